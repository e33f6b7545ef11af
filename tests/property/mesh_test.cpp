// invariants 1 to 4 on the recursive method, over random terrains, tilings, cameras, thresholds and budgets.
#include <catch2/catch.hpp>

#include <cmath>

#include "fjell/measure.h"
#include "shared/terrain_data.h"
#include "support/cut_scene.h"
#include "support/mesh_check.h"
#include "support/rounds.h"
#include "support/terrain_fixture.h"
#include "view/wanted.h"

using namespace fjell;
using namespace fjell::test;

namespace {

struct Tiling {
    int tile_log2;
    std::int32_t tiles_x, tiles_y;
};
constexpr Tiling tilings[] = {{1, 1, 1}, {1, 5, 3}, {2, 4, 4}, {3, 1, 1},   {3, 3, 2},  {4, 2, 5},
                              {5, 3, 2}, {6, 1, 1}, {6, 2, 1}, {3, 32, 16}, {2, 32, 16}};

io::LoadedPack random_terrain(Random& random, const Tiling& t, double nesting) {
    const auto shape = static_cast<Shape>(pick(random, 0, static_cast<int>(Shape::count) - 1));
    return bake_and_load(random_dem(random, (t.tiles_x << t.tile_log2) + 1, (t.tiles_y << t.tile_log2) + 1, shape),
                         small_bake(t.tile_log2, nesting));
}

// The bound a measured error must keep: the threshold, and nothing else: the mesh and the measure use the same heights.
// Float rounding is inside the method's own margin.
bool within(double measured_px, double threshold_px) {
    return measured_px <= threshold_px * (1 + 1e-9);
}

} // namespace

TEST_CASE("without culling every mesh is crack-free, covers the terrain and keeps the screen bound") {
    Random random(1);
    for (const Tiling& tiling : tilings)
        for (int terrain_number = 0; terrain_number < rounds(3, 8); ++terrain_number) {
            const double nesting = pick(random, 0, 2) ? 0.05 : 0.001;
            const auto pack = random_terrain(random, tiling, nesting);
            Recursive method(pack.terrain, ample_budget(pack.terrain));
            for (int frame = 0; frame < 8; ++frame) {
                const View view = random_view(random, pack.terrain);
                RefineSettings settings;
                settings.max_error_px = random_threshold(random);
                settings.cull = false;
                const FrameReport report = method.update(view, settings);
                CAPTURE(tiling.tile_log2, tiling.tiles_x, tiling.tiles_y, terrain_number, frame, settings.max_error_px);
                REQUIRE(report.converged);
                REQUIRE(report.tiles == pack.terrain.tile_count());
                REQUIRE(check_mesh(pack.terrain, method.mesh()) == "");
                const MeasuredError error = measure_error(pack.terrain, method.mesh(), view);
                REQUIRE(within(error.max_px, settings.max_error_px));
            }
        }
}

TEST_CASE("with culling the mesh stays crack-free and keeps the bound inside the frustum, for both metrics") {
    Random random(2);
    for (const Tiling& tiling : tilings)
        for (int terrain_number = 0; terrain_number < rounds(2, 6); ++terrain_number) {
            const auto pack = random_terrain(random, tiling, 0.05);
            Recursive method(pack.terrain, ample_budget(pack.terrain));
            for (int frame = 0; frame < 8; ++frame) {
                const View view = random_view(random, pack.terrain);
                const Frustum frustum = make_frustum(view);
                for (const Metric metric : {Metric::isotropic, Metric::depth}) {
                    RefineSettings settings;
                    settings.max_error_px = random_threshold(random);
                    settings.metric = metric;
                    (void)method.update(view, settings);
                    CAPTURE(tiling.tile_log2, tiling.tiles_x, tiling.tiles_y, terrain_number, frame,
                            settings.max_error_px);
                    REQUIRE(check_mesh(pack.terrain, method.mesh()) == "");
                    REQUIRE(within(measure_error(pack.terrain, method.mesh(), view, &frustum).max_px,
                                   settings.max_error_px));
                }
            }
        }
}

