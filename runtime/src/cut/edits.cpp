#include "cut/edits.h"

#include <algorithm>
#include <bit>

#include "cut/error_bound.h"
#include "cut/evaluate.h"
#include "cut/state.h"
#include "edit/ground.h"

namespace fjell {

namespace {

using edit::Plane;
using edit::Rect;

// The page's numbers, as when it was entered.
void refresh_page(CutState& s, std::uint32_t page) {
    Pages& pages = s.pages;
    const TerrainData& t = *pages.grid.terrain;
    const std::uint32_t terrain_slot = t.page_table[page].slot;
    if (terrain_slot == no_index || pages.loaded[terrain_slot].page != page) return;
    pages.loaded[terrain_slot].loads = t.slot_loads[terrain_slot]; // as follow_bases() has seen it
    pages.loaded[terrain_slot].extent = extent_of(pages.grid, page, terrain_slot);
    const std::uint32_t first = pages.page_groups[page], slot = first / max_page_groups;
    if (first == no_index) return;
    watch_visited_page(pages, s.work, s.visibility, slot);
    renew_bound_of_edited(pages, s.work, s.views, slot);
    if (page % pages.grid.pages_per_tile == 0) bound_tile(pages.grid, s.mesh, pages.state[slot], true);
}

std::uint32_t slot_of(const Pages& pages, SampleIndex v) {
    const std::int32_t l = pages.grid.terrain->tree.tile_log2;
    if (pages.grid.terrain->tree.is_corner(v)) return pages.grid.terrain->corner_at(v.column >> l, v.row >> l);
    const std::uint32_t vertex = find_vertex(pages, site_at(v));
    return vertex != no_index && is_active(pages, vertex) ? pages.vertex_slot[vertex] : no_index;
}

// Whether it is a hole: whose triangles are not drawn (relist()).
void refresh_hole(Mesh& mesh, std::uint32_t slot, bool hole) {
    mesh.hole[slot] = static_cast<std::uint8_t>((mesh.hole[slot] & ~hole_bit) | (hole ? hole_bit : 0));
}

void refresh_corner(CutState& s, SampleIndex v) {
    const std::uint32_t slot = slot_of(s.pages, v);
    const TerrainData::Vertex now = s.pages.grid.terrain->vertex(v);
    const float height_m = now.height_m;
    refresh_hole(s.mesh, slot, now.hole);
    if (s.mesh.vertices[slot].height_m == height_m) return;
    s.mesh.vertices[slot].height_m = height_m;
    if (s.mesh.morph != nullptr) s.mesh.morph[slot].morph_from_m = height_m;
    s.mesh.dirty_vertices.mark(slot);
}

// A vertex that is drawn: its own numbers.
void refresh_vertex(CutState& s, std::uint32_t vertex, SampleIndex v) {
    const TerrainData::Vertex now = s.pages.grid.terrain->vertex(v);
    const std::uint32_t slot = s.pages.vertex_slot[vertex];
    refresh_hole(s.mesh, slot, now.hole);
    MeshVertex& drawn = s.mesh.vertices[slot];
    if (s.mesh.morph == nullptr) {
        if (drawn.height_m == now.height_m) return;
        drawn.height_m = now.height_m;
        return s.mesh.dirty_vertices.mark(slot);
    }
    MorphVertex& morph = s.mesh.morph[slot];
    if (drawn.height_m == now.height_m && morph.error_m == now.error_m && morph.radius_m == now.radius_m) return;
    if (morph.morph_from_m == drawn.height_m) morph.morph_from_m = now.height_m; // where nothing morphs, or at the rim
    drawn.height_m = now.height_m;
    morph.error_m = now.error_m;
    morph.radius_m = now.radius_m;
    s.mesh.dirty_vertices.mark(slot);
}

// And where it starts: on the edge that it splits.
void refresh_start(CutState& s, std::uint32_t vertex, SampleIndex v) {
    if (s.mesh.morph == nullptr) return;
    const Pages& pages = s.pages;
    const std::uint32_t slot = pages.vertex_slot[vertex];
    const Diamond d = diamond(pages.grid.terrain->tree, v);
    const std::uint32_t ends[2] = {slot_of(pages, d.ends[0]), slot_of(pages, d.ends[1])};
    if (ends[0] == no_index || ends[1] == no_index) return;
    const float from_m = flat_height(pages.grid, s.mesh, slot, v, Tree::step_log2(v),
                                     Tree::kind(v) == VertexKind::centre, ends[0], ends[1]);
    if (s.mesh.morph[slot].morph_from_m == from_m) return;
    s.mesh.morph[slot].morph_from_m = from_m;
    s.mesh.dirty_vertices.mark(slot);
}

// Vertices of one plane: those at a change of their step, or around one of heights.
struct Followed {
    Plane plane;
    Rect squares;
};
// f(Followed) for the planes that a change concerns.
template <typename F>
void for_each_followed(const Tree& tree, const Rect& places, int step_log2, const F& f) {
    const bool all = step_log2 < 0;
    edit::for_each_plane(all ? 0 : step_log2, all ? tree.tile_log2 - 1 : step_log2, [&](const Plane& plane) {
        const Rect squares = all ? edit::around(tree, plane, places) : plane.squares(places).within(plane.all(tree));
        if (!squares.empty()) f(Followed{plane, squares});
    });
}
// visit(vertex, place) for those that have states.
template <typename Visit>
void for_each_vertex(const Pages& pages, const Followed& followed, const Visit& visit) {
    const auto& [plane, squares] = followed;
    for (std::int32_t j = squares.y0; j <= squares.y1; ++j)
        for (std::int32_t i = squares.x0; i <= squares.x1; ++i)
            if (const std::uint32_t vertex = find_vertex(pages, {plane.z, plane.kind, i, j}); vertex != no_index)
                visit(vertex, plane.at(i, j));
}

// --- triangles that come, because a hole is filled, and those that go, because one is cut

// The triangle of a key, if there is one: drawn or not, as its corners are by now. False: no segment is free.
bool relist(Mesh& mesh, std::uint32_t tile, std::uint32_t key) {
    const std::uint32_t slot = mesh.triangle_of[key];
    if (slot == no_index) return true;
    const std::uint32_t* const at = mesh.indices + std::size_t{slot} * 3;
    const MeshTriangle t{at[0], at[1], at[2]};
    const std::uint32_t from = mesh.segment_tile[slot >> mesh.segment_log2], to = list_for(mesh, tile, t);
    if (from == to) return true;
    // Its own segment comes free if it is the only one there.
    if (needs_segment(mesh, mesh.tiles[to]) && mesh.free_segment_count == 0 && mesh.tiles[from].in_last != 1)
        return false;
    remove_triangle(mesh, slot, key);
    append_triangle(mesh, to, t, key);
    return true;
}

// The tile of a triangle of a vertex, by its direction: a side on a border has some in both.
std::uint32_t tile_of(const Grid& grid, const Site& site, std::uint32_t d) {
    const Site inside = site.kind == VertexKind::centre
                            ? site
                            : parent_site(site, static_cast<int>(site.kind == VertexKind::side_x ? d >> 1 : d & 1));
    const std::int32_t log2 = grid.steps[inside.z].log2;
    return grid.terrain->tile_at(inside.i >> log2, inside.j >> log2);
}

// All triangles with a corner in these places. False: no segment is free.
bool relist_around(CutState& s, const Rect& places) {
    const Pages& pages = s.pages;
    const TerrainData& t = *pages.grid.terrain;
    bool all = true;
    // A triangle's right angle lies one step away from its other corners at most.
    edit::for_each_plane(0, t.tree.tile_log2 - 1, [&](const Plane& plane) {
        const Rect squares = plane.squares(places.grown(1 << plane.z)).within(plane.all(t.tree));
        if (squares.empty()) return;
        for_each_vertex(pages, {plane, squares}, [&](std::uint32_t vertex, SampleIndex v) {
            if (!is_active(pages, vertex)) return;
            const std::uint32_t slot = pages.vertex_slot[vertex];
            for (std::uint32_t d = 0; d < 4 && all; ++d)
                if (s.mesh.triangle_of[slot * 4 + d] != no_index)
                    all = relist(s.mesh, tile_of(pages.grid, site_at(v), d), slot * 4 + d);
        });
    });
    // Base triangles, of tiles whose root is not active: their right angles are corners.
    for (std::uint32_t tile = 0; tile < s.mesh.tile_count && all; ++tile) {
        const SampleIndex at = t.tile_xy(tile);
        const std::int32_t side = t.tree.side();
        if (!places.meets({at.column * side, at.row * side, (at.column + 1) * side, (at.row + 1) * side})) continue;
        for (const Bearing corner : {Bearing::north_east, Bearing::south_west}) {
            const bool east = corner == Bearing::north_east;
            const std::uint32_t slot = t.corner_at(at.column + east, at.row + !east);
            all = all && relist(s.mesh, tile, slot * 4 + static_cast<std::uint32_t>(child_number(corner)));
        }
    }
    return all;
}

// False: triangles that have become hidden, or that are not any more, find no segment.
bool follow(CutState& s, const Rect& places, int step_log2, bool holes) {
    Pages& pages = s.pages;
    const TerrainData& t = *pages.grid.terrain;
    for_each_followed(t.tree, places, step_log2, [&](const Followed& f) {
        edit::for_each_page(t, f.plane, f.squares, [&](std::uint32_t page) { refresh_page(s, page); });
    });
    edit::for_each_corner(t, places, [&](SampleIndex at, std::uint32_t) { refresh_corner(s, at); });
    std::uint32_t last = no_index;
    for_each_followed(t.tree, places, step_log2, [&](const Followed& f) {
        for_each_vertex(pages, f, [&](std::uint32_t vertex, SampleIndex v) {
            if (is_active(pages, vertex)) refresh_vertex(s, vertex, v);
            const std::uint32_t group = vertex / group_lanes;
            if (group == last) return;
            last = group;
            const GroupState& g = pages.groups[group];
            if (g.queue == unqueued && (g.ready() | g.active) != 0) make_due(s.work.schedule, group);
        });
    });
    const bool listed = !holes || relist_around(s, places);
    if (s.morphing.now.morph == Morph::none) return listed;
    for_each_followed(t.tree, places, step_log2, [&](const Followed& f) {
        for_each_vertex(pages, f, [&](std::uint32_t vertex, SampleIndex v) {
            if (is_active(pages, vertex) && !morphs_out(s.mesh, pages.vertex_slot[vertex])) refresh_start(s, vertex, v);
        });
    });
    return listed;
}

} // namespace

void follow_bases(CutState& s) {
    const TerrainData& t = *s.pages.grid.terrain;
    s.mesh.some_hidden = s.mesh.some_hidden || t.has_voids(); // edits may have come since it was created
    if (s.pages.seen_bases == t.ground_changes) return;
    s.pages.seen_bases = t.ground_changes;
    for (std::uint32_t slot = 0; slot < s.pages.fresh; ++slot) {
        PageState& page = s.pages.state[slot];
        if (page.page == no_index) continue;
        const PageEntry now = t.page_table[page.page];
        if (now.slot == page.terrain_slot) page.base = now.base; // otherwise it is entered anew
    }
}

void follow_ground(CutState& s) {
    const TerrainData& t = *s.pages.grid.terrain;
    if (s.pages.seen_ground == t.ground_changes) return;
    follow_bases(s);
    bool lacks_segment = false;
    const Rect all = edit::grid_of(t.tree);
    if (t.changed_ground == nullptr || t.ground_changes - s.pages.seen_ground > ground_change_log) {
        lacks_segment = !follow(s, all, heights_changed, t.has_voids());
    } else {
        for (std::uint64_t n = s.pages.seen_ground; n < t.ground_changes; ++n) {
            const GroundChange& c = t.changed_ground[n % ground_change_log];
            const Rect places{c.first.column, c.first.row, c.last.column, c.last.row};
            lacks_segment = !follow(s, places, c.step_log2, c.holes) || lacks_segment;
        }
    }
    s.pages.seen_ground = t.ground_changes;
    if (!lacks_segment) return;
    // Triangles that are hidden by now have no segment: then from the coarsest mesh, where all have room.
    s.frame.full_capacities |= cut_budget_triangles;
    reset(s);
    begin_at_roots(s.pages, s.work, s.mesh);
}

} // namespace fjell
