// Holes that stamps cut and fill (fjell/edit.h): bounded after every step, at rest what a bake gives, and drawn whole.
#include <catch2/catch.hpp>

#include <cmath>
#include <utility>

#include "fjell/measure.h"
#include "fjell/query.h"
#include "support/edited_ground.h"
#include "support/rounds.h"

using namespace fjell;
using namespace fjell::test;

namespace {

constexpr EditBudget with_holes{.holes = true};

std::size_t holes_of(const TerrainData& t) {
    std::size_t holes = 0;
    for (std::int32_t y = 0; y < t.tree.rows(); ++y)
        for (std::int32_t x = 0; x < t.tree.columns(); ++x) holes += t.is_hole({x, y});
    return holes;
}

// Samples that are holes, as a stamp of their rectangle: what is given is the mask, which must stay.
Stamp stamp_of(const baker::Dem& dem, StampShape shape, std::vector<std::uint8_t>& mask) {
    mask.assign(dem.voids.size(), 0);
    for (std::size_t i = 0; i < mask.size(); ++i) mask[i] = dem.voids[i] != 0 ? 255 : 0;
    Stamp stamp;
    stamp.shape = shape;
    stamp.columns = dem.columns, stamp.rows = dem.rows;
    stamp.mask = mask.data();
    return stamp;
}

std::string difference_in_holes(const TerrainData& a, const TerrainData& b) {
    for (std::int32_t y = 0; y < a.tree.grid_rows(); ++y)
        for (std::int32_t x = 0; x < a.tree.grid_columns(); ++x)
            if (a.vertex({x, y}).hole != b.vertex({x, y}).hole)
                return "a hole differs at " + std::to_string(x) + ", " + std::to_string(y);
    return {};
}

// At rest: every error is what the ground under its triangles, and its children, ask for; no more.
std::string check_tight(const TerrainData& t) {
    struct Ground {
        const TerrainData& t;
        const Tree& tree = t.tree;
        [[nodiscard]] std::int32_t h(SampleIndex v) const { return t.vertex(v).steps; }
        [[nodiscard]] bool is_void(SampleIndex v) const { return t.vertex(v).hole; }
    } ground{t};
    const edit::Pads pads = edit::pads_of(t.header, t.tree);
    const DiamondTerms terms{t.errors,      t.header.quantum_m, {t.header.spacing_m[0], t.header.spacing_m[1]},
                             pads.ground_m, pads.height_m,      t.header.estimate == ErrorEstimate::midpoint};
    for (const SampleIndex v : all_vertices(t)) {
        std::uint32_t asked = diamond_error(ground, terms, v, [&](SampleIndex a) { return t.tree.contains(a); }).code;
        const Children below = children(v);
        for (int k = 0; k < below.count; ++k)
            if (t.tree.contains(below.at[k]))
                asked = std::max(asked, std::min(t.errors.above(t.vertex(below.at[k]).error_code), 255u));
        if (t.vertex(v).error_code != asked)
            return "an error is " + std::to_string(t.vertex(v).error_code) + ", and " + std::to_string(asked) +
                   " is asked for at " + std::to_string(v.column) + ", " + std::to_string(v.row);
    }
    return {};
}

// Some with holes, some with room for them.
io::LoadedPack terrain_with_room(Random& random, int most, int most_log2, bool for_cut = false) {
    const int log2 = pick(random, 1, most_log2);
    baker::Dem dem = random_dem(random, pick(random, 2, most), pick(random, 2, most),
                                pick(random, 0, 1) != 0 ? Shape::fractal : Shape::noise);
    baker::BakeOptions options = small_bake(log2);
    options.order = static_cast<PageOrder>(pick(random, 0, for_cut ? 1 : 2));
    options.estimate = pick(random, 0, 4) != 0 ? ErrorEstimate::max : ErrorEstimate::midpoint;
    options.room_for_holes = pick(random, 0, 1) != 0;
    if (!options.room_for_holes) add_random_holes(random, dem, log2);
    return bake_and_load(std::move(dem), options);
}

} // namespace

