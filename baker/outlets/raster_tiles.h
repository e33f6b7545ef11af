// Tiles of heights as pictures: Terrain-RGB and Terrarium in Web Mercator, as MapLibre and others read them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "baker/outlets/globe.h"
#include "baker/outlets/surface.h"

namespace fjell::baker {

// Of a colour (r, g, b) the height in metres is
enum class HeightColours : std::uint8_t {
    terrain_rgb, // -10000 + (r * 65536 + g * 256 + b) / 10
    terrarium,   // r * 256 + g + b / 256 - 32768
};

struct RasterTile {
    std::vector<std::byte> image; // PNG or WebP; rows from the north, without loss
    double error_m = 0;           // no sample in the tile is farther above or below what its pixels say
    double low_m = 0, high_m = 0;
};
struct RasterRules {
    HeightColours colours = HeightColours::terrain_rgb;
    bool webp = false; // a third smaller than PNG, and slower to write; through GDAL
    int side_px = 512;
    int finest_level = 0; // samples are visited in tiles of this level, so that memory does not follow the tile's size
};
// A pixel is the ground's height at its middle. The error is measured at every sample, rounding included, for all that
// viewers do between the middles of four pixels: bilinear, and two triangles either way. At the sides it
// holds with the pixels of neighbours and without them. Throws Failure 1: heights that the colours cannot say; 3: GDAL
// writes no WebP.
[[nodiscard]] RasterTile make_raster_tile(const GroundSurface& surface, const SampleFinder& finder, TileId id,
                                          const RasterRules& rules);

} // namespace fjell::baker
