// Several views on one cut, and a cut that hesitates.
#include <catch2/catch.hpp>

#include "support/cut_scene.h"

using namespace fjell;
using namespace fjell::test;

namespace {

std::vector<View> random_views(Random& random, const Terrain& terrain, int count) {
    std::vector<View> views;
    while (count-- > 0) views.push_back(random_view(random, terrain));
    return views;
}

} // namespace

TEST_CASE("of several views, each gets what it wants: at rest the cut is the target of them all") {
    Random random(111);
    std::uint64_t more = 0;
    for (int round = 0; round < 50; ++round) {
        const auto pack = random_terrain(random, 100, 6);
        const Terrain& terrain = pack.terrain;
        Cut cut(terrain, ample_cut(terrain, max_cut_views));
        std::vector<View> views = random_views(random, terrain, pick(random, 1, 8));
        CutSettings settings;
        settings.max_error_px = random_threshold(random);
        for (int frame = 0; frame < 14; ++frame) {
            switch (pick(random, 0, 5)) {
            case 0: // views come or go, anywhere in the list
                views = random_views(random, terrain, pick(random, 1, 8));
                break;
            case 1:
                if (views.size() < max_cut_views)
                    views.insert(views.begin() + pick(random, 0, static_cast<int>(views.size())),
                                 random_view(random, terrain));
                break;
            case 2:
                if (views.size() > 1) views.erase(views.begin() + pick(random, 0, static_cast<int>(views.size()) - 1));
                break;
            case 3: std::reverse(views.begin(), views.end()); break; // the same eyes in other places
            default:
                for (View& view : views) view = moved(random, view, random_step_m(random, terrain));
            }
            if (pick(random, 0, 5) == 0) settings.max_error_px = random_threshold(random);
            const bool limited = pick(random, 0, 2) == 0;
            settings.max_work = limited ? static_cast<std::uint32_t>(pick(random, 0, 500)) : unlimited_work;
            const CutReport report = cut.update(views, settings);
            CAPTURE(round, frame, views.size(), settings.max_error_px, settings.max_work);
            REQUIRE(check_frame(cut, terrain, report, settings) == "");
            if (limited) continue;
            REQUIRE(report.converged);
            const VertexSet target = target_set(terrain, terrain, views, settings.max_error_px);
            REQUIRE(difference(active_set(cut), target) == "");
            more += target != target_set(terrain, terrain, {views.data(), 1}, settings.max_error_px);
        }
    }
    REQUIRE(more > 100); // that the others count is seen
}

TEST_CASE("more views than the budget says are refused by name, and nothing changes") {
    Random random(112);
    const auto pack = rich_terrain(random, 65, 5);
    Cut cut(pack.terrain, ample_cut(pack.terrain, 2));
    const std::vector<View> views = random_views(random, pack.terrain, 3);
    CutSettings settings;
    (void)cut.update({views.data(), 2}, settings);
    const auto before = triangles_of(cut.mesh());
    CutReport report;
    for (const std::span<const View> wrong : {std::span<const View>(views), std::span<const View>()}) {
        const Status refused = update_cut(cut.cut, wrong, settings, report);
        REQUIRE(refused.code == StatusCode::out_of_range);
        REQUIRE(std::string(refused.field) == "views (1 to CutBudget::views)");
        REQUIRE((triangles_of(cut.mesh()) == before));
        REQUIRE(check_cut(cut) == "");
    }
}

TEST_CASE("with hysteresis the cut rests between the two targets, changes nothing at rest and goes both ways") {
    Random random(113);
    std::uint64_t hesitated = 0;
    for (int round = 0; round < 50; ++round) {
        const auto pack = random_terrain(random, 110, 6);
        const Terrain& terrain = pack.terrain;
        Cut cut(terrain, ample_cut(terrain, 2));
        std::vector<View> views = random_views(random, terrain, pick(random, 1, 2));
        CutSettings settings;
        settings.max_error_px = random_threshold(random);
        settings.hysteresis = std::pow(10.0, uniform(random, -2, 1));
        VertexSet first;
        for (int frame = 0; frame < 12; ++frame) {
            switch (pick(random, 0, 5)) {
            case 0: settings.max_error_px = random_threshold(random); break;
            case 1: settings.hysteresis = pick(random, 0, 2) ? std::pow(10.0, uniform(random, -2, 1)) : 0; break;
            default:
                for (View& view : views) view = moved(random, view, random_step_m(random, terrain));
            }
            settings.max_work = pick(random, 0, 2) ? unlimited_work : 3000;
            CutReport report = cut.update(views, settings);
            CAPTURE(round, frame, settings.max_error_px, settings.hysteresis);
            REQUIRE(check_frame(cut, terrain, report, settings) == "");
            report = settle(cut, views, settings, 500);
            REQUIRE(report.converged);
            const VertexSet now = active_set(cut), least = target_set(terrain, terrain, views, settings.max_error_px),
                            most =
                                target_set(terrain, terrain, views, settings.max_error_px / (1 + settings.hysteresis));
            REQUIRE(contains(now, least));
            REQUIRE(contains(most, now));
            if (settings.hysteresis == 0) REQUIRE(difference(now, least) == "");
            hesitated += now != least && now != most;
            for (int rest = 0; rest < 3; ++rest) REQUIRE(cut.update(views, settings).work == 0);
        }
        // There and back within half of what the hysteresis spans: of what came up none goes. What is looked at on the
        // way back comes up before it must, once.
        settings.max_work = unlimited_work;
        settings.hysteresis = 1;
        const double requested_px = settings.max_error_px;
        (void)settle(cut, views, settings);
        for (int turn = 0; turn < 3; ++turn) {
            settings.max_error_px = requested_px * 1.2;
            const CutReport up = cut.update(views, settings);
            REQUIRE(up.activations == 0);
            settings.max_error_px = requested_px;
            const CutReport back = cut.update(views, settings);
            REQUIRE(back.deactivations == 0);
            if (turn > 0) REQUIRE(back.activations == 0);
            REQUIRE(contains(active_set(cut), target_set(terrain, terrain, views, requested_px)));
        }
    }
    REQUIRE(hesitated > 20);
}
