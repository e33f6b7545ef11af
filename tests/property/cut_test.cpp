// invariants 1, 4, 6 and 7 on the live cut: random terrains, views, thresholds and item limits.
#include <catch2/catch.hpp>

#include "fjell/measure.h"
#include "shared/terrain_data.h"
#include "support/cut_scene.h"
#include "support/rounds.h"

using namespace fjell;
using namespace fjell::test;

namespace {

// As for the recursive method: the threshold, and nothing else; float rounding is inside the decision's own margin.
bool within(double measured_px, double threshold_px) {
    return measured_px <= threshold_px * (1 + 1e-9);
}

} // namespace

TEST_CASE("at rest the live cut is the recursive method's mesh, triangle for triangle") {
    Random random(101);
    for (int round = 0; round < rounds(30, 120); ++round) {
        const auto pack = random_terrain(random, round % 10 == 9 ? 300 : 140, round % 10 == 9 ? 8 : 6);
        const Terrain& terrain = pack.terrain;
        Cut cut(terrain, ample_cut(terrain));
        View view = random_view(random, terrain);
        CutSettings settings;
        settings.max_error_px = random_threshold(random);
        for (int frame = 0; frame < 12; ++frame) {
            switch (pick(random, 0, 5)) {
            case 0: view = random_view(random, terrain); break;
            case 1: settings.max_error_px = random_threshold(random); break;
            default: view = moved(random, view, random_step_m(random, terrain));
            }
            const CutReport report = cut.update({&view, 1}, settings);
            CAPTURE(round, frame, settings.max_error_px, data_of(terrain).tree.tile_log2,
                    data_of(terrain).tree.columns(), data_of(terrain).tree.rows());
            REQUIRE(check_frame(cut, terrain, report, settings) == "");
            REQUIRE(report.converged);
            REQUIRE((triangles_of(cut.mesh()) == recursive_triangles(terrain, view, settings.max_error_px)));
        }
    }
}

// A frame that begins at rest goes page by page; one that begins with work left over evaluates more before it changes.
TEST_CASE("groups that are changed page by page come to the same mesh as those that are changed worst first") {
    Random random(134);
    int at_once = 0, lagged = 0;
    for (int round = 0; round < rounds(12, 60); ++round) {
        const auto pack = random_terrain(random, 300, 8);
        const Terrain& terrain = pack.terrain;
        Cut free(terrain, ample_cut(terrain)), replayed(terrain, ample_cut(terrain)),
            queued(terrain, ample_cut(terrain));
        View view = random_view(random, terrain);
        CutSettings settings;
        settings.max_error_px = random_threshold(random);
        for (int frame = 0; frame < 12; ++frame) {
            view = moved(random, view, random_step_m(random, terrain));
            const CutReport report = free.update({&view, 1}, settings);
            const std::uint32_t changes = report.activations + report.deactivations;
            at_once += report.visits != unlimited_work && changes != 0;
            CAPTURE(round, frame, settings.max_error_px);
            REQUIRE(check_frame(free, terrain, report, settings) == "");
            CutSettings limited = settings;
            limited.visits = report.visits;
            const CutReport again = replayed.update({&view, 1}, limited);
            CHECK(again.visits == report.visits);
            CHECK(again.activations + again.deactivations == changes);
            CHECK(std::ranges::equal(free.mesh().indices, replayed.mesh().indices));
            limited = settings;
            limited.max_work = 40;
            CutReport other = queued.update({&view, 1}, limited);
            lagged += !other.converged;
            while (!other.converged && other.waiting != 0) {
                REQUIRE(other.work <= limited.max_work);
                REQUIRE(check_frame(queued, terrain, other, limited) == "");
                other = queued.update({&view, 1}, limited);
            }
            if (!report.converged) continue;
            CHECK(triangles_of(free.mesh()) == triangles_of(queued.mesh()));
        }
    }
    CHECK(at_once > 20);
    CHECK(lagged > 20);
}

