// From a vertex on its way down the tree to its record: the recursion's inner arithmetic, for each order.
//
// PageLayout::place says the same for any vertex; here the step and the plane are known, and most is done beforehand.
// The method keeps a page table of its own (RecursiveState::step_pages) in which every step of a tile is a grid of
// pages, with one column and one row more than there are: the sides on the tile's east and south border, which the last
// pages hold too, are found through those, without a comparison.
#pragma once

#include <array>
#include <cstdint>

#include "shared/compiler.h"
#include "shared/terrain_data.h"

namespace fjell {

struct StepPageEntry {
    std::uint32_t origin; // number of the page's first record, or of what the arithmetic below starts from; no_index
    std::int32_t base;    // height scale steps
};

// A tile-local place: x in the low and y in the high 16 bits, 0 to 2^12. The middle of two is (a + b) >> 1, since the
// sums of coordinates are even there.
constexpr std::uint32_t pack_xy(std::uint32_t x, std::uint32_t y) {
    return x | y << 16;
}

// One kind of vertices of one step. A shift takes a place to its square, x and y at once, and leaves bits of y above
// x, which the masks take away. With a row's length r below 2^16, v * (2^16 + r) >> 16 is x + y * r.
struct LevelPlane {
    const StepPageEntry* pages; // of the step, in the tile in work
    std::uint32_t shift;        // from samples to squares
    std::uint32_t page_mask;    // of a page's position in its step
    std::uint32_t page_pitch;   // 2^16 + entries from one row of pages to the next
    std::uint32_t inside_mask;  // of a square in its page
    std::uint32_t stride;       // planar: 2^16 + records from one row to the next; linear: of the tile
    std::uint32_t offset;       // planar: of the plane in its page; hierarchical Z: of the step
    float unit_m;               // of the level's radii
    std::uint32_t first;        // entry of the step's first page
    std::uint32_t squares;      // a side of the whole step
    std::uint32_t page_side;    // squares
    std::uint32_t digit;        // hierarchical Z: which of a square's three vertices
};

// Entries that a tile's table has: page 0, then step by step twice as many a row as there are pages; in linear order
// one a page.
inline std::uint32_t first_entry(const PageLayout& pages, int z) {
    std::uint32_t first = 1;
    for (int coarser = pages.tile_log2 - 1; coarser > z; --coarser) {
        const StepLayout step = pages.step_layout(coarser);
        const std::uint32_t side = 1u << step.pages_log2;
        if (step.page_side == page_squares) first += 2 * side * (side + 1);
    }
    return first;
}
inline std::uint32_t entries_per_tile(const PageLayout& pages) {
    return pages.order == PageOrder::linear ? pages.pages_per_tile() : first_entry(pages, -1);
}

inline LevelPlane make_level_plane(const TerrainData& terrain, int z, VertexKind kind) {
    const PageLayout& pages = terrain.pages;
    const int level = 2 * (pages.tile_log2 - 1 - z) + (kind == VertexKind::centre ? 0 : 1);
    LevelPlane p{};
    p.shift = static_cast<std::uint32_t>(z + 1);
    p.unit_m = terrain.header.level_radius_m[level];
    p.stride = pages.side() + 1;
    if (pages.order == PageOrder::linear) return p;
    const StepLayout step = pages.step_layout(z);
    const bool in_pages = step.page_side == page_squares;
    p.squares = step.squares;
    p.page_side = step.page_side;
    p.offset = step.offset +
               (pages.order == PageOrder::planar ? page_index<PageOrder::planar>(step.page_side, kind, 0, 0) : 0);
    p.stride = (1u << 16) + step.page_side + (kind == VertexKind::side_y ? 1 : 0);
    p.digit = page_index<PageOrder::hierarchical_z>(2, kind, 0, 0);
    p.first = in_pages ? first_entry(pages, z) : 0;
    p.page_pitch = (1u << 16) + (2u << step.pages_log2);
    // One more than there are, for the far borders.
    p.page_mask = in_pages ? pack_xy(1, 1) * ((2u << step.pages_log2) - 1) : 0;
    p.inside_mask = pack_xy(1, 1) * (in_pages ? page_squares - 1 : 2 * step.squares - 1);
    return p;
}

// Writes what the table says of one page, loaded or not.
inline void set_step_page(const TerrainData& terrain, std::uint32_t page, StepPageEntry entry,
                          StepPageEntry* tile_entries) {
    const int z = terrain.pages.page_step_log2(page);
    if (z < 0) {
        tile_entries[page] = entry;
        return;
    }
    const StepLayout step = terrain.pages.step_layout(z);
    const SampleIndex position = terrain.pages.page_position(page);
    const auto side = std::int32_t{1} << step.pages_log2;
    StepPageEntry* const at = tile_entries + first_entry(terrain.pages, z) + position.row * 2 * side + position.column;
    *at = entry;
    // Seen through the extra column and row, the planes begin at the page's last but one.
    const bool planar = terrain.pages.order == PageOrder::planar && entry.origin != no_index;
    if (position.column == side - 1) at[1] = {entry.origin + (planar ? page_squares : 0), entry.base};
    if (position.row == side - 1)
        at[2 * side] = {entry.origin + (planar ? page_squares * page_squares : 0), entry.base};
}

inline constexpr std::array<std::uint16_t, page_squares> spread_table = [] {
    std::array<std::uint16_t, page_squares> table{};
    for (std::uint32_t i = 0; i < table.size(); ++i) table[i] = static_cast<std::uint16_t>(spread_bits(i));
    return table;
}();

// The number of a vertex' record among all; not loaded: its page is missing.
struct Located {
    std::uint32_t index;
    std::int32_t base;
    bool loaded;
};
template <PageOrder O>
FJELL_ALWAYS_INLINE inline Located locate(const LevelPlane& p, std::uint32_t xy) {
    if constexpr (O == PageOrder::linear) {
        const std::uint32_t index = (xy >> 16) * p.stride + (xy & 0xffff);
        const StepPageEntry& e = p.pages[index / max_page_vertices];
        return {e.origin + index % max_page_vertices, e.base, e.origin != no_index};
    } else {
        const std::uint32_t square = xy >> p.shift;
        const StepPageEntry& e = p.pages[((square >> page_squares_log2 & p.page_mask) * p.page_pitch) >> 16];
        const std::uint32_t inside = square & p.inside_mask;
        std::uint32_t index = e.origin + p.offset;
        if constexpr (O == PageOrder::planar) {
            index += (inside * p.stride) >> 16;
        } else {
            const std::uint32_t i = inside & 0xffff, j = inside >> 16, south = xy >> 16 >> p.shift,
                                east = (xy & 0xffff) >> p.shift;
            if (south == p.squares)
                index += 3 * p.page_side * p.page_side + (i & (page_squares - 1));
            else if (east == p.squares)
                index += 3 * p.page_side * p.page_side + p.page_side + (j & (page_squares - 1));
            else
                index += 3 * (spread_table[i] | static_cast<std::uint32_t>(spread_table[j]) << 1) + p.digit;
        }
        return {index, e.base, e.origin != no_index};
    }
}

} // namespace fjell
