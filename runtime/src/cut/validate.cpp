// Is a live cut what cut/state.h promises?
#include "validate.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "cut/evaluate.h"
#include "cut/refine.h"
#include "cut/state.h"

namespace fjell {

// --- queues and the schedule

namespace {

Violation check_queue(const Queues& q, std::uint32_t queue, Tally& queued) {
    const std::uint32_t head = q.group_count + queue;
    std::uint32_t count = 0, before = head;
    for (std::uint32_t group = q.ends[queue].next; group != head; group = q.nodes[group].link.next) {
        if (group >= q.group_count || ++count > q.sizes[queue]) return {"a queue goes elsewhere"};
        if (q.groups[group].queue != queue) return {"a group is in a queue, and says otherwise"};
        if (q.nodes[group].link.prev != before) return {"a queue's links disagree"};
        queued.add(group);
        before = group;
    }
    if (q.ends[queue].prev != before) return {"a queue's links disagree"};
    return count == q.sizes[queue] ? Violation{} : Violation{"a queue counts its groups wrongly"};
}

Violation check_schedule(const Schedule& s, const Queues& q, std::uint32_t slot) {
    const PageSchedule& page = s.pages[slot];
    const std::uint16_t* const ticks = s.ticks + std::size_t{slot} * page_ticks;
    std::uint32_t queued = 0;
    for (std::uint32_t n = 0; n < max_page_groups; ++n)
        queued += q.groups[slot * max_page_groups + n].queue != unqueued;
    for (std::uint32_t n = 0; n < page_ticks; ++n) {
        if (ticks[n] == unscheduled) continue;
        if (n >= max_page_groups) return {"a group is scheduled that there is not"};
        if (q.groups[slot * max_page_groups + n].queue != unqueued) return {"a group is scheduled, and in a queue"};
    }
    const std::uint16_t least = scalar_ticks.least(ticks);
    if (page.awake == no_index)
        return least == unscheduled && queued == 0 ? Violation{} : Violation{"a page sleeps with groups to watch"};
    if (page.awake >= s.awake_count || s.awake[page.awake].slot != slot) return {"a page is awake elsewhere"};
    const AwakePage& awake = s.awake[page.awake];
    if (awake.level != page.level) return {"a page is watched at another level than its own"};
    if (awake.queued != queued) return {"a page counts wrongly what of it is in queues"};
    if (awake.due) return {};
    const double one_m = tick_m(s, page);
    const double latest_m = std::max(page.charged_m + (least - soon) * one_m, s.odometer_m[awake.grade]);
    if (least != unscheduled && awake.due_m > latest_m + one_m / 1024) return {"a page comes up later than its groups"};
    if (s.odometer_m[awake.grade] > awake.due_m + one_m * 1.001) return {"a page's time has come, and it is not due"};
    return {};
}

Violation check_due(const Schedule& s, Tally& listed) {
    std::uint32_t count = 0;
    for (std::uint32_t level = 0; level < due_level_count; ++level) {
        if ((s.due_levels >> level & 1) == 0) continue;
        std::uint32_t last = no_index;
        for (std::uint32_t slot = s.due[level].first; slot != no_index; slot = s.next_due[slot]) {
            if (slot >= s.slot_count || ++count > s.due_count) return {"due pages go round in a circle"};
            if (!is_due(s, slot) || s.pages[slot].level != level) return {"a page is due, and says otherwise"};
            listed.add(slot);
            last = slot;
        }
        if (last == no_index || s.due[level].last != last) return {"the last due page is cut off"};
    }
    return count == s.due_count ? Violation{} : Violation{"due pages are counted wrongly"};
}

} // namespace

Violation validate_queues(const Queues& q) {
    Tally queued, say_so;
    for (std::uint32_t queue = 0; queue < queue_count; ++queue)
        if (const Violation wrong = check_queue(q, queue, queued)) return wrong;
    for (std::uint32_t group = 0; group < q.group_count; ++group) {
        if (q.groups[group].queue == unqueued) continue;
        if (q.groups[group].queue >= queue_count) return {"a group was taken from its queue and not put back"};
        say_so.add(group);
    }
    return queued == say_so ? Violation{} : Violation{"a group is in two queues, or lost from the one it says"};
}

Violation validate_schedule(const Schedule& s, const Queues& q) {
    Tally listed, say_so;
    std::uint32_t awake = 0;
    for (std::uint32_t slot = 0; slot < s.slot_count; ++slot) {
        if (const Violation wrong = check_schedule(s, q, slot)) return wrong;
        awake += s.pages[slot].awake != no_index;
        if (is_due(s, slot)) say_so.add(slot);
    }
    if (awake != s.awake_count) return {"awake pages do not add up"};
    if (const Violation wrong = check_due(s, listed)) return wrong;
    return listed == say_so ? Violation{} : Violation{"a page is due twice, or lost from the due pages"};
}

// --- the mesh and what is written

namespace {

Violation check_triangle(const CutState& s, std::uint32_t tile, std::uint32_t slot) {
    const std::uint32_t* const t = s.mesh.indices + std::size_t{slot} * 3;
    if (t[0] >= s.mesh.fresh_vertex || t[1] >= s.mesh.fresh_vertex || t[2] >= s.mesh.fresh_vertex)
        return {"a triangle's corner was never taken"};
    const std::uint32_t* const of = s.mesh.triangle_of + std::size_t{t[0]} * 4;
    if (std::count(of, of + 4, slot) != 1) return {"a triangle's right angle does not know it"};
    if (s.mesh.some_hidden && is_hidden(s.mesh, {t[0], t[1], t[2]}) != (tile == hidden_tile(s.mesh)))
        return {"a triangle is hidden wrongly"};
    return {};
}

Violation check_tile(const CutState& s, std::uint32_t tile, Tally& segments) {
    const TileList& list = s.mesh.tiles[tile];
    std::uint32_t count = list.in_last, total = 0, found = 0;
    for (std::uint32_t segment = list.last_segment; segment != no_index; segment = s.mesh.segment_below[segment]) {
        if (segment >= s.mesh.segment_count || ++found > s.mesh.segment_count)
            return {"a tile's segments go elsewhere"};
        if (s.mesh.segment_tile[segment] != tile) return {"a segment does not know its tile"};
        if (count == 0 || count > 1u << s.mesh.segment_log2) return {"an empty segment is kept"};
        segments.add(segment);
        for (std::uint32_t i = 0; i < count; ++i)
            if (const Violation wrong = check_triangle(s, tile, (segment << s.mesh.segment_log2) + i)) return wrong;
        total += count;
        count = 1u << s.mesh.segment_log2;
    }
    if (found != list.segments) return {"a tile counts its segments wrongly"};
    return total == list.total ? Violation{} : Violation{"a tile counts its triangles wrongly"};
}

Violation check_triangles(const CutState& s) {
    Tally segments, all;
    std::uint32_t listed = 0, made = 0;
    for (std::uint32_t tile = 0; tile <= s.mesh.tile_count; ++tile) {
        if (const Violation wrong = check_tile(s, tile, segments)) return wrong;
        listed += s.mesh.tiles[tile].total;
    }
    // What the bulk pass builds beside.
    if (s.bulk.phase == BulkPhase::triangles || s.bulk.phase == BulkPhase::built) {
        for (std::uint32_t tile = 0; tile <= s.mesh.tile_count; ++tile) {
            const BulkTile& list = s.bulk.tiles[tile];
            const std::uint32_t planned = (list.planned + (1u << s.mesh.segment_log2) - 1) >> s.mesh.segment_log2;
            for (std::uint32_t n = list.segments; list.reserved != no_index && n < planned; ++n)
                segments.add(s.mesh.free_segments[list.reserved - 1 - (n - list.segments)]);
            for (std::uint32_t segment = list.last_segment; segment != no_index;
                 segment = s.mesh.segment_below[segment])
                segments.add(segment);
        }
    }
    if (s.mesh.free_segment_count > s.mesh.segment_count) return {"more segments are free than there are"};
    for (std::uint32_t i = 0; i < s.mesh.free_segment_count; ++i) segments.add(s.mesh.free_segments[i]);
    all.add_range(0, s.mesh.segment_count);
    if (!(segments == all)) return {"a segment is used or free twice, or lost"};
    if (s.bulk.phase >= BulkPhase::releasing) return {}; // some of what was drawn before is still named
    const auto count = [&](std::uint32_t vertex_slot) {
        for (std::uint32_t d = 0; d < 4; ++d) made += s.mesh.triangle_of[std::size_t{vertex_slot} * 4 + d] != no_index;
    };
    for (std::uint32_t corner = 0; corner < s.mesh.corner_count; ++corner) count(corner);
    for (std::uint32_t number = 0; number < s.pages.group_count; ++number)
        for (std::uint32_t lanes = s.pages.groups[number].active; lanes != 0; lanes &= lanes - 1)
            count(s.pages.vertex_slot[number * group_lanes + static_cast<std::uint32_t>(std::countr_zero(lanes))]);
    return made == listed ? Violation{} : Violation{"a triangle is made that no tile has"};
}

// The words listed are those that hold any, each once. total: of the bits' words.
Violation check_words(const DirtyBits& written, std::size_t total) {
    Tally listed, held;
    std::uint32_t count = 0;
    for (std::size_t word = 0; word < total; ++word)
        if (written.bits[word] != 0) held.add(word), ++count;
    if (count != written.word_count) return {"words of written slots do not add up"};
    for (std::uint32_t i = 0; i < written.word_count; ++i) listed.add(written.words[i]);
    return listed == held ? Violation{} : Violation{"a word of written slots is listed twice, or not at all"};
}

Violation check_written(const CutState& s) {
    const std::size_t vertex_words = s.mesh.capacity / 64 + 1;
    const std::size_t triangle_words = (std::size_t{s.mesh.segment_count} << s.mesh.segment_log2) / 64 + 1;
    for (const DirtyBits* written : {&s.mesh.dirty_vertices, &s.mesh.untaken_vertices})
        if (const Violation wrong = check_words(*written, vertex_words)) return wrong;
    for (const DirtyBits* written : {&s.mesh.dirty_triangles, &s.mesh.untaken_triangles})
        if (const Violation wrong = check_words(*written, triangle_words)) return wrong;
    for (const DirtyBits* written : {&s.mesh.dirty_vertices, &s.mesh.dirty_triangles}) {
        std::uint32_t slots = 0;
        for (std::uint32_t i = 0; i < written->word_count; ++i)
            slots += static_cast<std::uint32_t>(std::popcount(written->bits[written->words[i]]));
        if (slots != written->slots) return {"written slots are counted wrongly"};
    }
    return {};
}

} // namespace

Violation validate_mesh(const CutState& s) {
    if (const Violation wrong = check_triangles(s)) return wrong;
    return check_written(s);
}

// --- groups and vertices

namespace {

Violation at(const char* what, const CutState& s, std::uint32_t vertex) {
    return {what, site_coord(site_of(s.pages, vertex))};
}

bool is_loaded(const CutState& s, std::uint32_t page) {
    const std::uint32_t slot = s.pages.grid.terrain->page_table[page].slot;
    return slot != no_index && s.pages.loaded[slot].page == page;
}

// Of a vertex that is active: its slot is in use, and is its own.
Violation check_slot(const CutState& s, std::uint32_t vertex, const Site& site) {
    const std::uint32_t slot = s.pages.vertex_slot[vertex];
    if (slot < s.mesh.corner_count || slot >= s.mesh.fresh_vertex) return at("no vertex slot for", s, vertex);
    const SampleIndex sample = s.pages.grid.terrain->tree.sample(site_coord(site));
    if (s.mesh.vertices[slot].column != sample.column || s.mesh.vertices[slot].row != sample.row)
        return at("a vertex slot is another vertex':", s, vertex);
    return {};
}

Violation check_vertex(const CutState& s, std::uint32_t vertex) {
    const Site site = site_of(s.pages, vertex);
    const GroupState& b = s.pages.groups[vertex / group_lanes];
    const auto bit = [&](std::uint16_t mask) { return (mask & bit_of(vertex)) != 0; };
    if (!exists(s.pages.grid, site) || find_vertex(s.pages, site) != vertex) {
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
        const bool possible = !leaf && exists(s.pages.grid, child);
        const std::uint32_t found = possible ? find_vertex(s.pages, child) : no_index;
        const bool there = found != no_index && is_active(s.pages, found);
        if (bit(b.active) && possible && found == no_index && !s.pages.some_wait &&
            is_loaded(s, place_of(s.pages.grid, child).page))
            return at("an active vertex' child has no state:", s, vertex);
        if (bit(b.child[d]) != there) return at("a child mask is wrong at", s, vertex);
        if (!bit(b.active) || leaf) continue; // at the rim no triangle lies beyond; a leaf has no children to say so
        const bool drawn = s.mesh.triangle_of[s.pages.vertex_slot[vertex] * 4 + d] != no_index;
        if (drawn != (possible && !there)) return at("a triangle is missing, or is one too many, at", s, vertex);
    }
    return {};
}

// The lanes of a group that could change: by the tree they may, and nobody else sees to it.
struct Changeable {
    std::uint32_t inactive, childless;
};
Changeable changeable(const CutState& s, std::uint32_t group) {
    const GroupState& b = s.pages.groups[group];
    const bool evicting = s.pages.state[group / max_page_groups].status == PageStatus::evicting;
    Changeable lanes{evicting ? 0u : static_cast<std::uint32_t>(b.ready() & ~b.active),
                     static_cast<std::uint32_t>(b.active & ~b.parental())};
    for (std::uint32_t lane = 0; lane < group_lanes; ++lane) // those that morph out go by themselves
        if ((b.active >> lane & 1) && morphs_out(s.mesh, s.pages.vertex_slot[group * group_lanes + lane]))
            lanes.childless &= ~(1u << lane);
    return lanes;
}

// Does a vertex agree with the decision, and will it be looked at before it could cease to? left_m: how far an eye may
// go until its group is due.
Violation check_decision(const CutState& s, std::uint32_t vertex, bool on, double left_m) {
    const SampleIndex c = site_coord(site_of(s.pages, vertex)), sample = s.pages.grid.terrain->tree.sample(c);
    const TerrainData::Vertex v = s.pages.grid.terrain->vertex(c);
    const float x = s.pages.grid.terrain->x_m(sample.column), z = s.pages.grid.terrain->z_m(sample.row);
    const Criterion& decision = criterion_of(s.pages, s.views, vertex / group_lanes);
    double margin = -1e300;
    bool in = false;
    for (std::uint32_t i = 0; i < s.views.count; ++i) {
        const Reach& r = on ? decision.keep[i] : decision.reach[i];
        in = in || wanted(r, x, v.height_m, z, v.error_m, v.radius_m);
        const Vec3 way{x - r.eye_x, v.height_m - r.eye_y, z - r.eye_z};
        const double reach = static_cast<double>(v.radius_m) + static_cast<double>(v.error_m) * r.q;
        margin = std::max(margin, reach * static_cast<double>(reach_grow) + static_cast<double>(r.pad) - length(way));
    }
    // Without its sphere, for which seen() may err. Not all pages are looked at while the bulk pass is under way, or
    // time is short.
    Evaluation place{};
    place.x = x;
    place.y = v.height_m;
    place.z = z;
    if (s.bulk.phase == BulkPhase::idle && !is_overlooking(s.pages, s.views, s.visibility) &&
        is_offscreen(s.pages, vertex / group_lanes) && seen(s.views, place))
        return at("a vertex is called off-screen, and a view sees it:", s, vertex);
    if (in != on) return at("a vertex disagrees with the decision, and nobody knows:", s, vertex);
    if (left_m > std::abs(margin) * (1 + 1e-4) + s.work.schedule.tick_m * 0.01)
        return at("a vertex could change before it is looked at:", s, vertex);
    if (grade_of(v.error_code) >
        s.work.schedule.awake[s.work.schedule.pages[vertex / group_lanes / max_page_groups].awake].grade)
        return at("a page's grade is too low:", s, vertex);
    return {};
}

bool some_page_leaves(const CutState& s) {
    for (std::uint32_t i = 0; i < s.pages.evicting_count; ++i)
        if (s.pages.state[s.pages.evicting[i]].active != 0) return true;
    return false;
}

Violation check_group(const CutState& s, std::uint32_t number) {
    const GroupState& b = s.pages.groups[number];
    const ParentMasks parents = parents_of(s.pages, number, (1u << shape_of(s.pages, number).lanes) - 1);
    if (b.parent[0] != parents.parent[0] || b.parent[1] != parents.parent[1])
        return at("a parent mask is wrong in the group of", s, number * group_lanes);
    const bool evicting = s.pages.state[number / max_page_groups].status == PageStatus::evicting;
    const Changeable lanes = changeable(s, number);
    const std::uint16_t ticks = ticks_of(s.work.schedule, number);
    if ((lanes.inactive | lanes.childless) != 0 && b.queue == unqueued && ticks == unscheduled && !evicting)
        return at("nobody will look at the group of", s, number * group_lanes);
    // What is due or in a queue is looked at in any case, and what is evicted goes without.
    const PageSchedule& page = s.work.schedule.pages[number / max_page_groups];
    if (page.awake == no_index) return {}; // validate_schedule() says so
    if (b.queue != unqueued || ticks == unscheduled || evicting ||
        s.pages.seen_changes != s.pages.grid.terrain->changes ||
        s.pages.seen_ground != s.pages.grid.terrain->ground_changes)
        return {};
    const double left_m = ticks <= soon ? 0
                                        : page.charged_m + (ticks - soon) * tick_m(s.work.schedule, page) -
                                              odometer_m(s.work.schedule, page);
    if (is_due(s.work.schedule, number / max_page_groups) && left_m <= 0) return {};
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
    const PageState& info = s.pages.state[slot];
    if (info.status != PageStatus::empty || info.parents != 0) return {"a state of no page is not empty"};
    for (std::uint32_t n = 0; n < max_page_groups; ++n) {
        const GroupState& b = s.pages.groups[slot * max_page_groups + n];
        if (b.queue != unqueued) return {"a group of no page is in a queue"};
        if (ticks_of(s.work.schedule, slot * max_page_groups + n) != unscheduled)
            return {"a group of no page is scheduled"};
        if ((b.active | b.parent[0] | b.parent[1] | b.parental()) != 0) return {"a group of no page is in use"};
    }
    return {};
}

Violation check_page(const CutState& s, std::uint32_t slot, Tally& vertex_slots) {
    const PageState& info = s.pages.state[slot];
    if (info.page >= s.pages.grid.terrain->page_count()) return {"a state is of a page that there is not"};
    if (s.pages.page_groups[info.page] != slot * max_page_groups) return {"a page's state is not where the page says"};
    if (info.status == PageStatus::empty) return {"a page's state is empty"};
    if (info.tile != info.page / s.pages.grid.pages_per_tile) return {"a page is another tile's"};
    if (info.terrain_slot >= s.pages.grid.terrain->slot_count || s.pages.loaded[info.terrain_slot].page != info.page)
        return {"a page's records are another page's"};
    if ((info.status == PageStatus::evicting) != s.pages.loaded[info.terrain_slot].evicting)
        return {"a page is evicted, and its state does not say so"};
    std::uint32_t active = 0, parents = 0;
    for (std::uint32_t n = 0; n < s.pages.grid.shapes[info.shape].count; ++n) {
        const std::uint32_t number = slot * max_page_groups + n;
        for (std::uint32_t lane = 0; lane < s.pages.grid.shapes[info.shape].groups[n].lanes; ++lane) {
            const std::uint32_t vertex = number * group_lanes + lane;
            if (const Violation wrong = check_vertex(s, vertex)) return wrong;
            if (!is_active(s.pages, vertex)) continue;
            vertex_slots.add(s.pages.vertex_slot[vertex]);
            ++active;
        }
        if (const Violation wrong = check_group(s, number)) return wrong;
        const GroupShape& shape = s.pages.grid.shapes[info.shape].groups[n];
        const ParentMasks absent = absent_parents(s.pages.grid, site_of(s.pages, number * group_lanes), shape);
        for (std::size_t i = 0; i < 2; ++i)
            parents += static_cast<std::uint32_t>(
                std::popcount(static_cast<std::uint16_t>(s.pages.groups[number].parent[i] & ~absent.parent[i])));
    }
    if (active != info.active) return {"a page counts its active vertices wrongly"};
    if (parents != info.parents) return {"a page counts its vertices' parents wrongly"};
    const bool in_bulk = s.bulk.phase != BulkPhase::idle && found_in(s.bulk, slot) != nullptr;
    if (parents == 0 && info.shape != 0 && !info.idle && !in_bulk)
        return {"a page is idle, and its state can never be taken"};
    return {};
}

// Those that say so are listed, once.
Violation check_idle(const CutState& s) {
    Tally listed, say_so;
    for (std::uint32_t i = 0; i < s.pages.idle_count; ++i)
        listed.add(s.pages.idle[(s.pages.first_idle + i) % s.pages.count]);
    for (std::uint32_t slot = 0; slot < s.pages.count; ++slot)
        if (s.pages.state[slot].idle) say_so.add(slot);
    return listed == say_so ? Violation{} : Violation{"an idle page is listed twice, or lost"};
}

Violation check_pages(const CutState& s, Tally& vertex_slots) {
    std::uint32_t evicting = 0, busy = 0, taken = 0, roots = 0;
    Tally listed, marked, unused, say_free;
    for (std::uint32_t slot = 0; slot < s.pages.count; ++slot) {
        const PageState& info = s.pages.state[slot];
        const bool empty = info.page == no_index;
        if (const Violation wrong = empty ? check_empty(s, slot) : check_page(s, slot, vertex_slots)) return wrong;
        busy += info.parents != 0;
        if (empty && slot < s.pages.fresh) unused.add(slot);
        if (empty) continue;
        ++taken;
        roots += info.shape == 0;
        if (info.status != PageStatus::evicting) continue;
        marked.add(slot);
        ++evicting;
    }
    for (std::uint32_t i = 0; i < s.pages.free_count; ++i) say_free.add(s.pages.free[i]);
    if (!(unused == say_free) || taken != s.pages.count - free_pages(s.pages))
        return {"states are lost, or free twice"};
    if (busy != s.pages.busy) return {"busy pages do not add up"};
    if (roots + s.pages.tiles_waiting != s.mesh.tile_count) return {"tiles whose page 0 has no state do not add up"};
    if (const Violation wrong = check_idle(s)) return wrong;
    for (std::uint32_t page = 0; page < s.pages.grid.terrain->page_count(); ++page) {
        const std::uint32_t first = s.pages.page_groups[page], slot = s.pages.grid.terrain->page_table[page].slot;
        if (first != no_index && (first >= s.pages.group_count || s.pages.state[first / max_page_groups].page != page))
            return {"a page's groups are another page's"};
        if (s.pages.seen_changes != s.pages.grid.terrain->changes ||
            s.pages.seen_ground != s.pages.grid.terrain->ground_changes)
            continue;
        if ((slot != no_index) != is_loaded(s, page) ||
            (slot != no_index && s.pages.loaded[slot].loads != s.pages.grid.terrain->slot_loads[slot]))
            return {"a page is loaded, and the cut has not entered it"};
    }
    if (evicting != s.pages.evicting_count) return {"pages that are evicted do not add up"};
    for (std::uint32_t i = 0; i < s.pages.evicting_count; ++i) listed.add(s.pages.evicting[i]);
    return listed == marked ? Violation{} : Violation{"a page is evicted that is not listed, or listed twice"};
}

// Slots are in use, given back, or were never taken; each is one of these, once.
Violation check_vertex_slots(const CutState& s, Tally taken) {
    if (s.mesh.fresh_vertex < s.mesh.corner_count || s.mesh.fresh_vertex > s.mesh.capacity ||
        s.mesh.free_vertex_count > s.mesh.fresh_vertex - s.mesh.corner_count)
        return {"more vertex slots are free than there are"};
    for (std::uint32_t i = 0; i < s.mesh.free_vertex_count; ++i) {
        const std::uint32_t slot = s.mesh.free_vertices[i];
        if (slot < s.mesh.corner_count || slot >= s.mesh.fresh_vertex)
            return {"a vertex slot is free that was never taken"};
        taken.add(slot);
    }
    Tally all;
    all.add_range(s.mesh.corner_count, s.mesh.fresh_vertex);
    return taken == all ? Violation{} : Violation{"a vertex slot is used or free twice, or lost"};
}

// What morphs by time is remembered in the order in which it began.
Violation check_morphing(const CutState& s) {
    const std::uint32_t size = s.morphing.ring_size;
    if (s.morphing.first_late >= size || s.morphing.late_count > size || s.morphing.first_out >= size ||
        s.morphing.out_count > size)
        return {"a ring of morphing vertices has no such place"};
    float younger_s = morph_clock_s;
    for (std::uint32_t i = 0; i < s.morphing.late_count; ++i) {
        const float age_s =
            morph_age_s(s.morphing.clock.now_s(), s.morphing.late_s[(s.morphing.first_late + i) % size]);
        if (age_s > younger_s) return {"vertices that morph in are not in their order"};
        younger_s = age_s;
    }
    for (std::uint32_t i = 0; i < s.morphing.out_count; ++i)
        if (s.morphing.out[(s.morphing.first_out + i) % size] >= s.pages.group_count * group_lanes)
            return {"a vertex morphs out that there is not"};
    return {};
}

Violation check_report(const CutState& s) {
    if (s.frame.number == 0) return {};
    const CutReport& r = s.frame.report;
    std::uint32_t active = s.mesh.corner_count, triangles = 0;
    for (std::uint32_t slot = 0; slot < s.pages.count; ++slot) active += s.pages.state[slot].active;
    for (std::uint32_t tile = 0; tile < s.mesh.tile_count; ++tile) triangles += s.mesh.tiles[tile].total;
    if (active != s.mesh.capacity - free_vertices(s.mesh)) return {"active vertices and their slots do not add up"};
    if (r.vertices != active || r.vertex_slots.used != active) return {"the report counts vertices wrongly"};
    if (r.triangles != triangles) return {"the report counts triangles wrongly"};
    if (r.blocked != blocked_groups(s.work)) return {"the report counts blocked groups wrongly"};
    if (r.blocked > r.waiting) return {"more is blocked than waits"};
    if (r.morphing != s.morphing.late_count + s.morphing.out_count)
        return {"the report counts morphing vertices wrongly"};
    return {};
}

} // namespace

Violation validate_cut(const CutState& s) {
    // While the state follows what the bulk pass has built, only the mesh is whole.
    if (s.bulk.phase >= BulkPhase::releasing) return validate_mesh(s);
    Tally vertex_slots;
    if (const Violation wrong = check_pages(s, vertex_slots)) return wrong;
    if (const Violation wrong = check_vertex_slots(s, vertex_slots)) return wrong;
    if (const Violation wrong = validate_queues(s.work.queues)) return wrong;
    if (const Violation wrong = validate_schedule(s.work.schedule, s.work.queues)) return wrong;
    for (std::uint32_t rank = 0; rank < rank_count; ++rank)
        if (s.work.queues.sizes[work_queues + rank] != 0 && (s.work.queues.work_ranks >> rank & 1) == 0)
            return {"a queue holds work, and nobody will look at it"};
    if (const Violation wrong = validate_mesh(s)) return wrong;
    if (const Violation wrong = check_morphing(s)) return wrong;
    return check_report(s);
}

} // namespace fjell
