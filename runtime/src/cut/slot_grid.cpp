#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "cut/slot_grid.cpp"
#include <hwy/foreach_target.h> // includes this file once a target

#include <hwy/highway.h>

#include <bit>
#include <cstddef>

#include "cut/lane_sets.h"
#include "cut/slot_grid.h"

HWY_BEFORE_NAMESPACE();
namespace fjell::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

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

} // namespace fjell::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace fjell {

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

} // namespace fjell
#endif
