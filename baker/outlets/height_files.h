// A height field as files of numbers for engines: 16 bits (.raw, .r16, .png), floats (.exr) or GeoTIFF (.tif), of every
// sample or of a step, whole or as tiles.
//
// A step of level L takes every 2^L-th sample, from the north-west on. Where the field ends inside a step or a tile,
// the rim's heights go on. Tiles have SIDE x SIDE numbers, and share a row or column with each neighbour; OUT.r16
// becomes OUT_x0_y0.r16, x to the east, y to the south. A file of 16 bits stands for heights offset_m + scale_m *
// number. OUT.json beside the files holds the summary. Only GeoTIFF keeps holes; elsewhere they are filled. O(samples);
// memory: 4 bytes a sample (9 while holes are filled), and a file. Each file is replaced whole, the summary last.
// Throws Failure: 1 the source, 2 an unknown ending or a side that is too small, 3 the disk, or a driver that GDAL
// lacks.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "baker/bake/bake.h"
#include "baker/read/source.h"

namespace fjell::baker {

struct HeightFilesOptions {
    int level = 0;
    std::int32_t tile_side = 0; // numbers; 0: one file
    int threads = 0;            // 0: all cores
    Progress progress{};
};

struct HeightFilesSummary {
    std::int32_t columns = 0, rows = 0;    // of a file
    std::int32_t tiles_x = 1, tiles_y = 1; // files
    double spacing_m[2] = {1, 1};          // between numbers
    double scale_m = 1, offset_m = 0;      // of 16 bits
    bool sixteen_bits = false;
    std::uint64_t holes_filled = 0;
    // The largest vertical distance of a sample from the surface through the file's heights, whichever diagonal cuts
    // its cells, and of the bilinear one. Rounding counts.
    double error_m = 0;
    std::vector<std::string> files; // the summary's last
};

// path: ends in .raw, .r16, .png, .exr, .tif or .tiff.
HeightFilesSummary write_height_files(const HeightSource& source, const HeightFilesOptions& options,
                                      const std::string& path);

// A picture of one band as GDAL's driver writes it. numbers: columns x rows, std::uint16_t or float.
void write_image(const std::string& path, const char* driver, std::int32_t columns, std::int32_t rows,
                 std::span<const std::uint16_t> numbers);
void write_image(const std::string& path, const char* driver, std::int32_t columns, std::int32_t rows,
                 std::span<const float> numbers);

} // namespace fjell::baker
