// Budgets of the live cut: each runs out alone, says its name, breaks nothing and is forgiven; the governor; refusals.
#include <catch2/catch.hpp>

#include "shared/terrain_data.h"
#include "support/cut_scene.h"

using namespace fjell;
using namespace fjell::test;

namespace {

std::uint32_t corners_of(const Terrain& terrain) {
    return (terrain.header().tiles_x + 1) * (terrain.header().tiles_y + 1);
}
// The smallest that create_cut() takes.
CutBudget least_cut(const Terrain& terrain, std::uint32_t segment_triangles = 8) {
    CutBudget budget;
    budget.vertices = corners_of(terrain);
    budget.segment_triangles = segment_triangles;
    budget.triangles = segment_triangles * (terrain.tile_count() + 3);
    return budget;
}

Status create(const Terrain& terrain, const CutBudget& budget, std::size_t bytes) {
    const auto memory = io::allocate(std::max<std::size_t>(bytes, 64));
    LiveCut cut;
    return create_cut(terrain, budget, {memory.get(), bytes}, cut);
}

// So many frames at rest; how often the effective threshold turned round, and whether it came to stand in the last
// tenth of them.
struct Rest {
    int turns = 0;
    bool stands = true;
    CutReport last;
};
Rest rest(Cut& cut, const View& view, const CutSettings& settings, int frames) {
    Rest r;
    double before = 0;
    int direction = 0;
    for (int frame = 0; frame < frames; ++frame) {
        r.last = cut.update({&view, 1}, settings);
        const double now = r.last.threshold_px;
        if (frame > 0 && now != before) {
            const int step = now > before ? 1 : -1;
            r.turns += direction != 0 && step != direction;
            direction = step;
            if (frame > frames - frames / 10) r.stands = false;
        }
        before = now;
    }
    return r;
}

} // namespace

TEST_CASE("a slot costs the bytes that the headers say") {
    Random random(140);
    const auto pack = bake_and_load(random_dem(random, 300, 300, Shape::noise), small_bake(6));
    constexpr std::uint32_t more = 1u << 20; // so many that bookkeeping and rounding up weigh less than a byte each
    const auto grown = [&](std::uint32_t vertices, std::uint32_t triangles, std::uint32_t slots) {
        CutBudget budget = least_cut(pack.terrain, 4096);
        budget.vertices += vertices;
        budget.triangles += triangles;
        data_of(pack.terrain).slot_count += slots;
        const std::size_t bytes = cut_bytes(pack.terrain, budget);
        data_of(pack.terrain).slot_count -= slots;
        return bytes;
    };
    const std::size_t least = grown(0, 0, 0);
    CHECK((grown(more, 0, 0) - least) / more == cut_vertex_bytes);
    CHECK((grown(0, more, 0) - least) / more == cut_triangle_bytes);
    // More slots than there are states, and fewer.
    CHECK((grown(0, 0, 14000) - grown(0, 0, 7000) + 3500) / 7000 == cut_page_slot_bytes);
    CHECK((grown(more, 0, 14000) - grown(more, 0, 7000) + 3500) / 7000 == cut_page_slot_bytes + cut_page_bytes);
    const auto slots = [&](std::uint32_t count) { return terrain_bytes(pack.terrain.header(), {.page_slots = count}); };
    const std::uint32_t tiles = pack.terrain.tile_count(), pages = pack.terrain.page_count();
    const std::size_t page = (slots(pages) - slots(tiles)) / (pages - tiles);
    CHECK((page + cut_page_bytes + 500) / 1000 == 32); // docs/guides/embedding-streaming.md: 32 KB each
}

