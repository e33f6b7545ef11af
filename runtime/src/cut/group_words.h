// Rows of bits, a whole plane at a time: what the bulk pass does to masks beside deciding.
#pragma once

#include <cstdint>

#include "cut/state.h"

namespace fjell {

// Bits 0, 2, 4 ... and 1, 3, 5 ... of each row, side by side.
void split_rows(const std::uint64_t* rows, std::uint32_t count, std::uint32_t* even, std::uint32_t* odd);

[[nodiscard]] std::uint32_t count_bits(const std::uint32_t* rows, std::uint32_t count);

// What rows of a plane hold, but for their groups' queues: a word a row.
struct GroupRows {
    const std::uint32_t *active, *parent[2], *child[4];
};
// Writes their groups, in no queue. a_row: 1 or 2, of 16 bits each.
void write_groups(GroupState* groups, std::uint32_t rows, std::uint32_t a_row, const GroupRows& from);

} // namespace fjell
