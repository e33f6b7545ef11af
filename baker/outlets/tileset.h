// A pyramid of tiles as 3D Tiles 1.1: each tile a glTF, and one tileset.json with the tree of them. implicit_tileset.h
// has the other way of saying the tree.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "baker/outlets/globe.h"
#include "baker/outlets/tile_mesh.h"
#include "gltf/mesh.h"

namespace fjell::baker {

struct GltfTile {
    std::vector<std::byte> bytes;
    double error_m = 0;           // of the mesh, and what rounding adds
    double low_m = 0, high_m = 0; // no place of its triangles is below or above, walls at its sides included
};
// y up; the place is float metres from tile_middle(), which the tileset or the glTF's node has in double: (east, up,
// south) of glTF stand for x, z and -y of the globe, as 3D Tiles turns them. A wall hangs down from every side:
// least_error_m or the tile's own error, three times. normals: a unit vector for each vertex, or none. size_m: no tile
// of the level is larger along an axis; quantised, all of them round to one lattice, so that they meet as they did.
struct GltfTileRules {
    double least_error_m = 0, size_m = 0;
    gltf::GlbPacking packing;
    bool placed = false; // the node has the place of the tile's middle; otherwise the tileset has
};
[[nodiscard]] GltfTile encode_gltf_tile(const TileMesh& mesh, const GltfTileRules& rules,
                                        std::span<const GlobePlace> normals, std::vector<std::byte> texture_jpeg);
[[nodiscard]] GlobePlace tile_middle(const DegreeBox& box);

struct TilesetTile {
    TileId id;
    double error_m = 0, low_m = 0, high_m = 0;
};
// Of each level its tiles, row by row, from the coarsest on; a tile's parent is in the level before.
using TilesetLevels = std::vector<std::vector<TilesetTile>>;
// Errors and heights of parents take in their children's.
[[nodiscard]] TilesetLevels with_children(TilesetLevels levels);
// The place of a tile in its level, or the number of tiles there.
[[nodiscard]] std::size_t find_tile(const std::vector<TilesetTile>& level, TileId id);
// A tileset of these tiles and what lies below them. extras: JSON that says what holds.
[[nodiscard]] nlohmann::ordered_json tileset_of(Tiling tiling, const std::vector<TilesetTile>& roots,
                                                nlohmann::ordered_json children, const std::string& extras);
[[nodiscard]] nlohmann::ordered_json region_json(const DegreeBox& box, double low_m, double high_m);
// The same with every tile in it, as text.
[[nodiscard]] std::string tileset_json(Tiling tiling, TilesetLevels levels, const std::string& extras);

} // namespace fjell::baker
