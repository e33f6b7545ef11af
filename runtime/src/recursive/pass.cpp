// Thesis 5.4 (figures 5.4, 5.6, 5.8), after Lindstrom and Pascucci, "Visualization of Large Terrains Made Easy" (2001).
// Departures are listed in fjell/recursive.h.
//
// Order of a strip. A triangle (apex, left, right), counter-clockwise from above, is entered at one end of its
// hypotenuse and left at the other: at `left` on even levels, at `right` on odd ones. The vertex m in the middle of the
// hypotenuse splits it into (m, apex, left) and (m, right, apex); the first of the two on the way is the one that holds
// the end we came in by, and both are entered from the opposite kind of end. So the two orders of figure 5.5 alternate
// by level, and vertices of alternating level parity alternate in the strip, which fixes the winding.
//
// Who decides. A vertex is the middle of a hypotenuse, or of a leg's, that two triangles share, so the recursion comes
// to it twice. In which of the two it is first follows from the order alone, so that the code knows it before it runs:
// the first one decides, the second one reads what was found. No branch asks, and no vertex is decided twice.
#include "recursive/pass.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>

#include "recursive/emit.h"
#include "recursive/locate.h"
#include "shared/compiler.h"
#include "view/wanted.h"

namespace fjell {

namespace {

// A vertex as the recursion carries it, in one register, which compilers would make two of a struct: pack_xy of its
// place below its slot.
using Corner = std::uint64_t;
constexpr Corner make_corner(std::uint32_t xy, std::uint32_t slot) {
    return xy | std::uint64_t{slot} << 32;
}
constexpr std::uint32_t xy_of(Corner c) {
    return static_cast<std::uint32_t>(c);
}
constexpr std::uint32_t slot_of(Corner c) {
    return static_cast<std::uint32_t>(c >> 32);
}

// A triangle before it is entered. even: its vertex is a centre. hypotenuse, left, right: the triangle on the other
// side of this edge comes earlier in the recursion (left: from the apex to the left end). inside: nothing is left to
// ask but the distance.
struct Kind {
    bool even, hypotenuse, left, right, inside;
};
// Of the halves: the one at the left end comes first on even levels. The edge between them was seen by the first.
constexpr Kind left_half(Kind k) {
    return {!k.even, k.left, !k.even, k.hypotenuse, k.inside};
}
constexpr Kind right_half(Kind k) {
    return {!k.even, k.right, k.hypotenuse, k.even, k.inside};
}
constexpr Kind inside(Kind k) {
    return {k.even, k.hypotenuse, k.left, k.right, true};
}

// What may still have to be asked below a vertex: the frustum's planes that its sphere crosses and, in every sub-tree
// alike, what is not as simple as the rest. Nothing left: only the distance decides.
constexpr std::uint32_t all_planes = 0b111111, special = 1u << 6;
constexpr std::uint32_t not_selected = 0xffffffff;

// Beyond this threshold only spheres that hold the eye select anything; a pass above it draws base triangles only,
// which every budget can hold.
constexpr double hopeless_px = 1e7;

template <PageOrder O, Topology T>
class Pass {
public:
    Pass(RecursiveState& state, const View& the_view, const RefineSettings& settings, double threshold_px)
        : s(state), terrain(*state.terrain), reach(make_reach(the_view, threshold_px)), base(state.base),
          partly(static_cast<std::uint16_t>(state.base + in_partly)),
          wholly(static_cast<std::uint16_t>(state.base + in_wholly)), x_m2(state.x_m2), z_m2(state.z_m2),
          height_scale(terrain.height_scale), statuses(state.statuses), slots(state.slots), records(terrain.records),
          error_m(terrain.errors.metres), radius_factor(terrain.radii.factor), holes(terrain.has_voids()),
          incomplete(terrain.pages_missing != 0), depth(settings.metric == Metric::depth), cull(settings.cull),
          emit(state), view(the_view), frustum(make_frustum(the_view)), nearest_m(the_view.near_m) {
        LevelPlane* to = levels; // three a step: centre, side_x, side_y
        for (int z = terrain.tree.tile_log2; z-- > 0;)
            for (const VertexKind kind : {VertexKind::centre, VertexKind::side_x, VertexKind::side_y})
                *to++ = make_level_plane(terrain, z, kind);
        last_planes = to;
        if (threshold_px > hopeless_px) select_none();
    }

