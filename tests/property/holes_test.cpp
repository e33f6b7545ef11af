// Holes: what is left out is exactly what has a corner in one, and their rims keep the screen bound.
#include <catch2/catch.hpp>

#include <cmath>

#include "fjell/measure.h"
#include "shared/terrain_data.h"
#include "support/cut_scene.h"
#include "support/mesh_check.h"
#include "support/rounds.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::test;

namespace {

io::LoadedPack random_holed_terrain(Random& random, bool large) {
    const int log2 = large ? pick(random, 6, 9) : pick(random, 1, 7);
    const std::int32_t columns = pick(random, 2, large ? 1000 : 120), rows = pick(random, 2, large ? 700 : 90);
    baker::Dem dem =
        random_dem(random, columns, rows, static_cast<Shape>(pick(random, 0, static_cast<int>(Shape::count) - 1)));
    add_random_holes(random, dem, log2);
    baker::BakeOptions options = small_bake(log2);
    options.order = static_cast<PageOrder>(pick(random, 0, 2));
    options.estimate = pick(random, 0, 3) ? ErrorEstimate::max : ErrorEstimate::midpoint;
    return bake_and_load(std::move(dem), options);
}

// Every sample in the closed triangle.
std::vector<SampleIndex> samples_under(const Triangle& t) {
    const auto turn = [](SampleIndex a, SampleIndex b, SampleIndex p) {
        return std::int64_t{b.column - a.column} * (p.row - a.row) -
               std::int64_t{b.row - a.row} * (p.column - a.column);
    };
    const std::int64_t sign = turn(t[0], t[1], t[2]) < 0 ? -1 : 1;
    const auto [x0, x1] = std::minmax({t[0].column, t[1].column, t[2].column});
    const auto [y0, y1] = std::minmax({t[0].row, t[1].row, t[2].row});
    std::vector<SampleIndex> samples;
    for (std::int32_t y = y0; y <= y1; ++y)
        for (std::int32_t x = x0; x <= x1; ++x) {
            const SampleIndex p{x, y};
            if (turn(t[0], t[1], p) * sign >= 0 && turn(t[1], t[2], p) * sign >= 0 && turn(t[2], t[0], p) * sign >= 0)
                samples.push_back(p);
        }
    return samples;
}

Vec3 position(const Terrain& t, SampleIndex c) {
    return {t.x_m(c.column), data_of(t).height_m(c), t.z_m(c.row)};
}

// How far a rim may be drawn from its place, in pixels: the size of the largest triangle that has both ground and hole
// under it, drawn or not. Triangles of the full resolution are drawn right by definition.
double rim_px(const Terrain& terrain, const std::vector<Triangle>& whole, const View& view) {
    double worst = 0;
    for (const Triangle& t : whole) {
        const std::vector<SampleIndex> samples = samples_under(t);
        if (samples.size() == 3) continue;
        std::size_t holes = 0;
        for (const SampleIndex c : samples) holes += data_of(terrain).is_hole(c);
        if (holes == 0 || holes == samples.size()) continue;
        double size = 0;
        for (std::size_t i = 0; i < 3; ++i)
            size = std::max(size, length(position(terrain, t[i]) - position(terrain, t[(i + 1) % 3])));
        for (const SampleIndex c : samples)
            worst = std::max(worst, size * focal_length_px(view) / length(position(terrain, c) - view.eye_m));
    }
    return worst;
}

} // namespace

