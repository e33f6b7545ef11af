#include "cut/views.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "cut/error_bound.h"
#include "cut/state.h"

namespace fjell {

Status validate(const CutSettings& c) {
    if (!(c.max_error_px >= 1e-3 && c.max_error_px <= 1e6))
        return {StatusCode::out_of_range, "CutSettings::max_error_px"};
    if (!(c.hysteresis >= 0 && c.hysteresis <= 10))
        return {StatusCode::out_of_range, "CutSettings::hysteresis (0 to 10)"};
    if (!(c.offscreen_factor >= 1 && c.offscreen_factor <= max_offscreen_factor))
        return {StatusCode::out_of_range, "CutSettings::offscreen_factor (1 to 100)"};
    if (!(c.max_time_us >= 0)) return {StatusCode::out_of_range, "CutSettings::max_time_us"};
    if (c.morph > Morph::time) return {StatusCode::out_of_range, "CutSettings::morph"};
    if (!(c.morph_s >= 0.01 && c.morph_s <= 10)) return {StatusCode::out_of_range, "CutSettings::morph_s (0.01 to 10)"};
    if (!std::isfinite(c.now_s)) return {StatusCode::out_of_range, "CutSettings::now_s"};
    return {};
}

Status validate(std::span<const View> views, const CutSettings& settings, const CutBudget& budget) {
    if (views.empty() || views.size() > budget.views)
        return {StatusCode::out_of_range, "views (1 to CutBudget::views)"};
    for (const View& view : views)
        if (Status v = validate(view); !v.ok()) return v;
    if (settings.morph != Morph::none && !budget.morph)
        return {StatusCode::not_supported, "CutSettings::morph (CutBudget::morph is false)"};
    return validate(settings);
}

namespace {

// Largest error of a grade in this terrain.
double grade_error_m(const Grid& grid, std::uint32_t grade) {
    const std::uint32_t code = ((grade + 1) << grade_codes_log2) - 1;
    return std::min(static_cast<double>(grid.terrain->errors.metres[code]),
                    static_cast<double>(grid.terrain->range.error_m));
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
    return view.max_error_px > 0 ? view.max_error_px * (effective_px / settings.max_error_px) : effective_px;
}

} // namespace

void take_views(const Grid& grid, Views& views, Morphing& morphing, const Frame& frame, std::span<const View> taken,
                double threshold_px) {
    const CutSettings& settings = frame.settings;
    Criterion &c = views.criterion, &offscreen = views.offscreen_criterion;
    // Two levels of nesting lie between a vertex and the ends of the edge that it splits.
    const double nested = 1 + static_cast<double>(grid.terrain->header.nesting);
    const double early = settings.morph == Morph::none ? 1 : nested * nested;
    morphing.before = morphing.now;
    morphing.now.morph = settings.morph;
    morphing.now.views = static_cast<std::uint32_t>(taken.size());
    morphing.now.now_s = morphing.clock.now_s();
    views.largest_ratio = 0;
    for (std::size_t i = 0; i < taken.size(); ++i) {
        const View& view = taken[i];
        const double full_px =
            view_threshold_px(view, settings, threshold_px) / (settings.corner_safe ? corner_factor(view) : 1);
        const double px = full_px / early;
        c.reach[i] = make_reach(view, px);
        c.wish[i] = make_reach(view, px / (1 + settings.hysteresis / 2));
        c.keep[i] = make_reach(view, px / (1 + settings.hysteresis));
        const double offscreen_px = px * offscreen_factor(frame, view, px);
        offscreen.reach[i] = make_reach(view, offscreen_px);
        offscreen.wish[i] = make_reach(view, offscreen_px / (1 + settings.hysteresis / 2));
        offscreen.keep[i] = make_reach(view, offscreen_px / (1 + settings.hysteresis));
        morphing.now.view[i] = {c.reach[i].eye_x, c.reach[i].eye_y, c.reach[i].eye_z, c.reach[i].q,
                                static_cast<float>(focal_length_px(view) / full_px)};
        views.view[i] = view;
        views.frustum[i] = make_frustum(view);
        views.largest_ratio = std::max(views.largest_ratio, threshold_ratio(view, settings));
    }
    c.views = offscreen.views = views.count = static_cast<std::uint32_t>(taken.size());
    c.hysteresis = offscreen.hysteresis = settings.hysteresis > 0;
    views.largest_unit_px = screen_unit_px(views, frame);
}

void charge_views(const Grid& grid, Schedule& schedule, BulkPass& bulk, Views& views, const Criterion& before,
                  const Criterion& offscreen_before) {
    const ViewChange change(before, views.criterion), offscreen_change(offscreen_before, views.offscreen_criterion);
    views.still = before.views != 0 && change.at(0) == 0;
    constexpr double rounding = 1 + 0x1p-18; // reach_grow, of the sums above, of decisions, and charge_rounding
    double metres[grade_count];
    for (std::uint32_t grade = 0; grade < grade_count; ++grade) {
        const double error_m = grade_error_m(grid, grade);
        metres[grade] = std::max(change.at(error_m), offscreen_change.at(error_m)) * rounding;
    }
    advance(schedule, metres);
    for (std::uint32_t grade = 0; grade < grade_count; ++grade)
        bulk.travelled_m[grade] = (bulk.travelled_m[grade] + metres[grade]) * (1 + 0x1p-50);
    // By 32 cells, or by a threshold as far: most of what is awake is due.
    views.jumped = metres[grade_count / 2] > 1024 * schedule.tick_m;
    views.leapt = change.at(0) > 1024 * schedule.tick_m;
    views.zoomed = false;
    const Criterion& now = views.criterion;
    for (std::uint32_t i = 0; now.views == before.views && i < now.views; ++i)
        views.zoomed = views.zoomed || now.reach[i].q > before.keep[i].q || now.keep[i].q < before.reach[i].q;
    views.zoomed = views.zoomed && metres[grade_count / 2] > 256 * schedule.tick_m;
}

// --- the governor

namespace {

constexpr double governor_up = 1.1, governor_full = 0.8, governor_fill = 0.9;

// Beyond this effective threshold only vertices whose spheres hold an eye are wanted: that of no view is below 1e7.
double governor_most_px(const Views& views, const Frame& frame) {
    double least_ratio = 1;
    for (std::uint32_t i = 0; i < views.count; ++i)
        least_ratio = std::min(least_ratio, threshold_ratio(views.view[i], frame.settings));
    return 1e7 / least_ratio;
}

// How far the threshold may move in a frame, as a factor. Where vertices morph, one frame in many of what they take
// from the edge to their height: a tenth at once would move the screen by as much as vertices that do not morph. In a
// hurry, when one rise after another was not enough, twice as far each time.
constexpr int glide_frames = 16;
double glide_factor(const Grid& grid, const Governor& governor, const Frame& frame) {
    if (frame.settings.morph == Morph::none) return std::numeric_limits<double>::infinity();
    // Vertices of a narrower band pop, nearly; it would only hold the rise up.
    const double band =
        std::max(2 * std::log1p(static_cast<double>(grid.terrain->header.nesting)), std::log(governor_up));
    return std::exp(std::ldexp(band / glide_frames, static_cast<int>(governor.haste)));
}

// What the threshold should be, once it is where it should have been. use: share of the scarcest capacity; blocked:
// work waits for a capacity. still: no eye has moved.
double threshold_aim_px(Governor& g, double requested_px, double most_px, double use, bool blocked, bool still) {
    if (blocked) {
        constexpr std::uint32_t most_haste = 4;
        if (g.failed_px > 0 && g.failed_px < g.effective_px) g.haste = std::min(g.haste + 1, most_haste);
        g.failed_px = g.effective_px;
        g.failed_use = governor_full;
        g.moved = false;
        // Vertices whose spheres hold the eye are wanted at any threshold.
        return std::min(g.effective_px * governor_up, std::max(requested_px, most_px));
    }
    g.haste = 0;
    // Where the camera rests, use says what the failure left; where it moves, the law has to do.
    g.moved = g.moved || !still;
    if (!g.moved) g.failed_use = std::min(g.failed_use, use);
    if (use >= governor_full) return g.effective_px;
    if (g.effective_px <= requested_px) {
        g.failed_px = 0;
        return g.effective_px;
    }
    const double next = std::max(requested_px, g.effective_px * std::sqrt(std::max(use, 1e-4) / governor_fill));
    // Not again where it has just failed, unless much less is in use than then.
    if (g.failed_px > 0 && next < g.failed_px * std::sqrt(governor_up)) {
        if (use > g.failed_use - (g.moved ? 0.05 : 0.15)) return g.effective_px;
        g.failed_px = 0;
    }
    return next;
}

} // namespace

void begin_governing(Governor& governor, double requested_px) {
    governor = {requested_px, requested_px, 0, 0, governor_full, false, 0};
}

void govern(const Grid& grid, const Views& views, Governor& governor, const Frame& frame, double use) {
    Governor& g = governor;
    const double requested_px = frame.report.error_px_requested;
    g.effective_px = std::max(g.effective_px, requested_px);
    g.aim_px = std::max(g.aim_px, requested_px);
    if (frame.lagging) return;
    const bool blocked = frame.full_capacities != 0;
    if (g.effective_px == g.aim_px || (blocked && g.aim_px < g.effective_px))
        g.aim_px = threshold_aim_px(g, requested_px, governor_most_px(views, frame), use, blocked, views.still);
    const double factor = glide_factor(grid, governor, frame);
    g.effective_px = std::clamp(g.aim_px, g.effective_px / factor, g.effective_px * factor);
}

bool raise_threshold(const Views& views, Governor& governor, const Frame& frame) {
    governor.failed_px = governor.effective_px;
    governor.aim_px = governor.effective_px *= governor_up;
    return governor.effective_px < governor_most_px(views, frame);
}

} // namespace fjell
