// Heights along a network of lines: roads that are nowhere steeper than they may be, rivers that never climb.
//
// Pure: places of a network are numbers, and nothing is known of a terrain. O((n + m) log n) for n places and m pairs;
// memory: 40 bytes a place and 32 a pair. Deterministic. Heights in metres, none of them NaN.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace fjell::baker {

// Two places whose heights may differ by most_m, and no more. most_m >= 0.
struct HeightLimit {
    std::uint32_t a = 0, b = 0;
    double most_m = 0;
};

// The heights that keep all limits and whose largest distance from `ground_m` is the least that any such heights have.
// Heights that keep the limits are Lipschitz in the distance that the limits make. Let low be the largest of those that
// are nowhere above the ground, and high the smallest that are nowhere below. If f is within e of the ground, then
// f - e is one of the former and f + e of the latter, so high - low <= 2 e everywhere. The mean of low and high keeps
// the limits as both do, and lies within (high - low) / 2 <= e of the ground, which is between them.
[[nodiscard]] std::vector<double> limited_heights(std::span<const double> ground_m,
                                                  std::span<const HeightLimit> limits);

// The ground with bumps shorter than about `length_m` taken out, along pairs that are distance_m apart: what the above
// is asked for, so that a road that may be steep does not follow every bump.
struct Neighbours {
    std::uint32_t a = 0, b = 0;
    double distance_m = 0;
};
[[nodiscard]] std::vector<double> without_bumps(std::span<const double> ground_m, std::span<const Neighbours> pairs,
                                                double length_m);

// Water runs from one place to another.
struct Flow {
    std::uint32_t from = 0, to = 0;
};
// The lowest of `most_m` at a place and everywhere upstream of it: the highest bed that is nowhere above most_m and
// never climbs. Places of a circle get one height.
[[nodiscard]] std::vector<double> river_beds(std::span<const double> most_m, std::span<const Flow> flows);

} // namespace fjell::baker
