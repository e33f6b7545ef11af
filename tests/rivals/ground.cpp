#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "rivals/rival.h"
#include "shared/terrain_data.h"

namespace fjell::rivals {

Ground ground_of(const Terrain& terrain) {
    if (terrain.tile_count() != 1 || terrain.has_voids() || terrain.pages_missing() != 0 ||
        terrain.columns() != terrain.rows() || data_of(terrain).tree.cut_x != 0)
        throw std::invalid_argument("rivals take a square of one tile, whole and without holes");
    const TerrainData& data = data_of(terrain);
    Ground g;
    g.side = data.tree.side();
    g.spacing_x_m = terrain.spacing_x_m();
    g.spacing_z_m = terrain.spacing_z_m();
    g.min_m = terrain.header().min_m;
    g.max_m = terrain.header().max_m;
    const auto samples = static_cast<std::size_t>(g.side + 1) * static_cast<std::size_t>(g.side + 1);
    g.height_m.resize(samples);
    g.error_m.resize(samples);
    g.radius_m.resize(samples);
    constexpr float infinite = std::numeric_limits<float>::infinity();
    for (std::int32_t y = 0; y <= g.side; ++y)
        for (std::int32_t x = 0; x <= g.side; ++x) {
            const TerrainData::Vertex v = data.vertex({x, y});
            const std::uint32_t i = g.index({x, y});
            const bool corner = data.tree.is_corner({x, y});
            g.height_m[i] = v.height_m;
            g.error_m[i] = corner ? infinite : v.error_m;
            g.radius_m[i] = corner ? infinite : v.radius_m;
        }
    return g;
}

namespace {

// Calls visit(coordinate) for all vertices but the corners, leaves first.
template <typename Visit>
void leaves_first(std::int32_t side, const Visit& visit) {
    for (std::int32_t s = 1; s < side; s *= 2) {
        for (std::int32_t y = 0; y <= side; y += s) // sides: one coordinate is an odd multiple of the step
            for (std::int32_t x = (y / s) % 2 == 0 ? s : 0; x <= side; x += 2 * s) visit(SampleIndex{x, y});
        for (std::int32_t y = s; y < side; y += 2 * s)
            for (std::int32_t x = s; x < side; x += 2 * s) visit(SampleIndex{x, y});
    }
}

} // namespace

std::vector<GroundVertex> vertices_of(const Ground& ground) {
    std::vector<GroundVertex> all(ground.height_m.size());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = {ground.height_m[i], ground.error_m[i], ground.radius_m[i]};
    return all;
}

Ground with_wedgies(const Ground& ground) {
    Ground g = ground;
    const Tree tree = Tree::covering(g.side + 1, g.side + 1, std::countr_zero(static_cast<std::uint32_t>(g.side)));
    const auto height = [&](SampleIndex c) { return static_cast<double>(g.height_m[g.index(c)]); };
    leaves_first(g.side, [&](SampleIndex v) {
        const Diamond d = diamond(tree, v);
        double below = 0;
        const Children c = children(v);
        for (int i = 0; i < c.count; ++i)
            if (tree.contains(c.at[i])) below = std::max(below, static_cast<double>(g.error_m[g.index(c.at[i])]));
        const double moved = std::abs(height(v) - (height(d.ends[0]) + height(d.ends[1])) / 2);
        const auto wedgie = static_cast<float>(below + moved);
        // A parent above its child by a margin that survives rounding: what forced splits would be needed for
        // otherwise.
        g.error_m[g.index(v)] = std::nextafter(wedgie * (1 + 0x1p-16f), std::numeric_limits<float>::infinity());
    });
    return g;
}

} // namespace fjell::rivals
