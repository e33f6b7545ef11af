// The bulk pass: the whole cut at once.
#include <catch2/catch.hpp>

#include "shared/terrain_data.h"
#include "support/cut_scene.h"
#include "support/rounds.h"

using namespace fjell;
using namespace fjell::test;

TEST_CASE("a cut built at once is the same as one refined step by step, and lives on alike") {
    Random random(102);
    for (int round = 0; round < rounds(35, 150); ++round) {
        const auto pack = random_terrain(random, round % 5 == 4 ? 300 : 140, round % 5 == 4 ? 8 : 6);
        const Terrain& terrain = pack.terrain;
        Cut cut(terrain, ample_cut(terrain));
        View view = random_view(random, terrain);
        for (int frame = 0; frame < 8; ++frame) {
            cut.state().bulk.pages_together = static_cast<std::uint32_t>(pick(random, 1, 5));
            if (pick(random, 0, 2) == 0) view = random_view(random, terrain);
            view = moved(random, view, random_step_m(random, terrain));
            CutSettings settings;
            settings.max_error_px = random_threshold(random);
            const CutReport report =
                frame % 2 == 0 ? cut.rebuild({&view, 1}, settings) : cut.update({&view, 1}, settings);
            CAPTURE(round, frame, settings.max_error_px, data_of(terrain).tree.tile_log2,
                    data_of(terrain).tree.columns(), data_of(terrain).tree.rows());
            REQUIRE(check_cut(cut) == "");
            REQUIRE(report.converged);
            REQUIRE(triangles_of(cut.mesh()) == recursive_triangles(terrain, view, settings.max_error_px));
        }
    }
}

TEST_CASE("after a jump of the camera a whole mesh stands beside the one that is built, after every unit of work") {
    Random random(104);
    int frames_in[static_cast<std::size_t>(BulkPhase::installing_roots) + 1] = {}, rested = 0;
    for (int round = 0; round < rounds(24, 120); ++round) {
        const auto pack = random_terrain(random, round % 4 == 3 ? 300 : 140, round % 4 == 3 ? 8 : 6);
        const Terrain& terrain = pack.terrain;
        CutBudget budget = ample_cut(terrain, 2);
        if (round % 3 == 0) budget.vertices = std::max(budget.vertices / 4, terrain.tile_count() * 4 + 200);
        Cut cut(terrain, budget);
        if (round % 2 == 0) cut.state().bulk.pages_together = 1;
        std::vector<View> views{random_view(random, terrain)};
        CutSettings settings;
        settings.max_error_px = random_threshold(random);
        settings.morph = round % 4 == 1 ? Morph::error : Morph::none;
        const auto step = [&](std::uint32_t visits) {
            settings.visits = visits;
            settings.now_s += 1.0 / 60;
            const CutReport report = cut.update(views, settings);
            CAPTURE(round, settings.max_error_px, visits, views.size(), budget.vertices,
                    static_cast<int>(settings.morph));
            REQUIRE(check_frame(cut, terrain, report, settings) == "");
            ++frames_in[static_cast<std::size_t>(cut.state().bulk.phase)];
            REQUIRE((cut.state().bulk.phase == BulkPhase::idle || !report.converged));
            return report;
        };
        for (int leg = 0; leg < 3; ++leg) {
            for (int frame = 0; frame < 14; ++frame) {
                for (View& view : views) view = moved(random, view, random_step_m(random, terrain));
                if (frame % 7 == 0) views[0] = random_view(random, terrain);
                if (frame == 10 && views.size() == 1) views.push_back(random_view(random, terrain));
                if (frame == 12 && views.size() == 2) views.pop_back();
                (void)step(static_cast<std::uint32_t>(pick(random, 1, leg == 2 ? 400 : 25)));
            }
            if (budget.vertices != ample_cut(terrain, 2).vertices) continue;
            for (int frame = 0; frame < 40 && !step(unlimited_work).converged; ++frame) {
            }
            REQUIRE(difference(active_set(cut), settings.morph == Morph::none
                                                    ? target_set(terrain, terrain, views, settings.max_error_px)
                                                    : active_set(cut)) == "");
            ++rested;
        }
    }
    CAPTURE(frames_in);
    for (const BulkPhase phase : {BulkPhase::roots, BulkPhase::installing_roots}) // of more tiles than a unit takes
        CHECK(frames_in[static_cast<std::size_t>(phase)] > 0);
    for (const BulkPhase phase :
         {BulkPhase::centres, BulkPhase::sides, BulkPhase::triangles, BulkPhase::releasing, BulkPhase::installing})
        CHECK(frames_in[static_cast<std::size_t>(phase)] > rounds(10, 50));
    CHECK(rested > rounds(30, 150));
}

