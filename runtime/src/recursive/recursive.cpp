// Thesis 5.4 (figures 5.4, 5.6, 5.8), after Lindstrom and Pascucci, "Visualization of Large Terrains Made Easy" (2001).
// Departures are listed in fjell/recursive.h.
//
// Order of a strip. A triangle (apex, left, right), counter-clockwise from above, is entered at one end of its
// hypotenuse and left at the other: at `left` on even levels, at `right` on odd ones. The vertex m in the middle of the
// hypotenuse splits it into (m, apex, left) and (m, right, apex); the first of the two on the way is the one that holds
// the end we came in by, and both are entered from the opposite kind of end. So the two orders of figure 5.5 alternate
// by level, and vertices of alternating level parity alternate in the strip, which fixes the winding.
#include <algorithm>
#include <bit>
#include <limits>

#include "recursive/emit.h"
#include "recursive/locate.h"
#include "recursive/state.h"
#include "view/wanted.h"

namespace fjell {

namespace {

// A vertex as the recursion carries it: x in the low and y in the high 16 bits, so that the middle of two is
// (a + b) >> 1 in one operation (sums of coordinates are even there and stay below 2^14).
struct Corner {
    std::uint32_t xy, slot;
};

constexpr std::uint32_t pack_xy(std::uint32_t x, std::uint32_t y) {
    return x | y << 16;
}

constexpr std::uint32_t all_planes = 0b111111; // of the frustum
constexpr std::uint32_t not_selected = 0xffffffff;

// Beyond this threshold only spheres that hold the eye select anything; a pass above it draws base triangles only,
// which every budget can hold.
constexpr double hopeless_px = 1e7;
constexpr double step_up = 1.25, step_down = 1 / 1.05;

// What one pass over all tiles found out.
struct PassResult {
    std::uint32_t selected = 0, triangles = 0, tiles = 0, written = 0, clearings = 0;
    std::uint32_t exhausted = 0; // BudgetBits; when set, the mesh is not usable
};

template <Order O, bool Cull, Metric M, Topology T>
class Pass {
public:
    Pass(RecursiveState& state, const View& the_view, double threshold_px)
        : s(state), terrain(*state.terrain), view(the_view), frustum(make_frustum(the_view)),
          reach(make_reach(the_view, threshold_px)), base(state.pass * 3), nearest_m(the_view.near_m),
          states(state.states), records(terrain.records), error_m(terrain.errors.metres),
          radius_factor(terrain.radii.factor), holes(terrain.has_voids()), incomplete(terrain.pages_missing != 0),
          emit(state) {
        LevelPlane* to = levels; // three a step: centre, side_x, side_y
        for (int z = terrain.tree.tile_log2; z-- > 0;)
            for (const VertexKind kind : {VertexKind::centre, VertexKind::side_x, VertexKind::side_y})
                *to++ = make_level_plane(terrain, z, kind);
        last_planes = to;
        if (threshold_px > hopeless_px) select_none();
    }

    PassResult run() {
        s.tile_count = 0;
        const Tree& tree = terrain.tree;
        for (std::int32_t ty = 0; ty < tree.tiles_y && !result.exhausted; ++ty)
            for (std::int32_t tx = 0; tx < tree.tiles_x && !result.exhausted; ++tx) tessellate(tx, ty);
        s.index_count = emit.cursor();
        return result;
    }

private:
    void tessellate(std::int32_t tx, std::int32_t ty) {
        side = terrain.pages.side();
        const auto tile = static_cast<std::uint32_t>(ty * terrain.tree.tiles_x + tx);
        const auto n = static_cast<std::int32_t>(side);
        column0 = tx * n;
        row0 = ty * n;
        step_pages = s.step_pages + std::size_t{tile} * s.step_pages_per_tile;
        limit_x = terrain.tree.columns() - 1 - column0;
        limit_y = terrain.tree.rows() - 1 - row0;
        some_not_drawn = holes || limit_x < n || limit_y < n;
        if (Cull && root_outside()) return;

        const std::uint32_t first_index = emit.cursor(), triangles_before = result.triangles;
        const Corner nw = corner(tile, 0, 0), ne = corner(tile, 1, 0), sw = corner(tile, 0, 1), se = corner(tile, 1, 1);
        if constexpr (T == Topology::strip) emit.begin_strip(nw.slot);
        root(ne, nw, se);
        if constexpr (T == Topology::strip) {
            // Three times the far corner: only degenerate triangles, and the second half starts at an odd place as
            // the first one did, so that the winding stays.
            emit.append(se.slot, 0);
            emit.push(se.slot);
            emit.push(se.slot);
        }
        root(sw, se, nw);
        if constexpr (T == Topology::strip) emit.append(nw.slot, 0);
        if (emit.full()) give_up(budget_indices);
        s.tiles[s.tile_count++] = {tile, first_index, emit.cursor() - first_index, result.triangles - triangles_before};
        ++result.tiles;
    }