TEST_CASE("a mesh with holes is the whole one less the triangles with a corner in a hole, and rims keep the bound") {
    Random random(41);
    std::size_t dropped = 0, kept = 0;
    for (int round = 0; round < rounds(60, 200); ++round) {
        const bool large = round % 40 == 39;
        const auto pack = random_holed_terrain(random, large);
        const Terrain& terrain = pack.terrain;
        const WithoutHoles without_holes(terrain);
        const Terrain& whole_terrain = without_holes.terrain();
        Recursive method(terrain, ample_budget(terrain)), strips(terrain, ample_budget(terrain)),
            whole(whole_terrain, ample_budget(terrain));
        for (int frame = 0; frame < (large ? 2 : 4); ++frame) {
            const View view = random_view(random, terrain);
            RefineSettings settings;
            settings.max_error_px = random_threshold(random) * (large ? 10 : 1);
            settings.cull = frame % 2 == 1;
            const FrameReport report = method.update(view, settings);
            (void)whole.update(view, settings);
            CAPTURE(round, frame, settings.max_error_px, data_of(terrain).tree.columns(), data_of(terrain).tree.rows(),
                    data_of(terrain).tree.tile_log2);
            REQUIRE(check_mesh(whole_terrain, whole.mesh()) == "");
            std::vector<Triangle> expected = triangles_of(whole.mesh());
            if (!settings.cull) REQUIRE(rim_px(terrain, expected, view) <= settings.max_error_px);
            const std::size_t all = expected.size();
            std::erase_if(expected, [&](const Triangle& t) {
                return data_of(terrain).is_hole(t[0]) || data_of(terrain).is_hole(t[1]) ||
                       data_of(terrain).is_hole(t[2]);
            });
            dropped += all - expected.size();
            kept += expected.size();
            REQUIRE(triangles_of(method.mesh()) == expected);
            REQUIRE(report.triangles == expected.size());
            if (terrain.header().estimate == ErrorEstimate::max) {
                const Frustum frustum = make_frustum(view);
                const MeasuredError error =
                    measure_error(terrain, method.mesh(), view, settings.cull ? &frustum : nullptr);
                REQUIRE(error.max_px <= settings.max_error_px * (1 + 1e-9));
            }
            settings.topology = Topology::strip;
            REQUIRE(strips.update(view, settings).triangles == expected.size());
            REQUIRE(triangles_of(strips.mesh()) == expected);
            for (const TileRange& range : strips.mesh().tiles)
                for (std::uint32_t i = 0; i < range.index_count; ++i)
                    REQUIRE(strips.mesh().indices[range.first_index + i] < strips.mesh().vertices.size());
        }
    }
    REQUIRE(dropped > rounds<std::size_t>(2'000, 10'000));
    REQUIRE(kept > rounds<std::size_t>(2'000, 10'000));
}

TEST_CASE("a terrain that is all hole but one sample draws nothing, and one cell draws two triangles") {
    Random random(42);
    for (const int side : {1, 2}) {
        baker::Dem dem = random_dem(random, 40, 30, Shape::fractal);
        dem.voids.assign(dem.heights_m.size(), 1);
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) dem.voids[dem.index(17 + x, 12 + y)] = 0;
        const auto pack = bake_and_load(std::move(dem), small_bake(4));
        Recursive method(pack.terrain, ample_budget(pack.terrain));
        View view = make_view({}, {0, -1, 0.1}, {0, 1, 0}, 1, 800, 600, 0.001, 1e6);
        view.eye_m = position(pack.terrain, {17, 12}) + Vec3{0, 0.1 * pack.terrain.spacing_x_m(), 0};
        RefineSettings settings;
        settings.cull = false;
        REQUIRE(method.update(view, settings).triangles == (side == 1 ? 0 : 2));
    }
}

TEST_CASE("ground without holes costs nothing: the flag of a hole changes no error but on its rim") {
    Random random(43);
    baker::Dem dem = random_dem(random, 129, 129, Shape::fractal);
    const auto solid = bake_and_load(dem, small_bake(6));
    dem.voids.assign(dem.heights_m.size(), 0);
    dem.voids[dem.index(100, 100)] = 1;
    const auto holed = bake_and_load(dem, small_bake(6));
    // A leaf's diamond reaches two samples; everything above it must grow, nothing else may.
    for (std::int32_t y = 0; y < 129; ++y)
        for (std::int32_t x = 0; x < 129; ++x) {
            const SampleIndex v{x, y};
            const auto before = data_of(solid.terrain).vertex(v), after = data_of(holed.terrain).vertex(v);
            const std::int32_t reach = data_of(solid.terrain).tree.is_corner(v) ? 0 : 2 << Tree::step_log2(v);
            // The hole's own vertex stands on what continues the ground around it.
            if (x != 100 || y != 100) REQUIRE(before.steps == after.steps);
            if (std::max(std::abs(x - 100), std::abs(y - 100)) > 2 * reach)
                REQUIRE(std::abs(before.error_m - after.error_m) <=
                        0.051 * std::max(before.error_m, after.error_m)); // the scale may begin elsewhere
        }
    REQUIRE(data_of(holed.terrain).vertex({99, 100}).error_m >= 2 * holed.terrain.spacing_x_m());
}
