// What a frame's report claims, against a measurement: in the frame in which anything at all has changed.
#include <catch2/catch.hpp>

#include <algorithm>
#include <vector>

#include "fjell/measure.h"
#include "support/rounds.h"
#include "support/stream_scene.h"

using namespace fjell;
using namespace fjell::test;

namespace {

// Each of them in one frame in three, so that any may change alone.
void change_some(Random& random, CutSettings& c, StreamSettings& s) {
    const auto now = [&] { return pick(random, 0, 2) == 0; };
    const auto few = [&](int most) {
        return pick(random, 0, 1) ? unlimited_work : static_cast<std::uint32_t>(pick(random, 0, most));
    };
    if (now()) c.max_error_px = random_threshold(random);
    if (now()) c.hysteresis = pick(random, 0, 1) ? 0 : uniform(random, 0, 1);
    if (now()) c.corner_safe = !c.corner_safe;
    if (now()) c.max_work = few(300);
    if (now()) c.visits = few(60);
    if (now()) c.morph = static_cast<Morph>(pick(random, 0, 2));
    if (now()) c.morph_s = std::pow(10.0, uniform(random, -2, 1));
    if (now()) c.offscreen_factor = pick(random, 0, 1) ? 1 : uniform(random, 1, 20);
    if (now()) s.pages = static_cast<std::uint32_t>(pick(random, 0, 16));
    if (now()) s.tests = pick(random, 0, 2) ? 1u << 16 : static_cast<std::uint32_t>(pick(random, 0, 99));
    if (now()) s.lookahead_s = pick(random, 0, 1) ? 0.5 : 0;
    c.now_s = s.now_s += uniform(random, 0, 0.1);
}

void change_views(Random& random, const Terrain& terrain, std::vector<View>& views) {
    if (pick(random, 0, 5) == 0) views.resize(static_cast<std::size_t>(pick(random, 1, 3)), views[0]);
    for (View& view : views) {
        if (pick(random, 0, 3) == 0) view = moved(random, view, random_step_m(random, terrain));
        if (pick(random, 0, 9) == 0) view = random_view(random, terrain);
        if (pick(random, 0, 5) == 0) view.max_error_px = pick(random, 0, 1) ? 0 : random_threshold(random);
    }
}

// The largest error that a view shows, in units of what the report claims: a view's own threshold scales it.
double shown_px(const Terrain& full, Cut& cut, std::span<const View> views, const CutSettings& settings) {
    CutMesh live = cut_mesh(cut.cut);
    const std::vector<MeshVertex> drawn = drawn_vertices(full, live);
    live.mesh.vertices = drawn;
    double most = 0;
    for (const View& view : views) {
        const Frustum frustum = make_frustum(view);
        const double px = measure_error(full, live.mesh, view, &frustum).max_px;
        most = std::max(most, view.max_error_px > 0 ? px * settings.max_error_px / view.max_error_px : px);
    }
    return most;
}

} // namespace