TEST_CASE("any extents: the same holds for terrains that end inside their last tiles, strips too") {
    Random random(12);
    for (int round = 0; round < rounds(65, 300); ++round) {
        const bool large = round % 60 == 59;
        const std::int32_t columns = pick(random, 2,
                                          large       ? 1000
                                          : round % 3 ? 90
                                                      : 9),
                           rows = pick(random, 2,
                                       large       ? 700
                                       : round % 3 ? 70
                                                   : 9);
        const auto shape = static_cast<Shape>(round % static_cast<int>(Shape::count));
        const int log2 = large ? pick(random, 5, 9) : pick(random, 1, 6);
        const auto pack = bake_and_load(random_dem(random, columns, rows, shape), small_bake(log2));
        Recursive method(pack.terrain, ample_budget(pack.terrain)), strips(pack.terrain, ample_budget(pack.terrain));
        for (int frame = 0; frame < (large ? 2 : 6); ++frame) {
            const View view = random_view(random, pack.terrain);
            const Frustum frustum = make_frustum(view);
            RefineSettings settings;
            settings.max_error_px = random_threshold(random) * (large ? 10 : 1);
            settings.cull = frame % 2 == 1;
            (void)method.update(view, settings);
            CAPTURE(round, columns, rows, log2, frame, settings.max_error_px);
            REQUIRE(check_mesh(pack.terrain, method.mesh()) == "");
            const MeasuredError error =
                measure_error(pack.terrain, method.mesh(), view, settings.cull ? &frustum : nullptr);
            REQUIRE(within(error.max_px, settings.max_error_px));
            settings.topology = Topology::strip;
            (void)strips.update(view, settings);
            REQUIRE(check_mesh(pack.terrain, strips.mesh()) == "");
            REQUIRE(triangles_of(strips.mesh()) == triangles_of(method.mesh()));
        }
    }
}

TEST_CASE("no sample inside the frustum belongs to a tile that is not drawn") {
    Random random(3);
    for (int round = 0; round < 40; ++round) {
        const auto pack = random_terrain(random, {3, 8, 8}, 0.05);
        const Terrain& terrain = pack.terrain;
        Recursive method(terrain, ample_budget(terrain));
        const View view = random_view(random, terrain);
        const Frustum frustum = make_frustum(view);
        (void)method.update(view, {});
        std::vector<bool> drawn(terrain.tile_count());
        for (const TileRange& range : method.mesh().tiles) drawn[range.tile] = true;
        for (std::int32_t y = 0; y < data_of(terrain).tree.rows(); ++y)
            for (std::int32_t x = 0; x < data_of(terrain).tree.columns(); ++x) {
                const Vec3 p = Vec3{terrain.x_m(x), data_of(terrain).height_m({x, y}), terrain.z_m(y)} - view.eye_m;
                bool inside = true;
                for (int i = 0; i < 6; ++i) inside = inside && dot(frustum.normal[i], p) >= frustum.offset[i];
                if (inside) REQUIRE(drawn[static_cast<std::size_t>(std::min(y / 8, 7) * 8 + std::min(x / 8, 7))]);
            }
    }
}

TEST_CASE("strip and list describe the same triangles with the same winding") {
    Random random(4);
    for (const Tiling& tiling : tilings)
        for (int frame = 0; frame < 10; ++frame) {
            const auto pack = random_terrain(random, tiling, 0.05);
            Recursive lists(pack.terrain, ample_budget(pack.terrain)), strips(pack.terrain, ample_budget(pack.terrain));
            const View view = random_view(random, pack.terrain);
            RefineSettings settings;
            settings.max_error_px = random_threshold(random);
            settings.cull = pick(random, 0, 1) == 1;
            const FrameReport list_report = lists.update(view, settings);
            settings.topology = Topology::strip;
            const FrameReport strip_report = strips.update(view, settings);
            REQUIRE(strip_report.triangles == list_report.triangles);
            REQUIRE(strip_report.vertices == list_report.vertices);
            REQUIRE(check_mesh(pack.terrain, strips.mesh()) == "");
            REQUIRE(triangles_of(strips.mesh()) == triangles_of(lists.mesh()));
            // One strip a tile, and not much longer than its triangles (L&P: about 1.3 to 1.6 indices a triangle).
            REQUIRE(strips.mesh().indices.size() <= lists.mesh().indices.size() + 9 * strips.mesh().tiles.size());
        }
}

