#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <utility>

#include "cut/bulk.h"
#include "cut/change.h"
#include "cut/governor.h"
#include "cut/lag.h"
#include "cut/morph.h"
#include "cut/pages.h"
#include "cut/refine.h"
#include "cut/sight.h"
#include "fjell/measure.h"
#include "validate.h"

namespace fjell {

namespace {

using Clock = std::chrono::steady_clock; // CLOCK_MONOTONIC: read without a system call

double microseconds(Clock::time_point from, Clock::time_point to) {
    return std::chrono::duration<double, std::micro>(to - from).count();
}

// Largest error of a grade in this terrain.
double grade_error_m(const Grid& grid, std::uint32_t grade) {
    const std::uint32_t code = ((grade + 1) << grade_codes_log2) - 1;
    return std::min(static_cast<double>(grid.terrain->errors.metres[code]),
                    static_cast<double>(grid.terrain->header.max_error_m));
}

// By how much a view's margin of a vertex (evaluate.h) may exceed another's, for the vertex' error.
struct ViewExcess {
    double eye_m; // from eye to eye, and what their pads differ by
    double q;     // 0 where the view is the coarser one

    [[nodiscard]] double at(double error_m) const { return eye_m + q * error_m; }
};
ViewExcess excess(const Criterion& a, std::uint32_t i, const Criterion& b, std::uint32_t j) {
    const auto difference = [](float x, float y) { return static_cast<double>(std::abs(x - y)); };
    const auto above = [](float x, float y) { return static_cast<double>(std::max(x - y, 0.0f)); };
    const Reach &of = a.reach[i], &over = b.reach[j];
    const Vec3 way{difference(of.eye_x, over.eye_x), difference(of.eye_y, over.eye_y),
                   difference(of.eye_z, over.eye_z)};
    return {length(way) + difference(of.pad, over.pad), std::max(above(of.q, over.q), above(a.keep[i].q, b.keep[j].q))};
}

// How far apart two sets of views are (Hausdorff, with a distance that has a direction). A vertex' margin is the
// largest that any view gives it, f(i). Each new i has an old j with f(i) <= f(j) + d, so the largest f(i) exceeds the
// largest f(j) by no more than d; and the other way round. So a margin changes by d at most, whichever views come, go
// or change places, and by nothing where an equal view stays, or a finer one at the same eye.
class ViewChange {
public:
    ViewChange(const Criterion& before, const Criterion& now) : before_(before.views), now_(now.views) {
        for (std::uint32_t i = 0; i < now_; ++i)
            for (std::uint32_t j = 0; j < before_; ++j)
                rise_[i][j] = excess(now, i, before, j), fall_[i][j] = excess(before, j, now, i);
    }

