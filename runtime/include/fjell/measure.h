// The true error of a mesh, measured at every full-resolution sample; and a bound of it, which takes less time.
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
    // Both are reduced by what rounding both heights to float may have added: some 1e-7 of the largest height.
    double max_px = 0;               // largest |height - surface| * lambda / distance(eye, sample)
    double max_m = 0;                // largest |height - surface|
    SampleIndex sample_px, sample_m; // where each was found
    std::uint64_t samples = 0;       // samples visited; those on an edge count for each triangle
};

// Measures a mesh, a list or strips. frustum: if given, only the samples inside it count. O(samples), for tests and
// tools.
[[nodiscard]] MeasuredError measure_error(const Terrain& terrain, const MeshView& mesh, const View& view,
                                          const Frustum* frustum = nullptr);

// A bound of the error on screen in pixels: no sample under a tile of the last update's mesh exceeds it by more than
// half a quantum of the pack. It is a bound of the mesh as it is now: if it lags, lacks capacity or pages, morphs, or
// is refined for the frustum only. It is computed from the errors in the pack, and measured where these say little. It
// is never below the truth. It is never below at_least_px either, which saves measuring: pass the requested or the
// reached threshold. Ground beside a hole that is not drawn counts with the size of the ground that is left out.
// corner_safe: also bounds the pixels in the image's corners, for what the view shows. O(triangles), and at most
// O(samples) if the mesh lags. For tools and tests. Returns unbounded_px if nothing smaller can be promised, because
// the eye touches missing ground, or if the handle is refused.
inline constexpr double unbounded_px = 1e7;
[[nodiscard]] double bound_error_px(LiveCut cut, const View& view, bool corner_safe, double at_least_px);
[[nodiscard]] double bound_error_px(RecursiveMethod method, const View& view, bool corner_safe, double at_least_px);

} // namespace fjell
FJELL_API_END
