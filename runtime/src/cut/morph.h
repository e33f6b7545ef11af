// Morphing in and out by time: which vertices were activated late, and what has to wait for them.
#pragma once

#include <algorithm>
#include <cmath>

#include "cut/frame.h"
#include "cut/mesh.h"
#include "cut/views.h"

namespace fjell {

// The clock of morphing: the host's, in whole ticks that floats hold, however large its numbers are. Only what passes
// from one update to the next counts; of a gap no more than any morph takes.
inline constexpr std::int32_t ticks_a_second = 1 << 14;
inline constexpr std::int64_t clock_ticks = std::int64_t{ticks_a_second} * static_cast<std::int64_t>(morph_clock_s);
inline constexpr std::int64_t longest_gap_ticks = 16 * ticks_a_second; // CutSettings::morph_s is 10 at most
static_assert(clock_ticks <= 1 << 24, "floats hold 24 bits");

struct MorphClock {
    std::int64_t host_ticks;  // of the last update
    std::int64_t ticks;       // since the first update; an int64 lasts 17 million years
    std::int64_t timed_ticks; // when a vertex last began to morph by time
    // What was activated until then has reached its height, and stays there when the settings change.
    std::int64_t arrived_ticks;
    [[nodiscard]] float now_s() const {
        return static_cast<float>(ticks % clock_ticks) / static_cast<float>(ticks_a_second);
    }
};

struct Evaluation; // evaluate.h

struct Morphing {
    MorphClock clock;
    MorphFrame now, before;
    std::uint32_t ring_size; // Mesh::capacity
    float* late_s;           // activated_s of vertices activated late, a ring: oldest first
    std::uint32_t first_late, late_count;
    std::int64_t arrives_ticks; // of the clock: when what has just gated an activation will have arrived
    std::uint32_t* out;         // vertices that morph out, a ring: those that began first
    std::uint32_t first_out, out_count;
};

// A terrain that ends inside a tile: what would lie beyond the rim stands on it (shared/tree.h), so there a vertex is
// not in the middle of the edge that it splits, and where it would have to start is not on the surface. Those vertices
// do not morph, and neither may any of their ancestors, or one could be half-way when a descendant is at its full
// height. Derivation: a side of step s lies at most s from its parents, centres of step s; these at most s from theirs,
// sides of step 2s. So reaching out by 2s and 3s from sides and centres, whatever holds for a vertex holds for its
// parents.
[[nodiscard]] inline bool stands_near_cut_rim(const Grid& grid, SampleIndex at, int z, bool centre) {
    const Tree& tree = grid.terrain->tree;
    const std::int32_t out = (centre ? 3 : 2) << z;
    return (tree.cut_x != 0 && at.column + out > tree.columns() - 1) ||
           (tree.cut_y != 0 && at.row + out > tree.rows() - 1);
}

// Where a vertex starts: in the middle of the edge that it splits.
[[nodiscard]] inline float flat_height(const Grid& grid, const Mesh& mesh, std::uint32_t vertex, SampleIndex at, int z,
                                       bool centre, std::uint32_t end_a, std::uint32_t end_b) {
    if (stands_near_cut_rim(grid, at, z, centre)) return mesh.vertices[vertex].height_m;
    return (mesh.vertices[end_a].height_m + mesh.vertices[end_b].height_m) * 0.5f;
}

// While an edge's ends still morph, the edge is not where their full heights say: what would split it has to wait.
[[nodiscard]] inline bool is_morphing(const Mesh& mesh, const Morphing& morphing, std::uint32_t slot) {
    return morph_age_s(morphing.now.now_s, mesh.morph[slot].activated_s) < morphing.now.morph_s;
}

// When it will not any more, by the clock: now, if it does not.
[[nodiscard]] inline std::int64_t arrival_ticks(const Mesh& mesh, const Morphing& morphing, std::uint32_t slot) {
    const float age_s = morph_age_s(morphing.now.now_s, mesh.morph[slot].activated_s);
    const float left_s = std::max(morphing.now.morph_s - age_s, 0.0f); // of those of long ago no integer holds it
    return morphing.clock.ticks + static_cast<std::int64_t>(std::ceil(left_s * static_cast<float>(ticks_a_second)));
}

// What waited for a page that was evicted is tried again.
inline void open_gate(Work& work) {
    work.queues.gate_passes = work.queues.sizes[gated_queues + work.queues.gated_turn] == 0 ? 1 : 2;
}

// Vertices of pages that are being evicted morph out: back to the edge that they split, in morph_s.
[[nodiscard]] inline bool morphs_out(const Mesh& mesh, std::uint32_t slot) {
    return (mesh.hole[slot] & morphs_out_bit) != 0;
}

// activated_s of a vertex that is activated now: activated_long_ago_s, unless it must morph by time.
[[nodiscard]] float activation_time_s(const Views& views, Morphing& morphing, const Frame& frame, float x, float y,
                                      float z, float error_m, float radius_m);

// Forgets vertices that have reached their height. What has waited for them is tried again.
void end_morphing_in(Work& work, Morphing& morphing);
// The queue of a group that waits for a vertex that arrives then.
[[nodiscard]] std::uint32_t rising_queue(Queues& queues, std::int64_t arrives_ticks);

// The vertex is active, has no active children and does not morph out yet. To the shader, a vertex that morphs out is
// one that morphs in, from where it stands to the edge, whatever the distance: only its numbers change.
void begin_morphing_out(const Pages& pages, Mesh& mesh, Morphing& morphing, std::uint32_t vertex);

// How long ago a vertex can have begun to morph by time that still hides something, in ticks.
[[nodiscard]] std::int64_t late_ticks(const Pages& pages, const Mesh& mesh, const Morphing& morphing,
                                      const Frame& frame);
// A vertex has begun to morph by time: it hides something until it has arrived.
void note_late(CutState& s, const Evaluation& v);

// Moves the clock on to the host's time. Sets how long vertices take in this frame: CutSettings::morph_s, or less after
// that was raised, or morphing was switched off and on again: no more than the time since the last vertex arrived, so
// that none of those that have arrived is moved back.
void advance_clock(Morphing& morphing, const Frame& frame, bool first);
// Before the clock's numbers return, what was activated the last time round becomes activated_long_ago_s: a cursor
// passes over all slots in half a turn of the clock, a few in a frame. It leaves alone what any morph_s could still
// show.
void retire_times(Mesh& mesh, const Morphing& morphing, std::int64_t ticks_before);

// Computes morph_from_m of every active vertex, which is not kept up to date while nothing morphs. O(active vertices).
void flatten_all(const Pages& pages, Mesh& mesh);

} // namespace fjell
