#include <algorithm>

#include "fjell/stream.h"

namespace fjell {

// A place on a border belongs to two tiles and a corner to four. Each of them takes the largest over all its owners, so
// they agree there; between the nine places they interpolate the same two numbers along a border, in the same way.
Status min_lod_grid(std::span<const TileMap> maps, std::uint32_t tiles_x, std::uint32_t tile, float (&out)[9]) {
    if (tiles_x == 0 || maps.size() % tiles_x != 0) return {Code::out_of_range, "tiles_x"};
    if (tile >= maps.size()) return {Code::out_of_range, "tile"};
    const auto wide = static_cast<std::int64_t>(tiles_x), high = static_cast<std::int64_t>(maps.size()) / wide;
    const std::int64_t column = tile % tiles_x, row = tile / tiles_x;
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) {
            float most = maps[tile].min_lod;
            for (std::int64_t j = std::max<std::int64_t>(row + std::min(y, 0), 0); j <= row + std::max(y, 0); ++j)
                for (std::int64_t i = std::max<std::int64_t>(column + std::min(x, 0), 0); i <= column + std::max(x, 0);
                     ++i)
                    if (i < wide && j < high)
                        most = std::max(most, maps[static_cast<std::size_t>(j * wide + i)].min_lod);
            out[3 * (y + 1) + x + 1] = most;
        }
    return {};
}

} // namespace fjell
