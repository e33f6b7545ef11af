#include "baker/maps/wetness.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <queue>

namespace fjell::baker {

namespace {

constexpr std::int32_t around[8][2] = {{-1, -1}, {0, -1}, {1, -1}, {-1, 0}, {1, 0}, {-1, 1}, {0, 1}, {1, 1}};

struct Flooded {
    float height_m;
    std::uint32_t cell;
    // Equal heights by place, so that the order does not depend on the queue.
    [[nodiscard]] bool operator<(const Flooded& o) const {
        return height_m != o.height_m ? height_m > o.height_m : cell > o.cell;
    }
};

class Drainage {
public:
    Drainage(const WetnessGrid& grid, std::vector<float>& heights_m)
        : grid_(grid), heights_(heights_m), cells_(heights_m.size()) {}

    // Raises what has no way out until it has one. Each cell lies a little above the one that it drains to.
    void fill() {
        std::vector<std::uint8_t> seen(cells_, 0);
        std::priority_queue<Flooded> open;
        for (std::uint32_t i = 0; i < cells_; ++i)
            if (on_rim(i)) {
                seen[i] = 1;
                open.push({heights_[i], i});
            }
        while (!open.empty()) {
            const Flooded from = open.top();
            open.pop();
            for_neighbours(from.cell, [&](std::uint32_t n, double) {
                if (seen[n]) return;
                seen[n] = 1;
                const float least = std::nextafter(std::nextafter(from.height_m, 1e30f), 1e30f);
                heights_[n] = std::max(heights_[n], least);
                open.push({heights_[n], n});
            });
        }
    }

    // The area that drains through each cell, its own with it, in square metres.
    [[nodiscard]] std::vector<float> areas() const {
        std::vector<std::uint32_t> order(cells_);
        std::iota(order.begin(), order.end(), 0u);
        std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
            return heights_[a] != heights_[b] ? heights_[a] > heights_[b] : a < b;
        });
        std::vector<float> area(cells_, static_cast<float>(grid_.spacing_m[0] * grid_.spacing_m[1]));
        for (const std::uint32_t i : order) {
            double share[8] = {}, all = 0;
            int k = 0;
            for_neighbours(i, [&](std::uint32_t n, double distance_m) {
                const double fall = (static_cast<double>(heights_[i]) - static_cast<double>(heights_[n])) / distance_m;
                share[k] = fall > 0 ? std::pow(fall, 1.1) : 0;
                all += share[k++];
            });
            if (all <= 0) continue;
            k = 0;
            for_neighbours(i, [&](std::uint32_t n, double) {
                area[n] += static_cast<float>(static_cast<double>(area[i]) * (share[k++] / all));
            });
        }
        return area;
    }

    [[nodiscard]] double steepest(std::uint32_t i) const {
        double steepest = 0;
        for_neighbours(i, [&](std::uint32_t n, double distance_m) {
            steepest =
                std::max(steepest, (static_cast<double>(heights_[i]) - static_cast<double>(heights_[n])) / distance_m);
        });
        return steepest;
    }

private:
    [[nodiscard]] std::int32_t column(std::uint32_t i) const { return static_cast<std::int32_t>(i) % grid_.columns; }
    [[nodiscard]] std::int32_t row(std::uint32_t i) const { return static_cast<std::int32_t>(i) / grid_.columns; }
    [[nodiscard]] bool on_rim(std::uint32_t i) const {
        return column(i) == 0 || row(i) == 0 || column(i) == grid_.columns - 1 || row(i) == grid_.rows - 1;
    }
    template <typename Visit>
    void for_neighbours(std::uint32_t i, Visit visit) const {
        for (const auto& to : around) {
            const std::int32_t x = column(i) + to[0], y = row(i) + to[1];
            if (x < 0 || y < 0 || x >= grid_.columns || y >= grid_.rows) continue;
            visit(static_cast<std::uint32_t>(y * grid_.columns + x),
                  std::hypot(to[0] * grid_.spacing_m[0], to[1] * grid_.spacing_m[1]));
        }
    }

    const WetnessGrid& grid_;
    std::vector<float>& heights_;
    std::size_t cells_;
};

} // namespace

WetnessGrid wetness_grid(std::int32_t sample_columns, std::int32_t sample_rows, const double (&spacing_m)[2]) {
    WetnessGrid grid;
    while ((std::max(sample_columns, sample_rows) - 1) >> grid.factor_log2 >= max_wetness_cells) ++grid.factor_log2;
    grid.columns = ((sample_columns - 1) >> grid.factor_log2) + 1;
    grid.rows = ((sample_rows - 1) >> grid.factor_log2) + 1;
    for (const int axis : {0, 1}) grid.spacing_m[axis] = std::ldexp(spacing_m[axis], grid.factor_log2);
    return grid;
}

Wetness::Wetness(const WetnessGrid& grid, std::vector<float> heights_m) : grid_(grid) {
    constexpr double least_slope = 0.001; // of what is level, or was filled
    Drainage drainage(grid_, heights_m);
    drainage.fill();
    index_ = drainage.areas();
    const double contour_m = 0.5 * (grid_.spacing_m[0] + grid_.spacing_m[1]);
    for (std::uint32_t i = 0; i < index_.size(); ++i)
        index_[i] = static_cast<float>(
            std::log(static_cast<double>(index_[i]) / contour_m / std::max(drainage.steepest(i), least_slope)));
}

Wetness Wetness::found(const WetnessGrid& grid, std::vector<float> index) {
    Wetness wetness;
    wetness.grid_ = grid;
    wetness.index_ = std::move(index);
    return wetness;
}

float Wetness::at(std::int32_t column, std::int32_t row) const {
    const auto place = [&](std::int32_t sample, std::int32_t cells, std::int32_t& cell) {
        const double at = std::clamp(std::ldexp(sample + 0.5, -grid_.factor_log2) - 0.5, 0.0, cells - 1.0);
        cell = std::min(static_cast<std::int32_t>(at), std::max(cells - 2, 0));
        return static_cast<float>(at - cell);
    };
    std::int32_t x = 0, y = 0;
    const float east = place(column, grid_.columns, x), south = place(row, grid_.rows, y);
    const std::int32_t x1 = std::min(x + 1, grid_.columns - 1), y1 = std::min(y + 1, grid_.rows - 1);
    const float north_row = of_cell(x, y) + (of_cell(x1, y) - of_cell(x, y)) * east;
    const float south_row = of_cell(x, y1) + (of_cell(x1, y1) - of_cell(x, y1)) * east;
    return north_row + (south_row - north_row) * south;
}

} // namespace fjell::baker
