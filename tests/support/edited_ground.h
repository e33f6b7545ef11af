// Terrains whose ground is edited, and yardsticks for it: slow and simple.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "edit/radii.h"
#include "fjell/edit.h"
#include "fjell/pages.h"
#include "shared/diamond_error.h"
#include "support/paging_host.h"

namespace fjell::test {

struct Editor {
    Editor(const Terrain& terrain, EditBudget budget = {})
        : memory(io::allocate(edits_bytes(terrain.header(), budget))) {
        REQUIRE(create_edits(terrain, budget, {memory.get(), edits_bytes(terrain.header(), budget)}, edits).ok());
    }
    ~Editor() { (void)destroy_edits(edits); }
    Editor(const Editor&) = delete;
    Editor& operator=(const Editor&) = delete;
    StampId push(const Stamp& stamp) {
        StampId id = 0;
        const Status s = push_stamp(edits, stamp, id);
        INFO(s.field);
        REQUIRE(s.ok());
        return id;
    }
    EditReport update(std::uint32_t most = unlimited_edit_work, double now_s = 0) {
        EditReport report;
        EditSettings settings;
        settings.max_work = most;
        settings.now_s = now_s;
        REQUIRE(update_edits(edits, {}, settings, report).ok());
        return report;
    }
    io::AlignedMemory memory;
    Edits edits;
};

// holes: half of them cut some, or fill some. locks: a third of them lock places, or unlock them.
inline Stamp random_stamp(Random& random, const Terrain& terrain, bool holes = false, bool locks = false) {
    const double wx = terrain.extent_x_m(), wz = terrain.extent_z_m(), cell = terrain.spacing_x_m();
    const double relief =
        std::max<double>(terrain.header().max_m - terrain.header().min_m, terrain.header().quantum_m * 20);
    Stamp s;
    s.shape = static_cast<StampShape>(pick(random, 0, 7));
    if (s.shape == StampShape::heights || s.shape == StampShape::path) s.shape = StampShape::raise;
    s.x_m = uniform(random, -0.1, 1.1) * wx, s.z_m = uniform(random, -0.1, 1.1) * wz;
    s.radius_m = static_cast<float>(cell * std::pow(10.0, uniform(random, -0.3, 1.3)));
    s.falloff_m = static_cast<float>(pick(random, 0, 1) * static_cast<double>(s.radius_m) * uniform(random, 0.2, 2));
    s.amount_m = static_cast<float>(relief * uniform(random, -0.06, 0.06));
    s.height_m = static_cast<float>(uniform(random, terrain.header().min_m, terrain.header().max_m));
    s.wavelength_m = static_cast<float>(cell * uniform(random, 1, 20));
    s.seed = static_cast<std::uint32_t>(pick(random, 0, 1000));
    if (holes && pick(random, 0, 1) != 0) s.shape = pick(random, 0, 2) != 0 ? StampShape::hole : StampShape::fill;
    if (locks && pick(random, 0, 2) == 0) {
        s.shape = pick(random, 0, 2) != 0 ? StampShape::lock : StampShape::unlock;
        s.amount_m = pick(random, 0, 3) == 0 ? 0 : static_cast<float>(relief * std::exp2(uniform(random, -12, -3)));
    }
    return s;
}

inline std::vector<SampleIndex> all_vertices(const TerrainData& t) {
    std::vector<SampleIndex> all;
    for (std::int32_t y = 0; y < t.tree.grid_rows(); ++y)
        for (std::int32_t x = 0; x < t.tree.grid_columns(); ++x)
            if (!t.tree.is_corner({x, y})) all.push_back({x, y});
    return all;
}

// The heights that diamonds are measured over.
struct LoadedGround {
    const TerrainData& t;
    const Tree& tree = t.tree;
    [[nodiscard]] std::int32_t h(SampleIndex v) const { return t.vertex(v).steps; }
    [[nodiscard]] bool is_void(SampleIndex v) const { return t.has_voids() && t.vertex(v).hole; }
};

// Heights, errors and spheres of all vertices that are loaded: nested, and errors no less than the ground under their
// triangles asks. truth: a terrain with the same ground, all of it loaded.
inline std::string check_bounds(const TerrainData& t, const TerrainData& truth) {
    const LoadedGround ground{truth};
    const DiamondTerms terms{t.errors, t.header.quantum_m, {t.header.spacing_m[0], t.header.spacing_m[1]}, 0, 0, false};
    const auto at = [](SampleIndex v) { return std::to_string(v.column) + ", " + std::to_string(v.row); };
    for (const SampleIndex v : all_vertices(t)) {
        const TerrainData::Vertex own = t.vertex(v);
        if (!own.loaded) continue;
        if (own.steps != truth.vertex(v).steps) return "a height is another one at " + at(v);
        if (own.hole != truth.vertex(v).hole) return "a hole is another one at " + at(v);
        const std::uint32_t asked =
            diamond_error(ground, terms, v, [&](SampleIndex a) { return t.tree.contains(a); }).code;
        if (own.error_code < asked)
            return "an error is too small at " + at(v) + ": " + std::to_string(own.error_code) + " of " +
                   std::to_string(asked);
        const SampleIndex p = t.tree.sample(v);
        const Children below = children(v);
        for (int k = 0; k < below.count; ++k) {
            if (!t.tree.contains(below.at[k])) continue;
            const TerrainData::Vertex child = t.vertex(below.at[k]);
            if (!child.loaded) continue;
            if (own.error_code < std::min(t.errors.above(child.error_code), 255u))
                return "errors do not nest at " + at(v) + ": " + std::to_string(own.error_code) + ", child " +
                       at(below.at[k]) + ": " + std::to_string(child.error_code) + ", tiles of " +
                       std::to_string(t.tree.side()) + ", " + std::to_string(t.tree.columns()) + " x " +
                       std::to_string(t.tree.rows());
            const SampleIndex q = t.tree.sample(below.at[k]);
            const double dx = t.x_m(p.column) - t.x_m(q.column), dz = t.z_m(p.row) - t.z_m(q.row),
                         dy = static_cast<double>(own.height_m) - static_cast<double>(child.height_m);
            if (std::sqrt(dx * dx + dy * dy + dz * dz) + static_cast<double>(child.radius_m) >
                static_cast<double>(own.radius_m))
                return "spheres do not nest at " + at(v) + ": " + std::to_string(own.radius_m) + " m, child " +
                       at(below.at[k]) + ": " + std::to_string(child.radius_m) + " m";
        }
    }
    return {};
}
inline std::string check_bounds(const TerrainData& t) {
    return check_bounds(t, t);
}

// As if the ground had always been like this: its heights baked, with the same scales because the least and the most,
// and the steepest step, are those of a corner that no stamp touches.
inline baker::Dem heights_of(const TerrainData& t) {
    baker::Dem dem;
    dem.columns = t.tree.columns(), dem.rows = t.tree.rows();
    dem.spacing_m[0] = t.header.spacing_m[0], dem.spacing_m[1] = t.header.spacing_m[1];
    for (std::int32_t y = 0; y < dem.rows; ++y)
        for (std::int32_t x = 0; x < dem.columns; ++x) dem.heights_m.push_back(t.height_m({x, y}));
    return dem;
}

inline std::string difference_of(const TerrainData& a, const TerrainData& b) {
    std::size_t heights = 0, errors = 0, radii = 0;
    SampleIndex first{-1, -1};
    for (const SampleIndex v : all_vertices(a)) {
        const TerrainData::Vertex p = a.vertex(v), q = b.vertex(v);
        const bool same = p.height_m == q.height_m && p.error_code == q.error_code && p.radius_m == q.radius_m;
        if (!same && first.column < 0) first = v;
        heights += p.height_m != q.height_m;
        errors += p.error_code != q.error_code;
        radii += p.radius_m != q.radius_m;
    }
    if (first.column < 0) return {};
    const TerrainData::Vertex p = a.vertex(first), q = b.vertex(first);
    return std::to_string(heights) + " heights, " + std::to_string(errors) + " errors and " + std::to_string(radii) +
           " radii differ, first at " + std::to_string(first.column) + ", " + std::to_string(first.row) + ": code " +
           std::to_string(p.error_code) + " for " + std::to_string(q.error_code) + ", radius " +
           std::to_string(p.radius_m) + " for " + std::to_string(q.radius_m) + ", height " +
           std::to_string(p.height_m) + " for " + std::to_string(q.height_m);
}

// A terrain whose scales no stamp inside changes: the lowest and the highest sample lie side by side in a corner.
inline io::LoadedPack framed_terrain(Random& random, int tile_log2, std::int32_t columns, std::int32_t rows,
                                     PageOrder order, bool room_for_holes = false, bool room_for_locks = false) {
    baker::Dem dem = random_dem(random, columns, rows, pick(random, 0, 1) ? Shape::fractal : Shape::noise);
    const auto [low, high] = std::minmax_element(dem.heights_m.begin(), dem.heights_m.end());
    const double range = std::max(static_cast<double>(*high) - static_cast<double>(*low), 1.0), quantum = range / 2000;
    const double least = static_cast<double>(*low) - 3 * range, most = static_cast<double>(*high) + 3 * range;
    for (float& h : dem.heights_m) h = static_cast<float>(std::round((static_cast<double>(h) - least) / quantum));
    const auto top = static_cast<float>(std::round((most - least) / quantum));
    for (const auto& [x, y] : {std::pair{0, 0}, {1, 1}}) dem.heights_m[dem.index(x, y)] = 0, (void)y;
    dem.heights_m[dem.index(1, 0)] = dem.heights_m[dem.index(0, 1)] = top;
    dem.native_quantum_m = 1;
    baker::BakeOptions options = small_bake(tile_log2);
    options.order = order;
    options.room_for_holes = room_for_holes;
    options.room_for_locks = room_for_locks;
    return bake_and_load(std::move(dem), options);
}

inline bool touches_frame(const Terrain& terrain, const Stamp& s) {
    const double out = static_cast<double>(s.radius_m) + static_cast<double>(s.falloff_m) + 4 * terrain.spacing_x_m() +
                       4 * terrain.spacing_z_m();
    return s.x_m - out < 0 && s.z_m - out < 0;
}

struct Happened {
    int frames = 0, changed = 0, left = 0; // frames, stamps that changed something, frames with pages missing
    int steps = 0;                         // of edits, each in a frame with others
    std::size_t holes = 0;                 // in the end
    int locks = 0;
};

// Frames in which stamps, cameras, budgets and pages come and go, beside the same stamps where all pages stay. The mesh
// is whole after each; every some frames the terrain is nested, and bounds the ground.
inline void dig_while_pages_leave(Random& random, const io::LoadedPack& pack, int frames, int check_every,
                                  Happened& sum, bool holes = false, bool locks = false) {
    PagedTerrain paged(pack.pack, {}), still(pack.pack, {});
    const TerrainData& t = data_of(paged.terrain);
    const EditBudget edits{.holes = holes};
    Editor editor(paged.terrain, edits), other(still.terrain, edits); // the same stamps where nothing leaves
    CutBudget budget = ample_cut(paged.terrain);
    budget.views = 2;
    budget.morph = pick(random, 0, 1) != 0;
    Cut cut(paged.terrain, budget), cut_of_still(still.terrain, ample_cut(still.terrain));
    Host host{random, pack.pack, paged.terrain, cut, false, {}, {}};
    Host loader{random, pack.pack, still.terrain, cut_of_still, false, {}, {}};
    host.load_all();
    loader.load_all();
    const auto keep_all = [&] {
        while (host.keep()) {
        }
        host.just_unloaded.clear();
        host.load_all();
    };
    CutSettings settings;
    settings.max_error_px = random_threshold(random);
    std::vector<View> views{random_view(random, pack.terrain)};
    for (int frame = 0; frame < frames; ++frame, ++sum.frames) {
        CAPTURE(frame);
        if (pick(random, 0, 3) == 0) {
            Stamp stamp = random_stamp(random, pack.terrain, holes, locks);
            sum.locks += stamp.shape == StampShape::lock;
            if (pick(random, 0, 9) == 0) stamp.shape = StampShape::restore, stamp.radius_m = 1e6f;
            const StampId id = editor.push(stamp);
            sum.changed += editor.update().samples != 0;
            if (stamp_state(editor.edits, id).state == StampState::waiting) { // held until its pages come
                keep_all();
                (void)editor.update();
            }
            const StampState state = stamp_state(editor.edits, id).state;
            REQUIRE(state != StampState::waiting);
            const StampId same = other.push(stamp);
            (void)other.update();
            REQUIRE(stamp_state(other.edits, same).state == state);
        }
        host.act();
        sum.left += t.pages_missing != 0;
        sum.steps += static_cast<int>(editor.update(static_cast<std::uint32_t>(pick(random, 0, 50))).work);
        if (pick(random, 0, 19) == 0) views.resize(1, views[0]);
        if (pick(random, 0, 19) == 0) views.assign(2, random_view(random, pack.terrain));
        for (View& view : views) view = moved(random, view, random_step_m(random, pack.terrain));
        if (pick(random, 0, 19) == 0) settings.max_work = pick(random, 0, 1) != 0 ? unlimited_work : 100;
        (void)cut.update(views, settings);
        REQUIRE(check_cut(cut) == "");
        if (frame % check_every == 0) REQUIRE(check_bounds(t, data_of(still.terrain)) == "");
    }
    keep_all();
    REQUIRE(t.pages_missing == 0);
    REQUIRE(check_bounds(t) == "");
    (void)editor.update();
    (void)other.update();
    const EditReport last = editor.update();
    CAPTURE(last.loose, last.unmeasured, last.blocks, t.tree.tile_log2, t.tree.columns(), t.tree.rows(), t.has_voids());
    CHECK(last.loose == 0);
    for (const SampleIndex v : all_vertices(t)) sum.holes += t.vertex(v).hole;
    // All is that of the ground that stood still.
    for (const SampleIndex v : all_vertices(t)) {
        const TerrainData::Vertex a = t.vertex(v), b = data_of(still.terrain).vertex(v);
        if (a.steps != b.steps || a.hole != b.hole || a.error_code != b.error_code || a.radius_m != b.radius_m) {
            FAIL_CHECK("vertex " << v.column << ", " << v.row << " is not what it is where nothing leaves");
            break;
        }
    }
}

} // namespace fjell::test
