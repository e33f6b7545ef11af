// Moving ground: craters, roads and cuts at run time, with the bound of every frame kept.
//
// A *stamp* says what happens to the samples of an area. Any thread hands stamps in (push_stamp). The frame's thread
// applies them, before it updates streams and cuts (update_edits). From then on all that speaks of the terrain speaks
// of the new ground: cuts, the recursive method, queries, snapshots. A stamp changes heights in the terrain's own
// pages; what it has changed is kept in the edits' block too, so a page that is evicted comes back with its edits.
//
// The bound. In the step that changes heights, spheres are made exact, errors of fine vertices are measured, and errors
// of coarse ones grow by as much as the change can add. So errors nest and bound the edited ground after every step
// (invariants 2 to 4). Later steps measure the coarse errors again; when EditReport::loose is 0 the terrain is the one
// that a bake of the edited heights with the same scales gives (docs/notes/edits.md says where it is not).
//
// Holes. Stamps cut holes and fill them where EditBudget::holes says so and the pack has room (has_room_for_holes()).
// The triangles with a corner in one are not drawn, from the next update of a cut on. Under a hole that was cut the
// ground keeps its height, for fill.
//
// Locks. Where a stamp has locked samples, vertices whose errors are above what is allowed there get codes that keep
// them in every mesh, as those that are baked do (docs/guides/baking.md). They follow the ground that moves. A lock
// holds until the whole terrain is smaller on the screen than 50 thresholds, and where pages are loaded.
//
// Memory: one block of the host's, whose size EditBudget says; nothing is allocated afterwards. A stamp that does not
// fit the budget, the height scale or the pack's codes is refused as a whole, and changes nothing.
// Threads: push_stamp and stamp_state on any; everything else on the frame's. Never waits, never calls into the kernel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fjell/export.h"
#include "fjell/handle.h"
#include "fjell/sample_index.h"
#include "fjell/status.h"
#include "fjell/terrain.h"
#include "fjell/view.h"

