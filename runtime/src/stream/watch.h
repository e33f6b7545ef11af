// Pages that are watched: what could be requested next, and what is loaded. Whether the views want each, how much, and
// for how long that stands.
#pragma once

#include <span>

#include "stream/state.h"

namespace fjell {

inline constexpr float never = 3e38f;
inline constexpr double most_px = 1e7; // of pages that are wanted at any threshold

[[nodiscard]] inline std::uint32_t root_watch(const StreamState& s, std::uint32_t tile) {
    return s.slots * watches_per_slot + tile;
}
[[nodiscard]] inline bool is_root(const StreamState& s, std::uint32_t watch) {
    return watch >= s.slots * watches_per_slot;
}
[[nodiscard]] inline std::uint32_t slot_of(std::uint32_t watch) {
    return watch / watches_per_slot;
}
[[nodiscard]] inline ChunkId chunk_of(const StreamState& s, std::uint32_t watch) {
    const std::uint32_t page = s.watch_page[watch], pages = s.terrain->pages_per_tile;
    return {ChunkKind::geometry, page / pages, page % pages};
}

// Where the ground has been edited, pages are bounded and tested anew (fjell/edit.h). O(watches) then.
void follow_ground(StreamState& s);

// Begins to watch a page, from the next test on; ceases to.
void watch_page(StreamState& s, std::uint32_t watch, std::uint32_t tile, std::uint32_t page, WatchState state);
void forget_watch(StreamState& s, std::uint32_t watch);
// Whether missing_bits has it.
void set_missing(StreamState& s, std::uint32_t watch, bool missing);

// Sets the eyes of this frame: where they are, where their motion will bring them, and how far they moved.
// effective_px: the threshold that the cut's own capacities allow.
void set_views(StreamState& s, std::span<const View> views, const CutSettings& cut, double effective_px);
// Sets wants[], page_px[], due[] and the missing bit of one, or of all whose time has come. O(eyes).
void test(StreamState& s, std::uint32_t watch);
void test_pages(StreamState& s);
// What brings a request forward.
[[nodiscard]] float score_of(const StreamState& s, std::uint32_t watch);
// What it would be if a frustum showed the page; not of a coarsest page.
[[nodiscard]] float score_if_seen(const StreamState& s, std::uint32_t watch);

// A box around a page and the ground of its tile that it says nothing of: up to its largest error above and below.
[[nodiscard]] Watch tile_box(const StreamState& s, std::uint32_t tile);
[[nodiscard]] double distance_m(const Watch& box, Vec3 eye_m);
[[nodiscard]] bool may_be_seen(const StreamState& s, const Watch& box);

} // namespace fjell
