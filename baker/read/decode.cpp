// Chunks are decoded and judged without a branch; only one that holds something void or implausible is gone through
// again, sample by sample.
#include "baker/read/decode.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "shared/compiler.h"

namespace fjell::baker {

namespace {

constexpr std::size_t chunk = 512, lanes = 8;

bool plausible(double metres) {
    return metres >= lowest_m && metres <= highest_m;
}

bool is_void(const Decoding& d, double number) {
    return std::any_of(d.voids.begin(), d.voids.end(),
                       [&](const Decoding::Void& v) { return std::abs(number - v.number) <= v.slack; });
}

// Whether any number of a chunk is a void.
template <typename T>
FJELL_ALWAYS_INLINE inline bool any_void(const T* raw, std::size_t count, const Decoding& d) {
    std::int32_t found = 0;
    for (const Decoding::Void& v : d.voids)
        for (std::size_t i = 0; i < count; ++i) found += std::abs(static_cast<double>(raw[i]) - v.number) <= v.slack;
    return found > 0;
}

// Least and most in lanes: no reduction, so that the compiler may vectorise without reordering floats.
struct Extremes {
    std::array<float, lanes> least, most;
    explicit Extremes(const ReadStatistics& c) {
        least.fill(c.least_m);
        most.fill(c.most_m);
    }
    FJELL_ALWAYS_INLINE void see(const float* heights, std::size_t count) {
        std::size_t i = 0;
        for (; i + lanes <= count; i += lanes)
            for (std::size_t k = 0; k < lanes; ++k) {
                least[k] = heights[i + k] < least[k] ? heights[i + k] : least[k];
                most[k] = heights[i + k] > most[k] ? heights[i + k] : most[k];
            }
        for (; i < count; ++i) least[0] = std::min(least[0], heights[i]), most[0] = std::max(most[0], heights[i]);
    }
    void give(ReadStatistics& c) const {
        c.least_m = *std::min_element(least.begin(), least.end());
        c.most_m = *std::max_element(most.begin(), most.end());
    }
};

// Heights of a chunk, and how many of them nobody can believe.
template <typename T>
FJELL_ALWAYS_INLINE inline std::int32_t heights_of(const T* raw, float* heights, std::size_t count, const Scaling& s) {
    std::int32_t implausible = 0;
    if (s == Scaling{}) {
        for (std::size_t i = 0; i < count; ++i) {
            implausible += !(raw[i] >= static_cast<T>(lowest_m)) | !(raw[i] <= static_cast<T>(highest_m));
            heights[i] = static_cast<float>(raw[i]);
        }
        return implausible;
    }
    for (std::size_t i = 0; i < count; ++i) {
        const double metres = s.file_m(static_cast<double>(raw[i])), asked = s.asked_m(metres);
        const bool as_filed = (metres >= lowest_m) & (metres <= highest_m);
        const bool as_asked = (asked >= lowest_m) & (asked <= highest_m);
        implausible += !(as_filed | as_asked);
        heights[i] = static_cast<float>(asked);
    }
    return implausible;
}

// The coarsest of 1, 0.1 and 0.01 that the number is a multiple of, as floats; per_unit never shrinks.
void find_step(double raw, double& per_unit) {
    while (per_unit <= 100 && static_cast<float>(std::round(raw * per_unit) / per_unit) != static_cast<float>(raw))
        per_unit *= 10;
}

template <typename T>
FJELL_ALWAYS_INLINE inline void find_step(const T* raw, std::size_t count, double& per_unit) {
    if (per_unit == 1) {
        constexpr T limit = static_cast<T>(1 << 30); // inside it, truncating to an integer is defined
        std::int32_t broken = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const T near = std::min(std::max(raw[i], -limit), limit);
            broken += static_cast<T>(static_cast<std::int32_t>(near)) != raw[i];
        }
        if (broken == 0) return;
    }
    for (std::size_t i = 0; i < count && per_unit <= 100; ++i) find_step(static_cast<double>(raw[i]), per_unit);
}

// One sample at a time, for a chunk with voids or implausible heights.
template <typename T>
FJELL_NOINLINE void decode_slowly(const T* raw, const std::uint8_t* valid, float* to, std::size_t count,
                                  const Decoding& d, const RowPlace& place, ReadStatistics& statistics) {
    for (std::size_t i = 0; i < count; ++i) {
        const double value = static_cast<double>(raw[i]);
        const double metres = d.scaling.file_m(value), asked = d.scaling.asked_m(metres);
        const std::int32_t x = place.x + static_cast<std::int32_t>(i) * place.step;
        const bool marked = (valid && valid[i] == 0) || is_void(d, value);
        if (!marked && (plausible(metres) || plausible(asked) || (d.all_ground && std::isfinite(asked)))) {
            to[i] = static_cast<float>(asked);
            statistics.least_m = std::min(statistics.least_m, to[i]);
            statistics.most_m = std::max(statistics.most_m, to[i]);
            statistics.ends.see(value, x, place.y);
            if (!d.whole) find_step(value, statistics.per_unit);
            continue;
        }
        to[i] = std::numeric_limits<float>::quiet_NaN();
        if (marked || std::isnan(metres)) {
            statistics.voids.add(x, place.y);
            continue;
        }
        const Tally before = statistics.implausible;
        statistics.implausible.add(x, place.y);
        if (before.count == 0 || std::tie(place.y, x) < std::tie(before.row, before.column))
            statistics.implausible_m = asked;
    }
}

template <typename T>
FJELL_ALWAYS_INLINE inline void decode_chunks(const T* raw, const std::uint8_t* valid, float* to, std::size_t count,
                                              const Decoding& d, const RowPlace& place, ReadStatistics& statistics) {
    std::array<float, chunk> heights;
    for (std::size_t at = 0; at < count; at += chunk) {
        const std::size_t n = std::min(chunk, count - at);
        const std::uint8_t* const marks = valid ? valid + at : nullptr;
        const RowPlace from{place.x + static_cast<std::int32_t>(at) * place.step, place.y, place.step};
        const bool all_valid = (!marks || std::find(marks, marks + n, 0) == marks + n) && !any_void(raw + at, n, d);
        if (all_valid && heights_of(raw + at, heights.data(), n, d.scaling) == 0) {
            Extremes extremes(statistics);
            extremes.see(heights.data(), n);
            extremes.give(statistics);
            statistics.ends.see(raw + at, n, from);
            if (!d.whole) find_step(raw + at, n, statistics.per_unit);
            std::copy_n(heights.begin(), n, to + at);
            continue;
        }
        decode_slowly(raw + at, marks, to + at, n, d, from, statistics);
    }
}

} // namespace

FJELL_CLONES void decode_row(const float* raw, const std::uint8_t* valid, float* to, std::size_t count,
                             const Decoding& decoding, const RowPlace& place, ReadStatistics& statistics) {
    decode_chunks(raw, valid, to, count, decoding, place, statistics);
}
FJELL_CLONES void decode_row(const double* raw, const std::uint8_t* valid, float* to, std::size_t count,
                             const Decoding& decoding, const RowPlace& place, ReadStatistics& statistics) {
    decode_chunks(raw, valid, to, count, decoding, place, statistics);
}

} // namespace fjell::baker
