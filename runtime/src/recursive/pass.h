// One pass of the recursive method over all tiles.
#pragma once

#include <cstdint>

#include "recursive/state.h"

namespace fjell {

struct PassResult {
    std::uint32_t selected = 0, triangles = 0, tiles = 0, written = 0, clearings = 0;
    std::uint32_t exhausted = 0; // BudgetBits; when set, the mesh is not usable
};

// Finds the mesh for one threshold, from the roots.
[[nodiscard]] PassResult run_pass(RecursiveState& s, const View& view, const RefineSettings& settings,
                                  double threshold_px);

// A new entry in the vertex buffer, which is cleared of vertices that this pass has not used when it is full: its slot,
// with hole_flag for a hole's, or no_index when all of it is of this pass.
[[nodiscard]] std::uint32_t insert_vertex(RecursiveState& s, std::uint32_t index, const MeshVertex& vertex, bool hole,
                                          PassResult& result);

} // namespace fjell