TEST_CASE("cut and filled holes are bounded after every step, and at rest errors are as small as they may be",
          "[edit]") {
    Random random(20261128);
    int applied = 0, cut = 0, filled = 0;
    for (int round = 0; round < rounds(12, 120); ++round) {
        const auto pack = terrain_with_room(random, 150, 7);
        const TerrainData& t = data_of(pack.terrain);
        CAPTURE(round, t.tree.tile_log2, t.tree.columns(), t.tree.rows(), static_cast<int>(t.header.order),
                static_cast<int>(t.header.estimate), t.header.voids);
        if (t.header.voids == t.header.columns * std::uint64_t{t.header.rows}) continue;
        REQUIRE(has_room_for_holes(t.header));
        Editor editor(pack.terrain, with_holes);
        for (int n = 0; n < 8; ++n) {
            const Stamp stamp = random_stamp(random, pack.terrain, true);
            const std::size_t before = holes_of(t);
            const StampId id = editor.push(stamp);
            EditReport report = editor.update(pick(random, 0, 1) != 0 ? 1 : 40);
            for (int step = 0; stamp_state(editor.edits, id).state == StampState::waiting; ++step) {
                REQUIRE(step < 1000);
                if (step % 5 == 0 && t.header.estimate == ErrorEstimate::max) REQUIRE(check_bounds(t) == "");
                report = editor.update(1);
            }
            const StampResult result = stamp_state(editor.edits, id);
            CAPTURE(n, static_cast<int>(stamp.shape), result.status.field);
            applied += result.state == StampState::applied;
            cut += holes_of(t) > before;
            filled += holes_of(t) < before;
            if (t.header.estimate == ErrorEstimate::max) REQUIRE(check_bounds(t) == "");
            if (pick(random, 0, 1) != 0) continue;
            report = editor.update();
            REQUIRE(report.loose + report.unmeasured == 0);
            REQUIRE(check_tight(t) == "");
        }
        (void)editor.update();
        REQUIRE(check_tight(t) == "");
    }
    CHECK(applied > rounds(30, 400));
    CHECK(cut > rounds(10, 150));
    CHECK(filled > rounds(2, 40));
}

TEST_CASE("ground that is cut is what a bake of it gives, bit for bit, and so is what is filled again", "[edit]") {
    Random random(20261129);
    int compared = 0;
    for (int round = 0; round < rounds(8, 80); ++round) {
        const int log2 = pick(random, 2, 7);
        baker::Dem dem = random_dem(random, pick(random, 20, 150), pick(random, 20, 150), Shape::fractal);
        dem.native_quantum_m = 0.01 * dem.spacing_m[0];
        baker::BakeOptions options = small_bake(log2);
        options.order = static_cast<PageOrder>(pick(random, 0, 2));
        options.room_for_holes = true;
        add_random_holes(random, dem, log2);
        const auto holed = bake_and_load(dem, options);
        // The same, and the ground under its holes, which the bake has continued, is ground.
        baker::Dem solid = heights_of(data_of(holed.terrain));
        solid.native_quantum_m = holed.terrain.header().quantum_m;
        const auto pack = bake_and_load(solid, options), as_it_was = bake_and_load(solid, options);
        const TerrainData &t = data_of(pack.terrain), &baked = data_of(holed.terrain);
        CAPTURE(round, log2, dem.columns, dem.rows, static_cast<int>(options.order));
        if (t.header.quantum_m != baked.header.quantum_m || t.header.base_m != baked.header.base_m ||
            t.header.error_floor_m != baked.header.error_floor_m || t.header.error_ratio != baked.header.error_ratio)
            continue; // where a void was the highest
        Editor editor(pack.terrain, with_holes);
        std::vector<std::uint8_t> mask;
        const StampId cut = editor.push(stamp_of(dem, StampShape::hole, mask));
        (void)editor.update();
        INFO(stamp_state(editor.edits, cut).status.field);
        REQUIRE(stamp_state(editor.edits, cut).state == StampState::applied);
        REQUIRE(difference_in_holes(t, baked) == "");
        REQUIRE(difference_of(t, baked) == "");
        ++compared;
        const StampShape back = pick(random, 0, 1) != 0 ? StampShape::fill : StampShape::restore;
        const StampId filled = editor.push(stamp_of(dem, back, mask));
        const EditReport report = editor.update();
        REQUIRE(stamp_state(editor.edits, filled).state == StampState::applied);
        CHECK(report.blocks == 0);
        REQUIRE(difference_in_holes(t, data_of(as_it_was.terrain)) == "");
        REQUIRE(difference_of(t, data_of(as_it_was.terrain)) == "");
    }
    CHECK(compared > rounds(3, 40));
}

