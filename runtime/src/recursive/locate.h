// From a vertex on its way down the tree to its place in the pages: the recursion's inner arithmetic, for each order.
// PageLayout::place says the same for any vertex; here the step and the plane are known, and most is done beforehand.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "fjell/terrain.h"

namespace fjell {

struct LevelPlane {
    std::uint32_t offset;      // planar: of the plane in its page; hierarchical Z: of the step
    std::uint32_t stride;      // planar: of a row
    std::uint32_t block;       // squares a side of a page
    std::uint32_t digit;       // hierarchical Z: which of a square's three vertices
    std::uint32_t shift;       // from samples to squares
    std::uint32_t first_page;  // of the step
    std::uint32_t last_block;  // in x and y
    std::uint32_t blocks_log2; // a side
    float unit_m;              // of the level's radii
};

inline LevelPlane make_level_plane(const Terrain& terrain, int z, PlaneKind kind) {
    const int level = 2 * (terrain.tree.tile_log2 - 1 - z) + (kind == PlaneKind::centre ? 0 : 1);
    LevelPlane p{};
    p.shift = static_cast<std::uint32_t>(z + 1);
    p.unit_m = terrain.header.level_radius_m[level];
    if (terrain.pages.order == Order::linear) return p;
    const StepLayout step = terrain.pages.step_layout(z);
    const bool planar = terrain.pages.order == Order::planar;
    p.block = step.block;
    p.offset = step.offset + (planar ? block_index<Order::planar>(step.block, kind, 0, 0) : 0);
    p.stride = step.block + (kind == PlaneKind::side_y ? 1 : 0);
    p.digit = block_index<Order::hierarchical_z>(2, kind, 0, 0);
    p.first_page = step.first_page;
    p.blocks_log2 = static_cast<std::uint32_t>(step.blocks_log2);
    p.last_block = (1u << step.blocks_log2) - 1;
    return p;
}

inline constexpr std::array<std::uint16_t, 64> spread_table = [] {
    std::array<std::uint16_t, 64> table{};
    for (std::uint32_t i = 0; i < table.size(); ++i) table[i] = static_cast<std::uint16_t>(spread_bits(i));
    return table;
}();

// x, y: tile-local.
template <Order O>
[[gnu::always_inline]] inline PagePlace locate(const LevelPlane& p, std::uint32_t side, std::uint32_t x,
                                               std::uint32_t y) {
    if constexpr (O == Order::linear) {
        const std::uint32_t index = y * (side + 1) + x;
        return {index / max_page_vertices, index % max_page_vertices};
    } else {
        const std::uint32_t i = x >> p.shift, j = y >> p.shift;
        const std::uint32_t bx = std::min(i >> page_squares_log2, p.last_block),
                            by = std::min(j >> page_squares_log2, p.last_block);
        const std::uint32_t il = i - (bx << page_squares_log2), jl = j - (by << page_squares_log2);
        if constexpr (O == Order::planar) {
            return {p.first_page + (by << p.blocks_log2) + bx, p.offset + jl * p.stride + il};
        } else {
            const std::uint32_t page =
                p.first_page + (spread_table[bx] | static_cast<std::uint32_t>(spread_table[by]) << 1);
            const std::uint32_t inner = 3 * p.block * p.block;
            if (jl == p.block) return {page, p.offset + inner + il};
            if (il == p.block) return {page, p.offset + inner + p.block + jl};
            return {page,
                    p.offset + 3 * (spread_table[il] | static_cast<std::uint32_t>(spread_table[jl]) << 1) + p.digit};
        }
    }
}

} // namespace fjell
