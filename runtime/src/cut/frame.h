// One frame of the live cut.
#pragma once

#include "cut/state.h"

namespace fjell {

// No vertex active, every page that is loaded entered, all slots free; and no triangle yet.
void reset(CutState& s);
// After reset(): two triangles a tile, and every tile's root to be looked at.
void begin_at_roots(CutState& s);

// Visits groups, worst first, until nothing is left or the items or the time are spent.
void refine(CutState& s);

} // namespace fjell
