// Height fields of files, through GDAL (thesis 5.3.1).
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "baker/read/options.h"
#include "baker/read/source.h"

namespace fjell::baker {

// One file or a mosaic of several that share CRS and grid; where they overlap the later one is on top, where it has
// heights. GeoTIFF, PNG (8 and 16 bits), BMP, ASCII grid, HGT, USGS DEM, netCDF, VRT: whatever GDAL's raster drivers
// open, band 1, or red, green and blue with an encoding. Pixels are samples; the band's scale, offset and unit and the
// CRS' units are applied; row 0 becomes north, column 0 west. What is reprojected is interpolated (cubic; bilinear
// beside voids), a hole where the file does not cover, and the same bit for bit whatever is read in whatever order.
// Throws Failure, one line with the path and the remedy. 1: missing file, folder, not a raster, an image, fewer than
// 2x2 samples, rotated, degrees that no plane can hold, no georeference without a spacing, files that do not fit
// together, a bbox outside; reading throws it for truncated data, `properties` for implausible heights and voids. 2: an
// option out of range. O(files).
[[nodiscard]] std::unique_ptr<HeightSource> open_source(const std::vector<std::string>& paths,
                                                        const ReadOptions& options);

// What a source is reprojected from, for whoever only looks at it: reading its files takes a hundredth of the time.
struct Unwarped {
    std::unique_ptr<HeightSource> source; // the files' own grid
    // Of a sample of the reprojected grid, where it is in that one: column and row. False: nowhere.
    std::function<bool(double& column, double& row)> place;
};
// None: it is not reprojected. The source may go before the result. Throws Failure.
[[nodiscard]] std::optional<Unwarped> unwarped(const HeightSource& source);

} // namespace fjell::baker
