// Read a height field through GDAL (thesis 5.3.1), or make one from a recipe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "baker/dem.h"

namespace fjell::baker {

// Voids are samples that the file marks as no-data (tag or mask) or that are NaN. Odd ones are infinite, or outside
// -12000..30000 m both as the file has them and after zscale: undeclared voids (-32767 and the like), or another unit.
// automatic: voids become holes (Dem::voids); odd ones, which only the user can tell apart, are refused. hole: both
// become holes. fill: both become ground, a smooth continuation of what surrounds them, on the source's own step
// (fill.h). refuse: a Failure that counts them.
enum class NoData : std::uint8_t { automatic, hole, fill, refuse };

struct ReadOptions {
    std::optional<double> spacing_m; // overrides the file's; required when the file's axes are degrees or it has none
    double zscale = 1;               // multiplies heights after the band's own scale and offset
    double zoffset_m = 0;            // added after zscale
    NoData nodata = NoData::automatic;
    std::size_t memory_bytes = std::size_t{8} << 30; // refuse DEMs whose bake needs more
};

// GeoTIFF, PNG (8 and 16 bits), BMP, ASCII grid, HGT, USGS DEM, netCDF: whatever GDAL's raster drivers open, band 1.
// Pixels are samples; the band's scale, offset and unit and the CRS' unit are applied; row 0 becomes north, column 0
// west. Throws Failure, one line with the path and the remedy. 1: missing file, folder, not a raster, an image,
// truncated data, fewer than 2x2 samples, rotated, odd heights or voids (above) or nothing else, degrees or no
// georeference without a spacing, a spacing out of range. 2: an option out of range. 3: more samples than memory_bytes
// allows. O(samples), one thread; 4 bytes a sample, 5 with holes, and 1.4 and 8 a void more while voids are filled.
[[nodiscard]] Dem read_dem(const std::string& path, const ReadOptions& options);

// Deterministic mountains of any size from a recipe (JSON, content/terrain/*.json; fields in content/README.md): same
// recipe, same bytes, on every machine and any number of threads (0: all cores). Throws Failure on a recipe that is not
// one.
[[nodiscard]] Dem synthesise(const std::string& recipe_path, int threads = 0);
[[nodiscard]] Dem synthesise_text(const std::string& recipe_json, int threads = 0);

// Writes a DEM as a GeoTIFF (UInt16 with scale and offset when native_quantum_m allows it, else Float32), beside its
// place, then renamed. Holes are written as the ground that continues over them. Throws Failure.
void write_dem(const Dem& dem, const std::string& path);

} // namespace fjell::baker
