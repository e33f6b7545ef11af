// The views of the last update, what follows from them, and what threshold they get.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "cut/pages.h"
#include "fjell/cut.h"
#include "view/wanted.h"

namespace fjell {

struct BulkPass;
struct LaneGroup; // evaluate.h
struct LaneAnswers;

// What all groups of a frame share.
struct Criterion {
    const float* error_m;       // 256
    const float* radius_factor; // 128
    float base_m, quantum_m;    // HeightScale
    float spacing_x_m, spacing_z_m;
    std::int32_t last_x, last_y; // of the terrain's samples
    std::uint32_t views;
    bool hysteresis;            // reach, wish and keep differ
    Reach reach[max_cut_views]; // vertices within it must be active: this is what margins of the others count to
    Reach wish[max_cut_views];  // farther: those that are looked at are activated already within it, or they would be
                                // looked at again and again where they are about to be needed
    Reach keep[max_cut_views];  // farther still: those that are active stay within it
};

// The views of the last update, and what follows from them.
struct Views {
    View view[max_cut_views];
    Frustum frustum[max_cut_views];
    std::uint32_t count;                      // 0: no update yet
    Criterion criterion, offscreen_criterion; // of groups that are not off-screen, and of those that are
    double largest_unit_px;                   // screen_unit_px() (error_bound.h)
    double largest_ratio;                     // of a view's threshold to that of the settings
    bool jumped;                              // an eye has, so far that much is due
    bool leapt;                               // and it is not only a threshold that has
    bool zoomed;                              // no eye has leapt, but a threshold, by more than hysteresis takes up
    bool still;                               // no eye has moved, come or gone since the frame before
    void (*evaluate)(const Criterion* const*, const LaneGroup*, std::uint32_t, LaneAnswers*);
    float (*worst_px)(const Criterion&, const LaneGroup&, const float*);
};

[[nodiscard]] inline const Criterion& criterion_of(const Pages& pages, const Views& views, std::uint32_t group) {
    return is_offscreen(pages, group) ? views.offscreen_criterion : views.criterion;
}

// May a view see any of a sphere?
[[nodiscard]] inline bool is_seen(const Views& views, const Vec3& centre_m, double radius_m) {
    for (std::uint32_t i = 0; i < views.count; ++i) {
        const Vec3 p = centre_m - views.view[i].eye_m;
        bool inside = true;
        for (int plane = 0; plane < 6 && inside; ++plane)
            inside = dot(views.frustum[i].normal[plane], p) >= views.frustum[i].offset[plane] - radius_m;
        if (inside) return true;
    }
    return false;
}

// Of an update, of the cut or of a stream beside it.
[[nodiscard]] Status validate(std::span<const View> views, const CutSettings& settings, const CutBudget& budget);

// Takes the views. threshold_px: the effective one, of those without one of their own.
void take_views(const Grid& grid, Views& views, Morphing& morphing, const Frame& frame, std::span<const View> taken,
                double threshold_px);
// What they may have changed becomes due. before: what the views were.
void charge_views(const Grid& grid, Schedule& schedule, BulkPass& bulk, Views& views, const Criterion& before,
                  const Criterion& offscreen_before);

// --- the governor: when a capacity does not suffice the effective threshold rises until it does, and falls again.
//
// It reacts to capacities only. Lack of time shows as lag instead, because changing the threshold makes work, exactly
// when there is too much of it. It acts on a cut at rest: one that has done all it can at the present threshold.
//
// Steps are sized so that they do not have to be taken back. Up: by a tenth, which frees at most a fifth (the number of
// vertices goes as the threshold to a power between -1 and -2), so that at least 0.8 of the scarcest capacity stay in
// use. Down: only below that, and only as far as fills nine tenths by the same law. A terrain whose vertices all come
// in one step can break any law, so a threshold that has failed is not tried again before use has dropped by a tenth.
//
// Where vertices morph it goes there frame by frame, or they would jump.

// What the governor remembers.
struct Governor {
    double effective_px; // 0: not started
    double aim_px;       // where it goes: at once, or frame by frame where vertices morph
    std::uint32_t haste; // how often in a row it has arrived in vain
    double failed_px;    // a threshold at which a capacity did not suffice; 0: none known
    double failed_use;   // share of the scarcest capacity in use once that was resolved
    bool moved;          // the camera has since then
    std::uint32_t cause; // CutBudgetBits that keep the effective threshold above the requested one
};

// A view's threshold over that of the settings. All views' rise alike when the effective threshold does.
[[nodiscard]] inline double threshold_ratio(const View& view, const CutSettings& settings) {
    return view_max_error_px(view, settings.max_error_px) / settings.max_error_px;
}

// At the requested threshold, as if nothing had ever failed.
void begin_governing(Governor& governor, double requested_px);

// The threshold that an update at the requested one begins with.
[[nodiscard]] inline double next_threshold_px(const Governor& governor, double requested_px) {
    return governor.cause == 0 ? requested_px : std::max(governor.effective_px, requested_px);
}

// The threshold of the next frame. use: share of the scarcest capacity.
void govern(const Grid& grid, const Views& views, Governor& governor, const Frame& frame, double use);

// A capacity did not suffice at this threshold: the next one. False: there is none at which less would be wanted.
[[nodiscard]] bool raise_threshold(const Views& views, Governor& governor, const Frame& frame);

} // namespace fjell
