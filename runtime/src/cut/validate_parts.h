// Parts of validate_cut() (validate.h).
#pragma once

#include "cut/state.h"
#include "validate.h"

namespace fjell {

// Every group that says it is in a list is there, once and where it says; nodes are in use or free.
[[nodiscard]] Violation validate_lists(const Lists& lists);

// Triangles, their segments, and the written slots.
[[nodiscard]] Violation validate_mesh(const CutState& s);

} // namespace fjell
