// Numbers of a band to metres.
#pragma once

#include <string>

#include "baker/read/gdal_file.h"
#include "baker/read/options.h"

namespace fjell::baker {

// Nothing on Earth, Mars or Venus lies outside; undeclared voids (-32767, -99999, 1e38) do.
inline constexpr double lowest_m = -12000, highest_m = 30000;

// raw -> metres as in the file -> metres as asked.
struct Scaling {
    double file_scale = 1, file_offset_m = 0, zscale = 1, zoffset_m = 0;

    [[nodiscard]] double file_m(double raw) const { return raw * file_scale + file_offset_m; }
    [[nodiscard]] double asked_m(double metres) const { return metres * zscale + zoffset_m; }
    friend bool operator==(const Scaling&, const Scaling&) = default;
};

// Metres in one unit of this name; no name means metres, 0 that it is not known.
[[nodiscard]] double unit_in_metres(const char* name);

// What the band, or the vertical axis of the CRS where the band is silent, calls its unit; empty: neither says.
[[nodiscard]] std::string unit_name(GDALRasterBand& band, const OGRSpatialReference* crs);

// From the band's scale, offset and unit, the unit of the CRS' vertical axis where the band has none, and the options.
// Throws Failure 1: a unit not known here, two units that differ, an absurd scale.
[[nodiscard]] Scaling scaling_of(GDALRasterBand& band, const OGRSpatialReference* crs, const ReadOptions& options,
                                 const std::string& path);

} // namespace fjell::baker
