// Vertices of one row against the samples under their triangles: the inner loop of estimate 1.
#pragma once

#include <cstddef>
#include <cstdint>

#include "fjell/tree.h"

namespace fjell::baker {

// `count` vertices of one plane, 2s samples apart. before: the triangles north of sides along x, west of sides along y;
// after: those south or east of them. Centres are squares: the first is cut from north-west to south-east or not, and
// every further one the other way where `alternate` says so.
struct VertexRow {
    const std::int32_t* first; // its height in steps; up to `walk_slack` heights past the triangles are read
    std::ptrdiff_t stride;     // from row to row of samples
    std::int32_t s, count;
    PlaneKind kind;
    bool before = true, after = true;
    bool falling = true, alternate = true;
};
inline constexpr std::size_t walk_slack = 64;

// worst[i]: the largest |2s (h - plane)| of vertex i, exact as long as heights under a triangle span less than
// 2^30 / 2s steps. The second one is the same, without vectors.
void walk_row(const VertexRow& row, std::int32_t* worst);
void walk_row_scalar(const VertexRow& row, std::int32_t* worst);

} // namespace fjell::baker