    // A vertex on its way through meshRefine: where it lies and what became of it.
    struct Node {
        std::uint32_t xy, index;
        std::uint32_t planes; // not_selected, or the frustum planes that its sphere may still cross
    };

    // The vertex in the middle of a triangle's hypotenuse, evaluated (evalTriangle). A hypotenuse whose ends share x is
    // a side that runs along y. planes: those the parent's sphere may cross.
    template <bool Centre>
    [[gnu::always_inline]] Node evaluate(std::uint32_t end, std::uint32_t other_end, const LevelPlane* at,
                                         std::uint32_t planes) {
        const std::uint32_t xy = (end + other_end) >> 1;
        const LevelPlane& plane = Centre || ((end ^ other_end) & 0xffff) != 0 ? *at : at[1];
        const std::uint32_t x = xy & 0xffff, y = xy >> 16;
        const Located at_record = locate<O>(plane, step_pages, side, x, y);
        if (!at_record.loaded) return {xy, 0, not_selected};
        return {xy, at_record.index, eval(at_record.index, at_record.base, plane, x, y, planes)};
    }

    // meshRefine of a triangle whose middle vertex m is selected. Both halves are evaluated before either is entered:
    // their memory is fetched side by side, and leaves cost no call. Even levels split at a centre. at: the planes of
    // the next level.
    template <bool Even>
    void refine(Corner apex, Corner left, Corner right, Corner m, const LevelPlane* at, std::uint32_t planes) {
        ++result.triangles; // one has become two
        const Corner first_end = Even ? left : right, second_end = Even ? right : left;
        if (!Even && at == last_planes) {
            leaf<!Even>(m, right, apex);
            if constexpr (T == Topology::strip) emit.append(apex.slot, Even);
            leaf<!Even>(m, apex, left);
            return;
        }
        const Node first = evaluate<!Even>(apex.xy, first_end.xy, at, planes);
        const Node second = evaluate<!Even>(apex.xy, second_end.xy, at, planes);
        half<Even, Even>(m, apex, first_end, at, first);
        if constexpr (T == Topology::strip) emit.append(apex.slot, Even);
        half<Even, !Even>(m, apex, second_end, at, second);
    }

    // The half of a split triangle beside `end`, which was its parent's left end or its right one.
    template <bool ParentEven, bool LeftEnd>
    [[gnu::always_inline]] void half(Corner m, Corner apex, Corner end, const LevelPlane* at, const Node& node) {
        const Corner left = LeftEnd ? apex : end, right = LeftEnd ? end : apex;
        if (node.planes == not_selected) return leaf<!ParentEven>(m, left, right);
        const Corner next{node.xy, slot_of(node.index, node.xy & 0xffff, node.xy >> 16)};
        refine<!ParentEven>(m, left, right, next, at + (ParentEven ? 2 : 1), node.planes);
    }

