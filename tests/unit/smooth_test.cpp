// The smooth surface that slopes are taken from, where heights are counted in steps.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "baker/check/verify_maps.h"
#include "baker/maps/smooth.h"
#include "fjell/texture.h"
#include "support/splat_rules.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::baker;
using namespace fjell::test;

namespace {

constexpr std::int32_t hills_side = 257;

// Hills a metre a sample; steps: what heights are rounded to; noise_m: added afterwards.
Dem counted_hills(double step_m, double noise_m) {
    Random random(42);
    Dem dem;
    dem.columns = dem.rows = hills_side;
    for (int y = 0; y < hills_side; ++y)
        for (int x = 0; x < hills_side; ++x) {
            double h = 30 * std::sin(x / 97.0) * std::cos(y / 131.0) + 9 * std::sin(x / 31.0 + y / 53.0) +
                       2.5 * std::sin(x / 17.0 - y / 23.0) + 0.05 * x;
            if (step_m > 0) h = std::round(h / step_m) * step_m;
            dem.heights_m.push_back(static_cast<float>(h + (noise_m > 0 ? uniform(random, -noise_m, noise_m) : 0)));
        }
    dem.native_quantum_m = noise_m > 0 ? 0 : step_m;
    return dem;
}

SmoothGround smooth_of(const Dem& dem) {
    return smooth_ground(dem.columns, dem.rows, dem.spacing_m, dem.native_quantum_m,
                         measure_tile(dem.heights_m.data(), dem.columns, dem.rows, dem.columns));
}

std::vector<float> part_of_hills(const Dem& dem, const Window& w) {
    std::vector<float> heights;
    for (int y = w.y; y < w.y + w.rows; ++y)
        for (int x = w.x; x < w.x + w.columns; ++x) heights.push_back(dem.at(x, y));
    return heights;
}

Buffer<float> surface(const Dem& dem, const SmoothGround& ground, const Window& wanted) {
    const Window seen = heights_for_smooth(ground, wanted);
    const std::vector<float> heights = part_of_hills(dem, seen);
    return smooth_heights(ground, {heights.data(), seen.columns, seen}, wanted);
}

constexpr const char* shape_rules = R"({"rules": [{"layer": "grass"},
  {"layer": "soil", "curvature_per_km": [null, -20], "curvature_soft_per_km": 20},
  {"layer": "scree", "slope_deg": [12, null], "slope_soft_deg": 8, "ragged": 0},
  {"layer": "rock", "slope_deg": [24, null], "slope_soft_deg": 12, "ragged": 0},
  {"layer": "water", "slope_deg": [null, 0.4], "slope_soft_deg": 0.4, "ragged": 0}]})";

// Of all layers the shares in mip 0 of all tiles, max_splat_names a texel.
std::vector<float> shares_of_all(const Dem& dem) {
    const RulesFile rules(shape_rules);
    BakeOptions options = small_bake(6);
    options.max_texture_log2 = 6;
    options.layers_path = rules.path();
    const auto loaded = bake_and_load(dem, options);
    std::vector<float> shares;
    for (std::uint32_t tile = 0; tile < loaded.pack.header.tiles_x * loaded.pack.header.tiles_y; ++tile) {
        const ChunkId id{ChunkKind::splat, tile, 0};
        std::vector<std::byte> texels(chunk_raw_bytes(loaded.pack.header, id));
        REQUIRE(read_chunk(loaded.pack, id, texels).ok());
        for (std::size_t i = 0; i < texels.size(); i += splat_texel_bytes) {
            float of_texel[max_splat_names] = {};
            for (std::size_t k = 0; k < splat_layers; ++k)
                of_texel[std::to_integer<std::size_t>(texels[i + 2 * k + 1])] +=
                    static_cast<float>(std::to_integer<int>(texels[i + 2 * k])) / 255;
            shares.insert(shares.end(), of_texel, of_texel + max_splat_names);
        }
    }
    return shares;
}

// How much of the ground shows another layer, in percent.
double others_percent(const std::vector<float>& a, const std::vector<float>& b) {
    REQUIRE(a.size() == b.size());
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += std::abs(static_cast<double>(a[i]) - static_cast<double>(b[i]));
    return 100 * 0.5 * sum / static_cast<double>(a.size() / max_splat_names);
}

double slope_of_hills(const float* h, std::int32_t columns, std::int32_t x, std::int32_t y) {
    const auto at = [&](std::int32_t u, std::int32_t v) {
        return static_cast<double>(
            h[static_cast<std::size_t>(v) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(u)]);
    };
    return std::atan(std::hypot(at(x + 1, y) - at(x - 1, y), at(x, y + 1) - at(x, y - 1)) / 2) * 180 / 3.14159265358979;
}

} // namespace

