// Pictures as files: 8-bit RGB PNG.
//
// Thread: any. Failure: io::Failure. A write that fails leaves no file behind, and an older file of that name stays as
// it was.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "fjell/export.h"
#include "fjell/io/failure.h"

FJELL_API_BEGIN
namespace fjell::gl {

// A picture in memory.
struct Image {
    std::uint32_t width = 0, height = 0;
    std::vector<std::uint8_t> rgb; // width * height * 3, top row first, sRGB

    [[nodiscard]] const std::uint8_t* pixel(std::uint32_t x, std::uint32_t y) const {
        return rgb.data() + (std::size_t{y} * width + x) * 3;
    }
};

// Writes a new file beside the place and renames it, so a reader never sees half a picture.
void write_png(const Image& image, const std::string& path);
// Reads any 8-bit PNG, converted to RGB.
[[nodiscard]] Image read_png(const std::string& path);

} // namespace fjell::gl
FJELL_API_END
