// Read a height field through GDAL (thesis 5.3.1), or make one from a recipe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "baker/dem.h"

namespace fjell::baker {

enum class NoData : std::uint8_t { refuse, fill };

struct ReadOptions {
    std::optional<double> spacing_m; // overrides the file's; required when the file's axes are degrees or it has none
    double zscale = 1;               // multiplies heights after the band's own scale and offset
    double zoffset_m = 0;            // added after zscale
    NoData nodata = NoData::refuse;
    std::size_t memory_bytes = std::size_t{8} << 30; // refuse DEMs whose bake needs more
};

// GeoTIFF, PNG (8 and 16 bits), BMP, ASCII grid, HGT, USGS DEM, netCDF: whatever GDAL's raster drivers open, band 1.
// Throws Failure: missing file, directory, not a raster, truncated data, fewer than 2x2 samples, NaN or infinite heights
// or all no-data, heights or spacing out of range, degrees without a spacing.
[[nodiscard]] Dem read_dem(const std::string& path, const ReadOptions& options);

// Deterministic mountains of any size from a recipe (JSON, content/terrain/*.json; fields in content/README.md): same
// recipe, same bytes, on every machine and any number of threads (0: all cores). Throws Failure on a recipe that is not
// one.
[[nodiscard]] Dem synthesise(const std::string& recipe_path, int threads = 0);
[[nodiscard]] Dem synthesise_text(const std::string& recipe_json, int threads = 0);

// Writes a DEM as a GeoTIFF (UInt16 with scale and offset when native_quantum_m allows it, else Float32), beside its
// place, then renamed. Throws Failure.
void write_dem(const Dem& dem, const std::string& path);

} // namespace fjell::baker