    PassResult run() {
        s.tile_count = 0;
        // By numbers, not by places: a sparse terrain may have a million places and a few tiles.
        for (std::uint32_t tile = 0; tile < terrain.tile_count() && !result.exhausted; ++tile) tessellate(tile);
        s.index_count = emit.cursor();
        return result;
    }

private:
    void tessellate(std::uint32_t tile) {
        side = terrain.pages.side();
        tile_place = terrain.tile_xy(tile);
        const auto n = static_cast<std::int32_t>(side);
        column0 = tile_place.column * n;
        row0 = tile_place.row * n;
        for (LevelPlane* plane = levels; plane != last_planes; ++plane)
            plane->pages = s.step_pages + std::size_t{tile} * s.step_pages_per_tile + plane->first;
        limit_x = terrain.tree.columns() - 1 - column0;
        limit_y = terrain.tree.rows() - 1 - row0;
        some_not_drawn = holes || limit_x < n || limit_y < n;
        if (cull && root_outside()) return;

        const std::uint32_t first_index = emit.cursor();
        std::uint32_t triangles = result.triangles;
        const Corner nw = corner(tile, 0, 0), ne = corner(tile, 1, 0), sw = corner(tile, 0, 1), se = corner(tile, 1, 1);
        if constexpr (T == Topology::strip) emit.begin_strip(slot_of(nw));
        root<Kind{true, false, false, false, false}>(ne, nw, se);
        if constexpr (T == Topology::strip) {
            // Three times the far corner: only degenerate triangles, and the second half starts at an odd place as
            // the first one did, so that the winding stays.
            emit.append(slot_of(se), 0);
            emit.push(slot_of(se));
            emit.push(slot_of(se));
        }
        root<Kind{true, true, false, false, false}>(sw, se, nw);
        if constexpr (T == Topology::strip) emit.append(slot_of(nw), 0);
        if (emit.full()) give_up(budget_indices);
        const std::uint32_t indices = emit.cursor() - first_index;
        if constexpr (T == Topology::triangles) result.triangles += indices / 3;
        triangles = result.triangles - triangles;
        s.tiles[s.tile_count++] = {tile, first_index, indices, triangles};
        ++result.tiles;
    }

    // The vertex in the middle of a triangle's hypotenuse: which one it is and what became of it.
    struct Node {
        std::uint32_t xy, index;
        std::uint32_t to_ask; // below it
        bool selected;
    };

    // The vertex of a triangle of this kind, from its hypotenuse. One whose ends share x is a side that runs along y.
    // to_ask: of the parent's.
    template <Kind K>
    FJELL_ALWAYS_INLINE Node look(std::uint32_t end, std::uint32_t other_end, const LevelPlane* at,
                                  std::uint32_t to_ask) {
        const std::uint32_t xy = (end + other_end) >> 1;
        const LevelPlane& plane = K.even || ((end ^ other_end) & 0xffff) != 0 ? *at : at[1];
        const Located found = locate<O>(plane, xy);
        if constexpr (K.inside) {
            if constexpr (K.hypotenuse) return {xy, found.index, 0, in_mesh(found.index)};
            return {xy, found.index, 0, near_enough(records[found.index], found.base, plane, xy)};
        } else {
            if (!found.loaded) return {xy, 0, 0, false};
            if constexpr (!K.hypotenuse) {
                const std::uint32_t left = decide(found, plane, xy, to_ask);
                return {xy, found.index, left, left != not_selected};
            }
            return {xy, found.index, decision(found.index) == in_wholly ? 0 : to_ask, in_mesh(found.index)};
        }
    }

