// What lies under small diamonds, looked at sample by sample in a window, several diamonds of a row at a time.
#pragma once

#include "edit/window.h"

namespace fjell::edit {

inline constexpr std::int32_t diamond_lanes = 8;

// `count` vertices of a plane, 1 to diamond_lanes, beside each other in a window with all around them loaded.
struct DiamondRow {
    const Cell* first; // the first one's
    int z;             // log2 of their step, 1 to measured_at_once
    VertexKind kind;
    std::int32_t count;
    bool first_from_sw, alternates; // of centres: where the hypotenuse starts, and whether every other one's does not
};
// worst[lane]: the largest difference between samples under a diamond and its triangles, in units of 1 / 2s steps.
void worst_under(const DiamondRow& row, std::int32_t (&worst)[diamond_lanes]);
// The same for the instruction set that the compiler was told: for tests.
void worst_under_scalar(const DiamondRow& row, std::int32_t (&worst)[diamond_lanes]);

} // namespace fjell::edit
