// What no view sees may be coarser (CutSettings::offscreen_factor), and nothing else may.
#include <catch2/catch.hpp>

#include <algorithm>
#include <vector>

#include "fjell/measure.h"
#include "support/cut_scene.h"
#include "support/rounds.h"

using namespace fjell;
using namespace fjell::test;

namespace {

// Of the set, those whose spheres some view sees: straight from the definition.
VertexSet seen_of(const Terrain& terrain, const VertexSet& set, std::span<const View> views) {
    const TerrainData& t = data_of(terrain);
    VertexSet out(set.size(), false);
    const std::int32_t columns = t.tree.grid_columns();
    for (std::size_t i = 0; i < set.size(); ++i) {
        const SampleIndex c{static_cast<std::int32_t>(i) % columns, static_cast<std::int32_t>(i) / columns};
        if (!set[i] || t.tree.is_corner(c)) continue;
        const TerrainData::Vertex v = t.vertex(c);
        const SampleIndex at = t.tree.sample(c);
        for (const View& view : views) {
            const Frustum f = make_frustum(view);
            const Vec3 p = Vec3{t.x_m(at.column), v.height_m, t.z_m(at.row)} - view.eye_m;
            bool inside = true;
            for (int plane = 0; plane < 6; ++plane)
                inside = inside && dot(f.normal[plane], p) >= f.offset[plane] - static_cast<double>(v.radius_m);
            if (inside) out[i] = true;
        }
    }
    return out;
}

std::size_t count(const VertexSet& set) {
    return static_cast<std::size_t>(std::count(set.begin(), set.end(), true));
}

} // namespace

TEST_CASE("at rest all that a view sees is refined as asked, nothing finer, and the rest to the factor at least") {
    Random random(161);
    std::size_t some_less = 0, frames = 0;
    for (int round = 0; round < rounds(8, 150); ++round) {
        const auto pack = pick(random, 0, 1) ? random_terrain(random, 150, 6) : rich_terrain(random, 200, 6);
        const Terrain& terrain = pack.terrain;
        std::vector<View> views(static_cast<std::size_t>(pick(random, 1, 3)));
        for (View& view : views) view = random_view(random, terrain);
        Cut cut(terrain, ample_cut(terrain, 3));
        CutSettings settings;
        settings.max_error_px = random_threshold(random);
        for (int frame = 0; frame < 12; ++frame, ++frames) {
            // Now and then all around again: that must come back exactly.
            settings.offscreen_factor = pick(random, 0, 3) == 0 ? 1 : std::pow(10.0, uniform(random, 0, 2));
            if (pick(random, 0, 5) == 0) settings.max_error_px = random_threshold(random);
            for (View& view : views) {
                view = moved(random, view, random_step_m(random, terrain));
                view = turned(random, view, pick(random, 0, 1) ? 0.02 : 1);
            }
            if (pick(random, 0, 5) == 0) std::swap(views.front(), views.back());
            CutReport report;
            if (pick(random, 0, 5) == 0) report = cut.rebuild(views, settings);
            report = settle(cut, views, settings);
            CAPTURE(round, frame, views.size(), settings.max_error_px, settings.offscreen_factor, report.waiting);
            REQUIRE(report.converged);
            REQUIRE(check_frame(cut, terrain, report, settings) == "");
            const VertexSet now = active_set(cut), fine = target_set(terrain, terrain, views, settings.max_error_px);
            if (settings.offscreen_factor == 1) {
                REQUIRE(difference(now, fine) == "");
                continue;
            }
            REQUIRE(contains(fine, now));
            REQUIRE(contains(now, seen_of(terrain, fine, views)));
            REQUIRE(
                contains(now, target_set(terrain, terrain, views, settings.max_error_px * settings.offscreen_factor)));
            some_less += count(now) < count(fine);
            for (const View& view : views) {
                const Frustum frustum = make_frustum(view);
                REQUIRE(measure_error(terrain, cut.mesh(), view, &frustum).max_px <=
                        report.error_bound_px * (1 + 1e-6));
            }
        }
    }
    CHECK(some_less > frames / 10); // or it would not be worth its name
}

TEST_CASE("what comes into sight stands before it is seen: a head that turns at rest sees neither lag nor morphing") {
    Random random(162);
    const auto pack = rich_terrain(random, 513, 6);
    const Terrain& terrain = pack.terrain;
    const double extent = terrain.x_m(512);
    for (const Morph morph : {Morph::none, Morph::error, Morph::time}) {
        Cut cut(terrain, ample_cut(terrain));
        CutSettings settings{.max_error_px = 2, .morph = morph, .offscreen_factor = 8};
        View view = make_view({extent / 2, terrain.header().max_m + extent / 50, extent / 2}, {1, -0.2, 0}, {0, 1, 0},
                              0.8, 640, 480, 1, 1e6);
        CutReport report = cut.rebuild({&view, 1}, settings);
        std::size_t changes = 0, coarser = 0;
        for (int frame = 0; frame < rounds(90, 720); ++frame) {
            const double angle = frame / 57.3; // a degree a frame
            view = make_view(view.eye_m, {std::cos(angle), -0.2, std::sin(angle)}, {0, 1, 0}, 0.8, 640, 480, 1, 1e6);
            settings.now_s += 1.0 / 60;
            report = cut.update({&view, 1}, settings);
            CAPTURE(frame, morph, report.waiting, report.morphing);
            REQUIRE(report.error_bound_px == settings.max_error_px);
            REQUIRE(report.morphing == 0);
            changes += report.activations;
            const Frustum frustum = make_frustum(view);
            if (frame % 20 == 0) coarser += measure_error(terrain, cut.mesh(), view).max_px > settings.max_error_px;
            if (frame % 20 == 0 && morph == Morph::none)
                REQUIRE(measure_error(terrain, cut.mesh(), view, &frustum).max_px <=
                        settings.max_error_px * (1 + 1e-6));
        }
        CHECK(changes > 1000);
        CHECK(coarser > rounds<std::size_t>(2, 5));
    }
}