    // One of a tile's two base triangles.
    void root(Corner apex, Corner left, Corner right) {
        ++result.triangles;
        const Node node = evaluate<true>(left.xy, right.xy, levels, Cull ? all_planes : 0);
        if (node.planes == not_selected) return leaf<true>(apex, left, right);
        const Corner m{node.xy, slot_of(node.index, node.xy & 0xffff, node.xy >> 16)};
        refine<true>(apex, left, right, m, levels + 1, node.planes);
    }

    // Even: of the level of the vertex that could split it.
    template <bool Even>
    [[gnu::always_inline]] void leaf(Corner apex, Corner left, Corner right) {
        if (some_not_drawn && not_drawn(apex, left, right)) {
            --result.triangles;
            if constexpr (T == Topology::triangles) return; // a strip needs the vertex on its way
        }
        if constexpr (T == Topology::strip) {
            emit.append(apex.slot, Even);
            if (emit.full()) give_up(budget_indices);
        } else if (!emit.triangle(apex.slot, left.slot, right.slot)) {
            give_up(budget_indices);
        }
    }

    // Where a vertex stands, in samples of the tile.
    [[nodiscard]] Coord place(std::uint32_t xy) const {
        return {std::min(static_cast<std::int32_t>(xy & 0xffff), limit_x),
                std::min(static_cast<std::int32_t>(xy >> 16), limit_y)};
    }

    // Does a corner lie in a hole, or has the triangle shrunk to nothing, because its vertices stand at the terrain's
    // rim?
    [[gnu::noinline]] bool not_drawn(Corner a, Corner b, Corner c) const {
        if (holes && ((a.slot | b.slot | c.slot) & hole_flag) != 0) return true;
        const Coord from = place(a.xy), ab = place(b.xy) - from, ac = place(c.xy) - from;
        return ab.x * ac.y == ab.y * ac.x;
    }

    // evalTriangle: looks the status up, or works it out and stores it. Answers with the planes left, or not_selected.
    [[gnu::always_inline]] std::uint32_t eval(std::uint32_t index, std::int32_t page_base, const LevelPlane& plane,
                                              std::uint32_t x, std::uint32_t y, std::uint32_t planes) {
        VertexState& state = states[index];
        if (state.status >= base) return state.status == base ? not_selected : planes;
        const Coord v{column0 + static_cast<std::int32_t>(x), row0 + static_cast<std::int32_t>(y)};
        planes =
            select(index, page_base, plane, {std::min(v.x, column0 + limit_x), std::min(v.y, row0 + limit_y)}, planes);
        if (incomplete && planes != not_selected && !parents_in(v)) planes = not_selected;
        const bool selected = planes != not_selected;
        state.status = base + (selected ? planes == 0 ? 2u : 1u : 0u);
        result.selected += selected;
        return planes;
    }

    // sample: where the vertex stands.
    [[gnu::always_inline]] std::uint32_t select(std::uint32_t index, std::int32_t page_base, const LevelPlane& plane,
                                                Coord sample, std::uint32_t planes) {
        const VertexRecord record = records[index];
        const float radius = plane.unit_m * radius_factor[record.radius & (radius_codes - 1)],
                    error = error_m[record.error];
        const float px = terrain.x_m(sample.x), pz = terrain.z_m(sample.y);
        const float py = terrain.height_scale.height_m(page_base + record.height);
        if (Cull && planes != 0) {
            planes = crossed({px, py, pz}, radius, planes);
            if (planes == not_selected) return not_selected;
        }
        if constexpr (M == Metric::isotropic) {
            if (!wanted(reach, px, py, pz, error, radius)) return not_selected;
        } else {
            // Depth of the sphere's nearest point; a sphere that reaches the near plane is refined (thesis 5.4.1).
            const double depth = dot(view.forward, Vec3{px, py, pz} - view.eye_m) - radius;
            if (!(depth < std::max(double{error} * reach.q, nearest_m))) return not_selected;
        }
        return planes;
    }

