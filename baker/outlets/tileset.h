// A pyramid of tiles as 3D Tiles 1.1: each tile a glTF, and one tileset.json with the tree of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "baker/outlets/globe.h"
#include "baker/outlets/tile_mesh.h"

namespace fjell::baker {

struct GltfTile {
    std::vector<std::byte> bytes;
    double low_m = 0, high_m = 0; // no place of its triangles is below or above, walls at its sides included
};
// y up; the place is float metres from tile_middle(), which the tileset has in double: (east, up, south) of glTF stand
// for x, z and -y of the globe, as 3D Tiles turns them. A wall of skirt_m hangs down from every side. normals: a unit
// vector for each vertex, or none.
[[nodiscard]] GltfTile encode_gltf_tile(const TileMesh& mesh, double skirt_m, std::span<const GlobePlace> normals);
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
