// One frame's work: which groups are visited in which order, and what a visit does.
//
// A visit evaluates one group and puts it in the list it belongs to then. That is one item; so is every vertex
// activated or deactivated, the first of a visit together with the evaluation of its group.
//
// Of the groups that have been evaluated the worst is changed first. While the mesh lags, two are evaluated for each
// one that is changed; where a capacity is short, all that are due are evaluated before any is changed. A frame that
// begins at rest, with room for all it may want, will probably do all. So it goes from page to page, those first that
// could hide most: it evaluates some sixteen groups, changes the worst of them first, by the same answers, and then
// what has become ready by that. Few of them wait in a queue or are evaluated twice. Each group that is changed is one
// more visit. Where a limit ends such a frame, what it has not changed is due.
#pragma once

#include "cut/state.h"

namespace fjell {

// Visits groups, worst first, until nothing is left or the items or the time are spent.
void refine(CutState& s);

// Groups that still have work, and those of them that wait for a capacity. Of the last refine().
[[nodiscard]] std::uint32_t waiting_groups(const Work& work);
[[nodiscard]] std::uint32_t blocked_groups(const Work& work);

} // namespace fjell
