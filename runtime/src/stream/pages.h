// Pages that are asked for, taken over, and let go of.
#pragma once

#include "stream/state.h"

namespace fjell {

// Watches of the tiles' coarsest pages, with nothing loaded.
void begin_pages(StreamState& s);

// What has come since the last update goes into slots, up to StreamSettings::pages.
void insert_pages(StreamState& s);

// Tests what the way of the eyes may have changed, then asks for the most wanted pages, withdraws what is not wanted
// any more, and asks the cut to let go of pages that are wanted less than those without a slot.
void request_pages(StreamState& s);

// They may be asked for again.
void forget_failed_pages(StreamState& s);

} // namespace fjell
