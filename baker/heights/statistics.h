// What one look at every sample says of the terrain: the bounds that all scales follow from (docs/notes/baking.md).
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

namespace fjell::baker {

// Of any set of whole tiles; adding up in any order gives the same.
struct HeightStatistics {
    float least_m = HUGE_VALF, most_m = -HUGE_VALF;
    float tile_range_m = 0;   // the largest difference of heights within one tile
    float step_m[2] = {0, 0}; // the largest between neighbours along a row and along a column
    std::uint64_t voids = 0;  // samples that are holes; counted by whose tile they lie in, once each
    // Of every fourth row: samples that differ from the one before, and how many of those are no whole metres or no
    // whole decimetres, give or take a fifth of one.
    std::uint64_t climbing = 0, off_metre = 0, off_decimetre = 0;

    // The steps that nearly all heights are whole numbers of, noise aside: 1, 0.1, or 0: neither.
    [[nodiscard]] double whole_m() const;
    void add(const HeightStatistics& other);
};

// One tile's samples, borders included: columns x rows of them, `stride` floats from row to row.
[[nodiscard]] HeightStatistics measure_tile(const float* heights_m, std::int32_t columns, std::int32_t rows,
                                            std::ptrdiff_t stride);

} // namespace fjell::baker
