// Where a tile's vertices lie: which page, and at which place in it (thesis 4.2 and 5.3.3).
//
// Planar and hierarchical Z-order divide a tile by levels. Page 0 holds all steps with at most 16 x 16 squares, and the
// corners: the coarsest 33 x 33 samples. A finer step of n x n squares (side 2s, its centre, the middle of its north
// and of its west side) is cut into pages of 32 x 32 squares, 64 x 64 cells of its step. A page is
// closed: it also holds the sides on its south and east border, 32 x 32 + 32 x 33 + 33 x 32 = 3,136 vertices. Of two
// pages of a tile that hold a border vertex, the one to its south or east owns it; a border vertex of two tiles is
// owned in each.
//   planar: in a page the planes centre, side_x, side_y, each row by row; pages row by row, coarse steps first.
//   hierarchical Z: squares in Z-order, three vertices each, then the south and the east border; pages in Z-order.
//   linear: the tile's samples row by row, cut into pages of 3,136. A coarse vertex is as far away as a fine one.
//
// Everything here is pure, thread-safe and O(1).
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

#include "fjell/pack.h"
#include "shared/tree.h"

namespace fjell {

inline constexpr int page_squares_log2 = 5;
inline constexpr std::uint32_t page_squares = 1u << page_squares_log2; // a side
inline constexpr std::uint32_t max_page_vertices =
    page_squares * page_squares + 2 * page_squares * (page_squares + 1); // 3,136

struct PagePlace {
    std::uint32_t page, index;
    friend constexpr bool operator==(PagePlace, PagePlace) = default;
};

// The bits of v, below 4,096, spread to the even places.
[[nodiscard]] constexpr std::uint32_t spread_bits(std::uint32_t v) {
    v = (v | v << 8) & 0x00ff00ff;
    v = (v | v << 4) & 0x0f0f0f0f;
    v = (v | v << 2) & 0x33333333;
    return (v | v << 1) & 0x55555555;
}
[[nodiscard]] constexpr std::uint32_t interleave(std::uint32_t x, std::uint32_t y) {
    return spread_bits(x) | spread_bits(y) << 1;
}
// The even places of v, put together.
[[nodiscard]] constexpr std::uint32_t even_bits(std::uint32_t v) {
    v &= 0x55555555;
    v = (v | v >> 1) & 0x33333333;
    v = (v | v >> 2) & 0x0f0f0f0f;
    v = (v | v >> 4) & 0x00ff00ff;
    return (v | v >> 8) & 0x0000ffff;
}

// One step of a tile in pages: what a vertex' place is computed from.
struct StepLayout {
    std::uint32_t squares = 0;    // a side of the whole step: n
    std::uint32_t page_side = 0;  // squares a side of a page: min(n, 32)
    std::uint32_t first_page = 0; // of the step
    std::uint32_t offset = 0;     // of the step's first vertex in its page; not 0 in page 0 only
    int pages_log2 = 0;           // pages a side
};

// Number of a vertex among those of its page, `side` squares wide; i, j: its square, counted from the page's first, up
// to `side` on the border.
template <PageOrder O>
[[nodiscard]] constexpr std::uint32_t page_index(std::uint32_t side, VertexKind kind, std::uint32_t i,
                                                 std::uint32_t j) {
    static_assert(O != PageOrder::linear);
    if constexpr (O == PageOrder::planar) {
        switch (kind) {
        case VertexKind::centre: return j * side + i;
        case VertexKind::side_x: return side * side + j * side + i;
        case VertexKind::side_y: break;
        }
        return side * side + side * (side + 1) + j * (side + 1) + i;
    } else {
        if (j == side) return 3 * side * side + i;
        if (i == side) return 3 * side * side + side + j;
        // Thesis 4.2.1: i - (i >> 2) - 1 of the Z-index i, whose last digit is 1 for odd x, 2 for odd y, 3 for both.
        const std::uint32_t digit = kind == VertexKind::centre ? 2 : kind == VertexKind::side_x ? 0 : 1;
        return 3 * interleave(i, j) + digit;
    }
}

struct PageLayout {
    int tile_log2 = 0;
    PageOrder order = PageOrder::planar;