    // meshRefine of a triangle of kind K whose vertex m is selected. Both halves are looked at before either is
    // entered: their memory is fetched side by side, and leaves cost no call. at: the planes of the next level.
    template <Kind K>
    FJELL_ALWAYS_INLINE void split(Corner apex, Corner left, Corner right, Corner m, const LevelPlane* at,
                                   std::uint32_t to_ask) {
        constexpr Kind first_kind = K.even ? left_half(K) : right_half(K),
                       second_kind = K.even ? right_half(K) : left_half(K);
        const Corner first_end = K.even ? left : right, second_end = K.even ? right : left;
        if (!K.even && at == last_planes) {
            half<first_kind, K.even>(m, apex, first_end, at, {0, 0, 0, false});
            if constexpr (T == Topology::strip) emit.append(slot_of(apex), K.even);
            half<second_kind, !K.even>(m, apex, second_end, at, {0, 0, 0, false});
            return;
        }
        const Node first = look<first_kind>(xy_of(apex), xy_of(first_end), at, to_ask);
        const Node second = look<second_kind>(xy_of(apex), xy_of(second_end), at, to_ask);
        half<first_kind, K.even>(m, apex, first_end, at, first);
        if constexpr (T == Topology::strip) emit.append(slot_of(apex), K.even);
        half<second_kind, !K.even>(m, apex, second_end, at, second);
    }
    // Out of line, or the compiler unrolls the recursion.
    template <Kind K>
    FJELL_NOINLINE void refine(Corner apex, Corner left, Corner right, Corner m, const LevelPlane* at,
                               std::uint32_t to_ask) {
        split<K>(apex, left, right, m, at, to_ask);
    }
    template <Kind K>
    FJELL_NOINLINE void refine_inside(Corner apex, Corner left, Corner right, Corner m, const LevelPlane* at) {
        split<K>(apex, left, right, m, at, 0);
    }

    // The half of a split triangle beside `end`, which was its parent's left end or its right one. K: its own kind.
    template <Kind K, bool LeftEnd>
    FJELL_ALWAYS_INLINE void half(Corner m, Corner apex, Corner end, const LevelPlane* at, const Node& node) {
        const Corner left = LeftEnd ? apex : end, right = LeftEnd ? end : apex;
        if (!node.selected) return leaf<K.even>(m, left, right);
        enter<K>(m, left, right, node, at + (K.even ? 1 : 2));
    }

    // Asks for the four squares of the next step that meet at a centre, two levels before the recursion comes to them:
    // it waits for memory otherwise, and the processor does not look so far ahead. The south-eastern one is never a
    // page's first, so that the others lie before it; an address that is none does no harm.
    FJELL_ALWAYS_INLINE void fetch_squares(std::uint32_t xy, const LevelPlane& centres) const {
        const std::uint32_t at = locate<O>(centres, xy).index;
        FJELL_PREFETCH(slots + at);
        if constexpr (O == PageOrder::hierarchical_z) FJELL_PREFETCH(records + at);
        if constexpr (O == PageOrder::planar) {
            constexpr std::uint32_t row = page_squares, side_x = page_index<O>(page_squares, VertexKind::side_x, 0, 0),
                                    side_y = page_index<O>(page_squares, VertexKind::side_y, 0, 0);
            for (const std::uint32_t plane : {at, at + side_x, at + side_y}) {
                FJELL_PREFETCH(records + plane);
                FJELL_PREFETCH(records + (plane - row));
            }
            FJELL_PREFETCH(slots + (at - row));
        }
    }

