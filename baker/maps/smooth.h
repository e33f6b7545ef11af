// The ground that slopes, curvatures and normals are taken from, where a source counts its heights in steps.
//
// Whole metres a metre apart are level ground and walls of 45 degrees, and look like grain in wood. The smooth surface
// lies within half a step of every height, so it rounds to the same numbers, and it bends as little as the method
// finds: means of squares of 2, 4, 8 and 16 samples, the coarsest first; each finer level begins with the coarser one,
// is smoothed once, and is held within the bound of its own means. A mean over many steps says more than half a step:
// there the bound is tighter, or valleys would be filled. Heights themselves stay as they are.
//
// A sample's value follows from its place and the heights around it alone: windows may be cut anywhere, and what two
// of them share is equal bit for bit. Beyond the rim the ground goes on as its point reflection, so an even slope stays
// one. Units: metres. Thread: pure functions. Complexity: O(samples).
#pragma once

#include <cstdint>

#include "baker/heights/statistics.h"
#include "baker/read/source.h"
#include "baker/store/memory.h"

namespace fjell::baker {

// Samples of a window, finite everywhere; rows are `stride` floats apart.
struct HeightWindow {
    const float* heights_m;
    std::ptrdiff_t stride;
    Window at;
};

struct SmoothGround {
    std::int32_t columns = 0, rows = 0; // of the terrain's samples
    float step_m = 0;                   // 0: the heights are the ground
    int levels = 0;                     // of squares, above the samples

    [[nodiscard]] bool smooths() const { return step_m > 0; }
    friend bool operator==(const SmoothGround&, const SmoothGround&) = default;
};
inline constexpr int most_smooth_levels = 4;

// native_step_m: what the source's numbers are multiples of, 0: not known. Steps that many samples' slopes do not show,
// less than a fortieth of the spacing, are not smoothed.
[[nodiscard]] SmoothGround smooth_ground(std::int32_t columns, std::int32_t rows, const double (&spacing_m)[2],
                                         double native_step_m, const HeightStatistics& heights);

// The samples that a window of the smooth surface follows from: `wanted` alone if nothing is smoothed.
[[nodiscard]] Window heights_for_smooth(const SmoothGround& ground, const Window& wanted);
// wanted.area() samples of the surface, row by row. heights: of heights_for_smooth(). ground.smooths().
[[nodiscard]] Buffer<float> smooth_heights(const SmoothGround& ground, const HeightWindow& heights,
                                           const Window& wanted);

} // namespace fjell::baker
