// An array of heights as a source, as files are.
#pragma once

#include <memory>
#include <string>

#include "baker/read/height_array.h"
#include "baker/read/options.h"
#include "baker/read/source.h"

namespace fjell::baker {

// Where an array lies.
struct ArrayPlace {
    double spacing_m[2] = {1, 1};  // from column to column, from row to row
    double crs_origin[2] = {0, 0}; // of sample (0, 0) in the CRS' units, east and north
    std::string crs;               // projected, as GDAL understands it; empty: none
};

// NaN and masked numbers are voids, as are those of options.voids; zscale, zoffset_m and nodata count too, and no
// other option. Throws Failure: 1 for fewer than 2 x 2 samples, 2 for a CRS that is none, or in degrees.
[[nodiscard]] std::unique_ptr<HeightSource> array_source(const HeightArray& array, const ArrayPlace& place,
                                                         const ReadOptions& options);

} // namespace fjell::baker