TEST_CASE("spheres that touch nest: an eye on a decision surface makes no crack, even with the smallest nesting") {
    Random random(5);
    for (int round = 0; round < 12; ++round) {
        const auto pack = random_terrain(random, {4, 3, 3}, 0.001);
        const Terrain& terrain = pack.terrain;
        Recursive method(terrain, ample_budget(terrain));
        const auto position = [&](SampleIndex c) {
            return Vec3{terrain.x_m(c.column), data_of(terrain).height_m(c), terrain.z_m(c.row)};
        };
        for (int sample = 0; sample < 60; ++sample) {
            const SampleIndex v{pick(random, 0, data_of(terrain).tree.columns() - 1),
                                pick(random, 0, data_of(terrain).tree.rows() - 1)};
            if (data_of(terrain).tree.is_corner(v)) continue;
            const Diamond d = diamond(data_of(terrain).tree, v);
            const SampleIndex parent = d.apexes[pick(random, 0, 1)];
            if (!data_of(terrain).tree.contains(parent) || data_of(terrain).tree.is_corner(parent)) continue;
            RefineSettings settings;
            settings.cull = false;
            settings.max_error_px = random_threshold(random);
            View view = make_view({}, {0, -1, 0.1}, {0, 1, 0}, 1, 1280, 720, 1, 1e6);
            const double q = focal_length_px(view) / settings.max_error_px;
            const double reach =
                static_cast<double>(data_of(terrain).vertex(v).radius_m) + data_of(terrain).vertex(v).error_m * q;
            // From the parent through the child to where the child is just not wanted: there the two are closest.
            const Vec3 away = normalised(position(v) - position(parent));
            if (length(away) == 0) continue;
            const double nudge = 1 + pick(random, -3, 3) * 0x1p-23;
            view.eye_m = position(v) + away * (reach * nudge);
            if (!validate(view).ok()) continue;
            (void)method.update(view, settings);
            REQUIRE(check_mesh(terrain, method.mesh()) == "");
        }
    }
}

TEST_CASE("what is selected is exactly what is wanted (invariant 7)") {
    Random random(6);
    for (int round = 0; round < 40; ++round) {
        const auto pack = random_terrain(random, tilings[pick(random, 0, 8)], 0.05);
        const Terrain& terrain = pack.terrain;
        Recursive method(terrain, ample_budget(terrain));
        const View view = random_view(random, terrain);
        RefineSettings settings;
        settings.max_error_px = random_threshold(random);
        settings.cull = false;
        (void)method.update(view, settings);
        const Reach reach = make_reach(view, settings.max_error_px);
        std::vector<bool> used(static_cast<std::size_t>(data_of(terrain).tree.columns()) *
                               static_cast<std::size_t>(data_of(terrain).tree.rows()));
        const auto at = [&](SampleIndex c) {
            return static_cast<std::size_t>(c.row) * static_cast<std::size_t>(data_of(terrain).tree.columns()) +
                   static_cast<std::size_t>(c.column);
        };
        for (const Triangle& t : triangles_of(method.mesh()))
            for (const SampleIndex c : t) used[at(c)] = true;
        for (std::int32_t y = 0; y < data_of(terrain).tree.rows(); ++y)
            for (std::int32_t x = 0; x < data_of(terrain).tree.columns(); ++x) {
                const SampleIndex c{x, y};
                const TerrainData::Vertex r = data_of(terrain).vertex(c);
                const bool expected =
                    data_of(terrain).tree.is_corner(c) ||
                    wanted(reach, terrain.x_m(x), data_of(terrain).height_m(c), terrain.z_m(y), r.error_m, r.radius_m);
                REQUIRE(used[at(c)] == expected);
            }
    }
}

