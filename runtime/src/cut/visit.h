// Looking at one block: is there anything to do, and doing it.
#pragma once

#include "cut/state.h"

namespace fjell {

// Both take a block that is held, evaluate it (one item), and put it in the list it belongs to then.

// Puts it in the queue that its lanes call for, or in the calendar.
void examine(CutState& s, std::uint32_t block);
// Activates and deactivates what its lanes call for, as far as this frame's items go; deactivations only if they may.
// What is left over keeps the block in a queue; otherwise it goes to the calendar.
void carry_out(CutState& s, std::uint32_t block, bool may_retire);

} // namespace fjell
