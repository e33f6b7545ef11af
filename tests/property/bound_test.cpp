// The bound that a snapshot claims, against measuring every sample: whatever state the mesh is in.
#include <catch2/catch.hpp>

#include <algorithm>
#include <vector>

#include "cut/state.h"
#include "fjell/measure.h"
#include "shared/terrain_data.h"
#include "support/cut_scene.h"
#include "support/rounds.h"

using namespace fjell;
using namespace fjell::test;

namespace {

CutSettings random_settings(Random& random) {
    CutSettings settings;
    settings.max_error_px = random_threshold(random);
    settings.morph = static_cast<Morph>(pick(random, 0, 2));
    settings.hysteresis = pick(random, 0, 3) == 0 ? 0.3 : 0;
    if (pick(random, 0, 2) == 0) settings.offscreen_factor = uniform(random, 1, 20);
    if (pick(random, 0, 1) == 0) settings.max_work = static_cast<std::uint32_t>(pick(random, 1, 300));
    return settings;
}

CutBudget random_budget(Random& random, const Terrain& terrain) {
    CutBudget budget = ample_cut(terrain);
    const auto corners = static_cast<std::uint32_t>(data_of(terrain).tree.tiles_x + 1) *
                         static_cast<std::uint32_t>(data_of(terrain).tree.tiles_y + 1);
    if (pick(random, 0, 2) == 0)
        budget.vertices =
            std::max(4 * terrain.tile_count(), corners) + static_cast<std::uint32_t>(pick(random, 0, 400));
    return budget;
}

// A terrain with some of its pages.
void load_some_pages(Random& random, const Pack& pack, const Terrain& terrain) {
    const double share = uniform(random, 0, 1);
    for (std::uint32_t tile = 0; tile < terrain.tile_count(); ++tile)
        for (std::uint32_t page = 0; page < terrain.pages_per_tile(); ++page)
            if (uniform(random, 0, 1) < share) (void)load_page(pack, terrain, tile, page); // some lack a coarser one
}

bool is_building(const Cut& cut) {
    return find_cut(cut.cut)->bulk.phase != BulkPhase::idle;
}

} // namespace

TEST_CASE("while a jump is built the claim is finite, and no sample that is shown is farther from the mesh") {
    Random random(153);
    std::size_t building = 0, wrong = 0, close = 0;
    for (int round = 0; round < rounds(60, 1500); ++round) {
        const auto pack = random_terrain(random, 200, 6);
        const Terrain& terrain = pack.terrain;
        Cut cut(terrain, ample_cut(terrain));
        CutSettings settings = random_settings(random);
        settings.max_work = unlimited_work;
        View view = random_view(random, terrain);
        (void)cut.update({&view, 1}, settings);
        for (int frame = 0; frame < 12; ++frame) {
            settings.now_s += 0.05;
            settings.visits = static_cast<std::uint32_t>(pick(random, 1, 6)); // in place of a clock
            if (pick(random, 0, 5) == 0) view = random_view(random, terrain);
            const CutReport report = cut.update({&view, 1}, settings);
            if (!is_building(cut)) continue;
            ++building;
            CutMesh live = cut_mesh(cut.cut);
            const std::vector<MeshVertex> drawn = drawn_vertices(terrain, live);
            live.mesh.vertices = drawn;
            const Frustum frustum = make_frustum(view);
            const double shown_px = measure_error(terrain, live.mesh, view, &frustum).max_px;
            CAPTURE(round, frame, settings.max_error_px, settings.morph, report.error_bound_px, shown_px);
            REQUIRE(shown_px <= report.error_bound_px * (1 + 1e-6));
            // All errors are less than the terrain's extent, and no view's near plane is nearer than 1e-5 of that.
            REQUIRE(report.error_bound_px < 1e6 * focal_length_px(view));
            wrong += shown_px > report.threshold_px;
            close += shown_px > report.error_bound_px / 4;
        }
    }
    CAPTURE(building, wrong, close);
    CHECK(building > rounds<std::size_t>(25, 500));
    CHECK(wrong > building / 10);
    CHECK(close != 0);
}

