// What a mesh is, seen from outside: its true error at every sample, its cracks, and what pops between two frames.
//
// Knows nothing of how a mesh was found. Corners may lie between samples; the ground is its samples. Errors on screen
// are |sample - surface| * lambda / distance(eye, sample), as fjell/measure.h has them. Complexity: O(samples + faces *
// log faces). Failure: none.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "rivals/rival.h"

namespace fjell::rivals {

struct Look {
    double error_px = 0; // the largest at any sample in view, less what float heights lose
    SampleIndex where;
    std::size_t uncovered = 0; // samples in view that no face covers
    std::size_t in_view = 0;   // faces with an area that no side of the frustum excludes
    std::size_t facing_down = 0;
};
[[nodiscard]] Look look_at(const Ground& ground, std::span<const Face> faces, const View& view);

// The surface's heights at all samples, NaN where nothing is.
[[nodiscard]] std::vector<float> surface_of(const Ground& ground, std::span<const Face> faces);

// Edges that lack their opposite: cracks and T-junctions. Those on the terrain's rim, and of what no view shows, are
// none.
struct Seams {
    std::size_t open_edges = 0;
    double gap_px = 0; // the largest, where a corner meets the middle of an edge
};
[[nodiscard]] Seams seams_of(const Ground& ground, std::span<const Face> faces, const View& view);

// How far the surface moves on screen from one frame to the next, at the sample where it moves most of those that both
// show; NaN: there is no surface.
[[nodiscard]] double popping_px(const Ground& ground, std::span<const float> before, const View& view_before,
                                std::span<const float> after, const View& view_after);

} // namespace fjell::rivals
