// Slots of vertices in rows: the grid that triangles are made from, a page at a time.
//
// Most rows of a page hold nothing - of 32 rows of centres 13 do, in the mean -, so all of this goes from one row that
// does to the next.
#pragma once

#include <cstdint>

#include "cut/bulk.h"

namespace fjell {

// Of at most 64 rows those that have a bit set, a bit each.
[[nodiscard]] std::uint64_t rows_in_use(const std::uint32_t* rows, std::uint32_t count);

// Rows of a page's vertices as the pass has numbered them, from row `first` on.
struct NumberedRows {
    const BulkPage* page;
    std::uint32_t first, count;
};
// The slots of their active vertices, each to its lane: row n's from to + n * stride on. Other lanes, of a group if
// that is the stride or of 32, may be overwritten.
void put_slots(const BulkSlots& slots, const NumberedRows& rows, std::uint32_t* to, std::size_t stride);

// What stands around and in half x half squares of a grid, from (qx, qy) on, are the corners of the finer ones. rows:
// of those finer rows of squares that need theirs, a bit each.
void hand_down(const SlotGrid& from, SlotGrid& to, std::uint32_t qx, std::uint32_t qy, std::uint32_t half,
               std::uint32_t rows);

} // namespace fjell