// What time ends while it goes page by page is replayed by its visits, as visits that end it are.
TEST_CASE("a frame whose visits end it page by page is the first part of the one that they do not end") {
    Random random(135);
    int ended = 0;
    for (int round = 0; round < rounds(16, 60); ++round) {
        const auto pack = random_terrain(random, 300, 8);
        const Terrain& terrain = pack.terrain;
        Cut first(terrain, ample_cut(terrain)), second(terrain, ample_cut(terrain));
        View view = random_view(random, terrain);
        CutSettings settings;
        settings.max_error_px = random_threshold(random);
        (void)first.rebuild({&view, 1}, settings);
        (void)second.rebuild({&view, 1}, settings);
        for (int frame = 0; frame < 12; ++frame) {
            view = moved(random, view, random_step_m(random, terrain) / 8);
            CAPTURE(round, frame, settings.max_error_px);
            settings.visits = static_cast<std::uint32_t>(pick(random, 1, 20));
            const CutReport report = first.update({&view, 1}, settings);
            REQUIRE(report.visits <= settings.visits);
            REQUIRE(check_frame(first, terrain, report, settings) == "");
            ended += report.waiting != 0;
            const CutReport again = second.update({&view, 1}, settings);
            REQUIRE(again.visits == report.visits);
            REQUIRE(again.error_bound_px == report.error_bound_px);
            REQUIRE(std::ranges::equal(first.mesh().indices, second.mesh().indices));
            settings.visits = unlimited_work - 1;
            for (int more = 0; more < 3; ++more) {
                (void)first.update({&view, 1}, settings);
                (void)second.update({&view, 1}, settings);
            }
        }
    }
    CHECK(ended > 20);
}

