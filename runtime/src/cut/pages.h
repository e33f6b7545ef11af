// Pages that are loaded, evicted and unloaded: what the cut does about each.
#pragma once

#include "cut/state.h"

namespace fjell {

// Enters every page that was loaded and lets go of those that were unloaded. O(changes since the last call), or
// O(slots) when those were more than the terrain's log remembers.
void sync_pages(CutState& s);
// Has the host unloaded a page that the cut holds? The same complexity.
[[nodiscard]] bool has_lost_pages(const Pages& pages);
// The next sync_pages() visits all slots.
void rescan_pages(Pages& pages);

// Gives a page its state, if it is loaded and has none. False: there is none to be had.
[[nodiscard]] bool attach_page(Pages& pages, Work& work, Mesh& mesh, Visibility& visibility, std::uint32_t page);
// The page may have become idle: another one may have its state, from the next frame on.
void note_idle(Pages& pages, std::uint32_t slot);
// Takes the state of the page that has been idle longest. False: none is. Not while the bulk pass is under way, or
// groups have been taken from their queues.
bool reclaim_page(Pages& pages, Work& work, Mesh& mesh, Morphing& morphing);
// A few, as far as they will be needed soon.
void keep_pages_at_hand(Pages& pages, Work& work, Mesh& mesh, Morphing& morphing);
// States that pages can have without taking others'.
[[nodiscard]] std::uint32_t free_pages(const Pages& pages);
// Can there be more pages with states than there are states?
[[nodiscard]] inline bool may_lack_pages(const Pages& pages) {
    return pages.count < pages.grid.terrain->slot_count;
}

// Parents that do not exist count as active, in a page's groups. Writes nothing else.
void mark_absent_parents(Pages& pages, std::uint32_t slot);
// As if nothing were active, for one page: what is counted of it, and its groups, which are zero but for such parents.
void clear_page(Pages& pages, std::uint32_t slot);
void forget_active(Pages& pages, std::uint32_t slot);
void zero_groups(Pages& pages, std::uint32_t slot);

// Deactivates what is still active in pages that are being evicted, as far as the items go.
void evict_pages(CutState& s);

// The page stays after all: what it could activate is evaluated again.
void cancel_eviction(Pages& pages, Work& work, std::uint32_t slot);

// Finds which parents of some lanes of a group are active.
struct ParentMasks {
    std::uint16_t parent[2];
};
[[nodiscard]] ParentMasks parents_of(const Pages& pages, std::uint32_t group, std::uint32_t lanes);
// Those that do not exist, at the terrain's rim and above a tile's root, count as active. first: of the group's lanes.
[[nodiscard]] ParentMasks absent_parents(const Grid& grid, const Site& first, const GroupShape& shape);

} // namespace fjell
