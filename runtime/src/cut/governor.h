// The governor: when a capacity does not suffice the effective threshold rises until it does, and comes back.
//
// It answers to capacities only. Lack of time shows as lag instead, because changing the threshold makes work, exactly
// when there is too much of it. It acts on a cut at rest: one that has done all it can at the present threshold.
//
// Steps are sized so that they do not have to be taken back. Up: by a tenth, which frees at most a fifth (the number of
// vertices goes as the threshold to a power between -1 and -2), so that at least 0.8 of the scarcest capacity stay in
// use. Down: only below that, and only as far as fills nine tenths by the same law. A terrain whose vertices all come
// in one step can break any law, so a threshold that has failed is not tried again before use has dropped by a tenth.
#pragma once

#include <algorithm>
#include <cmath>

#include "cut/state.h"

namespace fjell {

inline constexpr double governor_up = 1.1, governor_full = 0.8, governor_fill = 0.9, governor_most_px = 1e7;

// Returns the threshold of the next frame. use: share of the scarcest capacity; blocked: work waits for a capacity.
// still: no eye has moved.
inline double govern(Governor& g, double asked_px, double use, bool blocked, bool at_rest, bool still) {
    if (g.effective_px < asked_px) g.effective_px = asked_px;
    if (!at_rest) return g.effective_px;
    if (blocked) {
        g.failed_px = g.effective_px;
        g.failed_use = governor_full;
        g.moved = false;
        // Vertices whose spheres hold the eye are wanted at any threshold.
        return g.effective_px = std::min(g.effective_px * governor_up, std::max(asked_px, governor_most_px));
    }
    // Where the camera rests, use says what the failure left; where it moves, the law has to do.
    g.moved = g.moved || !still;
    if (!g.moved) g.failed_use = std::min(g.failed_use, use);
    if (use >= governor_full) return g.effective_px;
    if (g.effective_px <= asked_px) {
        g.failed_px = 0;
        return g.effective_px;
    }
    const double next = std::max(asked_px, g.effective_px * std::sqrt(std::max(use, 1e-4) / governor_fill));
    // Not again where it has just failed, unless much less is asked for than then.
    if (g.failed_px > 0 && next < g.failed_px * std::sqrt(governor_up)) {
        if (use > g.failed_use - (g.moved ? 0.05 : 0.15)) return g.effective_px;
        g.failed_px = 0;
    }
    return g.effective_px = next;
}

} // namespace fjell
