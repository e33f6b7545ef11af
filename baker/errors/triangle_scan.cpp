// Everything is measured in whole numbers: heights are height scale steps, and over a side of 2s cells a plane through
// three of them is a multiple of 1 / 2s at every sample. Sums are taken modulo 2^32; differences fit, so they come out
// right.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "baker/errors/triangle_scan.cpp"
#include <hwy/foreach_target.h> // includes this file once a target

#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cstdlib>

#include "baker/errors/triangle_scan.h"
#include "shared/compiler.h"

#ifndef FJELL_BAKER_SCAN_TRIANGLES
#define FJELL_BAKER_SCAN_TRIANGLES
namespace fjell::baker::scan {

using Steps = std::uint32_t; // modulo 2^32

// Calls take(row, count, first, slope) for the rows of samples under each of a vertex' triangles: `count` of them
// against first + slope k, in units of 1 / 2s.
template <typename Take>
FJELL_ALWAYS_INLINE inline void side_x(const VertexRow& r, const std::int32_t* v, const Take& take) {
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
FJELL_ALWAYS_INLINE inline void side_y(const VertexRow& r, const std::int32_t* v, const Take& take) {
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
FJELL_ALWAYS_INLINE inline void centre(const VertexRow& r, const std::int32_t* v, bool falling, const Take& take) {
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
FJELL_ALWAYS_INLINE inline void triangles(const VertexRow& r, std::int32_t i, const Take& take) {
    const std::int32_t* const v = r.first + std::ptrdiff_t{2} * r.s * i;
    switch (r.kind) {
    case VertexKind::side_x: return side_x(r, v, take);
    case VertexKind::side_y: return side_y(r, v, take);
    case VertexKind::centre: return centre(r, v, r.falling != (r.alternate && (i & 1)), take);
    }
}

[[nodiscard]] inline int shift_of(const VertexRow& r) {
    return std::countr_zero(static_cast<unsigned>(2 * r.s));
}

} // namespace fjell::baker::scan
#endif

HWY_BEFORE_NAMESPACE();
namespace fjell::baker::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Whole vectors, whose last lanes may not count. No sum over lanes before the last triangle ends.
void scan_lanes(const VertexRow& row, std::int32_t* worst) {
    const hn::ScalableTag<std::int32_t> d;
    const auto lanes = static_cast<std::int32_t>(hn::Lanes(d));
    static_assert(hn::MaxLanes(hn::ScalableTag<std::int32_t>()) <= scan_slack, "raise scan_slack");
    const int shift = scan::shift_of(row);
    const auto iota = hn::Iota(d, 0);
    for (std::int32_t i = 0; i < row.count; ++i) {
        auto most = hn::Zero(d);
        scan::triangles(
            row, i, [&](const std::int32_t* from, std::int32_t count, scan::Steps first, scan::Steps slope) HWY_ATTR {
                const auto rise = hn::Mul(hn::Set(d, static_cast<std::int32_t>(slope)), iota);
                for (std::int32_t k = 0; k < count; k += lanes) {
                    const auto start = static_cast<std::int32_t>(first + slope * static_cast<scan::Steps>(k));
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

// Vertices i, i + 1, ... of a row, one a lane. s is known, so that loops over a triangle unroll.
template <std::int32_t s>
class SmallVertices {
public:
    using D = hn::ScalableTag<std::int32_t>;
    using V = hn::Vec<D>;

    HWY_ATTR SmallVertices(const SmallRow& row, std::int32_t i) : r(row), first(i), most(hn::Zero(D())) {}

    HWY_INLINE V h(std::int32_t column, std::int32_t down) const {
        return hn::LoadU(D(), r.samples.template line_of<2 * s>(column, r.y + down) + first);
    }
    HWY_INLINE V times(V v, std::int32_t k) const { return hn::Mul(v, hn::Set(D(), k)); }
    HWY_INLINE void take(std::int32_t column, std::int32_t down, V line) {
        most = hn::Max(most, hn::Abs(hn::Sub(hn::ShiftLeft<shift>(h(column, down)), line)));
    }

    // middle: the column of the vertices. down: 1 or -1.
    HWY_INLINE void side_x_half(std::int32_t middle, std::int32_t down) {
        const V west = h(middle - s, 0), east = h(middle + s, 0), apex = h(middle, down * s);
        const V ends = hn::Add(west, east), slope = hn::Sub(east, west), rise = hn::Sub(hn::Add(apex, apex), ends);
        for (std::int32_t k = 0; k < s; ++k) {
            const std::int32_t half = s - k;
            V line = hn::Sub(hn::Add(times(ends, s), times(rise, k)), times(slope, half));
            for (std::int32_t x = -half; x <= half; ++x, line = hn::Add(line, slope)) take(middle + x, down * k, line);
        }
    }
    // across: 1 or -1.
    HWY_INLINE void side_y_half(std::int32_t middle, std::int32_t across) {
        const V north = h(middle, -s), south = h(middle, s), apex = h(middle + across * s, 0);
        const V ends = hn::Add(north, south), along = hn::Sub(south, north), rise = hn::Sub(hn::Add(apex, apex), ends);
        for (std::int32_t y = -s + 1; y < s; ++y) {
            V line = hn::Add(times(ends, s), times(along, y));
            for (std::int32_t x = 0; x <= s - std::abs(y); ++x, line = hn::Add(line, rise))
                take(middle + across * x, y, line);
        }
    }
    HWY_INLINE void centre(std::int32_t middle) {
        const V nw = h(middle - s, -s), ne = h(middle + s, -s), sw = h(middle - s, s), se = h(middle + s, s);
        const V north = hn::Sub(ne, nw), south = hn::Sub(se, sw), down = hn::Sub(sw, nw);
        // Squares are cut alternately: both lines are followed, and each lane takes its own.
        const auto turned = hn::And(hn::Iota(D(), first & 1), hn::Set(D(), r.alternate ? 1 : 0));
        const auto falling = hn::Eq(turned, hn::Set(D(), r.falling ? 0 : 1));
        V west = hn::ShiftLeft<shift>(nw);
        for (std::int32_t y = 0; y <= 2 * s; ++y, west = hn::Add(west, down)) {
            V fall = west, rise = west;
            for (std::int32_t x = 0; x <= 2 * s; ++x) {
                take(middle - s + x, y - s, hn::IfThenElse(falling, fall, rise));
                fall = hn::Add(fall, x < y ? south : north);
                rise = hn::Add(rise, x < 2 * s - y ? north : south);
            }
        }
    }

    static constexpr int shift = std::countr_zero(2u * s);
    const SmallRow& r;
    std::int32_t first;
    V most;
};

template <std::int32_t s>
HWY_INLINE void scan_small_lanes_of(const SmallRow& row, std::int32_t* worst) {
    const hn::ScalableTag<std::int32_t> d;
    for (std::int32_t i = 0; i < row.count; i += static_cast<std::int32_t>(hn::Lanes(d))) {
        SmallVertices<s> v(row, i);
        switch (row.kind) {
        case VertexKind::side_x:
            if (row.before) v.side_x_half(s, -1);
            if (row.after) v.side_x_half(s, 1);
            break;
        case VertexKind::side_y: {
            const auto lane = hn::Iota(d, i);
            v.side_y_half(0, -1);
            if (!row.open_west) v.most = hn::IfThenElseZero(hn::Ne(lane, hn::Zero(d)), v.most);
            SmallVertices<s> east(row, i);
            east.side_y_half(0, 1);
            if (!row.open_east) east.most = hn::IfThenElseZero(hn::Ne(lane, hn::Set(d, row.count - 1)), east.most);
            v.most = hn::Max(v.most, east.most);
            break;
        }
        case VertexKind::centre: v.centre(s); break;
        }
        hn::StoreU(v.most, d, worst + i);
    }
}

void scan_small_lanes(const SmallRow& row, std::int32_t* worst) {
    switch (row.samples.period) {
    case 4: return scan_small_lanes_of<2>(row, worst);
    case 8: return scan_small_lanes_of<4>(row, worst);
    default: return scan_small_lanes_of<8>(row, worst);
    }
}

} // namespace fjell::baker::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace fjell::baker {

HWY_EXPORT(scan_lanes);
HWY_EXPORT(scan_small_lanes);

void scan_small_row(const SmallRow& row, std::int32_t* worst) {
    HWY_DYNAMIC_DISPATCH(scan_small_lanes)(row, worst);
}

namespace {

// Sample i of every `period` to line i, `length` values further. Known periods are loaded side by side.
template <std::ptrdiff_t period>
FJELL_ALWAYS_INLINE inline void deal(const std::int32_t* samples, std::ptrdiff_t periods,
                                     std::int32_t* FJELL_RESTRICT to, std::size_t length) {
    for (std::ptrdiff_t k = 0; k < period; k += 4, to += 4 * length) {
        std::int32_t *FJELL_RESTRICT a = to, *FJELL_RESTRICT b = a + length, *FJELL_RESTRICT c = b + length,
                                     *FJELL_RESTRICT d = c + length;
        for (std::ptrdiff_t i = 0; i < periods; ++i) {
            const std::int32_t* const from = samples + i * period + k;
            a[i] = from[0], b[i] = from[1], c[i] = from[2], d[i] = from[3];
        }
    }
}
FJELL_CLONES void deal_fours(const std::int32_t* samples, std::ptrdiff_t periods, std::int32_t* to,
                             std::size_t length) {
    deal<4>(samples, periods, to, length);
}
FJELL_CLONES void deal_eights(const std::int32_t* samples, std::ptrdiff_t periods, std::int32_t* to,
                              std::size_t length) {
    deal<8>(samples, periods, to, length);
}
FJELL_CLONES void deal_sixteens(const std::int32_t* samples, std::ptrdiff_t periods, std::int32_t* to,
                                std::size_t length) {
    deal<16>(samples, periods, to, length);
}

} // namespace

DeinterleavedSamples DeinterleavedSamples::of(const std::int32_t* samples, std::ptrdiff_t stride, std::int32_t periods,
                                              std::int32_t rows, std::int32_t period) {
    DeinterleavedSamples p;
    p.period = period, p.columns = periods + 1, p.rows = rows;
    p.values.resize(front + static_cast<std::size_t>(rows) * static_cast<std::size_t>(period) * p.length());
    for (std::int32_t y = 0; y < rows; ++y, samples += stride) {
        auto* const to =
            p.values.data() + p.front + static_cast<std::size_t>(y) * static_cast<std::size_t>(period) * p.length();
        const auto deal_row = period == 4 ? deal_fours : period == 8 ? deal_eights : deal_sixteens;
        deal_row(samples, periods, to, p.length());
        to[periods] = samples[periods * period];
    }
    return p;
}

void scan_row(const VertexRow& row, std::int32_t* worst) {
    HWY_DYNAMIC_DISPATCH(scan_lanes)(row, worst);
}

void scan_row_scalar(const VertexRow& row, std::int32_t* worst) {
    for (std::int32_t i = 0; i < row.count; ++i) {
        worst[i] = 0;
        scan::triangles(
            row, i, [&](const std::int32_t* from, std::int32_t count, scan::Steps first, scan::Steps slope) {
                for (std::int32_t k = 0; k < count; ++k) {
                    const auto off =
                        static_cast<std::int32_t>((static_cast<scan::Steps>(from[k]) << scan::shift_of(row)) -
                                                  (first + slope * static_cast<scan::Steps>(k)));
                    worst[i] = std::max(worst[i], std::abs(off));
                }
            });
    }
}

} // namespace fjell::baker
#endif
