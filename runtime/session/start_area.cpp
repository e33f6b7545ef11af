#include "session/start_area.h"

#include <algorithm>
#include <optional>
#include <vector>

namespace fjell::session {

namespace {

constexpr std::size_t most_tiles = 256;
constexpr int places_a_side = 32; // cells of a tile's grid of places, a side

// What encloses all that was added.
class Enclosed {
public:
    void add(double x_m, double z_m) {
        west_ = any_ ? std::min(west_, x_m) : x_m, east_ = any_ ? std::max(east_, x_m) : x_m;
        north_ = any_ ? std::min(north_, z_m) : z_m, south_ = any_ ? std::max(south_, z_m) : z_m;
        any_ = true;
    }
    [[nodiscard]] bool any() const { return any_; }
    // At least as wide as this, and not beyond the extents.
    [[nodiscard]] Area area(double least_m, double extent_x_m, double extent_z_m) const {
        const auto span = [&](double from, double to, double extent) {
            const double more = std::max(least_m - (to - from), 0.0) / 2;
            return std::pair(std::max(from - more, 0.0), std::min(to + more, extent));
        };
        const auto [west, east] = span(west_, east_, extent_x_m);
        const auto [north, south] = span(north_, south_, extent_z_m);
        return {west, north, east - west, south - north};
    }

private:
    double west_ = 0, east_ = 0, north_ = 0, south_ = 0;
    bool any_ = false;
};

struct Tiling {
    explicit Tiling(const Terrain& terrain)
        : h(terrain.header()), side(1 << h.tile_log2), extent_x_m((h.columns - 1) * h.spacing_m[0]),
          extent_z_m((h.rows - 1) * h.spacing_m[1]) {}
    [[nodiscard]] double x_m(double column) const { return std::min(column * h.spacing_m[0], extent_x_m); }
    [[nodiscard]] double z_m(double row) const { return std::min(row * h.spacing_m[1], extent_z_m); }

    const PackHeader& h;
    const std::int32_t side;
    const double extent_x_m, extent_z_m;
};

// Returns whether the tile has ground.
bool add_ground(const Tiling& tiling, SampleIndex tile, const std::function<bool(double, double)>& has_ground,
                Enclosed& to) {
    bool any = false;
    const double step = static_cast<double>(tiling.side) / places_a_side;
    for (int j = 0; j <= places_a_side; ++j)
        for (int i = 0; i <= places_a_side; ++i) {
            const double x_m = tiling.x_m(tile.column * static_cast<double>(tiling.side) + i * step),
                         z_m = tiling.z_m(tile.row * static_cast<double>(tiling.side) + j * step);
            if (!has_ground(x_m, z_m)) continue;
            any = true;
            to.add(x_m, z_m);
        }
    return any;
}

} // namespace

Area start_area(const Terrain& terrain, const std::function<bool(double, double)>& has_ground) {
    const Tiling tiling(terrain);
    if (tiling.h.tiles_held == 0) return {0, 0, tiling.extent_x_m, tiling.extent_z_m};
    std::vector<SampleIndex> tiles;
    for (std::uint32_t tile = 0; tile < terrain.tile_count(); ++tile) tiles.push_back(terrain.tile_place(tile));
    const auto off_middle = [&](SampleIndex tile) {
        const double x = (2.0 * tile.column + 1 - tiling.h.tiles_x) * tiling.h.spacing_m[0],
                     z = (2.0 * tile.row + 1 - tiling.h.tiles_y) * tiling.h.spacing_m[1];
        return x * x + z * z;
    };
    std::stable_sort(tiles.begin(), tiles.end(),
                     [&](SampleIndex a, SampleIndex b) { return off_middle(a) < off_middle(b); });
    Enclosed ground;
    std::vector<SampleIndex> found;
    for (const SampleIndex tile : tiles)
        if (add_ground(tiling, tile, has_ground, ground)) {
            found.push_back(tile);
            break;
        }
    if (!ground.any()) return area_of_tiles(terrain);
    std::vector<SampleIndex> seen = found;
    for (std::size_t at = 0; at < found.size(); ++at)
        for (std::int32_t dy = -1; dy <= 1; ++dy)
            for (std::int32_t dx = -1; dx <= 1; ++dx) {
                const SampleIndex next{found[at].column + dx, found[at].row + dy};
                if (seen.size() > most_tiles || terrain.tile_at(next) == no_tile ||
                    std::find(seen.begin(), seen.end(), next) != seen.end())
                    continue;
                seen.push_back(next);
                if (add_ground(tiling, next, has_ground, ground)) found.push_back(next);
            }
    const double least_m = 2.0 * tiling.side / places_a_side * std::max(tiling.h.spacing_m[0], tiling.h.spacing_m[1]);
    return ground.area(least_m, tiling.extent_x_m, tiling.extent_z_m);
}

Area area_of_tiles(const Terrain& terrain) {
    const Tiling tiling(terrain);
    if (tiling.h.tiles_held == 0) return {0, 0, tiling.extent_x_m, tiling.extent_z_m};
    Enclosed tiles;
    for (std::uint32_t tile = 0; tile < terrain.tile_count(); ++tile) {
        const SampleIndex at = terrain.tile_place(tile);
        const double side = tiling.side;
        tiles.add(tiling.x_m(at.column * side), tiling.z_m(at.row * side));
        tiles.add(tiling.x_m((at.column + 1) * side), tiling.z_m((at.row + 1) * side));
    }
    return tiles.area(0, tiling.extent_x_m, tiling.extent_z_m);
}

} // namespace fjell::session
