// Looking at one group: is there anything to do, and doing it.
#pragma once

#include "cut/state.h"

namespace fjell {

// Both take a group that is held, evaluate it, and put it in the list it belongs to then. That is one item; so is every
// vertex activated or deactivated, the first of a visit together with the look at its group.

// Puts it in the queue that its lanes call for, or in the calendar.
void examine(CutState& s, std::uint32_t group);
// Activates and deactivates what its lanes call for, as far as this frame's items go; deactivations only if they may.
// What is left over keeps the group in a queue; otherwise it goes to the calendar.
void carry_out(CutState& s, std::uint32_t group, bool may_retire);

// The bulk pass: evaluates a group none of whose lanes is active, activates all that are ready and wanted without their
// triangles, and schedules it. Returns them. When vertex slots run out it says so in the report and returns none.
[[nodiscard]] std::uint32_t build_block(CutState& s, std::uint32_t group);

} // namespace fjell
