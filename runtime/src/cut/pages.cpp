#include "cut/pages.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "cut/change.h"
#include "cut/error_bound.h"
#include "cut/evaluate.h"
#include "cut/state.h"

namespace fjell {

void bound_tile(const Grid& grid, Mesh& mesh, const PageState& info, bool loaded) {
    TileList& tile = mesh.tiles[info.tile];
    tile.bounded = loaded;
    if (!loaded) return;
    const std::int32_t half = grid.terrain->tree.side() / 2, side = grid.terrain->tree.side();
    const SampleIndex root{info.tile_x * side + half, info.tile_y * side + half}, at = grid.terrain->tree.sample(root);
    const TerrainData::Vertex v = grid.terrain->vertex(root);
    tile.centre_m = {grid.terrain->x_m(at.column), v.height_m, grid.terrain->z_m(at.row)};
    tile.radius_m = v.radius_m;
}

namespace {

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
std::uint32_t coarse_z(const Grid& grid) {
    return static_cast<std::uint32_t>(std::max(grid.terrain->tree.tile_log2 - page_squares_log2, 0));
}

void empty_state(PageState& info) {
    const bool idle = info.idle;
    info = {};
    info.idle = idle;
    info.page = no_index;
}

// Every tile's page 0 is sure of a state.
bool has_state_for(const Pages& pages, bool root) {
    return free_pages(pages) > (root || !may_lack_pages(pages) ? 0 : pages.tiles_waiting);
}
std::uint32_t take_page(Pages& pages, bool root) {
    if (!has_state_for(pages, root)) return no_index;
    return pages.free_count != 0 ? pages.free[--pages.free_count] : pages.fresh++;
}

// With nothing active, and no parent. no_index: there is no state to be had.
std::uint32_t attach(Pages& pages, Work& work, Mesh& mesh, Visibility& visibility, std::uint32_t terrain_slot) {
    const TerrainData& t = *pages.grid.terrain;
    const LoadedPage& loaded = pages.loaded[terrain_slot];
    const std::uint32_t in_tile = loaded.page % pages.grid.pages_per_tile, slot = take_page(pages, in_tile == 0);
    if (slot == no_index) return no_index;
    PageState& info = pages.state[slot];
    FJELL_ASSERT(info.status == PageStatus::empty && pages.page_groups[loaded.page] == no_index);
    empty_state(info);
    info.page = loaded.page;
    info.terrain_slot = terrain_slot;
    info.tile = info.page / pages.grid.pages_per_tile;
    const SampleIndex tile = t.tile_xy(info.tile);
    info.tile_x = tile.column;
    info.tile_y = tile.row;
    info.base = t.page_table[info.page].base;
    info.status = loaded.evicting ? PageStatus::evicting : PageStatus::live;
    if (loaded.evicting) pages.evicting[pages.evicting_count++] = slot;
    if (in_tile != 0) {
        const SampleIndex position = t.pages.page_position(in_tile);
        info.shape = 1;
        info.z = static_cast<std::uint8_t>(t.pages.page_step_log2(in_tile));
        info.i0 = position.column << page_squares_log2;
        info.j0 = position.row << page_squares_log2;
    }
    info.x0 = info.tile_x * pages.grid.terrain->tree.side() + (info.i0 << (info.z + 1));
    info.y0 = info.tile_y * pages.grid.terrain->tree.side() + (info.j0 << (info.z + 1));
    begin_page(work.schedule, slot,
               in_tile == 0 ? coarse_z(pages.grid) : info.z); // ticks are of the finest step in a page
    pages.page_groups[info.page] = slot * max_page_groups;
    watch_page(pages, visibility, slot);
    if (in_tile == 0) {
        --pages.tiles_waiting;
        bound_tile(pages.grid, mesh, info, true);
    }
    mark_absent_parents(pages, slot);
    return slot;
}

void end_eviction(Pages& pages, std::uint32_t slot) {
    std::uint32_t* const end = pages.evicting + pages.evicting_count--;
    (void)std::remove(pages.evicting, end, slot);
}

void detach(Pages& pages, Work& work, Mesh& mesh, std::uint32_t slot) {
    PageState& info = pages.state[slot];
    FJELL_ASSERT(info.status != PageStatus::empty && info.active == 0);
    for (std::uint32_t n = 0; n < pages.grid.shapes[info.shape].count; ++n) {
        const std::uint32_t number = slot * max_page_groups + n;
        unlink(work.queues, number);
        pages.groups[number] = {};
    }
    clear_page_schedule(work.schedule, slot);
    pages.busy -= info.parents != 0;
    pages.page_groups[info.page] = no_index;
    if (info.shape == 0) {
        ++pages.tiles_waiting;
        bound_tile(pages.grid, mesh, info, false);
    }
    if (info.status == PageStatus::evicting) end_eviction(pages, slot);
    empty_state(info);
    pages.free[pages.free_count++] = slot;
}

bool nothing_active(const Mesh& mesh) {
    return mesh.capacity - free_vertices(mesh) == mesh.corner_count;
}

// Of a page that has just been attached: which of its vertices have active parents in other pages?
void find_parents(Pages& pages, Work& work, const Mesh& mesh, std::uint32_t slot) {
    const PageState& info = pages.state[slot];
    const bool none = nothing_active(mesh);
    for (std::uint32_t n = 0; n < pages.grid.shapes[info.shape].count; ++n) {
        const std::uint32_t number = slot * max_page_groups + n;
        GroupState& b = pages.groups[number];
        const std::uint32_t lanes = none ? 0 : outward_lanes(info, pages.grid.shapes[info.shape].groups[n]);
        if (lanes != 0) {
            const ParentMasks parents = parents_of(pages, number, lanes);
            for (std::size_t i = 0; i < 2; ++i) { // those that do not exist are not counted
                const auto more = static_cast<std::uint16_t>(parents.parent[i] & ~b.parent[i]);
                count_parents(pages, slot, static_cast<std::uint32_t>(std::popcount(more)));
                b.parent[i] |= more;
            }
        }
        if (b.ready() != 0) make_due(work.schedule, number);
    }
}

// A page that has come: some of its vertices may have active parents.
void attach_if_wanted(Pages& pages, Work& work, Mesh& mesh, Visibility& visibility, std::uint32_t terrain_slot) {
    if (pages.loaded[terrain_slot].page % pages.grid.pages_per_tile != 0 && nothing_active(mesh)) return;
    const std::uint32_t slot = attach(pages, work, mesh, visibility, terrain_slot);
    if (slot == no_index) {
        pages.some_wait = true;
        return;
    }
    find_parents(pages, work, mesh, slot);
    note_idle(pages, slot);
}

// One vertex of the subtree below an active vertex that has no active children itself.
std::uint32_t lowest_below(const Pages& pages, std::uint32_t vertex) {
    for (;;) {
        const GroupState& b = pages.groups[vertex / group_lanes];
        int d = 0;
        while (d < 4 && !(b.child[d] >> vertex % group_lanes & 1)) ++d;
        if (d == 4) return vertex;
        vertex = find_vertex(pages, child_site(site_of(pages, vertex), d));
    }
}

// The first vertex that keeps a page from leaving, or no_index: any active one that the page holds, its neighbours'
// vertices on its borders included. Those have both parents active, one of them here: it is enough to look here.
std::uint32_t first_active(const Pages& pages, std::uint32_t slot) {
    if (pages.state[slot].active == 0) return no_index;
    for (std::uint32_t n = 0; n < pages.grid.shapes[pages.state[slot].shape].count; ++n) {
        const std::uint32_t number = slot * max_page_groups + n;
        if (pages.groups[number].active != 0)
            return number * group_lanes + static_cast<std::uint32_t>(std::countr_zero(pages.groups[number].active));
    }
    return no_index;
}

} // namespace

ParentMasks absent_parents(const Grid& grid, const Site& first, const GroupShape& shape) {
    const auto lanes = static_cast<std::uint16_t>((1u << shape.lanes) - 1);
    ParentMasks absent{};
    switch (shape.kind) {
    case VertexKind::centre:
        if (first.z == grid.terrain->tree.tile_log2 - 1) absent = {{1, 1}};
        break;
    case VertexKind::side_x:
        if (!has_square(grid, first.z, first.i, first.j - 1)) absent.parent[0] = lanes;
        if (!has_square(grid, first.z, first.i, first.j)) absent.parent[1] = lanes;
        break;
    case VertexKind::side_y:
        if (!has_square(grid, first.z, first.i - 1, first.j)) absent.parent[0] = 1;
        if (shape.along_y) absent.parent[1] = lanes; // only a rim owns such a group
        break;
    }
    return absent;
}

void mark_absent_parents(Pages& pages, std::uint32_t slot) {
    const PageState& info = pages.state[slot];
    const std::int32_t n = info.shape == 0 ? 1 << pages.grid.steps[info.z].log2 : page_squares;
    const std::int32_t i0 = (info.tile_x << pages.grid.steps[info.z].log2) + info.i0,
                       j0 = (info.tile_y << pages.grid.steps[info.z].log2) + info.j0;
    const bool west = has_square(pages.grid, info.z, i0 - 1, j0), north = has_square(pages.grid, info.z, i0, j0 - 1),
               east = has_square(pages.grid, info.z, i0 + n, j0), south = has_square(pages.grid, info.z, i0, j0 + n);
    const std::uint32_t first = slot * max_page_groups;
    if (west && north && east && south) {
        if (info.shape == 0)
            pages.groups[first].parent[0] |= 1, pages.groups[first].parent[1] |= 1; // a tile's root has none
        return;
    }
    for (std::uint32_t k = 0; k < pages.grid.shapes[info.shape].count; ++k) {
        const GroupShape& shape = pages.grid.shapes[info.shape].groups[k];
        const auto lanes = static_cast<std::uint16_t>((1u << shape.lanes) - 1);
        const int z = info.z + shape.z;
        GroupState& group = pages.groups[first + k];
        switch (shape.kind) { // of a border that another page owns nothing is said
        case VertexKind::centre:
            if (z + 1 == pages.grid.terrain->tree.tile_log2) group.parent[0] |= 1, group.parent[1] |= 1;
            break;
        case VertexKind::side_x:
            if (!north && shape.j0 == 0) group.parent[0] |= lanes;
            if (!south && shape.j0 == 1u << pages.grid.steps[z].page_log2) group.parent[1] |= lanes;
            break;
        case VertexKind::side_y:
            if (!east && shape.along_y) group.parent[1] |= lanes;
            if (!west && !shape.along_y && shape.i0 == 0) group.parent[0] |= 1;
            break;
        }
    }
}

void forget_active(Pages& pages, std::uint32_t slot) {
    PageState& info = pages.state[slot];
    info.active = 0;
    pages.busy -= info.parents != 0;
    info.parents = 0;
}

void zero_groups(Pages& pages, std::uint32_t slot) {
    static_assert(unqueued == 0);
    std::memset(static_cast<void*>(pages.groups + std::size_t{slot} * max_page_groups), 0,
                pages.grid.shapes[pages.state[slot].shape].count * sizeof(GroupState));
    pages.state[slot].used = false;
}

void clear_page(Pages& pages, std::uint32_t slot) {
    forget_active(pages, slot);
    zero_groups(pages, slot);
    mark_absent_parents(pages, slot);
}

ParentMasks parents_of(const Pages& pages, std::uint32_t group, std::uint32_t lanes) {
    ParentMasks masks{};
    for (; lanes != 0; lanes &= lanes - 1) {
        const auto lane = static_cast<std::uint32_t>(std::countr_zero(lanes));
        const std::uint32_t vertex = group * group_lanes + lane;
        const Site site = site_of(pages, vertex);
        // A border has a lane in each page that holds it; only the owner's counts.
        if (!exists(pages.grid, site) || find_vertex(pages, site) != vertex) continue;
        const bool root = site.kind == VertexKind::centre && site.z == pages.grid.terrain->tree.tile_log2 - 1;
        for (int n = 0; n < 2; ++n) {
            const Site parent = parent_site(site, n);
            bool active = root || !exists(pages.grid, parent);
            if (!active) {
                const std::uint32_t found = find_vertex(pages, parent);
                active = found != no_index && is_active(pages, found);
            }
            masks.parent[n] |= static_cast<std::uint16_t>(static_cast<std::uint32_t>(active) << lane);
        }
    }
    return masks;
}

namespace {

// Does the terrain's slot hold another page than the cut has there, or none?
bool has_changed(const Pages& pages, std::uint32_t terrain_slot) {
    const TerrainData& t = *pages.grid.terrain;
    const LoadedPage& known = pages.loaded[terrain_slot];
    return known.page != no_index &&
           (known.page != t.slot_page[terrain_slot] || known.loads != t.slot_loads[terrain_slot]);
}

// Lets go of what the slot held, if it holds something else by now. False: the cut had to begin again.
bool leave_if_changed(CutState& s, std::uint32_t terrain_slot) {
    if (!has_changed(s.pages, terrain_slot)) return true;
    const std::uint32_t first = s.pages.page_groups[s.pages.loaded[terrain_slot].page], slot = first / max_page_groups;
    // The host did not call cut_release_page, or did not wait for it: the vertices must be deactivated all the same.
    for (std::uint32_t v = first == no_index ? no_index : first_active(s.pages, slot); v != no_index;
         v = first_active(s.pages, slot)) {
        if (deactivate(s.pages, s.work, s.mesh, s.views, lowest_below(s.pages, v)) == Outcome::done) continue;
        // No segment for triangles that were hidden: then from the coarsest mesh, where all have room.
        rescan_pages(s.pages);
        reset(s);
        begin_at_roots(s.pages, s.work, s.mesh);
        return false;
    }
    if (first != no_index) detach(s.pages, s.work, s.mesh, slot);
    s.pages.loaded[terrain_slot] = {no_index, 0, false, {}};
    return true;
}

void enter_if_loaded(Pages& pages, Work& work, Mesh& mesh, Visibility& visibility, std::uint32_t terrain_slot) {
    const TerrainData& t = *pages.grid.terrain;
    const std::uint32_t page = t.slot_page[terrain_slot];
    if (page == no_index || pages.loaded[terrain_slot].page != no_index) return;
    pages.loaded[terrain_slot] = {page, t.slot_loads[terrain_slot], false, extent_of(pages.grid, page, terrain_slot)};
    attach_if_wanted(pages, work, mesh, visibility, terrain_slot);
}

// Pages that had no state to be had.
void attach_waiting(Pages& pages, Work& work, Mesh& mesh, Visibility& visibility) {
    pages.some_wait = false;
    for (std::uint32_t slot = 0; slot < pages.grid.terrain->slot_count && !pages.some_wait; ++slot)
        if (const std::uint32_t page = pages.loaded[slot].page; page != no_index && pages.page_groups[page] == no_index)
            attach_if_wanted(pages, work, mesh, visibility, slot);
}

} // namespace

std::uint32_t free_pages(const Pages& pages) {
    return pages.free_count + pages.count - pages.fresh;
}

bool attach_page(Pages& pages, Work& work, Mesh& mesh, Visibility& visibility, std::uint32_t page) {
    if (pages.page_groups[page] != no_index) return true;
    const std::uint32_t terrain_slot = pages.grid.terrain->page_table[page].slot;
    if (terrain_slot == no_index || pages.loaded[terrain_slot].page != page) return true;
    const std::uint32_t slot = attach(pages, work, mesh, visibility, terrain_slot);
    if (slot == no_index) return false;
    if (pages.some_wait) find_parents(pages, work, mesh, slot); // or nobody could have attached it before
    return true;
}

void note_idle(Pages& pages, std::uint32_t slot) {
    PageState& page = pages.state[slot];
    if (page.idle || page.parents != 0 || page.shape == 0) return;
    page.idle = true;
    pages.idle[(pages.first_idle + pages.idle_count++) % pages.count] = slot;
}

bool reclaim_page(Pages& pages, Work& work, Mesh& mesh) {
    for (std::uint32_t left = pages.idle_count; left != 0; --left) {
        const std::uint32_t slot = pages.idle[pages.first_idle];
        pages.first_idle = (pages.first_idle + 1) % pages.count;
        --pages.idle_count;
        PageState& page = pages.state[slot];
        page.idle = false;
        if (page.page == no_index || page.parents != 0) continue; // it is not any more
        if (is_due(work.schedule, slot)) {                        // and may be in work
            note_idle(pages, slot);
            continue;
        }
        detach(pages, work, mesh, slot);
        return true;
    }
    return false;
}

void keep_pages_at_hand(Pages& pages, Work& work, Mesh& mesh) {
    constexpr std::uint32_t at_hand = 64, at_once = 32;
    if (!may_lack_pages(pages)) return;
    for (std::uint32_t n = 0; n < at_once && free_pages(pages) < at_hand + pages.tiles_waiting; ++n)
        if (!reclaim_page(pages, work, mesh)) return;
}

void rescan_pages(Pages& pages) {
    pages.seen_changes = pages.grid.terrain->changes - change_log - 1; // more than the log remembers
}

bool has_lost_pages(const Pages& pages) {
    const TerrainData& t = *pages.grid.terrain;
    const std::uint64_t count = t.changes - pages.seen_changes;
    const bool all = count > change_log;
    for (std::uint64_t n = 0; n < (all ? t.slot_count : count); ++n)
        if (has_changed(pages,
                        all ? static_cast<std::uint32_t>(n) : t.changed_slots[(pages.seen_changes + n) % change_log]))
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
    for (std::uint64_t n = 0; n < end; ++n) enter_if_loaded(s.pages, s.work, s.mesh, s.visibility, slot_of(n));
    if (s.pages.some_wait && has_state_for(s.pages, false)) attach_waiting(s.pages, s.work, s.mesh, s.visibility);
}

namespace {

// The group is evaluated in this frame.
void revisit(const Pages& pages, Work& work, std::uint32_t number) {
    // What waits in a queue is evaluated anyway.
    if (pages.groups[number].queue == unqueued && pages.groups[number].ready() != 0) make_due(work.schedule, number);
}

} // namespace

void cancel_eviction(Pages& pages, Work& work, std::uint32_t slot) {
    PageState& info = pages.state[slot];
    if (info.status != PageStatus::evicting) return;
    info.status = PageStatus::live;
    end_eviction(pages, slot);
    for (std::uint32_t n = 0; n < pages.grid.shapes[info.shape].count; ++n)
        revisit(pages, work, slot * max_page_groups + n);
    open_gate(work); // for what its vertices are the parents of
}

namespace {

// All of it at once.
void deactivate_page(CutState& s, std::uint32_t slot) {
    while (s.frame.report.work < s.frame.item_limit) {
        const std::uint32_t v = first_active(s.pages, slot), lowest = v == no_index ? v : lowest_below(s.pages, v);
        if (v == no_index || deactivate(s.pages, s.work, s.mesh, s.views, lowest) != Outcome::done) return;
        ++s.frame.report.work;
        ++s.frame.report.deactivations;
        revisit(s.pages, s.work, lowest / group_lanes); // the page may be kept before all have gone
    }
}

// Whatever may begin to: the vertices without active children, and of the others' descendants those that are.
void morph_out_page(CutState& s, std::uint32_t slot) {
    Pages& pages = s.pages;
    Frame& frame = s.frame;
    for (std::uint32_t n = 0; n < pages.grid.shapes[pages.state[slot].shape].count; ++n) {
        const std::uint32_t number = slot * max_page_groups + n;
        for (std::uint32_t lanes = pages.groups[number].active; lanes != 0; lanes &= lanes - 1) {
            if (frame.report.work >= frame.item_limit) return;
            const std::uint32_t v =
                lowest_below(pages, number * group_lanes + static_cast<std::uint32_t>(std::countr_zero(lanes)));
            if (morphs_out(s.mesh, pages.vertex_slot[v])) continue;
            begin_morphing_out(pages, s.mesh, s.morphing, v);
            note_late(s, evaluate_vertex(pages, s.views, v, site_of(pages, v), true));
            ++frame.report.work;
            ++frame.report.evaluations; // it was evaluated
        }
    }
}

// Deactivates what has arrived at its edge. An entry whose vertex is gone, or morphs out again, belongs to a page that
// was unloaded without waiting.
void end_morphing_out(CutState& s) {
    while (s.morphing.out_count != 0 && s.frame.report.work < s.frame.item_limit) {
        const std::uint32_t vertex = s.morphing.out[s.morphing.first_out];
        const bool there = is_active(s.pages, vertex) && morphs_out(s.mesh, s.pages.vertex_slot[vertex]);
        if (there && s.morphing.now.morph != Morph::none &&
            is_morphing(s.mesh, s.morphing, s.pages.vertex_slot[vertex]))
            return;
        // Children it can have only when morphing has just been switched off.
        const std::uint32_t lowest = there ? lowest_below(s.pages, vertex) : vertex;
        if (there && deactivate(s.pages, s.work, s.mesh, s.views, lowest) != Outcome::done) return;
        s.frame.report.work += there;
        s.frame.report.deactivations += there;
        if (there) revisit(s.pages, s.work, lowest / group_lanes); // its page may have been kept
        if (lowest != vertex) continue;
        s.morphing.first_out = (s.morphing.first_out + 1) % s.morphing.ring_size;
        --s.morphing.out_count;
        open_gate(s.work);
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
