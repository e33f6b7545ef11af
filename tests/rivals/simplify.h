// An irregular simplification of a ground, from all its samples down to its corners, by half-edge collapses, the one
// that is least wrong first (Hoppe 1998, 5): a sample goes, and its triangles follow to one of its neighbours.
//
// How wrong a collapse is, is the largest vertical distance from any sample under the triangles that it leaves to
// those, measured and not added up. Blocks of samples are simplified one after the other with their borders locked, to
// a number of vertices each; four neighbours are one block of the next level, until one is left. So no queue is ever
// longer than a block. Triangles never flip: doubled areas of whole coordinates stay above 0. The corners of the
// terrain stay, and samples of its sides go along them.
// Complexity: O(samples * log(side)), a few microseconds each. Memory: O(samples), but for the queues. Failure: none.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "rivals/rival.h"

namespace fjell::rivals {

inline constexpr std::uint32_t no_index = 0xffffffff;

// Corners are samples, counter-clockwise seen from above; neighbour k lies across the edge opposite to corner k.
struct LinkedFace {
    std::array<std::uint32_t, 3> corner{}, neighbour{};
};

// A sample that has gone. Its ring was `to`, w, ..., w', and back to `to`. The two triangles that have gone with it are
// first (from, to, w) and second (from, w', to): at the terrain's rim there is one only.
struct Collapse {
    std::uint32_t from = 0, to = 0;
    std::uint32_t first = no_index, second = no_index; // faces
    // Neighbours of first, then of second: beyond `to`, and beyond `from`. no_index beside a rim, or of no face.
    std::array<std::uint32_t, 4> around{no_index, no_index, no_index, no_index};
    float error_m = 0, reach_m = 0; // reach: from the sample to the farthest of its ring
};

struct Simplified {
    std::vector<LinkedFace> faces; // those with corner[0] == no_index have gone
    std::vector<Collapse> collapses;
};
// block_cells: a side of the first blocks; block_vertices: that each is simplified to, about.
[[nodiscard]] Simplified simplify(const Ground& ground, std::int32_t block_cells, std::size_t block_vertices);

} // namespace fjell::rivals