TEST_CASE("what a cut takes follows its vertices, however large the terrain is that is held whole") {
    Random random(143);
    const auto pack = bake_and_load(random_dem(random, 300, 300, Shape::noise), small_bake(6));
    const auto bytes_of = [&](std::uint32_t slots) {
        const std::uint32_t before = std::exchange(data_of(pack.terrain).slot_count, slots);
        const std::size_t bytes = cut_bytes(pack.terrain, {.vertices = 1u << 18, .triangles = 1u << 19});
        data_of(pack.terrain).slot_count = before;
        return bytes;
    };
    // 16,385 and 32,769 samples squared.
    CHECK(bytes_of(87'552) < 200'000'000);
    CHECK(bytes_of(350'208) - bytes_of(87'552) < 10'000'000);
}

TEST_CASE("each budget that is too small alone lowers quality, names itself, breaks nothing and is forgiven") {
    Random random(141);
    std::uint32_t seen = 0;
    int recovered = 0;
    for (int round = 0; round < 60; ++round) {
        const auto pack = random_terrain(random, 90, 5);
        const Terrain& terrain = pack.terrain;
        const auto bit = static_cast<CutBudgetBit>(1u << (round % 4));
        CutBudget budget = ample_cut(terrain);
        CutSettings settings, far;
        settings.max_error_px = std::pow(10.0, uniform(random, -2, -0.5));
        switch (bit) {
        case cut_budget_vertices:
            budget.vertices = corners_of(terrain) + static_cast<std::uint32_t>(pick(random, 0, 200));
            break;
        case cut_budget_triangles:
            budget.segment_triangles = 8;
            budget.triangles = 8 * (terrain.tile_count() + 3 + static_cast<std::uint32_t>(pick(random, 0, 60)));
            break;
        case cut_budget_work: settings.max_work = static_cast<std::uint32_t>(pick(random, 2, 60)); break;
        case cut_budget_time: settings.max_time_us = 1e-3; break; // less than a look at the clock takes
        }
        Cut cut(terrain, budget);
        bool ran_out = false;
        View view = random_view(random, terrain);
        for (int frame = 0; frame < 30; ++frame) {
            view = moved(random, view, random_step_m(random, terrain));
            if (frame == 15) view = random_view(random, terrain);
            const CutReport report = cut.update({&view, 1}, settings);
            CAPTURE(round, frame, settings.max_error_px, budget.vertices, budget.triangles, settings.max_work);
            REQUIRE(check_frame(cut, terrain, report, settings) == "");
            REQUIRE((report.exhausted & ~bit) == 0);
            if (!report.converged && report.threshold_px == report.error_px_requested) REQUIRE(report.exhausted == bit);
            REQUIRE(report.vertex_slots.used <= report.vertex_slots.capacity);
            REQUIRE(report.triangle_slots.used <= report.triangle_slots.capacity);
            REQUIRE(report.vertex_slots.peak >= report.vertex_slots.used);
            REQUIRE(report.triangle_slots.peak >= report.triangle_slots.used);
            ran_out = ran_out || report.exhausted != 0;
        }
        if (ran_out) seen |= bit;
        // The camera leaves to where the coarsest mesh will do, at the same threshold, and all is well again.
        far = settings;
        far.max_work = unlimited_work;
        far.max_time_us = 0;
        far.max_error_px = 1e6;
        const CutReport report = settle(cut, {&view, 1}, far, 300);
        CAPTURE(round, budget.vertices, budget.triangles, report.error_bound_px, report.waiting, report.blocked);
        const VertexSet target = target_set(terrain, terrain, {&view, 1}, far.max_error_px);
        const auto size = static_cast<std::uint32_t>(std::count(target.begin(), target.end(), true));
        // The governor stays where four fifths are in use; and spheres that hold the eye count at any threshold.
        if (size * 5 > budget.vertices * 4 || bit == cut_budget_triangles) continue;
        REQUIRE(report.converged);
        REQUIRE(report.exhausted == 0);
        REQUIRE(difference(active_set(cut), target) == "");
        ++recovered;
    }
    REQUIRE(seen == (cut_budget_vertices | cut_budget_triangles | cut_budget_work | cut_budget_time));
    REQUIRE(recovered > 30);
}

TEST_CASE("when the camera leaves, the threshold comes back to the requested one, and the cut to the target") {
    Random random(142);
    for (int round = 0; round < 16; ++round) {
        const auto pack = rich_terrain(random, 97, 4 + round % 2);
        const Terrain& terrain = pack.terrain;
        CutBudget budget = ample_cut(terrain);
        if (round % 4 < 2)
            budget.vertices = corners_of(terrain) + 600;
        else
            budget.triangles = budget.segment_triangles * (terrain.tile_count() * 2 + 40);
        Cut cut(terrain, budget);
        CutSettings settings;
        // Half of what the budget holds: found from afar, where it suffices.
        const View near_by = view_from_above(terrain, 0.01), far = view_from_above(terrain, 3);
        settings.max_error_px = 1e-3;
        for (;; settings.max_error_px *= 1.2) {
            Cut free(terrain, ample_cut(terrain));
            const CutReport wish = free.update({&far, 1}, settings);
            if (wish.vertices * 2 < budget.vertices && wish.triangle_slots.used * 2 < budget.triangles) break;
        }
        CutReport report;
        // It leaves when the governor has found what suffices, or while it still looks for it.
        const bool found = round % 3 == 0;
        const int stay = found ? 100 : pick(random, 1, 12);
        for (int frame = 0; frame < stay; ++frame) report = cut.update({&near_by, 1}, settings);
        CAPTURE(round, stay, settings.max_error_px, report.error_bound_px, report.vertices);
        REQUIRE_FALSE(report.converged);
        if (stay > 1) REQUIRE(report.threshold_px > settings.max_error_px);
        REQUIRE(check_frame(cut, terrain, report, settings) == "");
        // Most of the scarce capacity stays in use: what is governed is not thrown away.
        REQUIRE(std::max(report.vertex_slots.used / static_cast<double>(report.vertex_slots.capacity),
                         report.triangle_slots.used / static_cast<double>(report.triangle_slots.capacity)) > 0.6);
        report = settle(cut, {&far, 1}, settings, 200);
        REQUIRE(report.converged);
        REQUIRE(report.error_bound_px == settings.max_error_px);
        REQUIRE(report.exhausted == 0);
        REQUIRE(difference(active_set(cut), target_set(terrain, terrain, {&far, 1}, settings.max_error_px)) == "");
    }
}

TEST_CASE("after a step of the threshold or the camera the governor turns at most once, then stands, nothing blocked") {
    Random random(143);
    int governed = 0;
    for (int round = 0; round < 60; ++round) {
        const auto pack = round % 2 ? rich_terrain(random, 97, 5) : random_terrain(random, 97, 5);
        const Terrain& terrain = pack.terrain;
        CutBudget budget = ample_cut(terrain);
        if (pick(random, 0, 1))
            budget.vertices = corners_of(terrain) + static_cast<std::uint32_t>(pick(random, 10, 2000));
        else
            budget.triangles = budget.segment_triangles *
                               (terrain.tile_count() + 3 + static_cast<std::uint32_t>(pick(random, 1, 200)));
        Cut cut(terrain, budget);
        View view = random_view(random, terrain);
        CutSettings settings;
        settings.max_error_px = random_threshold(random) / 10;
        for (int leg = 0; leg < 4; ++leg) {
            // Some threshold must suffice: not when the spheres around the eye alone are too many.
            Cut coarse(terrain, ample_cut(terrain));
            CutSettings coarsest;
            coarsest.max_error_px = 1e4;
            const CutReport least = coarse.update({&view, 1}, coarsest);
            const bool suffices =
                least.vertices * 2 < budget.vertices && (least.triangle_slots.used + 64) * 2 < budget.triangles;
            const Rest r = rest(cut, view, settings, 200);
            CAPTURE(round, leg, settings.max_error_px, budget.vertices, budget.triangles, r.last.error_bound_px,
                    r.last.vertices, r.last.triangle_slots.used, r.last.blocked);
            if (suffices) CHECK(r.turns <= 1);
            if (suffices) CHECK(r.stands);
            if (suffices) CHECK(r.last.blocked == 0);
            REQUIRE(check_frame(cut, terrain, r.last, settings) == "");
            governed += r.last.threshold_px > settings.max_error_px;
            if (pick(random, 0, 1))
                view = random_view(random, terrain);
            else
                settings.max_error_px = random_threshold(random) / 10;
        }
    }
    REQUIRE(governed > 20);
}

TEST_CASE("where half of the vertices come in one step of the threshold, the one that has failed is not tried again "
          "and again") {
    // Bumps of one height, from so far above that they are equally large on screen: all of them are wanted, or none.
    baker::Dem dem;
    dem.columns = dem.rows = 65;
    for (int y = 0; y < dem.rows; ++y)
        for (int x = 0; x < dem.columns; ++x) dem.heights_m.push_back(x % 2 != 0 && y % 2 != 0 ? 10.0f : 0.0f);
    const auto pack = bake_and_load(std::move(dem), small_bake(6, 0.001));
    const View view = view_from_above(pack.terrain, 50);
    Cut free(pack.terrain, ample_cut(pack.terrain));
    CutSettings settings;
    settings.max_error_px = focal_length_px(view) * 10 / (50 * 64) / 2; // half of what a bump measures on screen
    const CutReport wish = free.update({&view, 1}, settings);
    CutBudget budget = ample_cut(pack.terrain);
    budget.vertices = wish.vertices / 2;
    Cut cut(pack.terrain, budget);
    const Rest r = rest(cut, view, settings, 200);
    CAPTURE(wish.vertices, r.turns, r.last.error_bound_px, r.last.vertices);
    CHECK(r.last.vertices * 5 < budget.vertices * 4); // so few that a lower threshold would be tried
    CHECK(r.turns == 0);
    CHECK(r.stands);
}

TEST_CASE("the smallest budgets that are taken give the coarsest meshes, with holes too, and never get stuck") {
    Random random(144);
    for (int round = 0; round < 60; ++round) {
        const auto pack = random_terrain(random, 70, 4);
        const Terrain& terrain = pack.terrain;
        CutBudget budget = least_cut(terrain, round % 2 ? 8 : 16);
        if (round % 3 == 1) budget.vertices += 300;                             // triangles alone are short
        if (round % 3 == 2) budget.triangles += 200 * budget.segment_triangles; // vertices alone are
        Cut cut(terrain, budget);
        CutSettings settings;
        for (int frame = 0; frame < 40; ++frame) {
            const View view = random_view(random, terrain);
            settings.max_error_px = random_threshold(random) / (frame % 2 ? 10 : 1);
            for (int again = 0; again < 3; ++again) {
                const CutReport report = cut.update({&view, 1}, settings);
                CAPTURE(round, frame, settings.max_error_px, budget.vertices, budget.triangles);
                REQUIRE(check_frame(cut, terrain, report, settings) == "");
            }
        }
    }
}

TEST_CASE("the smallest budget of triangles is used, by a rebuild as by updates") {
    Random random(150);
    for (int round = 0; round < 6; ++round) {
        const auto pack = rich_terrain(random, 129, 7); // one tile
        CutBudget budget = least_cut(pack.terrain, 512);
        budget.vertices = 3000;
        CAPTURE(round, budget.triangles);
        const View view = view_from_above(pack.terrain, 0.3);
        CutSettings settings;
        settings.max_error_px = 0.05;
        for (const bool rebuilt : {false, true}) {
            Cut cut(pack.terrain, budget);
            if (rebuilt) REQUIRE((cut.rebuild({&view, 1}, settings).exhausted & cut_budget_triangles) != 0);
            const Rest r = rest(cut, view, settings, 120);
            CAPTURE(rebuilt, r.last.threshold_px, r.last.triangles);
            CHECK(r.last.triangles > budget.segment_triangles / 2); // a whole segment is held back twice
            CHECK(r.last.error_bound_px < 1e4);
        }
    }
}

TEST_CASE("a budget that just holds what is requested is found to hold it, whatever came before") {
    Random random(149);
    for (int round = 0; round < 30; ++round) {
        const auto pack = random_terrain(random, 70, 4);
        const Terrain& terrain = pack.terrain;
        CutBudget budget = least_cut(terrain);
        if (round % 2) {
            budget.vertices += 300;
            budget.triangles += 8 * 100;
        }
        Cut cut(terrain, budget);
        CutSettings settings;
        for (int frame = 0; frame < 60; ++frame) {
            const View view = random_view(random, terrain);
            settings.max_error_px = random_threshold(random) / 10;
            (void)cut.update({&view, 1}, settings);
        }
        const View view = random_view(random, terrain);
        settings.max_error_px = 1e5;
        const CutReport old = settle(cut, {&view, 1}, settings, 400);
        Cut fresh(terrain, budget);
        const CutReport wish = settle(fresh, {&view, 1}, settings, 400);
        CAPTURE(round, old.waiting, old.blocked, old.error_bound_px, wish.error_bound_px, budget.vertices,
                budget.triangles);
        REQUIRE(old.converged == wish.converged);
        if (wish.converged) REQUIRE(difference(active_set(cut), active_set(fresh)) == "");
    }
}

TEST_CASE("where no threshold suffices the effective one does not run away, and the camera can leave") {
    Random random(150);
    const auto pack = rich_terrain(random, 65, 5);
    CutBudget budget = least_cut(pack.terrain);
    budget.vertices += 8;
    budget.triangles += 8 * 8;
    Cut cut(pack.terrain, budget);
    // On the ground, inside the spheres of more vertices than fit: those are wanted at any threshold.
    const double middle = pack.terrain.x_m(32);
    View view = view_from_above(pack.terrain, 1);
    view.eye_m = {middle, data_of(pack.terrain).ground_m(middle, pack.terrain.z_m(32)), pack.terrain.z_m(32)};
    CutSettings settings;
    settings.max_error_px = 1;
    CutReport report;
    for (int frame = 0; frame < 10'000; ++frame) report = cut.update({&view, 1}, settings); // three minutes
    CAPTURE(report.error_bound_px);
    CHECK(report.blocked != 0);
    CHECK(report.error_bound_px <= 1e7); // no farther than ten times what may be requested
    view.eye_m = view.eye_m + Vec3{0, middle * 1e3, 0};
    report = settle(cut, {&view, 1}, settings, 600); // ten seconds
    REQUIRE(report.vertices * 5 < budget.vertices * 4);
    REQUIRE(report.converged);
}

TEST_CASE("cut_bytes() is what create_cut() takes, and one byte less is refused") {
    Random random(145);
    for (int round = 0; round < 20; ++round) {
        const auto pack = random_terrain(random, 60, 5);
        CutBudget budget = least_cut(pack.terrain, 8u << pick(random, 0, 4));
        budget.vertices += static_cast<std::uint32_t>(pick(random, 0, 5000));
        budget.triangles += static_cast<std::uint32_t>(pick(random, 0, 5000));
        budget.views = static_cast<std::uint32_t>(pick(random, 1, 8));
        const std::size_t bytes = cut_bytes(pack.terrain, budget);
        REQUIRE(bytes > 0);
        REQUIRE(create(pack.terrain, budget, bytes).ok());
        const Status less = create(pack.terrain, budget, bytes - 1);
        REQUIRE(less.code == StatusCode::memory_too_small);
        REQUIRE(std::string(less.field) == "memory");
    }
}

TEST_CASE("a cut that cannot morph takes less memory, has the same mesh, and refuses to morph") {
    Random random(151);
    for (int round = 0; round < rounds(20, 100); ++round) {
        const auto pack = rich_terrain(random, pick(random, 20, 200), pick(random, 3, 6));
        const Terrain& terrain = pack.terrain;
        CutBudget budget = ample_cut(terrain);
        budget.vertices &= ~63u; // so that no part is rounded up
        budget.morph = false;
        CutBudget morphing = budget;
        morphing.morph = true;
        CHECK(cut_bytes(terrain, morphing) - cut_bytes(terrain, budget) ==
              std::size_t{budget.vertices} * cut_morph_bytes);
        Cut plain(terrain, budget), other(terrain, morphing);
        CutSettings settings;
        View view = random_view(random, terrain);
        for (int frame = 0; frame < 12; ++frame) {
            settings.max_error_px = random_threshold(random);
            const bool rebuild = pick(random, 0, 5) == 0;
            settings.max_work = rebuild || pick(random, 0, 1) ? unlimited_work : 200;
            if (pick(random, 0, 1)) view = random_view(random, terrain);
            for (Cut* cut : {&plain, &other}) {
                const CutReport report =
                    rebuild ? cut->rebuild({&view, 1}, settings) : cut->update({&view, 1}, settings);
                const std::string wrong = check_frame(*cut, terrain, report, settings);
                CAPTURE(round, frame, wrong);
                REQUIRE(wrong.empty());
            }
            const CutMesh a = cut_mesh(plain.cut), b = cut_mesh(other.cut);
            REQUIRE(a.morph.empty());
            REQUIRE(triangles_of(a.mesh) == triangles_of(b.mesh));
        }
        settings.morph = Morph::error;
        CutReport report;
        const Status refused = update_cut(plain.cut, {&view, 1}, settings, report);
        CHECK(refused.code == StatusCode::not_supported);
        CHECK(std::string(refused.field).rfind("CutSettings::morph", 0) == 0);
    }
}

TEST_CASE("an absurd budget is refused by the field's name before anything is asked of memory") {
    Random random(146);
    const auto pack = rich_terrain(random, 65, 4);
    const Terrain& terrain = pack.terrain;
    const auto refused = [&](const CutBudget& budget, StatusCode code, const std::string& field) {
        REQUIRE(cut_bytes(terrain, budget) == 0);
        const Status s = create(terrain, budget, 1 << 20);
        CHECK(s.code == code);
        CHECK(std::string(s.field).rfind(field, 0) == 0);
    };
    const CutBudget good = least_cut(terrain);
    REQUIRE(cut_bytes(terrain, good) != 0);
    CutBudget b = good;
    b.vertices = good.vertices - 1;
    refused(b, StatusCode::budget_too_small, "CutBudget::vertices");
    b.vertices = 0;
    refused(b, StatusCode::budget_too_small, "CutBudget::vertices");
    b.vertices = 0xffffffff;
    refused(b, StatusCode::out_of_range, "CutBudget::vertices");
    b = good;
    b.triangles = good.triangles - 1;
    refused(b, StatusCode::budget_too_small, "CutBudget::triangles");
    b.triangles = 0;
    refused(b, StatusCode::budget_too_small, "CutBudget::triangles");
    b.triangles = 0xffffffff;
    refused(b, StatusCode::out_of_range, "CutBudget::triangles");
    for (const std::uint32_t chunk : {0u, 1u, 4u, 7u, 9u, 1u << 17, 0xffffffffu}) {
        b = good;
        b.segment_triangles = chunk;
        refused(b, StatusCode::out_of_range, "CutBudget::segment_triangles");
    }
    for (const std::uint32_t views : {0u, max_cut_views + 1, 0xffffffffu}) {
        b = good;
        b.views = views;
        refused(b, StatusCode::out_of_range, "CutBudget::views");
    }
    baker::BakeOptions options = small_bake(4);
    options.order = PageOrder::linear;
    const auto linear = bake_and_load(random_dem(random, 33, 33, Shape::fractal), options);
    REQUIRE(create(linear.terrain, least_cut(linear.terrain), 1 << 20).code == StatusCode::not_supported);
    REQUIRE(cut_bytes(linear.terrain, least_cut(linear.terrain)) == 0);
}

TEST_CASE("memory that is not aligned is refused") {
    Random random(147);
    const auto pack = rich_terrain(random, 33, 4);
    const std::size_t bytes = cut_bytes(pack.terrain, {});
    const auto memory = io::allocate(bytes + 64);
    LiveCut cut;
    const Status s = create_cut(pack.terrain, {}, {memory.get() + 32, bytes}, cut);
    REQUIRE(s.code == StatusCode::out_of_range);
    REQUIRE(std::string(s.field) == "memory alignment");
}

TEST_CASE("a bad view or setting is refused by name and changes nothing") {
    Random random(148);
    const auto pack = rich_terrain(random, 65, 5);
    Cut cut(pack.terrain, ample_cut(pack.terrain));
    const View good = random_view(random, pack.terrain);
    (void)cut.update({&good, 1}, {});
    const auto before = triangles_of(cut.mesh());
    const double nan = std::nan("");
    const auto refused = [&](const View& view, const CutSettings& settings, const std::string& field) {
        CutReport report;
        const Status s = update_cut(cut.cut, {&view, 1}, settings, report);
        CHECK(s.code == StatusCode::out_of_range);
        CHECK(std::string(s.field).rfind(field, 0) == 0);
        CHECK((triangles_of(cut.mesh()) == before));
        CHECK(check_cut(cut) == "");
        CHECK(rebuild_cut(cut.cut, {&view, 1}, settings, report).code == StatusCode::out_of_range);
        CHECK((triangles_of(cut.mesh()) == before));
    };
    View bad = good;
    bad.eye_m.x = nan;
    refused(bad, {}, "View::eye_m");
    bad = good;
    bad.forward = good.forward * 1.001;
    refused(bad, {}, "View::forward");
    bad = good;
    bad.up = good.up * 1.001;
    refused(bad, {}, "View::up");
    for (const double lean : {-1e-3, 1e-3}) { // a unit vector, but not perpendicular to the direction
        bad = good;
        bad.up = normalised(good.up + good.forward * lean);
        refused(bad, {}, "View::up");
    }
    bad = good;
    bad.top = bad.bottom;
    refused(bad, {}, "View::bottom, top");
    bad = good;
    bad.right = std::nan("");
    refused(bad, {}, "View::left, right");
    const auto setting = [&](auto field, std::initializer_list<double> values, const std::string& name) {
        for (const double value : values) {
            CutSettings settings;
            settings.*field = value;
            CAPTURE(name, value);
            refused(good, settings, name);
        }
    };
    setting(&CutSettings::max_error_px, {0, -1, 1e-4, 1e7, nan}, "CutSettings::max_error_px");
    setting(&CutSettings::hysteresis, {-1e-9, 11, nan}, "CutSettings::hysteresis");
    setting(&CutSettings::offscreen_factor, {0.99, 101, nan}, "CutSettings::offscreen_factor");
    setting(&CutSettings::max_time_us, {-1, nan}, "CutSettings::max_time_us");
    setting(&CutSettings::morph_s, {0, 0.001, 11, nan}, "CutSettings::morph_s");
    setting(&CutSettings::now_s, {nan, 1.0 / 0.0}, "CutSettings::now_s");
    REQUIRE(cut.update({&good, 1}, {}).work == 0);
}

TEST_CASE("every bit names its field") {
    REQUIRE(std::string(budget_field(cut_budget_vertices)) == "CutBudget::vertices");
    REQUIRE(std::string(budget_field(cut_budget_triangles)) == "CutBudget::triangles");
    REQUIRE(std::string(budget_field(cut_budget_work)) == "CutSettings::max_work");
    REQUIRE(std::string(budget_field(cut_budget_time)) == "CutSettings::max_time_us");
}