    [[nodiscard]] constexpr std::uint32_t side() const { return 1u << tile_log2; }
    [[nodiscard]] constexpr std::uint32_t tile_vertices() const { return (side() + 1) * (side() + 1); }
    [[nodiscard]] constexpr std::uint32_t pages_per_tile() const {
        if (order == PageOrder::linear) return (tile_vertices() + max_page_vertices - 1) / max_page_vertices;
        return tile_log2 <= page_squares_log2 ? 1 : first_page(tile_log2);
    }
    // Vertices that the largest page holds: what a slot must have room for.
    [[nodiscard]] constexpr std::uint32_t page_capacity() const { return std::min(max_page_vertices, tile_vertices()); }
    [[nodiscard]] constexpr std::uint32_t page_vertices(std::uint32_t page) const {
        if (order == PageOrder::linear) return std::min(max_page_vertices, tile_vertices() - page * max_page_vertices);
        if (page != 0) return max_page_vertices;
        const std::uint32_t n = (1u << std::min(tile_log2, page_squares_log2)) + 1;
        return n * n;
    }
    // log2 of the step that this page is a part of; -1 for page 0 and in linear order.
    [[nodiscard]] constexpr int page_step_log2(std::uint32_t page) const {
        if (order == PageOrder::linear || page == 0) return -1;
        int z = tile_log2 - 1 - page_squares_log2;
        while (z > 0 && page >= first_page(tile_log2 - z)) --z;
        return z;
    }
    // Where such a page lies among the pages of its step; and the page that lies there. Neither for linear order.
    [[nodiscard]] constexpr SampleIndex page_position(std::uint32_t page) const {
        const int z = page_step_log2(page);
        const StepLayout step = step_layout(z);
        const std::uint32_t local = page - step.first_page;
        if (order == PageOrder::hierarchical_z)
            return {static_cast<std::int32_t>(even_bits(local)), static_cast<std::int32_t>(even_bits(local >> 1))};
        return {static_cast<std::int32_t>(local & ((1u << step.pages_log2) - 1)),
                static_cast<std::int32_t>(local >> step.pages_log2)};
    }
    [[nodiscard]] constexpr std::uint32_t page_at(int z, std::uint32_t px, std::uint32_t py) const {
        const StepLayout step = step_layout(z);
        return step.first_page +
               (order == PageOrder::hierarchical_z ? interleave(px, py) : (py << step.pages_log2) + px);
    }

    // Not for linear order.
    [[nodiscard]] constexpr StepLayout step_layout(int z) const {
        const int log2 = tile_log2 - 1 - z; // of the squares a side
        StepLayout step;
        step.squares = 1u << log2;
        if (log2 >= page_squares_log2) {
            step.page_side = page_squares;
            step.first_page = first_page(log2);
            step.pages_log2 = log2 - page_squares_log2;
        } else {
            step.page_side = step.squares;
            step.offset = (step.squares + 1) * (step.squares + 1); // all coarser steps and the corners
        }
        return step;
    }

