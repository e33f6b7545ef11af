#include "baker/heights/fill.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "baker/store/parallel.h"

namespace fjell::baker {

namespace {

constexpr std::int32_t piece_side = 1024; // samples a side that one piece of work covers
// Sweeps that take out the coarse grid's corners; the coarse grid takes care of the rest. Each one looks one sample
// further, twice (see relax): what is cut off further away cannot be felt.
constexpr int sweeps = 8;
constexpr std::int32_t halo = fill_halo;
static_assert(halo == 2 * sweeps);

struct Grid {
    Window at; // of its level
    std::vector<float> values;

    Grid(const Store<float>& from, const Window& w) : at(w), values(w.area()) {
        from.read(w, values.data(), w.columns);
    }
    explicit Grid(const Window& w) : at(w), values(w.area()) {}
    [[nodiscard]] std::size_t index(std::int32_t x, std::int32_t y) const { // of the level
        return static_cast<std::size_t>(y - at.y) * static_cast<std::size_t>(at.columns) +
               static_cast<std::size_t>(x - at.x);
    }
};

Window whole(const Store<float>& level) {
    return {0, 0, static_cast<std::int32_t>(level.columns()), static_cast<std::int32_t>(level.rows())};
}
Window clipped(std::int32_t x0, std::int32_t y0, std::int32_t x1, std::int32_t y1, const Window& level) {
    return common({x0, y0, x1 - x0, y1 - y0}, level);
}
Window clipped(std::int32_t x0, std::int32_t y0, std::int32_t x1, std::int32_t y1, const Store<float>& level) {
    return clipped(x0, y0, x1, y1, whole(level));
}

// body(piece): pieces of a window, in parallel.
template <typename Body>
void for_each_chunk(const Window& window, int threads, const Body& body) {
    const std::int64_t across = (window.columns - 1) / piece_side + 1, down = (window.rows - 1) / piece_side + 1;
    parallel_for(across * down, threads, [&](std::int64_t i) {
        const auto x = window.x + static_cast<std::int32_t>(i % across) * piece_side,
                   y = window.y + static_cast<std::int32_t>(i / across) * piece_side;
        body(clipped(x, y, x + piece_side, y + piece_side, window));
    });
}

} // namespace

bool halve_heights(const Store<float>& fine, const Window& window, int threads, Store<float>& coarse) {
    std::atomic<bool> voids{false};
    for_each_chunk(window, threads, [&](const Window& w) {
        const Grid from(fine, clipped(2 * w.x, 2 * w.y, 2 * (w.x + w.columns), 2 * (w.y + w.rows), fine));
        Grid to(w);
        for (std::int32_t y = w.y; y < w.y + w.rows; ++y)
            for (std::int32_t x = w.x; x < w.x + w.columns; ++x) {
                double sum = 0;
                int count = 0;
                for (std::int32_t fy = 2 * y; fy < std::min(2 * y + 2, from.at.y + from.at.rows); ++fy)
                    for (std::int32_t fx = 2 * x; fx < std::min(2 * x + 2, from.at.x + from.at.columns); ++fx) {
                        const float v = from.values[from.index(fx, fy)];
                        if (!std::isnan(v)) sum += static_cast<double>(v), ++count;
                    }
                if (count == 0) voids = true;
                to.values[to.index(x, y)] =
                    count ? static_cast<float>(sum / count) : std::numeric_limits<float>::quiet_NaN();
            }
        coarse.write(w, to.values.data(), w.columns);
    });
    return voids;
}

namespace {

// The coarse grid at the middle of a fine cell, between its four nearest.
float interpolate(const Grid& coarse, const Store<float>& level, std::int32_t x, std::int32_t y) {
    const std::int32_t near_x = x / 2, near_y = y / 2;
    const std::int32_t far_x = std::clamp(near_x + (x % 2 ? 1 : -1), 0, static_cast<std::int32_t>(level.columns()) - 1);
    const std::int32_t far_y = std::clamp(near_y + (y % 2 ? 1 : -1), 0, static_cast<std::int32_t>(level.rows()) - 1);
    const auto& v = coarse.values;
    return 0.5625f * v[coarse.index(near_x, near_y)] + 0.1875f * v[coarse.index(far_x, near_y)] +
           0.1875f * v[coarse.index(near_x, far_y)] + 0.0625f * v[coarse.index(far_x, far_y)];
}

// One sweep over the voids, first those of even x + y, then the odd ones: each becomes the mean of its neighbours.
// Within one half no void looks at another, so the order does not matter.
void relax(Grid& grid, const std::vector<std::size_t>& voids) {
    const auto columns = static_cast<std::size_t>(grid.at.columns);
    const auto parity_of_corner = static_cast<std::size_t>(grid.at.x + grid.at.y);
    for (const std::size_t half : {std::size_t{0}, std::size_t{1}})
        for (const std::size_t i : voids) {
            const std::size_t x = i % columns;
            if (((x + i / columns + parity_of_corner) & 1) != half) continue;
            float sum = 0, count = 0;
            const auto add = [&](std::size_t j) { sum += grid.values[j], ++count; };
            if (x > 0) add(i - 1);
            if (x + 1 < columns) add(i + 1);
            if (i >= columns) add(i - columns);
            if (i + columns < grid.values.size()) add(i + columns);
            grid.values[i] = sum / count;
        }
}

// One piece of a level, from that level's means and the coarser level, which is filled.
void fill_chunk(const Store<float>& level, const Store<float>& coarse, const FillStep& step, const Window& w,
                Store<float>& out) {
    Grid grid(level, clipped(w.x - halo, w.y - halo, w.x + w.columns + halo, w.y + w.rows + halo, level));
    std::vector<std::size_t> voids;
    for (std::size_t i = 0; i < grid.values.size(); ++i)
        if (std::isnan(grid.values[i])) voids.push_back(i);
    if (!voids.empty()) {
        const Window& g = grid.at;
        const Grid from(coarse, seen_coarser(w, whole(level), whole(coarse)));
        const auto columns = static_cast<std::size_t>(g.columns);
        for (const std::size_t i : voids)
            grid.values[i] = interpolate(from, coarse, g.x + static_cast<std::int32_t>(i % columns),
                                         g.y + static_cast<std::int32_t>(i / columns));
        for (int k = 0; k < sweeps; ++k) relax(grid, voids);
        if (step.quantum_m > 0)
            for (const std::size_t i : voids) {
                float& h = grid.values[i];
                h = static_cast<float>(std::round((static_cast<double>(h) - step.anchor_m) / step.quantum_m) *
                                           step.quantum_m +
                                       step.anchor_m);
            }
    }
    out.write(w, grid.values.data() + grid.index(w.x, w.y), grid.at.columns);
}

} // namespace

Window seen_coarser(const Window& w, const Window& level, const Window& coarse) {
    const Window g = clipped(w.x - halo, w.y - halo, w.x + w.columns + halo, w.y + w.rows + halo, level);
    return clipped(g.x / 2 - 1, g.y / 2 - 1, (g.x + g.columns) / 2 + 2, (g.y + g.rows) / 2 + 2, coarse);
}

void fill_level(const Store<float>& level, const Store<float>& coarse, const FillStep& step, const Window& window,
                int threads, Store<float>& out) {
    for_each_chunk(window, threads, [&](const Window& w) { fill_chunk(level, coarse, step, w, out); });
}

void fill_voids(const FillInput& input, Store<float>& out) {
    std::vector<Store<float>> means; // of level 1, 2, ...
    for (bool voids = true; voids;) {
        const Store<float>& fine = means.empty() ? input.raw : means.back();
        const std::string name = "means" + std::to_string(means.size() + 1);
        Store<float> coarse = input.make(name, (fine.columns() + 1) / 2, (fine.rows() + 1) / 2);
        voids =
            halve_heights(fine, whole(coarse), input.threads, coarse) && (coarse.columns() > 1 || coarse.rows() > 1);
        means.push_back(std::move(coarse));
    }
    Store<float> filled = std::move(means.back());
    for (std::size_t level = means.size() - 1; level > 0; --level) {
        Store<float>& from = means[level - 1];
        Store<float> to = input.make("filled" + std::to_string(level), from.columns(), from.rows());
        fill_level(from, filled, {}, whole(from), input.threads, to);
        filled.remove();
        from.remove();
        filled = std::move(to);
    }
    fill_level(input.raw, filled, input.step, whole(input.raw), input.threads, out);
    filled.remove();
}

} // namespace fjell::baker