TEST_CASE("with culling, too, what is selected is exactly what is wanted and meets the frustum, once in each tile") {
    Random random(15);
    for (int round = 0; round < rounds(40, 160); ++round) {
        const auto shape = static_cast<Shape>(round % static_cast<int>(Shape::count));
        baker::BakeOptions options = small_bake(pick(random, 1, 8));
        options.order = static_cast<PageOrder>(round % 3);
        const auto pack = bake_and_load(random_dem(random, pick(random, 2, 260), pick(random, 2, 200), shape), options);
        const Terrain& terrain = pack.terrain;
        const TerrainData& data = data_of(terrain);
        Recursive method(terrain, ample_budget(terrain));
        for (int frame = 0; frame < 4; ++frame) {
            const View view = random_view(random, terrain);
            RefineSettings settings;
            settings.max_error_px = random_threshold(random);
            settings.metric = frame == 3 ? Metric::depth : Metric::isotropic;
            settings.topology = frame == 2 ? Topology::strip : Topology::triangles;
            const FrameReport report = method.update(view, settings);
            const Reach reach = make_reach(view, settings.max_error_px);
            const Frustum frustum = make_frustum(view);
            // Of the grid, row by row, also beyond the rim.
            const std::int32_t columns = data.tree.grid_columns(), rows = data.tree.grid_rows();
            const auto at = [&](SampleIndex c) { return static_cast<std::size_t>(c.row) * columns + c.column; };
            std::vector<bool> expected(static_cast<std::size_t>(columns) * rows), used = expected, drawn = expected;
            for (std::int32_t y = 0; y < rows; ++y)
                for (std::int32_t x = 0; x < columns; ++x) {
                    const TerrainData::Vertex v = data.vertex({x, y});
                    const SampleIndex s = data.tree.sample({x, y});
                    const float px = terrain.x_m(s.column), pz = terrain.z_m(s.row);
                    const Vec3 p = Vec3{px, v.height_m, pz} - view.eye_m;
                    bool in = settings.metric == Metric::depth
                                  ? dot(view.forward, p) - double{v.radius_m} <
                                        std::max(double{v.error_m} * double{reach.q}, view.near_m)
                                  : wanted(reach, px, v.height_m, pz, v.error_m, v.radius_m);
                    for (int i = 0; i < 6; ++i)
                        in = in && !(dot(frustum.normal[i], p) - frustum.offset[i] < -double{v.radius_m});
                    expected[at({x, y})] = in || data.tree.is_corner({x, y});
                }
            const MeshView mesh = method.mesh();
            std::size_t count = 0;
            const std::int32_t side = data.tree.side();
            for (const TileRange& range : mesh.tiles)
                for (std::int32_t y = 0; y <= side; ++y)
                    for (std::int32_t x = 0; x <= side; ++x) {
                        const auto tile = static_cast<std::int32_t>(range.tile);
                        const SampleIndex c{tile % data.tree.tiles_x * side + x, tile / data.tree.tiles_x * side + y};
                        drawn[at(c)] = true;
                        count += expected[at(c)];
                    }
            for (const Triangle& t : triangles_of(mesh))
                for (const SampleIndex c : t) used[at(c)] = true;
            std::size_t wrong = 0;
            for (std::int32_t y = 0; y < data.tree.rows() - 1; ++y) // at the rim several stand at one sample
                for (std::int32_t x = 0; x < data.tree.columns() - 1; ++x)
                    wrong += used[at({x, y})] != (drawn[at({x, y})] && expected[at({x, y})]);
            CAPTURE(round, frame, data.tree.tile_log2, columns, rows, settings.max_error_px);
            REQUIRE(wrong == 0);
            REQUIRE(report.vertices == count);
        }
    }
}

TEST_CASE("what a frame knew of a vertex is forgotten by the time that frames' numbers come again") {
    Random random(16);
    const auto pack = bake_and_load(random_dem(random, 33, 33, Shape::noise), small_bake(5));
    Recursive method(pack.terrain, ample_budget(pack.terrain));
    View away = view_from_above(pack.terrain, 0.1);
    away.eye_m.y += away.far_m * 2;
    RefineSettings all, none;
    all.max_error_px = 0.01;
    for (int turn = 0; turn < 2; ++turn) {
        const FrameReport whole = method.update(view_from_above(pack.terrain, 0.1), all);
        REQUIRE(whole.vertices > 500);
        for (int frame = 3; frame < 21844; ++frame) REQUIRE(method.update(away, none).tiles == 0);
        for (int frame = 0; frame < 4; ++frame) {
            const View view = view_from_above(pack.terrain, 3);
            RefineSettings some;
            some.max_error_px = 30;
            Recursive fresh(pack.terrain, ample_budget(pack.terrain));
            const FrameReport expected = fresh.update(view, some), report = method.update(view, some);
            REQUIRE(expected.vertices > 10);
            REQUIRE(expected.vertices < 500);
            REQUIRE(report.vertices == expected.vertices);
            REQUIRE(triangles_of(method.mesh()) == triangles_of(fresh.mesh()));
        }
    }
}

