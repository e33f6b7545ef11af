#include "cut/change.h"

#include <algorithm>
#include <bit>

#include "cut/evaluate.h"
#include "cut/pages.h"
#include "cut/state.h"

namespace fjell {

namespace {

// A lane has work of this rank: its group goes to that queue, unless it is in one of a higher rank.
void queue_activation(const Pages& pages, Work& work, std::uint32_t vertex, std::uint32_t rank) {
    const std::uint32_t group = vertex / group_lanes;
    const GroupState& b = pages.groups[group];
    if (b.queue == being_visited) return; // will be evaluated
    const bool queued = b.queue != unqueued;
    std::uint32_t& calls = work.queues.nodes[group].calls;
    calls = (queued ? calls : 0) | bit_of(vertex);
    if (queued && b.queue < deactivation_queue && b.queue >= work_queues + rank) return;
    forget(work.schedule, group);
    unlink(work.queues, group);
    push_back(work.queues, work_queues + rank, group);
    work.queues.work_ranks |= 1u << rank;
}

bool is_evicting(const Pages& pages, std::uint32_t vertex) {
    return pages.state[vertex / group_lanes / max_page_groups].status == PageStatus::evicting;
}

// A vertex has just become ready, or an active one childless: when must it be evaluated?
void reevaluate(const Pages& pages, Work& work, const Views& views, std::uint32_t vertex, const Site& site,
                bool active) {
    if (is_evicting(pages, vertex)) return;
    const Evaluation v = evaluate_vertex(pages, views, vertex, site, active);
    const std::uint32_t group = vertex / group_lanes;
    if (v.wanted == active) {
        // What waits in a queue is evaluated in any case.
        if (pages.groups[group].queue == unqueued) tighten(work.schedule, group, v.slack_m, grade_of(v.code));
    } else if (!active) {
        queue_activation(pages, work, vertex, rank_of(views, v));
    } else if (pages.groups[group].queue == unqueued) {
        forget(work.schedule, group);
        push_back(work.queues, deactivation_queue, group);
        work.queues.nodes[group].calls = static_cast<std::uint32_t>(bit_of(vertex)) << 16;
    }
}

[[maybe_unused]] bool is_ready(const Pages& pages, std::uint32_t vertex) {
    return (pages.groups[vertex / group_lanes].ready() & bit_of(vertex)) != 0;
}
[[maybe_unused]] bool has_active_child(const Pages& pages, std::uint32_t vertex) {
    return (pages.groups[vertex / group_lanes].parental() & bit_of(vertex)) != 0;
}

// The triangle of a parent that a vertex splits.
struct Split {
    std::uint32_t parent; // no_index: a tile's corner
    std::uint32_t key;    // of the triangle: the parent's vertex slot * 4 + direction
    std::uint32_t tile;
    Halves halves;
};

// One or two of them: at the terrain's rim a side has one parent.
int splits_of(const Pages& pages, const Around& around, std::uint32_t vertex, Split (&out)[2]) {
    const Site& site = around.site;
    const bool root = site.z == pages.grid.terrain->tree.tile_log2 - 1 && site.kind == VertexKind::centre;
    int count = 0;
    for (int n = 0; n < 2; ++n) {
        Split split{};
        if (root) {
            // A tile's root splits its two base triangles, whose right angles are its north-east and south-west corner.
            const Bearing bearing = n == 0 ? Bearing::north_east : Bearing::south_west;
            const std::uint32_t corner = pages.grid.terrain->corner_at(site.i + 1 - n, site.j + n);
            split = {no_index, corner * 4 + static_cast<std::uint32_t>(child_number(bearing)), 0, halves(bearing)};
        } else {
            split.parent = around.parent[n];
            if (split.parent == no_index) continue;
            const Bearing bearing = parent_bearing(site, n);
            FJELL_ASSERT(is_active(pages, split.parent));
            split.key = pages.vertex_slot[split.parent] * 4 + static_cast<std::uint32_t>(child_number(bearing));
            split.halves = halves(bearing);
        }
        // The centre of the two lies inside its tile.
        const std::uint32_t inside = site.kind == VertexKind::centre ? vertex : split.parent;
        split.tile = pages.state[inside / group_lanes / max_page_groups].tile;
        out[count++] = split;
    }
    return count;
}

bool room_for(const Mesh& mesh, const Split* splits, int count) {
    // Two tiles at most, and what is not drawn; one segment each will do. Two more stay back for deactivations.
    std::uint32_t segments = mesh.some_hidden && room_in(mesh, hidden_tile(mesh)) < 4 ? 1 : 0;
    for (int i = 0; i < count; ++i) segments += room_in(mesh, splits[i].tile) < 4 ? 1 : 0;
    return segments == 0 || mesh.free_segment_count >= segments + 2;
}

// (parent, a, b) becomes (v, parent, a) and (v, b, parent).
void replace_by_halves(Pages& pages, Mesh& mesh, const Split& split, std::uint32_t slot) {
    const std::uint32_t* const t = mesh.indices + std::size_t{mesh.triangle_of[split.key]} * 3;
    const std::uint32_t p = t[0], a = t[1], b = t[2];
    replace_triangle(mesh, split.key, split.tile, {slot, p, a}, slot * 4 + split.halves.first);
    const MeshTriangle second{slot, b, p};
    append_triangle(mesh, list_for(mesh, split.tile, second), second, slot * 4 + split.halves.second);
    if (split.parent != no_index) pages.groups[split.parent / group_lanes].child[split.key % 4] |= bit_of(split.parent);
}

// All children have states then. False: there was none to be had, and nothing has changed.
bool attach_children(Pages& pages, Work& work, Mesh& mesh, Visibility& visibility, Around& around) {
    const bool leaf = around.site.kind != VertexKind::centre && around.site.z == 0;
    for (int d = 0; d < 4; ++d) {
        around.child[d] = no_index;
        const Site child = child_site(around.site, d);
        if (leaf || !exists(pages.grid, child)) continue;
        const VertexPlace at = place_of(pages.grid, child);
        if (pages.page_groups[at.page] == no_index && !attach_page(pages, work, mesh, visibility, at.page)) {
            while (d-- != 0) // what was attached for nothing
                if (around.child[d] != no_index) note_idle(pages, around.child[d] / group_lanes / max_page_groups);
            return false;
        }
        const std::uint32_t first = pages.page_groups[at.page];
        if (first != no_index) around.child[d] = first * group_lanes + at.vertex;
    }
    return true;
}

} // namespace

Outcome activate(CutState& s, std::uint32_t vertex, const Around& found) {
    FJELL_ASSERT(is_ready(s.pages, vertex) && !is_active(s.pages, vertex) &&
                 !has_active_child(s.pages, vertex)); // invariant 1
    const Site& site = found.site;
    Split splits[2];
    const int count = splits_of(s.pages, found, vertex, splits);
    if (free_vertices(s.mesh) == 0) return Outcome::no_vertices;
    if (!room_for(s.mesh, splits, count)) return Outcome::no_triangles;
    for (int n = 0; n < count; ++n) FJELL_ASSERT(s.mesh.triangle_of[splits[n].key] != no_index);
    const std::uint32_t first = s.mesh.triangle_of[splits[0].key];
    const std::uint32_t ends[2] = {s.mesh.indices[std::size_t{first} * 3 + 1],
                                   s.mesh.indices[std::size_t{first} * 3 + 2]};
    const bool morphing = s.morphing.now.morph != Morph::none;
    if (morphing && (is_morphing(s.mesh, s.morphing, ends[0]) || is_morphing(s.mesh, s.morphing, ends[1]))) {
        s.morphing.arrives_ticks =
            std::max(arrival_ticks(s.mesh, s.morphing, ends[0]), arrival_ticks(s.mesh, s.morphing, ends[1]));
        return Outcome::rising;
    }
    // What is about to morph out must not get children again, or its page could never be evicted.
    for (int n = 0; morphing && n < count; ++n)
        if (splits[n].parent != no_index &&
            (is_evicting(s.pages, splits[n].parent) || morphs_out(s.mesh, s.pages.vertex_slot[splits[n].parent])))
            return Outcome::gated;
    Around attached;
    if (found.lacks_child) {
        attached = found;
        if (!attach_children(s.pages, s.work, s.mesh, s.visibility, attached)) return Outcome::no_pages;
    }
    const Around& around = found.lacks_child ? attached : found;
    const Evaluation v = evaluate_vertex(s.pages, s.views, vertex, site, true);

    const std::uint32_t slot = take_vertex(s.mesh);
    const SampleIndex at = s.pages.grid.terrain->tree.sample(site_coord(site));
    s.mesh.vertices[slot] = {at.column, at.row, v.y};
    s.mesh.hole[slot] = is_void(record_of(s.pages, vertex));
    if (s.mesh.morph != nullptr) s.mesh.morph[slot] = {v.y, v.error_m, v.radius_m, activated_long_ago_s};
    if (morphing) {
        s.mesh.morph[slot].morph_from_m = flat_height(s.pages.grid, s.mesh, slot, site_coord(site), site.z,
                                                      site.kind == VertexKind::centre, ends[0], ends[1]);
        // What comes into sight is refined before it is seen: at once, or it would still morph when it is.
        if (s.visibility.now.count == 0 || seen(s.views, v))
            s.mesh.morph[slot].activated_s =
                activation_time_s(s.views, s.morphing, s.frame, v.x, v.y, v.z, v.error_m, v.radius_m);
        if (s.mesh.morph[slot].activated_s != activated_long_ago_s) note_late(s, v);
    }
    s.mesh.dirty_vertices.mark(slot);
    s.pages.vertex_slot[vertex] = slot;
    GroupState& group = s.pages.groups[vertex / group_lanes];
    group.active |= bit_of(vertex);
    PageState& page = s.pages.state[vertex / group_lanes / max_page_groups];
    ++page.active;
    page.used = true;

    for (int n = 0; n < count; ++n) replace_by_halves(s.pages, s.mesh, splits[n], slot);
    for (int d = 0; d < 4; ++d) {
        const std::uint32_t child = around.child[d];
        if (child == no_index) continue;
        GroupState& of_child = s.pages.groups[child / group_lanes];
        of_child.parent[parent_number(site.kind, d)] |= bit_of(child);
        count_parents(s.pages, child / group_lanes / max_page_groups, 1);
        if (of_child.ready() & bit_of(child)) reevaluate(s.pages, s.work, s.views, child, child_site(site, d), false);
    }
    return Outcome::done;
}

Outcome deactivate(Pages& pages, Work& work, Mesh& mesh, const Views& views, std::uint32_t vertex,
                   const Around& found) {
    FJELL_ASSERT(is_active(pages, vertex) && !has_active_child(pages, vertex)); // invariant 1
    // A page may have got its state since, with this parent.
    Around again;
    if (found.lacks_child) again = find_around(pages, vertex);
    const Around& around = found.lacks_child ? again : found;
    const Site& site = around.site;
    Split splits[2];
    const int count = splits_of(pages, around, vertex, splits);
    const std::uint32_t slot = pages.vertex_slot[vertex];
    if (mesh.some_hidden && mesh.free_segment_count < 2) {
        for (int n = 0; n < count; ++n)
            if (room_in(mesh, splits[n].tile) < 2 || room_in(mesh, hidden_tile(mesh)) < 2) return Outcome::no_triangles;
    }
    for (int n = 0; n < count; ++n) {
        const Split& split = splits[n];
        const std::uint32_t first = mesh.triangle_of[slot * 4 + split.halves.first];
        // (v, parent, a) and (v, b, parent) become (parent, a, b) again.
        const std::uint32_t p = mesh.indices[std::size_t{first} * 3 + 1], a = mesh.indices[std::size_t{first} * 3 + 2];
        const std::uint32_t b = mesh.indices[std::size_t{mesh.triangle_of[slot * 4 + split.halves.second]} * 3 + 1];
        const std::uint32_t second_key = slot * 4 + split.halves.second;
        replace_triangle(mesh, slot * 4 + split.halves.first, split.tile, {p, a, b}, split.key);
        remove_triangle(mesh, mesh.triangle_of[second_key], second_key);
    }
    give_vertex(mesh, slot);
    GroupState& group = pages.groups[vertex / group_lanes];
    group.active &= static_cast<std::uint16_t>(~bit_of(vertex));
    FJELL_ASSERT(pages.state[vertex / group_lanes / max_page_groups].active != 0);
    --pages.state[vertex / group_lanes / max_page_groups].active;
    for (int d = 0; d < 4; ++d) {
        const std::uint32_t child = around.child[d];
        if (child == no_index) continue;
        pages.groups[child / group_lanes].parent[parent_number(site.kind, d)] &=
            static_cast<std::uint16_t>(~bit_of(child));
        const std::uint32_t page = child / group_lanes / max_page_groups;
        FJELL_ASSERT(pages.state[page].parents != 0);
        if (--pages.state[page].parents != 0) continue;
        --pages.busy;
        note_idle(pages, page);
    }
    for (int n = 0; n < count; ++n) {
        const Split& split = splits[n];
        if (split.parent == no_index) continue;
        GroupState& of_parent = pages.groups[split.parent / group_lanes];
        of_parent.child[split.key % 4] &= static_cast<std::uint16_t>(~bit_of(split.parent));
        if (!(of_parent.parental() & bit_of(split.parent)))
            reevaluate(pages, work, views, split.parent, site_of(pages, split.parent), true);
    }
    return Outcome::done;
}

} // namespace fjell
