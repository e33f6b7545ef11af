#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "cut/fans.cpp"
#include <hwy/foreach_target.h> // includes this file once a target

#include <hwy/highway.h>

#include <array>
#include <bit>
#include <cstddef>
#include <cstring>

#include "cut/fans.h"
#include "tree/order.h"

// What the targets share.
#ifndef FJELL_FANS_ONCE
#define FJELL_FANS_ONCE
namespace fjell {
namespace {

// Corners of a fan by name: the vertex, and the four around it. Of a centre those are the corners of its square.
enum Corner : std::uint8_t { first, second, third, fourth, vertex };
// Of the triangle in each direction the two corners beside the vertex.
constexpr Corner centre_corners[4][2] = {{first, third}, {fourth, second}, {second, first}, {third, fourth}};
// Of a side: west, east, north, south.
constexpr Corner side_corners[4][2] = {{third, first}, {second, third}, {first, fourth}, {fourth, second}};

struct Fan {
    alignas(64) std::int32_t corner[16]; // of the twelve indices, packed
    std::uint32_t number[4];             // of each triangle, after the first one's slot
    std::uint32_t none[4];               // all ones: it is not drawn
    std::uint32_t count;
};
using Fans = std::array<Fan, 16>;
constexpr Fans make_fans(const Corner (&corners)[4][2]) {
    Fans made{};
    for (std::uint32_t drawn = 0; drawn < 16; ++drawn) {
        Fan& fan = made[drawn];
        for (std::uint32_t d = 0; d < 4; ++d) {
            fan.number[d] = fan.count;
            fan.none[d] = (drawn >> d & 1) - 1;
            if ((drawn >> d & 1) == 0) continue;
            std::int32_t* const at = fan.corner + 3 * std::size_t{fan.count++};
            at[0] = vertex, at[1] = corners[d][0], at[2] = corners[d][1];
        }
    }
    return made;
}
constexpr Fans centre_fans = make_fans(centre_corners), side_fans = make_fans(side_corners);

// Where the corners are: the first two side by side, and the others too or not.
struct CentreCorners {
    const std::uint32_t *slots, *norths, *souths;
    void copy(std::uint32_t i, std::uint32_t (&to)[5]) const {
        to[first] = norths[i], to[second] = norths[i + 1], to[third] = souths[i], to[fourth] = souths[i + 1];
        to[vertex] = slots[i];
    }
};
struct SideCorners {
    const std::uint32_t *slots, *ends, *norths, *souths;
    void copy(std::uint32_t i, std::uint32_t (&to)[5]) const {
        to[first] = ends[i], to[second] = ends[i + 1], to[third] = norths[i], to[fourth] = souths[i];
        to[vertex] = slots[i];
    }
};

inline std::uint32_t drawn_around(const CentreRow& row, std::uint32_t i) {
    return (static_cast<std::uint32_t>(row.sides_y >> i) & 3) | (row.north >> i & 1) << 2 | (row.south >> i & 1) << 3;
}
inline std::uint32_t drawn_around(const SideRow& row, std::uint32_t i) {
    return static_cast<std::uint32_t>((row.up >> 2 * i & 3) | (row.down >> 2 * i & 3) << 2);
}

} // namespace
} // namespace fjell
#endif

