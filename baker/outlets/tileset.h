// A pyramid of tiles as 3D Tiles 1.1: each tile a glTF, and one tileset.json with the tree of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "baker/outlets/globe.h"
#include "baker/outlets/gltf_mesh.h"
#include "baker/outlets/tile_mesh.h"

namespace fjell::baker {

struct GltfTile {
    std::vector<std::byte> bytes;
    double error_m = 0;           // of the mesh, and what rounding adds
    double low_m = 0, high_m = 0; // no place of its triangles is below or above, walls at its sides included
};
// y up; the place is float metres from tile_middle(), which the tileset has in double: (east, up, south) of glTF stand
// for x, z and -y of the globe, as 3D Tiles turns them. A wall hangs down from every side: least_error_m or the tile's
// own error, three times. normals: a unit vector for each vertex, or none. size_m: no tile of the level is larger along
// an axis; quantised, all of them round to one lattice, so that they meet as they did.
struct GltfTileRules {
    double least_error_m = 0, size_m = 0;
    GltfPacking packing;
};
[[nodiscard]] GltfTile encode_gltf_tile(const TileMesh& mesh, const GltfTileRules& rules,
                                        std::span<const GlobePlace> normals, std::vector<std::byte> texture_jpeg);
[[nodiscard]] GlobePlace tile_middle(const DegreeBox& box);

struct TilesetTile {
    TileId id;
    double error_m = 0, low_m = 0, high_m = 0;
};
// levels: of each level its tiles, from the coarsest on; a tile's parent is in the level before. Errors and heights of
// parents take in their children's. extras: JSON that says what holds.
[[nodiscard]] std::string tileset_json(Tiling tiling, const std::vector<std::vector<TilesetTile>>& levels,
                                       const std::string& extras);

} // namespace fjell::baker