FJELL_API_BEGIN
namespace fjell {

struct EditsData; // opaque, lives in the host's memory
class Edits : public Handle<EditsData> {};

enum class StampShape : std::uint32_t {
    raise,   // amount_m is added; negative: taken away
    level,   // to the plane through height_m at the centre, with slope_x and slope_z
    crater,  // a bowl amount_m deep, with a rim of a fifth of that which fades over falloff_m
    path,    // to the line through `points`: a road or a ramp; radius_m is half its width, falloff_m its shoulder
    noise,   // smooth noise of +-amount_m, wavelength_m from hill to hill, is added
    smooth,  // to the mean of a sample and its eight neighbours
    heights, // to `heights`, a raster of its own
    restore, // to the pack's heights, and to its holes
    // Not the heights: the colour map shows `rgb`, and the splat map `material`.
    paint,
    unpaint, // to the pack's maps, bit for bit where it applies wholly
    // A hole is cut: a tunnel's mouth, a shaft; or filled: the ground is as high as it was when it was cut, and under a
    // pack's hole as around it.
    hole,
    fill,
    // No height either. No view draws the ground farther than amount_m from where it is, between samples too: a road
    // within 5 cm, a runway within 0. A pixel's threshold is not asked. Of several locks the strictest counts.
    lock,
    unlock // takes locks of stamps away
};

struct StampPoint {
    double x_m = 0, z_m = 0; // scene axes
    float height_m = 0;
};

inline constexpr std::uint8_t no_material = 255; // of Stamp::material

// What happens to which samples. The shape applies wholly within radius_m of the centre (of the line, for a path), and
// fades out over falloff_m beyond; a lock does not fade out. `heights` and `mask` apply to their rectangle. `hole`,
// `fill`, `lock` and `unlock` apply to samples wholly, where the share is a half or more, or not at all. Only `hole`,
// `fill` and `restore` make holes of ground, or ground of holes. All others leave samples that are holes.
struct Stamp {
    StampShape shape = StampShape::raise;
    double x_m = 0, z_m = 0; // the centre, scene axes
    float radius_m = 0, falloff_m = 0;
    float amount_m = 0;                           // of a lock: 0 or more
    float height_m = 0, slope_x = 0, slope_z = 0; // of `level`: metres up a metre east, and a metre south
    float wavelength_m = 0;
    std::uint32_t seed = 0;
    // Pointed to, not copied: they must stay until stamp_state() says that the stamp is done or refused.
    const StampPoint* points = nullptr; // of a path, in order, 2 to max_path_points; of paint and locks, too
    std::uint32_t point_count = 0;
    SampleIndex first;                  // of the rectangle
    std::int32_t columns = 0, rows = 0; // of the rectangle; 0: none
    const float* heights_m = nullptr;   // `heights`: row by row; NaN leaves a sample as it is
    const std::uint8_t* mask = nullptr; // any shape: 255 applies it wholly, 0 not at all; null: wholly
    // Seconds of EditSettings::now_s in which the ground moves to what the stamp makes of it; 0: it does at once. All
    // that speaks of the ground speaks of where it is by then. Only a stamp that fits into 72 x 72 samples moves, and
    // EditBudget::moving of them at a time; others come at once. Refused on its way, because stamps beside it have
    // taken the codes that it needs, it leaves the ground where it is. One that makes holes, or fills some, comes at
    // once.
    float morph_s = 0;
    float strength = 1; // 0 to 1: the share of all this that happens
    // Of `paint`, which waits for no pages and comes at once. So does a lock.
    std::uint8_t rgb[3] = {0, 0, 0};     // sRGB
    std::uint8_t material = no_material; // the number of a name in the pack's layers; none: the colour map shows
};
inline constexpr std::uint32_t max_path_points = 256;

// What the block has room for. Each is named by what is refused when it is spent.
struct EditBudget {
    std::uint32_t blocks = 1024; // blocks of 32 x 32 samples that differ from the pack, 4.2 KB each
    std::uint32_t stamps = 256;  // handed in and not yet applied
    std::uint32_t areas = 256;   // whose coarse errors wait to be measured again; beyond that areas are merged
    std::uint32_t moving = 4;    // stamps whose ground is on its way (Stamp::morph_s), 42 KB each; 0 to 1,024
    // Blocks of 32 x 32 samples with paint on them, 11 KB each; 0 to 16,777,216. None are kept for a pack without
    // colour and splat maps.
    std::uint32_t paint = 256;
    // May stamps cut holes and fill them? 0.3 KB a block more; and small diamonds beside a hole take longer. Needs a
    // pack with room for it (has_room_for_holes()); create_edits() takes any.
    bool holes = false;
    std::uint32_t locks = 256; // blocks of 32 x 32 samples some of which are locked, 1 KB each; 0 to 16,777,216
};

// Do a pack's codes span what the rim of a hole asks for, the size of the largest triangle over it? They do if it has
// holes, if it was baked with room for them (fjell-bake --room-for-holes yes), and if the diagonal of its tiles is
// shorter than some 120,000 of its height steps. False for a header that check_ranges() refuses.
[[nodiscard]] bool has_room_for_holes(const PackHeader& header);

// Has a pack codes for vertices that every mesh draws? Most have: those baked with locks, with room for them
// (fjell-bake --room-for-locks yes), or whose height steps are not too fine for their extent. None whose errors are
// estimates. Others refuse locks. False for a header that check_ranges() refuses.
[[nodiscard]] bool has_room_for_locks(const PackHeader& header);

using StampId = std::uint64_t; // 0: none

enum class StampState : std::uint32_t {
    unknown, // never handed in, or so long ago that it is forgotten
    waiting, // in the queue, or held: until the pages that it changes are loaded, or errors around it are measured
    applied,
    refused, // StampResult::status says why
    moving   // its ground is on its way (Stamp::morph_s)
};
struct StampResult {
    StampState state = StampState::unknown;
    Status status;
};

// 0 for a header that check_ranges() refuses.
[[nodiscard]] std::size_t edits_bytes(const PackHeader& header, const EditBudget& budget = {});
// One a terrain, after create_terrain and before its cuts begin to update. memory: at least edits_bytes(), aligned to
// 64. Fails with not_supported for a sparse terrain, whose missing tiles have no ground to edit.
Status create_edits(const Terrain& terrain, const EditBudget& budget, std::span<std::byte> memory, Edits& edits);
// The ground stays as it is edited, as long as its pages stay loaded; maps stay painted as long as they are shown. No
// thread may be in stream_provide() or paint_map() of this terrain.
Status destroy_edits(const Edits& edits);

// Any thread. What push_stamp() says of a stamp's numbers: out_of_range with the field's name.
[[nodiscard]] Status check_stamp(const Stamp& stamp);
// Any thread, O(1). Refuses what check_stamp() refuses, and changes nothing; EditBudget::holes and Stamp::shape are at
// fault where no stamp may cut a hole, or fill one, or lock. out_of_slots: the queue is full (EditBudget::stamps).
// Example:
//     fjell::Stamp crater;
//     crater.shape = fjell::StampShape::crater;
//     crater.x_m = hit.position_m.x, crater.z_m = hit.position_m.z;
//     crater.radius_m = 12, crater.falloff_m = 6, crater.amount_m = 5;
//     fjell::StampId id = 0;
//     const fjell::Status pushed = fjell::push_stamp(edits, crater, id);
//     if (!pushed.ok()) std::printf("%s: %s\n", pushed.field, fjell::message(pushed.code));
Status push_stamp(const Edits& edits, const Stamp& stamp, StampId& id);
// Any thread, O(1).
[[nodiscard]] StampResult stamp_state(const Edits& edits, StampId id);

inline constexpr std::uint32_t unlimited_edit_work = 0xffff'ffff;
struct EditSettings {
    // Work items: a piece of 64 x 64 samples of a stamp, a step of one that moves, or a coarse vertex measured again. A
    // stamp between whose pieces there would be a cliff that the pack cannot bound is one item.
    std::uint32_t max_work = unlimited_edit_work;
    std::uint32_t max_time_us = 0; // 0: no limit; overrun by one item at most
    double now_s = 0;              // the host's clock, for Stamp::morph_s; must not run backwards
};

enum EditBudgetBit : std::uint32_t {
    edit_budget_work = 1,
    edit_budget_time = 2,
    edit_budget_blocks = 4,
    edit_budget_paint = 8,
    edit_budget_locks = 16
};

struct EditReport {
    std::uint32_t applied = 0, refused = 0; // stamps, in this call
    std::uint32_t waiting = 0;              // stamps that are not applied yet
    // Of those the ones that wait for pages, or for errors around them. A stream of the terrain loads such pages, after
    // those that its views want; a host with its own loader has to.
    std::uint32_t held = 0;
    std::uint32_t samples = 0;    // that were changed
    std::uint32_t loose = 0;      // areas whose coarse errors are not measured again yet
    std::uint32_t unmeasured = 0; // areas that cannot be before more pages are loaded
    std::uint32_t work = 0;       // items spent
    std::uint32_t blocks = 0;     // of EditBudget::blocks in use
    std::uint32_t exhausted = 0;  // EditBudgetBits that ended the call or refused a stamp
    double apply_us = 0, measure_us = 0;
    std::uint32_t moving = 0; // stamps whose ground is on its way; they are not among the waiting
    std::uint32_t paint = 0;  // of EditBudget::paint in use
    std::uint32_t locks = 0;  // of EditBudget::locks in use
};
// The frame's thread, before update_stream and update_cut: applies stamps, the one nearest to a view first but never
// before an earlier one that overlaps it; then measures errors again, as far as the settings allow.
Status update_edits(const Edits& edits, std::span<const View> views, const EditSettings& settings, EditReport& report);

// What locks cost: vertices whose errors keep them in the mesh of any view that sees the terrain, the pack's own among
// them, in pages that are loaded. Give a cut more room than that (CutBudget::vertices): it gives up all other detail
// first. The frame's thread, O(what it returns); 0 for invalid handles.
[[nodiscard]] std::uint32_t count_always_drawn(const Edits& edits);

// A rectangle of samples whose heights have changed, or that have become holes or ground; both ends belong to it.
struct GroundRect {
    SampleIndex first, last;
};
// What has changed since the consumer's last call, for physics, path finding, or a host's own copy: up to rects.size()
// rectangles, in order. cursor: the consumer's own, 0 at first. Returns how many. lost: more has changed than is
// remembered (the last 1,024 changes), and rects[0] is the whole terrain. A query made afterwards sees the new ground.
// The frame's thread, O(rectangles).
[[nodiscard]] std::uint32_t take_ground_changes(const Edits& edits, std::uint64_t& cursor, std::span<GroundRect> rects,
                                                bool& lost);

} // namespace fjell
FJELL_API_END