TEST_CASE("the smooth surface is within half a step of every height, and the same however windows are cut") {
    for (const double step : {1.0, 0.1}) {
        const Dem dem = counted_hills(step, 0);
        const SmoothGround ground = smooth_of(dem);
        REQUIRE(ground.smooths());
        CHECK(ground.step_m == static_cast<float>(step));
        const Window all{0, 0, hills_side, hills_side};
        const Buffer<float> whole = surface(dem, ground, all);
        double most = 0;
        for (std::size_t i = 0; i < whole.size(); ++i)
            most = std::max(most, std::abs(static_cast<double>(whole[i]) - static_cast<double>(dem.heights_m[i])));
        CHECK(most <= 0.5 * step * (1 + 1e-5));
        CHECK(most > 0.3 * step);
        Random random(7);
        for (int i = 0; i < 20; ++i) {
            const Window w{pick(random, 0, hills_side - 2), pick(random, 0, hills_side - 2), 0, 0};
            const Window cut{w.x, w.y, pick(random, 1, hills_side - w.x), pick(random, 1, hills_side - w.y)};
            const Buffer<float> made = surface(dem, ground, cut);
            std::size_t other = 0;
            for (int y = 0; y < cut.rows; ++y)
                for (int x = 0; x < cut.columns; ++x)
                    other += made[static_cast<std::size_t>(y * cut.columns + x)] !=
                             whole[static_cast<std::size_t>((y + cut.y) * hills_side + x + cut.x)];
            CAPTURE(cut.x, cut.y, cut.columns, cut.rows);
            REQUIRE(other == 0);
        }
    }
}

TEST_CASE("an even slope of whole metres stays one up to the rim, and level ground level") {
    Dem dem;
    dem.columns = 90, dem.rows = 70;
    dem.native_quantum_m = 1;
    for (int y = 0; y < dem.rows; ++y)
        for (int x = 0; x < dem.columns; ++x) dem.heights_m.push_back(static_cast<float>(2 * x - y));
    const Window all{0, 0, dem.columns, dem.rows};
    Buffer<float> smooth = surface(dem, smooth_of(dem), all);
    for (std::size_t i = 0; i < smooth.size(); ++i) REQUIRE(smooth[i] == Approx(dem.heights_m[i]).margin(1e-3));
    std::fill(dem.heights_m.begin(), dem.heights_m.end(), 7.0f);
    smooth = surface(dem, smooth_of(dem), all);
    CHECK(std::all_of(smooth.begin(), smooth.end(), [](float h) { return h == 7; }));
}

TEST_CASE("slopes of whole metres and decimetres come within a degree or two of what they were before rounding") {
    const Dem truth = counted_hills(0, 0);
    for (const auto& [step, most_deg] : {std::pair{1.0, 2.0}, std::pair{0.1, 0.3}}) {
        const Dem dem = counted_hills(step, 0);
        const Buffer<float> smooth = surface(dem, smooth_of(dem), {0, 0, hills_side, hills_side});
        double off = 0, raw_off = 0;
        for (int y = 1; y + 1 < hills_side; ++y)
            for (int x = 1; x + 1 < hills_side; ++x) {
                const double wanted = slope_of_hills(truth.heights_m.data(), hills_side, x, y);
                off += std::pow(slope_of_hills(smooth.data(), hills_side, x, y) - wanted, 2);
                raw_off += std::pow(slope_of_hills(dem.heights_m.data(), hills_side, x, y) - wanted, 2);
            }
        const double n = (hills_side - 2.0) * (hills_side - 2.0);
        std::printf("steps of %g m: slopes off by %.2f degrees, of the heights alone %.2f\n", step, std::sqrt(off / n),
                    std::sqrt(raw_off / n));
        CHECK(std::sqrt(off / n) < most_deg);
        CHECK(std::sqrt(raw_off / n) > 3 * std::sqrt(off / n));
    }
}

TEST_CASE("a terrain of whole metres or decimetres and the same with 2 cm of noise get the same layers to 2%") {
    for (const double step : {1.0, 0.1}) {
        const std::vector<float> whole = shares_of_all(counted_hills(step, 0)),
                                 noisy = shares_of_all(counted_hills(step, 0.02));
        const double others = others_percent(whole, noisy);
        std::printf("steps of %g m, and with noise: %.2f%% of the ground in other layers\n", step, others);
        CHECK(others < 2);
    }
}

TEST_CASE("heights that are no whole metres, and steps that slopes do not show, are left as they are") {
    CHECK(!smooth_of(counted_hills(0, 0)).smooths());
    CHECK(!smooth_of(counted_hills(0, 0.02)).smooths());
    CHECK(smooth_of(counted_hills(0.1, 0.019)).step_m == 0.1f);
    CHECK(smooth_of(counted_hills(1, 0.02)).step_m == 1.0f);
    Dem far = counted_hills(0.1, 0);
    far.spacing_m[0] = far.spacing_m[1] = 30;
    CHECK(!smooth_of(far).smooths());
    // A lake in ground of centimetres: nearly all samples are level, and those say nothing.
    Dem lake = counted_hills(0, 0);
    for (float& h : lake.heights_m) h = h < 20 ? 20 : h;
    CHECK(!smooth_of(lake).smooths());
}
