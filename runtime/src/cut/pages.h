// Pages that are loaded, evicted and unloaded: what the cut does about each.
#pragma once

#include "cut/state.h"

namespace fjell {

// Attaches every page that was loaded and detaches those that were unloaded. O(changes since the last call), or
// O(slots) when those were more than the terrain's log remembers.
void sync_pages(CutState& s);
// Has the host unloaded a page that the cut holds? The same complexity.
[[nodiscard]] bool has_lost_pages(const CutState& s);
// The next sync_pages() visits all slots.
void rescan_pages(CutState& s);

// As if nothing were active, for one page.
void clear_page(CutState& s, std::uint32_t slot);

// Deactivates what is still active in pages that are being evicted, as far as the items go.
void evict_pages(CutState& s);

// The page stays after all: what it could activate is evaluated again.
void cancel_eviction(CutState& s, std::uint32_t slot);

// Finds which parents of some lanes of a group are active.
struct ParentMasks {
    std::uint16_t parent[2];
};
[[nodiscard]] ParentMasks parents_of(const CutState& s, std::uint32_t group, std::uint32_t lanes);

} // namespace fjell
