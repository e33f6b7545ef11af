// The place of a sample: its column and row in the height field, counted from the north-west.
#pragma once

#include <cstdint>

#include "fjell/export.h"

FJELL_API_BEGIN
namespace fjell {

// A place, or the difference of two places.
struct SampleIndex {
    std::int32_t column = 0, row = 0;
    friend constexpr bool operator==(SampleIndex, SampleIndex) = default;
    friend constexpr SampleIndex operator+(SampleIndex a, SampleIndex b) {
        return {a.column + b.column, a.row + b.row};
    }
    friend constexpr SampleIndex operator-(SampleIndex a, SampleIndex b) {
        return {a.column - b.column, a.row - b.row};
    }
};

} // namespace fjell
FJELL_API_END
