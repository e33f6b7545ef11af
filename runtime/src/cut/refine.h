// One frame's work: which groups are visited in which order, and what a visit does.
//
// A visit evaluates one group and puts it in the list it belongs to then. That is one item; so is every vertex
// activated or deactivated, the first of a visit together with the evaluation of its group.
#pragma once

#include "cut/state.h"

namespace fjell {

// Visits groups, worst first, until nothing is left or the items or the time are spent.
void refine(CutState& s);

// Groups that still have work, and those of them that wait for a capacity. Of the last refine().
[[nodiscard]] std::uint32_t waiting_groups(const Work& work);
[[nodiscard]] std::uint32_t blocked_groups(const Work& work);

} // namespace fjell