TEST_CASE("vertices that have arrived stay where they are when morphing takes longer, or stops and starts again") {
    Random random(392);
    const auto pack = bake_and_load(random_dem(random, 257, 257, Shape::fractal), small_bake(7));
    struct Way {
        double first_s, then_s;
        int none_until; // frames from 21 on without morphing
    };
    for (const Way& way : {Way{1, 1, 23}, Way{0.05, 10, 0}, Way{1, 10, 70}}) {
        Cut cut(pack.terrain, ample_cut(pack.terrain));
        CutSettings settings{.max_error_px = 1};
        double worst_px = 0;
        std::uint32_t morphed = 0;
        std::vector<bool> arrived(257 * 257);
        for (int frame = 0; frame < 120; ++frame) {
            const double x = pack.terrain.extent_x_m() * (0.9 - 0.05 * std::clamp(frame - 10, 0, 10));
            const View view = make_view({x, pack.terrain.header().max_m + 20.0, pack.terrain.extent_z_m() / 2},
                                        {-.5, -.6, .1}, {0, 1, 0}, 1, 1280, 720, 1, 1e6);
            settings.morph = frame >= 21 && frame < way.none_until ? Morph::none : Morph::time;
            settings.morph_s = frame < 62 ? way.first_s : way.then_s;
            settings.now_s = frame / 64.0;
            const CutReport report = cut.update({&view, 1}, settings);
            morphed += report.morphing != 0;
            if (frame <= 21) continue;
            const CutMesh live = cut_mesh(cut.cut);
            const std::vector<MeshVertex> drawn = drawn_vertices(pack.terrain, live);
            for (const TileRange& tile : live.mesh.tiles)
                for (std::uint32_t k = tile.first_index; k < tile.first_index + tile.index_count; ++k) {
                    const MeshVertex& v = live.mesh.vertices[live.mesh.indices[k]];
                    const auto place = static_cast<std::size_t>(v.row * 257 + v.column);
                    if (report.morphing == 0) arrived[place] = true;
                    if (!arrived[place]) continue; // activated since
                    const Vec3 at{pack.terrain.x_m(v.column), v.height_m, pack.terrain.z_m(v.row)};
                    worst_px = std::max(worst_px, std::abs(drawn[live.mesh.indices[k]].height_m - v.height_m) *
                                                      focal_length_px(view) / length(at - view.eye_m));
                }
        }
        CAPTURE(way.first_s, way.then_s, way.none_until, worst_px);
        CHECK(morphed > 5);
        CHECK(worst_px <= 1.001); // by distance a vertex may be on its way, within the threshold
    }
}

TEST_CASE("a report holds in the frame in which settings, budgets, views, thresholds or modes change") {
    Random random(391);
    std::size_t frames = 0, close = 0, converged = 0, rebuilt = 0, raised = 0, missing = 0;
    for (int round = 0; round < rounds(24, 200); ++round) {
        const auto pack = streamed_terrain(random, pick(random, 0, 3) == 0);
        CutBudget budget = ample_cut(pack.terrain, 3);
        if (pick(random, 0, 1) == 0)
            budget.vertices = 4 * pack.terrain.tile_count() + static_cast<std::uint32_t>(pick(random, 40, 2000));
        const auto tiles = static_cast<int>(pack.terrain.tile_count()),
                   all = static_cast<int>(pack.terrain.page_count());
        const auto slots = static_cast<std::uint32_t>(pick(random, std::min(tiles + 2, all), all));
        Streamed on(pack.pack, budget, slots, {});
        ScriptedClient client(random, on, {.most_delay = pick(random, 0, 3)});
        std::vector<View> views{random_view(random, pack.terrain)};
        CutSettings settings;
        settings.max_error_px = random_threshold(random);
        StreamSettings streaming;
        for (int frame = 0; frame < 30; ++frame) {
            change_some(random, settings, streaming);
            change_views(random, pack.terrain, views);
            client.act();
            (void)on.update(views, settings, streaming);
            client.follow();
            const bool rebuild = pick(random, 0, 7) == 0;
            const CutReport r = rebuild ? on.cut.rebuild(views, settings) : on.cut.update(views, settings);
            const double px = shown_px(pack.terrain, on.cut, views, settings);
            CAPTURE(round, frame, rebuild, settings.max_error_px, settings.morph, settings.morph_s, settings.now_s,
                    r.waiting, r.morphing, r.threshold_px, r.error_bound_px, r.converged, on.paged.terrain.missing_px(),
                    px);
            if (r.error_bound_px < unbounded_px) REQUIRE(px <= r.error_bound_px * (1 + 1e-6));
            if (r.converged) REQUIRE(r.error_bound_px == settings.max_error_px);
            ++frames;
            close += px > r.error_bound_px / 2;
            converged += r.converged;
            rebuilt += rebuild;
            raised += r.threshold_px > r.error_px_requested;
            missing += on.paged.terrain.missing_px() > 0;
        }
    }
    CAPTURE(frames, close, converged, rebuilt, raised, missing);
    CHECK(close > frames / 50);
    CHECK(converged > frames / 50);
    CHECK(raised > frames / 50);
    CHECK(missing > frames / 10);
    CHECK(rebuilt > frames / 20);
}
