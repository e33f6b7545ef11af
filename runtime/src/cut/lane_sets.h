// Of each set of eight lanes, a bit each, what vectors look up: for packing what is set, and for spreading it again.
#pragma once

#include <array>
#include <bit>
#include <cstdint>

namespace fjell {

using LaneTable = std::array<std::array<std::uint8_t, 8>, 256>;

// Its lanes, the lowest first.
inline constexpr LaneTable lane_sets = [] {
    LaneTable sets{};
    for (std::uint32_t bits = 0; bits < 256; ++bits)
        for (std::uint8_t lane = 0, n = 0; lane < 8; ++lane)
            if (bits >> lane & 1) sets[bits][n++] = lane;
    return sets;
}();

// Of each lane, how many lanes below it are in the set.
inline constexpr LaneTable lane_ranks = [] {
    LaneTable ranks{};
    for (std::uint32_t bits = 0; bits < 256; ++bits)
        for (std::uint32_t lane = 0; lane < 8; ++lane)
            ranks[bits][lane] = static_cast<std::uint8_t>(std::popcount(bits & ((1u << lane) - 1)));
    return ranks;
}();

} // namespace fjell
