// Blocks of samples by their places: a table of open addresses, whose cells have numbers of blocks, or no_index. The
// blocks of the numbers 0 to count - 1 are in use, each with its place: x and y, in blocks.
#pragma once

#include <cstdint>
#include <utility>

#include "shared/terrain_data.h"

namespace fjell::edit {

struct BlockTable {
    std::uint32_t* cells;
    std::uint32_t size; // a power of 2, larger than the number of blocks

    // Where the search for a place begins.
    [[nodiscard]] std::uint32_t home(std::int32_t x, std::int32_t y) const {
        return (static_cast<std::uint32_t>(x) * 0x9e37'79b9u ^ static_cast<std::uint32_t>(y) * 0x85eb'ca6bu) &
               (size - 1);
    }
    // The cell of the block there, or the empty one where it would be.
    template <typename B>
    [[nodiscard]] std::uint32_t cell(const B* blocks, std::int32_t x, std::int32_t y) const {
        std::uint32_t at = home(x, y);
        while (cells[at] != no_index && (blocks[cells[at]].x != x || blocks[cells[at]].y != y))
            at = (at + 1) & (size - 1);
        return at;
    }
    template <typename B>
    [[nodiscard]] B* find(B* blocks, std::int32_t x, std::int32_t y) const {
        const std::uint32_t number = cells[cell(blocks, x, y)];
        return number == no_index ? nullptr : &blocks[number];
    }
    // Gives the block of a cell back: the last one takes its number, which is returned, and what was found past its
    // cell moves up.
    template <typename B>
    std::uint32_t remove(B* blocks, std::uint32_t& count, std::uint32_t from) const {
        const std::uint32_t mask = size - 1, number = cells[from];
        cells[from] = no_index;
        for (std::uint32_t at = (from + 1) & mask; cells[at] != no_index; at = (at + 1) & mask) {
            const B& b = blocks[cells[at]];
            if (((at - home(b.x, b.y)) & mask) < ((at - from) & mask)) continue; // its search begins after the cell
            std::swap(cells[from], cells[at]);
            from = at;
        }
        const std::uint32_t last = --count;
        if (number != last) {
            cells[cell(blocks, blocks[last].x, blocks[last].y)] = number;
            blocks[number] = blocks[last];
        }
        return number;
    }
};

} // namespace fjell::edit
