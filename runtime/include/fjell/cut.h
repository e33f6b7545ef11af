// The incremental method: a cut that is kept from frame to frame and pays only for what changes.
//
// The recursive method (fjell/recursive.h) finds the mesh anew in every frame. This method keeps the set of active
// vertices. For every group of 16 vertices it also keeps the slack: how far the eye may still move before a vertex of
// the group could change. A frame visits only the groups whose slack is spent. It activates or deactivates one vertex
// at a time, and the mesh has no crack after any of these steps. The mesh is refined in all directions; the frustum
// decides what is drawn, and what is refined first. CutSettings::offscreen_factor above 1 refines less outside the
// views.
//
// Work is counted in items. An item is one group evaluated, or one vertex activated or deactivated, which includes
// evaluating its group again. A constant bounds the work of an item. A mesh that is built beside the drawn one is
// charged about a sixth of an item for each group, so that an item takes as long there. A limit in microseconds is
// checked before every group.
// When the items or the time of a frame do not suffice, the mesh lags behind the view, and the report says by how many
// pixels. When a capacity does not suffice, the effective threshold rises until it does; it falls again when room is
// free. With morphing the threshold changes gradually.
//
// Memory: one block from the host, of cut_bytes() bytes, touched at creation. Afterwards nothing allocates, locks,
// throws or calls the system. Thread: one at a time; to load and unload pages counts as use.
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

// What a cut may use. Fixed at creation.
struct CutBudget {
    // Slots of the vertex buffer, cut_vertex_bytes each; at least 4 for each tile. The number of page states follows
    // from it (cut_pages()); when those are spent, CutReport::exhausted names this field too.
    std::uint32_t vertices = 1u << 19;
    std::uint32_t triangles = 1u << 20; // slots of the index buffer, cut_triangle_bytes each
    // Triangles lie tile by tile in segments of this many slots. A segment is one draw range. A power of two from 8 to
    // 65,536.
    std::uint32_t segment_triangles = 512;
    std::uint32_t views = 1; // 1 to max_cut_views
    // Jobs that a build may run side by side when CutSettings::jobs are given, 1 to max_cut_workers. Each takes some 20
    // KB for each level of a tile.
    std::uint32_t workers = 1;
    // Vertices may morph. False: CutSettings::morph can only be none, CutMesh::morph is empty, and a vertex slot takes
    // cut_morph_bytes less.
    bool morph = true;
};
// What cut_bytes() takes for a vertex slot, how much of it is for morphing, and what it takes for a triangle slot, a
// page slot of the terrain (TerrainBudget::page_slots) and a page state. Some bits of bookkeeping are not counted.
inline constexpr std::size_t cut_vertex_bytes = 57, cut_morph_bytes = 24, cut_triangle_bytes = 12,
                             cut_page_slot_bytes = 28, cut_page_bytes = 19'716;
// How many pages may have a state at a time. A page has a state while one of its vertices may become active; the
// coarsest page of a tile always has one. As measured, a page holds 100 to 280 active vertices. page_slots, tiles:
// those of the terrain.
[[nodiscard]] constexpr std::uint32_t cut_pages(const CutBudget& budget, std::uint32_t page_slots,
                                                std::uint32_t tiles) {
    const std::uint32_t most = tiles + 256 + budget.vertices / 64;
    return most < page_slots ? most : page_slots;
}

// How a vertex appears and disappears: geomorphing (thesis 5.4.1). With error and time a vertex is activated at
// max_error_px / (1 + nesting)^2, where it lies on the edge that it splits. It has risen to its height at max_error_px.
// By then the ends of that edge no longer move, because errors nest. So the surface is continuous, and the screen bound
// holds. When a view appears, disappears or jumps, the mesh changes at once.
enum class Morph : std::uint8_t {
    none, // vertices appear at their height
    // By distance, in the vertex shader. A vertex that is activated late takes morph_s as well, so it does not pop.
    error,
    // The same, and every vertex takes morph_s: for cameras that move far in a frame.
    time
};

