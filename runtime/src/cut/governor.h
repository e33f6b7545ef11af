// The governor: when a capacity does not suffice the effective threshold rises until it does, and falls again.
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
#pragma once

#include "cut/state.h"

namespace fjell {

// A view's threshold over that of the settings. All views' rise alike when the effective threshold does.
[[nodiscard]] inline double threshold_ratio(const View& view, const CutSettings& settings) {
    return view_error_px(view, settings.error_px) / settings.error_px;
}

// At the requested threshold, as if nothing had ever failed.
void begin_governing(Governor& governor, double requested_px);

// The threshold of the next frame. use: share of the scarcest capacity.
void govern(const Grid& grid, const Views& views, Governor& governor, const Frame& frame, double use);

// A capacity did not suffice at this threshold: the next one. False: there is none at which less would be wanted.
[[nodiscard]] bool raise_threshold(const Views& views, Governor& governor, const Frame& frame);

} // namespace fjell
