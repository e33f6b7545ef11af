// The vertex tree of right isosceles triangles, without pointers (thesis 2.5.1 and 3.4).
//
// Coordinates are whole samples. Inside a tile of side 2^l cells, x and y run 0..2^l. A vertex that is not a tile
// corner has step s = 2^min(ctz x, ctz y) and lies in one of three planes of that step:
//   centre: the middle of a square of side 2s; side_x: the middle of a side that runs along x; side_y: along y.
// Levels count from the root: level 2k holds the centres and level 2k+1 the sides of step 2^(l-1-k).
// The same arithmetic holds over a whole terrain of tiles, with the one exception that `Tree` takes care of:
// every tile's own root square has its diagonal from (0,0) to (2^l,2^l).
//
// Any extents: whole tiles cover the terrain, and a vertex beyond its last column or row *stands at* that one
// (`sample`). The map is monotone, so no triangle flips; those beyond the rim shrink to nothing and are dropped.
//
// Everything here is O(1), pure and thread-safe. Shared by the baker, the runtime and the tests.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

#include "fjell/pack.h"
#include "fjell/sample_index.h"

namespace fjell {

inline constexpr std::uint32_t no_index = 0xffff'ffff; // the one index, slot or name that stands for nothing

enum class VertexKind : std::uint8_t { centre, side_x, side_y };

// A terrain covered by tiles_x by tiles_y tiles of side 2^tile_log2 cells.
struct Tree {
    int tile_log2 = 0;
    std::int32_t tiles_x = 0, tiles_y = 0;
    std::int32_t cut_x = 0, cut_y = 0; // cells of the last tiles that lie beyond the terrain, 0..side - 1

    // The fewest tiles that cover columns x rows samples, both at least 2.
    [[nodiscard]] static constexpr Tree covering(std::int32_t columns, std::int32_t rows, int tile_log2) {
        const std::int32_t side = std::int32_t{1} << tile_log2;
        const std::int32_t tiles_x = (columns - 2) / side + 1, tiles_y = (rows - 2) / side + 1;
        return {tile_log2, tiles_x, tiles_y, tiles_x * side + 1 - columns, tiles_y * side + 1 - rows};
    }
    [[nodiscard]] constexpr std::int32_t side() const { return std::int32_t{1} << tile_log2; }
    // Samples of the terrain.
    [[nodiscard]] constexpr std::int32_t columns() const { return grid_columns() - cut_x; }
    [[nodiscard]] constexpr std::int32_t rows() const { return grid_rows() - cut_y; }
    // Places of vertices: of the terrain and beyond, to the end of the last tiles.
    [[nodiscard]] constexpr std::int32_t grid_columns() const { return tiles_x * side() + 1; }
    [[nodiscard]] constexpr std::int32_t grid_rows() const { return tiles_y * side() + 1; }
    [[nodiscard]] constexpr bool contains(SampleIndex c) const {
        return c.column >= 0 && c.row >= 0 && c.column < grid_columns() && c.row < grid_rows();
    }
    // Where a vertex stands, and whose height it has.
    [[nodiscard]] constexpr SampleIndex sample(SampleIndex c) const {
        return {std::min(c.column, columns() - 1), std::min(c.row, rows() - 1)};
    }
    // A corner of a tile: always active, outside the tree.
    [[nodiscard]] constexpr bool is_corner(SampleIndex c) const { return ((c.column | c.row) & (side() - 1)) == 0; }
    // log2 of the step of a vertex that is not a corner.
    [[nodiscard]] static constexpr int step_log2(SampleIndex c) {
        return std::countr_zero(static_cast<std::uint32_t>(c.column | c.row));
    }
    [[nodiscard]] static constexpr VertexKind kind(SampleIndex c) {
        const int z = step_log2(c);
        const bool odd_x = (c.column >> z) & 1, odd_y = (c.row >> z) & 1;
        return odd_x && odd_y ? VertexKind::centre : odd_x ? VertexKind::side_x : VertexKind::side_y;
    }
    [[nodiscard]] constexpr int level(SampleIndex c) const {
        return 2 * (tile_log2 - 1 - step_log2(c)) + (kind(c) == VertexKind::centre ? 0 : 1);
    }
};

// The diamond that a vertex splits: its hypotenuse runs between ends[0] and ends[1], its right angles are at apexes[].
// On the domain's rim one apex lies outside; ends never do. The apexes are the vertex' parents (or tile corners).
struct Diamond {
    SampleIndex ends[2];
    SampleIndex apexes[2];
};

[[nodiscard]] constexpr Diamond diamond(const Tree& tree, SampleIndex v) {
    const int z = Tree::step_log2(v);
    const std::int32_t s = std::int32_t{1} << z;
    switch (Tree::kind(v)) {
    case VertexKind::side_x:
        return {{{v.column - s, v.row}, {v.column + s, v.row}}, {{v.column, v.row - s}, {v.column, v.row + s}}};
    case VertexKind::side_y:
        return {{{v.column, v.row - s}, {v.column, v.row + s}}, {{v.column - s, v.row}, {v.column + s, v.row}}};
    case VertexKind::centre: break;
    }
    // The square's corner (x-s, y-s), in units of 2s: an even sum ends the hypotenuse, an odd sum is a parent. A
    // tile's root square counts from its own tile, so its sum is 0.
    const bool odd = z != tree.tile_log2 - 1 && ((((v.column - s) >> (z + 1)) + ((v.row - s) >> (z + 1))) & 1);
    const SampleIndex nw{v.column - s, v.row - s}, ne{v.column + s, v.row - s}, sw{v.column - s, v.row + s},
        se{v.column + s, v.row + s};
    if (odd) return {{sw, ne}, {nw, se}};
    return {{nw, se}, {ne, sw}};
}

// The four children; those outside the domain do not exist. A leaf (a side of step 1) has none: count is 0.
struct Children {
    SampleIndex at[4];
    int count = 0; // 0 or 4
};

[[nodiscard]] constexpr Children children(SampleIndex v) {
    const int z = Tree::step_log2(v);
    const std::int32_t s = std::int32_t{1} << z;
    if (Tree::kind(v) == VertexKind::centre)
        return {{{v.column - s, v.row}, {v.column + s, v.row}, {v.column, v.row - s}, {v.column, v.row + s}}, 4};
    if (s == 1) return {};
    const std::int32_t h = s / 2;
    return {
        {{v.column - h, v.row - h}, {v.column + h, v.row - h}, {v.column - h, v.row + h}, {v.column + h, v.row + h}},
        4};
}

} // namespace fjell
