// Small groups: the up to 16 vertices of one kind and step that are evaluated together, and how any vertex is found in
// them.
//
// A page's planes are cut row by row: a row of 32 is two groups, a coarse row of 16 or fewer is one.
// The column of side_y on a page's east border, which planar order keeps at the ends of its rows, is two groups of its
// own. Groups are the same for both orders; only where a lane's record lies differs. A vertex of the cut is named by
// group * 16 + lane, its group by the place of its page's state in the pool * max_page_groups + number in the page.
//
// Squares are counted over the whole terrain here: square (i, j) of step s has its north-west corner at (2is, 2js) and
// owns its centre, the middle of its north side (side_x) and of its west side (side_y).
#pragma once

#include <cstdint>

#include "shared/order.h"
#include "shared/tree.h"

namespace fjell {

inline constexpr std::uint32_t lanes_log2 = 4;
inline constexpr std::uint32_t group_lanes = 1u << lanes_log2;
inline constexpr std::uint32_t max_page_groups = max_page_vertices / group_lanes;

[[nodiscard]] inline std::uint16_t bit_of(std::uint32_t vertex) {
    return static_cast<std::uint16_t>(1u << vertex % group_lanes);
}

struct GroupShape {
    std::uint16_t first; // planar order: place of lane 0 in the page
    std::uint8_t stride; // and from lane to lane
    std::uint8_t lanes;
    VertexKind kind;
    std::uint8_t z;      // log2 of the step, over the slot's
    std::uint8_t i0, j0; // lane 0's square, counted from the page's first
    std::uint8_t x, y;   // and its place, in steps from that square's corner
    bool along_y;        // lanes go south; otherwise east
    std::uint8_t parts;  // of the page that it lies in, as bits
};
// A page has 2 x 4 parts, of 16 x 8 squares each, which are in sight or not (visibility.h); page 0 is one.
inline constexpr std::uint32_t parts_x = 2, parts_y = 4, page_parts = parts_x * parts_y;
inline constexpr std::uint32_t part_columns = page_squares / parts_x, part_rows = page_squares / parts_y;
inline constexpr std::uint8_t all_parts = 0xff;
static_assert(part_columns == group_lanes && page_parts == 8);

[[nodiscard]] constexpr std::uint32_t part_at(std::uint32_t i, std::uint32_t j) { // squares; the last border: inside
    const std::uint32_t x = i / part_columns, y = j / part_rows;
    return (y < parts_y ? y : parts_y - 1) * parts_x + (x < parts_x ? x : parts_x - 1);
}
static_assert(max_page_groups * group_lanes == max_page_vertices);

// The groups of one kind of page (page 0, or any other).
struct PageShape {
    std::uint32_t count = 0;
    GroupShape groups[max_page_groups] = {};
};

// Where the planes of a step begin, in groups of their page.
struct StepGroups {
    std::int32_t log2;        // of the squares a side, of a tile
    std::int32_t page_log2;   // of the squares a side, of a page
    std::uint32_t first_page; // of the step
    std::uint32_t words_log2; // of the groups a row: 0 or 1
    std::uint32_t centres, sides_x, sides_y, column;
};

// A vertex by its place in the tree.
struct Site {
    int z;
    VertexKind kind;
    std::int32_t i, j; // square
};

[[nodiscard]] constexpr SampleIndex site_coord(const Site& v) {
    const int x = 2 * v.i + (v.kind != VertexKind::side_y), y = 2 * v.j + (v.kind != VertexKind::side_x);
    return {x << v.z, y << v.z};
}
[[nodiscard]] constexpr Site site_at(SampleIndex c) {
    const int z = Tree::step_log2(c);
    return {z, Tree::kind(c), c.column >> (z + 1), c.row >> (z + 1)};
}

// Child d of a centre lies west, east, north, south; of a side, at the quadrant (east: +1) + (south: +2).
[[nodiscard]] constexpr Site child_site(const Site& v, int d) {
    if (v.kind == VertexKind::centre) {
        const bool side_x = d >= 2;
        return {v.z, side_x ? VertexKind::side_x : VertexKind::side_y, v.i + (d == 1), v.j + (d == 3)};
    }
    const int east = d & 1, south = d >> 1;
    if (v.kind == VertexKind::side_x) return {v.z - 1, VertexKind::centre, 2 * v.i + east, 2 * v.j - 1 + south};
    return {v.z - 1, VertexKind::centre, 2 * v.i - 1 + east, 2 * v.j + south};
}
// Which of its parents v is to child d.
[[nodiscard]] constexpr int parent_number(VertexKind kind, int d) {
    if (kind == VertexKind::centre) return d == 0 || d == 2 ? 1 : 0;
    return kind == VertexKind::side_x ? 0 : 1;
}
// Parent n (0 or 1): of a side the centre to its north or west, then south or east; of a centre a side_x, then a
// side_y. Not for a tile's root.
[[nodiscard]] constexpr Site parent_site(const Site& v, int n) {
    if (v.kind == VertexKind::side_x) return {v.z, VertexKind::centre, v.i, v.j - 1 + n};
    if (v.kind == VertexKind::side_y) return {v.z, VertexKind::centre, v.i - 1 + n, v.j};
    if (n == 0) return {v.z + 1, VertexKind::side_x, v.i >> 1, (v.j + 1) >> 1};
    return {v.z + 1, VertexKind::side_y, (v.i + 1) >> 1, v.j >> 1};
}
// Where parent n lies, seen from v, and which child of it v is.
enum class Bearing : std::uint8_t { west, east, north, south, north_west, north_east, south_west, south_east };
[[nodiscard]] constexpr Bearing parent_bearing(const Site& v, int n) {
    if (v.kind == VertexKind::side_x) return n == 0 ? Bearing::north : Bearing::south;
    if (v.kind == VertexKind::side_y) return n == 0 ? Bearing::west : Bearing::east;
    const bool east = ((v.i & 1) != 0) == (n == 1), south = ((v.j & 1) != 0) == (n == 0);
    return east ? (south ? Bearing::south_east : Bearing::north_east)
                : (south ? Bearing::south_west : Bearing::north_west);
}
[[nodiscard]] constexpr int child_number(Bearing parent) {
    switch (parent) {
    case Bearing::west: return 1;
    case Bearing::east: return 0;
    case Bearing::north: return 3;
    case Bearing::south: return 2;
    case Bearing::north_west: return 3;
    case Bearing::north_east: return 2;
    case Bearing::south_west: return 1;
    case Bearing::south_east: break;
    }
    return 0;
}
// v splits its parent's triangle (parent, a, b) into (v, parent, a) and (v, b, parent), counter-clockwise from above.
// The directions of these two from v: the child of v on their hypotenuse.
struct Halves {
    std::uint8_t first, second;
};
[[nodiscard]] constexpr Halves halves(Bearing parent) {
    switch (parent) {
    case Bearing::north: return {0, 1};
    case Bearing::west: return {2, 0};
    case Bearing::south: return {3, 2};
    case Bearing::east: return {1, 3};
    case Bearing::north_east: return {2, 1};
    case Bearing::north_west: return {0, 2};
    case Bearing::south_west: return {3, 0};
    case Bearing::south_east: break;
    }
    return {1, 3};
}

[[nodiscard]] constexpr std::uint32_t words_log2_of(std::int32_t page_log2) {
    return page_log2 > static_cast<std::int32_t>(lanes_log2) ? 1 : 0;
}
[[nodiscard]] constexpr std::uint32_t step_group_count(std::int32_t page_log2) {
    const std::uint32_t n = 1u << page_log2, words = 1u << words_log2_of(page_log2);
    return (n + n + 1 + n + 1) * words;
}

// Appends the groups of a step with n x n squares whose vertices begin at place `offset` of the page.
inline void add_step(PageShape& page, std::uint32_t n, std::uint32_t offset, int z) {
    const auto add = [&](VertexKind kind, std::uint32_t i0, std::uint32_t j0, std::uint32_t lanes, bool along_y) {
        const std::uint32_t first = offset + page_index<PageOrder::planar>(n, kind, i0, j0);
        page.groups[page.count++] = {
            static_cast<std::uint16_t>(first),
            static_cast<std::uint8_t>(along_y ? n + 1 : 1),
            static_cast<std::uint8_t>(lanes),
            kind,
            static_cast<std::uint8_t>(z),
            static_cast<std::uint8_t>(i0),
            static_cast<std::uint8_t>(j0),
            static_cast<std::uint8_t>(2 * i0 + (kind != VertexKind::side_y)),
            static_cast<std::uint8_t>(2 * j0 + (kind != VertexKind::side_x)),
            along_y,
            static_cast<std::uint8_t>(1u << part_at(i0, j0) | 1u << part_at(i0, along_y ? j0 + lanes - 1 : j0))};
    };
    const std::uint32_t lanes = n < group_lanes ? n : group_lanes;
    for (const VertexKind kind : {VertexKind::centre, VertexKind::side_x, VertexKind::side_y})
        for (std::uint32_t j = 0; j < n + (kind == VertexKind::side_x); ++j)
            for (std::uint32_t i = 0; i < n; i += lanes) add(kind, i, j, lanes, false);
    for (std::uint32_t j = 0; j < n; j += lanes) add(VertexKind::side_y, n, j, lanes, true);
}

inline PageShape make_page_shape(const PageLayout& pages, bool page_0) {
    PageShape shape;
    if (!page_0) {
        add_step(shape, page_squares, 0, 0);
        return shape;
    }
    for (int z = pages.tile_log2 - 1; z >= 0; --z) {
        const StepLayout step = pages.step_layout(z);
        if (step.page_side == page_squares) break;
        add_step(shape, step.squares, step.offset, z);
    }
    return shape;
}

inline StepGroups make_step_groups(const PageLayout& pages, int z) {
    StepGroups s{};
    const StepLayout step = pages.step_layout(z);
    s.log2 = pages.tile_log2 - 1 - z;
    s.page_log2 = s.log2 < page_squares_log2 ? s.log2 : page_squares_log2;
    s.first_page = step.first_page;
    s.words_log2 = words_log2_of(s.page_log2);
    const std::uint32_t n = 1u << s.page_log2, words = 1u << s.words_log2;
    if (step.page_side != page_squares)
        for (int log2 = 0; log2 < s.page_log2; ++log2) s.centres += step_group_count(log2);
    s.sides_x = s.centres + n * words;
    s.sides_y = s.sides_x + (n + 1) * words;
    s.column = s.sides_y + n * words;
    return s;
}

} // namespace fjell