    // Figure 5.8, a plane at a time: of the planes given, those the sphere crosses; not_selected when it lies outside
    // one.
    [[gnu::noinline]] std::uint32_t crossed(Vec3 centre, double radius, std::uint32_t planes) const {
        const Vec3 p = centre - view.eye_m;
        std::uint32_t left = 0;
        for (; planes != 0; planes &= planes - 1) {
            const auto i = static_cast<std::size_t>(std::countr_zero(planes));
            const double d = dot(frustum.normal[i], p) - frustum.offset[i];
            if (d < -radius) return not_selected;
            if (d < radius) left |= 1u << i;
        }
        return left;
    }

    // Where pages are missing, nested errors are not enough: a vertex is in the cut when it is wanted, all pages that
    // hold it are there, and its parents are in the cut (invariant 7). One parent is known on the way down; this
    // asks both, across tiles.
    [[gnu::noinline]] bool parents_in(Coord v) {
        if (!copies_loaded(v)) return false;
        const Diamond d = diamond(terrain.tree, v);
        for (const Coord parent : d.apexes)
            if (terrain.tree.contains(parent) && !terrain.tree.is_corner(parent) && !in_cut(parent)) return false;
        return true;
    }

    // A vertex on the border of two tiles has a copy in each.
    [[nodiscard]] bool copies_loaded(Coord v) const {
        const auto n = static_cast<std::int32_t>(side);
        const Coord first{std::max(v.x - 1, 0) / n, std::max(v.y - 1, 0) / n};
        for (std::int32_t ty = first.y; ty <= std::min(v.y / n, terrain.tree.tiles_y - 1); ++ty)
            for (std::int32_t tx = first.x; tx <= std::min(v.x / n, terrain.tree.tiles_x - 1); ++tx)
                if (find(tx, ty, v).page.slot == no_index) return false;
        return true;
    }

    struct Found {
        PageEntry page;
        std::uint32_t index; // among all records
    };
    [[nodiscard]] Found find(std::int32_t tx, std::int32_t ty, Coord v) const {
        const auto n = static_cast<std::int32_t>(side);
        const std::size_t tile =
            static_cast<std::uint32_t>(ty) * std::size_t{terrain.header.tiles_x} + static_cast<std::uint32_t>(tx);
        const PagePlace at = terrain.pages.place_as<O>(static_cast<std::uint32_t>(v.x - tx * n),
                                                       static_cast<std::uint32_t>(v.y - ty * n));
        const PageEntry page = terrain.page_table[tile * terrain.pages_per_tile + at.page];
        return {page, page.slot * terrain.page_capacity + at.index};
    }

    // The same decision as eval's, for any vertex; remembered in the same place.
    bool in_cut(Coord v) {
        const auto n = static_cast<std::int32_t>(side);
        const Found found =
            find(std::min(v.x / n, terrain.tree.tiles_x - 1), std::min(v.y / n, terrain.tree.tiles_y - 1), v);
        if (found.page.slot == no_index) return false;
        VertexState& state = s.states[found.index];
        if (state.status >= base) return state.status != base;
        const LevelPlane& plane =
            levels[3 * (terrain.tree.tile_log2 - 1 - Tree::step_log2(v)) + static_cast<int>(Tree::kind(v))];
        const std::uint32_t planes =
            select(found.index, found.page.base, plane, terrain.tree.sample(v), Cull ? all_planes : 0);
        const bool selected = planes != not_selected && parents_in(v);
        state.status = base + (selected ? planes == 0 ? 2u : 1u : 0u);
        result.selected += selected;
        return selected;
    }

    // The root's sphere holds all of the tile; without its page nothing is known.
    bool root_outside() const {
        const std::uint32_t half = side / 2;
        const Located at = locate<O>(levels[0], step_pages, side, half, half);
        if (!at.loaded) return false;
        const VertexRecord root = terrain.records[at.index];
        const Coord v = place(pack_xy(half, half));
        return crossed({terrain.x_m(column0 + v.x), terrain.height_scale.height_m(at.base + root.height),
                        terrain.z_m(row0 + v.y)},
                       levels[0].unit_m * terrain.radii.factor[root.radius & (radius_codes - 1)],
                       all_planes) == not_selected;
    }

