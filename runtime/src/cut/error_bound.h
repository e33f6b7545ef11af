// What a mesh that lags may hide, in pixels (invariant 4).
//
// A triangle hides no more than the error of the vertex that would split it, within that vertex' sphere; and errors
// and spheres nest. So of all that is not drawn it is enough to know the vertices that are ready and not active. Those
// that wait are in pages that are due, or with groups in queues, or that are being evicted: of every other page, all
// are within the threshold. A page's own bound, from its box, its largest error and its largest sphere, costs little
// and is loose where the eye is near; of the few pages whose bounds are highest the vertices are looked at, one by one.
//
// Vertices that morph by time hide something too, until they have arrived. Of those it is known, for each size of error
// and each eighth of the time that they take, how near their spheres were to an eye when they began (LateBounds).
#pragma once

#include "cut/state.h"

namespace fjell {

// Pixels of a metre at a metre's distance, in the view that shows it largest.
[[nodiscard]] double screen_unit_px(const Views& views, const Frame& frame);

// What a page's vertices could hide: called when it comes to a slot of the terrain. O(its vertices).
[[nodiscard]] PageExtent extent_of(const Grid& grid, std::uint32_t page, std::uint32_t terrain_slot);

// A visit of the page has ended: what could it hide, and so how soon must it be visited when it is due?
void note_bound(const Pages& pages, Work& work, const Views& views, std::uint32_t slot);

// The same where the ground of the page has been edited.
void renew_bound_of_edited(const Pages& pages, Work& work, const Views& views, std::uint32_t slot);

// What no mesh of the terrain exceeds, whatever it was made for and however it morphs: the largest error, as near as a
// sample that a view shows may be to its eye. Coarse, but finite, and nothing has to be known of the cut. O(1) a view.
[[nodiscard]] double any_mesh_px(const CutState& s);

// No less than the largest error on screen of what waits or morphs by time, as if it were error_bound_px;
// unbounded_px at most. 0: nothing does. offscreen_too: also of pages that are called off-screen. O(awake pages).
[[nodiscard]] double error_bound_px(CutState& s, bool offscreen_too);

} // namespace fjell