TEST_CASE("pages are looked at again only when a view has left what they were looked at with") {
    Random random(163);
    const auto pack = rich_terrain(random, 257, 6);
    const double extent = pack.terrain.x_m(256), cell = pack.terrain.spacing_x_m();
    Cut cut(pack.terrain, ample_cut(pack.terrain));
    const CutSettings settings{.max_error_px = 1, .offscreen_factor = 4};
    View view = make_view({extent / 2, pack.terrain.header().max_m + cell, extent / 2}, {1, -0.1, 0}, {0, 1, 0}, 0.8,
                          640, 480, 1, 1e6);
    (void)cut.rebuild({&view, 1}, settings);
    int looks = 0;
    Vec3 at = cut.state().visibility.now.of[0].eye_m;
    for (int frame = 0; frame < 100; ++frame) {
        view.eye_m = view.eye_m + Vec3{cell / 2, 0, 0};
        (void)cut.update({&view, 1}, settings);
        const Vec3 now = cut.state().visibility.now.of[0].eye_m;
        looks += length(now - at) > 0;
        at = now;
    }
    CHECK(looks >= 10);
    CHECK(looks <= 13); // after more than 4 cells each
}

TEST_CASE("with time enough every frame of a flight keeps to its threshold, pages that are new to it too") {
    Random random(167);
    const auto pack = rich_terrain(random, 1025, 7);
    const Terrain& terrain = pack.terrain;
    const double cell_m = terrain.x_m(1), extent = terrain.x_m(1024);
    for (int round = 0; round < rounds(3, 20); ++round) {
        Cut cut(terrain, ample_cut(terrain));
        const CutSettings settings{.max_error_px = 2, .offscreen_factor = 8};
        const double heading = uniform(random, 0, 6.28), step_m = cell_m * std::pow(10.0, uniform(random, -1, 0.5));
        const Vec3 forward{std::cos(heading), -0.15, std::sin(heading)};
        Vec3 eye{extent / 2, terrain.header().max_m + 10 * cell_m, extent / 2};
        for (int frame = 0; frame < 200; ++frame, eye = eye + Vec3{forward.x, 0, forward.z} * step_m) {
            const View view = make_view(eye, forward, {0, 1, 0}, 0.8, 640, 480, 1, 1e6);
            const CutReport report = frame == 0 ? cut.rebuild({&view, 1}, settings) : cut.update({&view, 1}, settings);
            CAPTURE(round, frame, step_m / cell_m, report.waiting);
            if (frame > 0) REQUIRE(report.error_bound_px == settings.max_error_px);
        }
    }
}

TEST_CASE("where time ends a frame before all pages are looked at, what is claimed holds for what is shown") {
    Random random(164);
    int lagging = 0, bounded = 0, beyond = 0;
    for (int round = 0; round < rounds(8, 60); ++round) {
        const auto pack = rich_terrain(random, 257, 6);
        const Terrain& terrain = pack.terrain;
        Cut cut(terrain, ample_cut(terrain));
        CutSettings settings{.max_error_px = uniform(random, 0.5, 3), .offscreen_factor = uniform(random, 3, 30)};
        View view = random_view(random, terrain);
        REQUIRE(settle(cut, {&view, 1}, settings).converged);
        for (int frame = 0; frame < 30; ++frame) {
            // Turned so far that all pages would have to be looked at, with time for some of them: in place of a clock.
            settings.visits = static_cast<std::uint32_t>(pick(random, 1, 12));
            if (pick(random, 0, 1) == 0) view = turned(random, view, 2);
            if (pick(random, 0, 29) == 0) view = random_view(random, terrain);
            const CutReport report = cut.update({&view, 1}, settings);
            CAPTURE(round, frame, settings.max_error_px, settings.offscreen_factor, report.waiting);
            REQUIRE(report.visits <= settings.visits);
            lagging += !report.converged;
            if (report.error_bound_px >= unbounded_px) continue;
            ++bounded;
            const Frustum frustum = make_frustum(view);
            const double shown_px = measure_error(terrain, cut.mesh(), view, &frustum).max_px;
            REQUIRE(shown_px <= report.error_bound_px * (1 + 1e-6));
            beyond += shown_px > settings.max_error_px * (1 + 1e-6);
        }
        settings.visits = unlimited_work;
        REQUIRE(settle(cut, {&view, 1}, settings).converged);
        const VertexSet fine = target_set(terrain, terrain, {&view, 1}, settings.max_error_px);
        REQUIRE(contains(active_set(cut), seen_of(terrain, fine, {&view, 1})));
    }
    CAPTURE(lagging, bounded, beyond);
    CHECK(beyond >= 5);
}
