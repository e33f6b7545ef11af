// One frame of the live cut.
#pragma once

#include "cut/state.h"

namespace fjell {

// As if just created: no vertex active, every page that is loaded entered, all slots free.
void reset(CutState& s);

// Visits blocks, worst first, until nothing is left or the items or the time are spent.
void refine(CutState& s);

} // namespace fjell
