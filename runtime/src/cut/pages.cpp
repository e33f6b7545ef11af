#include "cut/pages.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "cut/change.h"
#include "cut/lag.h"
#include "cut/morph.h"

namespace fjell {

namespace {

// The sphere of the tile's root holds all of the tile.
void bound_tile(CutState& s, const PageSlot& info, bool loaded) {
    TileList& tile = s.tiles[info.tile];
    tile.bounded = loaded;
    if (!loaded) return;
    const std::int32_t half = s.terrain->tree.side() / 2, side = s.terrain->tree.side();
    const Coord root{info.tile_x * side + half, info.tile_y * side + half}, at = s.terrain->tree.sample(root);
    const TerrainData::Vertex v = s.terrain->vertex(root);
    tile.centre_m[0] = s.terrain->x_m(at.x);
    tile.centre_m[1] = v.height_m;
    tile.centre_m[2] = s.terrain->z_m(at.y);
    tile.radius_m = v.radius_m;
}

// Of a page that was just loaded nothing is active: only lanes with a parent in another page can be ready. In any page
// but page 0 those are the centres, whose parents belong to the coarser step, and the sides along its border.
std::uint32_t outward_lanes(const PageSlot& info, const GroupShape& shape) {
    const std::uint32_t all = (1u << shape.lanes) - 1;
    if (info.shape == 0) return all;
    switch (shape.kind) {
    case VertexKind::centre: break;
    case VertexKind::side_x: return shape.j0 == 0 || shape.j0 == page_squares ? all : 0;
    case VertexKind::side_y: return shape.along_y ? all : shape.i0 == 0 ? 1 : 0;
    }
    return all;
}

// The finest step of page 0.
std::uint32_t coarse_z(const CutState& s) {
    return static_cast<std::uint32_t>(std::max(s.terrain->tree.tile_log2 - page_squares_log2, 0));
}

void empty_slot(PageSlot& info) {
    const bool listed = info.listed;
    info = {};
    info.listed = listed;
}

void attach_page(CutState& s, std::uint32_t slot) {
    const TerrainData& t = *s.terrain;
    const std::uint32_t page = t.slot_page[slot];
    PageSlot& info = s.page_slot[slot];
    FJELL_ASSERT(info.status == PageSlotStatus::empty && s.page_groups[page] == no_index);
    empty_slot(info);
    info.page = page;
    info.loads = t.slot_loads[slot];
    info.tile = page / s.pages_per_tile;
    info.tile_x = static_cast<std::int32_t>(info.tile) % s.tiles_x;
    info.tile_y = static_cast<std::int32_t>(info.tile) / s.tiles_x;
    info.base = t.page_table[page].base;
    info.status = PageSlotStatus::live;
    const std::uint32_t in_tile = page % s.pages_per_tile;
    if (in_tile != 0) {
        const Coord position = t.pages.page_position(in_tile);
        info.shape = 1;
        info.z = static_cast<std::uint8_t>(t.pages.page_step_log2(in_tile));
        info.i0 = position.x << page_squares_log2;
        info.j0 = position.y << page_squares_log2;
    }
    info.x0 = info.tile_x * s.terrain->tree.side() + (info.i0 << (info.z + 1));
    info.y0 = info.tile_y * s.terrain->tree.side() + (info.j0 << (info.z + 1));
    begin_page(s.schedule, slot, in_tile == 0 ? coarse_z(s) : info.z); // ticks are of the finest step in a page
    bound_page(s, info, slot);
    s.page_groups[page] = slot * max_page_groups;
    if (in_tile == 0) bound_tile(s, info, true);
    clear_page(s, slot);
    const bool nothing_active = s.budget.vertices - free_vertices(s) == corner_slots(s);
    for (std::uint32_t n = 0; n < s.shapes[info.shape].count; ++n) {
        const std::uint32_t number = slot * max_page_groups + n;
        GroupState& b = s.groups[number];
        if (!nothing_active) {
            const std::uint32_t lanes = outward_lanes(info, s.shapes[info.shape].groups[n]);
            if (lanes == 0) continue;
            const ParentMasks parents = parents_of(s, number, lanes);
            b.parent[0] |= parents.parent[0]; // to those that do not exist
            b.parent[1] |= parents.parent[1];
            touch(s, slot);
        }
        if (b.ready() != 0) make_due(s.schedule, number);
    }
}

void detach_page(CutState& s, std::uint32_t slot) {
    PageSlot& info = s.page_slot[slot];
    FJELL_ASSERT(info.status != PageSlotStatus::empty && info.active == 0);
    for (std::uint32_t n = 0; n < s.shapes[info.shape].count; ++n) {
        const std::uint32_t number = slot * max_page_groups + n;
        unlink(s.queues, number);
        s.groups[number] = {};
        s.groups[number].queue = unqueued;
    }
    clear_page_schedule(s.schedule, slot);
    if (info.late) forget_late_page(s, slot);
    s.page_groups[info.page] = no_index;
    if (info.page % s.pages_per_tile == 0) bound_tile(s, info, false);
    for (std::uint32_t i = 0; i < s.evicting_count; ++i)
        if (s.evicting[i] == slot) s.evicting[i--] = s.evicting[--s.evicting_count];
    empty_slot(info);
    info.page = no_index;
}

// One vertex of the subtree below an active vertex that has no active children itself.
std::uint32_t lowest_below(const CutState& s, std::uint32_t vertex) {
    for (;;) {
        const GroupState& b = s.groups[vertex / group_lanes];
        int d = 0;
        while (d < 4 && !(b.child[d] >> vertex % group_lanes & 1)) ++d;
        if (d == 4) return vertex;
        vertex = find_vertex(s, child_site(site_of(s, vertex), d));
    }
}

// The first vertex that keeps a page from leaving, or no_index: any active one that the page holds, its neighbours'
// vertices on its borders included. Those have both parents active, one of them here: it is enough to look here.
std::uint32_t first_active(const CutState& s, std::uint32_t slot) {
    if (s.page_slot[slot].active == 0) return no_index;
    for (std::uint32_t n = 0; n < s.shapes[s.page_slot[slot].shape].count; ++n) {
        const std::uint32_t number = slot * max_page_groups + n;
        if (s.groups[number].active != 0)
            return number * group_lanes + static_cast<std::uint32_t>(std::countr_zero(s.groups[number].active));
    }
    return no_index;
}

} // namespace

// At the terrain's rim, and above a tile's root, parents that do not exist count as active.
ParentMasks absent_parents(const CutState& s, const Site& first, const GroupShape& shape) {
    const auto lanes = static_cast<std::uint16_t>((1u << shape.lanes) - 1);
    const std::int32_t rows = s.tiles_y << s.steps[first.z].log2;
    ParentMasks absent{};
    switch (shape.kind) {
    case VertexKind::centre:
        if (first.z == s.terrain->tree.tile_log2 - 1) absent = {{1, 1}};
        break;
    case VertexKind::side_x:
        if (first.j == 0) absent.parent[0] = lanes;
        if (first.j == rows) absent.parent[1] = lanes;
        break;
    case VertexKind::side_y:
        if (first.i == 0) absent.parent[0] = 1;
        if (shape.along_y) absent.parent[1] = lanes; // only the terrain's rim owns such a group
        break;
    }
    return absent;
}

void clear_page(CutState& s, std::uint32_t slot) {
    PageSlot& info = s.page_slot[slot];
    info.active = 0;
    info.touched = false;
    const std::int32_t n = info.shape == 0 ? 1 << s.terrain->tree.tile_log2 : page_squares;
    const std::int32_t columns = s.tiles_x << s.steps[info.z].log2, rows = s.tiles_y << s.steps[info.z].log2;
    const std::int32_t i0 = (info.tile_x << s.steps[info.z].log2) + info.i0,
                       j0 = (info.tile_y << s.steps[info.z].log2) + info.j0;
    const bool rim = info.shape == 0 || i0 == 0 || j0 == 0 || i0 + n >= columns || j0 + n >= rows;
    static_assert(unqueued == 0);
    std::memset(static_cast<void*>(s.groups + std::size_t{slot} * max_page_groups), 0,
                s.shapes[info.shape].count * sizeof(GroupState));
    for (std::uint32_t k = 0; rim && k < s.shapes[info.shape].count; ++k) {
        const std::uint32_t number = slot * max_page_groups + k;
        GroupState& b = s.groups[number];
        const GroupShape& shape = s.shapes[info.shape].groups[k];
        const Site first = site_of(s, number * group_lanes);
        // A border has a lane in each page that holds it; only the owner's counts.
        if (exists(s, first) && find_vertex(s, first) != number * group_lanes) continue;
        const ParentMasks absent = absent_parents(s, first, shape);
        b.parent[0] = absent.parent[0];
        b.parent[1] = absent.parent[1];
    }
}

ParentMasks parents_of(const CutState& s, std::uint32_t group, std::uint32_t lanes) {
    ParentMasks masks{};
    for (; lanes != 0; lanes &= lanes - 1) {
        const auto lane = static_cast<std::uint32_t>(std::countr_zero(lanes));
        const std::uint32_t vertex = group * group_lanes + lane;
        const Site site = site_of(s, vertex);
        // A border has a lane in each page that holds it; only the owner's counts.
        if (!exists(s, site) || find_vertex(s, site) != vertex) continue;
        const bool root = site.kind == VertexKind::centre && site.z == s.terrain->tree.tile_log2 - 1;
        for (int n = 0; n < 2; ++n) {
            const Site parent = parent_site(site, n);
            bool active = root || !exists(s, parent);
            if (!active) {
                const std::uint32_t found = find_vertex(s, parent);
                active = found != no_index && (s.groups[found / group_lanes].active >> found % group_lanes & 1);
            }
            masks.parent[n] |= static_cast<std::uint16_t>(static_cast<std::uint32_t>(active) << lane);
        }
    }
    return masks;
}

namespace {

// Does the slot hold another page than the cut has there, or none?
bool has_changed(const CutState& s, std::uint32_t slot) {
    const TerrainData& t = *s.terrain;
    const PageSlot& info = s.page_slot[slot];
    return info.page != no_index && (info.page != t.slot_page[slot] || info.loads != t.slot_loads[slot]);
}

// Lets go of what the slot held, if it holds something else by now. False: the cut had to begin again.
bool detach_if_changed(CutState& s, std::uint32_t slot) {
    if (!has_changed(s, slot)) return true;
    // The host did not call cut_release_page, or did not wait for it: the vertices must be deactivated all the same.
    for (std::uint32_t v = first_active(s, slot); v != no_index; v = first_active(s, slot)) {
        if (deactivate(s, lowest_below(s, v)) == Outcome::done) continue;
        // No segment for triangles that were hidden: then from the coarsest mesh, where all have room.
        rescan_pages(s);
        reset(s);
        begin_at_roots(s);
        return false;
    }
    detach_page(s, slot);
    return true;
}

void attach_if_loaded(CutState& s, std::uint32_t slot) {
    if (s.terrain->slot_page[slot] != no_index && s.page_slot[slot].page == no_index) attach_page(s, slot);
}

} // namespace

void rescan_pages(CutState& s) {
    s.seen_changes = s.terrain->changes - change_log - 1; // more than the log remembers
}

bool has_lost_pages(const CutState& s) {
    const TerrainData& t = *s.terrain;
    const std::uint64_t count = t.changes - s.seen_changes;
    const bool all = count > change_log;
    for (std::uint64_t n = 0; n < (all ? t.slot_count : count); ++n)
        if (has_changed(s, all ? static_cast<std::uint32_t>(n) : t.changed_slots[(s.seen_changes + n) % change_log]))
            return true;
    return false;
}

void sync_pages(CutState& s) {
    const TerrainData& t = *s.terrain;
    const std::uint64_t seen = s.seen_changes, count = t.changes - seen;
    if (count == 0) return;
    s.seen_changes = t.changes;
    const auto logged = [&](std::uint64_t n) { return t.changed_slots[(seen + n) % change_log]; };
    const bool all = count > change_log;
    const std::uint64_t end = all ? t.slot_count : count;
    for (std::uint64_t n = 0; n < end; ++n)
        if (!detach_if_changed(s, all ? static_cast<std::uint32_t>(n) : logged(n))) return;
    for (std::uint64_t n = 0; n < end; ++n) attach_if_loaded(s, all ? static_cast<std::uint32_t>(n) : logged(n));
}

namespace {

// The group is evaluated in this frame.
void revisit(CutState& s, std::uint32_t number) {
    // What waits in a queue is evaluated anyway.
    if (s.groups[number].queue == unqueued && s.groups[number].ready() != 0) make_due(s.schedule, number);
}

} // namespace

void cancel_eviction(CutState& s, std::uint32_t slot) {
    PageSlot& info = s.page_slot[slot];
    if (info.status != PageSlotStatus::evicting) return;
    info.status = PageSlotStatus::live;
    s.evicting_count =
        static_cast<std::uint32_t>(std::remove(s.evicting, s.evicting + s.evicting_count, slot) - s.evicting);
    for (std::uint32_t n = 0; n < s.shapes[info.shape].count; ++n) revisit(s, slot * max_page_groups + n);
    open_gate(s); // for what its vertices are the parents of
}

namespace {

// All of it at once.
void deactivate_page(CutState& s, std::uint32_t slot) {
    while (s.report.items < s.item_limit) {
        const std::uint32_t v = first_active(s, slot);
        if (v == no_index || deactivate(s, lowest_below(s, v)) != Outcome::done) return;
        ++s.report.items;
        ++s.report.deactivations;
    }
}

// Whatever may begin to: the vertices without active children, and of the others' descendants those that are.
void morph_out_page(CutState& s, std::uint32_t slot) {
    for (std::uint32_t n = 0; n < s.shapes[s.page_slot[slot].shape].count; ++n) {
        const std::uint32_t number = slot * max_page_groups + n;
        for (std::uint32_t lanes = s.groups[number].active; lanes != 0; lanes &= lanes - 1) {
            if (s.report.items >= s.item_limit) return;
            const std::uint32_t v =
                lowest_below(s, number * group_lanes + static_cast<std::uint32_t>(std::countr_zero(lanes)));
            if (morphs_out(s, s.vertex_slot[v])) continue;
            begin_morphing_out(s, v);
            note_late(s, v / group_lanes / max_page_groups);
            ++s.report.items;
            ++s.report.evaluations; // it was evaluated
        }
    }
}

// Deactivates what has arrived at its edge. An entry whose vertex is gone, or morphs out again, belongs to a page that
// was unloaded without waiting.
void end_morphing_out(CutState& s) {
    while (s.morphing_out_count != 0 && s.report.items < s.item_limit) {
        const std::uint32_t vertex = s.morphing_out[s.first_morphing_out];
        const bool there =
            (s.groups[vertex / group_lanes].active & bit_of(vertex)) && morphs_out(s, s.vertex_slot[vertex]);
        if (there && s.morph_now.morph != Morph::none && is_morphing(s, s.vertex_slot[vertex])) return;
        // Children it can have only when morphing has just been switched off.
        const std::uint32_t lowest = there ? lowest_below(s, vertex) : vertex;
        if (there && deactivate(s, lowest) != Outcome::done) return;
        s.report.items += there;
        s.report.deactivations += there;
        if (there) revisit(s, lowest / group_lanes); // its page may have been kept
        if (lowest != vertex) continue;
        s.first_morphing_out = (s.first_morphing_out + 1) % s.budget.vertices;
        --s.morphing_out_count;
        open_gate(s);
    }
}

} // namespace

void evict_pages(CutState& s) {
    end_morphing_out(s);
    for (std::uint32_t i = 0; i < s.evicting_count; ++i)
        if (s.page_slot[s.evicting[i]].active == 0)
            continue;
        else if (s.morph_now.morph == Morph::none)
            deactivate_page(s, s.evicting[i]);
        else
            morph_out_page(s, s.evicting[i]);
}

} // namespace fjell