TEST_CASE("the corner-safe bound is the angular one, divided by what the image's corner stretches") {
    Random random(13);
    for (int round = 0; round < 30; ++round) {
        const auto pack = random_terrain(random, {5, 2, 2}, 0.05);
        Recursive method(pack.terrain, ample_budget(pack.terrain)), plain(pack.terrain, ample_budget(pack.terrain));
        const View view = random_view(random, pack.terrain);
        RefineSettings settings;
        settings.max_error_px = random_threshold(random);
        settings.cull = false;
        settings.corner_safe = true;
        const FrameReport report = method.update(view, settings);
        const MeasuredError error = measure_error(pack.terrain, method.mesh(), view);
        REQUIRE(within(error.max_px, settings.max_error_px / corner_factor(view)));
        REQUIRE(report.error_bound_px == settings.max_error_px);
        settings.corner_safe = false;
        settings.max_error_px /= corner_factor(view);
        (void)plain.update(view, settings);
        REQUIRE(triangles_of(method.mesh()) == triangles_of(plain.mesh()));
    }
}

TEST_CASE("a vertical error at the image's corner is never larger in pixels than the corner factor allows") {
    Random random(14);
    for (int round = 0; round < 2000; ++round) {
        const View view = make_view({}, {uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)},
                                    {0.1, 1, 0.2}, uniform(random, 0.2, 2.5), round % 2 ? 1600 : 5400, 900, 1, 1e5);
        const Vec3 right = cross(view.forward, view.up);
        const double ty = view.top, tx = view.right;
        const double u = uniform(random, -1, 1) * tx, v = uniform(random, -1, 1) * ty,
                     depth = uniform(random, 10, 1000);
        const Vec3 p = (view.forward + right * u + view.up * v) * depth;
        const double error_m = 1e-4 * depth; // small: the factor is the derivative's bound
        const auto pixel = [&](Vec3 q) {
            const double d = dot(q, view.forward);
            return Vec3{focal_length_px(view) * dot(q, right) / d, focal_length_px(view) * dot(q, view.up) / d, 0};
        };
        const double moved = length(pixel(p + Vec3{0, error_m, 0}) - pixel(p));
        const double angular = error_m * focal_length_px(view) / length(p);
        REQUIRE(moved <= angular * corner_factor(view) * 1.001); // second order in error / depth
        // And in the worst corner it does need that much, but for a step of the factor: nothing is wasted.
        double most = 1;
        for (const double x : {-tx, tx})
            for (const double y : {-ty, ty}) {
                const Vec3 corner = (view.forward + right * x + view.up * y) * depth;
                most = std::max(most, length(pixel(corner + Vec3{0, error_m, 0}) - pixel(corner)) /
                                          (error_m * focal_length_px(view) / length(corner)));
            }
        REQUIRE(corner_factor(view) <= 1.5 * most * 1.001);
    }
}

TEST_CASE("a budget that is too small lowers quality, names itself and breaks nothing") {
    Random random(7);
    for (int round = 0; round < 60; ++round) {
        const auto pack = random_terrain(random, {4, 3, 3}, 0.05);
        const Terrain& terrain = pack.terrain;
        const bool vertices = pick(random, 0, 1) == 0;
        RecursiveBudget budget = ample_budget(terrain);
        if (vertices)
            budget.vertices = static_cast<std::uint32_t>(pick(random, 4 * 9, 500));
        else
            budget.indices = static_cast<std::uint32_t>(pick(random, 9 * 9, 3000));
        Recursive method(terrain, budget), free(terrain, ample_budget(terrain));
        RefineSettings settings;
        settings.max_error_px = 0.05;
        settings.cull = pick(random, 0, 1) == 1;
        settings.topology = pick(random, 0, 1) ? Topology::strip : Topology::triangles;
        for (int frame = 0; frame < 4; ++frame) {
            const View view = random_view(random, terrain);
            const FrameReport report = method.update(view, settings);
            const FrameReport wish = free.update(view, settings);
            REQUIRE(check_mesh(terrain, method.mesh()) == "");
            REQUIRE(report.error_px_requested == settings.max_error_px);
            REQUIRE(report.converged == (report.error_bound_px <= report.error_px_requested));
            if (report.converged)
                REQUIRE(report.triangles == wish.triangles);
            else
                REQUIRE(report.exhausted == (vertices ? budget_vertices : budget_indices));
            if (vertices && wish.vertices > budget.vertices) REQUIRE_FALSE(report.converged);
        }
    }
}

