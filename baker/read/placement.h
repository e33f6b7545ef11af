// The georeference of a raster's samples.
#pragma once

#include <cstdint>
#include <string>

#include "baker/read/gdal_file.h"

namespace fjell::baker {

// metres: any linear unit. perhaps_degrees: nothing says so, but every place is a latitude and longitude.
enum class Axes : std::uint8_t { none, metres, degrees, perhaps_degrees };

// A grid with row 0 in the north and column 0 in the west, in the units of its CRS.
struct Placement {
    std::int32_t columns = 0, rows = 0;
    Axes axes = Axes::none;
    double step[2] = {1, 1};             // from sample to sample, > 0
    double origin[2] = {0, 0};           // of sample (0, 0): easting or longitude, northing or latitude
    double unit_m = 1;                   // metres in one unit of metre axes
    bool flip_x = false, flip_y = false; // how the file has them
    std::string crs_wkt;                 // empty: none that means anything elsewhere

    [[nodiscard]] double east(double column) const { return origin[0] + step[0] * column; }
    [[nodiscard]] double north(double row) const { return origin[1] - step[1] * row; }
};

// Throws Failure 1 for a grid that is rotated or sheared, or absurd.
[[nodiscard]] Placement place(GDALDataset& file, const std::string& path);

// What a spacing is in units of the CRS, where that counts metres, feet and so on; 0 in degrees and without a CRS.
void crs_step_of(const double (&spacing_m)[2], const std::string& crs_wkt, double (&step)[2]);

[[nodiscard]] std::string wkt_of(const OGRSpatialReference& crs);

} // namespace fjell::baker
