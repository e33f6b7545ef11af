// A picture or a table of numbers in a format that GDAL writes, in memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <gdal_priv.h>

namespace fjell::baker {

struct ImageNumbers {
    std::int32_t columns = 0, rows = 0;
    GDALDataType type = GDT_Byte;
    const void* numbers = nullptr; // row by row; the bands of a pixel side by side
    int bands = 1;
};
// options: of the driver, "NAME=VALUE". name: of what is written, for messages. Any thread. Throws Failure 3: GDAL has
// no such driver, or fails.
[[nodiscard]] std::vector<std::byte> encode_image(const char* driver, const ImageNumbers& image,
                                                  const std::vector<std::string>& options, const std::string& name);

} // namespace fjell::baker
