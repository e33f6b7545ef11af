// What locks (locks/locks.h) ask of unsaturated errors. A vertex is raised if a sample that a lock holds lies under
// the square around its diamond, which is more than the diamond and costs few vertices.
//
// error_px: its code counts so many codes more. error_m: if its triangles may be off by more, it gets the code of its
// level's locks, which keeps it in the mesh of any view that sees the terrain (ErrorScale::always()).
#pragma once

#include <cstdint>

#include "baker/errors/step.h"
#include "baker/heights/region.h"
#include "baker/heights/scales.h"
#include "baker/locks/locks.h"

namespace fjell::baker {

struct LockedRegion {
    const Locks& locks;
    const Scales& scales;
    Tree tree;
    Region region;
};

// Codes of the finest step, as leaf_errors() has them, and those of all others, as unsaturated_errors() has them: null
// where there are none. O(samples of the region) where a lock is near, else O(locks).
void raise_locked(const LockedRegion& in, VertexPlanes<std::uint8_t>& finest, Patch<std::uint8_t>* coarser);

// Of a step of a region with saturated errors: vertices with the code of their level's locks or a larger one. Those of
// the southern and the eastern border are the neighbour's, or nobody's at the rim.
[[nodiscard]] std::uint64_t always_drawn(const StepInput& step);

} // namespace fjell::baker