TEST_CASE("quality comes back in full when the camera leaves") {
    Random random(8);
    const auto pack = bake_and_load(random_dem(random, 129, 129, Shape::fractal), small_bake(5));
    Recursive method(pack.terrain, {600, 4000});
    const double extent = pack.terrain.x_m(128);
    const auto at_height = [&](double h) {
        return make_view({extent / 2, pack.terrain.header().max_m + h, extent / 2}, {0, -1, 0.01}, {0, 1, 0}, 1, 800,
                         600, extent * 1e-4, extent * 1e4);
    };
    REQUIRE_FALSE(method.update(at_height(extent * 0.01), {}).converged);
    FrameReport report;
    int frames = 0;
    do report = method.update(at_height(extent * 300), {});
    while (!report.converged && ++frames < 1000);
    REQUIRE(report.converged);
    REQUIRE(report.exhausted == 0);
}

TEST_CASE("a copy of the vertex buffer that only takes over what was written stays equal to it") {
    Random random(9);
    const auto pack = bake_and_load(random_dem(random, 129, 65, Shape::fractal), small_bake(5));
    // Small enough to be cleared often, large enough to converge.
    Recursive method(pack.terrain, {3000, 40000});
    std::vector<MeshVertex> copy(3000);
    RefineSettings settings;
    settings.max_error_px = 4;
    std::uint32_t clearings = 0;
    for (int frame = 0; frame < 300; ++frame) {
        const FrameReport report = method.update(random_view(random, pack.terrain), settings);
        clearings += report.buffer_clearings;
        const MeshView mesh = method.mesh();
        for (std::uint32_t i = mesh.dirty_begin; i < mesh.dirty_end; ++i) copy[i] = mesh.vertices[i];
        for (const std::uint32_t i : mesh.indices) {
            REQUIRE(copy[i].column == mesh.vertices[i].column);
            REQUIRE(copy[i].row == mesh.vertices[i].row);
            REQUIRE(copy[i].height_m == mesh.vertices[i].height_m);
        }
        REQUIRE(check_mesh(pack.terrain, mesh) == "");
    }
    REQUIRE(clearings > 0);
}

TEST_CASE("a bad view or setting is refused by name and leaves the mesh as it was") {
    Random random(10);
    const auto pack = bake_and_load(random_dem(random, 33, 33, Shape::fractal), small_bake(4));
    Recursive method(pack.terrain, ample_budget(pack.terrain));
    const View good = random_view(random, pack.terrain);
    (void)method.update(good, {});
    const auto before = triangles_of(method.mesh());
    FrameReport report;
    const auto refused = [&](const View& view, const RefineSettings& settings, const std::string& field) {
        const Status s = update_recursive(method.method, view, settings, report);
        CHECK(s.code == StatusCode::out_of_range);
        CHECK(std::string(s.field).rfind(field, 0) == 0);
        CHECK(triangles_of(method.mesh()) == before);
    };
    View bad = good;
    bad.eye_m.x = std::nan("");
    refused(bad, {}, "View::eye_m");
    bad = good;
    bad.forward = {0, 0, 0};
    refused(bad, {}, "View::forward");
    bad = good;
    bad.near_m = bad.far_m;
    refused(bad, {}, "View::near_m");
    bad = good;
    bad.top = bad.bottom;
    refused(bad, {}, "View::bottom, top");
    RefineSettings settings;
    settings.max_error_px = 0;
    refused(good, settings, "RefineSettings::max_error_px");
    settings = {};
    settings.metric = Metric::depth;
    settings.cull = false;
    refused(good, settings, "RefineSettings::cull");
}