TEST_CASE("no sample is farther from a live mesh than its bound, however far it is behind, and the bound is tight") {
    Random random(151);
    std::size_t behind = 0, tight = 0, paged = 0, lagging = 0, told = 0;
    for (int round = 0; round < rounds(60, 1500); ++round) {
        const auto pack = random_terrain(random, 200, 6);
        const bool whole = pick(random, 0, 2) != 0;
        const PagedTerrain some(pack.pack, {});
        if (!whole) load_some_pages(random, pack.pack, some.terrain);
        const Terrain& terrain = whole ? pack.terrain : some.terrain;
        Cut cut(terrain, random_budget(random, terrain));
        View view = random_view(random, terrain);
        CutSettings settings = random_settings(random);
        for (int frame = 0; frame < 5; ++frame) {
            settings.now_s += 0.05;
            const CutReport report = cut.update({&view, 1}, settings);
            CutMesh live = cut_mesh(cut.cut);
            const std::vector<MeshVertex> drawn = drawn_vertices(terrain, live);
            live.mesh.vertices = drawn;
            const double measured_px = measure_error(pack.terrain, live.mesh, view).max_px;
            const double bound_px = bound_error_px(cut.cut, view, false, 1e-3);
            // What the report claims is of what the view shows.
            const Frustum frustum = make_frustum(view);
            const bool all_around = settings.offscreen_factor == 1;
            const double shown_px =
                all_around ? measured_px : measure_error(pack.terrain, live.mesh, view, &frustum).max_px;
            CAPTURE(round, frame, whole, settings.max_error_px, settings.morph, report.waiting, report.morphing,
                    measured_px, bound_px, report.error_bound_px);
            REQUIRE(measured_px <= bound_px);
            if (whole) {
                REQUIRE(shown_px <= report.error_bound_px * (1 + 1e-6));
                lagging += !report.converged;
                told += !report.converged && report.error_bound_px < unbounded_px;
            }
            if (whole && !is_building(cut) && !terrain.has_voids() && measured_px < 1e6) {
                REQUIRE(bound_px <= std::max(1e-3, 1.1 * measured_px));
                ++tight;
            }
            // Beside a hole the bound adds what morphing moves to what is hidden: it may be more than the threshold.
            const bool added = terrain.has_voids() && settings.morph != Morph::none;
            if (report.waiting == 0 && report.morphing == 0 && whole && !added && all_around)
                REQUIRE(bound_px <= report.error_bound_px * (1 + 1e-6));
            behind += measured_px > settings.max_error_px;
            paged += !whole;
            view = moved(random, view, random_step_m(random, terrain));
            if (!all_around) view = turned(random, view, 0.3);
        }
    }
    CHECK(behind > rounds<std::size_t>(25, 500));
    CHECK(tight > rounds<std::size_t>(50, 1000));
    CHECK(paged > rounds<std::size_t>(25, 500));
    CHECK(lagging > rounds<std::size_t>(25, 500));
    CHECK(told > lagging / 4);
}

TEST_CASE("while many vertices morph by time the claim holds, and is of some use") {
    Random random(154);
    std::size_t many = 0, close = 0;
    for (int round = 0; round < rounds(6, 100); ++round) {
        const auto pack = rich_terrain(random, 257, 7);
        const Terrain& terrain = pack.terrain;
        Cut cut(terrain, ample_cut(terrain));
        CutSettings settings;
        settings.max_error_px = uniform(random, 0.5, 3);
        settings.morph = round % 3 == 2 ? Morph::error : Morph::time;
        settings.morph_s = uniform(random, 0.1, 1);
        View view = view_from_above(terrain, uniform(random, 0.02, 0.3));
        (void)cut.rebuild({&view, 1}, settings);
        const Vec3 step = normalised({uniform(random, -1, 1), 0, uniform(random, -1, 1)}) *
                          (terrain.spacing_x_m() * uniform(random, 0.2, 20));
        for (int frame = 0; frame < 20; ++frame) {
            view.eye_m = view.eye_m + step;
            settings.now_s += 1.0 / 60;
            const CutReport report = cut.update({&view, 1}, settings);
            CutMesh live = cut_mesh(cut.cut);
            const std::vector<MeshVertex> drawn = drawn_vertices(terrain, live);
            live.mesh.vertices = drawn;
            const double measured_px = measure_error(terrain, live.mesh, view).max_px;
            CAPTURE(round, frame, settings.max_error_px, settings.morph, report.morphing);
            REQUIRE(measured_px <= report.error_bound_px * (1 + 1e-6));
            if (report.morphing < 100 || is_building(cut)) continue;
            ++many;
            close += report.error_bound_px < 12 * std::max(measured_px, settings.max_error_px);
        }
    }
    CAPTURE(many, close);
    CHECK(many > rounds<std::size_t>(30, 500));
    CHECK(close > many / 2);
}