    // The triangle of a selected vertex becomes two.
    template <Kind K>
    FJELL_ALWAYS_INLINE void enter(Corner apex, Corner left, Corner right, const Node& node, const LevelPlane* at) {
        if constexpr (T == Topology::strip) ++result.triangles;
        if constexpr (K.even && O != PageOrder::linear)
            if (at + 2 != last_planes) fetch_squares(node.xy, at[2]);
        if constexpr (K.inside && !K.hypotenuse) {
            statuses[node.index] = wholly;
            ++result.selected;
        }
        std::uint32_t slot = slots[node.index];
        if (!K.hypotenuse && slot == no_index) slot = insert_record(node.index, node.xy);
        const Corner m = make_corner(node.xy, slot);
        if (K.inside || node.to_ask == 0) return refine_inside<inside(K)>(apex, left, right, m, at);
        if constexpr (!K.inside) refine<K>(apex, left, right, m, at, node.to_ask);
    }

    // One of a tile's two base triangles.
    template <Kind K>
    void root(Corner apex, Corner left, Corner right) {
        if constexpr (T == Topology::strip) ++result.triangles;
        const std::uint32_t to_ask = (cull ? all_planes : 0) | (depth || incomplete ? special : 0);
        const Node node = look<K>(xy_of(left), xy_of(right), levels, to_ask);
        if (!node.selected) return leaf<true>(apex, left, right);
        if constexpr (!K.hypotenuse) measure_axes();
        enter<K>(apex, left, right, node, levels + 1);
    }

    // Even: of the level of the vertex that could split it.
    template <bool Even>
    FJELL_ALWAYS_INLINE void leaf(Corner apex, Corner left, Corner right) {
        if (some_not_drawn && not_drawn(apex, left, right)) {
            if constexpr (T == Topology::triangles) return;
            --result.triangles; // a strip needs the vertex on its way
        }
        if constexpr (T == Topology::strip) {
            emit.append(slot_of(apex), Even);
            if (emit.full()) give_up(budget_indices);
        } else if (!emit.triangle(slot_of(apex), slot_of(left), slot_of(right))) {
            give_up(budget_indices);
        }
    }

    // Where a vertex stands, in samples of the tile.
    [[nodiscard]] SampleIndex place(std::uint32_t xy) const {
        return {std::min(static_cast<std::int32_t>(xy & 0xffff), limit_x),
                std::min(static_cast<std::int32_t>(xy >> 16), limit_y)};
    }

    // Does a corner lie in a hole, or has the triangle shrunk to nothing, because its vertices stand at the terrain's
    // rim?
    FJELL_NOINLINE bool not_drawn(Corner a, Corner b, Corner c) const {
        if (holes && ((slot_of(a) | slot_of(b) | slot_of(c)) & hole_flag) != 0) return true;
        const SampleIndex from = place(xy_of(a)), ab = place(xy_of(b)) - from, ac = place(xy_of(c)) - from;
        return ab.column * ac.row == ab.row * ac.column;
    }

    struct Position {
        float x_m, y_m, z_m;
    };
    // Of a vertex of this tile. Beyond the rim it stands at the rim.
    [[nodiscard]] Position position(VertexRecord record, std::int32_t page_base, std::uint32_t xy) const {
        const SampleIndex at = place(xy);
        return {terrain.x_m(column0 + at.column), height_scale.height_m(page_base + record.height),
                terrain.z_m(row0 + at.row)};
    }

    // Squared distances from the eye to the tile's columns and rows: half of what there is to work out for a vertex.
    void measure_axes() {
        const auto n = static_cast<std::int32_t>(side);
        for (std::int32_t i = 0; i <= n; ++i) {
            const float dx = terrain.x_m(column0 + std::min(i, limit_x)) - reach.eye_x,
                        dz = terrain.z_m(row0 + std::min(i, limit_y)) - reach.eye_z;
            x_m2[i] = dx * dx;
            z_m2[i] = dz * dz;
        }
    }

    FJELL_ALWAYS_INLINE float radius_m(VertexRecord record, const LevelPlane& plane) const {
        return plane.unit_m * radius_factor[record.radius & (radius_codes - 1)];
    }

