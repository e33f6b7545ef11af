// Edited ground (fjell/edit.h): after every step the bound and the nesting hold, and at rest the terrain is the one
// that a bake of the edited heights gives.
#include <catch2/catch.hpp>

#include <cmath>

#include "edit/small_diamonds.h"
#include "fjell/measure.h"
#include "fjell/pages.h"
#include "fjell/query.h"
#include "support/edited_ground.h"
#include "support/rounds.h"

using namespace fjell;
using namespace fjell::test;

TEST_CASE("edited ground is bounded after every step, and at rest it is what a bake gives", "[edit]") {
    Random random(20261127);
    for (int round = 0; round < rounds(6, 60); ++round) {
        const int log2 = pick(random, 2, 7);
        const std::int32_t side = 1 << log2;
        const std::int32_t columns = pick(random, 1, std::max(1, 200 / side)) * side + 1,
                           rows = pick(random, 1, std::max(1, 200 / side)) * side + 1;
        const auto order = static_cast<PageOrder>(pick(random, 0, 2));
        CAPTURE(round, log2, columns, rows, static_cast<int>(order));
        const auto pack = framed_terrain(random, log2, columns, rows, order);
        const TerrainData& t = data_of(pack.terrain);
        Editor editor(pack.terrain);
        int applied = 0;
        for (int n = 0; n < 6; ++n) {
            const Stamp stamp = random_stamp(random, pack.terrain);
            if (touches_frame(pack.terrain, stamp)) continue;
            const StampId id = editor.push(stamp);
            CHECK(stamp_state(editor.edits, id).state == StampState::waiting);
            const bool in_steps = pick(random, 0, 1) != 0;
            EditReport report = editor.update(in_steps ? 1 : 40);
            for (int step = 0; stamp_state(editor.edits, id).state == StampState::waiting; ++step) {
                REQUIRE(step < 1000);
                report = editor.update(1);
            }
            const StampResult result = stamp_state(editor.edits, id);
            CAPTURE(n, static_cast<int>(stamp.shape), result.status.field);
            applied += result.state == StampState::applied;
            REQUIRE(check_bounds(t) == "");
            if (pick(random, 0, 2) == 0) {
                report = editor.update();
                REQUIRE(report.loose + report.unmeasured == 0);
                REQUIRE(check_bounds(t) == "");
            }
        }
        const EditReport report = editor.update();
        CHECK(report.loose + report.unmeasured + report.waiting == 0);
        const auto baked = bake_and_load(
            [&] {
                baker::Dem dem = heights_of(t);
                dem.native_quantum_m = 1;
                return dem;
            }(),
            [&] {
                baker::BakeOptions options = small_bake(log2);
                options.order = order;
                return options;
            }());
        REQUIRE(data_of(baked.terrain).header.quantum_m == t.header.quantum_m);
        REQUIRE(data_of(baked.terrain).header.base_m == t.header.base_m);
        CHECK(difference_of(t, data_of(baked.terrain)) == "");
        CHECK(applied > 0);
    }
}

