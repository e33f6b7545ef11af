#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "cut/bulk_rows.cpp"
#include <hwy/foreach_target.h> // includes this file once a target

#include <hwy/highway.h>

#include <array>
#include <bit>
#include <cstddef>
#include <cstring>

#include "cut/bulk_rows.h"

// What the targets share.
#ifndef FJELL_BULK_ROWS_ONCE
#define FJELL_BULK_ROWS_ONCE
namespace fjell {
namespace {

// Of each set of eight lanes, a bit each, and each lane, how many lanes below it are in the set.
constexpr auto lane_ranks = [] {
    std::array<std::array<std::uint8_t, 8>, 256> ranks{};
    for (std::uint32_t bits = 0; bits < 256; ++bits)
        for (std::uint32_t lane = 0; lane < 8; ++lane)
            ranks[bits][lane] = static_cast<std::uint8_t>(std::popcount(bits & ((1u << lane) - 1)));
    return ranks;
}();

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

namespace hn = hwy::HWY_NAMESPACE;

// --- bits

using LongRow = hn::CappedTag<std::uint64_t, 8>;

// even_bits() of 64.
template <typename V>
HWY_INLINE V even_of(V v) {
    const LongRow d;
    v = hn::And(v, hn::Set(d, 0x5555'5555'5555'5555));
    v = hn::And(hn::Or(v, hn::ShiftRight<1>(v)), hn::Set(d, 0x3333'3333'3333'3333));
    v = hn::And(hn::Or(v, hn::ShiftRight<2>(v)), hn::Set(d, 0x0f0f'0f0f'0f0f'0f0f));
    v = hn::And(hn::Or(v, hn::ShiftRight<4>(v)), hn::Set(d, 0x00ff'00ff'00ff'00ff));
    v = hn::And(hn::Or(v, hn::ShiftRight<8>(v)), hn::Set(d, 0x0000'ffff'0000'ffff));
    return hn::Or(v, hn::ShiftRight<16>(v)); // the upper half is cut off
}

void split_all(const std::uint64_t* rows, std::uint32_t count, std::uint32_t* even, std::uint32_t* odd) {
    const LongRow d;
    const hn::Rebind<std::uint32_t, LongRow> half;
    const auto lanes = static_cast<std::uint32_t>(hn::Lanes(d));
    std::uint32_t n = 0;
    for (; n + lanes <= count; n += lanes) {
        const auto v = hn::LoadU(d, rows + n);
        hn::StoreU(hn::TruncateTo(half, even_of(v)), half, even + n);
        hn::StoreU(hn::TruncateTo(half, even_of(hn::ShiftRight<1>(v))), half, odd + n);
    }
    for (; n < count; ++n) {
        const auto low = static_cast<std::uint32_t>(rows[n]), high = static_cast<std::uint32_t>(rows[n] >> 32);
        even[n] = even_bits(low) | even_bits(high) << 16;
        odd[n] = even_bits(low >> 1) | even_bits(high >> 1) << 16;
    }
}

std::uint32_t count_all(const std::uint32_t* rows, std::uint32_t count) {
    std::uint32_t bits = 0, n = 0;
    for (; n + 2 <= count; n += 2) {
        std::uint64_t two = 0;
        std::memcpy(&two, rows + n, sizeof two);
        bits += static_cast<std::uint32_t>(std::popcount(two));
    }
    return n == count ? bits : bits + static_cast<std::uint32_t>(std::popcount(rows[n]));
}

// Four rows of two groups: eight arrays of eight become eight groups.
void write_all(GroupState* groups, std::uint32_t rows, std::uint32_t a_row, const GroupRows& from) {
    std::uint32_t row = 0;
#if HWY_TARGET != HWY_SCALAR && !HWY_HAVE_SCALABLE
    const hn::FixedTag<std::uint16_t, 8> d;
    const hn::FixedTag<std::uint32_t, 4> d2;
    const hn::FixedTag<std::uint64_t, 2> d4;
    auto* out = reinterpret_cast<std::uint16_t*>(groups);
    const auto load = [&](const std::uint32_t* words) HWY_ATTR { return hn::BitCast(d, hn::LoadU(d2, words + row)); };
    const auto low = [&](auto x, auto y) HWY_ATTR { return hn::BitCast(d2, hn::InterleaveLower(d, x, y)); };
    const auto high = [&](auto x, auto y) HWY_ATTR { return hn::BitCast(d2, hn::InterleaveUpper(d, x, y)); };
    const auto write_two = [&](auto first, auto second) HWY_ATTR {
        const auto x = hn::BitCast(d4, first), y = hn::BitCast(d4, second);
        hn::StoreU(hn::BitCast(d, hn::InterleaveLower(d4, x, y)), d, out);
        hn::StoreU(hn::BitCast(d, hn::InterleaveUpper(d4, x, y)), d, out + 8);
        out += 16;
    };
    const auto write_four = [&](auto w0, auto w1, auto w2, auto w3) HWY_ATTR {
        write_two(hn::InterleaveLower(d2, w0, w1), hn::InterleaveLower(d2, w2, w3));
        write_two(hn::InterleaveUpper(d2, w0, w1), hn::InterleaveUpper(d2, w2, w3));
    };
    for (; a_row == 2 && row + 4 <= rows; row += 4) {
        const auto active = load(from.active), parent0 = load(from.parent[0]), parent1 = load(from.parent[1]),
                   child0 = load(from.child[0]), child1 = load(from.child[1]), child2 = load(from.child[2]),
                   child3 = load(from.child[3]), queue = hn::Zero(d);
        write_four(low(active, parent0), low(parent1, child0), low(child1, child2), low(child3, queue));
        write_four(high(active, parent0), high(parent1, child0), high(child1, child2), high(child3, queue));
    }
#endif
    for (; row < rows; ++row)
        for (std::uint32_t word = 0; word < a_row; ++word) {
            const auto of = [&](const std::uint32_t* words) {
                return static_cast<std::uint16_t>(words[row] >> (group_lanes * word));
            };
            groups[row * a_row + word] = {of(from.active),
                                          {of(from.parent[0]), of(from.parent[1])},
                                          {of(from.child[0]), of(from.child[1]), of(from.child[2]), of(from.child[3])},
                                          unqueued};
        }
}

// --- slots

using Row = hn::CappedTag<std::uint32_t, page_squares / 2>;

std::uint64_t find_rows_in_use(const std::uint32_t* rows, std::uint32_t count) {
    const Row d;
    const auto lanes = static_cast<std::uint32_t>(hn::Lanes(d));
    std::uint64_t used = 0;
    std::uint32_t n = 0;
    for (; n + lanes <= count; n += lanes) {
        std::uint8_t bytes[8] = {};
        hn::StoreMaskBits(d, hn::Ne(hn::LoadU(d, rows + n), hn::Zero(d)), bytes);
        used |= (bytes[0] | std::uint64_t{bytes[1]} << 8) << n;
    }
    for (; n < count; ++n) used |= std::uint64_t{rows[n] != 0} << n;
    return used;
}

// Slots from `slot` on for the lanes whose bits are set, and whatever for the others: no branch to mispredict a vertex.
HWY_INLINE void put_row(std::uint32_t active, std::uint32_t slot, std::uint32_t width, std::uint32_t* out) {
    const hn::CappedTag<std::uint32_t, 8> d;
    const hn::Rebind<std::uint8_t, decltype(d)> bytes;
    const auto lanes = static_cast<std::uint32_t>(hn::Lanes(d));
    for (std::uint32_t group = 0; group < width; group += group_lanes) {
        if ((active >> group & 0xffff) == 0) continue; // its line need not come
        for (std::uint32_t first = group; first < group + group_lanes; first += 8) {
            const std::uint32_t bits = active >> first & 0xff;
            for (std::uint32_t lane = 0; lane < 8; lane += lanes)
                hn::StoreU(hn::Add(hn::Set(d, slot), hn::PromoteTo(d, hn::LoadU(bytes, &lane_ranks[bits][lane]))), d,
                           out + first + lane);
            slot += static_cast<std::uint32_t>(std::popcount(bits));
        }
    }
}

void put_all_slots(const BulkSlots& all, const NumberedRows& rows, std::uint32_t* to, std::size_t stride) {
    const BulkSlots slots = all;
    const std::uint32_t width = stride == group_lanes ? group_lanes : page_squares;
    const std::uint32_t* const active = rows.page->active + rows.first;
    const std::uint16_t* const numbers = rows.page->first + rows.first;
    for (std::uint64_t left = find_rows_in_use(active, rows.count); left != 0; left &= left - 1) {
        const auto row = static_cast<std::size_t>(std::countr_zero(left));
        std::uint32_t* const out = to + row * stride;
        std::uint32_t number = rows.page->number + numbers[row], lanes = active[row];
        if (slots.are_consecutive(number)) {
            put_row(lanes, slots[number], width, out);
            continue;
        }
        for (; lanes != 0; lanes &= lanes - 1) out[std::countr_zero(lanes)] = slots[number++];
    }
}

HWY_INLINE void interleave_row(const std::uint32_t* even, const std::uint32_t* odd, std::uint32_t half,
                               std::uint32_t* out) {
    const Row d;
    const auto lanes = static_cast<std::uint32_t>(hn::Lanes(d));
    std::uint32_t i = 0;
    for (; i + lanes <= half; i += lanes)
        hn::StoreInterleaved2(hn::LoadU(d, even + i), hn::LoadU(d, odd + i), d, out + std::size_t{2} * i);
    for (; i < half; ++i) out[2 * i] = even[i], out[2 * i + 1] = odd[i];
    out[2 * half] = even[half];
}

void hand_rows_down(const SlotGrid& from, SlotGrid& to, std::uint32_t qx, std::uint32_t qy, std::uint32_t half,
                    std::uint32_t rows) {
    // Corners north and south of each row of squares.
    for (std::uint64_t left = rows | std::uint64_t{rows} << 1; left != 0; left &= left - 1) {
        const auto row = static_cast<std::uint32_t>(std::countr_zero(left)), j = qy + row / 2;
        if (row % 2 == 0)
            interleave_row(from.corner[j] + qx, from.side_x[j] + qx, half, to.corner[row]);
        else
            interleave_row(from.side_y[j] + qx, from.centre[j + 1] + qx + 1, half, to.corner[row]);
    }
}

// --- triangles

#if HWY_MAX_BYTES >= 32 && !HWY_HAVE_SCALABLE
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

HWY_EXPORT(split_all);
HWY_EXPORT(count_all);
HWY_EXPORT(write_all);

static_assert(unqueued == 0 && offsetof(GroupState, active) == 0 && offsetof(GroupState, parent) == 2 &&
                  offsetof(GroupState, child) == 6 && offsetof(GroupState, queue) == 14,
              "write_all() writes groups in this order");

void split_rows(const std::uint64_t* rows, std::uint32_t count, std::uint32_t* even, std::uint32_t* odd) {
    HWY_DYNAMIC_DISPATCH(split_all)(rows, count, even, odd);
}
std::uint32_t count_bits(const std::uint32_t* rows, std::uint32_t count) {
    return HWY_DYNAMIC_DISPATCH(count_all)(rows, count);
}
void write_groups(GroupState* groups, std::uint32_t rows, std::uint32_t a_row, const GroupRows& from) {
    HWY_DYNAMIC_DISPATCH(write_all)(groups, rows, a_row, from);
}

HWY_EXPORT(find_rows_in_use);
HWY_EXPORT(put_all_slots);
HWY_EXPORT(hand_rows_down);

std::uint64_t rows_in_use(const std::uint32_t* rows, std::uint32_t count) {
    return HWY_DYNAMIC_DISPATCH(find_rows_in_use)(rows, count);
}
void put_slots(const BulkSlots& slots, const NumberedRows& rows, std::uint32_t* to, std::size_t stride) {
    HWY_DYNAMIC_DISPATCH(put_all_slots)(slots, rows, to, stride);
}
void hand_down(const SlotGrid& from, SlotGrid& to, std::uint32_t qx, std::uint32_t qy, std::uint32_t half,
               std::uint32_t rows) {
    HWY_DYNAMIC_DISPATCH(hand_rows_down)(from, to, qx, qy, half, rows);
}

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
