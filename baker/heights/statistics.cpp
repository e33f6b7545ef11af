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

// Samples of a row that differ from the one before, and of those the ones that are far from whole units.
struct Wholes {
    std::int32_t climbing = 0, off_metre = 0, off_decimetre = 0;
};
constexpr float near_whole = 0.2f; // 2 cm of noise on decimetres
FJELL_CLONES void wholes_of_row(const float* row, std::int32_t columns, Wholes& w) {
    constexpr float most = 2e8f; // of an int, with the factor; what is higher counts as whole
    std::int32_t climbing = 0, off_metre = 0, off_decimetre = 0;
    for (std::int32_t x = 1; x < columns; ++x) {
        const float low = row[x] < -most ? 0 : row[x], h = low > most ? 0 : low, tenths = h * 10;
        const float metre = h - static_cast<float>(static_cast<std::int32_t>(h)),
                    decimetre = tenths - static_cast<float>(static_cast<std::int32_t>(tenths));
        const float of_metre = metre < 0 ? -metre : metre, of_decimetre = decimetre < 0 ? -decimetre : decimetre;
        const std::int32_t climbs = row[x] != row[x - 1] ? 1 : 0;
        climbing += climbs;
        off_metre += climbs & (of_metre > near_whole ? 1 : 0) & (of_metre < 1 - near_whole ? 1 : 0);
        off_decimetre += climbs & (of_decimetre > near_whole ? 1 : 0) & (of_decimetre < 1 - near_whole ? 1 : 0);
    }
    w.climbing += climbing, w.off_metre += off_metre, w.off_decimetre += off_decimetre;
}

} // namespace

void HeightStatistics::add(const HeightStatistics& other) {
    least_m = std::min(least_m, other.least_m);
    most_m = std::max(most_m, other.most_m);
    tile_range_m = std::max(tile_range_m, other.tile_range_m);
    for (const int axis : {0, 1}) step_m[axis] = std::max(step_m[axis], other.step_m[axis]);
    voids += other.voids;
    climbing += other.climbing, off_metre += other.off_metre, off_decimetre += other.off_decimetre;
}

double HeightStatistics::whole_m() const {
    constexpr std::uint64_t fewest = 64, few_off = 100; // one in so many
    constexpr float steps = 4;                          // within fewer, heights are whole numbers by chance
    if (climbing < fewest) return 0;
    if (off_metre * few_off <= climbing && most_m - least_m > steps) return 1;
    return off_decimetre * few_off <= climbing && most_m - least_m > 0.1f * steps ? 0.1 : 0;
}

HeightStatistics measure_tile(const float* heights_m, std::int32_t columns, std::int32_t rows, std::ptrdiff_t stride) {
    Extremes e;
    Wholes w;
    for (std::int32_t y = 0; y < rows; ++y) {
        const float* const row = heights_m + y * stride;
        if (y % 4 == 0) wholes_of_row(row, columns, w);
        extremes_of_row(row, y + 1 < rows ? row + stride : nullptr, columns, e);
    }
    HeightStatistics s;
    s.least_m = e.least + 0.0f; // -0 becomes 0
    s.most_m = e.most + 0.0f;
    s.tile_range_m = std::nextafter(e.most - e.least, HUGE_VALF);
    s.step_m[0] = std::nextafter(e.along, HUGE_VALF);
    s.step_m[1] = std::nextafter(e.across, HUGE_VALF);
    s.climbing = static_cast<std::uint64_t>(w.climbing);
    s.off_metre = static_cast<std::uint64_t>(w.off_metre);
    s.off_decimetre = static_cast<std::uint64_t>(w.off_decimetre);
    return s;
}

} // namespace fjell::baker
