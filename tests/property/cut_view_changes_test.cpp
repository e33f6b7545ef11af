// Views that come, go and change places: only how far they are from those that stay may make work, and the cut stays
// exact however often they do.
#include <catch2/catch.hpp>

#include "shared/terrain_data.h"
#include "support/cut_scene.h"
#include "support/rounds.h"

using namespace fjell;
using namespace fjell::test;

namespace {

// As if the cut had flown so far. Nothing may be scheduled yet: it has to be new.
void set_odometers(CutState& s, double ticks) {
    for (double& odometer_m : s.work.schedule.odometer_m) odometer_m = ticks * s.work.schedule.tick_m;
}

// Of a cut that has just seen new views and done nothing about them.
std::uint32_t due_groups(const Schedule& s) {
    std::uint32_t due = 0;
    for (std::uint32_t slot = 0; slot < s.slot_count; ++slot) {
        const PageSchedule& page = s.pages[slot];
        if (!is_due(s, slot)) continue;
        std::uint16_t ticks[page_ticks];
        std::copy_n(s.ticks + std::size_t{slot} * page_ticks, page_ticks, ticks);
        const double gone = std::floor((odometer_m(s, page) - page.charged_m) / tick_m(s, page));
        scalar_ticks.charge(ticks, static_cast<std::uint16_t>(std::clamp(gone, 0.0, double{most_ticks})));
        due += static_cast<std::uint32_t>(std::count(ticks, ticks + page_ticks, spent));
    }
    return due;
}

View far_view(const Terrain& terrain) { // farther than any slack is counted
    return view_from_above(terrain, 5e7 / std::max(terrain.extent_x_m(), terrain.extent_z_m()));
}

// One change of what the views are.
void change_views(Random& random, const Terrain& terrain, std::vector<View>& views) {
    const auto any = [&] { return static_cast<std::size_t>(pick(random, 0, static_cast<int>(views.size()) - 1)); };
    const auto add = [&](View view) {
        if (views.size() == max_cut_views) views.erase(views.begin() + pick(random, 0, max_cut_views - 1));
        views.insert(views.begin() + pick(random, 0, static_cast<int>(views.size())), view);
    };
    switch (pick(random, 0, 9)) {
    case 0: return add(random_view(random, terrain));
    case 1: return add(views[any()]); // an equal one
    case 2: return add(moved(random, views[any()], random_step_m(random, terrain)));
    case 3:
    case 4:
        if (views.size() > 1) views.erase(views.begin() + static_cast<int>(any()));
        return;
    case 5: return std::swap(views[any()], views[any()]);
    case 6: return std::shuffle(views.begin(), views.end(), random);
    case 7: {
        View& view = views[any()];
        view.max_error_px = pick(random, 0, 2) ? random_threshold(random) : 0;
        return;
    }
    case 8:
        if (pick(random, 0, 9) == 0) return add(far_view(terrain));
        [[fallthrough]];
    default: {
        View& view = views[any()];
        view = moved(random, view, random_step_m(random, terrain));
    }
    }
}

CutBudget some_budget(const Terrain& terrain) {
    return ample_cut(terrain, max_cut_views);
}

} // namespace