    // A corner of the tile: east, south: 0 or 1. Always selected; its state stands behind those of all pages.
    Corner corner(std::uint32_t tile, std::uint32_t east, std::uint32_t south) {
        const std::uint32_t x = east * side, y = south * side;
        const std::uint32_t index = terrain.slot_count * terrain.page_capacity + 4 * tile + 2 * south + east;
        VertexState& state = s.states[index];
        state.status = base + 1;
        ++result.selected;
        if (state.slot != no_index) return {pack_xy(x, y), state.slot};
        const std::uint32_t tiles_x = terrain.header.tiles_x;
        const std::uint32_t stored = terrain.corners[(tile / tiles_x + south) * (tiles_x + 1) + tile % tiles_x + east];
        return {pack_xy(x, y), insert(index, static_cast<std::int32_t>(stored & ~corner_void_bit),
                                      (stored & corner_void_bit) != 0, x, y)};
    }

    std::uint32_t slot_of(std::uint32_t index, std::uint32_t x, std::uint32_t y) {
        const std::uint32_t slot = states[index].slot;
        return slot != no_index ? slot : insert_record(index, x, y);
    }

    [[gnu::noinline]] std::uint32_t insert_record(std::uint32_t index, std::uint32_t x, std::uint32_t y) {
        const VertexRecord record = terrain.records[index];
        const PageEntry page = terrain.page_table[terrain.slot_page[index / terrain.page_capacity]];
        return insert(index, page.base + record.height, is_void(record), x, y);
    }

    // A new entry in the vertex buffer; clears it of vertices that this frame has not used when it is full.
    std::uint32_t insert(std::uint32_t index, std::int32_t steps, bool hole, std::uint32_t x, std::uint32_t y) {
        if (s.free_count == 0) clear_unused();
        if (s.free_count == 0) {
            give_up(budget_vertices);
            return 0;
        }
        const std::uint32_t slot = s.free_slots[--s.free_count];
        const Coord at = place(pack_xy(x, y));
        s.vertices[slot] = {column0 + at.x, row0 + at.y, terrain.height_scale.height_m(steps)};
        s.owners[slot] = index;
        s.dirty_begin = std::min(s.dirty_begin, slot);
        s.dirty_end = std::max(s.dirty_end, slot + 1);
        ++result.written;
        return s.states[index].slot = slot | (holes && hole ? hole_flag : 0);
    }

    void clear_unused() {
        if (result.clearings) return; // what is left is all of this frame
        ++result.clearings;
        for (std::uint32_t slot = s.budget.vertices; slot-- > 0;) {
            if (s.owners[slot] == no_index) continue;
            VertexState& owner = s.states[s.owners[slot]];
            if (owner.status > base) continue;
            owner.slot = no_index;
            s.owners[slot] = no_index;
            s.free_slots[s.free_count++] = slot;
        }
    }

    // From here on nothing is selected, so the recursion folds up quickly.
    void give_up(BudgetBit bit) {
        result.exhausted |= bit;
        select_none();
    }

    void select_none() {
        reach.eye_x = std::numeric_limits<float>::infinity();
        reach.q = -std::numeric_limits<float>::infinity();
        nearest_m = -std::numeric_limits<double>::infinity();
    }

