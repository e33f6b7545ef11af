// From a vertex on its way down the tree to its record: the recursion's inner arithmetic, for each order.
//
// PageLayout::place says the same for any vertex; here the step and the plane are known, and most is done beforehand.
// The method keeps a page table of its own (RecursiveState::step_pages) in which every step of a tile is a grid of
// pages, with one column and one row more than there are: the sides on the tile's east and south border, which the last
// pages hold too, are found through those, without a comparison.
#pragma once

#include <array>
#include <cstdint>

#include "pack/terrain_data.h"

namespace fjell {

struct StepPageEntry {
    std::uint32_t origin; // number of the page's first record, or of what the arithmetic below starts from; no_index
    std::int32_t base;    // height scale steps
};

struct LevelPlane {
    std::uint32_t offset;     // planar: of the plane in its page; hierarchical Z: of the step
    std::uint32_t stride;     // planar: of a row
    std::uint32_t squares;    // a side of the whole step
    std::uint32_t page_side;  // squares
    std::uint32_t digit;      // hierarchical Z: which of a square's three vertices
    std::uint32_t shift;      // from samples to squares
    std::uint32_t first;      // entry of the step's first page
    std::uint32_t pitch_log2; // entries from one row of pages to the next
    float unit_m;             // of the level's radii
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
    return pages.order == Order::linear ? pages.pages_per_tile() : first_entry(pages, -1);
}

inline LevelPlane make_level_plane(const TerrainData& terrain, int z, VertexKind kind) {
    const int level = 2 * (terrain.tree.tile_log2 - 1 - z) + (kind == VertexKind::centre ? 0 : 1);
    LevelPlane p{};
    p.shift = static_cast<std::uint32_t>(z + 1);
    p.unit_m = terrain.header.level_radius_m[level];
    if (terrain.pages.order == Order::linear) return p;
    const StepLayout step = terrain.pages.step_layout(z);
    p.squares = step.squares;
    p.page_side = step.page_side;
    p.offset = step.offset +
               (terrain.pages.order == Order::planar ? page_index<Order::planar>(step.page_side, kind, 0, 0) : 0);
    p.stride = step.page_side + (kind == VertexKind::side_y ? 1 : 0);
    p.digit = page_index<Order::hierarchical_z>(2, kind, 0, 0);
    p.first = step.page_side == page_squares ? first_entry(terrain.pages, z) : 0;
    p.pitch_log2 = static_cast<std::uint32_t>(step.pages_log2 + 1);
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
    const Coord position = terrain.pages.page_position(page);
    const auto side = std::int32_t{1} << step.pages_log2;
    StepPageEntry* const at = tile_entries + first_entry(terrain.pages, z) + position.y * 2 * side + position.x;
    *at = entry;
    // Seen through the extra column and row, the planes begin at the page's last but one.
    const bool planar = terrain.pages.order == Order::planar && entry.origin != no_index;
    if (position.x == side - 1) at[1] = {entry.origin + (planar ? page_squares : 0), entry.base};
    if (position.y == side - 1) at[2 * side] = {entry.origin + (planar ? page_squares * page_squares : 0), entry.base};
}

inline constexpr std::array<std::uint16_t, page_squares> spread_table = [] {
    std::array<std::uint16_t, page_squares> table{};
    for (std::uint32_t i = 0; i < table.size(); ++i) table[i] = static_cast<std::uint16_t>(spread_bits(i));
    return table;
}();

// The vertex' page and the number of its record among all; origin no_index: not loaded. x, y: tile-local.
struct Located {
    std::uint32_t index;
    std::int32_t base;
    bool loaded;
};
template <Order O>
[[gnu::always_inline]] inline Located locate(const LevelPlane& p, const StepPageEntry* entries, std::uint32_t side,
                                             std::uint32_t x, std::uint32_t y) {
    constexpr std::uint32_t inside = page_squares - 1;
    if constexpr (O == Order::linear) {
        const std::uint32_t index = y * (side + 1) + x;
        const StepPageEntry e = entries[index / max_page_vertices];
        return {e.origin + index % max_page_vertices, e.base, e.origin != no_index};
    } else {
        const std::uint32_t i = x >> p.shift, j = y >> p.shift;
        const StepPageEntry e = entries[p.first + (j >> page_squares_log2 << p.pitch_log2) + (i >> page_squares_log2)];
        std::uint32_t index = e.origin + p.offset;
        if constexpr (O == Order::planar)
            index += (j & inside) * p.stride + (i & inside);
        else if (j == p.squares)
            index += 3 * p.page_side * p.page_side + (i & inside);
        else if (i == p.squares)
            index += 3 * p.page_side * p.page_side + p.page_side + (j & inside);
        else
            index +=
                3 * (spread_table[i & inside] | static_cast<std::uint32_t>(spread_table[j & inside]) << 1) + p.digit;
        return {index, e.base, e.origin != no_index};
    }
}

} // namespace fjell
