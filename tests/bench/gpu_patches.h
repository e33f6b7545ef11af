// The same ground drawn twice, with the same light: as a live cut's mesh, and as CDLOD's patches. What a triangle costs
// the GPU that lies in a buffer, and one that a vertex shader makes of a grid and a texture of heights.
//
// Both are drawn with a shader that has next to nothing to do; the cut does not morph, CDLOD does. Failure:
// io::Failure.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace fjell::bench {

struct PatchPlan {
    std::string one_tile, tiles; // packs of the same square of samples, for CDLOD and for the cut
    std::uint32_t width = 1920, height = 1080;
    double error_px = 2;                  // of the comparison at equal error
    std::vector<std::uint32_t> triangles; // that are to be drawn
    std::size_t repeats = 20;
    bool timers = false; // the GPU's are real
    std::string out;     // folder of the pictures
};

// An array, an object a mesh: "method", "asked" (what was held equal), "error_px" (asked of the method),
// "true_error_px" (at every sample in view), "triangles", "draws", "mesh_bytes" and "height_bytes" on the GPU,
// "select_us" (the CPU's: the cut from nothing, CDLOD's selection), "draw_us" (null without timers), "frame_ms" (with
// glFinish), "picture".
[[nodiscard]] nlohmann::json draw_patches(const PatchPlan& plan);

} // namespace fjell::bench
