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

#include "recursive/state.h"
#include "tree/wanted.h"

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

// Index arithmetic of one plane inside a tile.
struct LevelPlane {
    std::uint32_t offset, stride, shift;
};

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

template <bool Cull, Metric M, Topology T>
class Pass {
public:
    Pass(RecursiveState& state, const View& the_view, double threshold_px)
        : s(state), terrain(*state.terrain), view(the_view), frustum(make_frustum(the_view)),
          reach(make_reach(the_view, threshold_px)), base(state.pass * 3), nearest_m(the_view.near_m) {
        LevelPlane* to = levels; // three a step: centre, side_x, side_y
        for (int z = terrain.order.tile_log2; z-- > 0;)
            for (const PlaneKind kind : {PlaneKind::centre, PlaneKind::side_x, PlaneKind::side_y}) {
                const PlanarOrder::Plane plane = terrain.order.plane(z, kind);
                *to++ = {plane.offset, plane.stride, static_cast<std::uint32_t>(z + 1)};
            }
        last_planes = to;
        if (threshold_px > hopeless_px) select_none();
    }

    PassResult run() {
        s.tile_count = 0;
        const Tree& tree = terrain.tree;
        for (std::int32_t ty = 0; ty < tree.tiles_y && !result.exhausted; ++ty)
            for (std::int32_t tx = 0; tx < tree.tiles_x && !result.exhausted; ++tx) tessellate(tx, ty);
        s.index_count = cursor;
        return result;
    }

private:
    void tessellate(std::int32_t tx, std::int32_t ty) {
        const std::int32_t side = terrain.tree.side();
        const auto tile = static_cast<std::uint32_t>(ty * terrain.tree.tiles_x + tx);
        column0 = tx * side;
        row0 = ty * side;
        first_vertex = tile * terrain.vertices_per_tile;
        records = terrain.tile_records(tile);
        states = s.states + first_vertex;
        limit_x = terrain.tree.columns() - 1 - column0;
        limit_y = terrain.tree.rows() - 1 - row0;
        cut = limit_x < side || limit_y < side;
        if (Cull && root_outside()) return;

        const auto n = static_cast<std::uint32_t>(side);
        const std::uint32_t first_index = cursor, triangles_before = result.triangles;
        const Corner nw = corner(0, 0, 0), ne = corner(1, n, 0), sw = corner(2, 0, n), se = corner(3, n, n);
        if constexpr (T == Topology::strip) {
            push(nw.slot);
            push(nw.slot);
            last_parity = 0;
        }
        root(ne, nw, se);
        if constexpr (T == Topology::strip) {
            // Three times the far corner: only degenerate triangles, and the second half starts at an odd place as
            // the first one did, so that the winding stays.
            append(se.slot, 0);
            push(se.slot);
            push(se.slot);
        }
        root(sw, se, nw);
        if constexpr (T == Topology::strip) append(nw.slot, 0);
        s.tiles[s.tile_count++] = {tile, first_index, cursor - first_index, result.triangles - triangles_before};
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
        const std::uint32_t index = plane.offset + (y >> plane.shift) * plane.stride + (x >> plane.shift);
        return {xy, index, eval(index, x, y, planes)};
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
            if constexpr (T == Topology::strip) append(apex.slot, Even);
            leaf<!Even>(m, apex, left);
            return;
        }
        const Node first = evaluate<!Even>(apex.xy, first_end.xy, at, planes);
        const Node second = evaluate<!Even>(apex.xy, second_end.xy, at, planes);
        half<Even, Even>(m, apex, first_end, at, first);
        if constexpr (T == Topology::strip) append(apex.slot, Even);
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
        if (cut && beyond_rim(apex.xy, left.xy, right.xy)) {
            --result.triangles;
            if constexpr (T == Topology::triangles) return; // a strip needs the vertex, and its area is zero anyway
        }
        if constexpr (T == Topology::strip) {
            append(apex.slot, Even);
        } else {
            if (cursor + 3 > s.budget.indices) return give_up(budget_indices);
            std::uint32_t* out = s.indices + cursor;
            out[0] = apex.slot;
            out[1] = left.slot;
            out[2] = right.slot;
            cursor += 3;
        }
    }

    // Where a vertex stands, in samples of the tile.
    [[nodiscard]] Coord place(std::uint32_t xy) const {
        return {std::min(static_cast<std::int32_t>(xy & 0xffff), limit_x),
                std::min(static_cast<std::int32_t>(xy >> 16), limit_y)};
    }

    // Has the triangle shrunk to nothing, because its vertices stand at the terrain's rim?
    [[gnu::noinline]] bool beyond_rim(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
        const Coord from = place(a), ab = place(b) - from, ac = place(c) - from;
        return ab.x * ac.y == ab.y * ac.x;
    }

    // tStripAppend. parity: of the vertex' level; parities alternate along the strip, or the older vertex is repeated.
    void append(std::uint32_t slot, int parity) {
        if (cursor < 2) return; // only after the indices ran out at the very beginning
        const std::uint32_t older = s.indices[cursor - 2];
        if (slot == s.indices[cursor - 1] || slot == older) return;
        if (parity == last_parity) push(older);
        push(slot);
        last_parity = parity;
    }

    void push(std::uint32_t slot) {
        if (cursor == s.budget.indices) return give_up(budget_indices);
        s.indices[cursor++] = slot;
    }

    // evalTriangle: looks the status up, or works it out and stores it. Answers with the planes left, or not_selected.
    [[gnu::always_inline]] std::uint32_t eval(std::uint32_t index, std::uint32_t x, std::uint32_t y,
                                              std::uint32_t planes) {
        VertexState& state = states[index];
        if (state.status >= base) return state.status == base ? not_selected : planes;
        planes = select(index, x, y, planes);
        const bool selected = planes != not_selected;
        state.status = base + (selected ? planes == 0 ? 2u : 1u : 0u);
        result.selected += selected;
        return planes;
    }

    [[gnu::always_inline]] std::uint32_t select(std::uint32_t index, std::uint32_t x, std::uint32_t y,
                                                std::uint32_t planes) {
        const VertexRecord& record = records[index];
        const float radius = from_bfloat16(record.radius), error = from_bfloat16(record.error);
        const float px = terrain.x_m(column0 + std::min(static_cast<std::int32_t>(x), limit_x));
        const float py = terrain.lattice.height_m(record.height);
        const float pz = terrain.z_m(row0 + std::min(static_cast<std::int32_t>(y), limit_y));
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

    // The root's sphere holds all of the tile. (Its place in planar order is right behind the corners.)
    bool root_outside() const {
        const std::int32_t half = terrain.tree.side() / 2;
        const VertexRecord& root = records[4];
        return crossed({terrain.x_m(column0 + std::min(half, limit_x)), terrain.lattice.height_m(root.height),
                        terrain.z_m(row0 + std::min(half, limit_y))},
                       from_bfloat16(root.radius), all_planes) == not_selected;
    }

    Corner corner(std::uint32_t index, std::uint32_t x, std::uint32_t y) {
        states[index].status = base + 1; // always selected
        ++result.selected;
        return {pack_xy(x, y), slot_of(index, x, y)};
    }

    std::uint32_t slot_of(std::uint32_t index, std::uint32_t x, std::uint32_t y) {
        const std::uint32_t slot = states[index].slot;
        return slot != no_slot ? slot : insert(index, x, y);
    }

    // A new entry in the vertex buffer; clears it of vertices that this frame has not used when it is full.
    [[gnu::noinline]] std::uint32_t insert(std::uint32_t index, std::uint32_t x, std::uint32_t y) {
        if (s.free_count == 0) clear_unused();
        if (s.free_count == 0) {
            give_up(budget_vertices);
            return 0;
        }
        const std::uint32_t slot = s.free_slots[--s.free_count];
        const Coord at = place(pack_xy(x, y));
        s.vertices[slot] = {static_cast<std::uint16_t>(at.x), static_cast<std::uint16_t>(at.y),
                            terrain.lattice.height_m(records[index].height)};
        s.owners[slot] = first_vertex + index;
        states[index].slot = slot;
        s.dirty_begin = std::min(s.dirty_begin, slot);
        s.dirty_end = std::max(s.dirty_end, slot + 1);
        ++result.written;
        return slot;
    }

    void clear_unused() {
        if (result.clearings) return; // what is left is all of this frame
        ++result.clearings;
        for (std::uint32_t slot = s.budget.vertices; slot-- > 0;) {
            if (s.owners[slot] == no_owner) continue;
            VertexState& owner = s.states[s.owners[slot]];
            if (owner.status > base) continue;
            owner.slot = no_slot;
            s.owners[slot] = no_owner;
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
    const Terrain& terrain;
    const View& view;
    Frustum frustum;
    Reach reach;
    std::uint32_t base;
    double nearest_m; // depth at which everything is refined
    LevelPlane levels[3 * max_tile_log2];
    const LevelPlane* last_planes; // one past them
    PassResult result;
    // The tile in work.
    std::int32_t column0 = 0, row0 = 0;
    std::int32_t limit_x = 0, limit_y = 0; // the terrain's last column and row, counted from the tile's first
    bool cut = false;                      // they lie inside it
    std::uint32_t first_vertex = 0;
    const VertexRecord* records = nullptr;
    VertexState* states = nullptr;
    std::uint32_t cursor = 0; // into the indices
    int last_parity = 0;
};

template <bool Cull, Metric M>
PassResult run_topology(RecursiveState& s, const View& view, double threshold_px) {
    if (s.topology == Topology::strip) return Pass<Cull, M, Topology::strip>(s, view, threshold_px).run();
    return Pass<Cull, M, Topology::triangles>(s, view, threshold_px).run();
}

PassResult run_pass(RecursiveState& s, const View& view, const RefineSettings& settings, double threshold_px) {
    // Status numbers of an earlier pass must never look like this one's.
    if (++s.pass > std::numeric_limits<std::uint32_t>::max() / 3 - 1) {
        const std::size_t count = std::size_t{s.terrain->tile_count()} * s.terrain->vertices_per_tile;
        for (std::size_t i = 0; i < count; ++i) s.states[i].status = 0;
        s.pass = 1;
    }
    if (settings.metric == Metric::depth) return run_topology<true, Metric::depth>(s, view, threshold_px);
    if (settings.cull) return run_topology<true, Metric::isotropic>(s, view, threshold_px);
    return run_topology<false, Metric::isotropic>(s, view, threshold_px);
}

// Where to start: where the last frame ended, a step finer when it had room to spare.
double first_threshold(const RecursiveState& s, double asked_px) {
    if (!s.exhausted || s.effective_px <= asked_px) return asked_px;
    const bool room = s.last_selected < s.budget.vertices / 5 * 4 && s.last_indices < s.budget.indices / 5 * 4;
    return std::max(asked_px, room ? s.effective_px * step_down : s.effective_px);
}

} // namespace

Status update_recursive(RecursiveMethod method, const View& view, const RefineSettings& settings, FrameReport& report) {
    if (Status v = validate(view); !v.ok()) return v;
    if (!(settings.error_px >= 1e-3 && settings.error_px <= 1e6))
        return {Code::out_of_range, "RefineSettings::error_px"};
    if (settings.metric == Metric::depth && !settings.cull)
        return {Code::out_of_range,
                "RefineSettings::cull (the depth metric needs it: behind the eye depth means nothing)"};
    RecursiveState& s = *method.state;
    s.topology = settings.topology;
    s.dirty_begin = s.budget.vertices;
    s.dirty_end = 0;
    report = {};
    report.frame = ++s.frame;
    report.error_px_asked = settings.error_px;

    const double corner = settings.corner_safe ? corner_factor(view) : 1;
    double threshold_px = first_threshold(s, settings.error_px);
    std::uint32_t exhausted = threshold_px > settings.error_px ? s.exhausted : 0;
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
    report.converged = threshold_px <= settings.error_px;
    return {};
}

} // namespace fjell
