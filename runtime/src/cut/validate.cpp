// Is a live cut what cut/state.h promises? Groups and vertices here, the mesh and what is written in validate_mesh.cpp,
// queues and the schedule in validate_work.cpp.
#include "validate.h"

#include <bit>
#include <cmath>

#include "cut/bulk.h"
#include "cut/evaluate.h"
#include "cut/find.h"
#include "cut/morph.h"
#include "cut/pages.h"
#include "cut/refine.h"
#include "cut/sight.h"
#include "cut/validate_parts.h"

namespace fjell {

namespace {

Violation at(const char* what, const CutState& s, std::uint32_t vertex) {
    return {what, site_coord(site_of(s, vertex))};
}

bool is_active(const CutState& s, std::uint32_t vertex) {
    return (s.groups[vertex / group_lanes].active & bit_of(vertex)) != 0;
}

bool is_loaded(const CutState& s, std::uint32_t page) {
    const std::uint32_t slot = s.terrain->page_table[page].slot;
    return slot != no_index && s.loaded[slot].page == page;
}

// Of a vertex that is active: its slot is in use, and is its own.
Violation check_slot(const CutState& s, std::uint32_t vertex, const Site& site) {
    const std::uint32_t slot = s.vertex_slot[vertex];
    if (slot < corner_slots(s) || slot >= s.fresh_vertex) return at("no vertex slot for", s, vertex);
    const Coord sample = s.terrain->tree.sample(site_coord(site));
    if (s.vertices[slot].column != sample.x || s.vertices[slot].row != sample.y)
        return at("a vertex slot is another vertex':", s, vertex);
    return {};
}

Violation check_vertex(const CutState& s, std::uint32_t vertex) {
    const Site site = site_of(s, vertex);
    const GroupState& b = s.groups[vertex / group_lanes];
    const auto bit = [&](std::uint16_t mask) { return (mask & bit_of(vertex)) != 0; };
    if (!exists(s, site) || find_vertex(s, site) != vertex) {
        if (bit(b.active)) return at("a vertex is active where it is not owned:", s, vertex);
        if (bit(b.ready())) return at("a vertex is ready where it is not owned:", s, vertex);
        return {};
    }
    if (bit(b.active) && !bit(b.ready())) return at("an active vertex' parent is not active:", s, vertex);
    if (bit(b.active))
        if (const Violation wrong = check_slot(s, vertex, site)) return wrong;
    const bool leaf = site.kind != VertexKind::centre && site.z == 0;
    for (std::uint32_t d = 0; d < 4; ++d) {
        const Site child = child_site(site, static_cast<int>(d));
        const bool possible = !leaf && exists(s, child);
        const std::uint32_t found = possible ? find_vertex(s, child) : no_index;
        const bool there = found != no_index && is_active(s, found);
        if (bit(b.active) && possible && found == no_index && !s.pages_wait && is_loaded(s, place_of(s, child).page))
            return at("an active vertex' child has no state:", s, vertex);
        if (bit(b.child[d]) != there) return at("a child mask is wrong at", s, vertex);
        if (!bit(b.active) || leaf) continue; // at the rim no triangle lies beyond; a leaf has no children to say so
        const bool drawn = s.triangle_of[s.vertex_slot[vertex] * 4 + d] != no_index;
        if (drawn != (possible && !there)) return at("a triangle is missing, or is one too many, at", s, vertex);
    }
    return {};
}

// The lanes of a group that could change: by the tree they may, and nobody else sees to it.
struct Changeable {
    std::uint32_t inactive, childless;
};
Changeable changeable(const CutState& s, std::uint32_t group) {
    const GroupState& b = s.groups[group];
    const bool evicting = s.page_state[group / max_page_groups].status == PageStatus::evicting;
    Changeable lanes{evicting ? 0u : static_cast<std::uint32_t>(b.ready() & ~b.active),
                     static_cast<std::uint32_t>(b.active & ~b.parental())};
    for (std::uint32_t lane = 0; lane < group_lanes; ++lane) // those that morph out go by themselves
        if ((b.active >> lane & 1) && morphs_out(s, s.vertex_slot[group * group_lanes + lane]))
            lanes.childless &= ~(1u << lane);
    return lanes;
}

// Does a vertex agree with the decision, and will it be looked at before it could cease to? left_m: how far an eye may
// go until its group is due.
Violation check_decision(const CutState& s, std::uint32_t vertex, bool on, double left_m) {
    const Coord c = site_coord(site_of(s, vertex)), sample = s.terrain->tree.sample(c);
    const TerrainData::Vertex v = s.terrain->vertex(c);
    const float x = s.terrain->x_m(sample.x), z = s.terrain->z_m(sample.y);
    const Criterion& decision = criterion_of(s, vertex / group_lanes);
    double margin = -1e300;
    bool in = false;
    for (std::uint32_t i = 0; i < s.view_count; ++i) {
        const Reach& r = on ? decision.keep[i] : decision.reach[i];
        in = in || wanted(r, x, v.height_m, z, v.error_m, v.radius_m);
        const Vec3 way{x - r.eye_x, v.height_m - r.eye_y, z - r.eye_z};
        const double reach = static_cast<double>(v.radius_m) + static_cast<double>(v.error_m) * r.q;
        margin = std::max(margin, reach * static_cast<double>(reach_grow) + static_cast<double>(r.pad) - length(way));
    }
    // Without its sphere, for which seen() may err. Not all pages are looked at while the bulk pass is under way, or time
    // is short.
    Evaluation place{};
    place.x = x;
    place.y = v.height_m;
    place.z = z;
    if (s.bulk.phase == BulkPhase::idle && !is_overlooking(s) && is_offscreen(s, vertex / group_lanes) && seen(s, place))
        return at("a vertex is called off-screen, and a view sees it:", s, vertex);
    if (in != on) return at("a vertex disagrees with the decision, and nobody knows:", s, vertex);
    if (left_m > std::abs(margin) * (1 + 1e-4) + s.schedule.tick_m * 0.01)
        return at("a vertex could change before it is looked at:", s, vertex);
    if (grade_of(v.error_code) > s.schedule.awake[s.schedule.pages[vertex / group_lanes / max_page_groups].awake].grade)
        return at("a page's grade is too low:", s, vertex);
    return {};
}

bool some_page_leaves(const CutState& s) {
    for (std::uint32_t i = 0; i < s.evicting_count; ++i)
        if (s.page_state[s.evicting[i]].active != 0) return true;
    return false;
}

Violation check_group(const CutState& s, std::uint32_t number) {
    const GroupState& b = s.groups[number];
    const ParentMasks parents = parents_of(s, number, (1u << shape_of(s, number).lanes) - 1);
    if (b.parent[0] != parents.parent[0] || b.parent[1] != parents.parent[1])
        return at("a parent mask is wrong in the group of", s, number * group_lanes);
    const bool evicting = s.page_state[number / max_page_groups].status == PageStatus::evicting;
    const Changeable lanes = changeable(s, number);
    const std::uint16_t ticks = ticks_of(s.schedule, number);
    if ((lanes.inactive | lanes.childless) != 0 && b.queue == unqueued && ticks == unscheduled && !evicting)
        return at("nobody will look at the group of", s, number * group_lanes);
    // What is due or in a queue is looked at in any case, and what is evicted goes without.
    const PageSchedule& page = s.schedule.pages[number / max_page_groups];
    if (page.awake == no_index) return {}; // validate_schedule() says so
    if (b.queue != unqueued || ticks == unscheduled || evicting || s.seen_changes != s.terrain->changes) return {};
    const double left_m =
        ticks <= soon ? 0 : page.charged_m + (ticks - soon) * tick_m(s.schedule, page) - odometer_m(s.schedule, page);
    if (is_due(s.schedule, number / max_page_groups) && left_m <= 0) return {};
    // Until a page is evicted, what stood on it goes step by step, whatever the decision says.
    const bool leaves = lanes.inactive != 0 && some_page_leaves(s);
    for (std::uint32_t left = lanes.inactive | lanes.childless; left != 0; left &= left - 1) {
        const auto lane = static_cast<std::uint32_t>(std::countr_zero(left));
        const bool on = (lanes.childless >> lane & 1) != 0;
        if (!on && leaves) continue;
        if (const Violation wrong = check_decision(s, number * group_lanes + lane, on, left_m)) return wrong;
    }
    return {};
}

// A state of no page: nothing is left in it.
Violation check_empty(const CutState& s, std::uint32_t slot) {
    const PageState& info = s.page_state[slot];
    if (info.status != PageStatus::empty || info.parents != 0) return {"a state of no page is not empty"};
    for (std::uint32_t n = 0; n < max_page_groups; ++n) {
        const GroupState& b = s.groups[slot * max_page_groups + n];
        if (b.queue != unqueued) return {"a group of no page is in a queue"};
        if (ticks_of(s.schedule, slot * max_page_groups + n) != unscheduled) return {"a group of no page is scheduled"};
        if ((b.active | b.parent[0] | b.parent[1] | b.parental()) != 0) return {"a group of no page is in use"};
    }
    return {};
}

Violation check_page(const CutState& s, std::uint32_t slot, Tally& vertex_slots) {
    const PageState& info = s.page_state[slot];
    if (info.page >= s.terrain->page_count()) return {"a state is of a page that there is not"};
    if (s.page_groups[info.page] != slot * max_page_groups) return {"a page's state is not where the page says"};
    if (info.status == PageStatus::empty) return {"a page's state is empty"};
    if (info.tile != info.page / s.pages_per_tile) return {"a page is another tile's"};
    if (info.terrain_slot >= s.terrain->slot_count || s.loaded[info.terrain_slot].page != info.page)
        return {"a page's records are another page's"};
    if ((info.status == PageStatus::evicting) != s.loaded[info.terrain_slot].evicting)
        return {"a page is evicted, and its state does not say so"};
    std::uint32_t active = 0, parents = 0;
    for (std::uint32_t n = 0; n < s.shapes[info.shape].count; ++n) {
        const std::uint32_t number = slot * max_page_groups + n;
        for (std::uint32_t lane = 0; lane < s.shapes[info.shape].groups[n].lanes; ++lane) {
            const std::uint32_t vertex = number * group_lanes + lane;
            if (const Violation wrong = check_vertex(s, vertex)) return wrong;
            if (!is_active(s, vertex)) continue;
            vertex_slots.add(s.vertex_slot[vertex]);
            ++active;
        }
        if (const Violation wrong = check_group(s, number)) return wrong;
        const GroupShape& shape = s.shapes[info.shape].groups[n];
        const ParentMasks absent = absent_parents(s, site_of(s, number * group_lanes), shape);
        for (std::size_t i = 0; i < 2; ++i)
            parents += static_cast<std::uint32_t>(
                std::popcount(static_cast<std::uint16_t>(s.groups[number].parent[i] & ~absent.parent[i])));
    }
    if (active != info.active) return {"a page counts its active vertices wrongly"};
    if (parents != info.parents) return {"a page counts its vertices' parents wrongly"};
    const bool in_bulk = s.bulk.phase != BulkPhase::idle && found_in(s, slot) != nullptr;
    if (parents == 0 && info.shape != 0 && !info.idle && !in_bulk)
        return {"a page is idle, and its state can never be taken"};
    return {};
}

// Those that say so are listed, once.
Violation check_idle(const CutState& s) {
    Tally listed, say_so;
    for (std::uint32_t i = 0; i < s.idle_count; ++i) listed.add(s.idle_pages[(s.first_idle + i) % s.page_count]);
    for (std::uint32_t slot = 0; slot < s.page_count; ++slot)
        if (s.page_state[slot].idle) say_so.add(slot);
    return listed == say_so ? Violation{} : Violation{"an idle page is listed twice, or lost"};
}

Violation check_pages(const CutState& s, Tally& vertex_slots) {
    std::uint32_t evicting = 0, busy = 0, taken = 0, roots = 0;
    Tally listed, marked, unused, say_free;
    for (std::uint32_t slot = 0; slot < s.page_count; ++slot) {
        const PageState& info = s.page_state[slot];
        const bool empty = info.page == no_index;
        if (const Violation wrong = empty ? check_empty(s, slot) : check_page(s, slot, vertex_slots)) return wrong;
        busy += info.parents != 0;
        if (empty && slot < s.fresh_page) unused.add(slot);
        if (empty) continue;
        ++taken;
        roots += info.shape == 0;
        if (info.status != PageStatus::evicting) continue;
        marked.add(slot);
        ++evicting;
    }
    for (std::uint32_t i = 0; i < s.free_page_count; ++i) say_free.add(s.free_pages[i]);
    if (!(unused == say_free) || taken != s.page_count - free_pages(s)) return {"states are lost, or free twice"};
    if (busy != s.busy_pages) return {"busy pages do not add up"};
    if (roots + s.tiles_waiting != s.terrain->tile_count()) return {"tiles whose page 0 has no state do not add up"};
    if (const Violation wrong = check_idle(s)) return wrong;
    for (std::uint32_t page = 0; page < s.terrain->page_count(); ++page) {
        const std::uint32_t first = s.page_groups[page], slot = s.terrain->page_table[page].slot;
        if (first != no_index && (first >= s.group_count || s.page_state[first / max_page_groups].page != page))
            return {"a page's groups are another page's"};
        if (s.seen_changes != s.terrain->changes) continue;
        if ((slot != no_index) != is_loaded(s, page) ||
            (slot != no_index && s.loaded[slot].loads != s.terrain->slot_loads[slot]))
            return {"a page is loaded, and the cut has not entered it"};
    }
    if (evicting != s.evicting_count) return {"pages that are evicted do not add up"};
    for (std::uint32_t i = 0; i < s.evicting_count; ++i) listed.add(s.evicting[i]);
    return listed == marked ? Violation{} : Violation{"a page is evicted that is not listed, or listed twice"};
}

// Slots are in use, given back, or were never taken; each is one of these, once.
Violation check_vertex_slots(const CutState& s, Tally taken) {
    if (s.fresh_vertex < corner_slots(s) || s.fresh_vertex > s.budget.vertices ||
        s.free_vertex_count > s.fresh_vertex - corner_slots(s))
        return {"more vertex slots are free than there are"};
    for (std::uint32_t i = 0; i < s.free_vertex_count; ++i) {
        const std::uint32_t slot = s.free_vertices[i];
        if (slot < corner_slots(s) || slot >= s.fresh_vertex) return {"a vertex slot is free that was never taken"};
        taken.add(slot);
    }
    Tally all;
    all.add_range(corner_slots(s), s.fresh_vertex);
    return taken == all ? Violation{} : Violation{"a vertex slot is used or free twice, or lost"};
}

// What morphs by time is remembered in the order in which it began.
Violation check_morphing(const CutState& s) {
    const std::uint32_t size = s.budget.vertices;
    if (s.first_late >= size || s.late_count > size || s.first_morphing_out >= size || s.morphing_out_count > size)
        return {"a ring of morphing vertices has no such place"};
    float younger_s = morph_clock_s;
    for (std::uint32_t i = 0; i < s.late_count; ++i) {
        const float age_s = morph_age_s(s.clock.now_s(), s.late_s[(s.first_late + i) % size]);
        if (age_s > younger_s) return {"vertices that morph in are not in their order"};
        younger_s = age_s;
    }
    for (std::uint32_t i = 0; i < s.morphing_out_count; ++i)
        if (s.morphing_out[(s.first_morphing_out + i) % size] >= s.group_count * group_lanes)
            return {"a vertex morphs out that there is not"};
    return {};
}

Violation check_report(const CutState& s) {
    if (s.frame == 0) return {};
    const CutReport& r = s.report;
    std::uint32_t active = corner_slots(s), triangles = 0;
    for (std::uint32_t slot = 0; slot < s.page_count; ++slot) active += s.page_state[slot].active;
    for (std::uint32_t tile = 0; tile < s.terrain->tile_count(); ++tile) triangles += s.tiles[tile].total;
    if (active != s.budget.vertices - free_vertices(s)) return {"active vertices and their slots do not add up"};
    if (r.vertices != active || r.vertex_slots.used != active) return {"the report counts vertices wrongly"};
    if (r.triangles != triangles) return {"the report counts triangles wrongly"};
    if (r.blocked != blocked_groups(s)) return {"the report counts blocked groups wrongly"};
    if (r.blocked > r.waiting) return {"more is blocked than waits"};
    if (r.morphing != s.late_count + s.morphing_out_count) return {"the report counts morphing vertices wrongly"};
    return {};
}

} // namespace

Violation validate_cut(const CutState& s) {
    // While the state follows what the bulk pass has built, only the mesh is whole.
    if (s.bulk.phase >= BulkPhase::releasing) return validate_mesh(s);
    Tally vertex_slots;
    if (const Violation wrong = check_pages(s, vertex_slots)) return wrong;
    if (const Violation wrong = check_vertex_slots(s, vertex_slots)) return wrong;
    if (const Violation wrong = validate_queues(s.queues)) return wrong;
    if (const Violation wrong = validate_schedule(s.schedule, s.queues)) return wrong;
    for (std::uint32_t rank = 0; rank < rank_count; ++rank)
        if (s.queues.sizes[work_queues + rank] != 0 && (s.work_ranks >> rank & 1) == 0)
            return {"a queue holds work, and nobody will look at it"};
    if (const Violation wrong = validate_mesh(s)) return wrong;
    if (const Violation wrong = check_morphing(s)) return wrong;
    return check_report(s);
}

} // namespace fjell
