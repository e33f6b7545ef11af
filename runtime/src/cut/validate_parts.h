// Parts of validate_cut() (validate.h).
#pragma once

#include "cut/state.h"
#include "validate.h"

namespace fjell {

// Every group that says it is in a queue is there, once.
[[nodiscard]] Violation validate_queues(const Queues& queues);

// Pages that watch anything are awake, and come up no later than their groups; due pages are in their lists, once.
[[nodiscard]] Violation validate_schedule(const Schedule& schedule, const Queues& queues);

// Triangles, their segments, and the written slots.
[[nodiscard]] Violation validate_mesh(const CutState& s);

} // namespace fjell