TEST_CASE("work items bound a first frame and a jump, which take as many of them whatever a frame may spend") {
    Random random(106);
    for (int round = 0; round < rounds(8, 60); ++round) {
        const auto pack = random_terrain(random, 300, 8);
        const Terrain& terrain = pack.terrain;
        Cut whole(terrain, ample_cut(terrain)), bounded(terrain, ample_cut(terrain));
        CutSettings settings;
        settings.max_error_px = random_threshold(random) / 4;
        settings.visits = unlimited_work - 1; // a limit that is never met: without one a jump is built from nothing
        CutSettings few = settings;
        few.max_work = static_cast<std::uint32_t>(pick(random, 20, 4'000));
        for (int jump = 0; jump < 3; ++jump) {
            const View view = random_view(random, terrain);
            const CutReport once = whole.update({&view, 1}, settings);
            REQUIRE(once.converged);
            std::uint64_t work = 0, frames = 0;
            CutReport report;
            do {
                report = bounded.update({&view, 1}, few);
                REQUIRE(report.work <= few.max_work);
                // And not in what it says only: a unit is a page at most.
                REQUIRE(report.vertices_changed <= few.max_work * parts_an_item + max_page_vertices);
                REQUIRE(report.triangles_changed <=
                        few.max_work * parts_an_item * triangles_a_part + 2 * max_page_vertices);
                work += report.work;
                CAPTURE(round, jump, few.max_work, once.work, work, ++frames);
                REQUIRE(check_frame(bounded, terrain, report, few) == "");
                REQUIRE(frames <= once.work * 1.1 / few.max_work + 3);
            } while (!report.converged);
            CAPTURE(round, jump, few.max_work, once.work, work, frames);
            CHECK(triangles_of(bounded.mesh()) == triangles_of(whole.mesh()));
            CHECK(work <= once.work * 1.1 + 10);
            // What is built beside takes fewer than one by one would.
            CHECK(once.work <= once.evaluations + once.activations + once.deactivations);
        }
    }
}

TEST_CASE("without a limit a jump and a zoom are built as a rebuild builds them, or followed where that is less work") {
    Random random(108);
    int built = 0, followed = 0;
    for (int round = 0; round < rounds(12, 80); ++round) {
        const auto pack = random_terrain(random, 300, 8);
        const Terrain& terrain = pack.terrain;
        Cut flown(terrain, ample_cut(terrain)), replayed(terrain, ample_cut(terrain));
        CutSettings settings;
        settings.max_error_px = random_threshold(random) / 4;
        View view = random_view(random, terrain);
        for (int frame = 0; frame < 6; ++frame) {
            if (frame % 3 == 1) view = random_view(random, terrain);
            if (frame % 3 == 2) view = moved(random, view, 20 * terrain.header().spacing_m[0]);
            if (frame == 3) settings.max_error_px *= 4;
            const double active = flown.state().mesh.capacity - free_vertices(flown.state().mesh),
                         pages = flown.state().pages.busy;
            const CutReport report = flown.update({&view, 1}, settings);
            Cut rebuilt(terrain, ample_cut(terrain));
            const CutReport anew = rebuilt.rebuild({&view, 1}, settings);
            CAPTURE(round, frame);
            REQUIRE(check_frame(flown, terrain, report, settings) == "");
            CHECK(report.converged);
            CHECK_FALSE(report.rebuilt); // the host has not asked for it
            CHECK(triangles_of(flown.mesh()) == triangles_of(rebuilt.mesh()));
            const bool is_built = report.work == anew.work && report.activations == anew.activations;
            if (frame == 0) CHECK(is_built);
            (is_built ? built : followed) += frame != 0;
            // What a build of what was there would have cost, twice; and the last batch, which is not cut short. Frames
            // that have neither leapt nor zoomed have no choice.
            if (!is_built && frame % 3 != 2) CHECK(report.work <= (active + 210 * pages) / 6 + 256 + 16 * 32);
            CutSettings again = settings;
            again.visits = report.visits; // a replay by visits does the same
            const CutReport repeated = replayed.update({&view, 1}, again);
            CHECK(repeated.work == report.work);
            CHECK(triangles_of(replayed.mesh()) == triangles_of(flown.mesh()));
        }
    }
    CHECK(built > 10);
    CHECK(followed > 10);
}

TEST_CASE("a camera that jumps in every frame is followed all the same, however few items and visits there are") {
    Random random(107);
    for (int round = 0; round < rounds(6, 40); ++round) {
        const auto pack = rich_terrain(random, 257, 8);
        const Terrain& terrain = pack.terrain;
        Cut cut(terrain, ample_cut(terrain));
        CutSettings settings;
        settings.max_error_px = 1;
        settings.max_work = round % 2 == 0 ? 60 : unlimited_work;
        settings.visits = round % 2 == 0 ? unlimited_work : 10;
        int installed = 0;
        for (int frame = 0; frame < 400; ++frame) {
            const View view = random_view(random, terrain);
            const CutReport report = cut.update({&view, 1}, settings);
            installed += report.activations != 0 && cut.state().bulk.phase >= BulkPhase::releasing;
            if (frame % 20 == 0) REQUIRE(check_frame(cut, terrain, report, settings) == "");
        }
        CAPTURE(round);
        CHECK(installed > 0);
    }
}

TEST_CASE("a jump that the clock has cut into frames is replayed by their visits") {
    Random random(105);
    int building = 0;
    for (int round = 0; round < rounds(6, 40); ++round) {
        const auto pack = random_terrain(random, 300, 8);
        const Terrain& terrain = pack.terrain;
        Cut flown(terrain, ample_cut(terrain)), replayed(terrain, ample_cut(terrain));
        View view = random_view(random, terrain);
        CutSettings settings;
        settings.max_error_px = random_threshold(random);
        for (int frame = 0; frame < 20; ++frame) {
            view = frame % 8 == 0 ? random_view(random, terrain) : moved(random, view, random_step_m(random, terrain));
            settings.max_time_us = pick(random, 0, 3) ? uniform(random, 1, 60) : 0;
            settings.visits = unlimited_work;
            const CutReport report = flown.update({&view, 1}, settings);
            building += flown.state().bulk.phase != BulkPhase::idle;
            settings.max_time_us = 0;
            settings.visits = report.visits;
            const CutReport again = replayed.update({&view, 1}, settings);
            CAPTURE(round, frame, report.visits);
            REQUIRE(again.visits == report.visits);
            REQUIRE(again.vertices == report.vertices);
            REQUIRE(triangles_of(replayed.mesh()) == triangles_of(flown.mesh()));
        }
    }
    CHECK(building > 0);
}

TEST_CASE("a host that copies only what was written has the mesh, from the first frame on") {
    Random random(103);
    for (int round = 0; round < rounds(30, 120); ++round) {
        const auto pack = random_terrain(random, 140, 6);
        const Terrain& terrain = pack.terrain;
        CutBudget budget = ample_cut(terrain);
        if (round % 3 == 0) { // a capacity is spent now and then
            budget.vertices = std::max(budget.vertices / 8, terrain.tile_count() * 4 + 20);
            budget.triangles = std::max(budget.triangles / 4, budget.segment_triangles * (terrain.tile_count() + 6));
        }
        Cut cut(terrain, budget);
        std::vector<MeshVertex> vertices(budget.vertices, MeshVertex{-1, -1, -1});
        std::vector<MorphVertex> morph(budget.vertices, MorphVertex{-1, -1, -1, -1});
        std::vector<std::uint32_t> indices(cut.mesh().indices.size(), 0xffffffff);
        View view = random_view(random, terrain);
        for (int frame = 0; frame < 12; ++frame) {
            if (pick(random, 0, 3) == 0) view = random_view(random, terrain);
            view = moved(random, view, random_step_m(random, terrain));
            CutSettings settings;
            settings.max_error_px = random_threshold(random);
            settings.morph = frame > 6 ? Morph::error : Morph::none;
            settings.now_s = frame;
            settings.max_work = pick(random, 0, 1) ? unlimited_work : 200;
            settings.visits = pick(random, 0, 1) ? unlimited_work : static_cast<std::uint32_t>(pick(random, 1, 90));
            pick(random, 0, 3) == 0 ? cut.rebuild({&view, 1}, settings) : cut.update({&view, 1}, settings);
            const CutMesh live = cut_mesh(cut.cut);
            const CutChanges changes = cut_take_changes(cut.cut);
            for_each_run(changes.vertex_bits, changes.vertex_words, [&](std::uint32_t first, std::uint32_t count) {
                for (std::uint32_t i = first; i < first + count; ++i) {
                    REQUIRE(i < budget.vertices);
                    vertices[i] = live.mesh.vertices[i], morph[i] = live.morph[i];
                }
            });
            for_each_run(changes.triangle_bits, changes.triangle_words, [&](std::uint32_t first, std::uint32_t count) {
                REQUIRE(3 * (first + count) <= indices.size());
                std::copy_n(live.mesh.indices.begin() + 3 * first, 3 * count, indices.begin() + 3 * first);
            });
            std::size_t stale = 0;
            for (const TileRange& range : cut.mesh().tiles)
                for (std::uint32_t i = range.first_index; i < range.first_index + range.index_count; ++i) {
                    const std::uint32_t slot = live.mesh.indices[i];
                    stale += indices[i] != slot || vertices[slot].column != live.mesh.vertices[slot].column ||
                             vertices[slot].row != live.mesh.vertices[slot].row ||
                             vertices[slot].height_m != live.mesh.vertices[slot].height_m ||
                             morph[slot].morph_from_m != live.morph[slot].morph_from_m ||
                             morph[slot].error_m != live.morph[slot].error_m;
                }
            CAPTURE(round, frame);
            REQUIRE(stale == 0);
        }
    }
}

TEST_CASE("a head that turns while a jump is built, between two parts of a page, leaves no vertex without a place") {
    Random random(109);
    const auto pack = rich_terrain(random, 513, 8);
    const Terrain& terrain = pack.terrain;
    const double extent = terrain.x_m(512);
    Cut cut(terrain, ample_cut(terrain));
    CutSettings settings;
    settings.max_error_px = 0.5;
    const auto look = [&](double x, double to) {
        return make_view({x, terrain.header().max_m + extent / 100, extent / 2}, {to, -0.1, 0}, {0, 1, 0}, 0.5, 640,
                         480, 1, 1e6);
    };
    View view = look(extent / 4, 1);
    (void)cut.rebuild({&view, 1}, settings);
    int built = 0;
    for (int jump = 0; jump < 4; ++jump)
        for (int frame = 0; frame < 400; ++frame) {
            view = look(jump % 2 == 0 ? extent * 0.7 : extent * 0.3, frame % 2 == 0 ? 1 : -1);
            settings.visits = frame == 399 ? unlimited_work : static_cast<std::uint32_t>(pick(random, 1, 3));
            (void)cut.update({&view, 1}, settings);
            built += cut.state().bulk.phase != BulkPhase::idle;
            CAPTURE(jump, frame, static_cast<int>(cut.state().bulk.phase));
            if (frame % 100 == 99) REQUIRE(check_cut(cut) == "");
        }
    CHECK(built > 100);
}
