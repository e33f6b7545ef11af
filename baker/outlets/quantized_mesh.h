// A tile as quantized-mesh 1.0, the terrain format of CesiumJS.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "baker/outlets/globe.h"
#include "baker/outlets/tile_mesh.h"

namespace fjell::baker {

struct EncodedTile {
    std::vector<std::byte> bytes;
    double low_m = 0, high_m = 0; // of its vertices
};
inline constexpr std::uint32_t water_mask_px = 256;
struct TileExtensions {
    std::span<const GlobePlace> normals; // octvertexnormals: a unit vector for each vertex; none: it is left out
    std::vector<std::byte> water{};      // watermask: 255 for water, a byte for all of the tile, or water_mask_px rows
                                         // of as many, from the north-west; none: it is left out
    std::string available{};             // metadata, which says the error too: of a root what tiles lie below it, JSON
                                         // as in layer.json from level 1 on; or nothing
};
// height_step_m: that heights are whole multiples of, a power of two. Throws Failure 1 when the heights of one tile
// span more steps than 15 bits hold.
[[nodiscard]] EncodedTile encode_quantized_mesh(const TileMesh& mesh, double height_step_m,
                                                const TileExtensions& extensions);

// RFC 1952, without a name and a time: equal bytes give equal files.
[[nodiscard]] std::vector<std::byte> gzip(std::span<const std::byte> bytes);

} // namespace fjell::baker