inline constexpr std::uint32_t unlimited_work = 0xffffffff;

inline constexpr double max_offscreen_factor = 100;

// The settings of an update. They may change from frame to frame.
struct CutSettings {
    double max_error_px = 1; // threshold (kappa) in pixels, 0.001 to 1e6, for views without their own
    // A vertex becomes active above max_error_px, and inactive below max_error_px / (1 + hysteresis). In between it
    // stays as it is. A vertex in between whose group is evaluated is activated in the upper half already. 0 to 10.
    // With 0 the mesh at rest is exactly that of the recursive method. With 0.04 it has a twentieth more vertices, and
    // a slow camera takes half of the time.
    double hysteresis = 0;
    bool corner_safe = false; // bound the pixels in the image's corners too
    // Work items that this frame may do. With 0 the mesh does not change. The last step of a build may exceed this by
    // up to 256 items, which are charged to the next frames.
    std::uint32_t max_work = unlimited_work;
    // Groups evaluated, units built and pages looked at. To replay a frame that max_time_us has ended, give the
    // CutReport::visits of that frame.
    std::uint32_t visits = unlimited_work;
    double max_time_us = 0; // time that the update may take; 0: no limit
    Morph morph = Morph::none;
    // How long a vertex that is activated late takes to reach its height, 0.01 to 10.
    double morph_s = 0.25;
    // The host's clock, for timed morphing only. Any finite number will do, Unix time too. While it runs backwards, the
    // cut's own clock does not move.
    double now_s = 0;
    // Ground that no view sees, nor soon will, is refined to max_error_px times this factor, 1 to 100. With 1 all
    // ground is refined alike, so turning costs nothing. A larger factor takes a fraction of the vertices and of the
    // work, but turning costs some. When a view turns, frames look again at the pages that have a state, within their
    // time. Until they have looked at all that a view may see, the reported error is at least the factor times the
    // threshold.
    double offscreen_factor = 1;
    // The host's, used within the call only. At most CutBudget::workers jobs run side by side.
    JobSystem jobs = {};
};
// Whether every number is in its range. update_cut(), rebuild_cut() and update_stream() refuse the settings that this
// refuses.
Status validate(const CutSettings& settings);

// Bits of CutReport::exhausted. Each names the field that did not suffice.
enum CutBudgetBit : std::uint32_t {
    cut_budget_vertices = 1u << 0,  // CutBudget::vertices
    cut_budget_triangles = 1u << 1, // CutBudget::triangles
    cut_budget_work = 1u << 2,      // CutSettings::max_work
    cut_budget_time = 1u << 3       // CutSettings::max_time_us
};
// The name of the field that one bit belongs to, e.g. "CutBudget::vertices".
[[nodiscard]] const char* budget_field(CutBudgetBit bit);

// How much of a capacity is used now, how much was used at most so far, and how much exists.
struct BudgetUse {
    std::uint32_t used = 0, peak = 0, capacity = 0;
};

