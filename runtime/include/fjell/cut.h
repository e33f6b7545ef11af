// The incremental method: a cut that lives from frame to frame and pays only for what changes.
//
// The recursive method (fjell/recursive.h) rebuilds the mesh from the roots in every frame. This one keeps the set of
// active vertices and, for every small group of them, its slack: how far the eye may still move before any of them
// could change. A frame visits only groups whose slack is spent, and activates or deactivates one vertex at a time; the
// mesh is free of cracks after every single step. It refines in all directions, unless CutSettings::offscreen_factor
// says otherwise; the frustum decides what is drawn, and what is refined first.
//
// Work is counted in items: one group evaluated, or one vertex activated or deactivated (which includes evaluating its
// group again), each bounded by a constant. A mesh that is built beside the drawn one takes about a sixth of an item
// for each, so that an item takes as long. A limit in microseconds is checked before every group. When a frame's items
// do not suffice, the mesh lags behind the view and the report says by how much. When a capacity does not suffice, the
// effective threshold rises until it does; it falls again when there is room. Where vertices morph it does so
// gradually.
//
// Memory: one piece from the host, cut_bytes() of it, touched at creation; afterwards no allocation, lock, system call
// or exception. Thread: one at a time; loading and unloading pages counts as use.
// Complexity: O(vertices that change + groups whose slack is spent). Failure: update_cut() refuses an invalid view or
// setting and changes nothing.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "fjell/export.h"
#include "fjell/handle.h"
#include "fjell/jobs.h"
#include "fjell/mesh.h"
#include "fjell/status.h"
#include "fjell/terrain.h"
#include "fjell/view.h"

