// The true error of a mesh: every triangle against every full-resolution sample under it; and what a method's mesh
// keeps to, without looking at every sample.
#pragma once

#include "fjell/cut.h"
#include "fjell/export.h"
#include "fjell/mesh.h"
#include "fjell/recursive.h"
#include "fjell/sample_index.h"
#include "fjell/terrain.h"
#include "fjell/view.h"

FJELL_API_BEGIN
namespace fjell {

// The largest errors, and where they are.
struct MeasuredError {
    // Less what rounding both heights to float may have added: some 1e-7 of the largest height.
    double max_px = 0;               // largest |height - surface| * lambda / distance(eye, sample)
    double max_m = 0;                // largest |height - surface|
    SampleIndex sample_px, sample_m; // where
    std::uint64_t samples = 0;       // visited, shared edges counted once a triangle
};

// mesh: list or strips. frustum: when given, only samples inside it count. O(samples), for tests and tools.
[[nodiscard]] MeasuredError measure_error(const Terrain& terrain, const MeshView& mesh, const View& view,
                                          const Frustum* frustum = nullptr);

// The error on screen, in pixels, that no sample under a tile of the last update's mesh exceeds (half a quantum of the
// pack apart), as the mesh stands: behind with its work, short of a capacity or of pages, morphing, refined for the
// frustum only. From the errors in the pack, and by measuring where they say little; so it is never below the truth,
// and never below at_least_px, which saves measuring: give the threshold that the update was asked for, or has reached.
// The ground beside a hole that is not drawn counts with the size of what is left out. corner_safe: of what the view
// shows, pixels of the picture too. O(triangles), and where the mesh lags O(samples) at most. For tools and tests.
// unbounded_px: no less can be promised, because the eye touches what is missing; or the handle is refused.
inline constexpr double unbounded_px = 1e7;
[[nodiscard]] double bound_error_px(LiveCut cut, const View& view, bool corner_safe, double at_least_px);
[[nodiscard]] double bound_error_px(RecursiveMethod method, const View& view, bool corner_safe, double at_least_px);

} // namespace fjell
FJELL_API_END
