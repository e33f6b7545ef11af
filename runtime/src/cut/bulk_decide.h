// The bulk pass' work on rows of a page (bulk_decide.cpp).
#pragma once

#include "cut/bulk_pages.h"

namespace fjell {

struct CutState;

// Decides the unit's rows: in the phase `centres` those of which its page's masks say what is ready, in `sides` those
// next to active centres. Writes nothing but its page and itself.
void decide_unit(const CutState& s, BulkUnit& unit);

// Writes the vertices of the unit's rows, of all steps in the page, to their slots. Writes nothing but those, and where
// the rows begin.
void place_unit(CutState& s, BulkUnit& unit);

} // namespace fjell
