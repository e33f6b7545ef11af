// The recursive method: the thesis' refinement as it stands (5.4, figures 5.4 to 5.8), from the roots, every frame.
//
// tesselate / meshRefine / evalTriangle / tStripAppend, status integers of frame * 3 + {0, 1, 2}, a vertex buffer with
// an index per vertex, view-frustum culling with the completely-inside short cut. Departures: each leaf is tested
// before it is entered; corners carry their slots; statuses have 16 bits, and which of a vertex' two triangles decides
// it is known beforehand; the short cut works plane by plane; culling is done in double precision, because far spheres
// that just touch a plane do not nest in float; when a capacity does not suffice the frame is done again with a higher
// threshold (the thesis does not say what happens).
//
// Memory: one piece from the host, 6 bytes a vertex of every page slot plus the budget. Thread: one at a time.
// Complexity of update: O(selected vertices), 1.2 to 1.4 times what a recursion costs that has no pages, tiles, holes
// or budgets, and 3 times where a page is missing (docs/notes/recursive-method.md).
// Failure: update() refuses an invalid view or setting and leaves the last mesh as it was; exhaustion sets a bit in the
// report, raises the effective threshold and keeps the mesh valid.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fjell/export.h"
#include "fjell/handle.h"
#include "fjell/mesh.h"
#include "fjell/status.h"
#include "fjell/terrain.h"
#include "fjell/view.h"

FJELL_API_BEGIN
namespace fjell {

// What the method may use: fixed at creation.
struct RecursiveBudget {
    std::uint32_t vertices = 1u << 18; // slots of the vertex buffer, recursive_vertex_bytes each
    std::uint32_t indices = 1u << 20;  // strip or list indices, 4 bytes each
};
inline constexpr std::size_t recursive_vertex_bytes = 20; // of recursive_bytes(), for a slot of the vertex buffer

// What a distance is measured to.
enum class Metric : std::uint8_t {
    isotropic, // Lindstrom: distance from the eye to the vertex' sphere
    depth      // thesis 5.4.1: depth of the sphere's nearest point along the view; needs culling
};

// What an update goes by.
struct RefineSettings {
    double max_error_px = 1; // the threshold (kappa), 0.001 to 1e6; a view may have its own (View::max_error_px)
    Metric metric = Metric::isotropic;
    bool cull = true;         // per vertex, against the six planes
    bool corner_safe = false; // bound pixels in the image's corners too, at the price of more triangles
    Topology topology = Topology::triangles;
};

// Bits of FrameReport::exhausted.
enum BudgetBit : std::uint32_t { budget_vertices = 1u << 0, budget_indices = 1u << 1 };

// What an update has done.
struct FrameReport {
    std::uint64_t frame = 0;
    std::uint32_t vertices = 0; // selected: active vertices and the corners of drawn tiles
    std::uint32_t triangles = 0;
    std::uint32_t tiles = 0;            // drawn
    std::uint32_t vertices_written = 0; // new in the vertex buffer
    std::uint32_t buffer_clearings = 0;
    std::uint32_t restarts = 0;                        // passes thrown away because a capacity did not suffice
    std::uint32_t exhausted = 0;                       // BudgetBits
    double error_px_requested = 0, error_bound_px = 0; // requested: the view's own, or that of the settings
    bool converged = false;                            // error bound == requested
};

struct RecursiveState; // opaque, lives in the host's memory
using RecursiveMethod = Handle<RecursiveState>;

// 0 for a budget that create_recursive() refuses.
[[nodiscard]] std::size_t recursive_bytes(const Terrain& terrain, const RecursiveBudget& budget);

// memory: at least recursive_bytes(), aligned to 64. When terrain is destroyed the method is refused.
// Fails with budget_too_small when 4 vertices and 9 indices a tile do not fit.
Status create_recursive(const Terrain& terrain, const RecursiveBudget& budget, std::span<std::byte> memory,
                        RecursiveMethod& method);
// Ends the method.
Status destroy_recursive(RecursiveMethod method);

// Finds the mesh of a view.
Status update_recursive(RecursiveMethod method, const View& view, const RefineSettings& settings, FrameReport& report);

// Of the last update.
[[nodiscard]] MeshView recursive_mesh(RecursiveMethod method);

} // namespace fjell
FJELL_API_END