// What an update has done, and how good the mesh is.
struct CutReport {
    std::uint64_t frame = 0;
    // Items: evaluations + activations + deactivations. A mesh that is built beside the drawn one counts in the frames
    // that build it, six of its groups for an item. Its activations are counted below when it is drawn.
    std::uint32_t work = 0;
    // unlimited_work: the frame had no limit, and chose between following its views and a new mesh.
    std::uint32_t visits = 0;
    std::uint32_t evaluations = 0, activations = 0, deactivations = 0;
    std::uint32_t vertices = 0;                         // active vertices, and the corners of all tiles
    std::uint32_t triangles = 0;                        // of the whole terrain
    std::uint32_t tiles_drawn = 0, triangles_drawn = 0; // of the tiles that some view may see
    // Lag: groups that have work to do, and pages whose groups have yet to be looked at.
    std::uint32_t waiting = 0;
    std::uint32_t blocked = 0; // how many of these wait because a capacity is exhausted
    // Vertices that morph by time. They morph in because they were activated late, or out because their page is
    // evicted.
    std::uint32_t morphing = 0;
    std::uint32_t exhausted = 0; // CutBudgetBits
    // error_px_requested: CutSettings::max_error_px. threshold_px: what the cut refines to; it is larger than requested
    // while a capacity is exhausted. error_bound_px: no sample that a view shows is farther from the surface on screen,
    // whatever waits for items, time, a capacity or a page (Terrain::missing_px).
    // The error bound is the threshold, and more while the mesh lags. After a jump, and when the eye is amid unfinished
    // ground, it is what no mesh of the terrain can exceed: the largest error at the distance of the nearest ground, or
    // at the near plane if that is farther. Then it may be hundreds or thousands of times the threshold; it never
    // exceeds unbounded_px (fjell/measure.h).
    // All thresholds rise alike. In a view that sets View::max_error_px, multiply all three numbers by
    // View::max_error_px / error_px_requested.
    double error_px_requested = 0, error_bound_px = 0, threshold_px = 0;
    // Nothing waits or morphs, and the error bound is the requested one: the screen bound holds.
    bool converged = false;
    bool rebuilt = false;                                      // by rebuild_cut()
    BudgetUse vertex_slots, triangle_slots;                    // triangle slots count in whole segments
    std::uint32_t vertices_changed = 0, triangles_changed = 0; // slots that this update has written
    double prepare_us = 0, refine_us = 0, output_us = 0;
};

struct CutState; // opaque, lives in the host's memory
using LiveCut = Handle<CutState>;

// Bytes that create_cut() needs. 0 for a budget that create_cut() refuses.
[[nodiscard]] std::size_t cut_bytes(const Terrain& terrain, const CutBudget& budget);

// Makes a cut of a terrain. memory: at least cut_bytes(), aligned to 64. It belongs to the host and must outlive the
// cut. When the terrain is destroyed, calls on the cut are refused. Fails with out_of_range if a field of the budget
// is, with budget_too_small if not even the coarsest mesh fits, and with not_supported for a pack in linear order.
// Example:
//     fjell::Status s = fjell::create_cut(terrain, budget, {cut_memory.get(), fjell::cut_bytes(terrain, budget)}, cut);
Status create_cut(const Terrain& terrain, const CutBudget& budget, std::span<std::byte> memory, LiveCut& cut);
// Ends the cut. Streams that were made with it are refused from then on.
Status destroy_cut(LiveCut cut);

// Refines and coarsens the cut for the views, as far as the items go. A vertex is wanted when any view wants it. views:
// 1 to CutBudget::views of them, in any order. Views have no identity: when views change places, or when one comes or
// goes beside an equal one, the update costs nothing. Any other view that comes or goes costs what a move from or to
// the nearest view would.
// In the first frame a frame without limits builds the mesh from nothing, as rebuild_cut() does. Later it does so where
// a jump, a zoom or another threshold makes that the cheaper way; where vertices morph, after every jump of 16 to 32
// cells. With a limit of items or time the ground that the views see is built beside the drawn mesh after such a jump.
// The old mesh is drawn until the new one is complete, which may take several frames; the ground that is not seen
// follows. Such a build needs free slots, at least a quarter of those in use. Otherwise the cut is refined vertex by
// vertex, worst first. Example:
//     if (s.ok()) s = fjell::update_cut(cut, {&view, 1}, {.max_error_px = 1, .max_time_us = 2'000}, report);
//     if (!s.ok()) std::printf("%s: %s\n", s.field, fjell::message(s.code));
Status update_cut(LiveCut cut, std::span<const View> views, const CutSettings& settings, CutReport& report);

// Builds the cut from nothing: for the first frame, after a teleport, for an export. Its time has no limit; it takes
// some nanoseconds for each triangle. The capacities are kept.
Status rebuild_cut(LiveCut cut, std::span<const View> views, const CutSettings& settings, CutReport& report);

