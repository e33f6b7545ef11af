// How many samples are of one kind, and where the first of them is.
#pragma once

#include <cstdint>
#include <tuple>

namespace fjell::baker {

// Samples of one kind, and the first of them in reading order.
struct Tally {
    std::uint64_t count = 0;
    std::int32_t column = 0, row = 0;

    void add(std::int32_t x, std::int32_t y) { add(Tally{1, x, y}); }
    void add(const Tally& other) {
        if (other.count == 0) return;
        if (count == 0 || std::tie(other.row, other.column) < std::tie(row, column))
            column = other.column, row = other.row;
        count += other.count;
    }
};

// Where sample i of a row stands: (x + i * step, y).
struct RowPlace {
    std::int32_t x = 0, y = 0, step = 1;
};

} // namespace fjell::baker