    // x, y: tile-local, 0..2^l. The owner's place for a vertex that several pages of the tile hold.
    template <PageOrder O>
    [[nodiscard]] constexpr PagePlace place_as(std::uint32_t x, std::uint32_t y) const {
        if constexpr (O == PageOrder::linear) {
            const std::uint32_t index = y * (side() + 1) + x;
            return {index / max_page_vertices, index % max_page_vertices};
        } else {
            if (((x | y) & (side() - 1)) == 0) return {0, (x >> tile_log2) + 2 * (y >> tile_log2)};
            const SampleIndex c{static_cast<std::int32_t>(x), static_cast<std::int32_t>(y)};
            const int z = Tree::step_log2(c);
            const StepLayout step = step_layout(z);
            const std::uint32_t i = x >> (z + 1), j = y >> (z + 1), last = (1u << step.pages_log2) - 1;
            const std::uint32_t px = std::min(i / step.page_side, last), py = std::min(j / step.page_side, last);
            const std::uint32_t page =
                O == PageOrder::hierarchical_z ? interleave(px, py) : (py << step.pages_log2) + px;
            return {step.first_page + page,
                    step.offset +
                        page_index<O>(step.page_side, Tree::kind(c), i - px * step.page_side, j - py * step.page_side)};
        }
    }
    [[nodiscard]] constexpr PagePlace place(std::uint32_t x, std::uint32_t y) const {
        switch (order) {
        case PageOrder::planar: return place_as<PageOrder::planar>(x, y);
        case PageOrder::hierarchical_z: return place_as<PageOrder::hierarchical_z>(x, y);
        case PageOrder::linear: break;
        }
        return place_as<PageOrder::linear>(x, y);
    }
    // Tile-local coordinates of a vertex in a page, owned or not.
    [[nodiscard]] constexpr SampleIndex coord(PagePlace at) const {
        if (order == PageOrder::linear) {
            const std::uint32_t index = at.page * max_page_vertices + at.index;
            return {static_cast<std::int32_t>(index % (side() + 1)), static_cast<std::int32_t>(index / (side() + 1))};
        }
        if (at.page != 0) {
            const SampleIndex position = page_position(at.page);
            return page_coord(page_step_log2(at.page), position.column, position.row, at.index);
        }
        const auto n = static_cast<std::int32_t>(side());
        if (at.index < 4)
            return {static_cast<std::int32_t>(at.index & 1) * n, static_cast<std::int32_t>(at.index >> 1) * n};
        int z = tile_log2 - 1;
        while (z > 0 && tile_log2 - z < page_squares_log2 && at.index >= step_layout(z - 1).offset) --z;
        return page_coord(z, 0, 0, at.index - step_layout(z).offset);
    }

private:
    // First page of the step with 2^log2 squares a side, log2 >= 5: after page 0 and all coarser steps.
    [[nodiscard]] static constexpr std::uint32_t first_page(int log2) {
        return 1 + ((1u << (2 * (log2 - page_squares_log2))) - 1) / 3;
    }
    [[nodiscard]] constexpr SampleIndex page_coord(int z, std::int32_t px, std::int32_t py, std::uint32_t index) const {
        const std::uint32_t n = step_layout(z).page_side;
        VertexKind kind = VertexKind::centre;
        std::uint32_t i = 0, j = 0;
        if (order == PageOrder::planar) {
            if (index < n * n) {
                i = index % n, j = index / n;
            } else if (index < n * n + n * (n + 1)) {
                kind = VertexKind::side_x;
                i = (index - n * n) % n, j = (index - n * n) / n;
            } else {
                kind = VertexKind::side_y;
                const std::uint32_t in_plane = index - n * n - n * (n + 1);
                i = in_plane % (n + 1), j = in_plane / (n + 1);
            }
        } else if (index < 3 * n * n) {
            constexpr VertexKind kinds[3] = {VertexKind::side_x, VertexKind::side_y, VertexKind::centre};
            kind = kinds[index % 3];
            i = even_bits(index / 3), j = even_bits(index / 3 >> 1);
        } else if (index < 3 * n * n + n) {
            kind = VertexKind::side_x;
            i = index - 3 * n * n, j = n;
        } else {
            kind = VertexKind::side_y;
            i = n, j = index - 3 * n * n - n;
        }
        const std::int32_t s = std::int32_t{1} << z;
        const std::int32_t square_x = px * static_cast<std::int32_t>(n) + static_cast<std::int32_t>(i),
                           square_y = py * static_cast<std::int32_t>(n) + static_cast<std::int32_t>(j);
        return {2 * square_x * s + (kind == VertexKind::side_y ? 0 : s),
                2 * square_y * s + (kind == VertexKind::side_x ? 0 : s)};
    }
};

[[nodiscard]] inline PageLayout pages_of(const PackHeader& header) {
    return {static_cast<int>(header.tile_log2), header.order};
}
[[nodiscard]] inline Tree tree_of(const PackHeader& header) {
    return Tree::covering(static_cast<std::int32_t>(header.columns), static_cast<std::int32_t>(header.rows),
                          static_cast<int>(header.tile_log2));
}
// The tree level on whose radius unit (PackHeader::level_radius_m) PageBound::radius counts: the page's coarsest.
[[nodiscard]] inline int bound_level(const PageLayout& pages, std::uint32_t page) {
    const int z = pages.page_step_log2(page); // -1: page 0, or linear order
    return z < 0 ? 0 : 2 * (pages.tile_log2 - 1 - z);
}

} // namespace fjell
