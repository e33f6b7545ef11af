#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "cut/group_words.cpp"
#include <hwy/foreach_target.h> // includes this file once a target

#include <hwy/highway.h>

#include <bit>
#include <cstddef>
#include <cstring>

#include "cut/group_words.h"

HWY_BEFORE_NAMESPACE();
namespace fjell::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Row = hn::CappedTag<std::uint64_t, 8>;

// even_bits() of 64.
template <typename V>
HWY_INLINE V even_of(V v) {
    const Row d;
    v = hn::And(v, hn::Set(d, 0x5555'5555'5555'5555));
    v = hn::And(hn::Or(v, hn::ShiftRight<1>(v)), hn::Set(d, 0x3333'3333'3333'3333));
    v = hn::And(hn::Or(v, hn::ShiftRight<2>(v)), hn::Set(d, 0x0f0f'0f0f'0f0f'0f0f));
    v = hn::And(hn::Or(v, hn::ShiftRight<4>(v)), hn::Set(d, 0x00ff'00ff'00ff'00ff));
    v = hn::And(hn::Or(v, hn::ShiftRight<8>(v)), hn::Set(d, 0x0000'ffff'0000'ffff));
    return hn::Or(v, hn::ShiftRight<16>(v)); // the upper half is cut off
}

void split_all(const std::uint64_t* rows, std::uint32_t count, std::uint32_t* even, std::uint32_t* odd) {
    const Row d;
    const hn::Rebind<std::uint32_t, Row> half;
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

} // namespace fjell
#endif
