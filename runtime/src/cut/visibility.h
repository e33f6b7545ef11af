// Which pages the views see, or soon may: the others need less detail (CutSettings::offscreen_factor).
//
// Views turn and move in every frame, pages are many. So pages, and their parts, are looked at with frustums that are
// wider than the views, and again only when a view has left the middle of them: seldom, and while what is new there is
// still out of sight, so that it is refined before it is seen. A box holds the spheres of all its vertices
// (error_bound.h), and those hold all that depends on them: what is called off-screen shows nothing, in any view.
#pragma once

#include "cut/frame.h"
#include "cut/views.h"

namespace fjell {

struct BulkPass;
struct CutState;

// With what pages are looked at: planes 2 to 5 of frustums wider than a view, through the eye that it had then.
struct LookView {
    Vec3 eye_m, forward;
    Frustum half, most, outer; // by half the margin, three quarters and all of it
    Frustum last;              // and beyond it: what parts leave
};
struct Look {
    LookView of[max_cut_views];
    std::uint32_t count; // 0: nothing is off-screen
};

// With what pages are looked at.
struct Visibility {
    Look now, before;   // of the look that pages are given, and of the one that the others had
    std::uint32_t next; // state of a page that comes next; from Pages::fresh on all have had it
    bool mixed;         // the others had several: looks that did not come to their end
};

// How much coarser than its threshold a view refines what nobody sees: offscreen_factor, or less where a threshold is
// so large that errors off-screen might reach into the picture.
[[nodiscard]] double offscreen_factor(const Frame& frame, const View& view, double threshold_px);

// Begins to look at all pages if a view has left the middle of what they were looked at with, and goes on with some of
// them in each frame, or with as many as its time allows when views are fast. Groups that come into sight, or leave it,
// are due. Not while the bulk pass is under way.
void watch_pages(CutState& s);
// Before a bulk pass beside what is drawn: that looks at the pages that it visits, and the next frames at the others.
void watch_visited_pages(CutState& s);
void watch_visited_page(Pages& pages, Work& work, const Visibility& visibility, std::uint32_t slot);
// May a view see what nobody has looked at for it yet? It is refined to the factor, then.
[[nodiscard]] bool is_overlooking(const Pages& pages, const Views& views, const Visibility& visibility);
// A page that has just got its state.
void watch_page(Pages& pages, Visibility& visibility, std::uint32_t slot);

// May any of a page's vertices, or what depends on them, be seen by a view as it is now?
[[nodiscard]] bool may_be_seen(const Pages& pages, const Views& views, const PageState& page);

} // namespace fjell