// Looking at its block again is part of an activation: one item does one of them.
TEST_CASE("with one item a frame every single step is a whole mesh, and the steps lead to the recursive one's") {
    Random random(102);
    std::uint64_t steps = 0;
    for (int round = 0; round < rounds(8, 24); ++round) {
        const auto pack = random_terrain(random, 24, 4);
        const Terrain& terrain = pack.terrain;
        Cut cut(terrain, ample_cut(terrain));
        const View view = random_view(random, terrain); // one that jumps would have its mesh built beside
        CutSettings settings;
        settings.max_error_px = random_threshold(random) * 30;
        (void)cut.rebuild({&view, 1}, settings);
        for (int leg = 0; leg < 3; ++leg) {
            settings.max_error_px = random_threshold(random) * 3;
            settings.max_work = 1;
            CutReport report;
            int frame = 0;
            for (; frame < 20'000 && !report.converged; ++frame) {
                report = cut.update({&view, 1}, settings);
                CAPTURE(round, leg, frame, settings.max_error_px);
                const std::string wrong = check_frame(cut, terrain, report, settings);
                if (!wrong.empty()) REQUIRE(wrong == "");
                REQUIRE(report.activations + report.deactivations <= 1);
                if (!report.converged) REQUIRE((report.exhausted == cut_budget_work));
                steps += report.activations + report.deactivations;
            }
            CAPTURE(round, leg, frame, report.waiting);
            REQUIRE(report.converged);
            REQUIRE((triangles_of(cut.mesh()) == recursive_triangles(terrain, view, settings.max_error_px)));
        }
    }
    REQUIRE(steps > rounds<std::size_t>(600, 2'000));
}

TEST_CASE("one item a frame is enough to arrive") {
    Random random(103);
    for (int round = 0; round < 6; ++round) {
        const auto pack = random_terrain(random, 24, 4);
        Cut cut(pack.terrain, ample_cut(pack.terrain));
        const View view = random_view(random, pack.terrain);
        CutSettings settings;
        settings.max_error_px = random_threshold(random);
        settings.max_work = 1;
        const CutReport report = settle(cut, {&view, 1}, settings, 50'000);
        CAPTURE(round, report.waiting, report.vertices);
        REQUIRE(report.converged);
        REQUIRE((triangles_of(cut.mesh()) == recursive_triangles(pack.terrain, view, settings.max_error_px)));
    }
}

TEST_CASE(
    "teleports, thresholds, lenses and item limits at random never break the mesh, and at rest it is the target") {
    Random random(104);
    std::uint64_t lagging = 0;
    for (int round = 0; round < rounds(12, 50); ++round) {
        const auto pack = random_terrain(random, round % 10 == 9 ? 260 : 90, round % 10 == 9 ? 8 : 6);
        const Terrain& terrain = pack.terrain;
        Cut cut(terrain, ample_cut(terrain));
        View view = random_view(random, terrain);
        CutSettings settings;
        settings.max_error_px = random_threshold(random);
        for (int leg = 0; leg < 2; ++leg) {
            for (int frame = 0; frame < 24; ++frame) {
                switch (pick(random, 0, 7)) {
                case 0: view = random_view(random, terrain); break;
                case 1: settings.max_error_px = random_threshold(random); break;
                case 2: // another lens, the same place
                    view = make_view(view.eye_m, view.forward, view.up, uniform(random, 0.1, 2.5),
                                     static_cast<std::uint32_t>(pick(random, 1, 4000)),
                                     static_cast<std::uint32_t>(pick(random, 1, 4000)), view.near_m, view.far_m);
                    break;
                case 3: settings.corner_safe = !settings.corner_safe; break;
                case 4: break;
                default: view = moved(random, view, random_step_m(random, terrain));
                }
                settings.max_work = pick(random, 0, 5) == 0
                                        ? unlimited_work
                                        : static_cast<std::uint32_t>(std::pow(10.0, uniform(random, 0, 4))) - 1;
                const CutReport report = cut.update({&view, 1}, settings);
                CAPTURE(round, leg, frame, settings.max_error_px, settings.max_work);
                REQUIRE(check_frame(cut, terrain, report, settings) == "");
                REQUIRE((report.exhausted & ~cut_budget_work) == 0);
                if (!report.converged) REQUIRE(report.exhausted == cut_budget_work);
                lagging += !report.converged;
            }
            settings.max_work = 2000;
            const CutReport report = settle(cut, {&view, 1}, settings, 2000);
            CAPTURE(round, leg, settings.max_error_px, settings.corner_safe);
            REQUIRE(report.converged);
            REQUIRE(difference(active_set(cut), target_set(terrain, terrain, {&view, 1}, settings.max_error_px,
                                                           settings.corner_safe)) == "");
            REQUIRE((triangles_of(cut.mesh()) ==
                     recursive_triangles(terrain, view, settings.max_error_px, settings.corner_safe)));
            // And then nothing is done any more.
            const CutReport rest = cut.update({&view, 1}, settings);
            REQUIRE(rest.work == 0);
            REQUIRE(rest.vertices_changed + rest.triangles_changed == 0);
        }
    }
    REQUIRE(lagging > rounds<std::size_t>(120, 500));
}

TEST_CASE("a frame that reports converged keeps the screen bound, with its corners too when asked") {
    Random random(105);
    double closest = 0;
    for (int round = 0; round < rounds(15, 60); ++round) {
        const auto pack = random_terrain(random, 140, 6);
        const Terrain& terrain = pack.terrain;
        if (terrain.header().estimate != ErrorEstimate::max) continue;
        Cut cut(terrain, ample_cut(terrain));
        CutSettings settings;
        View view = random_view(random, terrain);
        for (int frame = 0; frame < 8; ++frame) {
            view =
                pick(random, 0, 3) ? moved(random, view, random_step_m(random, terrain)) : random_view(random, terrain);
            settings.max_error_px = random_threshold(random);
            settings.corner_safe = pick(random, 0, 1) == 1;
            settings.max_work = pick(random, 0, 1) ? unlimited_work : 5000;
            if (!cut.update({&view, 1}, settings).converged) continue;
            const double bound_px = settings.max_error_px / (settings.corner_safe ? corner_factor(view) : 1);
            const MeasuredError error = measure_error(terrain, cut.mesh(), view);
            CAPTURE(round, frame, settings.max_error_px, settings.corner_safe, error.max_px);
            REQUIRE(within(error.max_px, bound_px));
            closest = std::max(closest, error.max_px / bound_px);
        }
    }
    REQUIRE(closest > 0.5); // the bound is not kept by drawing everything
}