TEST_CASE("a live cut takes out what is cut, and puts back what is filled: whole, bounded, in every frame", "[edit]") {
    Random random(20261130);
    int changed = 0, hidden = 0;
    for (int round = 0; round < rounds(8, 80); ++round) {
        const auto pack = terrain_with_room(random, 120, 6, true);
        const TerrainData& t = data_of(pack.terrain);
        CAPTURE(round, t.tree.tile_log2, t.tree.columns(), t.tree.rows(), static_cast<int>(t.header.estimate));
        Editor editor(pack.terrain, with_holes);
        Cut cut(pack.terrain, ample_cut(pack.terrain));
        Recursive strips(pack.terrain, ample_budget(pack.terrain));
        CutSettings settings;
        settings.max_error_px = random_threshold(random);
        std::vector<View> views{random_view(random, pack.terrain)};
        for (int frame = 0; frame < 30; ++frame) {
            CAPTURE(frame);
            if (pick(random, 0, 1) == 0) editor.push(random_stamp(random, pack.terrain, true));
            const std::size_t before = holes_of(t);
            const EditReport edited = editor.update(
                pick(random, 0, 1) ? unlimited_edit_work : static_cast<std::uint32_t>(pick(random, 0, 60)));
            changed += holes_of(t) != before;
            if (pick(random, 0, 9) == 0) views[0] = random_view(random, pack.terrain);
            views[0] = moved(random, views[0], random_step_m(random, pack.terrain));
            settings.max_work = pick(random, 0, 1) ? unlimited_work : static_cast<std::uint32_t>(pick(random, 0, 200));
            settings.morph = static_cast<Morph>(pick(random, 0, 2));
            settings.offscreen_factor = pick(random, 0, 2) == 0 ? uniform(random, 1, 8) : 1;
            settings.now_s += 1.0 / 60;
            const CutReport report = cut.update(views, settings);
            const bool followed = cut.state().pages.seen_ground == t.ground_changes;
            REQUIRE((followed || cut.state().bulk.phase != BulkPhase::idle));
            REQUIRE((followed ? check_frame(cut, pack.terrain, report, settings) : check_cut(cut)) == "");
            hidden += cut.state().mesh.tiles[hidden_tile(cut.state().mesh)].total != 0;
            if (t.header.estimate == ErrorEstimate::midpoint || !followed) continue;
            const CutMesh live = cut_mesh(cut.cut);
            MeshView mesh = cut.mesh();
            const std::vector<MeshVertex> drawn = drawn_vertices(pack.terrain, live);
            mesh.vertices = drawn;
            const Frustum frustum = make_frustum(views[0]);
            const MeasuredError measured =
                measure_error(pack.terrain, mesh, views[0], settings.offscreen_factor > 1 ? &frustum : nullptr);
            CAPTURE(settings.max_error_px, report.threshold_px, measured.max_m, edited.loose);
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
        // The method that has been there all the time draws the same.
        RefineSettings refine;
        refine.max_error_px = settings.max_error_px;
        refine.cull = false;
        refine.topology = Topology::strip;
        (void)strips.update(views[0], refine);
        CHECK(triangles_of(strips.mesh()) == triangles_of(cut.mesh()));
    }
    CHECK(changed > rounds(30, 300));
    CHECK(hidden > rounds(30, 300));
}

TEST_CASE("a mesh that was drawn before edits came, and one whose slots are all taken, follow holes too", "[edit]") {
    Random random(20261131);
    int short_of_segments = 0;
    for (int round = 0; round < rounds(20, 200); ++round) {
        baker::Dem dem = random_dem(random, 129, 129, Shape::fractal);
        baker::BakeOptions options = small_bake(pick(random, 3, 5));
        options.room_for_holes = true;
        const auto pack = bake_and_load(std::move(dem), options);
        const TerrainData& t = data_of(pack.terrain);
        CAPTURE(round, t.tree.tile_log2);
        CutBudget budget = ample_cut(pack.terrain);
        budget.segment_triangles = 64;
        budget.triangles = (t.tile_count() + 3 + static_cast<std::uint32_t>(pick(random, 0, 12))) * 64;
        Cut cut(pack.terrain, budget);
        CutSettings settings;
        settings.max_error_px = 0.05;
        const std::vector<View> views{random_view(random, pack.terrain)};
        Editor editor(pack.terrain, with_holes);
        for (int frame = 0; frame < 12; ++frame) {
            CAPTURE(frame);
            const std::uint32_t free = cut.state().mesh.free_segment_count;
            if (frame % 3 == 2) {
                Stamp stamp = random_stamp(random, pack.terrain);
                stamp.shape = frame == 5 ? StampShape::fill : StampShape::hole;
                stamp.radius_m = static_cast<float>(uniform(random, 0.1, 1)) * pack.terrain.extent_x_m();
                editor.push(stamp);
                (void)editor.update();
            }
            const CutReport report = cut.update(views, settings);
            short_of_segments += free <= 2 && (report.exhausted & cut_budget_triangles) != 0;
            if (cut.state().pages.seen_ground != t.ground_changes) continue;
            REQUIRE(check_frame(cut, pack.terrain, report, settings) == "");
        }
    }
    CHECK(short_of_segments > rounds(5, 50));
}

TEST_CASE("pages that leave come back with their holes", "[edit]") {
    Random random(20261132);
    Happened sum;
    std::size_t holes = 0;
    for (int round = 0; round < rounds(8, 80); ++round) {
        CAPTURE(round);
        const bool large = pick(random, 0, 1) != 0;
        const int log2 = large ? pick(random, 7, 9) : pick(random, 1, 5), most = large ? 300 : std::min(90, 20 << log2);
        baker::Dem dem = random_dem(random, pick(random, 2, most), pick(random, 2, most),
                                    pick(random, 0, 1) ? Shape::fractal : Shape::noise);
        baker::BakeOptions options = small_bake(log2);
        options.order = pick(random, 0, 1) != 0 ? PageOrder::planar : PageOrder::hierarchical_z;
        options.room_for_holes = pick(random, 0, 1) != 0;
        if (!options.room_for_holes) add_random_holes(random, dem, log2);
        const auto pack = bake_and_load(std::move(dem), options);
        dig_while_pages_leave(random, pack, 30, 3, sum, true);
        holes += sum.holes;
    }
    CHECK(sum.changed > rounds(15, 150));
    CHECK(sum.left > rounds(15, 150));
    CHECK(holes > 100);
}

TEST_CASE("all that speaks of the ground says where a hole is, from the update on that has cut it", "[edit]") {
    Random random(20261133);
    baker::Dem dem = random_dem(random, 129, 129, Shape::fractal);
    dem.spacing_m[0] = dem.spacing_m[1] = 2;
    baker::BakeOptions options = small_bake(6);
    options.room_for_holes = true;
    const auto pack = bake_and_load(std::move(dem), options);
    Editor editor(pack.terrain, with_holes);
    const double x = 120, z = 140;
    Stamp stamp;
    stamp.shape = StampShape::hole, stamp.x_m = x, stamp.z_m = z, stamp.radius_m = 9, stamp.morph_s = 5;
    const double height_m = ground_height(pack.terrain, x, z).height_m;
    const auto hit_m = [&] {
        const GroundHit hit = cast_ray(pack.terrain, {x, height_m + 50, z}, {0, -1, 0}, 1000);
        return hit.hit ? hit.distance_m : -1;
    };
    const auto patch_holes = [&] {
        float heights[16 * 16];
        bool holes[16 * 16];
        (void)ground_patch(pack.terrain, {52, 62}, 0, 16, heights, holes);
        return std::count(std::begin(holes), std::end(holes), true);
    };
    CHECK(!ground_height(pack.terrain, x, z).hole);
    CHECK(patch_holes() == 0);
    const double to_ground_m = hit_m();
    CHECK(to_ground_m > 0);
    const StampId id = editor.push(stamp);
    const EditReport report = editor.update();
    CHECK(stamp_state(editor.edits, id).state == StampState::applied); // at once, whatever morph_s says
    CHECK(report.samples == 69);                                       // within 4.5 samples
    CHECK(pack.terrain.has_voids());
    CHECK(ground_height(pack.terrain, x, z).hole);
    CHECK(patch_holes() == 69);
    CHECK(hit_m() == -1);
    std::uint64_t cursor = 0;
    GroundRect rects[4];
    bool lost = false;
    REQUIRE(take_ground_changes(editor.edits, cursor, rects, lost) == 1);
    CHECK((rects[0].first.column == 56 && rects[0].first.row == 66 && rects[0].last.column == 64 &&
           rects[0].last.row == 74));
    // Ground that is raised there stays a hole; what is filled has its height of before.
    Stamp raise = stamp;
    raise.shape = StampShape::raise, raise.amount_m = 3;
    editor.push(raise);
    CHECK(editor.update().samples == 0);
    stamp.shape = StampShape::fill;
    editor.push(stamp);
    CHECK(editor.update().blocks == 0);
    CHECK(!ground_height(pack.terrain, x, z).hole);
    CHECK(ground_height(pack.terrain, x, z).height_m == height_m);
    CHECK(hit_m() == to_ground_m);
}

TEST_CASE("a hole is refused by name where no budget has it, or the pack has no room for it", "[edit]") {
    Random random(20261134);
    // Flat, and in fine steps: others have the room anyway.
    baker::Dem dem = random_dem(random, 65, 65, Shape::flat);
    dem.spacing_m[0] = dem.spacing_m[1] = 10;
    dem.native_quantum_m = 0x1p-12;
    for (std::size_t i = 0; i < dem.heights_m.size(); ++i) dem.heights_m[i] = 0x1p-8f * static_cast<float>(i % 7);
    const auto solid = bake_and_load(dem, small_bake(5));
    baker::BakeOptions options = small_bake(5);
    options.room_for_holes = true;
    const auto roomy = bake_and_load(dem, options);
    CHECK(!has_room_for_holes(solid.terrain.header()));
    CHECK(has_room_for_holes(roomy.terrain.header()));
    CHECK(!has_room_for_holes({}));
    CHECK(edits_bytes(solid.terrain.header(), {}) + 1024 * 260 <= edits_bytes(solid.terrain.header(), with_holes));
    for (const StampShape shape : {StampShape::hole, StampShape::fill}) {
        Stamp stamp;
        stamp.shape = shape, stamp.radius_m = 100, stamp.x_m = stamp.z_m = 300;
        StampId id = 0;
        const auto refusal = [&](const io::LoadedPack& pack, const EditBudget& budget) {
            Editor editor(pack.terrain, budget);
            const Status s = push_stamp(editor.edits, stamp, id);
            CHECK((s.ok() || s.code == StatusCode::out_of_range));
            CHECK(editor.update().samples == (s.ok() ? 317 : 0)); // the ground stays as it is edited
            return std::string(s.field);
        };
        CHECK(refusal(roomy, {}) == "EditBudget::holes");
        CHECK(refusal(solid, with_holes) == "Stamp::shape (holes need a pack that is baked with --room-for-holes yes)");
        CHECK(refusal(roomy, with_holes) == "");
    }
}
