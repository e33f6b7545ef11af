// Whatever a host does to a live cut, in whatever order: every frame holds what any must, and at rest it is the cut
// that one built from nothing is.
#include <catch2/catch.hpp>

#include "support/paging_host.h"
#include "support/rounds.h"

using namespace fjell;
using namespace fjell::test;

namespace {

// Jobs one after the other, the last one first.
void run_backwards(void*, std::uint32_t count, void (*job)(void*, std::uint32_t), void* data) {
    for (std::uint32_t index = count; index-- != 0;) job(data, index);
}

struct Met {
    int built_beside = 0, rebuilt = 0, kept = 0, incomplete = 0, morphed = 0, blocked = 0, scarce = 0, rested = 0;
};

// What the host asks for, and what it looks at.
struct Wishes {
    Random& random;
    const Terrain& terrain;
    std::vector<View> views;
    CutSettings settings;
    bool may_morph = true;

    [[nodiscard]] std::uint32_t limit(int most) {
        return pick(random, 0, 2) ? unlimited_work : static_cast<std::uint32_t>(pick(random, 0, most));
    }
    void look() {
        for (View& view : views) {
            if (pick(random, 0, 5) == 0) view = random_view(random, terrain);
            view = moved(random, view, random_step_m(random, terrain));
            if (pick(random, 0, 2) == 0) view = turned(random, view, 1);
            if (pick(random, 0, 19) == 0) view.max_error_px = pick(random, 0, 1) ? random_threshold(random) : 0;
        }
        if (views.size() < 3 && pick(random, 0, 14) == 0) views.push_back(random_view(random, terrain));
        if (views.size() > 1 && pick(random, 0, 9) == 0) views.erase(views.begin() + pick(random, 0, 1));
    }
    void set() {
        settings.max_work = limit(120);
        settings.visits = limit(60);
        settings.now_s += pick(random, 0, 9) == 0 ? uniform(random, 0, 20) : 1.0 / 60;
        if (pick(random, 0, 14) == 0) settings.max_error_px = random_threshold(random);
        if (pick(random, 0, 14) == 0) settings.hysteresis = pick(random, 0, 1) ? uniform(random, 0, 1) : 0;
        if (pick(random, 0, 14) == 0) settings.corner_safe = !settings.corner_safe;
        if (pick(random, 0, 14) == 0) settings.offscreen_factor = pick(random, 0, 1) ? uniform(random, 1, 20) : 1;
        if (pick(random, 0, 11) == 0) settings.morph = static_cast<Morph>(pick(random, 0, 2));
        if (!may_morph) settings.morph = Morph::none;
        settings.jobs = pick(random, 0, 1) ? JobSystem{&run_backwards, nullptr} : JobSystem{};
    }
    // Nothing that what was before can show in.
    void rest() {
        settings.max_work = settings.visits = unlimited_work;
        settings.hysteresis = 0;
        settings.offscreen_factor = 1;
        settings.morph = Morph::none;
    }
};

// A life of so many frames, then rest: three times.
void live(Random& random, bool large, bool abrupt, Met& met) {
    const auto pack = paged_terrain(random, large);
    TerrainBudget slots;
    if (pick(random, 0, 2) == 0)
        slots.page_slots = static_cast<std::uint32_t>(pick(random, 1, static_cast<int>(pack.terrain.page_count())));
    PagedTerrain paged(pack.pack, slots);
    CutBudget budget = ample_cut(pack.terrain, 2);
    budget.workers = 3;
    budget.views = 3;
    budget.morph = pick(random, 0, 3) != 0;
    const bool scarce = pick(random, 0, 3) == 0;
    if (scarce) budget.vertices = std::max(budget.vertices / 8, pack.terrain.tile_count() * 4 + 100);
    Cut cut(paged.terrain, budget);
    Host host{random, pack.pack, paged.terrain, cut, abrupt, {}, {}};
    host.load_all();
    Wishes wishes{random, pack.terrain, {random_view(random, pack.terrain)}, {}, budget.morph};
    wishes.settings.max_error_px = random_threshold(random);
    for (int leg = 0; leg < 3; ++leg) {
        for (int frame = 0; frame < 20; ++frame) {
            if (pick(random, 0, 2) == 0) host.act();
            if (pick(random, 0, 2) == 0) met.kept += host.keep();
            wishes.look();
            wishes.set();
            const bool rebuild = pick(random, 0, 19) == 0;
            CutSettings& settings = wishes.settings;
            const CutReport report = rebuild ? cut.rebuild(wishes.views, settings) : cut.update(wishes.views, settings);
            CAPTURE(leg, frame, rebuild, settings.max_error_px, settings.max_work, settings.visits, settings.hysteresis,
                    settings.offscreen_factor, static_cast<int>(settings.morph), wishes.views.size());
            CutSettings unlimited = settings;
            unlimited.max_work = unlimited_work;
            REQUIRE(check_frame(cut, pack.terrain, report, rebuild ? unlimited : settings) == "");
            met.built_beside += cut.state().bulk.phase != BulkPhase::idle;
            met.rebuilt += rebuild;
            met.incomplete += paged.terrain.pages_missing() != 0;
            met.morphed += report.morphing != 0;
            met.blocked += report.blocked != 0;
        }
        while (!host.evicting.empty()) (void)host.keep();
        wishes.rest();
        CutReport report;
        for (int frame = 0; frame == 0 || (frame < 60 && report.waiting + report.morphing != 0); ++frame) {
            wishes.settings.now_s += 0.5;
            report = cut.update(wishes.views, wishes.settings);
        }
        CAPTURE(leg, wishes.settings.max_error_px, wishes.views.size(), paged.terrain.pages_missing());
        REQUIRE(check_frame(cut, pack.terrain, report, wishes.settings) == "");
        if (scarce && report.exhausted != 0) { // what is refined to is the governor's way, then
            ++met.scarce;
            continue;
        }
        REQUIRE(report.waiting == 0);
        Cut anew(paged.terrain, budget);
        (void)anew.rebuild(wishes.views, wishes.settings);
        REQUIRE(difference(active_set(cut), active_set(anew)) == "");
        REQUIRE(triangles_of(cut.mesh()) == triangles_of(anew.mesh()));
        ++met.rested;
    }
}

} // namespace

TEST_CASE("whatever a host does, every frame is whole, and at rest the cut is one built from nothing") {
    Random random(131);
    Met met;
    for (int round = 0; round < rounds(40, 400); ++round) {
        CAPTURE(round);
        live(random, round % 8 == 7, round % 3 == 0, met);
    }
    CAPTURE(met.built_beside, met.rebuilt, met.kept, met.incomplete, met.morphed, met.blocked, met.scarce);
    for (const int times : {met.built_beside, met.rebuilt, met.kept, met.incomplete, met.morphed})
        CHECK(times > rounds(40, 400));
    CHECK(met.blocked > rounds(5, 50));
    CHECK(met.scarce > rounds(3, 30));
    CHECK(met.rested > rounds(90, 900));
}
