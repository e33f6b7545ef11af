// Pages that come, are asked back, and go.
#pragma once

#include "cut/state.h"

namespace fjell {

// Enters every page that is loaded and leaves those that are gone. O(changes since the last call), or O(slots) when
// those were more than the terrain's log remembers.
void sync_pages(CutState& s);
// The next call looks at all slots.
void rescan_pages(CutState& s);

// As if nothing were active, for one page.
void clear_page(CutState& s, std::uint32_t slot);

// Deactivates what draining pages still hold, as far as the items go.
void evict_pages(CutState& s);

// A draining page stays after all: what it could activate is looked at again.
void cancel_eviction(CutState& s, std::uint32_t slot);

// Finds which parents of some lanes of a group are active.
struct ParentMasks {
    std::uint16_t parent[2];
};
[[nodiscard]] ParentMasks parents_of(const CutState& s, std::uint32_t group, std::uint32_t lanes);

} // namespace fjell
