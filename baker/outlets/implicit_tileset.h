// The tree of a tileset as 3D Tiles 1.1 writes it implicitly: a few roots in tileset.json, and below each the tiles
// that there are as bits in .subtree files, with their errors and heights in tables.
//
// A client derives the places of tiles: a rectangle of degrees is cut into four equal ones, so the tiling must be the
// geographic one. It may also derive errors: half of the parent's. A root's geometricError is so large that halving
// never goes below what a tile's mesh keeps; the tables have each tile's own (TILE_GEOMETRIC_ERROR), and its heights.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>

#include "baker/outlets/tileset.h"

namespace fjell::baker {

// Relative to the tileset: of a tile's content, or of the subtree that begins with it. first_level: of the roots.
[[nodiscard]] std::string implicit_path(TileId id, std::int32_t first_level, const char* ending);

// Gives each file's path and bytes: the subtrees, and tileset.json last.
using TakeFile = std::function<void(const std::string& path, std::span<const std::byte> bytes)>;
void write_implicit_tileset(TilesetLevels levels, const std::string& extras, const TakeFile& take);

} // namespace fjell::baker
