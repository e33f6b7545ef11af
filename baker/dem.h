// A height field as the baker sees it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "host/failure.h"

namespace fjell::baker {

using host::Failure;

// Heights in metres after scale and offset, row 0 = north, row by row; every one finite.
struct Dem {
    std::int32_t columns = 0, rows = 0;
    std::vector<float> heights_m; // columns * rows
    double spacing_m[2] = {1, 1}; // along columns, along rows; > 0
    double origin_m[2] = {0, 0};  // of sample (0, 0) in CRS axes
    std::string crs_wkt;          // empty: none
    // The step that the source's numbers are multiples of (integer types: |scale|), 0 when not known.
    double native_quantum_m = 0;

    [[nodiscard]] float at(std::int32_t x, std::int32_t y) const {
        return heights_m[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(x)];
    }
};

} // namespace fjell::baker
