#include "cut/pages.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "cut/change.h"
#include "cut/lag.h"
#include "cut/morph.h"
#include "cut/sight.h"

namespace fjell {

namespace {

// The sphere of the tile's root holds all of the tile.
void bound_tile(CutState& s, const PageState& info, bool loaded) {
    TileList& tile = s.mesh.tiles[info.tile];
    tile.bounded = loaded;
    if (!loaded) return;
    const std::int32_t half = s.pages.grid.terrain->tree.side() / 2, side = s.pages.grid.terrain->tree.side();
    const Coord root{info.tile_x * side + half, info.tile_y * side + half},
        at = s.pages.grid.terrain->tree.sample(root);
    const TerrainData::Vertex v = s.pages.grid.terrain->vertex(root);
    tile.centre_m[0] = s.pages.grid.terrain->x_m(at.x);
    tile.centre_m[1] = v.height_m;
    tile.centre_m[2] = s.pages.grid.terrain->z_m(at.y);
    tile.radius_m = v.radius_m;
}

// Of a page that was just loaded nothing is active: only lanes with a parent in another page can be ready. In any page
// but page 0 those are the centres, whose parents belong to the coarser step, and the sides along its border.
std::uint32_t outward_lanes(const PageState& info, const GroupShape& shape) {
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
    return static_cast<std::uint32_t>(std::max(s.pages.grid.terrain->tree.tile_log2 - page_squares_log2, 0));
}

void empty_state(PageState& info) {
    const bool idle = info.idle;
    info = {};
    info.idle = idle;
    info.page = no_index;
}

// Every tile's page 0 is sure of a state.
bool has_state_for(const CutState& s, bool root) {
    return free_pages(s) > (root || !may_lack_pages(s) ? 0 : s.pages.tiles_waiting);
}
std::uint32_t take_page(CutState& s, bool root) {
    if (!has_state_for(s, root)) return no_index;
    return s.pages.free_count != 0 ? s.pages.free[--s.pages.free_count] : s.pages.fresh++;
}

// With nothing active, and no parent. no_index: there is no state to be had.
std::uint32_t attach(CutState& s, std::uint32_t terrain_slot) {
    const TerrainData& t = *s.pages.grid.terrain;
    const LoadedPage& loaded = s.pages.loaded[terrain_slot];
    const std::uint32_t in_tile = loaded.page % s.pages.grid.pages_per_tile, slot = take_page(s, in_tile == 0);
    if (slot == no_index) return no_index;
    PageState& info = s.pages.state[slot];
    FJELL_ASSERT(info.status == PageStatus::empty && s.pages.page_groups[loaded.page] == no_index);
    empty_state(info);
    info.page = loaded.page;
    info.terrain_slot = terrain_slot;
    info.tile = info.page / s.pages.grid.pages_per_tile;
    const Coord tile = t.tile_xy(info.tile);
    info.tile_x = tile.x;
    info.tile_y = tile.y;
    info.base = t.page_table[info.page].base;
    info.status = loaded.evicting ? PageStatus::evicting : PageStatus::live;
    if (loaded.evicting) s.pages.evicting[s.pages.evicting_count++] = slot;
    if (in_tile != 0) {
        const Coord position = t.pages.page_position(in_tile);
        info.shape = 1;
        info.z = static_cast<std::uint8_t>(t.pages.page_step_log2(in_tile));
        info.i0 = position.x << page_squares_log2;
        info.j0 = position.y << page_squares_log2;
    }
    info.x0 = info.tile_x * s.pages.grid.terrain->tree.side() + (info.i0 << (info.z + 1));
    info.y0 = info.tile_y * s.pages.grid.terrain->tree.side() + (info.j0 << (info.z + 1));
    begin_page(s.work.schedule, slot, in_tile == 0 ? coarse_z(s) : info.z); // ticks are of the finest step in a page
    s.pages.page_groups[info.page] = slot * max_page_groups;
    s.bulk.pages[slot].build = 0;
    watch_page(s, slot);
    if (in_tile == 0) {
        --s.pages.tiles_waiting;
        bound_tile(s, info, true);
    }
    mark_absent_parents(s, slot);
    return slot;
}

void detach(CutState& s, std::uint32_t slot) {
    PageState& info = s.pages.state[slot];
    FJELL_ASSERT(info.status != PageStatus::empty && info.active == 0);
    for (std::uint32_t n = 0; n < s.pages.grid.shapes[info.shape].count; ++n) {
        const std::uint32_t number = slot * max_page_groups + n;
        unlink(s.work.queues, number);
        s.pages.groups[number] = {};
    }
    clear_page_schedule(s.work.schedule, slot);
    s.pages.busy -= info.parents != 0;
    if (info.late) forget_late_page(s, slot);
    s.pages.page_groups[info.page] = no_index;
    if (info.shape == 0) {
        ++s.pages.tiles_waiting;
        bound_tile(s, info, false);
    }
    if (info.status == PageStatus::evicting)
        s.pages.evicting_count = static_cast<std::uint32_t>(
            std::remove(s.pages.evicting, s.pages.evicting + s.pages.evicting_count, slot) - s.pages.evicting);
    empty_state(info);
    s.pages.free[s.pages.free_count++] = slot;
}

bool nothing_active(const CutState& s) {
    return s.mesh.capacity - free_vertices(s) == s.mesh.corner_count;
}

// Of a page that has just been attached: which of its vertices have active parents in other pages?
void find_parents(CutState& s, std::uint32_t slot) {
    const PageState& info = s.pages.state[slot];
    const bool none = nothing_active(s);
    for (std::uint32_t n = 0; n < s.pages.grid.shapes[info.shape].count; ++n) {
        const std::uint32_t number = slot * max_page_groups + n;
        GroupState& b = s.pages.groups[number];
        const std::uint32_t lanes = none ? 0 : outward_lanes(info, s.pages.grid.shapes[info.shape].groups[n]);
        if (lanes != 0) {
            const ParentMasks parents = parents_of(s, number, lanes);
            for (std::size_t i = 0; i < 2; ++i) { // those that do not exist are not counted
                const auto more = static_cast<std::uint16_t>(parents.parent[i] & ~b.parent[i]);
                count_parents(s, slot, static_cast<std::uint32_t>(std::popcount(more)));
                b.parent[i] |= more;
            }
        }
        if (b.ready() != 0) make_due(s.work.schedule, number);
    }
}

// A page that has come: some of its vertices may have active parents.
void attach_if_wanted(CutState& s, std::uint32_t terrain_slot) {
    if (s.pages.loaded[terrain_slot].page % s.pages.grid.pages_per_tile != 0 && nothing_active(s)) return;
    const std::uint32_t slot = attach(s, terrain_slot);
    if (slot == no_index) {
        s.pages.some_wait = true;
        return;
    }
    find_parents(s, slot);
    note_idle(s, slot);
}

// One vertex of the subtree below an active vertex that has no active children itself.
std::uint32_t lowest_below(const CutState& s, std::uint32_t vertex) {
    for (;;) {
        const GroupState& b = s.pages.groups[vertex / group_lanes];
        int d = 0;
        while (d < 4 && !(b.child[d] >> vertex % group_lanes & 1)) ++d;
        if (d == 4) return vertex;
        vertex = find_vertex(s, child_site(site_of(s, vertex), d));
    }
}

// The first vertex that keeps a page from leaving, or no_index: any active one that the page holds, its neighbours'
// vertices on its borders included. Those have both parents active, one of them here: it is enough to look here.
std::uint32_t first_active(const CutState& s, std::uint32_t slot) {
    if (s.pages.state[slot].active == 0) return no_index;
    for (std::uint32_t n = 0; n < s.pages.grid.shapes[s.pages.state[slot].shape].count; ++n) {
        const std::uint32_t number = slot * max_page_groups + n;
        if (s.pages.groups[number].active != 0)
            return number * group_lanes + static_cast<std::uint32_t>(std::countr_zero(s.pages.groups[number].active));
    }
    return no_index;
}

} // namespace

ParentMasks absent_parents(const CutState& s, const Site& first, const GroupShape& shape) {
    const auto lanes = static_cast<std::uint16_t>((1u << shape.lanes) - 1);
    ParentMasks absent{};
    switch (shape.kind) {
    case VertexKind::centre:
        if (first.z == s.pages.grid.terrain->tree.tile_log2 - 1) absent = {{1, 1}};
        break;
    case VertexKind::side_x:
        if (!has_square(s, first.z, first.i, first.j - 1)) absent.parent[0] = lanes;
        if (!has_square(s, first.z, first.i, first.j)) absent.parent[1] = lanes;
        break;
    case VertexKind::side_y:
        if (!has_square(s, first.z, first.i - 1, first.j)) absent.parent[0] = 1;
        if (shape.along_y) absent.parent[1] = lanes; // only a rim owns such a group
        break;
    }
    return absent;
}

void mark_absent_parents(CutState& s, std::uint32_t slot) {
    const PageState& info = s.pages.state[slot];
    const std::int32_t n = info.shape == 0 ? 1 << s.pages.grid.steps[info.z].log2 : page_squares;
    const std::int32_t i0 = (info.tile_x << s.pages.grid.steps[info.z].log2) + info.i0,
                       j0 = (info.tile_y << s.pages.grid.steps[info.z].log2) + info.j0;
    const bool west = has_square(s, info.z, i0 - 1, j0), north = has_square(s, info.z, i0, j0 - 1),
               east = has_square(s, info.z, i0 + n, j0), south = has_square(s, info.z, i0, j0 + n);
    const std::uint32_t first = slot * max_page_groups;
    if (west && north && east && south) {
        if (info.shape == 0)
            s.pages.groups[first].parent[0] |= 1, s.pages.groups[first].parent[1] |= 1; // a tile's root has none
        return;
    }
    for (std::uint32_t k = 0; k < s.pages.grid.shapes[info.shape].count; ++k) {
        const GroupShape& shape = s.pages.grid.shapes[info.shape].groups[k];
        const auto lanes = static_cast<std::uint16_t>((1u << shape.lanes) - 1);
        const int z = info.z + shape.z;
        GroupState& group = s.pages.groups[first + k];
        switch (shape.kind) { // of a border that another page owns nothing is said
        case VertexKind::centre:
            if (z + 1 == s.pages.grid.terrain->tree.tile_log2) group.parent[0] |= 1, group.parent[1] |= 1;
            break;
        case VertexKind::side_x:
            if (!north && shape.j0 == 0) group.parent[0] |= lanes;
            if (!south && shape.j0 == 1u << s.pages.grid.steps[z].page_log2) group.parent[1] |= lanes;
            break;
        case VertexKind::side_y:
            if (!east && shape.along_y) group.parent[1] |= lanes;
            if (!west && !shape.along_y && shape.i0 == 0) group.parent[0] |= 1;
            break;
        }
    }
}

void forget_active(CutState& s, std::uint32_t slot) {
    PageState& info = s.pages.state[slot];
    info.active = 0;
    s.pages.busy -= info.parents != 0;
    info.parents = 0;
}

void zero_groups(CutState& s, std::uint32_t slot) {
    static_assert(unqueued == 0);
    std::memset(static_cast<void*>(s.pages.groups + std::size_t{slot} * max_page_groups), 0,
                s.pages.grid.shapes[s.pages.state[slot].shape].count * sizeof(GroupState));
    s.pages.state[slot].used = false;
}

void clear_page(CutState& s, std::uint32_t slot) {
    forget_active(s, slot);
    zero_groups(s, slot);
    mark_absent_parents(s, slot);
}

ParentMasks parents_of(const CutState& s, std::uint32_t group, std::uint32_t lanes) {
    ParentMasks masks{};
    for (; lanes != 0; lanes &= lanes - 1) {
        const auto lane = static_cast<std::uint32_t>(std::countr_zero(lanes));
        const std::uint32_t vertex = group * group_lanes + lane;
        const Site site = site_of(s, vertex);
        // A border has a lane in each page that holds it; only the owner's counts.
        if (!exists(s, site) || find_vertex(s, site) != vertex) continue;
        const bool root = site.kind == VertexKind::centre && site.z == s.pages.grid.terrain->tree.tile_log2 - 1;
        for (int n = 0; n < 2; ++n) {
            const Site parent = parent_site(site, n);
            bool active = root || !exists(s, parent);
            if (!active) {
                const std::uint32_t found = find_vertex(s, parent);
                active = found != no_index && (s.pages.groups[found / group_lanes].active >> found % group_lanes & 1);
            }
            masks.parent[n] |= static_cast<std::uint16_t>(static_cast<std::uint32_t>(active) << lane);
        }
    }
    return masks;
}

namespace {

// Does the terrain's slot hold another page than the cut has there, or none?
bool has_changed(const CutState& s, std::uint32_t terrain_slot) {
    const TerrainData& t = *s.pages.grid.terrain;
    const LoadedPage& known = s.pages.loaded[terrain_slot];
    return known.page != no_index &&
           (known.page != t.slot_page[terrain_slot] || known.loads != t.slot_loads[terrain_slot]);
}

// Lets go of what the slot held, if it holds something else by now. False: the cut had to begin again.
bool leave_if_changed(CutState& s, std::uint32_t terrain_slot) {
    if (!has_changed(s, terrain_slot)) return true;
    const std::uint32_t first = s.pages.page_groups[s.pages.loaded[terrain_slot].page], slot = first / max_page_groups;
    // The host did not call cut_release_page, or did not wait for it: the vertices must be deactivated all the same.
    for (std::uint32_t v = first == no_index ? no_index : first_active(s, slot); v != no_index;
         v = first_active(s, slot)) {
        if (deactivate(s, lowest_below(s, v)) == Outcome::done) continue;
        // No segment for triangles that were hidden: then from the coarsest mesh, where all have room.
        rescan_pages(s);
        reset(s);
        begin_at_roots(s);
        return false;
    }
    if (first != no_index) detach(s, slot);
    s.pages.loaded[terrain_slot] = {no_index, 0, false, {}};
    return true;
}

void enter_if_loaded(CutState& s, std::uint32_t terrain_slot) {
    const TerrainData& t = *s.pages.grid.terrain;
    const std::uint32_t page = t.slot_page[terrain_slot];
    if (page == no_index || s.pages.loaded[terrain_slot].page != no_index) return;
    s.pages.loaded[terrain_slot] = {page, t.slot_loads[terrain_slot], false, extent_of(s, page, terrain_slot)};
    attach_if_wanted(s, terrain_slot);
}

// Pages that had no state to be had.
void attach_waiting(CutState& s) {
    s.pages.some_wait = false;
    for (std::uint32_t slot = 0; slot < s.pages.grid.terrain->slot_count && !s.pages.some_wait; ++slot)
        if (const std::uint32_t page = s.pages.loaded[slot].page;
            page != no_index && s.pages.page_groups[page] == no_index)
            attach_if_wanted(s, slot);
}

} // namespace

std::uint32_t free_pages(const CutState& s) {
    return s.pages.free_count + s.pages.count - s.pages.fresh;
}

bool attach_page(CutState& s, std::uint32_t page) {
    if (s.pages.page_groups[page] != no_index) return true;
    const std::uint32_t terrain_slot = s.pages.grid.terrain->page_table[page].slot;
    if (terrain_slot == no_index || s.pages.loaded[terrain_slot].page != page) return true;
    const std::uint32_t slot = attach(s, terrain_slot);
    if (slot == no_index) return false;
    if (s.pages.some_wait) find_parents(s, slot); // or nobody could have attached it before
    return true;
}

void note_idle(CutState& s, std::uint32_t slot) {
    PageState& page = s.pages.state[slot];
    if (page.idle || page.parents != 0 || page.shape == 0) return;
    page.idle = true;
    s.pages.idle[(s.pages.first_idle + s.pages.idle_count++) % s.pages.count] = slot;
}

bool reclaim_page(CutState& s) {
    for (std::uint32_t left = s.pages.idle_count; left != 0; --left) {
        const std::uint32_t slot = s.pages.idle[s.pages.first_idle];
        s.pages.first_idle = (s.pages.first_idle + 1) % s.pages.count;
        --s.pages.idle_count;
        PageState& page = s.pages.state[slot];
        page.idle = false;
        if (page.page == no_index || page.parents != 0) continue; // it is not any more
        if (is_due(s.work.schedule, slot)) {                      // and may be in work
            note_idle(s, slot);
            continue;
        }
        detach(s, slot);
        return true;
    }
    return false;
}

void keep_pages_at_hand(CutState& s) {
    constexpr std::uint32_t at_hand = 64, at_once = 32;
    if (!may_lack_pages(s)) return;
    for (std::uint32_t n = 0; n < at_once && free_pages(s) < at_hand + s.pages.tiles_waiting; ++n)
        if (!reclaim_page(s)) return;
}

void rescan_pages(CutState& s) {
    s.pages.seen_changes = s.pages.grid.terrain->changes - change_log - 1; // more than the log remembers
}

bool has_lost_pages(const CutState& s) {
    const TerrainData& t = *s.pages.grid.terrain;
    const std::uint64_t count = t.changes - s.pages.seen_changes;
    const bool all = count > change_log;
    for (std::uint64_t n = 0; n < (all ? t.slot_count : count); ++n)
        if (has_changed(s,
                        all ? static_cast<std::uint32_t>(n) : t.changed_slots[(s.pages.seen_changes + n) % change_log]))
            return true;
    return false;
}

void sync_pages(CutState& s) {
    const TerrainData& t = *s.pages.grid.terrain;
    const std::uint64_t seen = s.pages.seen_changes, count = t.changes - seen;
    s.pages.seen_changes = t.changes;
    const bool all = count > change_log;
    const auto slot_of = [&](std::uint64_t n) {
        return all ? static_cast<std::uint32_t>(n) : t.changed_slots[(seen + n) % change_log];
    };
    const std::uint64_t end = all ? t.slot_count : count;
    for (std::uint64_t n = 0; n < end; ++n)
        if (!leave_if_changed(s, slot_of(n))) return;
    for (std::uint64_t n = 0; n < end; ++n) enter_if_loaded(s, slot_of(n));
    if (s.pages.some_wait && has_state_for(s, false)) attach_waiting(s);
}

namespace {

// The group is evaluated in this frame.
void revisit(CutState& s, std::uint32_t number) {
    // What waits in a queue is evaluated anyway.
    if (s.pages.groups[number].queue == unqueued && s.pages.groups[number].ready() != 0)
        make_due(s.work.schedule, number);
}

} // namespace

void cancel_eviction(CutState& s, std::uint32_t slot) {
    PageState& info = s.pages.state[slot];
    if (info.status != PageStatus::evicting) return;
    info.status = PageStatus::live;
    s.pages.evicting_count = static_cast<std::uint32_t>(
        std::remove(s.pages.evicting, s.pages.evicting + s.pages.evicting_count, slot) - s.pages.evicting);
    for (std::uint32_t n = 0; n < s.pages.grid.shapes[info.shape].count; ++n) revisit(s, slot * max_page_groups + n);
    open_gate(s); // for what its vertices are the parents of
}

namespace {

// All of it at once.
void deactivate_page(CutState& s, std::uint32_t slot) {
    while (s.frame.report.items < s.frame.item_limit) {
        const std::uint32_t v = first_active(s, slot), lowest = v == no_index ? v : lowest_below(s, v);
        if (v == no_index || deactivate(s, lowest) != Outcome::done) return;
        ++s.frame.report.items;
        ++s.frame.report.deactivations;
        revisit(s, lowest / group_lanes); // the page may be kept before all have gone
    }
}

// Whatever may begin to: the vertices without active children, and of the others' descendants those that are.
void morph_out_page(CutState& s, std::uint32_t slot) {
    for (std::uint32_t n = 0; n < s.pages.grid.shapes[s.pages.state[slot].shape].count; ++n) {
        const std::uint32_t number = slot * max_page_groups + n;
        for (std::uint32_t lanes = s.pages.groups[number].active; lanes != 0; lanes &= lanes - 1) {
            if (s.frame.report.items >= s.frame.item_limit) return;
            const std::uint32_t v =
                lowest_below(s, number * group_lanes + static_cast<std::uint32_t>(std::countr_zero(lanes)));
            if (morphs_out(s, s.pages.vertex_slot[v])) continue;
            begin_morphing_out(s, v);
            note_late(s, v / group_lanes / max_page_groups);
            ++s.frame.report.items;
            ++s.frame.report.evaluations; // it was evaluated
        }
    }
}

// Deactivates what has arrived at its edge. An entry whose vertex is gone, or morphs out again, belongs to a page that
// was unloaded without waiting.
void end_morphing_out(CutState& s) {
    while (s.morphing.out_count != 0 && s.frame.report.items < s.frame.item_limit) {
        const std::uint32_t vertex = s.morphing.out[s.morphing.first_out];
        const bool there = (s.pages.groups[vertex / group_lanes].active & bit_of(vertex)) &&
                           morphs_out(s, s.pages.vertex_slot[vertex]);
        if (there && s.morphing.now.morph != Morph::none && is_morphing(s, s.pages.vertex_slot[vertex])) return;
        // Children it can have only when morphing has just been switched off.
        const std::uint32_t lowest = there ? lowest_below(s, vertex) : vertex;
        if (there && deactivate(s, lowest) != Outcome::done) return;
        s.frame.report.items += there;
        s.frame.report.deactivations += there;
        if (there) revisit(s, lowest / group_lanes); // its page may have been kept
        if (lowest != vertex) continue;
        s.morphing.first_out = (s.morphing.first_out + 1) % s.morphing.ring_size;
        --s.morphing.out_count;
        open_gate(s);
    }
}

} // namespace

void evict_pages(CutState& s) {
    end_morphing_out(s);
    for (std::uint32_t i = 0; i < s.pages.evicting_count; ++i)
        if (s.pages.state[s.pages.evicting[i]].active == 0)
            continue;
        else if (s.morphing.now.morph == Morph::none)
            deactivate_page(s, s.pages.evicting[i]);
        else
            morph_out_page(s, s.pages.evicting[i]);
}

} // namespace fjell
