// The recursive method: the refinement of the thesis (5.4, figures 5.4 to 5.8), from the roots, in every frame.
//
// As in the thesis: tesselate / meshRefine / evalTriangle / tStripAppend, status integers of frame * 3 + {0, 1, 2}, a
// vertex buffer with an index per vertex, and view-frustum culling with the completely-inside short cut. Departures
// from the thesis:
// - each leaf is tested before it is entered, and corners carry their slots;
// - statuses have 16 bits, and it is known beforehand which of a vertex' two triangles decides its status;
// - the short cut works plane by plane;
// - culling is done in doubles, because far spheres that just touch a plane do not nest in floats;
// - if a capacity does not suffice, the frame is repeated with a higher threshold; the thesis does not treat this case.
//
// Memory: one block from the host, of 6 bytes for each vertex of every page slot and the budget's own. Thread: one at a
// time.
// Complexity of an update: O(selected vertices), 1.2 to 1.4 times what a recursion costs that has no pages, tiles,
// holes or budgets, and 3 times that where a page is missing (docs/notes/recursive-method.md).
// Failure: update_recursive() refuses an invalid view or setting and leaves the last mesh as it was. An exhausted
// budget sets a bit in the report and raises the effective threshold; the mesh stays valid.
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

// What the method may use. Fixed at creation.
struct RecursiveBudget {
    std::uint32_t vertices = 1u << 18; // slots of the vertex buffer, recursive_vertex_bytes each
    std::uint32_t indices = 1u << 20;  // strip or list indices, 4 bytes each
};
inline constexpr std::size_t recursive_vertex_bytes = 20; // what recursive_bytes() takes for a slot

// What the distance of a vertex is.
enum class Metric : std::uint8_t {
    // From the eye to the vertex' sphere (Lindstrom).
    isotropic,
    // Depth of the sphere's nearest point along the view (thesis 5.4.1). Needs culling.
    depth
};

// The settings of an update.
struct RefineSettings {
    // The threshold (kappa) in pixels, 0.001 to 1e6. A view may have its own (View::max_error_px).
    double max_error_px = 1;
    Metric metric = Metric::isotropic;
    bool cull = true; // cull each vertex against the six planes
    // Bound the pixels in the image's corners too, which takes more triangles.
    bool corner_safe = false;
    Topology topology = Topology::triangles;
};

// Bits of FrameReport::exhausted.
enum BudgetBit : std::uint32_t { budget_vertices = 1u << 0, budget_indices = 1u << 1 };

// What an update has done.
struct FrameReport {
    std::uint64_t frame = 0;
    std::uint32_t vertices = 0; // active vertices and the corners of drawn tiles
    std::uint32_t triangles = 0;
    std::uint32_t tiles = 0;            // drawn
    std::uint32_t vertices_written = 0; // written anew to the vertex buffer
    std::uint32_t buffer_clearings = 0;
    // How often the frame was begun again because a capacity did not suffice.
    std::uint32_t restarts = 0;
    std::uint32_t exhausted = 0; // BudgetBits
    // Requested: the view's own threshold, or that of the settings.
    double error_px_requested = 0, error_bound_px = 0;
    bool converged = false; // the error bound is the requested one
};

struct RecursiveState; // opaque, lives in the host's memory
using RecursiveMethod = Handle<RecursiveState>;

// Bytes that create_recursive() needs. 0 for a budget that create_recursive() refuses.
[[nodiscard]] std::size_t recursive_bytes(const Terrain& terrain, const RecursiveBudget& budget);

// Makes the method. memory: at least recursive_bytes(), aligned to 64; it must outlive the method. When the terrain is
// destroyed, calls on the method are refused. Fails with budget_too_small if 4 vertices and 9 indices for each tile do
// not fit.
Status create_recursive(const Terrain& terrain, const RecursiveBudget& budget, std::span<std::byte> memory,
                        RecursiveMethod& method);
// Ends the method.
Status destroy_recursive(RecursiveMethod method);

// Finds the mesh of a view.
Status update_recursive(RecursiveMethod method, const View& view, const RefineSettings& settings, FrameReport& report);

// The mesh of the last update.
[[nodiscard]] MeshView recursive_mesh(RecursiveMethod method);

} // namespace fjell
FJELL_API_END