// Asks the cut to evict a page: to deactivate all vertices of the page, so that it can be unloaded. This takes several
// updates. With morphing it takes some morph_s, because the vertices morph out first. Call again until `released` is
// true; the page must not be unloaded before. A page that is not loaded is released at once.
Status cut_release_page(LiveCut cut, std::uint32_t tile, std::uint32_t page, bool& released);

// Cancels cut_release_page(): the page stays.
Status cut_cancel_release(LiveCut cut, std::uint32_t tile, std::uint32_t page);

// Any vertex that was activated then has reached its height.
inline constexpr float activated_long_ago_s = -1e30f;
// The clock of the cut, which activated_s and MorphFrame::now_s refer to. It counts from the first update and starts
// again at 0 after this many seconds. Floats represent its steps of 2^-14 s exactly. Use morph_age_s() for an age.
inline constexpr float morph_clock_s = 1024;

// What morphing needs of a vertex. The array runs parallel to MeshView::vertices.
struct MorphVertex {
    float morph_from_m; // height on the hypotenuse that it splits: where it starts
    float error_m;      // its world-space error
    float radius_m;     // of its bounding sphere
    // When it was activated late, on the cut's clock; otherwise activated_long_ago_s.
    float activated_s;
};
static_assert(sizeof(MorphVertex) == 16, "MorphVertex is uploaded: change the renderer's vertex format with it");

// What the vertex shader needs of a view. A vertex has morphed in by t = (start - d) / (start - full), clamped to 0..1.
// d is the distance from the eye to the vertex at full height, start = radius_m + error_m * start_per_error, full =
// radius_m + error_m * full_per_error. Of several views the largest t counts. With timed morphing t is at most
// morph_age_s() / morph_s.
struct MorphView {
    float eye_x, eye_y, eye_z; // scene axes, metres
    float start_per_error, full_per_error;
};
// The shader's inputs for a frame, the same for all vertices.
struct MorphFrame {
    Morph morph = Morph::none;
    std::uint32_t views = 0;
    MorphView view[max_cut_views] = {};
    float now_s = 0, morph_s = 1; // now_s: on the cut's clock
};
// The age of a moment on the cut's clock. A vertex that was activated more than half a turn of the clock ago has
// activated_long_ago_s.
[[nodiscard]] constexpr float morph_age_s(float now_s, float then_s) {
    const float age_s = now_s - then_s;
    return age_s < 0 ? age_s + morph_clock_s : age_s;
}
// The height in metres that the shader gives a vertex. The same expression, for tests, exports and queries.
[[nodiscard]] float morphed_height_m(const Terrain& terrain, const MeshVertex& vertex, const MorphVertex& morph,
                                     const MorphFrame& frame);

// All that a renderer needs of a cut. The spans point into the cut and are valid until its next update.
struct CutMesh {
    MeshView mesh;                      // all slots; the ranges are of the tiles that some view may see
    std::span<const MorphVertex> morph; // one for each vertex slot, or none (CutBudget::morph)
    MorphFrame frame;                   // the shader's other inputs
};
// The mesh of the last update. Empty for a handle that is refused. O(1).
[[nodiscard]] CutMesh cut_mesh(LiveCut cut);

// Slots that were written, as a bit set of 64 slots a word. *_words lists the words that have any bit set.
struct CutChanges {
    std::span<const std::uint64_t> vertex_bits, triangle_bits;
    std::span<const std::uint32_t> vertex_words, triangle_words;
};
// Takes all slots that were written since the last call, however many updates and rebuilds that were. A renderer that
// uploads them has the buffers of CutMesh, unused slots included. Each change is given out once. So if several
// renderers draw a cut, call this once for all, and let a renderer that draws later keep the slots that it has not
// uploaded. The spans are valid until the next update, rebuild or call. O(words listed).
// Example:
//     const fjell::CutChanges changes = fjell::cut_take_changes(cut);
//     fjell::for_each_run(changes.vertex_bits, changes.vertex_words, upload);
[[nodiscard]] CutChanges cut_take_changes(LiveCut cut);

// Calls visit(first, count) for every run of consecutive written slots.
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
