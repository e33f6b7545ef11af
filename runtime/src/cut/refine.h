// One frame's work: which groups are visited in which order, and what a visit does.
//
// A visit evaluates one group and puts it in the list it belongs to then. That is one item; so is every vertex
// activated or deactivated, the first of a visit together with the evaluation of its group.
//
// A frame without a limit that begins at rest, with room for all it may want, need not do the worst first: it will do
// all, and what it comes to keeps the claim in any order. So it goes from page to page, and changes what a page's
// groups call for as soon as they are evaluated, by the same answers. Nothing of that waits in a queue or is evaluated
// twice.
#pragma once

#include "cut/state.h"

namespace fjell {

// Visits groups, worst first unless the order is free, until nothing is left or the items or the time are spent.
void refine(CutState& s);

// Groups that still have work, and those of them that wait for a capacity. Of the last refine().
[[nodiscard]] std::uint32_t waiting_groups(const Work& work);
[[nodiscard]] std::uint32_t blocked_groups(const Work& work);

} // namespace fjell