    // evalTriangle where nothing but the distance is left to ask.
    FJELL_ALWAYS_INLINE bool near_enough(VertexRecord record, std::int32_t page_base, const LevelPlane& plane,
                                         std::uint32_t xy) const {
        return wanted_at(reach, x_m2[xy & 0xffff], height_scale.height_m(page_base + record.height), z_m2[xy >> 16],
                         error_m[record.error], radius_m(record, plane));
    }

    // evalTriangle in full; stores what it finds.
    FJELL_NOINLINE std::uint32_t decide(Located at, const LevelPlane& plane, std::uint32_t xy, std::uint32_t to_ask) {
        if (incomplete && decision(at.index) <= in_wholly) // a child of it was decided
            return decision(at.index) == not_in ? not_selected : to_ask;
        to_ask = select(records[at.index], position(records[at.index], at.base, xy), plane, to_ask);
        const SampleIndex v{column0 + static_cast<std::int32_t>(xy & 0xffff),
                            row0 + static_cast<std::int32_t>(xy >> 16)};
        if (incomplete && to_ask != not_selected && !parents_in(v)) to_ask = not_selected;
        return store(at.index, to_ask);
    }

    FJELL_ALWAYS_INLINE std::uint32_t store(std::uint32_t index, std::uint32_t to_ask) {
        const bool selected = to_ask != not_selected;
        statuses[index] = static_cast<std::uint16_t>(base + (!selected ? not_in : to_ask == 0 ? in_wholly : in_partly));
        result.selected += selected;
        return to_ask;
    }
    // Above in_wholly: none yet in this pass.
    [[nodiscard]] std::uint32_t decision(std::uint32_t index) const {
        return static_cast<std::uint16_t>(statuses[index] - base);
    }
    [[nodiscard]] bool in_mesh(std::uint32_t index) const {
        return static_cast<std::uint16_t>(statuses[index] - partly) <= in_wholly - in_partly;
    }

    // Answers with what is left to ask, or not_selected.
    FJELL_ALWAYS_INLINE std::uint32_t select(VertexRecord record, Position p, const LevelPlane& plane,
                                             std::uint32_t to_ask) const {
        const float radius = radius_m(record, plane), error = error_m[record.error];
        const Vec3 centre{p.x_m, p.y_m, p.z_m};
        if (!depth) {
            if (!wanted(reach, p.x_m, p.y_m, p.z_m, error, radius)) return not_selected;
        } else {
            // Depth of the sphere's nearest point; a sphere that reaches the near plane is refined (thesis 5.4.1).
            const double nearest_point_m = dot(view.forward, centre - view.eye_m) - double{radius};
            if (!(nearest_point_m < std::max(double{error} * double{reach.q}, nearest_m))) return not_selected;
        }
        return crossed(centre, radius, to_ask);
    }

