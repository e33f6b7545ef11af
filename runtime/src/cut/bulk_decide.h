// The bulk pass' work on rows of a page (bulk_decide.cpp).
#pragma once

#include "cut/state.h"

namespace fjell {

// Decides the unit's rows: in the phase `centres` those of which its page's masks say what is ready, in `sides` those
// next to active centres. Writes nothing but its page and itself.
void decide_unit(const Pages& pages, const Schedule& schedule, const BulkPass& bulk, const Views& views,
                 BulkUnit& unit);

// Writes the vertices of the unit's rows, of all steps in the page, to their slots. Writes nothing but those, and where
// the rows begin.
void place_unit(const Pages& pages, const BulkPass& bulk, Mesh& mesh, const Views& views, BulkUnit& unit);

} // namespace fjell
