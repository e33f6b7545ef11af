// The bulk pass: the whole cut at once, from nothing, level by level (DESIGN section 6, "From nothing").
//
// One by one an activation costs hundreds of nanoseconds, because everything it touches is somewhere else. Here a row
// of a page is a word: which vertices are ready follows from their parents' words by spreading bits, a group is
// evaluated once, and its vertices take slots in order. Triangles come last, page by page on the way down, when it is
// known which children are active; a page's corners are handed down as a grid of slots, so that no vertex is looked up.
#pragma once

#include "cut/state.h"

namespace fjell {

// The cut must be as reset() leaves it, with its decision set. Activates all that the decision wants. False when a
// capacity does not suffice, named in the report; the cut must then be reset.
[[nodiscard]] bool build_all(CutState& s);

} // namespace fjell
