#include "query/ground.h"

#include <cmath>
#include <cstdint>

#include "fjell/query.h"

namespace fjell {

using namespace query;

namespace {

// Into [0, last]; NaN too.
double onto(double value, double last) {
    return value > 0 ? std::min(value, last) : 0;
}

} // namespace

GroundHeight ground_height(const Terrain& handle, double x_m, double z_m, float accurate_m) {
    const TerrainData* const data = find(handle);
    if (data == nullptr) return {};
    const TerrainData& terrain = *data;
    const double column = x_m / terrain.header.spacing_m[0], row = z_m / terrain.header.spacing_m[1];
    const Point p{onto(column, terrain.tree.columns() - 1), onto(row, terrain.tree.rows() - 1)};
    const Coord tile = tile_of(terrain, p);
    Reader reader(terrain, tile.x, tile.y);
    const Found found = find_ground(terrain, reader, p, accurate_code(terrain, accurate_m));
    GroundHeight out;
    out.inside = p.x == column && p.y == row;
    out.hole = found.hole;
    out.finest = found.finest;
    out.height_m = query::height_m(terrain, found.plane.height(p));
    out.normal = normal_of(terrain, found.plane);
    out.error_m = reported_m(terrain, found.error_m);
    return out;
}

namespace {

// One row of a patch: reads of neighbouring samples mostly stay in one page of each step.
struct PatchRow {
    const TerrainData& t;
    double worst_m = 0;
    bool finest = true;

    void sample(Reader& reader, Coord v, float& height, bool& hole) {
        if (const Sample s = reader.read(v); s.loaded) {
            height = t.height_scale.height_m(s.steps);
            hole = s.hole;
            return;
        }
        const Point p{static_cast<double>(v.x), static_cast<double>(v.y)};
        const Found found = find_ground(t, reader, p, any_error);
        height = static_cast<float>(query::height_m(t, found.plane.height(p)));
        hole = found.hole;
        worst_m = std::max(worst_m, found.error_m);
        finest = finest && found.error_m == 0;
    }
};

std::int32_t place(std::int32_t first, std::uint32_t i, int step_log2, std::int32_t last) {
    const std::int64_t at = first + (static_cast<std::int64_t>(i) << step_log2);
    return static_cast<std::int32_t>(std::clamp<std::int64_t>(at, 0, last));
}

} // namespace

GroundPatch ground_patch(const Terrain& handle, Coord first, int step_log2, std::uint32_t side,
                         std::span<float> heights_m, std::span<bool> holes) {
    const std::size_t count = std::size_t{side} * side;
    if (side < 2 || side > max_patch_side || step_log2 < 0 || step_log2 > max_tile_log2 || heights_m.size() < count ||
        (!holes.empty() && holes.size() < count))
        return {INFINITY, false};
    const TerrainData* const data = find(handle);
    if (data == nullptr) return {INFINITY, false};
    const TerrainData& terrain = *data;
    const Tree& tree = terrain.tree;
    PatchRow row{terrain};
    for (std::uint32_t j = 0; j < side; ++j) {
        const std::int32_t y = place(first.y, j, step_log2, tree.rows() - 1);
        for (std::uint32_t i = 0; i < side;) {
            // As far as this tile goes.
            const Coord v{place(first.x, i, step_log2, tree.columns() - 1), y};
            const Coord tile = tile_of(terrain, {static_cast<double>(v.x), static_cast<double>(v.y)});
            Reader reader(terrain, tile.x, tile.y);
            const std::int32_t end = tile.x == tree.tiles_x - 1 ? tree.columns() : (tile.x + 1) * tree.side();
            for (; i < side; ++i) {
                const Coord at{place(first.x, i, step_log2, tree.columns() - 1), y};
                if (at.x >= end) break;
                const std::size_t to = std::size_t{j} * side + i;
                bool hole = false;
                row.sample(reader, at, heights_m[to], hole);
                if (!holes.empty()) holes[to] = hole;
            }
        }
    }
    return {reported_m(terrain, row.worst_m), row.finest};
}

} // namespace fjell
