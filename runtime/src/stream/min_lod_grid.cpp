#include <algorithm>

#include "fjell/stream.h"
#include "pack/terrain_data.h"

namespace fjell {

namespace {

// A place on a border belongs to two tiles and a corner to four. Each of them takes the largest over all its owners, so
// they agree there; between the nine places they interpolate the same two numbers along a border, in the same way.
// number(column, row): of a tile, or no_index where there is none.
template <typename Number>
void fill_grid(std::span<const TileMap> maps, std::int64_t column, std::int64_t row, std::uint32_t tile,
               const Number& number, float (&out)[9]) {
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) {
            float most = maps[tile].min_lod;
            for (std::int64_t j = std::max<std::int64_t>(row + std::min(y, 0), 0); j <= row + std::max(y, 0); ++j)
                for (std::int64_t i = std::max<std::int64_t>(column + std::min(x, 0), 0); i <= column + std::max(x, 0);
                     ++i)
                    if (const std::uint32_t of = number(i, j); of != no_index) most = std::max(most, maps[of].min_lod);
            out[3 * (y + 1) + x + 1] = most;
        }
}

} // namespace

Status min_lod_grid(std::span<const TileMap> maps, std::uint32_t tiles_x, std::uint32_t tile, float (&out)[9]) {
    if (tiles_x == 0 || maps.size() % tiles_x != 0) return {Code::out_of_range, "tiles_x"};
    if (tile >= maps.size()) return {Code::out_of_range, "tile"};
    const auto wide = static_cast<std::int64_t>(tiles_x), high = static_cast<std::int64_t>(maps.size()) / wide;
    fill_grid(
        maps, tile % tiles_x, tile / tiles_x, tile,
        [&](std::int64_t i, std::int64_t j) {
            return i < wide && j < high ? static_cast<std::uint32_t>(j * wide + i) : no_index;
        },
        out);
    return {};
}

Status min_lod_grid(std::span<const TileMap> maps, const Terrain& terrain, std::uint32_t tile, float (&out)[9]) {
    const TerrainData* const t = find(terrain);
    if (t == nullptr) return {Code::invalid_handle, "terrain"};
    if (maps.size() != t->tile_count()) return {Code::out_of_range, "maps"};
    if (tile >= maps.size()) return {Code::out_of_range, "tile"};
    const Coord place = t->tile_xy(tile);
    fill_grid(
        maps, place.x, place.y, tile,
        [&](std::int64_t i, std::int64_t j) {
            return i < t->tree.tiles_x && j < t->tree.tiles_y
                       ? t->tile_at(static_cast<std::int32_t>(i), static_cast<std::int32_t>(j))
                       : no_index;
        },
        out);
    return {};
}

} // namespace fjell
