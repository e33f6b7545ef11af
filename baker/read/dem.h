// A height field as the baker sees it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "io/failure.h"

namespace fjell::baker {

using io::Failure;

// Heights in metres after scale and offset, row 0 = north, row by row. Every one is finite, also where there is a hole:
// there they continue the ground around it (fill.h), so that only what draws or stands on the ground has to ask.
struct Dem {
    std::int32_t columns = 0, rows = 0;
    std::vector<float> heights_m;    // columns * rows
    std::vector<std::uint8_t> voids; // columns * rows, 1: no height there, a hole; empty: none
    double spacing_m[2] = {1, 1};    // along columns, along rows; > 0
    double origin_m[2] = {0, 0};     // of sample (0, 0) in CRS axes
    double crs_step[2] = {0, 0};     // between samples in CRS units; 0: what spacing_m is in them, if they count metres
    std::string crs_wkt;             // empty: none
    // The step that the source's numbers are multiples of (integer types: |scale|), 0 when not known.
    double native_quantum_m = 0;

    [[nodiscard]] std::size_t index(std::int32_t x, std::int32_t y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(x);
    }
    [[nodiscard]] float at(std::int32_t x, std::int32_t y) const { return heights_m[index(x, y)]; }
    [[nodiscard]] bool is_void(std::int32_t x, std::int32_t y) const {
        return !voids.empty() && voids[index(x, y)] != 0;
    }
};

// How many samples are holes. O(samples).
[[nodiscard]] inline std::uint64_t void_count(const Dem& dem) {
    return static_cast<std::uint64_t>(std::count(dem.voids.begin(), dem.voids.end(), std::uint8_t{1}));
}

} // namespace fjell::baker
