// Morphing in and out by time: which vertices were activated late, and what has to wait for them.
#pragma once

#include <algorithm>
#include <cmath>

#include "cut/state.h"

namespace fjell {

// How far a vertex has morphed in by its distance alone, 0 to 1.
[[nodiscard]] inline float morph_fraction(const MorphFrame& frame, float x, float y, float z, float error_m,
                                          float radius_m) {
    float most = 0;
    for (std::uint32_t i = 0; i < frame.views; ++i) {
        const MorphView& v = frame.view[i];
        const float dx = x - v.eye_x, dy = y - v.eye_y, dz = z - v.eye_z;
        const float distance = std::sqrt(dx * dx + dy * dy + dz * dz);
        const float start = radius_m + error_m * v.q_start, full = radius_m + error_m * v.q_full;
        const float t = start > full ? (start - distance) / (start - full) : distance < start ? 1.0f : 0.0f;
        most = std::max(most, std::min(t, 1.0f));
    }
    return most;
}

// A terrain that ends inside a tile: what would lie beyond the rim stands on it (tree/tree.h), so there a vertex is
// not in the middle of the edge that it splits, and where it would have to start is not on the surface. Those vertices
// do not morph, and neither may any of their ancestors, or one could be half-way when a descendant is at its full
// height. Derivation: a side of step s lies at most s from its parents, centres of step s; these at most s from theirs,
// sides of step 2s. So reaching out by 2s and 3s from sides and centres, whatever holds for a vertex holds for its
// parents.
[[nodiscard]] inline bool stands_near_cut_rim(const Grid& grid, Coord at, int z, bool centre) {
    const Tree& tree = grid.terrain->tree;
    const std::int32_t out = (centre ? 3 : 2) << z;
    return (tree.cut_x != 0 && at.x + out > tree.columns() - 1) || (tree.cut_y != 0 && at.y + out > tree.rows() - 1);
}

// Where a vertex starts: in the middle of the edge that it splits.
[[nodiscard]] inline float flat_height(const Grid& grid, const Mesh& mesh, std::uint32_t vertex, Coord at, int z,
                                       bool centre, std::uint32_t end_a, std::uint32_t end_b) {
    if (stands_near_cut_rim(grid, at, z, centre)) return mesh.vertices[vertex].height_m;
    return (mesh.vertices[end_a].height_m + mesh.vertices[end_b].height_m) * 0.5f;
}

// Displacement on screen below which nobody can see a vertex jump.
inline constexpr float unseen_px = 0.01f;

// activated_s of a vertex that is activated now: long_active_s, unless it must morph by time.
[[nodiscard]] inline float activation_time_s(const Views& views, Morphing& morphing, const Frame& frame, float x,
                                             float y, float z, float error_m, float radius_m) {
    const MorphFrame& now = morphing.now;
    if (now.morph == Morph::none) return long_active_s;
    if (now.morph == Morph::error) {
        // Late: the frame before would have shown it above its edge already.
        const float before = morph_fraction(morphing.before, x, y, z, error_m, radius_m);
        if (before * static_cast<float>(frame.report.threshold_px * views.largest_ratio) <= unseen_px)
            return long_active_s;
    }
    if (morphing.late_count == morphing.ring_size)
        return long_active_s; // cannot be: a slot each; but no reason to fail
    morphing.late_s[(morphing.first_late + morphing.late_count++) % morphing.ring_size] = now.now_s;
    morphing.clock.timed_ticks = morphing.clock.ticks;
    return now.now_s;
}

// While an edge's ends still morph, the edge is not where their full heights say: what would split it has to wait.
[[nodiscard]] inline bool is_morphing(const Mesh& mesh, const Morphing& morphing, std::uint32_t slot) {
    return morph_age_s(morphing.now.now_s, mesh.morph[slot].activated_s) < morphing.now.morph_s;
}

// What waited for a vertex that morphs, or for a page that is evicted, is tried again.
inline void open_gate(Work& work) {
    work.queues.gate_passes = work.queues.sizes[gated_queues + work.queues.gated_turn] == 0 ? 1 : 2;
}

// Forgets vertices that have reached their height.
inline void end_morphing_in(Work& work, Morphing& morphing) {
    while (morphing.late_count != 0 &&
           (morphing.now.morph == Morph::none ||
            morph_age_s(morphing.now.now_s, morphing.late_s[morphing.first_late]) >= morphing.now.morph_s)) {
        morphing.first_late = (morphing.first_late + 1) % morphing.ring_size;
        --morphing.late_count;
        open_gate(work);
    }
}

// Moves the clock on to the host's time.
inline void advance_clock(Morphing& morphing, const Frame& frame, bool first) {
    MorphClock& c = morphing.clock;
    constexpr double most = 0x1p62; // so that a difference of two fits an int64
    const double exact = std::clamp(frame.settings.now_s * static_cast<double>(ticks_a_second), -most, most);
    const auto host = static_cast<std::int64_t>(std::floor(exact + 0.5));
    if (!first) c.ticks += std::clamp<std::int64_t>(host - c.host_ticks, 0, longest_gap_ticks);
    c.host_ticks = host;
}

// Before the clock's numbers return, what was activated the last time round becomes long_active_s: a cursor passes over
// all slots in half a turn of the clock, a few in a frame. It leaves alone what any morph_s could still show.
inline void retire_times(Mesh& mesh, const Morphing& morphing, std::int64_t ticks_before) {
    constexpr std::int64_t round = clock_ticks / 2;
    const std::int64_t now = morphing.clock.ticks;
    if (now == ticks_before || ticks_before - morphing.clock.timed_ticks > round + longest_gap_ticks) return;
    const auto cursor = [&](std::int64_t ticks) {
        return static_cast<std::uint32_t>(ticks % round * static_cast<std::int64_t>(mesh.capacity) / round);
    };
    const auto pass = [&](std::uint32_t first, std::uint32_t end) {
        for (std::uint32_t slot = first; slot < std::min(end, mesh.fresh_vertex); ++slot) {
            MorphVertex& m = mesh.morph[slot];
            if (m.activated_s == long_active_s ||
                morph_age_s(morphing.clock.now_s(), m.activated_s) * static_cast<float>(ticks_a_second) <
                    static_cast<float>(longest_gap_ticks))
                continue;
            m.activated_s = long_active_s;
            mesh.dirty_vertices.mark(slot);
        }
    };
    const std::uint32_t first = cursor(ticks_before), end = cursor(now);
    if (first <= end) return pass(first, end);
    pass(first, mesh.capacity);
    pass(0, end);
}

// Vertices of pages that are being evicted morph out: back to the edge that they split, in morph_s.
[[nodiscard]] inline bool morphs_out(const Mesh& mesh, std::uint32_t slot) {
    return (mesh.hole[slot] & morphs_out_bit) != 0;
}

// The vertex is active, has no active children and does not morph out yet. To the shader, a vertex that morphs out is
// one that morphs in, from where it stands to the edge, whatever the distance: only its numbers change.
inline void begin_morphing_out(const Pages& pages, Mesh& mesh, Morphing& morphing, std::uint32_t vertex) {
    const std::uint32_t slot = pages.vertex_slot[vertex];
    MeshVertex& v = mesh.vertices[slot];
    MorphVertex& m = mesh.morph[slot];
    const float edge_m = m.flat_m;
    m.flat_m = morphed_height_m(pages.grid.handle, v, m, morphing.now);
    v.height_m = edge_m;
    m.error_m = 1e30f; // by distance it has arrived
    m.radius_m = 0;
    m.activated_s = morphing.now.now_s;
    morphing.clock.timed_ticks = morphing.clock.ticks;
    mesh.hole[slot] |= morphs_out_bit;
    mesh.dirty_vertices.mark(slot);
    FJELL_ASSERT(morphing.out_count < morphing.ring_size); // a full ring would forget the first
    morphing.out[(morphing.first_out + morphing.out_count++) % morphing.ring_size] = vertex;
}

} // namespace fjell