TEST_CASE("while many vertices morph by time the claim holds, and is a small multiple of the truth") {
    Random random(393);
    std::vector<double> ratios;
    for (int round = 0; round < rounds(2, 20); ++round) {
        const auto pack = bake_and_load(random_dem(random, 513, 513, Shape::fractal), small_bake(7));
        const Terrain& terrain = pack.terrain;
        Cut cut(terrain, ample_cut(terrain));
        CutSettings settings{.max_error_px = 1, .morph = Morph::time, .morph_s = 1};
        const double cells = uniform(random, 0.25, 2), wide_m = terrain.extent_x_m();
        for (int frame = 0; frame < 100; ++frame) { // straight on, low over the ridges
            settings.now_s = frame / 64.0;
            const Vec3 eye{wide_m * 0.1 + frame * cells * terrain.spacing_x_m(), terrain.header().max_m + 0.02 * wide_m,
                           terrain.extent_z_m() / 2};
            const View view = make_view(eye, {1, -0.5, 0.1}, {0, 1, 0}, 1, 1280, 720, 1, 1e6);
            const CutReport report = cut.update({&view, 1}, settings);
            if (frame % 5 != 0 || report.morphing < 100 || is_building(cut)) continue;
            CutMesh live = cut_mesh(cut.cut);
            const std::vector<MeshVertex> drawn = drawn_vertices(terrain, live);
            live.mesh.vertices = drawn;
            const double shown_px = measure_error(terrain, live.mesh, view).max_px;
            CAPTURE(round, frame, cells, report.morphing, report.error_bound_px, shown_px);
            REQUIRE(shown_px <= report.error_bound_px * (1 + 1e-6));
            ratios.push_back(report.error_bound_px / shown_px);
        }
    }
    REQUIRE(ratios.size() > rounds<std::size_t>(20, 200));
    std::ranges::sort(ratios);
    CAPTURE(ratios.size(), ratios[ratios.size() / 2], ratios.back());
    // All of a page counted in which any vertex morphs: 770 in the median.
    CHECK(ratios[ratios.size() / 2] < 10);
    CHECK(ratios[ratios.size() * 9 / 10] < 80);
}

TEST_CASE("no sample is farther from a recursive mesh than its bound, culled or short of a capacity") {
    Random random(152);
    std::size_t beyond = 0;
    for (int round = 0; round < rounds(60, 1000); ++round) {
        const auto pack = random_terrain(random, 200, 6);
        RecursiveBudget budget = ample_budget(pack.terrain);
        if (pick(random, 0, 2) == 0) {
            budget.vertices = std::min(budget.vertices, 4 * pack.terrain.tile_count() + 60);
            budget.indices = std::min(budget.indices, 12 * pack.terrain.tile_count() + 600);
        }
        Recursive method(pack.terrain, budget);
        const View view = random_view(random, pack.terrain);
        RefineSettings settings;
        settings.max_error_px = random_threshold(random);
        settings.cull = pick(random, 0, 1) == 0;
        settings.topology = pick(random, 0, 1) == 0 ? Topology::strip : Topology::triangles;
        const FrameReport report = method.update(view, settings);
        const double measured_px = measure_error(pack.terrain, method.mesh(), view).max_px;
        const double bound_px = bound_error_px(method.method, view, false, 1e-3);
        CAPTURE(round, settings.max_error_px, settings.cull, report.error_bound_px, measured_px, bound_px);
        REQUIRE(measured_px <= bound_px);
        if (!pack.terrain.has_voids() && measured_px < 1e6) REQUIRE(bound_px <= std::max(1e-3, 1.1 * measured_px));
        if (!settings.cull) REQUIRE(bound_px <= report.error_bound_px * (1 + 1e-6));
        beyond += measured_px > report.error_bound_px;
    }
    CHECK(beyond > rounds<std::size_t>(5, 50));
}

TEST_CASE("a refused handle promises nothing") {
    CHECK(bound_error_px(LiveCut{}, View{}, false, 1) == unbounded_px);
    CHECK(bound_error_px(RecursiveMethod{}, View{}, false, 1) == unbounded_px);
}
