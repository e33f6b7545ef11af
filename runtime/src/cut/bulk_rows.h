// Rows of a page, in the machine's vectors: what the bulk pass does to masks, slots and triangles beside deciding.
#pragma once

#include <cstdint>

#include "cut/bulk.h"

namespace fjell {

// --- bits

// Bits 0, 2, 4 ... and 1, 3, 5 ... of each row, side by side.
void split_rows(const std::uint64_t* rows, std::uint32_t count, std::uint32_t* even, std::uint32_t* odd);

[[nodiscard]] std::uint32_t count_bits(const std::uint32_t* rows, std::uint32_t count);

// What rows of a plane hold, but for their groups' queues: a word a row.
struct GroupRows {
    const std::uint32_t *active, *parent[2], *child[4];
};
// Writes their groups, in no queue. a_row: 1 or 2, of 16 bits each.
void write_groups(GroupState* groups, std::uint32_t rows, std::uint32_t a_row, const GroupRows& from);

// --- slots of vertices in rows: the grid that triangles are made from, a page at a time. Most rows of a page hold
// nothing - of 32 rows of centres 13 do, in the mean -, so all of this goes from one row that does to the next.

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

// --- triangles around rows of vertices, written one after the other: what emitting a mesh comes down to
//
// A vertex has up to four, towards its four children; one is drawn where that child is not active. All four are
// written, packed, the next over one that is not drawn, so that no branch can be mispredicted. Where the machine has
// vectors of eight, a vertex and the corners around it are one, and a permutation of it for each of the 16 sets of
// drawn triangles gives the twelve indices.

// Where triangles go: slots from `next` on. Around a vertex there may be four, so the last before `end` stay empty.
struct FanOut {
    std::uint32_t *indices, *triangle_of; // Mesh's
    std::uint32_t next, end;
};

// Centres of a row of squares, by their numbers in the row: their slots, and those of the corners to the north and the
// south (one more). Bits: that the triangle towards that side is drawn; sides_y has one more.
struct CentreRow {
    const std::uint32_t *slots, *norths, *souths;
    std::uint64_t sides_y;
    std::uint32_t north, south;
};
// A row of sides: their slots, those to the west and, one on, to the east, and those to the north and south. up, down:
// two bits a side, that the triangles north and south of it, west then east, are drawn.
struct SideRow {
    const std::uint32_t *slots, *ends, *norths, *souths;
    std::uint64_t up, down;
};

// The triangles around the vertices whose bits are set, from the lowest on, while there is room for four. Returns the
// bits that are left. triangle_of says where each is, or no_index.
[[nodiscard]] std::uint32_t fan_centres(FanOut& out, const CentreRow& row, std::uint32_t active);
[[nodiscard]] std::uint32_t fan_sides(FanOut& out, const SideRow& row, std::uint32_t active);

// A page's rows of squares, all three kinds of vertices: row j's centres, its sides to the north, and those to the west
// of its squares. finer: centres of the finer step, rows -1 to 2n - 1; of the column west of the page a bit a row, from
// row 0 on.
struct FanPage {
    const SlotGrid* grid;
    const std::uint32_t *centre, *side_x;
    const std::uint64_t *side_y, *finer;
    const std::uint32_t* finer_west;
    std::uint32_t all; // squares of a row
};
// The triangles around all of theirs whose bits are set, row after row, while there is room for four times the vertices
// of a row. Returns the bits that are left.
[[nodiscard]] std::uint32_t fan_rows(FanOut& out, const FanPage& page, std::uint32_t rows);

} // namespace fjell