    RecursiveState& s;
    const TerrainData& terrain;
    const View& view;
    Frustum frustum;
    Reach reach;
    std::uint32_t base;
    double nearest_m; // depth at which everything is refined
    LevelPlane levels[3 * max_tile_log2];
    const LevelPlane* last_planes; // one past them
    PassResult result;
    // Of the terrain and the state, at hand.
    VertexState* const states;
    const VertexRecord* const records;
    const float* const error_m;
    const float* const radius_factor;
    const bool holes;      // the terrain has some
    const bool incomplete; // pages are missing
    Emitter emit;
    // The tile in work.
    std::uint32_t side = 0;
    std::int32_t column0 = 0, row0 = 0;
    std::int32_t limit_x = 0, limit_y = 0; // the terrain's last column and row, counted from the tile's first
    bool some_not_drawn = false;           // they lie inside it, or the terrain has holes
    const StepPageEntry* step_pages = nullptr;
};

template <Order O, bool Cull, Metric M>
PassResult run_topology(RecursiveState& s, const View& view, double threshold_px) {
    if (s.topology == Topology::strip) return Pass<O, Cull, M, Topology::strip>(s, view, threshold_px).run();
    return Pass<O, Cull, M, Topology::triangles>(s, view, threshold_px).run();
}

template <Order O>
PassResult run_order(RecursiveState& s, const View& view, const RefineSettings& settings, double threshold_px) {
    if (settings.metric == Metric::depth) return run_topology<O, true, Metric::depth>(s, view, threshold_px);
    if (settings.cull) return run_topology<O, true, Metric::isotropic>(s, view, threshold_px);
    return run_topology<O, false, Metric::isotropic>(s, view, threshold_px);
}

PassResult run_pass(RecursiveState& s, const View& view, const RefineSettings& settings, double threshold_px) {
    // Status numbers of an earlier pass must never look like this one's.
    if (++s.pass > std::numeric_limits<std::uint32_t>::max() / 3 - 1) {
        for (std::size_t i = 0; i < s.state_count; ++i) s.states[i].status = 0;
        s.pass = 1;
    }
    switch (s.terrain->pages.order) {
    case Order::planar: return run_order<Order::planar>(s, view, settings, threshold_px);
    case Order::hierarchical_z: return run_order<Order::hierarchical_z>(s, view, settings, threshold_px);
    case Order::linear: break;
    }
    return run_order<Order::linear>(s, view, settings, threshold_px);
}

// Where to start: where the last frame ended, a step finer when it had room to spare.
double first_threshold(const RecursiveState& s, double requested_px) {
    if (!s.exhausted || s.effective_px <= requested_px) return requested_px;
    const bool room = s.last_selected < s.budget.vertices / 5 * 4 && s.last_indices < s.budget.indices / 5 * 4;
    return std::max(requested_px, room ? s.effective_px * step_down : s.effective_px);
}

} // namespace

Status update_recursive(RecursiveMethod method, const View& view, const RefineSettings& settings, FrameReport& report) {
    RecursiveState* const found = find_recursive(method);
    if (found == nullptr) return no_recursive;
    RecursiveState& s = *found;
    if (Status v = validate(view); !v.ok()) return v;
    if (!(settings.error_px >= 1e-3 && settings.error_px <= 1e6))
        return {Code::out_of_range, "RefineSettings::error_px"};
    if (settings.metric == Metric::depth && !settings.cull)
        return {Code::out_of_range,
                "RefineSettings::cull (the depth metric needs it: behind the eye depth means nothing)"};
    sync_pages(s);
    s.topology = settings.topology;
    s.dirty_begin = s.budget.vertices;
    s.dirty_end = 0;
    report = {};
    report.frame = ++s.frame;
    const double requested_px = view_error_px(view, settings.error_px);
    report.error_px_requested = requested_px;

    const double corner = settings.corner_safe ? corner_factor(view) : 1;
    double threshold_px = first_threshold(s, requested_px);
    std::uint32_t exhausted = threshold_px > requested_px ? s.exhausted : 0;
    PassResult result;
    for (;; threshold_px *= step_up, ++report.restarts) {
        result = run_pass(s, view, settings, threshold_px / corner);
        report.vertices_written += result.written;
        report.buffer_clearings += result.clearings;
        exhausted |= result.exhausted;
        if (!result.exhausted) break;
    }
    s.effective_px = threshold_px;
    s.exhausted = report.exhausted = exhausted;
    s.last_selected = result.selected;
    s.last_indices = s.index_count;
    report.vertices = result.selected;
    report.triangles = result.triangles;
    report.tiles = result.tiles;
    report.error_px_effective = threshold_px;
    report.converged = threshold_px <= requested_px;
    return {};
}

} // namespace fjell
