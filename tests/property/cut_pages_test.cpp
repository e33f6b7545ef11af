// Pages that come and go under a live cut: evicted and waited for, or unloaded without warning.
#include <catch2/catch.hpp>

#include "cut/around.h"
#include "shared/terrain_data.h"
#include "support/paging_host.h"
#include "support/rounds.h"

using namespace fjell;
using namespace fjell::test;

namespace {

// How pages go, and how many states they may have.
struct Way {
    bool abrupt, scarce;
};

// As if the budget were smaller: of small terrains all pages have states.
void make_states_scarce(Random& random, Cut& cut) {
    CutState& s = cut.state();
    REQUIRE((s.pages.idle_count == 0 && s.pages.free_count == 0));
    s.pages.count =
        std::min(s.pages.count, s.pages.grid.terrain->tile_count() + static_cast<std::uint32_t>(pick(random, 1, 16)));
}

void live_with(std::uint32_t seed, const Way& way, int count) {
    Random random(seed);
    std::uint64_t gone = 0, incomplete = 0, refined = 0, spent = 0, enough = 0;
    for (int round = 0; round < count; ++round) {
        const auto pack = paged_terrain(random, way.scarce || round % 8 == 7);
        TerrainBudget slots;
        if (pick(random, 0, 1))
            slots.page_slots = static_cast<std::uint32_t>(pick(random, 1, static_cast<int>(pack.terrain.page_count())));
        PagedTerrain paged(pack.pack, slots);
        Cut cut(paged.terrain, ample_cut(pack.terrain));
        if (way.scarce) make_states_scarce(random, cut);
        Host host{random, pack.pack, paged.terrain, cut, way.abrupt, {}, {}};
        host.load_all();
        View view = random_view(random, pack.terrain);
        CutSettings settings;
        settings.max_error_px = random_threshold(random);
        for (int leg = 0; leg < 3; ++leg) {
            for (int frame = 0; frame < 12; ++frame) {
                host.act();
                if (pick(random, 0, 4) == 0) view = random_view(random, pack.terrain);
                view = moved(random, view, random_step_m(random, pack.terrain));
                settings.max_work =
                    pick(random, 0, 2) ? unlimited_work : static_cast<std::uint32_t>(pick(random, 0, 99));
                settings.visits = pick(random, 0, 1) ? unlimited_work : static_cast<std::uint32_t>(pick(random, 1, 60));
                const CutReport report = cut.update({&view, 1}, settings);
                CAPTURE(round, leg, frame, settings.max_error_px, settings.max_work, paged.terrain.pages_missing());
                REQUIRE(check_frame(cut, pack.terrain, report, settings) == "");
                incomplete += paged.terrain.pages_missing() != 0;
            }
            settings.max_work = settings.visits = unlimited_work;
            CutReport report;
            for (int frame = 0; frame < (way.scarce ? 120 : 4); ++frame) {
                host.collect();
                report = cut.update({&view, 1}, settings);
                if (frame % 16 == 15) REQUIRE(check_frame(cut, pack.terrain, report, settings) == "");
            }
            REQUIRE(host.evicting.empty());
            CAPTURE(round, leg, settings.max_error_px, paged.terrain.pages_missing(),
                    data_of(paged.terrain).slot_count);
            REQUIRE(check_frame(cut, pack.terrain, report, settings) == "");
            // Where states do not suffice the threshold has risen until they did, or as far as it can.
            const bool suffice = !way.scarce || report.exhausted == 0;
            (suffice ? enough : spent) += 1;
            if (way.scarce) REQUIRE((report.exhausted & ~std::uint32_t{cut_budget_vertices}) == 0);
            if (suffice) REQUIRE(report.converged);
            if (report.waiting == 0)
                REQUIRE(difference(active_set(cut),
                                   target_set(pack.terrain, paged.terrain, {&view, 1}, report.threshold_px)) == "");
            refined += report.vertices;
        }
        gone += way.abrupt ? host.unloaded : host.released;
    }
    CAPTURE(gone, incomplete, refined, spent, enough);
    if (way.scarce) REQUIRE(spent > rounds<std::size_t>(1, 12));
    if (way.scarce) REQUIRE(enough > rounds<std::size_t>(1, 12));
    REQUIRE(gone > rounds<std::size_t>(30, 200));
    REQUIRE(incomplete > rounds<std::size_t>(50, 300));
    REQUIRE(refined > rounds<std::size_t>(way.scarce ? 1'500 : 3'000, 20'000));
}

} // namespace

TEST_CASE("pages that are evicted go without a crack, and at rest the cut is the target of what is left") {
    live_with(121, {false, false}, rounds(20, 48));
}

TEST_CASE(
    "what waits for morphing vertices, or for a page that is kept after all, is not forgotten when items run out") {
    Random random(123);
    for (int round = 0; round < rounds(40, 160); ++round) {
        auto pack = paged_terrain(random, false);
        Cut cut(pack.terrain, ample_cut(pack.terrain));
        View view = random_view(random, pack.terrain);
        CutSettings settings;
        settings.max_error_px = random_threshold(random);
        settings.morph = pick(random, 0, 1) ? Morph::error : Morph::time;
        settings.morph_s = 0.05;
        const auto any = [&](std::uint32_t count) {
            return static_cast<std::uint32_t>(pick(random, 0, static_cast<int>(count) - 1));
        };
        std::vector<Page> evicting;
        CutReport report;
        for (int frame = 0; frame < 24; ++frame) {
            evicting.push_back({any(pack.terrain.tile_count()), any(pack.terrain.pages_per_tile())});
            bool released = false;
            REQUIRE(cut_release_page(cut.cut, evicting.back().tile, evicting.back().page, released).ok());
            if (pick(random, 0, 3) == 0) view = random_view(random, pack.terrain);
            settings.max_work = static_cast<std::uint32_t>(pick(random, 0, 30));
            settings.now_s += 1.0 / 60;
            report = cut.update({&view, 1}, settings);
        }
        // At rest, with few items: what is left over when the last vertex has morphed must be tried all the same.
        for (int frame = 0; frame < 90; ++frame) {
            if (frame > 30 && !evicting.empty()) {
                (void)cut_cancel_release(cut.cut, evicting.back().tile, evicting.back().page);
                evicting.pop_back();
            }
            settings.max_work = static_cast<std::uint32_t>(pick(random, 1, frame < 60 ? 300 : 6));
            settings.now_s += 1.0 / 60;
            report = cut.update({&view, 1}, settings);
        }
        REQUIRE(evicting.empty());
        settings.max_work = unlimited_work;
        for (int frame = 0; frame < 90; ++frame) {
            settings.now_s += 1.0 / 60;
            report = cut.update({&view, 1}, settings);
        }
        CAPTURE(round, settings.max_error_px, static_cast<int>(settings.morph), report.waiting, report.morphing);
        REQUIRE(report.converged);
        Cut anew(pack.terrain, ample_cut(pack.terrain));
        REQUIRE(anew.rebuild({&view, 1}, settings).converged);
        REQUIRE(difference(active_set(cut), active_set(anew)) == "");
    }
}

TEST_CASE("a page that is kept after all while a jump is built is refined as any other") {
    Random random(124);
    int kept = 0;
    for (int round = 0; round < rounds(40, 200); ++round) {
        auto pack = paged_terrain(random, false);
        Cut cut(pack.terrain, ample_cut(pack.terrain, 2));
        View view = random_view(random, pack.terrain);
        CutSettings settings;
        settings.max_error_px = random_threshold(random);
        (void)settle(cut, {&view, 1}, settings);
        const auto any = [&](std::uint32_t count) {
            return static_cast<std::uint32_t>(pick(random, 0, static_cast<int>(count) - 1));
        };
        std::vector<Page> leaving;
        for (int n = 0; n < 6; ++n) {
            leaving.push_back({any(pack.terrain.tile_count()), n < 2 ? 0 : any(pack.terrain.pages_per_tile())});
            bool released = false;
            REQUIRE(cut_release_page(cut.cut, leaving.back().tile, leaving.back().page, released).ok());
        }
        view = random_view(random, pack.terrain);
        settings.visits = static_cast<std::uint32_t>(pick(random, 1, 40));
        CutReport report = cut.update({&view, 1}, settings);
        kept += cut.state().bulk.phase != BulkPhase::idle;
        for (const Page& p : leaving) (void)cut_cancel_release(cut.cut, p.tile, p.page);
        settings.visits = unlimited_work;
        for (int frame = 0; frame == 0 || (frame < 40 && !report.converged); ++frame)
            report = cut.update({&view, 1}, settings);
        CAPTURE(round, settings.max_error_px);
        REQUIRE(report.converged);
        Cut anew(pack.terrain, ample_cut(pack.terrain, 2));
        REQUIRE(anew.rebuild({&view, 1}, settings).converged);
        REQUIRE(difference(active_set(cut), active_set(anew)) == "");
    }
    REQUIRE(kept > rounds(5, 25));
}

TEST_CASE("pages unloaded without warning leave a whole mesh as well") {
    live_with(122, {true, false}, rounds(10, 48));
}

TEST_CASE("a page is released step by step, each a whole mesh, and nothing of it is active when it says so") {
    Random random(123);
    for (int round = 0; round < 6; ++round) {
        const auto pack = rich_terrain(random, 33, 4);
        PagedTerrain paged(pack.pack, {});
        Cut cut(paged.terrain, ample_cut(pack.terrain));
        Host host{random, pack.pack, paged.terrain, cut, false, {}, {}};
        host.load_all();
        View view = random_view(random, pack.terrain);
        CutSettings settings;
        settings.max_error_px = 0.5;
        (void)settle(cut, {&view, 1}, settings);
        settings.max_work = 2;
        const Page p = host.any();
        bool released = false;
        int frames = 0;
        for (; !released && frames < 5000; ++frames) {
            REQUIRE(cut_release_page(cut.cut, p.tile, p.page, released).ok());
            view = moved(random, view, 1e-3 * paged.terrain.spacing_x_m());
            const CutReport report = cut.update({&view, 1}, settings);
            CAPTURE(round, frames);
            REQUIRE(check_frame(cut, pack.terrain, report, settings) == "");
        }
        REQUIRE(released);
        const std::uint32_t first = cut.state().pages.page_groups[p.tile * pack.terrain.pages_per_tile() + p.page];
        REQUIRE((first == no_index || cut.state().pages.state[first / max_page_groups].active == 0));
        (void)unload_page(paged.terrain, p.tile, p.page);
        settings.max_work = unlimited_work;
        REQUIRE(cut.update({&view, 1}, settings).converged);
        REQUIRE(difference(active_set(cut),
                           target_set(pack.terrain, paged.terrain, {&view, 1}, settings.max_error_px)) == "");
    }
}

// What cut_release_page() began ends when its page goes, also when update_cut() did not see it gone.
TEST_CASE("a page that went and came back between two frames is drawn again") {
    Random random(124);
    const auto pack = rich_terrain(random, 65, 5);
    PagedTerrain paged(pack.pack, {});
    Cut cut(paged.terrain, ample_cut(pack.terrain));
    Host host{random, pack.pack, paged.terrain, cut, false, {}, {}};
    host.load_all();
    const View view = view_from_above(pack.terrain, 0.1);
    CutSettings settings;
    settings.max_error_px = 0.1;
    (void)settle(cut, {&view, 1}, settings);
    bool released = false;
    REQUIRE(cut_release_page(cut.cut, 0, 0, released).ok());
    (void)cut.update({&view, 1}, settings);
    REQUIRE(cut_release_page(cut.cut, 0, 0, released).ok());
    REQUIRE(released);
    (void)unload_page(paged.terrain, 0, 0);
    REQUIRE(load_page(pack.pack, paged.terrain, 0, 0).ok()); // into the same slot, most likely
    const CutReport report = settle(cut, {&view, 1}, settings, 10);
    REQUIRE(check_cut(cut) == "");
    REQUIRE(difference(active_set(cut), target_set(pack.terrain, paged.terrain, {&view, 1}, settings.max_error_px)) ==
            "");
    REQUIRE(report.converged);
}

TEST_CASE("a bulk pass does not forget which pages are being evicted") {
    Random random(125);
    const auto pack = rich_terrain(random, 65, 5);
    PagedTerrain paged(pack.pack, {});
    Cut cut(paged.terrain, ample_cut(pack.terrain));
    Host host{random, pack.pack, paged.terrain, cut, false, {}, {}};
    host.load_all();
    const View view = view_from_above(pack.terrain, 0.1);
    CutSettings settings;
    settings.max_error_px = 0.1;
    (void)settle(cut, {&view, 1}, settings);
    bool released = false;
    REQUIRE(cut_release_page(cut.cut, 0, 0, released).ok());
    (void)cut.update({&view, 1}, settings);
    REQUIRE(cut_release_page(cut.cut, 0, 0, released).ok());
    REQUIRE(released);
    (void)cut.rebuild({&view, 1}, settings);
    // The host was told that it may unload: nothing of the page may be active.
    const std::uint32_t first = cut.state().pages.page_groups[0];
    REQUIRE((first == no_index || cut.state().pages.state[first / max_page_groups].active == 0));
}

TEST_CASE("a page that is not loaded is released at once, one that does not exist is refused") {
    Random random(126);
    const auto pack = rich_terrain(random, 65, 5);
    PagedTerrain paged(pack.pack, {});
    Cut cut(paged.terrain, ample_cut(pack.terrain));
    bool released = false;
    REQUIRE(cut_release_page(cut.cut, 0, 0, released).ok());
    REQUIRE(released);
    REQUIRE(cut_release_page(cut.cut, pack.terrain.tile_count(), 0, released).code == StatusCode::out_of_range);
    REQUIRE(cut_release_page(cut.cut, 0, pack.terrain.pages_per_tile(), released).code == StatusCode::out_of_range);
}

TEST_CASE(
    "where pages outnumber their states, the mesh is whole, the claim true, and states go to those that need one") {
    live_with(125, {false, true}, rounds(4, 24));
    live_with(126, {true, true}, rounds(4, 24));
}

TEST_CASE("the vertices around one are found by steps as they are by places in the tree") {
    Random random(128);
    std::uint64_t lacking = 0, compared = 0;
    for (int round = 0; round < rounds(6, 24); ++round) {
        // Steps of several full pages a tile, one of them the child of another.
        const auto pack =
            bake_and_load(random_dem(random, pick(random, 70, 400), pick(random, 70, 400), Shape::fractal),
                          small_bake(pick(random, 7, 8)));
        Cut cut(pack.terrain, ample_cut(pack.terrain));
        CutSettings settings;
        settings.max_error_px = random_threshold(random) / 4;
        const View view = random_view(random, pack.terrain);
        (void)cut.rebuild({&view, 1}, settings);
        const Pages& pages = cut.state().pages;
        for (std::uint32_t vertex = 0; vertex < pages.fresh * max_page_vertices; ++vertex) {
            const std::uint32_t group = vertex / group_lanes;
            if (pages.state[vertex / max_page_vertices].page == no_index ||
                group % max_page_groups >= pages.grid.shapes[pages.state[group / max_page_groups].shape].count ||
                vertex % group_lanes >= shape_of(pages, group).lanes)
                continue;
            // A border has a place in each page that holds it; the vertex is its owner's.
            const Site site = site_of(pages, vertex);
            if (!exists(pages.grid, site) || find_vertex(pages, site) != vertex) continue;
            const Around a = find_around(pages, vertex), b = find_around_anywhere(pages, vertex);
            const bool same = std::equal(a.child, a.child + 4, b.child) &&
                              std::equal(a.parent, a.parent + 2, b.parent) && a.lacks_child == b.lacks_child &&
                              site_coord(a.site) == site_coord(b.site);
            CAPTURE(round, vertex);
            if (!same) REQUIRE(same);
            lacking += a.lacks_child;
            ++compared;
        }
    }
    CHECK((compared > 100'000 && lacking > 1000));
}

TEST_CASE("a rebuild finds the states of the pages that it leaves") {
    Random random(127);
    int taken_again = 0, coarser = 0;
    for (int round = 0; round < rounds(8, 40); ++round) {
        const auto pack = paged_terrain(random, true);
        Cut cut(pack.terrain, ample_cut(pack.terrain)), fresh(pack.terrain, ample_cut(pack.terrain));
        make_states_scarce(random, cut);
        CutSettings settings;
        settings.max_error_px = random_threshold(random);
        for (int frame = 0; frame < 6; ++frame) {
            const View view = random_view(random, pack.terrain);
            const CutReport report = cut.rebuild({&view, 1}, settings), full = fresh.rebuild({&view, 1}, settings);
            CAPTURE(round, frame, report.threshold_px);
            REQUIRE(check_frame(cut, pack.terrain, report, settings) == "");
            taken_again += cut.state().pages.fresh == cut.state().pages.count;
            coarser += report.exhausted != 0;
            if (report.exhausted == 0)
                REQUIRE(report.triangles == full.triangles);
            else
                REQUIRE(report.exhausted == cut_budget_vertices);
        }
    }
    CHECK(taken_again > rounds(8, 40));
    CHECK(coarser > rounds(2, 10));
}