TEST_CASE("ground that takes its time is bounded on its way, and ends where it would have been at once", "[edit]") {
    Random random(20261205);
    int on_its_way = 0, arrived = 0, between = 0;
    for (int round = 0; round < rounds(8, 80); ++round) {
        const int log2 = pick(random, 4, 6);
        Random same = random;
        const auto pack = framed_terrain(random, log2, 129, 65, PageOrder::planar),
                   twin = framed_terrain(same, log2, 129, 65, PageOrder::planar);
        const TerrainData &t = data_of(pack.terrain), &goal = data_of(twin.terrain);
        Editor editor(pack.terrain, {.moving = static_cast<std::uint32_t>(pick(random, 0, 2))}), at_once(twin.terrain);
        double now_s = 0;
        for (int n = 0; n < 4; ++n) {
            CAPTURE(round, n, log2);
            const baker::Dem before = heights_of(t);
            StampId ids[2] = {};
            for (StampId& id : ids) { // in order where they overlap
                Stamp stamp = random_stamp(random, pack.terrain);
                while (touches_frame(pack.terrain, stamp)) stamp = random_stamp(random, pack.terrain);
                const StampId other = at_once.push(stamp);
                (void)at_once.update();
                stamp.morph_s = 1;
                id = editor.push(stamp);
                if (stamp_state(at_once.edits, other).state == StampState::refused) id = 0;
            }
            const baker::Dem after = heights_of(goal);
            const auto waits = [&](StampId id) {
                const StampState state = stamp_state(editor.edits, id).state;
                return state == StampState::waiting || state == StampState::moving;
            };
            std::uint32_t gone = no_index; // a page of the first tile
            for (int frame = 0; waits(ids[0]) || waits(ids[1]); ++frame) {
                REQUIRE(frame < 400);
                if (gone != no_index && pick(random, 0, 2) == 0)
                    REQUIRE(load_page(pack.pack, pack.terrain, 0, std::exchange(gone, no_index)).ok());
                else if (gone == no_index && pick(random, 0, 9) == 0 && t.pages_per_tile > 1)
                    REQUIRE(unload_page(pack.terrain, 0, gone = t.pages_per_tile - 1).ok());
                now_s += uniform(random, 0, 0.4);
                const EditReport report = editor.update(pick(random, 0, 1) != 0 ? unlimited_edit_work : 20, now_s);
                on_its_way += static_cast<int>(report.moving);
                arrived += static_cast<int>(report.applied);
                if (gone != no_index) continue;
                REQUIRE(check_bounds(t) == "");
                const baker::Dem now = heights_of(t);
                if (report.moving == 1 && report.waiting == 0)
                    for (std::size_t i = 0; i < now.heights_m.size(); ++i)
                        between += now.heights_m[i] != before.heights_m[i] && now.heights_m[i] != after.heights_m[i];
            }
            if (gone != no_index) REQUIRE(load_page(pack.pack, pack.terrain, 0, gone).ok());
            REQUIRE((heights_of(t).heights_m == after.heights_m));
        }
        (void)editor.update(unlimited_edit_work, now_s);
        (void)at_once.update();
        CHECK(editor.update(unlimited_edit_work, now_s).loose == 0);
        CHECK(difference_of(t, goal) == "");
    }
    CHECK(on_its_way > rounds(60, 600));
    CHECK(arrived > rounds(20, 200));
    CHECK(between > rounds(1000, 10'000));
}

TEST_CASE("a live cut follows edited ground: whole, bounded, and at rest the target", "[edit]") {
    Random random(20261128);
    int changed = 0;
    for (int round = 0; round < rounds(6, 60); ++round) {
        const auto pack = random_terrain(random, 150, 6);
        CAPTURE(round);
        const TerrainData& t = data_of(pack.terrain);
        Editor editor(pack.terrain);
        Cut cut(pack.terrain, ample_cut(pack.terrain));
        CutSettings settings;
        settings.max_error_px = random_threshold(random);
        std::vector<View> views{random_view(random, pack.terrain)};
        for (int frame = 0; frame < 40; ++frame) {
            CAPTURE(frame);
            if (pick(random, 0, 2) == 0) editor.push(random_stamp(random, pack.terrain));
            const EditReport edited = editor.update(
                pick(random, 0, 1) ? unlimited_edit_work : static_cast<std::uint32_t>(pick(random, 0, 60)));
            changed += edited.samples != 0;
            if (pick(random, 0, 9) == 0) views[0] = random_view(random, pack.terrain);
            views[0] = moved(random, views[0], random_step_m(random, pack.terrain));
            settings.max_work = pick(random, 0, 1) ? unlimited_work : static_cast<std::uint32_t>(pick(random, 0, 200));
            settings.morph = static_cast<Morph>(pick(random, 0, 2));
            settings.offscreen_factor = pick(random, 0, 2) == 0 ? uniform(random, 1, 8) : 1;
            settings.now_s += 1.0 / 60;
            const CutReport report = cut.update(views, settings);
            // While a jump is built beside it, what is drawn is the mesh of before.
            const bool followed = cut.state().pages.seen_ground == t.ground_changes;
            REQUIRE((followed || cut.state().bulk.phase != BulkPhase::idle));
            REQUIRE((followed ? check_frame(cut, pack.terrain, report, settings) : check_cut(cut)) == "");
            const CutMesh live = cut_mesh(cut.cut);
            // What is claimed is no less than what is drawn hides, by every sample.
            MeshView mesh = cut.mesh();
            const std::vector<MeshVertex> drawn = drawn_vertices(pack.terrain, live);
            mesh.vertices = drawn;
            const Frustum frustum = make_frustum(views[0]);
            const MeasuredError measured =
                measure_error(pack.terrain, mesh, views[0], settings.offscreen_factor > 1 ? &frustum : nullptr);
            CAPTURE(settings.offscreen_factor, settings.max_error_px, static_cast<int>(settings.morph),
                    static_cast<int>(cut.state().bulk.phase), report.waiting, report.morphing, report.threshold_px,
                    measured.sample_m.column, measured.sample_m.row, measured.max_m, edited.samples, edited.loose);
            REQUIRE(measured.max_px <= report.error_bound_px * (1 + 1e-6) + 1e-9);
        }
        (void)editor.update();
        settings.max_work = unlimited_work;
        settings.morph = Morph::none;
        settings.offscreen_factor = 1;
        settings.now_s += 100;
        (void)settle(cut, views, settings, 50);
        CHECK(difference(active_set(cut), target_set(pack.terrain, pack.terrain, views, settings.max_error_px)) == "");
        CHECK(recursive_triangles(pack.terrain, views[0], settings.max_error_px) == triangles_of(cut.mesh()));
        REQUIRE(check_bounds(t) == "");
    }
    CHECK(changed > rounds(30, 300));
}

TEST_CASE("pages that leave come back with their edits", "[edit]") {
    Random random(20261129);
    Happened sum;
    for (int round = 0; round < rounds(6, 60); ++round) {
        CAPTURE(round);
        dig_while_pages_leave(random, paged_terrain(random, pick(random, 0, 1) != 0), 30, 3, sum);
    }
    CHECK(sum.changed > rounds(10, 100));
    CHECK(sum.left > rounds(10, 100));
}

TEST_CASE("after hundred thousands of steps of digging the mesh is whole, and nothing is loose", "[edit]") {
    Random random(20261204);
    Happened sum;
    for (int round = 0; sum.frames < rounds(600, 50'000); ++round) {
        CAPTURE(round);
        dig_while_pages_leave(random, paged_terrain(random, false), rounds(100, 1000), 100, sum);
    }
    CHECK(sum.steps > rounds(1000, 250'000));
    CHECK(sum.changed > sum.frames / 20);
    CHECK(sum.left > sum.frames / 3);
}

TEST_CASE("what other edits of a terrain have changed is followed, too", "[edit]") {
    Random random(20261201);
    const auto pack = rich_terrain(random, 129, 5);
    Cut cut(pack.terrain, ample_cut(pack.terrain));
    const std::vector<View> views{random_view(random, pack.terrain)};
    CutSettings settings;
    settings.max_error_px = 1;
    const auto dig = [&](Editor& editor, double at) {
        Stamp stamp;
        stamp.x_m = at * static_cast<double>(pack.terrain.extent_x_m());
        stamp.z_m = at * static_cast<double>(pack.terrain.extent_z_m());
        stamp.radius_m = 10 * pack.terrain.spacing_x_m(), stamp.amount_m = 100 * pack.terrain.header().quantum_m;
        const StampId id = editor.push(stamp);
        (void)editor.update();
        REQUIRE(stamp_state(editor.edits, id).state == StampState::applied);
    };
    (void)settle(cut, views, settings, 50);
    {
        Editor editor(pack.terrain);
        dig(editor, 0.3);
    }
    Editor editor(pack.terrain); // whose log says nothing of the first
    dig(editor, 0.7);
    (void)settle(cut, views, settings, 50);
    CHECK(recursive_triangles(pack.terrain, views[0], settings.max_error_px) == triangles_of(cut.mesh()));
    const MeshView mesh = cut.mesh();
    for (const TileRange& range : mesh.tiles)
        for (std::uint32_t k = 0; k < range.index_count; ++k) {
            const MeshVertex& v = mesh.vertices[mesh.indices[range.first_index + k]];
            REQUIRE(v.height_m == data_of(pack.terrain).height_m({v.column, v.row}));
        }
}

TEST_CASE("ground rises and sinks beyond what the pack holds, in one piece or in many", "[edit]") {
    Random random(20261202);
    baker::Dem dem = random_dem(random, 257, 257, Shape::fractal);
    dem.spacing_m[0] = dem.spacing_m[1] = 1;
    const auto [low, high] = std::minmax_element(dem.heights_m.begin(), dem.heights_m.end());
    const float base_m = *low, range_m = *high - base_m;
    for (float& h : dem.heights_m) h = 50 + 40 * (h - base_m) / range_m;
    dem.native_quantum_m = 0.01;
    const auto pack = bake_and_load(std::move(dem), small_bake(7));
    Editor editor(pack.terrain);
    for (const float amount_m : {-120.0f, 200.0f, -60.0f})
        for (const float radius_m : {15.0f, 60.0f}) {
            CAPTURE(amount_m, radius_m);
            Stamp stamp;
            stamp.x_m = uniform(random, 80, 170), stamp.z_m = uniform(random, 80, 170);
            stamp.radius_m = radius_m, stamp.falloff_m = 40, stamp.amount_m = amount_m;
            const StampId id = editor.push(stamp);
            (void)editor.update(1);
            for (int step = 0; stamp_state(editor.edits, id).state == StampState::waiting; ++step) {
                REQUIRE(step < 100);
                REQUIRE(check_bounds(data_of(pack.terrain)) == "");
                (void)editor.update(1);
            }
            CHECK(std::string(stamp_state(editor.edits, id).status.field) == "");
            REQUIRE(check_bounds(data_of(pack.terrain)) == "");
            (void)editor.update();
            REQUIRE(check_bounds(data_of(pack.terrain)) == "");
        }
    CHECK(data_of(pack.terrain).range.low_m < 0);
    CHECK(data_of(pack.terrain).range.high_m > 150);
}

TEST_CASE("ground that comes and goes leaves nothing behind", "[edit]") {
    Random random(20261203);
    const auto pack = framed_terrain(random, 6, 193, 193, PageOrder::planar);
    const TerrainData& t = data_of(pack.terrain);
    baker::Dem before = heights_of(t);
    before.native_quantum_m = 1;
    const EditBudget budget{24, 8, 8};
    Editor editor(pack.terrain, budget);
    int applied = 0;
    std::uint32_t most = 0;
    for (int round = 0; round < rounds(60, 3000); ++round) {
        Stamp stamp = random_stamp(random, pack.terrain);
        if (touches_frame(pack.terrain, stamp)) continue;
        if (pick(random, 0, 1) != 0) stamp.shape = StampShape::restore, stamp.falloff_m = 0;
        const StampId id = editor.push(stamp);
        most = std::max(most, editor.update().blocks);
        applied += stamp_state(editor.edits, id).state == StampState::applied;
        if (round % 10 != 9) continue;
        Stamp all;
        all.shape = StampShape::restore;
        all.radius_m = 1e6f;
        const StampId last = editor.push(all);
        const EditReport report = editor.update();
        REQUIRE(stamp_state(editor.edits, last).state == StampState::applied);
        REQUIRE(report.blocks == 0);
        REQUIRE((heights_of(t).heights_m == before.heights_m));
    }
    CHECK(applied > rounds(15, 800));
    CHECK(most > 8);
    CHECK(difference_of(t, data_of(bake_and_load(baker::Dem(before),
                                                 [] {
                                                     baker::BakeOptions options = small_bake(6);
                                                     options.order = PageOrder::planar;
                                                     return options;
                                                 }())
                                       .terrain)) == "");
}

TEST_CASE("a stamp that cannot be is refused by its field's name, and changes nothing", "[edit]") {
    Random random(20261130);
    const auto pack = rich_terrain(random, 129, 5);
    const TerrainData& t = data_of(pack.terrain);
    Editor editor(pack.terrain, {4, 2, 2});
    const auto before = heights_of(t).heights_m;
    const float quantum = pack.terrain.header().quantum_m, cell = pack.terrain.spacing_x_m();
    Stamp good;
    good.x_m = static_cast<double>(pack.terrain.extent_x_m()) / 2,
    good.z_m = static_cast<double>(pack.terrain.extent_z_m()) / 2;
    good.radius_m = 3 * cell, good.amount_m = quantum * 50;
    StampId id = 0;
    const auto refused = [&](const auto& change) {
        Stamp stamp = good;
        change(stamp);
        const Status s = push_stamp(editor.edits, stamp, id);
        CHECK(s.code == StatusCode::out_of_range);
        return std::string(s.field);
    };
    CHECK(refused([](Stamp& s) { s.x_m = NAN; }) == "Stamp::x_m");
    CHECK(refused([](Stamp& s) { s.radius_m = -1; }) == "Stamp::radius_m");
    CHECK(refused([](Stamp& s) { s.amount_m = INFINITY; }) == "Stamp::amount_m");
    CHECK(refused([](Stamp& s) { s.shape = static_cast<StampShape>(99); }) == "Stamp::shape");
    CHECK(refused([](Stamp& s) { s.shape = StampShape::heights; }) == "Stamp::heights_m");
    CHECK(refused([](Stamp& s) { s.shape = StampShape::path; }) == "Stamp::points");
    CHECK(refused([](Stamp& s) { s.shape = StampShape::noise; }) == "Stamp::wavelength_m");
    // The queue.
    StampId ids[2];
    for (StampId& one : ids) CHECK(push_stamp(editor.edits, good, one).ok());
    CHECK(push_stamp(editor.edits, good, id).code == StatusCode::out_of_slots);
    (void)editor.update();
    for (const StampId one : ids) CHECK(std::string(stamp_state(editor.edits, one).status.field) == "");
    for (const StampId one : ids) CHECK(stamp_state(editor.edits, one).state == StampState::applied);
    CHECK((heights_of(t).heights_m != before));
    const auto applied = [&](const auto& change) {
        Stamp stamp = good;
        change(stamp);
        REQUIRE(push_stamp(editor.edits, stamp, id).ok());
        (void)editor.update();
        return stamp_state(editor.edits, id);
    };
    // All the way back.
    CHECK(applied([](Stamp& s) { s.shape = StampShape::restore, s.radius_m = 1e6f; }).state == StampState::applied);
    CHECK((heights_of(t).heights_m == before));
    CHECK(editor.update().blocks == 0);
    // More blocks than there are, a cliff that no code bounds, heights that 16 bits do not hold: nothing changes.
    StampResult result = applied([](Stamp& s) { s.radius_m = 1e6f; });
    CHECK(result.state == StampState::refused);
    CHECK(std::string(result.status.field) == "EditBudget::blocks");
    result = applied([&](Stamp& s) { s.amount_m = quantum * 70'000; });
    CHECK(result.state == StampState::refused);
    CHECK(std::string(result.status.field).rfind("Stamp (", 0) == 0);
    result = applied([&](Stamp& s) { s.amount_m = cell * 500; });
    CHECK(result.state == StampState::refused);
    CHECK((heights_of(t).heights_m == before));
    // Handles.
    CHECK(push_stamp({}, good, id).code == StatusCode::invalid_handle);
    CHECK(stamp_state(editor.edits, 12345).state == StampState::unknown);
    EditReport report;
    CHECK(update_edits({}, {}, {}, report).code == StatusCode::invalid_handle);
    Edits second;
    const std::size_t bytes = edits_bytes(pack.terrain.header(), {});
    const auto memory = io::allocate(bytes);
    CHECK(create_edits(pack.terrain, {}, {memory.get(), bytes}, second).code == StatusCode::not_supported);
}

TEST_CASE("small diamonds are measured in vectors as they are sample by sample", "[edit]") {
    Random random(44);
    const Tree tree{7, 2, 2, 0, 0};
    const auto window = std::make_unique<edit::Window>();
    struct Ground {
        const Tree& tree;
        edit::Window& window;
        [[nodiscard]] std::int32_t h(SampleIndex v) const { return window.at(v).steps; }
        [[nodiscard]] static bool is_void(SampleIndex) { return false; }
    } const ground{tree, *window};
    for (int round = 0; round < rounds(30, 300); ++round) {
        window->rect = {64, 64, 64 + edit::window_side - 1, 64 + edit::window_side - 1};
        const int most = 1 << pick(random, 1, 19);
        for (edit::Cell& cell : window->cells) cell.steps = pick(random, -most, most);
        const edit::Plane plane{pick(random, 1, edit::measured_at_once), edit::sides_then_centres[pick(random, 0, 2)]};
        const edit::Rect squares = plane.squares(window->rect.grown(-(1 << plane.z)));
        const std::int32_t count = std::min(pick(random, 1, edit::diamond_lanes), squares.columns());
        const std::int32_t i = pick(random, squares.x0, squares.x1 + 1 - count),
                           j = pick(random, squares.y0, squares.y1);
        const auto from_sw = [&](SampleIndex v) { return diamond(tree, v).ends[0].row > v.row; };
        const bool centre = plane.kind == VertexKind::centre;
        const edit::DiamondRow row{&window->at(plane.at(i, j)),       plane.z, plane.kind, count,
                                   centre && from_sw(plane.at(i, j)), centre};
        CAPTURE(round, plane.z, static_cast<int>(plane.kind), count, i, j);
        std::int32_t vector[edit::diamond_lanes], scalar[edit::diamond_lanes];
        edit::worst_under(row, vector), edit::worst_under_scalar(row, scalar);
        for (std::int32_t k = 0; k < count; ++k) {
            const Diamond d = diamond(tree, plane.at(i + k, j));
            double worst = 0;
            for (const SampleIndex apex : d.apexes)
                worst = std::max(worst, diamonds::scan_triangle(ground, apex, d.ends[0], d.ends[1]).worst_steps);
            CHECK(vector[k] == worst * (2 << plane.z));
            CHECK(scalar[k] == vector[k]);
        }
    }
}