    [[nodiscard]] double at(double error_m) const {
        double most = 0, falls[max_cut_views];
        std::fill_n(falls, before_, everything);
        for (std::uint32_t i = 0; i < now_; ++i) {
            double rise = everything;
            for (std::uint32_t j = 0; j < before_; ++j) {
                rise = std::min(rise, rise_[i][j].at(error_m));
                falls[j] = std::min(falls[j], fall_[i][j].at(error_m));
            }
            most = std::max(most, rise);
        }
        for (std::uint32_t j = 0; j < before_; ++j) most = std::max(most, falls[j]);
        return most;
    }

private:
    static constexpr double everything = 1e300; // the first views are far from none
    std::uint32_t before_, now_;
    ViewExcess rise_[max_cut_views][max_cut_views], fall_[max_cut_views][max_cut_views]; // [now][before]
};

// Exactly the requested one when the effective threshold is.
double view_threshold_px(const View& view, const CutSettings& settings, double effective_px) {
    return view.error_px > 0 ? view.error_px * (effective_px / settings.error_px) : effective_px;
}

// Sets the views; what they may have changed becomes due.
void set_views(CutState& s, std::span<const View> views, double threshold_px) {
    const Criterion before = s.views.criterion, offscreen_before = s.views.offscreen_criterion;
    Criterion &c = s.views.criterion, &offscreen = s.views.offscreen_criterion;
    // Two levels of nesting lie between a vertex and the ends of the edge that it splits.
    const double nested = 1 + static_cast<double>(s.pages.grid.terrain->header.nesting);
    if (s.frame.settings.morph != Morph::none && s.morphing.now.morph == Morph::none) {
        finish_bulk(s); // its triangles could not be flattened one by one
        flatten_all(s.pages, s.mesh);
    }
    const double early = s.frame.settings.morph == Morph::none ? 1 : nested * nested;
    s.morphing.before = s.morphing.now;
    s.morphing.now.morph = s.frame.settings.morph;
    s.morphing.now.views = static_cast<std::uint32_t>(views.size());
    s.morphing.now.now_s = s.morphing.clock.now_s();
    s.morphing.now.morph_s = static_cast<float>(s.frame.settings.morph_s);
    s.views.largest_ratio = 0;
    for (std::size_t i = 0; i < views.size(); ++i) {
        const double full_px = view_threshold_px(views[i], s.frame.settings, threshold_px) /
                               (s.frame.settings.corner_safe ? corner_factor(views[i]) : 1);
        const double px = full_px / early;
        c.reach[i] = make_reach(views[i], px);
        c.keep[i] = make_reach(views[i], px / (1 + s.frame.settings.hysteresis));
        const double offscreen_px = px * offscreen_factor(s.frame, views[i], px);
        offscreen.reach[i] = make_reach(views[i], offscreen_px);
        offscreen.keep[i] = make_reach(views[i], offscreen_px / (1 + s.frame.settings.hysteresis));
        s.morphing.now.view[i] = {c.reach[i].eye_x, c.reach[i].eye_y, c.reach[i].eye_z, c.reach[i].q,
                                  static_cast<float>(lambda_px(views[i]) / full_px)};
        s.views.view[i] = views[i];
        s.views.frustum[i] = make_frustum(views[i]);
        s.views.largest_ratio = std::max(s.views.largest_ratio, threshold_ratio(views[i], s.frame.settings));
    }
    c.views = offscreen.views = s.views.count = static_cast<std::uint32_t>(views.size());
    c.hysteresis = offscreen.hysteresis = s.frame.settings.hysteresis > 0;
    s.views.largest_unit_px = screen_unit_px(s.views, s.frame);
    const ViewChange change(before, c), offscreen_change(offscreen_before, offscreen);
    s.views.still = before.views != 0 && change.at(0) == 0;
    constexpr double rounding = 1 + 0x1p-18; // reach_grow, of the sums above, of decisions, and charge_rounding
    double metres[grade_count];
    for (std::uint32_t grade = 0; grade < grade_count; ++grade)
        metres[grade] = std::max(change.at(grade_error_m(s.pages.grid, grade)),
                                 offscreen_change.at(grade_error_m(s.pages.grid, grade))) *
                        rounding;
    advance(s.work.schedule, metres);
    for (std::uint32_t grade = 0; grade < grade_count; ++grade)
        s.bulk.travelled_m[grade] = (s.bulk.travelled_m[grade] + metres[grade]) * (1 + 0x1p-50);
    // By 32 cells, or by a threshold as far: most of what is awake is due.
    s.views.jumped = metres[grade_count / 2] > 1024 * s.work.schedule.tick_m;
    s.views.leapt = change.at(0) > 1024 * s.work.schedule.tick_m;
}

bool may_be_seen(const Views& views, const TileList& tile) {
    if (!tile.bounded) return true;
    for (std::uint32_t i = 0; i < views.count; ++i) {
        const Vec3 p = Vec3{tile.centre_m[0], tile.centre_m[1], tile.centre_m[2]} - views.view[i].eye_m;
        bool inside = true;
        for (int plane = 0; plane < 6 && inside; ++plane)
            inside = dot(views.frustum[i].normal[plane], p) >= views.frustum[i].offset[plane] - tile.radius_m;
        if (inside) return true;
    }
    return false;
}

void list_ranges(Mesh& mesh, const Views& views, Frame& frame) {
    mesh.range_count = 0;
    for (std::uint32_t tile = 0; tile < mesh.tile_count; ++tile) {
        const TileList& list = mesh.tiles[tile];
        if (list.total == 0 || !may_be_seen(views, list)) continue;
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
    forget_late_pages(s.pages, s.morphing, s.frame, r.morphing == 0);
    if (r.waiting == 0 && r.morphing == 0) return 0;
    // Nobody has looked at what is drawn, or at what pages hide that have no state.
    if (s.bulk.phase != BulkPhase::idle || s.pages.some_wait) return any_mesh_px(s);
    // What is called off-screen, and may be seen, is refined to the factor at least, but for what waits there.
    const double coarsest_px = overlooking ? r.threshold_px * s.frame.settings.offscreen_factor : 0;
    const double lag = std::max(lag_px(s, overlooking), coarsest_px);
    if (r.morphing == 0 && s.morphing.now.morph == Morph::none) return lag;
    // Of vertices that stand between two heights what moves them comes on top of what the mesh around them hides; it
    // is less than the threshold where they should not be active any more.
    return std::min(std::max(lag, r.threshold_px) + r.threshold_px, unbounded_px);
}

void finish(CutState& s) {
    CutReport& r = s.frame.report;
    list_ranges(s.mesh, s.views, s.frame);
    r.vertex_slots = {s.mesh.capacity - free_vertices(s.mesh), 0, s.mesh.capacity};
    s.mesh.vertex_peak = std::max(s.mesh.vertex_peak, r.vertex_slots.used);
    r.vertex_slots.peak = s.mesh.vertex_peak;
    const auto slots = [&](std::uint32_t segments) { return segments << s.mesh.segment_log2; };
    r.triangle_slots = {slots(s.mesh.segment_count - s.mesh.free_segment_count), slots(s.mesh.segment_peak),
                        slots(s.mesh.segment_count)};
    r.vertices = r.vertex_slots.used;
    for (std::uint32_t tile = 0; tile < s.mesh.tile_count; ++tile) r.triangles += s.mesh.tiles[tile].total;
    r.blocked = blocked_groups(s.work);
    if (s.pages.some_wait) s.frame.full_capacities |= cut_budget_vertices;
    if (s.frame.full_capacities != 0) s.governor.cause = s.frame.full_capacities;
    if (r.threshold_px <= r.error_px_requested) s.governor.cause = s.frame.full_capacities;
    r.exhausted |= s.governor.cause;
    r.morphing = s.morphing.late_count + s.morphing.out_count;
    r.waiting = waiting_groups(s.work);
    const bool building = s.bulk.phase != BulkPhase::idle;
    const bool overlooking = !building && is_overlooking(s.pages, s.views, s.visibility);
    r.waiting += building + s.pages.some_wait + overlooking;
    if (s.bulk.phase >= BulkPhase::releasing) r.vertices = s.mesh.corner_count + s.bulk.taken;
    for (std::uint32_t i = 0; i < s.pages.evicting_count; ++i)
        r.waiting += s.pages.state[s.pages.evicting[i]].active != 0;
    r.vertices_changed = s.mesh.dirty_vertices.slots;
    r.triangles_changed = s.mesh.dirty_triangles.slots;
    const std::uint32_t gated = s.work.queues.sizes[gated_queues] + s.work.queues.sizes[gated_queues + 1];
    s.frame.lagging = r.waiting != r.blocked + gated + s.pages.some_wait;
    r.converged = r.waiting == 0 && r.morphing == 0 && r.threshold_px <= r.error_px_requested;
    const double use = std::max({static_cast<double>(r.vertex_slots.used) / r.vertex_slots.capacity,
                                 static_cast<double>(r.triangle_slots.used) / r.triangle_slots.capacity,
                                 may_lack_pages(s.pages) ? static_cast<double>(s.pages.busy) / s.pages.count : 0.0});
    govern(s.pages.grid, s.views, s.governor, s.frame, use);
    // What waits, and what pages hide that are wanted and not there, bounds the screen as a threshold would.
    r.error_px_effective = std::max({r.threshold_px, waiting_px(s, overlooking), s.pages.grid.terrain->missing_px});
    r.converged = r.converged && s.pages.grid.terrain->missing_px <= r.error_px_requested;
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
    frame.report.error_px_requested = settings.error_px;
    // As much as the last one that lagged has taken: it looks at what waits, and nobody knows which will.
    frame.reserved_us = std::min(frame.output_us, settings.budget_us / 2);
    frame.full_capacities = frame.batches = frame.deactivations_when_full = 0;
    advance_clock(morphing, frame, frame.number == 1);
}

// Every slot that is in use: after a rebuild they are the first ones. Others stay marked: a jump's build that a rebuild
// cut short has written there.
void mark_all(Mesh& mesh) {
    mesh.dirty_vertices.mark_range(0, mesh.fresh_vertex);
    mesh.dirty_triangles.mark_range(0, (mesh.segment_count - mesh.free_segment_count) << mesh.segment_log2);
}

} // namespace

Status validate(const CutSettings& c) {
    if (!(c.error_px >= 1e-3 && c.error_px <= 1e6)) return {Code::out_of_range, "CutSettings::error_px"};
    if (!(c.hysteresis >= 0 && c.hysteresis <= 10)) return {Code::out_of_range, "CutSettings::hysteresis (0 to 10)"};
    if (!(c.offscreen_factor >= 1 && c.offscreen_factor <= max_offscreen_factor))
        return {Code::out_of_range, "CutSettings::offscreen_factor (1 to 100)"};
    if (!(c.budget_us >= 0)) return {Code::out_of_range, "CutSettings::budget_us"};
    if (c.morph > Morph::time) return {Code::out_of_range, "CutSettings::morph"};
    if (!(c.morph_s >= 0.01 && c.morph_s <= 10)) return {Code::out_of_range, "CutSettings::morph_s (0.01 to 10)"};
    if (!std::isfinite(c.now_s)) return {Code::out_of_range, "CutSettings::now_s"};
    return {};
}

Status validate(std::span<const View> views, const CutSettings& settings, std::uint32_t most_views) {
    if (views.empty() || views.size() > most_views) return {Code::out_of_range, "views (1 to CutBudget::views)"};
    for (const View& view : views)
        if (Status v = validate(view); !v.ok()) return v;
    return validate(settings);
}

Status update_cut(LiveCut cut, std::span<const View> views, const CutSettings& settings, CutReport& report) {
    CutState* const found = find_cut(cut);
    if (found == nullptr) return no_cut;
    CutState& s = *found;
    if (Status v = validate(views, settings, s.budget.views); !v.ok()) return v;
    const std::int64_t ticks_before = s.morphing.clock.ticks;
    begin_frame(s.mesh, s.morphing, s.frame, settings);
    retire_times(s.mesh, s.morphing, ticks_before);
    s.frame.item_limit = settings.items;
    CutReport& r = s.frame.report;
    s.governor.effective_px = std::max(s.governor.effective_px, settings.error_px);
    if (s.governor.cause == 0) s.governor.effective_px = s.governor.aim_px = settings.error_px;
    r.threshold_px = s.governor.effective_px;
    set_views(s, views, s.governor.effective_px);
    if (run_bulk(s)) {
        const auto built = Clock::now();
        finish(s);
        r.items = r.evaluations + r.activations + r.deactivations;
        r.refine_us = microseconds(s.frame.started, built);
        r.output_us = microseconds(built, Clock::now());
        report = r;
        return {};
    }
    r.items = r.evaluations + r.activations + r.deactivations;
    sync_pages(s);
    watch_pages(s);
    // What was blocked takes its turn again; what still is goes to the other list.
    if (s.work.queues.sizes[blocked_queues + (s.work.queues.turn ^ 1)] == 0) s.work.queues.turn ^= 1;
    if (s.work.queues.sizes[gated_queues + (s.work.queues.gated_turn ^ 1)] == 0) {
        s.work.queues.gated_turn ^= 1;
        if (s.work.queues.gate_passes != 0) --s.work.queues.gate_passes;
    }
    end_morphing_in(s.work, s.morphing);
    const auto prepared = Clock::now();
    evict_pages(s);
    keep_pages_at_hand(s.pages, s.work, s.mesh, s.morphing);
    refine(s);
    const auto refined = Clock::now();
    finish(s);
    r.prepare_us = microseconds(s.frame.started, prepared);
    r.refine_us = microseconds(prepared, refined);
    r.output_us = microseconds(refined, Clock::now());
    if (s.frame.lagging && !s.views.jumped) s.frame.output_us = r.output_us;
    report = r;
    FJELL_WALK(s.frame.number, validate_cut(s));
    return {};
}

Status rebuild_cut(LiveCut cut, std::span<const View> views, const CutSettings& settings, CutReport& report) {
    CutState* const found = find_cut(cut);
    if (found == nullptr) return no_cut;
    CutState& s = *found;
    if (Status v = validate(views, settings, s.budget.views); !v.ok()) return v;
    begin_frame(s.mesh, s.morphing, s.frame, settings);
    s.frame.item_limit = s.frame.settings.visits = unlimited_items;
    s.frame.settings.budget_us = 0;
    s.frame.report.rebuilt = true;
    CutReport& r = s.frame.report;
    // A rebuild starts from scratch: with the requested threshold, or the lowest one above it that the capacities
    // allow.
    begin_governing(s.governor, settings.error_px);
    bool complete = true;
    finish_bulk(s);
    if (s.pages.grid.terrain->changes != s.pages.seen_changes) reset(s);
    bool cleared = !may_lack_pages(s.pages);
    for (;;) {
        set_views(s, views, s.governor.effective_px);
        watch_pages(s);
        const BulkStatus status = build_bulk(s);
        if (status == BulkStatus::built) break;
        r.evaluations = 0;
        if (status == BulkStatus::no_pages && !std::exchange(cleared, true)) { // those of what is drawn were missing
            reset(s);
            while (reclaim_page(s.pages, s.work, s.mesh, s.morphing)) {
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
    r.items = r.evaluations + r.activations;
    const auto built = Clock::now();
    finish(s);
    r.refine_us = microseconds(s.frame.started, built);
    r.output_us = microseconds(built, Clock::now());
    report = r;
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
    if (tile >= s.mesh.tile_count || page >= s.pages.grid.pages_per_tile) return {Code::out_of_range, "tile or page"};
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
    if (tile >= s.mesh.tile_count || page >= s.pages.grid.pages_per_tile) return {Code::out_of_range, "tile or page"};
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
    case cut_budget_items: return "CutSettings::items";
    case cut_budget_time: break;
    }
    return "CutSettings::budget_us";
}

MorphFrame cut_morph(LiveCut cut) {
    const CutState* const s = find_cut(cut);
    return s != nullptr ? s->morphing.now : MorphFrame{};
}

float morphed_height_m(const Terrain& terrain, const MeshVertex& v, const MorphVertex& m, const MorphFrame& frame) {
    if (frame.morph == Morph::none) return v.height_m;
    const TerrainData* const found = find(terrain);
    if (found == nullptr) return v.height_m;
    float t = morph_fraction(frame, found->x_m(v.column), v.height_m, found->z_m(v.row), m.error_m, m.radius_m);
    t = std::min(t, morph_age_s(frame.now_s, m.activated_s) / frame.morph_s);
    return m.flat_m + (v.height_m - m.flat_m) * std::clamp(t, 0.0f, 1.0f);
}

} // namespace fjell
