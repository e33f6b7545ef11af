// Vertices of one step in squares of 8 x 8 squares: how methods that decide in groups lay them out.
//
// Of the vertices on a border those belong to the block that lies east or south of it; on the rim to the only one.
#pragma once

#include <bit>
#include <cstdint>
#include <vector>

#include "rivals/rival.h"
#include "shared/tree.h"

namespace fjell::rivals {

struct StepBlocks {
    struct Level {                                      // of one step, blocks row by row
        std::int32_t step = 0, per_side = 0, cells = 0; // cells: of a block's side
        std::size_t first = 0;
    };
    struct Block {
        std::int32_t x = 0, y = 0;          // north-west
        std::uint32_t first = 0, count = 0; // of places
    };
    std::vector<Level> levels; // the coarsest first
    std::vector<Block> blocks;
    std::vector<std::uint32_t> places; // row << 16 | column

    explicit StepBlocks(std::int32_t side) {
        for (std::int32_t step = side / 2; step >= 1; step /= 2) {
            const std::int32_t cells = std::min(16 * step, side);
            levels.push_back({step, side / cells, cells, blocks.size()});
            for (std::int32_t y = 0; y < side; y += cells)
                for (std::int32_t x = 0; x < side; x += cells) add(side, step, cells, x, y);
        }
    }
    [[nodiscard]] std::size_t block(std::size_t level, std::int32_t bx, std::int32_t by) const {
        return levels[level].first + static_cast<std::size_t>(by * levels[level].per_side + bx);
    }
    // Calls visit(x, y) for the blocks of the next level in block (bx, by) of this one.
    template <typename Visit>
    void below(std::size_t level, std::int32_t bx, std::int32_t by, const Visit& visit) const {
        if (level + 1 == levels.size()) return;
        const std::int32_t n = levels[level + 1].per_side / levels[level].per_side;
        for (std::int32_t y = n * by; y < n * by + n; ++y)
            for (std::int32_t x = n * bx; x < n * bx + n; ++x) visit(x, y);
    }
    [[nodiscard]] static constexpr SampleIndex place(std::uint32_t packed) {
        return {static_cast<std::int32_t>(packed & 0xffff), static_cast<std::int32_t>(packed >> 16)};
    }

private:
    void add(std::int32_t side, std::int32_t step, std::int32_t cells, std::int32_t x0, std::int32_t y0) {
        Block b{x0, y0, static_cast<std::uint32_t>(places.size()), 0};
        const std::int32_t x1 = x0 + cells == side ? side : x0 + cells - step,
                           y1 = y0 + cells == side ? side : y0 + cells - step;
        for (std::int32_t y = y0; y <= y1; y += step)
            for (std::int32_t x = x0; x <= x1; x += step)
                if (Tree::step_log2({x, y}) == std::countr_zero(static_cast<std::uint32_t>(step)) &&
                    !((x == 0 || x == side) && (y == 0 || y == side)))
                    places.push_back(static_cast<std::uint32_t>(y) << 16 | static_cast<std::uint32_t>(x));
        b.count = static_cast<std::uint32_t>(places.size()) - b.first;
        blocks.push_back(b);
    }
};

} // namespace fjell::rivals
