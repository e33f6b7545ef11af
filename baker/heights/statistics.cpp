#include "baker/heights/statistics.h"

#include <algorithm>
#include <cmath>

#include "shared/compiler.h"

namespace fjell::baker {

namespace {

// The smallest and the largest of a row, and the largest differences to the next column and the next row. The compiler
// vectorises this (see CMakeLists.txt: no NaN can reach it, and the sign of a zero is taken off in the end).
struct Extremes {
    float least = HUGE_VALF, most = -HUGE_VALF, along = 0, across = 0;
};
FJELL_CLONES void extremes_of_row(const float* row, const float* next, std::int32_t columns, Extremes& e) {
    float least = e.least, most = e.most, along = e.along, across = e.across;
    for (std::int32_t x = 0; x < columns; ++x) {
        least = row[x] < least ? row[x] : least;
        most = row[x] > most ? row[x] : most;
    }
    for (std::int32_t x = 0; x + 1 < columns; ++x) {
        const float step = std::abs(row[x + 1] - row[x]);
        along = step > along ? step : along;
    }
    if (next)
        for (std::int32_t x = 0; x < columns; ++x) {
            const float step = std::abs(next[x] - row[x]);
            across = step > across ? step : across;
        }
    e = {least, most, along, across};
}

} // namespace

void HeightStatistics::add(const HeightStatistics& other) {
    least_m = std::min(least_m, other.least_m);
    most_m = std::max(most_m, other.most_m);
    tile_range_m = std::max(tile_range_m, other.tile_range_m);
    for (const int axis : {0, 1}) step_m[axis] = std::max(step_m[axis], other.step_m[axis]);
    voids += other.voids;
}

HeightStatistics measure_tile(const float* heights_m, std::int32_t columns, std::int32_t rows, std::ptrdiff_t stride) {
    Extremes e;
    for (std::int32_t y = 0; y < rows; ++y) {
        const float* const row = heights_m + y * stride;
        extremes_of_row(row, y + 1 < rows ? row + stride : nullptr, columns, e);
    }
    HeightStatistics s;
    s.least_m = e.least + 0.0f; // -0 becomes 0
    s.most_m = e.most + 0.0f;
    s.tile_range_m = std::nextafter(e.most - e.least, HUGE_VALF);
    s.step_m[0] = std::nextafter(e.along, HUGE_VALF);
    s.step_m[1] = std::nextafter(e.across, HUGE_VALF);
    return s;
}

} // namespace fjell::baker
