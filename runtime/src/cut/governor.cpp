#include "cut/governor.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fjell {

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
