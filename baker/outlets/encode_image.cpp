#include "baker/outlets/encode_image.h"

#include <memory>

#include <cpl_string.h>
#include <cpl_vsi.h>
#include <fmt/format.h>

#include "baker/read/gdal_file.h"

namespace fjell::baker {

std::vector<std::byte> encode_image(const char* driver, const ImageNumbers& image,
                                    const std::vector<std::string>& options, const std::string& name) {
    const GdalMessages messages;
    register_drivers();
    GDALDriver* const memory = GetGDALDriverManager()->GetDriverByName("MEM");
    GDALDriver* const to = GetGDALDriverManager()->GetDriverByName(driver);
    if (!memory || !to)
        throw Failure(
            3, fmt::format("{}: this GDAL has no driver for {}; install one, or take another format", name, driver));
    GdalFile copy(memory->Create("", image.columns, image.rows, image.bands, image.type, nullptr));
    const std::string place = fmt::format("/vsimem/fjell-{}", static_cast<const void*>(&messages));
    const int number_bytes = GDALGetDataTypeSizeBytes(image.type);
    bool written =
        copy &&
        copy->RasterIO(GF_Write, 0, 0, image.columns, image.rows, const_cast<void*>(image.numbers), image.columns,
                       image.rows, image.type, image.bands, nullptr, GSpacing{image.bands} * number_bytes,
                       GSpacing{image.bands} * number_bytes * image.columns, number_bytes, nullptr) == CE_None;
    std::vector<char*> list; // as GDAL takes lists: ended by a null
    std::vector<std::string> kept = options;
    for (std::string& option : kept) list.push_back(option.data());
    list.push_back(nullptr);
    if (written) copy.reset(to->CreateCopy(place.c_str(), copy.get(), 0, list.data(), nullptr, nullptr));
    written = written && copy && !messages.failed();
    copy.reset();
    vsi_l_offset bytes = 0;
    GByte* const data = written ? VSIGetMemFileBuffer(place.c_str(), &bytes, 1) : nullptr;
    VSIUnlink((place + ".aux.xml").c_str());
    if (!data) throw Failure(3, fmt::format("{}: cannot be written{}", name, messages.said()));
    const std::unique_ptr<GByte, void (*)(GByte*)> owned(data, [](GByte* p) { CPLFree(p); });
    const auto* const first = reinterpret_cast<const std::byte*>(data);
    return {first, first + bytes};
}

} // namespace fjell::baker
