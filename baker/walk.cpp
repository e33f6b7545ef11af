// Everything is measured in whole numbers: heights are lattice steps, and over a side of 2s cells a plane through three
// of them is a multiple of 1 / 2s at every sample. Sums are taken modulo 2^32; differences fit, so they come out right.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "baker/walk.cpp"
#include <hwy/foreach_target.h> // includes this file once a target

#include <hwy/highway.h>

#include <bit>
#include <algorithm>
#include <cstdlib>

#include "baker/walk.h"

#ifndef FJELL_BAKER_WALK_TRIANGLES
#define FJELL_BAKER_WALK_TRIANGLES
namespace fjell::baker::walk {

using Steps = std::uint32_t; // modulo 2^32

// Calls take(row, count, first, slope) for the rows of samples under each of a vertex' triangles: `count` of them
// against first + slope k, in units of 1 / 2s.
template <typename Take>
[[gnu::always_inline]] inline void side_x(const VertexRow& r, const std::int32_t* v, const Take& take) {
    const std::int32_t s = r.s;
    const auto west = static_cast<Steps>(v[-s]), east = static_cast<Steps>(v[s]), slope = east - west;
    const auto half_triangle = [&](std::ptrdiff_t down) {
        const Steps rise = 2 * static_cast<Steps>(v[down * s]) - west - east;
        Steps first = (west + east) * static_cast<Steps>(s) - slope * static_cast<Steps>(s);
        const std::int32_t* row = v - s;
        for (std::int32_t half = s; half > 0; --half) {
            take(row, 2 * half + 1, first, slope);
            first += rise + slope;
            row += down + 1;
        }
    };
    if (r.before) half_triangle(-r.stride);
    if (r.after) half_triangle(r.stride);
}

template <typename Take>
[[gnu::always_inline]] inline void side_y(const VertexRow& r, const std::int32_t* v, const Take& take) {
    const std::int32_t s = r.s;
    const auto north = static_cast<Steps>(v[-r.stride * s]), south = static_cast<Steps>(v[r.stride * s]);
    const Steps along = south - north, ends = north + south;
    const Steps west_slope = ends - 2 * static_cast<Steps>(v[-s]), east_slope = 2 * static_cast<Steps>(v[s]) - ends;
    for (std::int32_t y = -s + 1; y < s; ++y) {
        const std::int32_t width = s - std::abs(y);
        const std::int32_t* const middle = v + y * r.stride;
        const Steps at = ends * static_cast<Steps>(s) + along * static_cast<Steps>(y);
        if (r.before) take(middle - width, width + 1, at - west_slope * static_cast<Steps>(width), west_slope);
        if (r.after) take(middle, width + 1, at, east_slope);
    }
}

template <typename Take>
[[gnu::always_inline]] inline void centre(const VertexRow& r, const std::int32_t* v, bool falling, const Take& take) {
    const std::int32_t s = r.s, side = 2 * s;
    const auto h = [&](std::ptrdiff_t dx, std::ptrdiff_t dy) { return static_cast<Steps>(v[dy * r.stride + dx]); };
    const Steps nw = h(-s, -s), ne = h(s, -s), sw = h(-s, s), se = h(s, s);
    const Steps west_slope = falling ? se - sw : ne - nw, east_slope = falling ? ne - nw : se - sw;
    const std::int32_t* row = v - s * r.stride - s;
    Steps west = nw * static_cast<Steps>(side);
    for (std::int32_t y = 0; y <= side; ++y, row += r.stride, west += sw - nw) {
        const std::int32_t cut = falling ? y : side - y; // the last of the western triangle, the first of the eastern
        take(row, cut + 1, west, west_slope);
        take(row + cut, side - cut + 1, west + west_slope * static_cast<Steps>(cut), east_slope);
    }
}

template <typename Take>
[[gnu::always_inline]] inline void triangles(const VertexRow& r, std::int32_t i, const Take& take) {
    const std::int32_t* const v = r.first + std::ptrdiff_t{2} * r.s * i;
    switch (r.kind) {
    case PlaneKind::side_x: return side_x(r, v, take);
    case PlaneKind::side_y: return side_y(r, v, take);
    case PlaneKind::centre: return centre(r, v, r.falling != (r.alternate && (i & 1)), take);
    }
}

[[nodiscard]] inline int shift_of(const VertexRow& r) {
    return std::countr_zero(static_cast<unsigned>(2 * r.s));
}

} // namespace fjell::baker::walk
#endif

HWY_BEFORE_NAMESPACE();
namespace fjell::baker::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Whole vectors, whose last lanes may not count. No sum over lanes before the last triangle ends.
void walk_lanes(const VertexRow& row, std::int32_t* worst) {
    const hn::ScalableTag<std::int32_t> d;
    const auto lanes = static_cast<std::int32_t>(hn::Lanes(d));
    static_assert(hn::MaxLanes(hn::ScalableTag<std::int32_t>()) <= walk_slack, "raise walk_slack");
    const int shift = walk::shift_of(row);
    const auto iota = hn::Iota(d, 0);
    for (std::int32_t i = 0; i < row.count; ++i) {
        auto most = hn::Zero(d);
        walk::triangles(row, i,
                        [&](const std::int32_t* from, std::int32_t count, walk::Steps first, walk::Steps slope) HWY_ATTR {
                            const auto rise = hn::Mul(hn::Set(d, static_cast<std::int32_t>(slope)), iota);
                            for (std::int32_t k = 0; k < count; k += lanes) {
                                const auto start = static_cast<std::int32_t>(first + slope * static_cast<walk::Steps>(k));
                                const auto line = hn::Add(hn::Set(d, start), rise);
                                const auto height = hn::ShiftLeftSame(hn::LoadU(d, from + k), shift);
                                const auto off = hn::Abs(hn::Sub(height, line));
                                const auto counts = hn::FirstN(d, static_cast<std::size_t>(count - k));
                                most = hn::Max(most, hn::IfThenElseZero(counts, off));
                            }
                        });
        worst[i] = hn::GetLane(hn::MaxOfLanes(d, most));
    }
}

} // namespace fjell::baker::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace fjell::baker {

HWY_EXPORT(walk_lanes);

void walk_row(const VertexRow& row, std::int32_t* worst) {
    HWY_DYNAMIC_DISPATCH(walk_lanes)(row, worst);
}

void walk_row_scalar(const VertexRow& row, std::int32_t* worst) {
    for (std::int32_t i = 0; i < row.count; ++i) {
        worst[i] = 0;
        walk::triangles(row, i, [&](const std::int32_t* from, std::int32_t count, walk::Steps first, walk::Steps slope) {
            for (std::int32_t k = 0; k < count; ++k) {
                const auto off = static_cast<std::int32_t>((static_cast<walk::Steps>(from[k]) << walk::shift_of(row)) -
                                                           (first + slope * static_cast<walk::Steps>(k)));
                worst[i] = std::max(worst[i], std::abs(off));
            }
        });
    }
}

} // namespace fjell::baker
#endif