TEST_CASE("views come, go and change places a million times, and the cut stays exact") {
    Random random(121);
    const int terrains = rounds(8, 40), changes = rounds(1250, 25'000), stretch = rounds(50, 250);
    std::uint64_t lagging = 0, rewound = 0, alone = 0;
    for (int round = 0; round < terrains; ++round) {
        const auto pack = random_terrain(random, 40, 5);
        const Terrain& terrain = pack.terrain;
        Cut cut(terrain, some_budget(terrain));
        // Odometers lose nothing where they begin again, nor far beyond.
        constexpr double starts[] = {0, rewind_ticks - 1000, 0x1p48 - 1000};
        set_odometers(cut.state(), starts[round % 3]);
        std::vector<View> views{random_view(random, terrain)};
        CutSettings settings;
        settings.max_error_px = random_threshold(random);
        for (int change = 0; change < changes; ++change) {
            change_views(random, terrain, views);
            settings.max_work = static_cast<std::uint32_t>(pick(random, 0, 60));
            const double before = cut.state().work.schedule.odometer_m[0];
            const bool rebuilds = pick(random, 0, 299) == 0;
            const CutReport report = rebuilds ? cut.rebuild(views, settings) : cut.update(views, settings);
            rewound += cut.state().work.schedule.odometer_m[0] < before;
            lagging += !report.converged;
            if (change % stretch != stretch - 1) continue;
            CAPTURE(round, change, views.size(), settings.max_error_px);
            if (!rebuilds) REQUIRE(check_frame(cut, terrain, report, settings) == "");
            if (pick(random, 0, 2) == 0) views.resize(1);
            settings.max_work = 1000;
            REQUIRE(settle(cut, views, settings, 1000).converged);
            REQUIRE(check_cut(cut) == "");
            REQUIRE(difference(active_set(cut), target_set(terrain, terrain, views, settings.max_error_px)) == "");
            if (views.size() > 1) continue;
            REQUIRE((triangles_of(cut.mesh()) == recursive_triangles(terrain, views[0], settings.max_error_px)));
            ++alone;
        }
    }
    REQUIRE(lagging > static_cast<std::uint64_t>(terrains) * static_cast<std::uint64_t>(changes) / 20);
    REQUIRE(rewound > static_cast<std::uint64_t>(terrains) / 2);
    REQUIRE(alone > 10);
}

TEST_CASE("a cut built anew in the middle of changes has nothing in a queue that is gone") {
    Random random(123);
    std::uint64_t let_go = 0; // groups that wait, beside the root's, in root pages where nothing is active any more
    for (int round = 0; round < rounds(250, 2500); ++round) {
        const auto pack = random_terrain(random, 40, 5);
        const Terrain& terrain = pack.terrain;
        Cut cut(terrain, some_budget(terrain));
        std::vector<View> views{random_view(random, terrain)};
        CutSettings settings;
        settings.max_error_px = random_threshold(random);
        for (int change = 0; change < 200; ++change) {
            change_views(random, terrain, views);
            settings.max_work = static_cast<std::uint32_t>(pick(random, 0, 60));
            if (pick(random, 0, 9) != 0) {
                (void)cut.update(views, settings);
                continue;
            }
            const CutState& s = cut.state();
            for (std::uint32_t slot = 0; slot < s.pages.fresh; ++slot) {
                const PageState& page = s.pages.state[slot];
                if (page.page == no_index || page.shape != 0 || page.active != 0) continue;
                const GroupState* const groups = s.pages.groups + std::size_t{slot} * max_page_groups;
                const std::uint32_t root = s.pages.grid.steps[data_of(terrain).tree.tile_log2 - 1].centres;
                for (std::uint32_t n = 0; n < s.pages.grid.shapes[0].count; ++n)
                    let_go += n != root && groups[n].queue != unqueued;
            }
            (void)cut.rebuild(views, settings);
            CAPTURE(round, change, views.size(), settings.max_error_px);
            REQUIRE(check_cut(cut) == "");
        }
    }
    CHECK(let_go >= rounds<std::uint64_t>(0, 10)); // rare: compilers draw different views from the same numbers
}

TEST_CASE("with hysteresis too, views that come, go and change places leave every page due in time") {
    Random random(122);
    for (int round = 0; round < rounds(10, 60); ++round) {
        const auto pack = random_terrain(random, 60, 5);
        const Terrain& terrain = pack.terrain;
        Cut cut(terrain, some_budget(terrain));
        std::vector<View> views{random_view(random, terrain)};
        CutSettings settings;
        settings.max_error_px = random_threshold(random);
        for (int change = 0; change < 60; ++change) {
            change_views(random, terrain, views);
            if (pick(random, 0, 9) == 0)
                settings.hysteresis = pick(random, 0, 2) ? std::pow(10.0, uniform(random, -2, 1)) : 0;
            settings.corner_safe = pick(random, 0, 9) == 0;
            settings.max_work = pick(random, 0, 1) ? unlimited_work : 50;
            const CutReport report = cut.update(views, settings);
            CAPTURE(round, change, views.size(), settings.max_error_px, settings.hysteresis);
            REQUIRE(check_frame(cut, terrain, report, settings) == "");
            if (!report.converged) continue;
            const VertexSet now = active_set(cut);
            const double over = 1 + settings.hysteresis;
            REQUIRE(contains(now, target_set(terrain, terrain, views, settings.max_error_px, settings.corner_safe)));
            REQUIRE(contains(target_set(terrain, terrain, thresholds_over(over, views), settings.max_error_px / over,
                                        settings.corner_safe),
                             now));
        }
    }
}

TEST_CASE("a view beside an equal or a finer one, one that goes from it, and views that change places visit no group") {
    Random random(123);
    const auto pack = rich_terrain(random, 257, 7);
    const Terrain& terrain = pack.terrain;
    for (const Morph morph : {Morph::none, Morph::error}) {
        Cut cut(terrain, ample_cut(terrain, max_cut_views));
        CutSettings settings;
        settings.morph = morph;
        settings.hysteresis = morph == Morph::none ? 0 : 0.2;
        View a = random_view(random, terrain), b = random_view(random, terrain), c = random_view(random, terrain);
        b.max_error_px = 3;
        const auto visits = [&](std::vector<View> views) {
            const CutReport report = cut.update(views, settings);
            REQUIRE(report.converged);
            REQUIRE(report.work == report.visits);
            return report.visits;
        };
        REQUIRE(cut.update(std::vector<View>{a}, settings).visits > 0);
        CHECK(visits({a, a}) == 0);
        CHECK(visits({a, a, a, a, a, a, a, a}) == 0);
        CHECK(visits({a}) == 0);
        View coarse = a; // wants less than its neighbour does
        coarse.max_error_px = 4 * settings.max_error_px;
        CHECK(visits({a, coarse}) == 0);
        CHECK(visits({coarse, a, a}) == 0);
        CHECK(visits({a}) == 0);
        REQUIRE(cut.update(std::vector<View>{a, b, c}, settings).visits > 0);
        CHECK(visits({c, b, a}) == 0);
        CHECK(visits({b, a, b, c}) == 0);
        CHECK(visits({c, a, b}) == 0);
        View turned = a; // sees other things, wants the same
        turned.forward = a.forward * -1;
        CHECK(visits({turned, b, c}) == 0);
        CHECK(visits({a, turned, b, c}) == 0);
        REQUIRE(cut.update(std::vector<View>{a, c}, settings).visits > 0);
    }
}

// Without items nothing is visited, and what waits is what is due.
TEST_CASE("a view that comes or goes makes as many groups due as one that moves between it and the nearest other one") {
    Random random(124);
    const auto pack = rich_terrain(random, 257, 7);
    const Terrain& terrain = pack.terrain;
    CutSettings settings, no_items;
    no_items.max_work = 0;
    int few = 0;
    for (int round = 0; round < rounds(20, 200); ++round) {
        const View a = random_view(random, terrain), b = random_view(random, terrain);
        View near = moved(random, a, random_step_m(random, terrain) / 10);
        if (pick(random, 0, 1)) near.max_error_px = settings.max_error_px * uniform(random, 0.9, 1.1);
        const auto due = [&](std::vector<View> before, std::vector<View> after) {
            Cut cut(terrain, ample_cut(terrain, max_cut_views));
            REQUIRE(settle(cut, before, settings).converged);
            const CutReport report = cut.update(after, no_items);
            REQUIRE(report.visits == 0);
            REQUIRE(report.waiting == cut.state().work.schedule.due_count);
            return due_groups(cut.state().work.schedule);
        };
        const std::uint32_t move = due({a}, {near}), all = due({a}, {far_view(terrain)});
        CAPTURE(round, move, all);
        // One that comes only adds: where it is the coarser one, its threshold costs nothing.
        const std::uint32_t come = due({a}, {a, near});
        if (near.max_error_px <= settings.max_error_px)
            CHECK(come == move);
        else
            CHECK(come <= move);
        CHECK(due({a}, {near, a, near}) == come);
        const std::uint32_t with_b = due({a, b}, {near, b});
        CHECK(due({a, b}, {b, near}) == with_b);
        CHECK(due({b, a}, {b, near, a}) <= with_b);
        CHECK(due({a, near}, {a}) == due({a, near}, {a, a}));
        few += move * 10 < all;
    }
    CHECK(few > rounds(8, 80));
}
