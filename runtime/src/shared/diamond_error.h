// A vertex' own error, one vertex at a time: the slow way, which handles holes and the terrain's rim. The baker takes
// it there; edits take it for vertices that have either under them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <utility>

#include "shared/record.h"
#include "shared/tree.h"

namespace fjell {

// Codes of errors. on_ground: without what a hole's rim asks for, of triangles that may be drawn: none of their corners
// is a hole.
struct UnsaturatedError {
    std::uint8_t code = 0, on_ground = 0;
};

struct DiamondTerms {
    const ErrorScale& errors;
    double quantum_m;
    double spacing_m[2];
    double ground_pad_m, height_pad_m; // what ways along the ground, and heights, may be longer by
    bool midpoint;                     // ErrorEstimate::midpoint
};

// Does its diamond reach beyond the last column or row?
[[nodiscard]] inline bool straddles_rim(const Tree& tree, SampleIndex v) {
    const std::int32_t s = 1 << Tree::step_log2(v);
    return (v.column + s >= tree.columns() && tree.cut_x != 0) || (v.row + s >= tree.rows() && tree.cut_y != 0);
}

namespace diamonds {

struct TriangleScan {
    double worst_steps = 0;
    bool ground = false, hole = false;
};

[[nodiscard]] inline std::int64_t floor_div(std::int64_t a, std::int64_t b) { // b > 0
    return a >= 0 ? a / b : -((-a + b - 1) / b);
}

// The samples of row y inside the triangle, its edges included: from, to.
[[nodiscard]] inline std::pair<std::int32_t, std::int32_t> row_of(const SampleIndex (&corners)[3], std::int32_t y) {
    std::int64_t from = INT32_MIN, to = INT32_MAX;
    for (int k = 0; k < 3; ++k) { // corners turn one way, so that inside is on the same side of all edges
        const SampleIndex p = corners[k], q = corners[(k + 1) % 3];
        const std::int64_t dx = q.column - p.column, dy = q.row - p.row;
        // dx (y - p.y) - dy (x - p.x) >= 0
        const std::int64_t c = dx * (y - p.row);
        if (dy > 0)
            to = std::min(to, p.column + floor_div(c, dy));
        else if (dy < 0)
            from = std::max(from, p.column - floor_div(c, -dy));
        else if (c < 0)
            return {0, -1};
    }
    return {static_cast<std::int32_t>(from), static_cast<std::int32_t>(to)};
}

// What lies under a triangle whose corners stand anywhere; none where it has no area: that is never drawn.
template <typename Ground>
[[nodiscard]] TriangleScan scan_triangle(const Ground& ground, SampleIndex a, SampleIndex b, SampleIndex c) {
    TriangleScan sum;
    std::int64_t area =
        std::int64_t{b.column - a.column} * (c.row - a.row) - std::int64_t{b.row - a.row} * (c.column - a.column);
    if (area == 0) return sum;
    if (area < 0) std::swap(b, c), area = -area;
    const SampleIndex corners[3] = {a, b, c};
    const double ha = ground.h(a), hb = ground.h(b) - ha, hc = ground.h(c) - ha;
    const double gx = (hb * (c.row - a.row) - hc * (b.row - a.row)) / static_cast<double>(area);
    const double gy = (hc * (b.column - a.column) - hb * (c.column - a.column)) / static_cast<double>(area);
    const auto [y0, y1] = std::minmax({a.row, b.row, c.row});
    for (std::int32_t y = y0; y <= y1; ++y) {
        const auto [x0, x1] = row_of(corners, y);
        const double at_row = ha + gy * (y - a.row);
        for (std::int32_t x = x0; x <= x1; ++x) {
            if (ground.is_void({x, y})) {
                sum.hole = true;
                continue;
            }
            sum.ground = true;
            sum.worst_steps = std::max(sum.worst_steps, std::abs(ground.h({x, y}) - (at_row + gx * (x - a.column))));
        }
    }
    // Squeezed triangles divide by odd numbers: what is left of that is no error.
    if (sum.worst_steps < 0x1p-20) sum.worst_steps = 0;
    return sum;
}

template <typename Ground>
[[nodiscard]] double longest_edge_m(const Ground& ground, const DiamondTerms& in, SampleIndex a, SampleIndex b,
                                    SampleIndex c) {
    const auto edge = [&](SampleIndex p, SampleIndex q) {
        const double dx = std::abs(p.column - q.column) * in.spacing_m[0],
                     dy = std::abs(p.row - q.row) * in.spacing_m[1];
        const double dh = static_cast<double>(ground.h(p) - ground.h(q)) * in.quantum_m;
        return std::sqrt(dx * dx + dy * dy + dh * dh) + 2 * in.ground_pad_m + in.height_pad_m;
    };
    return std::max({edge(a, b), edge(b, c), edge(c, a)}) * (1 + 0x1p-20);
}

} // namespace diamonds

// Of any step. ground: `tree`, h(place) in height scale steps and is_void(place). has(apex): whether the triangle at
// that parent counts.
template <typename Ground, typename Has>
[[nodiscard]] UnsaturatedError diamond_error(const Ground& ground, const DiamondTerms& in, SampleIndex v,
                                             const Has& has) {
    const Tree& tree = ground.tree;
    const Diamond d = diamond(tree, v);
    // At the finest step, and for estimate 2, twice the surface's jump when the vertex is activated: that is what a
    // reader works out. Beside the rim triangles are squeezed, and measured whatever the estimate.
    const bool jump = !straddles_rim(tree, v) && (Tree::step_log2(v) == 0 || in.midpoint);
    double error_m =
        jump ? 0.5 * in.quantum_m * std::abs(2.0 * ground.h(v) - ground.h(d.ends[0]) - ground.h(d.ends[1])) : 0;
    const bool hole_below = ground.is_void(d.ends[0]) || ground.is_void(d.ends[1]);
    double on_ground_m = hole_below || ground.is_void(v) ? 0 : error_m;
    bool any = false;
    for (const SampleIndex apex : d.apexes) {
        if (!has(apex)) continue;
        const SampleIndex a = tree.sample(apex), b = tree.sample(d.ends[0]), c = tree.sample(d.ends[1]);
        const diamonds::TriangleScan sum = diamonds::scan_triangle(ground, a, b, c);
        any = any || sum.ground;
        if (!jump) error_m = std::max(error_m, sum.worst_steps * in.quantum_m);
        if (!jump && !hole_below && !ground.is_void(apex))
            on_ground_m = std::max(on_ground_m, sum.worst_steps * in.quantum_m);
        // A hole's rim is drawn to within the triangle's size.
        if (sum.ground && sum.hole)
            error_m =
                std::max({error_m, sum.worst_steps * in.quantum_m, diamonds::longest_edge_m(ground, in, a, b, c)});
    }
    if (!any) return {};
    return {in.errors.code_up(error_m), in.errors.code_up(on_ground_m)};
}

} // namespace fjell
