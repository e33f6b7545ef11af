// Colour and normal maps, cut into tiles with mips (thesis 6.1: an image, or a ramp over height).
//
// Mip m of a map with N = 2^log2 texels a side has N >> m; the smallest has 4. Texel centres of the first and last
// column and row of *every* mip lie on the tile's border, and each texel is computed from the whole terrain alone -
// never from the tile - so both neighbours store equal values there and no seam shows under clamp-to-edge.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "baker/dem.h"
#include "fjell/tree.h"

namespace fjell::baker {

// An image stretched over the DEM: its outer edge on the outermost samples. 8-bit RGB.
struct Image {
    std::int32_t width = 0, height = 0;
    std::vector<std::uint8_t> rgb;
};
// Through GDAL: 1 or 2 bands (grey or palette), 3 or 4 bands (red, green, blue), 8 bits or 16 scaled down; alpha is
// ignored. Throws Failure.
[[nodiscard]] Image read_image(const std::string& path);

// height_m -> sRGB, linear between stops. JSON: {"stops": [{"height_m": 0, "rgb": [r, g, b]}, ...]} or, with
// "relative": true, heights as 0..1 of the DEM's range. Throws Failure.
struct Ramp {
    struct Stop {
        double height_m;
        double rgb[3]; // 0..255
    };
    std::vector<Stop> stops;
    bool relative = false;
};
[[nodiscard]] Ramp read_ramp(const std::string& path);
// The ramp with its heights in metres for this DEM; one that has them already comes back as it is. O(samples): call it
// once, or colour_mip does for every relative ramp it is given.
[[nodiscard]] Ramp absolute(const Ramp& ramp, const Dem& dem);

struct MapBuilder {
    const Dem& dem; // columns == tree.columns(), rows == tree.rows(); texels beyond take the nearest
    Tree tree;
    std::uint32_t colour_log2 = 0, normal_log2 = 0;
};

// Every texel is a tent over the source, as wide as its mip's texels are apart (never narrower than the source's own),
// colours in linear light. A mip costs O(source pixels under the tile). Thread-safe.

// One mip of one tile, RGB (sRGB). Exactly one of image and ramp is given; a ramp colours the filtered heights.
[[nodiscard]] std::vector<std::uint8_t> colour_mip(const MapBuilder& maps, const Image* image, const Ramp* ramp,
                                                   std::uint32_t tile, std::uint32_t mip);
// One mip of one tile, two signed-normalised bytes a texel: east and south components of the unit normal, filtered from
// the full-resolution heights' normals (central differences, one-sided on the rim).
[[nodiscard]] std::vector<std::uint8_t> normal_mip(const MapBuilder& maps, std::uint32_t tile, std::uint32_t mip);

// log2 texels a side that keep the image's (or, for ramp and normals, the DEM's) detail: at most max_log2.
[[nodiscard]] std::uint32_t fitting_log2(double texels_per_tile, std::uint32_t max_log2);

} // namespace fjell::baker
