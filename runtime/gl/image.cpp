#include "fjell/gl/image.h"

#include <memory>
#include <span>

#include <stb_image.h>
#include <stb_image_write.h>

#include "gl/fail.h"
#include "io/file.h"

namespace fjell::gl {

void write_png(const Image& image, const std::string& path) {
    if (image.width == 0 || image.height == 0 || image.rgb.size() != std::size_t{3} * image.width * image.height)
        fail("cannot write '" + path + "': the picture is empty or its size and its pixels disagree");
    std::vector<std::uint8_t> png;
    const auto append = [](void* to, void* bytes, int count) {
        const auto* first = static_cast<const std::uint8_t*>(bytes);
        auto& out = *static_cast<std::vector<std::uint8_t>*>(to);
        out.insert(out.end(), first, first + count);
    };
    if (!stbi_write_png_to_func(append, &png, static_cast<int>(image.width), static_cast<int>(image.height), 3,
                                image.rgb.data(), static_cast<int>(image.width * 3)))
        fail("cannot write '" + path + "': the picture could not be compressed (out of memory)");
    io::AtomicFile file(path);
    file.write(std::as_bytes(std::span(png)));
    file.commit();
}

Image read_png(const std::string& path) {
    int width = 0, height = 0, channels = 0;
    const std::unique_ptr<stbi_uc, void (*)(void*)> pixels(stbi_load(path.c_str(), &width, &height, &channels, 3),
                                                           stbi_image_free);
    if (!pixels) fail("cannot read '" + path + "': " + stbi_failure_reason());
    Image image{static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height), {}};
    image.rgb.assign(pixels.get(), pixels.get() + std::size_t{3} * image.width * image.height);
    return image;
}

} // namespace fjell::gl