    // Figure 5.8, a plane at a time: of the planes given, those the sphere crosses; not_selected when it lies outside
    // one. In double precision: far from the eye float's rounding exceeds the margin of small spheres, and a vertex
    // would be kept that its parent has lost.
    [[nodiscard]] std::uint32_t crossed(Vec3 centre, double radius, std::uint32_t to_ask) const {
        const Vec3 p = centre - view.eye_m;
        std::uint32_t left = to_ask & special;
        for (std::uint32_t planes = to_ask & all_planes; planes != 0; planes &= planes - 1) {
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
    FJELL_NOINLINE bool parents_in(SampleIndex v) {
        if (!copies_loaded(v)) return false;
        const Diamond d = diamond(terrain.tree, v);
        for (const SampleIndex parent : d.apexes)
            if (exists(parent) && !in_cut(parent)) return false;
        return true;
    }

    // An apex that has to be in the cut: not a corner, and in a tile that there is. Those of a centre lie in its own
    // tile, those of a side are centres, which lie in one tile only.
    [[nodiscard]] bool exists(SampleIndex parent) const {
        if (!terrain.tree.contains(parent) || terrain.tree.is_corner(parent)) return false;
        if (Tree::kind(parent) != VertexKind::centre) return true;
        const int log2 = terrain.tree.tile_log2;
        return terrain.has_tile(parent.column >> log2, parent.row >> log2);
    }

    // A vertex on the border of two tiles has a copy in each that there is.
    [[nodiscard]] bool copies_loaded(SampleIndex v) const {
        const auto n = static_cast<std::int32_t>(side);
        const SampleIndex first{std::max(v.column - 1, 0) / n, std::max(v.row - 1, 0) / n};
        for (std::int32_t ty = first.row; ty <= std::min(v.row / n, terrain.tree.tiles_y - 1); ++ty)
            for (std::int32_t tx = first.column; tx <= std::min(v.column / n, terrain.tree.tiles_x - 1); ++tx)
                if (terrain.has_tile(tx, ty) && find(tx, ty, v).page.slot == no_index) return false;
        return true;
    }

    struct Found {
        PageEntry page;
        std::uint32_t index; // among all records
    };
    [[nodiscard]] Found find(std::int32_t tx, std::int32_t ty, SampleIndex v) const {
        const auto n = static_cast<std::int32_t>(side);
        const std::size_t tile = terrain.tile_at(tx, ty);
        const PagePlace at = terrain.pages.place_as<O>(static_cast<std::uint32_t>(v.column - tx * n),
                                                       static_cast<std::uint32_t>(v.row - ty * n));
        const PageEntry page = terrain.page_table[tile * terrain.pages_per_tile + at.page];
        return {page, page.slot * terrain.page_capacity + at.index};
    }

    // The same decision as decide()'s, for any vertex; remembered in the same place.
    bool in_cut(SampleIndex v) {
        const auto n = static_cast<std::int32_t>(side);
        const SampleIndex tile = terrain.tile_with(
            v, {std::min(v.column / n, terrain.tree.tiles_x - 1), std::min(v.row / n, terrain.tree.tiles_y - 1)});
        const Found found = find(tile.column, tile.row, v);
        if (found.page.slot == no_index) return false;
        if (decision(found.index) <= in_wholly) return decision(found.index) != not_in;
        const LevelPlane& plane =
            levels[3 * (terrain.tree.tile_log2 - 1 - Tree::step_log2(v)) + static_cast<int>(Tree::kind(v))];
        const VertexRecord record = records[found.index];
        const SampleIndex sample = terrain.tree.sample(v);
        const Position p{terrain.x_m(sample.column), height_scale.height_m(found.page.base + record.height),
                         terrain.z_m(sample.row)};
        std::uint32_t to_ask = select(record, p, plane, (cull ? all_planes : 0) | special);
        if (to_ask != not_selected && !parents_in(v)) to_ask = not_selected;
        return store(found.index, to_ask) != not_selected;
    }

    // The root's sphere holds all of the tile; without its page nothing is known.
    [[nodiscard]] bool root_outside() const {
        const std::uint32_t xy = pack_xy(side / 2, side / 2);
        const Located at = locate<O>(levels[0], xy);
        if (!at.loaded) return false;
        const Position p = position(records[at.index], at.base, xy);
        return crossed({p.x_m, p.y_m, p.z_m}, radius_m(records[at.index], levels[0]), all_planes) == not_selected;
    }

    // A corner of the tile: east, south: 0 or 1. Always selected; its state stands behind those of all pages.
    Corner corner(std::uint32_t tile, std::uint32_t east, std::uint32_t south) {
        const std::uint32_t x = east * side, y = south * side;
        const std::uint32_t index = terrain.slot_count * terrain.page_capacity + 4 * tile + 2 * south + east;
        (void)store(index, special);
        if (slots[index] != no_index) return make_corner(pack_xy(x, y), slots[index]);
        const std::uint32_t stored = terrain.corners[terrain.corner_at(
            tile_place.column + static_cast<std::int32_t>(east), tile_place.row + static_cast<std::int32_t>(south))];
        return make_corner(pack_xy(x, y),
                           insert(index, corner_steps(stored), (stored & corner_void_bit) != 0, pack_xy(x, y)));
    }

    FJELL_NOINLINE std::uint32_t insert_record(std::uint32_t index, std::uint32_t xy) {
        const VertexRecord record = records[index];
        const PageEntry page = terrain.page_table[terrain.slot_page[index / terrain.page_capacity]];
        return insert(index, page.base + record.height, is_void(record), xy);
    }

    std::uint32_t insert(std::uint32_t index, std::int32_t steps, bool hole, std::uint32_t xy) {
        const SampleIndex at = place(xy);
        const MeshVertex vertex{column0 + at.column, row0 + at.row, height_scale.height_m(steps)};
        const std::uint32_t slot = insert_vertex(s, index, vertex, holes && hole, result);
        if (slot != no_index) return slot;
        give_up(budget_vertices);
        return 0;
    }

    // From here on nothing is selected, so the recursion folds up quickly.
    void give_up(BudgetBit bit) {
        result.exhausted |= bit;
        select_none();
    }

    void select_none() {
        reach.pad = std::numeric_limits<float>::quiet_NaN();
        reach.q = -std::numeric_limits<float>::infinity();
        nearest_m = -std::numeric_limits<double>::infinity();
    }

    RecursiveState& s;
    const TerrainData& terrain;
    Reach reach;
    std::uint32_t base;
    // Of the terrain and the state, at hand.
    const std::uint16_t partly, wholly; // statuses of what is selected
    float *const x_m2, *const z_m2;
    const HeightScale height_scale;
    std::uint16_t* const statuses;
    std::uint32_t* const slots;
    const VertexRecord* const records;
    const float* const error_m;
    const float* const radius_factor;
    // The tile in work.
    SampleIndex tile_place;
    std::int32_t column0 = 0, row0 = 0;
    std::int32_t limit_x = 0, limit_y = 0; // the terrain's last column and row, counted from the tile's first
    std::uint32_t side = 0;
    bool some_not_drawn = false; // they lie inside it, or the terrain has holes
    const bool holes;            // the terrain has some
    const bool incomplete;       // pages are missing
    const bool depth;            // the metric
    const bool cull;
    PassResult result;
    Emitter emit;
    const LevelPlane* last_planes; // one past them
    LevelPlane levels[3 * max_tile_log2];
    const View& view;
    Frustum frustum;
    double nearest_m; // depth at which everything is refined
};

template <PageOrder O>
PassResult run_order(RecursiveState& s, const View& view, const RefineSettings& settings, double threshold_px) {
    if (settings.topology == Topology::strip) return Pass<O, Topology::strip>(s, view, settings, threshold_px).run();
    return Pass<O, Topology::triangles>(s, view, settings, threshold_px).run();
}

} // namespace

PassResult run_pass(RecursiveState& s, const View& view, const RefineSettings& settings, double threshold_px) {
    s.base = s.base == 3 * pass_numbers ? 3 : s.base + 3;
    const std::size_t part = std::min(s.state_count / clearing_passes + 1, s.state_count - s.cleared);
    std::memset(s.statuses + s.cleared, 0, part * sizeof *s.statuses);
    s.cleared = s.cleared + part == s.state_count ? 0 : s.cleared + part;
    switch (s.terrain->pages.order) {
    case PageOrder::planar: return run_order<PageOrder::planar>(s, view, settings, threshold_px);
    case PageOrder::hierarchical_z: return run_order<PageOrder::hierarchical_z>(s, view, settings, threshold_px);
    case PageOrder::linear: break;
    }
    return run_order<PageOrder::linear>(s, view, settings, threshold_px);
}

} // namespace fjell
