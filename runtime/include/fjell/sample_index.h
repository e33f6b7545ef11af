// Where a sample is: column and row of the height field, counted from its north-west.
#pragma once

#include <cstdint>

#include "fjell/export.h"

FJELL_API_BEGIN
namespace fjell {

// Or the way from one sample to another.
struct SampleIndex {
    std::int32_t x = 0, y = 0; // column, row
    friend constexpr bool operator==(SampleIndex, SampleIndex) = default;
    friend constexpr SampleIndex operator+(SampleIndex a, SampleIndex b) { return {a.x + b.x, a.y + b.y}; }
    friend constexpr SampleIndex operator-(SampleIndex a, SampleIndex b) { return {a.x - b.x, a.y - b.y}; }
};

} // namespace fjell
FJELL_API_END
