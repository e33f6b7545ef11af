// The decision (tree/wanted.h) for the sixteen lanes of a group at once, with how far each is from changing.
//
// For a view, margin = reach - distance in metres: how far the eye may go before the answer can change. Of several
// views the largest counts: a vertex is wanted when any of them wants it. Margins carry rounding of some 2^-21 of
// distance and reach; slack() takes off more than that.
#pragma once

#include <cstdint>

#include "cut/groups.h"
#include "fjell/cut.h"
#include "fjell/terrain.h"
#include "view/wanted.h"

namespace fjell {

// What all groups of a frame share.
struct Decision {
    const float* error_m;       // 256
    const float* radius_factor; // 128
    float base_m, quantum_m;    // HeightScale
    float spacing_x_m, spacing_z_m;
    std::int32_t last_x, last_y; // of the terrain's samples
    std::uint32_t views;
    bool hysteresis;            // keep differs from reach
    Reach reach[max_cut_views]; // for vertices that are not active
    Reach keep[max_cut_views];  // for those that are
};

// Lane n stands at sample (x0 + n dx, y0 + n dy), clamped to the terrain.
struct LaneGroup {
    const VertexRecord* records; // group_lanes, contiguous, all readable
    std::int32_t x0, y0, dx, dy;
    std::int32_t base; // height scale steps
    float unit_m;      // of the level's radii
};

struct LaneMargins {
    alignas(64) float reach_m[group_lanes]; // largest of all views
    alignas(64) float keep_m[group_lanes];
    alignas(64) float span_m[group_lanes]; // distance + reach, for the rounding
    std::uint32_t wanted, kept;            // a bit a lane
};

void evaluate(const Decision& decision, const LaneGroup& group, LaneMargins& margins);
// The same, bit for bit, without vector instructions.
void evaluate_scalar(const Decision& decision, const LaneGroup& group, LaneMargins& margins);

inline constexpr float slack_rounding = 0x1p-19f;

} // namespace fjell