HWY_BEFORE_NAMESPACE();
namespace fjell::HWY_NAMESPACE {

#if HWY_MAX_BYTES >= 32 && !HWY_HAVE_SCALABLE
namespace hn = hwy::HWY_NAMESPACE;
using Eight = hn::FixedTag<std::uint32_t, 8>;
using Four = hn::FixedTag<std::uint32_t, 4>;
using Two = hn::FixedTag<std::uint32_t, 2>;

HWY_INLINE auto around(const CentreCorners& at, std::uint32_t i) {
    return hn::Combine(Four(), hn::LoadU(Two(), at.souths + i), hn::LoadU(Two(), at.norths + i));
}
HWY_INLINE auto around(const SideCorners& at, std::uint32_t i) {
    const std::uint64_t others = at.norths[i] | std::uint64_t{at.souths[i]} << 32;
    const auto third_and_fourth = hn::BitCast(Two(), hn::Set(hn::FixedTag<std::uint64_t, 1>(), others));
    return hn::Combine(Four(), third_and_fourth, hn::LoadU(Two(), at.ends + i));
}

// From out.next on; returns how many there are.
template <typename Corners>
HWY_INLINE std::uint32_t write_fan(const FanOut& out, const Corners& at, std::uint32_t i, const Fan& fan) {
    const std::uint32_t v = at.slots[i];
    const auto corners = hn::Combine(Eight(), hn::Set(Four(), v), around(at, i));
    const auto low = hn::TableLookupLanes(corners, hn::SetTableIndices(Eight(), fan.corner));
    const auto high = hn::TableLookupLanes(corners, hn::SetTableIndices(Eight(), fan.corner + 8));
    std::uint32_t* const indices = out.indices + std::size_t{out.next} * 3;
    hn::StoreU(low, Eight(), indices);
    hn::StoreU(hn::LowerHalf(Four(), high), Four(), indices + 8);
    const auto named =
        hn::Or(hn::Add(hn::Set(Four(), out.next), hn::LoadU(Four(), fan.number)), hn::LoadU(Four(), fan.none));
    hn::StoreU(named, Four(), out.triangle_of + std::size_t{v} * 4);
    return fan.count;
}
#else
template <typename Corners>
HWY_INLINE std::uint32_t write_fan(const FanOut& out, const Corners& at, std::uint32_t i, const Fan& fan) {
    std::uint32_t corner[5];
    at.copy(i, corner);
    std::uint32_t* const indices = out.indices + std::size_t{out.next} * 3;
    for (std::uint32_t n = 0; n < 12; ++n) indices[n] = corner[fan.corner[n]];
    std::uint32_t* const named = out.triangle_of + std::size_t{corner[vertex]} * 4;
    for (std::uint32_t d = 0; d < 4; ++d) named[d] = (out.next + fan.number[d]) | fan.none[d];
    return fan.count;
}
#endif

template <typename Corners, typename Row>
HWY_INLINE std::uint32_t fan_row(FanOut& to, const Corners& at, const Row& row, const Fans& fans,
                                 std::uint32_t active) {
    FanOut out = to;
    for (; active != 0 && out.next + 4 <= out.end; active &= active - 1) {
        const auto i = static_cast<std::uint32_t>(std::countr_zero(active));
        out.next += write_fan(out, at, i, fans[drawn_around(row, i)]);
    }
    to.next = out.next;
    return active;
}

// As many as there are: the caller knows that there is room.
template <typename Corners, typename Row>
HWY_INLINE std::uint32_t fan_whole_row(const FanOut& to, std::uint32_t next, const Corners& at, const Row& row,
                                       const Fans& fans, std::uint32_t active) {
    FanOut out = to;
    out.next = next;
    for (; active != 0; active &= active - 1) {
        const auto i = static_cast<std::uint32_t>(std::countr_zero(active));
        out.next += write_fan(out, at, i, fans[drawn_around(row, i)]);
    }
    return out.next;
}

std::uint32_t fan_all_rows(FanOut& to, const FanPage& page, std::uint32_t rows) {
    const FanOut out = to;
    const SlotGrid& g = *page.grid;
    std::uint32_t next = out.next;
    for (; rows != 0; rows &= rows - 1) {
        const auto j = static_cast<std::size_t>(std::countr_zero(rows));
        const std::uint32_t centres = page.centre[j], sides_x = page.side_x[j],
                            sides_y = static_cast<std::uint32_t>(page.side_y[j]) & page.all;
        const auto vertices =
            static_cast<std::uint32_t>(std::popcount(centres) + std::popcount(sides_x) + std::popcount(sides_y));
        if (next + 4 * vertices > out.end) break;
        const std::uint32_t *const corners = g.corner[j], *const south_corners = g.corner[j + 1],
                                   *const slots = g.centre[j + 1] + 1;
        const CentreRow centre_row{slots,           corners,         south_corners,
                                   ~page.side_y[j], ~page.side_x[j], ~page.side_x[j + 1]};
        next = fan_whole_row(out, next, CentreCorners{slots, corners, south_corners}, centre_row, centre_fans, centres);
        const std::uint64_t* const finer = page.finer + 2 * j;
        if (sides_x != 0) {
            const std::uint32_t* const norths = g.centre[j] + 1;
            const SideRow row{g.side_x[j], corners, norths, slots, ~finer[0], ~finer[1]};
            next = fan_whole_row(out, next, SideCorners{g.side_x[j], corners, norths, slots}, row, side_fans, sides_x);
        }
        if (sides_y != 0) {
            // Moved by a column, so that a side's own two come together.
            const auto columns = [&](std::size_t n)
                                     HWY_ATTR { return ~(finer[1 + n] << 1 | page.finer_west[2 * j + n]); };
            const SideRow row{g.side_y[j], slots - 1, corners, south_corners, columns(0), columns(1)};
            next = fan_whole_row(out, next, SideCorners{g.side_y[j], slots - 1, corners, south_corners}, row, side_fans,
                                 sides_y);
        }
    }
    to.next = next;
    return rows;
}

std::uint32_t fan_centre_row(FanOut& out, const CentreRow& row, std::uint32_t active) {
    return fan_row(out, CentreCorners{row.slots, row.norths, row.souths}, row, centre_fans, active);
}
std::uint32_t fan_side_row(FanOut& out, const SideRow& row, std::uint32_t active) {
    return fan_row(out, SideCorners{row.slots, row.ends, row.norths, row.souths}, row, side_fans, active);
}

} // namespace fjell::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace fjell {

HWY_EXPORT(fan_centre_row);
HWY_EXPORT(fan_side_row);
HWY_EXPORT(fan_all_rows);

std::uint32_t fan_centres(FanOut& out, const CentreRow& row, std::uint32_t active) {
    return HWY_DYNAMIC_DISPATCH(fan_centre_row)(out, row, active);
}
std::uint32_t fan_sides(FanOut& out, const SideRow& row, std::uint32_t active) {
    return HWY_DYNAMIC_DISPATCH(fan_side_row)(out, row, active);
}
std::uint32_t fan_rows(FanOut& out, const FanPage& page, std::uint32_t rows) {
    return HWY_DYNAMIC_DISPATCH(fan_all_rows)(out, page, rows);
}

} // namespace fjell
#endif
