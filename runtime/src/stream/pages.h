// Pages that are wanted, asked for, taken over, and let go of.
#pragma once

#include "stream/state.h"

namespace fjell {

// Watches of the tiles' coarsest pages, with nothing loaded.
void begin_pages(StreamState& s);

// Takes over the eyes of this frame: where they are, where their motion will bring them, and how far they came.
// effective_px: the threshold that the cut's own capacities allow.
void look_for_pages(StreamState& s, std::span<const View> views, const CutSettings& cut, double effective_px);

// What has come since the last update goes into slots, up to StreamSettings::pages.
void take_pages(StreamState& s);

// Tests what the way of the eyes may have changed, then asks for the most wanted pages, withdraws what is not wanted
// any more, and asks the cut to let go of pages that are wanted less than those without a slot.
void want_pages(StreamState& s);

// They may be asked for again.
void forget_failed_pages(StreamState& s);

// A box around a page and the ground of its tile that it says nothing of: up to its largest error above and below.
[[nodiscard]] Watch tile_box(const StreamState& s, std::uint32_t tile);
[[nodiscard]] double distance_m(const Watch& box, Vec3 eye_m);
[[nodiscard]] bool may_be_seen(const StreamState& s, const Watch& box);

} // namespace fjell