FJELL_API_BEGIN
namespace fjell {

inline constexpr std::uint32_t max_cut_views = 8;

// What a cut may use: fixed at creation.
struct CutBudget {
    // Slots of the vertex buffer, cut_vertex_bytes each; 4 a tile at least. And states of pages (cut_pages()): where
    // those are spent, vertices are.
    std::uint32_t vertices = 1u << 19;
    std::uint32_t triangles = 1u << 20; // slots of the index buffer, cut_triangle_bytes each
    // Triangles lie tile by tile, in segments of this many slots: a segment is one draw range. 8 to 65,536, a power of
    // two.
    std::uint32_t segment_triangles = 512;
    std::uint32_t views = 1; // 1 to max_cut_views
    // Jobs that a build runs side by side at most, where CutSettings::jobs are given: some 20 KB for each level of a
    // tile. 1 to max_cut_workers.
    std::uint32_t workers = 1;
};
// Bytes of cut_bytes() for a slot of each buffer (some bits of bookkeeping not counted), for each page slot of the
// terrain (TerrainBudget::page_slots), and for the state of a page.
inline constexpr std::size_t cut_vertex_bytes = 57, cut_triangle_bytes = 12, cut_page_slot_bytes = 28,
                             cut_page_bytes = 19'716;
// A page has a state while one of its vertices may become active. So many can at a time: as measured, one holds 100 to
// 280 active vertices, but for every tile's coarsest page, which always has a state. page_slots, tiles: the terrain's.
[[nodiscard]] constexpr std::uint32_t cut_pages(const CutBudget& budget, std::uint32_t page_slots,
                                                std::uint32_t tiles) {
    const std::uint32_t most = tiles + 256 + budget.vertices / 64;
    return most < page_slots ? most : page_slots;
}

// How a vertex appears and disappears: geomorphing (thesis 5.4.1). With error and time
// vertices are activated at max_error_px / (1 + nesting)^2, on the edge that they split, and reach their height at
// max_error_px. The ends of that edge no longer move by then, because errors nest; so the surface is continuous and the
// screen bound holds. When a view appears, disappears or jumps, the mesh changes at once.
enum class Morph : std::uint8_t {
    none,  // no morphing: at once
    error, // by distance, in the vertex shader; a vertex that is activated late also takes morph_s, and so does not pop
    time   // the same, and every vertex takes morph_s: for cameras that move far in a frame
};

inline constexpr std::uint32_t unlimited_work = 0xffffffff;

inline constexpr double max_offscreen_factor = 100;

// What an update goes by: may change from frame to frame.
struct CutSettings {
    double max_error_px = 1; // the threshold (kappa), 0.001 to 1e6, of views without their own
    // A vertex is active above max_error_px and inactive below max_error_px / (1 + hysteresis); 0 to 10. Between them
    // it stays as it is, but what is looked at comes up half-way already. 0.04 takes a twentieth more vertices, and
    // half of the time where the camera is slow. 0: at rest the mesh is exactly the recursive method's.
    double hysteresis = 0;
    bool corner_safe = false; // bound pixels in the image's corners too
    // Work items that this frame may do; 0: none, the mesh stands still. What a step of building costs beyond them, 256
    // at most, is charged to the frames that follow.
    std::uint32_t max_work = unlimited_work;
    // Groups, units of building and looks at pages: replays a frame that max_time_us ended.
    std::uint32_t visits = unlimited_work;
    double max_time_us = 0; // time that it may take; 0: no limit
    Morph morph = Morph::none;
    double morph_s = 0.25; // time that a vertex activated late takes to reach its height; 0.01 to 10
    // The host's clock, for timed morphing only: any finite number, years of uptime and Unix time too. While it runs
    // backwards, the cut's clock stands.
    double now_s = 0;
    // What no view sees, nor soon will, is refined to max_error_px times this. 1: as finely as what is seen, so that
    // turning costs nothing; more: a fraction of the vertices and of the work, and turning takes some. Now and then
    // frames look at the pages that have a state, as long as there is time; until all have been looked at that a view
    // may see, the error claimed is this factor times the threshold at least. 1 to 100.
    double offscreen_factor = 1;
    JobSystem jobs = {}; // the host's, used within the call only; CutBudget::workers of it side by side
};
// Every number in its range. update_cut(), rebuild_cut() and update_stream() refuse what this does.
Status validate(const CutSettings& settings);

// Bits of CutReport::exhausted: the field that did not suffice.
enum CutBudgetBit : std::uint32_t {
    cut_budget_vertices = 1u << 0,  // CutBudget::vertices
    cut_budget_triangles = 1u << 1, // CutBudget::triangles
    cut_budget_work = 1u << 2,      // CutSettings::max_work
    cut_budget_time = 1u << 3       // CutSettings::max_time_us
};
// The field that a single bit stands for, e.g. "CutBudget::vertices".
[[nodiscard]] const char* budget_field(CutBudgetBit bit);

// Of a capacity: now, the most so far, and what there is.
struct BudgetUse {
    std::uint32_t used = 0, peak = 0, capacity = 0;
};

// What an update has done, and how good the mesh is.
struct CutReport {
    std::uint64_t frame = 0;
    // Items: evaluations + activations + deactivations. Those of a mesh that is built beside the drawn one are counted
    // in the frames that build it, six for an item; its activations below where it is drawn.
    std::uint32_t work = 0;
    std::uint32_t visits = 0; // unlimited_work: the frame had no limit, and chose the cheaper of two ways
    std::uint32_t evaluations = 0, activations = 0, deactivations = 0;
    std::uint32_t vertices = 0;                         // active, and the corners of all tiles
    std::uint32_t triangles = 0;                        // of the whole terrain
    std::uint32_t tiles_drawn = 0, triangles_drawn = 0; // of tiles that some view may see
    std::uint32_t waiting = 0; // lag: groups that have work to do, and pages whose groups have yet to be looked at
    std::uint32_t blocked = 0; // of those, for want of a capacity
    // Vertices that morph by time: in, because they were activated late, or out, because their page is evicted.
    std::uint32_t morphing = 0;
    std::uint32_t exhausted = 0; // CutBudgetBits
    // Requested: CutSettings::max_error_px. Threshold: what the cut refines to, which is more when a capacity is
    // exhausted. Error bound: no sample that a view shows is farther from the surface on screen, whatever waits for
    // items, time, a capacity or a page (Terrain::missing_px): the threshold, or more while the mesh lags. After a
    // jump, and when the eye stands in what waits, it is what no mesh of the terrain exceeds: the largest error, as
    // near as ground is to the eye or as the near plane, if that is farther; hundreds or thousands of times the
    // threshold, and measure.h's unbounded_px at most. Thresholds of all views rise alike: where View::max_error_px is
    // set, these are for it times View::max_error_px / error_px_requested.
    double error_px_requested = 0, error_bound_px = 0, threshold_px = 0;
    bool converged = false;                 // nothing waits or morphs, error bound == requested: the screen bound holds
    bool rebuilt = false;                   // by rebuild_cut()
    BudgetUse vertex_slots, triangle_slots; // triangle slots in whole segments
    std::uint32_t vertices_changed = 0, triangles_changed = 0; // slots that this update has written
    double prepare_us = 0, refine_us = 0, output_us = 0;
};

struct CutState; // opaque, lives in the host's memory
using LiveCut = Handle<CutState>;

// 0 for a budget that create_cut() refuses.
[[nodiscard]] std::size_t cut_bytes(const Terrain& terrain, const CutBudget& budget);

// memory: at least cut_bytes(), aligned to 64. When terrain is destroyed the cut is refused; planar and hierarchical
// Z-order. Fails with out_of_range when a field of the budget does, with budget_too_small when not even the coarsest
// mesh fits, with not_supported for a pack in linear order.
// Example:
//     fjell::Status s = fjell::create_cut(terrain, budget, {cut_memory.get(), fjell::cut_bytes(terrain, budget)}, cut);
Status create_cut(const Terrain& terrain, const CutBudget& budget, std::span<std::byte> memory, LiveCut& cut);
// Ends the cut. Streams that were given it are refused from then on.
Status destroy_cut(LiveCut cut);

// Refines and coarsens the cut for the views, as far as the items go: a vertex is wanted when any view wants it. views:
// 1 to CutBudget::views of them. A view is what it sees, not its place among them: views that change places, or come
// and go where an equal one stays, cost nothing; any other costs what a move from or to the nearest one would.
// In the first frame, and where a jump, a zoom or another threshold makes that the cheaper way, a frame without limits
// builds the mesh from nothing, as rebuild_cut() does; where vertices morph, after every jump of 16 to 32 cells. With a
// limit of items or time, what the views see after such a jump is built beside what is drawn, which stays until it
// stands: in as many frames as items and time make of it, with what is not seen to follow. That takes slots that are
// free, a quarter of those in use at least; otherwise the cut is refined vertex by vertex, worst first.
// Example:
//     if (s.ok()) s = fjell::update_cut(cut, {&view, 1}, {.max_error_px = 1, .max_time_us = 2'000}, report);
//     if (!s.ok()) std::printf("%s: %s\n", s.field, fjell::message(s.code));
Status update_cut(LiveCut cut, std::span<const View> views, const CutSettings& settings, CutReport& report);

// Builds the cut from scratch: for the first frame, after a teleport, for an export. Not bounded in
// time: some nanoseconds a triangle. Keeps to the capacities.
Status rebuild_cut(LiveCut cut, std::span<const View> views, const CutSettings& settings, CutReport& report);

// Asks the cut to evict this page: to deactivate all its vertices, so that it can be unloaded. This takes several
// updates; with morphing some morph_s, because the vertices morph out first. Call again until `released` is true; a
// page must not be unloaded before. A page that is not loaded is released at once.
Status cut_release_page(LiveCut cut, std::uint32_t tile, std::uint32_t page, bool& released);

// Cancels cut_release_page(): the page stays.
Status cut_cancel_release(LiveCut cut, std::uint32_t tile, std::uint32_t page);

inline constexpr float activated_long_ago_s = -1e30f; // so long ago that any vertex has reached its height
// The cut's own clock, of activated_s and MorphFrame::now_s, counts from its first update and starts again at 0 after
// so many seconds: floats hold its steps of 2^-14 s exactly. An age is morph_age_s().
inline constexpr float morph_clock_s = 1024;

// Vertices of the cut for morphing, one for one with MeshView::vertices.
struct MorphVertex {
    float morph_from_m; // height on the hypotenuse it splits: where it starts
    float error_m;      // its own
    float radius_m;     // of its sphere
    float activated_s;  // on the cut's clock, when it was activated, if late; otherwise activated_long_ago_s
};
static_assert(sizeof(MorphVertex) == 16, "MorphVertex is uploaded: change the renderer's vertex format with it");

// What the vertex shader needs beside them. A vertex has morphed in by t = (start - d) / (start - full), t from 0 to 1,
// where d is the distance from the eye to its full height, start = radius_m + error_m * start_per_error, full =
// radius_m + error_m * full_per_error. Of several views the largest t counts. By time t is at most morph_age_s() /
// morph_s.
struct MorphView {
    float eye_x, eye_y, eye_z; // scene axes, metres
    float start_per_error, full_per_error;
};
// The shader's inputs of a frame, the same for all vertices.
struct MorphFrame {
    Morph morph = Morph::none;
    std::uint32_t views = 0;
    MorphView view[max_cut_views] = {};
    float now_s = 0, morph_s = 1; // now_s: on the cut's clock
};
// How long ago something was on the cut's clock. What was activated more than half a turn of the clock ago is
// activated_long_ago_s.
[[nodiscard]] constexpr float morph_age_s(float now_s, float then_s) {
    const float age_s = now_s - then_s;
    return age_s < 0 ? age_s + morph_clock_s : age_s;
}
// The height that the shader gives a vertex: the same expression, for tests, exports and queries.
[[nodiscard]] float morphed_height_m(const Terrain& terrain, const MeshVertex& vertex, const MorphVertex& morph,
                                     const MorphFrame& frame);

// All that a renderer needs of a cut. Spans point into the cut, and hold until its next update.
struct CutMesh {
    MeshView mesh;                      // all slots; ranges of the tiles that some view may see
    std::span<const MorphVertex> morph; // one a vertex slot
    MorphFrame frame;                   // the shader's other inputs
};
// Of the last update. Empty for a handle that is refused. O(1).
[[nodiscard]] CutMesh cut_mesh(LiveCut cut);

// Slots that were written, 64 to a word; only the words listed hold any.
struct CutChanges {
    std::span<const std::uint64_t> vertex_bits, triangle_bits;
    std::span<const std::uint32_t> vertex_words, triangle_words;
};
// Takes all slots that were written since the last call, however many updates and rebuilds ago that was: whoever
// uploads them has the buffers of CutMesh, those that are not in use included. Once for all renderers of a cut: one
// that draws later than others keeps the slots that it has not uploaded. Valid until the next update, rebuild or call.
// O(words listed).
// Example:
//     const fjell::CutChanges changes = fjell::cut_take_changes(cut);
//     fjell::for_each_run(changes.vertex_bits, changes.vertex_words, upload);
[[nodiscard]] CutChanges cut_take_changes(LiveCut cut);

// Calls visit(first, count) for every run of written slots.
template <typename Visit>
void for_each_run(std::span<const std::uint64_t> bits, std::span<const std::uint32_t> words, const Visit& visit) {
    for (const std::uint32_t word : words)
        for (std::uint64_t left = bits[word]; left != 0;) {
            const auto first = static_cast<std::uint32_t>(std::countr_zero(left));
            const auto count = static_cast<std::uint32_t>(std::countr_one(left >> first));
            visit(word * 64 + first, count);
            left = first + count == 64 ? 0 : left & ~std::uint64_t{0} << (first + count);
        }
}

} // namespace fjell
FJELL_API_END
