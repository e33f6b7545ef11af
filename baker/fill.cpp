#include "baker/fill.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fjell::baker {

namespace {

struct Grid {
    std::int32_t columns, rows;
    std::vector<float> values; // NaN: void

    [[nodiscard]] std::size_t index(std::int32_t x, std::int32_t y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(x);
    }
};

// Means of what is there in each 2 x 2; true when voids are left.
bool halve(const Grid& fine, Grid& coarse) {
    coarse.columns = (fine.columns + 1) / 2;
    coarse.rows = (fine.rows + 1) / 2;
    coarse.values.resize(static_cast<std::size_t>(coarse.columns) * static_cast<std::size_t>(coarse.rows));
    bool voids = false;
    for (std::int32_t y = 0; y < coarse.rows; ++y)
        for (std::int32_t x = 0; x < coarse.columns; ++x) {
            double sum = 0;
            int count = 0;
            for (std::int32_t fy = 2 * y; fy < std::min(2 * y + 2, fine.rows); ++fy)
                for (std::int32_t fx = 2 * x; fx < std::min(2 * x + 2, fine.columns); ++fx) {
                    const float v = fine.values[fine.index(fx, fy)];
                    if (!std::isnan(v)) sum += v, ++count;
                }
            voids |= count == 0;
            coarse.values[coarse.index(x, y)] =
                count ? static_cast<float>(sum / count) : std::numeric_limits<float>::quiet_NaN();
        }
    return voids;
}

// The coarse grid at the middle of a fine cell, between its four nearest.
float interpolate(const Grid& coarse, std::int32_t x, std::int32_t y) {
    const std::int32_t near_x = x / 2, near_y = y / 2;
    const std::int32_t far_x = std::clamp(near_x + (x % 2 ? 1 : -1), 0, coarse.columns - 1);
    const std::int32_t far_y = std::clamp(near_y + (y % 2 ? 1 : -1), 0, coarse.rows - 1);
    const auto& v = coarse.values;
    return 0.5625f * v[coarse.index(near_x, near_y)] + 0.1875f * v[coarse.index(far_x, near_y)] +
           0.1875f * v[coarse.index(near_x, far_y)] + 0.0625f * v[coarse.index(far_x, far_y)];
}

// One sweep of Gauss and Seidel, row by row, over the voids: each becomes the mean of its neighbours.
void relax(Grid& grid, const std::vector<std::size_t>& voids) {
    const auto columns = static_cast<std::size_t>(grid.columns);
    for (const std::size_t i : voids) {
        const std::size_t x = i % columns;
        float sum = 0, count = 0;
        const auto add = [&](std::size_t j) { sum += grid.values[j], ++count; };
        if (x > 0) add(i - 1);
        if (x + 1 < columns) add(i + 1);
        if (i >= columns) add(i - columns);
        if (i + columns < grid.values.size()) add(i + columns);
        grid.values[i] = sum / count;
    }
}

std::vector<std::size_t> fill_from(Grid& grid, const Grid& coarse) {
    const auto is_void = [](float height) { return std::isnan(height); };
    std::vector<std::size_t> voids; // counted first: growing would take twice the memory where most is void
    voids.reserve(static_cast<std::size_t>(std::count_if(grid.values.begin(), grid.values.end(), is_void)));
    for (std::size_t i = 0; i < grid.values.size(); ++i)
        if (is_void(grid.values[i])) voids.push_back(i);
    const auto columns = static_cast<std::size_t>(grid.columns);
    for (const std::size_t i : voids)
        grid.values[i] =
            interpolate(coarse, static_cast<std::int32_t>(i % columns), static_cast<std::int32_t>(i / columns));
    constexpr int sweeps = 8; // takes out the coarse grid's corners; the coarse grid itself settles the rest
    for (int k = 0; k < sweeps; ++k) relax(grid, voids);
    return voids;
}

} // namespace

void fill_voids(std::vector<float>& heights_m, std::int32_t columns, std::int32_t rows, double quantum_m,
                double anchor_m) {
    std::vector<Grid> pyramid(1);
    pyramid[0] = {columns, rows, std::move(heights_m)};
    for (bool voids = true; voids;) {
        Grid coarse{};
        voids = halve(pyramid.back(), coarse) && (coarse.columns > 1 || coarse.rows > 1);
        pyramid.push_back(std::move(coarse));
    }
    for (std::size_t level = pyramid.size() - 1; level-- > 0;) {
        const std::vector<std::size_t> filled = fill_from(pyramid[level], pyramid[level + 1]);
        if (level > 0 || !(quantum_m > 0)) continue;
        for (const std::size_t i : filled) {
            float& h = pyramid[0].values[i];
            h = static_cast<float>(std::round((h - anchor_m) / quantum_m) * quantum_m + anchor_m);
        }
    }
    heights_m = std::move(pyramid[0].values);
}

} // namespace fjell::baker
