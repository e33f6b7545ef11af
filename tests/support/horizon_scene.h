// Horizons of small terrains: as a bake makes them, and as rays through every sample find them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "baker/maps/horizon.h"
#include "baker/maps/maps.h"
#include "fjell/pack.h"
#include "fjell/texture.h"
#include "support/map_scene.h"

namespace fjell::test {

struct HeightField {
    std::int32_t columns = 0, rows = 0;
    double spacing_m[2] = {1, 1};
    std::function<double(int x, int y)> height_m;
};

// All levels in memory.
class HorizonScene {
public:
    HorizonScene(const HeightField& field) : levels(field.columns, field.rows, field.spacing_m) {
        for (int level = 0; level < levels.count(); ++level) {
            const baker::Window& all = levels.extents(level);
            std::vector<float> heights(all.area());
            if (level == 0)
                for (std::int32_t y = 0, i = 0; y < all.rows; ++y)
                    for (std::int32_t x = 0; x < all.columns; ++x, ++i)
                        heights[static_cast<std::size_t>(i)] = static_cast<float>(field.height_m(x, y));
            else
                baker::halve_level(all_.back().data(), levels.extents(level - 1), levels.extents(level - 1), all,
                                   heights.data());
            all_.push_back(std::move(heights));
        }
    }
    [[nodiscard]] baker::TexelPlanes of(int stride_log2, const baker::Window& points) const {
        std::vector<baker::LevelWindow> seen;
        for (int level = 0; level < levels.count(); ++level) {
            const baker::Window at = baker::seen_of_level(level, stride_log2, points), all = levels.extents(level);
            baker::LevelWindow window{at, {}};
            for (int y = at.y; y < at.y + at.rows; ++y)
                for (int x = at.x; x < at.x + at.columns; ++x)
                    window.heights_m.push_back(
                        x < 0 || y < 0 || x >= all.columns || y >= all.rows
                            ? baker::no_ground_m
                            : all_[static_cast<std::size_t>(level)][static_cast<std::size_t>(y * all.columns + x)]);
            seen.push_back(std::move(window));
        }
        return baker::horizons(levels, stride_log2, points, seen);
    }
    [[nodiscard]] float height_m(std::int32_t x, std::int32_t y) const {
        return all_[0][static_cast<std::size_t>(y * levels.extents(0).columns + x)];
    }

    baker::HorizonLevels levels;

private:
    std::vector<std::vector<float>> all_;
};

// [mip][tile]
inline std::vector<std::vector<baker::MipTexels>> all_horizons(const baker::MapPlan& plan, const HorizonScene& scene) {
    const auto tiles = static_cast<std::uint32_t>(plan.tree.tiles_x * plan.tree.tiles_y);
    std::vector<std::vector<baker::MipTexels>> mips(mip_count(plan.horizon_log2));
    for (std::uint32_t tile = 0; tile < tiles; ++tile) {
        auto near = baker::near_mips_from(plan, baker::MapKind::horizon, tile,
                                          scene.of(plan.stride_log2(baker::MapKind::horizon),
                                                   baker::points_for_map(plan, baker::MapKind::horizon, tile)));
        for (std::size_t m = 0; m < near.size(); ++m) mips[m].push_back(std::move(near[m]));
    }
    constexpr auto kind = baker::MapKind::horizon;
    for (std::uint32_t m = baker::near_mips; m < mips.size(); ++m)
        for (std::uint32_t tile = 0; tile < tiles; ++tile)
            mips[m].push_back(baker::far_mip(
                plan, kind, m, tile, gather(plan, kind, m - 1, baker::finer_texels(plan, kind, m, tile), mips[m - 1])));
    return mips;
}

// Elevation in degrees of the highest ground that a ray from a sample meets: heights between samples bilinear, a step
// every quarter of the lesser spacing.
inline double traced_horizon_deg(const HorizonScene& scene, std::int32_t x, std::int32_t y, double azimuth_deg) {
    constexpr double radians = 3.14159265358979323846 / 180;
    const baker::Window& all = scene.levels.extents(0);
    const auto& spacing = scene.levels.spacing_m();
    const double unit = std::min(spacing[0], spacing[1]), own = static_cast<double>(scene.height_m(x, y));
    const double east = std::sin(azimuth_deg * radians) * unit / spacing[0],
                 south = -std::cos(azimuth_deg * radians) * unit / spacing[1];
    double tangent = 0;
    for (double d = 0.25;; d += 0.25) {
        // Along an axis a ray stays on it, whatever sines and cosines are rounded to.
        const double u = x + (std::abs(east) < 1e-9 ? 0 : d * east), v = y + (std::abs(south) < 1e-9 ? 0 : d * south);
        if (u < 0 || v < 0 || u > all.columns - 1 || v > all.rows - 1) break;
        const int i = std::min(static_cast<int>(u), all.columns - 2), j = std::min(static_cast<int>(v), all.rows - 2);
        const double a = u - i, b = v - j;
        const auto h = [&](int p, int q) { return static_cast<double>(scene.height_m(i + p, j + q)); };
        const double ground = (h(0, 0) * (1 - a) + h(1, 0) * a) * (1 - b) + (h(0, 1) * (1 - a) + h(1, 1) * a) * b;
        tangent = std::max(tangent, (ground - own) / (d * unit));
    }
    return std::atan(tangent) / radians;
}

} // namespace fjell::test
