// Pages that are requested, inserted and evicted.
#pragma once

#include "stream/state.h"

namespace fjell {

// Watches of the tiles' coarsest pages, with nothing loaded.
void begin_pages(StreamState& s);

// Inserts what has arrived since the last update, up to StreamSettings::pages.
void insert_pages(StreamState& s);

// Tests what the motion of the eyes may have changed, then requests the pages that are wanted most, cancels requests
// that are not wanted any more, and has the cut evict pages that are wanted less than those without a slot.
void request_pages(StreamState& s);

// They may be requested again.
void forget_failed_pages(StreamState& s);

} // namespace fjell
