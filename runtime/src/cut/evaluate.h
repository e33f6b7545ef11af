// The decision (view/wanted.h) for the sixteen lanes of a group at once, with how far each is from changing.
//
// For a view, margin = reach - distance in metres: how far the eye may go before the answer can change. Of several
// views the largest counts: a vertex is wanted when any of them wants it. Margins carry rounding of some 2^-21 of
// distance and reach; a slack leaves out more than that.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "cut/views.h"

namespace fjell {

// Lane n stands at sample (x0 + n dx, y0 + n dy), clamped to the terrain.
struct LaneGroup {
    const VertexRecord* records; // group_lanes, contiguous, all readable
    std::int32_t x0, y0, dx, dy;
    std::int32_t base;                 // height scale steps
    float unit_m;                      // of the level's radii
    std::uint32_t inactive, childless; // lanes that may be activated, or deactivated: a bit each. No other is looked at
};

struct LaneAnswers {
    std::uint32_t wanted, kept; // of the lanes that were looked at
    float slack_m;              // the smallest, once each is as the answers want it
    std::uint32_t code;         // their largest error code
};

// Several groups, each by its own decision: side by side they wait less for one another.
void evaluate(const Criterion* const* decisions, const LaneGroup* groups, std::uint32_t count, LaneAnswers* answers);
// The same, bit for bit, a lane at a time, on any machine.
void evaluate_scalar(const Criterion* const* decisions, const LaneGroup* groups, std::uint32_t count,
                     LaneAnswers* answers);
inline void evaluate(const Criterion& decision, const LaneGroup& group, LaneAnswers& answers) {
    const Criterion* const of = &decision;
    evaluate(&of, &group, 1, &answers);
}
inline void evaluate_scalar(const Criterion& decision, const LaneGroup& group, LaneAnswers& answers) {
    const Criterion* const of = &decision;
    evaluate_scalar(&of, &group, 1, &answers);
}

// Vertices of one page and step, wherever they lie in it. picked: of each, from the lowest bit on, its place among the
// page's records (16 bits), and how many steps it stands east and south of the page's corner (8 each); the rest is the
// caller's. There are count of them; then, up to a multiple of group_lanes, any that exist.
struct PickedLanes {
    const VertexRecord* records;
    const std::uint64_t* picked;
    std::uint32_t count;
    std::int32_t x0, y0; // the page's corner
    int z;               // log2 of the step
    std::int32_t base;   // height scale steps
    float unit_m;        // of the level's radii
};
struct PickedAnswers {
    std::uint16_t* wanted; // a bit a vertex
    std::int32_t* ticks;   // of its slack, most_ticks at most
    std::uint32_t code;    // their largest error code
};
// As evaluate() does for lanes that are not active.
void evaluate_picked(const Criterion& decision, const PickedLanes& lanes, float ticks_a_metre, PickedAnswers& answers);
// Writes them, one after the other, as they are before anything is known of the edges that they split. Both must have
// room for a multiple of group_lanes; morph may be null.
void place_picked(const Criterion& decision, const PickedLanes& lanes, MeshVertex* vertices, MorphVertex* morph);

// Rows of one plane of a full page, in planar order: lane n of row j stands 2n steps east and 2j steps south of the
// first.
struct PageRows {
    const VertexRecord* records; // of the first row; all readable
    std::uint32_t stride;        // records from row to row
    std::uint32_t count;
    const std::uint32_t* ready; // a bit a lane, a word a row: no other is looked at
    std::int32_t x0, y0;        // where the first lane stands, in samples
    int z;                      // log2 of the step
    std::int32_t base;          // height scale steps
    float unit_m;               // of the level's radii
};
struct RowAnswers {
    std::uint32_t* wanted; // bits that are set, a word a row
    std::uint16_t* ticks;  // two a row, one for each group: lowered to soon + those of its smallest slack
    std::uint32_t code;    // the largest error code
    std::uint32_t count;   // wanted vertices
    std::uint32_t groups;  // that were looked at
};
// As evaluate_picked(): where it pays to look at a row as it lies.
void evaluate_rows(const Criterion& decision, const PageRows& rows, float ticks_a_metre, RowAnswers& answers);

// Writes the vertices whose bits are set in some planes of a page, all of one level, as place_picked() does, but
// exactly as many as there are. Returns how many. voids: of each, 1 if it has no height, or 0; or nullptr.
std::uint32_t place_rows(const Criterion& decision, const PageRows* planes, std::uint32_t count, MeshVertex* vertices,
                         MorphVertex* morph, std::uint8_t* voids);

// Of the lanes called inactive, the largest error on screen of what each would split, in any view: error_m * unit_px /
// (distance - radius), and no less. unit_px: pixels of a metre at a metre's distance, a number a view.
[[nodiscard]] float worst_px(const Criterion& decision, const LaneGroup& group, const float* unit_px);
[[nodiscard]] float worst_px_scalar(const Criterion& decision, const LaneGroup& group, const float* unit_px);

inline constexpr float apart_rounding = 0x1p-18f; // of distances and radii
inline constexpr float least_apart_m = 1e-6f;     // or what a vertex hides may touch the eye

// Of one vertex: the same numbers as evaluate() gives for its lane, of one answer.
struct Evaluation {
    bool wanted;
    float slack_m;
    float error_m, radius_m;
    std::uint8_t code;
    float x, y, z;
};

[[nodiscard]] inline Evaluation evaluate_vertex(const Pages& pages, const Views& views, std::uint32_t vertex,
                                                const Site& site, bool active) {
    const Criterion& c = criterion_of(pages, views, vertex / group_lanes);
    const VertexRecord record = record_of(pages, vertex);
    const SampleIndex at = site_coord(site);
    const std::int32_t base = pages.state[vertex / group_lanes / max_page_groups].base;
    Evaluation v{};
    v.x = static_cast<float>(std::min(at.column, c.last_x)) * c.spacing_x_m;
    v.z = static_cast<float>(std::min(at.row, c.last_y)) * c.spacing_z_m;
    v.y = c.base_m + static_cast<float>(record.height + base) * c.quantum_m;
    v.error_m = c.error_m[record.error];
    v.code = record.error;
    v.radius_m = pages.grid.level_unit_m[2 * site.z + (site.kind == VertexKind::centre ? 0 : 1)] *
                 c.radius_factor[record.radius & (radius_codes - 1)];
    float margin = -3.4e38f, span = 0;
    for (std::uint32_t i = 0; i < c.views; ++i) {
        const Reach& r = active && c.hysteresis ? c.keep[i] : c.reach[i];
        const float squared = floats::squared_distance(floats::One(), r, v.x, v.y, v.z);
        floats::add_view(squared, std::sqrt(squared), floats::reach_m(floats::One(), r, v.error_m, v.radius_m), margin,
                         span, v.wanted);
        if (c.hysteresis && !active)
            v.wanted = v.wanted ||
                       floats::is_within(squared, floats::reach_m(floats::One(), c.wish[i], v.error_m, v.radius_m));
    }
    v.slack_m = std::max(floats::slack_m(floats::One(), margin, span), 0.0f);
    return v;
}

// What all groups of a page have in common.
struct PageAtHand {
    std::uint32_t first; // of its groups
    const PageState* info;
    const GroupShape* shapes;
    const VertexRecord* records;
};
[[nodiscard]] inline PageAtHand page_at_hand(const Pages& pages, std::uint32_t slot) {
    const PageState& info = pages.state[slot];
    return {slot * max_page_groups, &info, pages.grid.shapes[info.shape].groups, records_of(pages, slot)};
}

// Where a group's lanes stand, and their records: in the page, or gathered.
[[nodiscard]] inline LaneGroup lanes_of(const Pages& pages, const PageAtHand& page, std::uint32_t number,
                                        VertexRecord (&gathered)[group_lanes]) {
    const PageState& info = *page.info;
    const GroupShape& shape = page.shapes[number - page.first];
    const int z = info.z + shape.z;
    const std::int32_t apart = 2 << z;
    LaneGroup lanes{page.records + shape.first,
                    info.x0 + (std::int32_t{shape.x} << z),
                    info.y0 + (std::int32_t{shape.y} << z),
                    shape.along_y ? 0 : apart,
                    shape.along_y ? apart : 0,
                    info.base,
                    pages.grid.level_unit_m[2 * z + (shape.kind == VertexKind::centre ? 0 : 1)],
                    0,
                    0};
    if (shape.lanes != group_lanes || shape.stride != 1 || pages.grid.hz_places) {
        for (std::uint32_t lane = 0; lane < group_lanes; ++lane)
            gathered[lane] = record_of(pages, number * group_lanes + std::min<std::uint32_t>(lane, shape.lanes - 1u));
        lanes.records = gathered;
    }
    return lanes;
}
[[nodiscard]] inline LaneGroup lanes_of(const Pages& pages, std::uint32_t number,
                                        VertexRecord (&gathered)[group_lanes]) {
    return lanes_of(pages, page_at_hand(pages, number / max_page_groups), number, gathered);
}

[[nodiscard]] inline bool seen(const Views& views, const Evaluation& v) {
    return is_seen(views, {v.x, v.y, v.z}, static_cast<double>(v.radius_m));
}

// Worst first: 16 ranks of a factor 2 of screen error over the threshold, and 16 above them for what is seen.
[[nodiscard]] inline std::uint32_t rank_of(const Views& views, const Evaluation& v) {
    float worst = 0;
    for (std::uint32_t i = 0; i < views.criterion.views; ++i) {
        const Reach& r = views.criterion.reach[i];
        const float depth = std::sqrt(floats::squared_distance(floats::One(), r, v.x, v.y, v.z)) - v.radius_m;
        worst = std::max(worst, v.error_m * r.q / std::max(depth, 1e-3f));
    }
    const int log2 = std::clamp(worst < 0x1p15f ? std::ilogb(std::max(worst, 1.0f)) : 15, 0, 15);
    return static_cast<std::uint32_t>(log2) + (seen(views, v) ? 16u : 0u);
}

} // namespace fjell
