// Read a height field through GDAL (thesis 5.3.1), or make one from a recipe.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "baker/read/dem.h"
#include "baker/read/source.h"

namespace fjell::baker {

// Voids are samples that the file marks as no-data (tag or mask) or that are NaN. Odd ones are infinite, or outside
// -12000..30000 m both as the file has them and after zscale: undeclared voids (-32767 and the like), or another unit.
// automatic: voids become holes (Dem::voids); odd ones, which only the user can tell apart, are refused. hole: both
// become holes. fill: both become ground, a smooth continuation of what surrounds them, on the source's own step
// (fill.h). refuse: a Failure that counts them.
enum class NoData : std::uint8_t { automatic, hole, fill, refuse };

// Heights packed into the red, green and blue of a picture; no height where alpha is 0.
// terrarium: R * 256 + G + B / 256 - 32768. terrain_rgb (Mapbox): -10000 + (R * 65536 + G * 256 + B) * 0.1.
enum class Encoding : std::uint8_t { none, terrarium, terrain_rgb };

struct ReadOptions {
    // Overrides the file's; settles what to do with degrees (they count as a square grid) or without a georeference.
    // With a crs that is named, the spacing to reproject to.
    std::optional<double> spacing_m;
    // automatic ("auto"): what is in degrees is reprojected to metres (projection.h), the rest stays as it is. "none":
    // nothing is reprojected. Else a projected CRS as GDAL understands it ("EPSG:25832", WKT, PROJ) to reproject to.
    std::string crs = "auto";
    Encoding encoding = Encoding::none;
    // West, south, east, north: only samples inside. In the units of the CRS after reprojection; columns and rows,
    // counted from the north-west, when there is no georeference.
    std::optional<std::array<double, 4>> bbox;
    double zscale = 1;    // multiplies heights after the band's own scale and offset
    double zoffset_m = 0; // added after zscale
    NoData nodata = NoData::automatic;
    std::size_t memory_bytes = std::size_t{8} << 30; // read_dem refuses larger height fields
};

// One file or a mosaic of several that share CRS and lattice; where they overlap the later one is on top, where it has
// heights. GeoTIFF, PNG (8 and 16 bits), BMP, ASCII grid, HGT, USGS DEM, netCDF, VRT: whatever GDAL's raster drivers
// open, band 1, or red, green and blue with an encoding. Pixels are samples; the band's scale, offset and unit and the
// CRS' units are applied; row 0 becomes north, column 0 west. What is reprojected is interpolated (cubic; bilinear
// beside voids), a hole where the file does not cover, and the same bit for bit whatever is read in whatever order.
// Throws Failure, one line with the path and the remedy. 1: missing file, folder, not a raster, an image, fewer than
// 2x2 samples, rotated, degrees that no plane can hold, no georeference without a spacing, files that do not fit
// together, a bbox outside; reading throws it for truncated data, settling for odd heights and voids. 2: an option out
// of range. O(files).
[[nodiscard]] std::unique_ptr<HeightSource> open_source(const std::vector<std::string>& paths,
                                                        const ReadOptions& options);

// GDAL keeps decoded blocks of all open files in at most this many bytes (default: 5% of the machine's memory).
void limit_gdal_cache(std::size_t bytes);

// The whole of a source in memory. Throws Failure as reading and settling do; name: for messages.
[[nodiscard]] Dem read_dem(const HeightSource& source, const std::string& name);
// Throws Failure as open_source does, and 3: more samples than memory_bytes allows.
// O(samples), one thread; 4 bytes a sample, 5 with holes, and 1.4 and 8 a void more while voids are filled.
[[nodiscard]] Dem read_dem(const std::vector<std::string>& paths, const ReadOptions& options);
[[nodiscard]] Dem read_dem(const std::string& path, const ReadOptions& options);

// Deterministic mountains of any size from a recipe (JSON, content/terrain/*.json; fields in content/README.md): same
// recipe, same bytes, on every machine and any number of threads (0: all cores). Throws Failure on a recipe that is not
// one.
[[nodiscard]] Dem synthesise(const std::string& recipe_path, int threads = 0);
[[nodiscard]] Dem synthesise_text(const std::string& recipe_json, int threads = 0);

} // namespace fjell::baker
