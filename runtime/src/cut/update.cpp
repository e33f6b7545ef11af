#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <utility>

#include "cut/edits.h"
#include "cut/error_bound.h"
#include "cut/refine.h"
#include "cut/state.h"
#include "fjell/measure.h"
#include "fjell/pages.h"
#include "validate.h"

namespace fjell {

namespace {

using Clock = std::chrono::steady_clock; // CLOCK_MONOTONIC: read without a system call

double microseconds(Clock::time_point from, Clock::time_point to) {
    return std::chrono::duration<double, std::micro>(to - from).count();
}

// Takes the views; what they may have changed becomes due.
void set_views(CutState& s, std::span<const View> views, double threshold_px) {
    if (s.frame.settings.morph != Morph::none && s.morphing.now.morph == Morph::none) {
        finish_bulk(s); // its triangles could not be flattened one by one
        flatten_all(s.pages, s.mesh);
    }
    const Criterion before = s.views.criterion, offscreen_before = s.views.offscreen_criterion;
    take_views(s.pages.grid, s.views, s.morphing, s.frame, views, threshold_px);
    charge_views(s.pages.grid, s.work.schedule, s.bulk, s.views, before, offscreen_before);
}

void list_ranges(Mesh& mesh, const Views& views, Frame& frame) {
    mesh.range_count = 0;
    for (std::uint32_t tile = 0; tile < mesh.tile_count; ++tile) {
        const TileList& list = mesh.tiles[tile];
        if (list.total == 0 || (list.bounded && !is_seen(views, list.centre_m, list.radius_m))) continue;
        ++frame.report.tiles_drawn;
        frame.report.triangles_drawn += list.total;
        std::uint32_t count = list.in_last;
        for (std::uint32_t segment = list.last_segment; segment != no_index; segment = mesh.segment_below[segment]) {
            mesh.ranges[mesh.range_count++] = {tile, (segment << mesh.segment_log2) * 3, count * 3, count};
            count = 1u << mesh.segment_log2;
        }
    }
}

// What the mesh lacks of its threshold; 0: nothing.
double waiting_px(CutState& s, bool overlooking) {
    const CutReport& r = s.frame.report;
    if (r.waiting == 0 && r.morphing == 0) return 0;
    // Nobody has looked at what is drawn, or at what pages hide that have no state.
    if (s.bulk.phase != BulkPhase::idle || s.pages.some_wait) return any_mesh_px(s);
    // What is called off-screen, and may be seen, is refined to the factor at least, but for what waits there.
    const double coarsest_px = overlooking ? r.threshold_px * s.frame.settings.offscreen_factor : 0;
    const double hidden_px = std::max(error_bound_px(s, overlooking), coarsest_px);
    if (r.morphing == 0 && s.morphing.now.morph == Morph::none) return hidden_px;
    // Of vertices that stand between two heights what moves them comes on top of what the mesh around them hides; it
    // is less than the threshold where they should not be active any more.
    return std::min(std::max(hidden_px, r.threshold_px) + r.threshold_px, unbounded_px);
}

// What is in use. Returns the share of the scarcest capacity.
double report_use(const Pages& pages, Mesh& mesh, CutReport& r) {
    r.vertex_slots = {mesh.capacity - free_vertices(mesh), 0, mesh.capacity};
    mesh.vertex_peak = std::max(mesh.vertex_peak, r.vertex_slots.used);
    r.vertex_slots.peak = mesh.vertex_peak;
    const auto slots = [&](std::uint32_t segments) { return segments << mesh.segment_log2; };
    r.triangle_slots = {slots(mesh.segment_count - mesh.free_segment_count), slots(mesh.segment_peak),
                        slots(mesh.segment_count)};
    r.vertices = r.vertex_slots.used;
    for (std::uint32_t tile = 0; tile < mesh.tile_count; ++tile) r.triangles += mesh.tiles[tile].total;
    r.vertices_changed = mesh.dirty_vertices.slots;
    r.triangles_changed = mesh.dirty_triangles.slots;
    return std::max({static_cast<double>(r.vertex_slots.used) / r.vertex_slots.capacity,
                     static_cast<double>(r.triangle_slots.used) / r.triangle_slots.capacity,
                     may_lack_pages(pages) ? static_cast<double>(pages.busy) / pages.count : 0.0});
}

// Missing pages that no view wants at the threshold of the stream's search hide no more than that; a rebuild may refine
// to a lower one.
void claim_unsought_pages(const Grid& grid, double threshold_px) {
    TerrainData& t = *find(grid.handle);
    if (t.pages_missing != 0 && t.sought_px > threshold_px) t.missing_px = std::max(t.missing_px, t.sought_px);
}

bool is_same(const View& a, const View& b) {
    const auto same = [](Vec3 u, Vec3 v) { return u.x == v.x && u.y == v.y && u.z == v.z; };
    return same(a.eye_m, b.eye_m) && same(a.forward, b.forward) && same(a.up, b.up) && a.left == b.left &&
           a.right == b.right && a.bottom == b.bottom && a.top == b.top && a.width_px == b.width_px &&
           a.height_px == b.height_px && a.near_m == b.near_m && a.far_m == b.far_m && a.max_error_px == b.max_error_px;
}

// What missing pages may hide from this cut's views. The stream has looked for what its own views want; from others any
// page may hide anything.
double missing_px(const CutState& s) {
    const TerrainData& t = *s.pages.grid.terrain;
    if (t.pages_missing == 0 || t.sought_px == 0) return t.missing_px;
    const std::span sought(t.sought_view, t.sought_views);
    for (const View& view : std::span(s.views.view, s.views.count))
        if (std::none_of(sought.begin(), sought.end(), [&](const View& v) { return is_same(v, view); }))
            return std::max(t.missing_px, any_mesh_px(s));
    return t.missing_px;
}

// What is left to do. overlooking: a view may see what nobody has looked at for it yet. hidden_px: by missing pages.
void report_waiting(CutState& s, bool overlooking, double hidden_px) {
    CutReport& r = s.frame.report;
    if (s.pages.some_wait) s.frame.full_capacities |= cut_budget_vertices;
    if (s.frame.full_capacities != 0 || r.threshold_px <= r.error_px_requested)
        s.governor.cause = s.frame.full_capacities;
    r.exhausted |= s.governor.cause;
    const bool building = s.bulk.phase != BulkPhase::idle;
    r.morphing = s.morphing.late_count + s.morphing.out_count;
    r.blocked = blocked_groups(s.work);
    r.waiting = waiting_groups(s.work) + building + s.pages.some_wait + overlooking;
    for (std::uint32_t i = 0; i < s.pages.evicting_count; ++i)
        r.waiting += s.pages.state[s.pages.evicting[i]].active != 0;
    std::uint32_t gated = 0;
    for (std::uint32_t queue = gated_queues; queue < queue_count; ++queue) gated += s.work.queues.sizes[queue];
    s.frame.lagging = r.waiting != r.blocked + gated + s.pages.some_wait;
    r.converged = r.waiting == 0 && r.morphing == 0 && r.threshold_px <= r.error_px_requested &&
                  hidden_px <= r.error_px_requested;
}

// What was changed: listed, reported and governed, and what the screen may lack of it claimed.
void finish(CutState& s) {
    CutReport& r = s.frame.report;
    list_ranges(s.mesh, s.views, s.frame);
    claim_unsought_pages(s.pages.grid, r.threshold_px);
    const double use = report_use(s.pages, s.mesh, r);
    if (s.bulk.phase >= BulkPhase::releasing) r.vertices = s.mesh.corner_count + s.bulk.taken;
    const bool overlooking = s.bulk.phase == BulkPhase::idle && is_overlooking(s.pages, s.views, s.visibility);
    const double hidden_px = missing_px(s);
    report_waiting(s, overlooking, hidden_px);
    govern(s.pages.grid, s.views, s.governor, s.frame, use);
    // What waits, and what pages hide that are wanted and not there, bounds the screen as a threshold would.
    r.error_bound_px = std::max({r.threshold_px, waiting_px(s, overlooking), hidden_px});
}

// What the host has not taken is kept for it.
void begin_changes(Mesh& mesh, const Frame& frame) {
    if (std::exchange(mesh.untaken_taken, false)) {
        mesh.untaken_vertices.clear();
        mesh.untaken_triangles.clear();
    }
    if (std::exchange(mesh.dirty_taken, false)) {
        mesh.dirty_vertices.clear();
        mesh.dirty_triangles.clear();
    } else if (frame.number != 0) { // what create_cut() has written belongs to the first frame
        mesh.dirty_vertices.move_to(mesh.untaken_vertices);
        mesh.dirty_triangles.move_to(mesh.untaken_triangles);
    }
}

void begin_frame(Mesh& mesh, Morphing& morphing, Frame& frame, const CutSettings& settings) {
    frame.started = Clock::now();
    frame.settings = settings;
    begin_changes(mesh, frame);
    frame.report = {};
    frame.report.frame = ++frame.number;
    frame.report.error_px_requested = settings.max_error_px;
    // As much as the last one that lagged has taken: it looks at what waits, and nobody knows which will.
    frame.reserved_us = std::min(frame.output_us, settings.max_time_us / 2);
    frame.full_capacities = frame.batches = frame.deactivations_when_full = 0;
    advance_clock(morphing, frame, frame.number == 1);
}

// What was blocked takes its turn again; what still is goes to the other list.
void take_turns(Queues& queues) {
    if (queues.sizes[blocked_queues + (queues.turn ^ 1)] == 0) queues.turn ^= 1;
    if (queues.sizes[gated_queues + (queues.gated_turn ^ 1)] == 0) {
        queues.gated_turn ^= 1;
        if (queues.gate_passes != 0) --queues.gate_passes;
    }
}

// Every slot that is in use: after a rebuild they are the first ones. Others stay marked: a jump's build that a rebuild
// cut short has written there.
void mark_all(Mesh& mesh) {
    mesh.dirty_vertices.mark_range(0, mesh.fresh_vertex);
    mesh.dirty_triangles.mark_range(0, (mesh.segment_count - mesh.free_segment_count) << mesh.segment_log2);
}

// The whole mesh, all around, with the requested threshold or the lowest one above it that the capacities allow.
void build_from_nothing(CutState& s, std::span<const View> views) {
    CutReport& r = s.frame.report;
    begin_governing(s.governor, s.frame.settings.max_error_px);
    bool complete = true;
    finish_bulk(s);
    if (s.pages.grid.terrain->changes != s.pages.seen_changes) reset(s);
    follow_ground(s);
    bool cleared = !may_lack_pages(s.pages);
    for (;;) {
        set_views(s, views, s.governor.effective_px);
        watch_pages(s);
        const BulkStatus status = build_bulk(s);
        if (status == BulkStatus::built) break;
        r.evaluations = 0;
        if (status == BulkStatus::no_pages && !std::exchange(cleared, true)) { // those of what is drawn were missing
            reset(s);
            while (reclaim_page(s.pages, s.work, s.mesh)) {
            }
            continue;
        }
        s.governor.cause |= status == BulkStatus::no_triangles ? cut_budget_triangles : cut_budget_vertices;
        if (raise_threshold(s.views, s.governor, s.frame)) continue;
        // What is wanted at any threshold is too much: as far as it goes, then.
        reset(s);
        begin_at_roots(s.pages, s.work, s.mesh);
        refine(s);
        complete = false;
        break;
    }
    r.threshold_px = s.governor.effective_px;
    if (complete) mark_all(s.mesh); // otherwise refine() has marked what it wrote
    r.activations = s.mesh.capacity - free_vertices(s.mesh) - s.mesh.corner_count;
    r.work = r.evaluations + r.activations;
    if (complete) r.work = r.work * parts_a_group / parts_an_item;
    s.bulk.parts = 0;
    const auto built = Clock::now();
    finish(s);
    r.refine_us = microseconds(s.frame.started, built);
    r.output_us = microseconds(built, Clock::now());
}

// A frame that has no limit does what it can in the cheapest way. (A replay of one that its time has ended has visits.)
bool has_no_limit(const Frame& frame) {
    return frame.item_limit == unlimited_work && frame.settings.visits == unlimited_work &&
           frame.settings.max_time_us == 0;
}

// What both ways cost, in units of some 20 ns (docs/notes/live-cut.md, "Follow or build"): for a new mesh its vertices
// and pages, which are about as many as now; to follow, the groups whose slack is spent, each with what comes of it.
// Where something is off-screen groups that come into sight are due as well.
constexpr std::uint64_t page_cost = 210, spent_cost = 26, spent_cost_with_offscreen = 36, item_cost = 6;

std::uint64_t building_cost(const CutState& s) {
    const std::uint32_t active = s.mesh.capacity - free_vertices(s.mesh) - s.mesh.corner_count;
    return active + page_cost * s.pages.busy;
}

// Of a frame without a limit whose views have leapt or zoomed: is a new mesh cheaper than what follows them? Where
// vertices morph only a jump has one, for none of them would rise.
bool is_build_cheaper(const CutState& s) {
    // Where a capacity is short a new mesh is tried at many thresholds, and what follows ends where it is spent.
    const bool short_of_room = s.governor.cause != 0;
    if (s.frame.settings.morph != Morph::none || s.frame.number == 1 || short_of_room) return s.views.leapt;
    const std::uint64_t cost = s.frame.settings.offscreen_factor > 1 ? spent_cost_with_offscreen : spent_cost;
    const auto most = static_cast<std::uint32_t>(building_cost(s) / cost);
    return count_spent(s.work.schedule, most) > most;
}

// So many items of following cost more than twice as much as a new mesh: when they are spent, that is made after all.
// Nobody can tell beforehand how much comes of a group that is spent.
std::uint32_t items_of_a_build(const CutState& s) {
    return static_cast<std::uint32_t>(building_cost(s) / item_cost) + 256;
}

} // namespace

Status update_cut(LiveCut cut, std::span<const View> views, const CutSettings& settings, CutReport& report) {
    CutState* const found = find_cut(cut);
    if (found == nullptr) return no_cut;
    CutState& s = *found;
    if (Status v = validate(views, settings, s.budget); !v.ok()) return v;
    const std::int64_t ticks_before = s.morphing.clock.ticks;
    begin_frame(s.mesh, s.morphing, s.frame, settings);
    retire_times(s.mesh, s.morphing, ticks_before);
    s.frame.item_limit = settings.max_work;
    CutReport& r = s.frame.report;
    s.governor.effective_px = next_threshold_px(s.governor, settings.max_error_px);
    if (s.governor.cause == 0) s.governor.aim_px = settings.max_error_px;
    r.threshold_px = s.governor.effective_px;
    set_views(s, views, s.governor.effective_px);
    follow_bases(s);
    // What replays a frame that has chosen its way: it chooses again.
    const bool chooses = has_no_limit(s.frame) && (s.views.leapt || s.views.zoomed);
    const auto build = [&] {
        build_from_nothing(s, views);
        r.visits = unlimited_work;
        report = r;
        FJELL_WALK(s.frame.number, validate_cut(s));
        return Status{};
    };
    if (chooses && is_build_cheaper(s)) return build();
    if (chooses) s.views.leapt = false; // nor is one built beside
    if (run_bulk(s)) {
        const auto built = Clock::now();
        finish(s);
        r.refine_us = microseconds(s.frame.started, built);
        r.output_us = microseconds(built, Clock::now());
        report = r;
        return {};
    }
    const auto changes = [&] { return r.evaluations + r.activations + r.deactivations; };
    [[maybe_unused]] const std::uint32_t beside = changes() - r.work; // what was built takes less
    sync_pages(s);
    follow_ground(s);
    watch_pages(s);
    take_turns(s.work.queues);
    end_morphing_in(s.work, s.morphing);
    const auto prepared = Clock::now();
    evict_pages(s);
    keep_pages_at_hand(s.pages, s.work, s.mesh);
    const bool may_build = chooses && settings.morph == Morph::none && s.governor.cause == 0;
    if (may_build) s.frame.item_limit = items_of_a_build(s);
    refine(s);
    FJELL_ASSERT(changes() - r.work == beside);
    if (may_build && (r.exhausted & cut_budget_work) != 0) {
        s.frame.item_limit = unlimited_work;
        r.exhausted = r.deactivations = s.frame.full_capacities = 0;
        return build();
    }
    const auto refined = Clock::now();
    finish(s);
    r.prepare_us = microseconds(s.frame.started, prepared);
    r.refine_us = microseconds(prepared, refined);
    r.output_us = microseconds(refined, Clock::now());
    if (s.frame.lagging && !s.views.jumped) s.frame.output_us = r.output_us;
    if (chooses) r.visits = unlimited_work;
    report = r;
    FJELL_WALK(s.frame.number, validate_cut(s));
    return {};
}

Status rebuild_cut(LiveCut cut, std::span<const View> views, const CutSettings& settings, CutReport& report) {
    CutState* const found = find_cut(cut);
    if (found == nullptr) return no_cut;
    CutState& s = *found;
    if (Status v = validate(views, settings, s.budget); !v.ok()) return v;
    begin_frame(s.mesh, s.morphing, s.frame, settings);
    s.frame.item_limit = s.frame.settings.visits = unlimited_work;
    s.frame.settings.max_time_us = 0;
    s.frame.report.rebuilt = true;
    build_from_nothing(s, views);
    report = s.frame.report;
    FJELL_WALK(s.frame.number, validate_cut(s));
    return {};
}

namespace {

// nullptr: the cut does not hold it.
LoadedPage* loaded_page(const Pages& pages, std::uint32_t page) {
    const std::uint32_t slot = pages.grid.terrain->page_table[page].slot;
    return slot != no_index && pages.loaded[slot].page == page ? &pages.loaded[slot] : nullptr;
}

} // namespace

Status cut_release_page(LiveCut cut, std::uint32_t tile, std::uint32_t page, bool& released) {
    CutState* const found = find_cut(cut);
    if (found == nullptr) return no_cut;
    CutState& s = *found;
    if (tile >= s.mesh.tile_count || page >= s.pages.grid.pages_per_tile)
        return {StatusCode::out_of_range, "tile or page"};
    LoadedPage* const loaded = loaded_page(s.pages, tile * s.pages.grid.pages_per_tile + page);
    released = loaded == nullptr;
    if (released) return {};
    const std::uint32_t first = s.pages.page_groups[loaded->page], slot = first / max_page_groups;
    const bool attached = first != no_index;
    if (attached && !loaded->evicting) {
        FJELL_ASSERT(s.pages.state[slot].status == PageStatus::live && s.pages.evicting_count < s.pages.count);
        s.pages.state[slot].status = PageStatus::evicting;
        s.pages.evicting[s.pages.evicting_count++] = slot;
    }
    loaded->evicting = true;
    // What the bulk pass has found there may be about to be drawn.
    released = !attached || (s.pages.state[slot].active == 0 &&
                             (s.bulk.phase == BulkPhase::idle || found_in(s.bulk, slot) == nullptr));
    return {};
}

Status cut_cancel_release(LiveCut cut, std::uint32_t tile, std::uint32_t page) {
    CutState* const found = find_cut(cut);
    if (found == nullptr) return no_cut;
    CutState& s = *found;
    if (tile >= s.mesh.tile_count || page >= s.pages.grid.pages_per_tile)
        return {StatusCode::out_of_range, "tile or page"};
    LoadedPage* const loaded = loaded_page(s.pages, tile * s.pages.grid.pages_per_tile + page);
    if (loaded == nullptr) return {};
    loaded->evicting = false;
    if (const std::uint32_t first = s.pages.page_groups[loaded->page]; first != no_index)
        cancel_eviction(s.pages, s.work, first / max_page_groups);
    return {};
}

const char* budget_field(CutBudgetBit bit) {
    switch (bit) {
    case cut_budget_vertices: return "CutBudget::vertices";
    case cut_budget_triangles: return "CutBudget::triangles";
    case cut_budget_work: return "CutSettings::max_work";
    case cut_budget_time: break;
    }
    return "CutSettings::max_time_us";
}

} // namespace fjell
