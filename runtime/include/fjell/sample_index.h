// Where a sample is: column and row of the height field, counted from its north-west.
#pragma once

#include <cstdint>

#include "fjell/export.h"

FJELL_API_BEGIN
namespace fjell {

// Or the way from one sample to another.
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
