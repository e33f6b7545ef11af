// The true error of a mesh: every triangle against every full-resolution sample under it.
#pragma once

#include "fjell/coord.h"
#include "fjell/export.h"
#include "fjell/mesh.h"
#include "fjell/terrain.h"
#include "fjell/view.h"

FJELL_API_BEGIN
namespace fjell {

// The largest errors, and where they are.
struct MeasuredError {
    // Less what rounding both heights to float may have added: some 1e-7 of the largest height.
    double max_px = 0;         // largest |height - surface| * lambda / distance(eye, sample)
    double max_m = 0;          // largest |height - surface|
    Coord sample_px, sample_m; // where
    std::uint64_t samples = 0; // visited, shared edges counted once a triangle
};

// mesh: list or strips. frustum: when given, only samples inside it count. O(samples), for tests and tools.
[[nodiscard]] MeasuredError measure_error(const Terrain& terrain, const MeshView& mesh, const View& view,
                                          const Frustum* frustum = nullptr);

} // namespace fjell
FJELL_API_END
