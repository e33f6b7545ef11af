// The bulk pass' triangles: page by page on the way down, when it is known which vertices are active.
#pragma once

#include "cut/bulk.h"

namespace fjell {

// False: there might not be segments enough.
[[nodiscard]] bool begin_triangles(CutState& s);
// Those of one more page. False: there is none.
[[nodiscard]] bool step_triangles(CutState& s);

} // namespace fjell
