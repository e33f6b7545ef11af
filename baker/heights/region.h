// Regions of a terrain, which are whole tiles, and the quantised heights of one and some places around it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "baker/store/store.h"
#include "baker/store/window.h"
#include "shared/tree.h"

namespace fjell::baker {

// Tile size for `auto`: 512 cells, more when the terrain would have over 1,024 tiles, fewer when one tile covers it.
[[nodiscard]] inline int auto_tile_log2(std::int32_t columns, std::int32_t rows) {
    int log2 = 9;
    while (log2 > min_tile_log2 && (1 << (log2 - 1)) >= std::max(columns, rows) - 1) --log2;
    const auto tiles = [&] {
        const Tree tree = Tree::covering(columns, rows, log2);
        return static_cast<std::int64_t>(tree.tiles_x) * tree.tiles_y;
    };
    while (log2 < max_tile_log2 && tiles() > 1024) ++log2;
    return log2;
}

// Whole tiles in height scale coordinates, borders included.
struct Region {
    SampleIndex first, last; // multiples of the tile's side
};

// The least that a bake works on at once: one tile, or a square of small ones. Regions in rows from the north-west.
class Regions {
public:
    // least_cells: a side; smaller tiles are grouped.
    Regions(const Tree& tree, std::int32_t least_cells) : tree_(tree) {
        while (group_ * tree.side() < least_cells) group_ *= 2;
        across_ = (tree.tiles_x - 1) / group_ + 1;
        down_ = (tree.tiles_y - 1) / group_ + 1;
    }
    [[nodiscard]] std::int64_t count() const { return std::int64_t{across_} * down_; }
    [[nodiscard]] std::int32_t across() const { return across_; }
    [[nodiscard]] std::int32_t down() const { return down_; }
    [[nodiscard]] std::int32_t cells() const { return group_ * tree_.side(); } // a side, at most
    [[nodiscard]] Region at(std::int64_t index) const {
        const SampleIndex first{static_cast<std::int32_t>(index % across_) * cells(),
                                static_cast<std::int32_t>(index / across_) * cells()};
        return {first,
                {std::min(first.column + cells(), tree_.grid_columns() - 1),
                 std::min(first.row + cells(), tree_.grid_rows() - 1)}};
    }
    // Of a part, counted in regions: its tiles; and its samples, each in one part: a border's are those of the part to
    // the south or east.
    [[nodiscard]] Window tiles_of(const Window& part) const {
        const std::int32_t x = part.x * group_, y = part.y * group_;
        return {x, y, std::min((part.x + part.columns) * group_, tree_.tiles_x) - x,
                std::min((part.y + part.rows) * group_, tree_.tiles_y) - y};
    }
    [[nodiscard]] Window samples_of(const Window& part) const {
        const std::int32_t x = part.x * cells(), y = part.y * cells();
        return {x, y, (part.x + part.columns == across_ ? tree_.columns() : x + part.columns * cells()) - x,
                (part.y + part.rows == down_ ? tree_.rows() : y + part.rows * cells()) - y};
    }
    // Calls visit(tile, its north-west corner).
    template <typename Visit>
    void for_each_tile(const Region& region, const Visit& visit) const {
        for (std::int32_t y = region.first.row; y < region.last.row; y += tree_.side())
            for (std::int32_t x = region.first.column; x < region.last.column; x += tree_.side())
                visit(static_cast<std::uint32_t>(y / tree_.side() * tree_.tiles_x + x / tree_.side()),
                      SampleIndex{x, y});
    }

private:
    Tree tree_;
    std::int32_t group_ = 1, across_ = 1, down_ = 1;
};

// Places [x, x + columns) by [y, y + rows), one value each; a place beyond the terrain has the value of
// where it stands.
template <typename T>
struct Patch {
    static constexpr std::size_t slack = 64; // values past the last that may be read: loops in whole vectors
    std::int32_t x = 0, y = 0, columns = 0, rows = 0;
    Buffer<T> values; // not cleared

    Patch() = default;
    Patch(std::int32_t x0, std::int32_t y0, std::int32_t w, std::int32_t h)
        : x(x0), y(y0), columns(w), rows(h), values(static_cast<std::size_t>(w) * static_cast<std::size_t>(h) + slack) {
    }
    [[nodiscard]] std::size_t area() const {
        return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
    }
    [[nodiscard]] const T* at(std::int32_t px, std::int32_t py) const { return values.data() + index(px, py); }
    [[nodiscard]] T* at(std::int32_t px, std::int32_t py) { return values.data() + index(px, py); }
    [[nodiscard]] std::size_t index(std::int32_t px, std::int32_t py) const {
        return static_cast<std::size_t>(py - y) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(px - x);
    }
};

struct QuantisedHeights {
    Tree tree;
    Patch<std::int32_t> steps;
    Patch<std::uint8_t> voids; // 1: a hole; no values: there is none here
    bool on_scale = true;      // each height is a whole number of steps, bit for bit

    [[nodiscard]] std::int32_t h(SampleIndex c) const { return *steps.at(c.column, c.row); }
    [[nodiscard]] bool has_voids() const { return !voids.values.empty(); }
    [[nodiscard]] bool is_void(SampleIndex c) const { return has_voids() && *voids.at(c.column, c.row) != 0; }
};

} // namespace fjell::baker
