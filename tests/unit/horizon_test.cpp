// Horizon maps: what a texel says of the ground around it, against rays and against ground whose horizon is known.
#include <catch2/catch.hpp>

#include <cmath>
#include <random>
#include <tuple>

#include "baker/check/verify_maps.h"
#include "support/horizon_scene.h"
#include "support/rounds.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::baker;
using namespace fjell::test;

namespace {

constexpr double radians_a_degree = 3.14159265358979323846 / 180;

MapPlan horizon_plan(const Tree& tree, std::uint32_t log2) {
    MapPlan plan;
    plan.tree = tree;
    plan.horizon_log2 = log2;
    return plan;
}

HeightField field_of(const Tree& tree, std::function<double(int, int)> height_m, double east_m = 10,
                     double south_m = 10) {
    return {tree.columns(), tree.rows(), {east_m, south_m}, std::move(height_m)};
}

HeightField field_of(const Dem& dem) {
    return {dem.columns, dem.rows, {dem.spacing_m[0], dem.spacing_m[1]}, [&dem](int x, int y) { return dem.at(x, y); }};
}

std::vector<std::uint8_t> codes_of(const MipTexels& mip, std::uint32_t side) {
    std::vector<std::uint8_t> codes(std::size_t{side} * side * horizon_planes);
    REQUIRE(decode_horizon(mip.blocks, side, codes).ok());
    return codes;
}

struct ErrorsDeg {
    double mean = 0, rms = 0, p95 = 0, most = 0;
};
ErrorsDeg errors_of(std::vector<double> off) {
    ErrorsDeg e;
    for (double& d : off) {
        e.mean += d / static_cast<double>(off.size());
        e.rms += d * d / static_cast<double>(off.size());
        d = std::abs(d);
    }
    e.rms = std::sqrt(e.rms);
    std::sort(off.begin(), off.end());
    e.p95 = off[off.size() * 95 / 100];
    e.most = off.back();
    return e;
}

// Marched less traced, at random points.
ErrorsDeg marching_errors(const HorizonScene& scene, int points, unsigned seed) {
    std::mt19937 random(seed);
    const Window all = scene.levels.extents(0);
    std::vector<double> off;
    for (int n = 0; n < points; ++n) {
        const auto x = static_cast<std::int32_t>(random() % static_cast<unsigned>((all.columns + 1) / 2)),
                   y = static_cast<std::int32_t>(random() % static_cast<unsigned>((all.rows + 1) / 2));
        const TexelPlanes planes = scene.of(1, {x, y, 1, 1});
        for (std::size_t k = 0; k < horizon_directions; ++k)
            off.push_back(std::asin(static_cast<double>(planes.channel[k][0])) / radians_a_degree -
                          traced_horizon_deg(scene, 2 * x, 2 * y, 24.0 * static_cast<double>(k)));
    }
    return errors_of(std::move(off));
}

} // namespace

TEST_CASE("flat ground sees all of the sky and no horizon, exactly, in every mip") {
    for (const Tree& tree : {Tree{5, 2, 2}, Tree::covering(39, 21, 4), Tree{1, 2, 3}}) {
        const MapPlan plan = horizon_plan(tree, 4);
        const auto mips = all_horizons(plan, HorizonScene(field_of(tree, [](int, int) { return 1234.567; })));
        REQUIRE(mips.size() == 3);
        for (std::uint32_t m = 0; m < mips.size(); ++m)
            for (const MipTexels& mip : mips[m]) {
                const auto codes = codes_of(mip, 16 >> m);
                for (std::size_t i = 0; i < codes.size(); ++i)
                    REQUIRE(codes[i] == (i % horizon_planes == horizon_directions ? 255 : 0));
            }
    }
}

TEST_CASE("an endless slope is its own horizon, and the sky over it counts as whole") {
    const Tree tree{5, 2, 2};
    for (const auto& [east, south] : {std::pair{0.5, 0.0}, {0.0, -0.25}, {-2.0, 1.0}, {3.0, 4.0}}) {
        const HorizonScene scene(field_of(
            tree, [e = east, s = south](int x, int y) { return 1000 + e * 10 * x + s * 20 * y; }, 10, 20));
        const TexelPlanes planes = scene.of(1, {4, 4, 20, 20});
        for (std::size_t k = 0; k < horizon_directions; ++k) {
            const double azimuth = 24.0 * static_cast<double>(k) * radians_a_degree;
            const double rise = std::max(0.0, east * std::sin(azimuth) - south * std::cos(azimuth));
            // Half of a level's rise over a cell, to both sides, is 3/4 raised; from 12 cells away.
            const double raised = 0.75 / 12 * (std::abs(east) + 2 * std::abs(south));
            for (const float sine : planes.channel[k]) {
                const double tangent = static_cast<double>(sine) / std::sqrt(1 - static_cast<double>(sine * sine));
                REQUIRE(tangent >= rise - 1e-4);
                REQUIRE(tangent <= rise + raised);
            }
        }
        for (const float sky : planes.channel[horizon_directions])
            REQUIRE(static_cast<double>(sky) == Approx(1).margin(0.01)); // what is raised hides
    }
}

TEST_CASE("horizons lie near those of rays through every sample") {
    // Fractals as steep as mountains and as the roughest ground. What is left is mostly ground less than a sample away,
    // where a ray's first step is.
    std::mt19937 random(7);
    for (const auto& [relief, most_rms_deg, most_p95_deg] : {std::tuple{0.3, 0.4, 0.8}, {1.0, 0.9, 2.1}}) {
        Dem dem = random_dem(random, 257, 193, Shape::fractal);
        const auto [low, high] = std::minmax_element(dem.heights_m.begin(), dem.heights_m.end());
        const double range = static_cast<double>(*high - *low);
        dem.spacing_m[0] = range / relief / 64;
        dem.spacing_m[1] = dem.spacing_m[0] * 1.5;
        const HorizonScene scene(field_of(dem));
        const ErrorsDeg e = marching_errors(scene, rounds(60, 600), 8);
        CAPTURE(relief, e.mean, e.rms, e.p95, e.most);
        CHECK(std::abs(e.mean) < 0.2);
        CHECK(e.rms < most_rms_deg);
        CHECK(e.p95 < most_p95_deg);
    }
}

TEST_CASE("a far ridge is seen as high as it stands, and nothing stands beyond the rim") {
    const Tree tree = Tree::covering(601, 601, 7);
    // A ridge from west to east, 750 m high and 1 km wide; direction 0 is north, 7 and 8 are 12 degrees beside south.
    const HorizonScene scene(
        field_of(tree, [](int, int y) { return std::max(0.0, 750.0 - std::abs(y - 100) * 15.0); }));
    for (const int y : {160, 200, 300, 400, 500, 580}) {
        const TexelPlanes planes = scene.of(1, {150, y / 2, 1, 1});
        const double height = std::sin(std::atan(750 / (10.0 * (y - 100))));
        const auto north = static_cast<double>(planes.channel[0][0]);
        CAPTURE(y, north, height);
        CHECK(north / height > 0.9);
        CHECK(north / height < 1.02);
        CHECK((planes.channel[7][0] == 0 && planes.channel[8][0] == 0));
    }
    const TexelPlanes rim = scene.of(1, {150, 1, 1, 1}); // beyond the ridge
    CHECK(rim.channel[0][0] == 0.0f);
    CHECK(rim.channel[7][0] > 0.0f);
}

TEST_CASE("the sky's share is that of rays in all directions, in a pit, on a peak and before a wall") {
    // A wall of height 8 across the north, seen from a distance of 8.
    const Tree tree{7, 1, 1};
    const HorizonScene wall(field_of(tree, [](int, int y) { return y <= 56 ? 80.0 : 0.0; }));
    const TexelPlanes before = wall.of(0, {64, 64, 1, 1});
    double sky = 0;
    for (std::size_t k = 0; k < horizon_directions; ++k) {
        const double sine = static_cast<double>(before.channel[k][0]);
        sky += (1 - sine * sine) / horizon_directions;
    }
    CHECK(static_cast<double>(before.channel[horizon_directions][0]) == Approx(sky).margin(1e-3));
    CHECK(static_cast<double>(before.channel[0][0]) == Approx(std::sqrt(0.5)).margin(1e-4));
    const HorizonScene peak(
        field_of(tree, [](int x, int y) { return -1.0 * ((x - 64) * (x - 64) + (y - 64) * (y - 64)); }));
    CHECK(peak.of(0, {64, 64, 1, 1}).channel[horizon_directions][0] == 1.0f);
    const HorizonScene pit(field_of(tree, [](int x, int y) { return x == 64 && y == 64 ? -1000.0 : 0.0; }));
    CHECK(pit.of(0, {64, 64, 1, 1}).channel[horizon_directions][0] < 0.01f);
}

TEST_CASE("neighbouring tiles compute equal horizons on their border, in every mip") {
    for (const std::uint32_t log2 : {2u, 3u, 4u, 5u})
        for (const Tree& tree : {Tree{4, 3, 2}, Tree{2, 2, 3}, Tree{6, 2, 2}, Tree::covering(39, 21, 4)}) {
            const MapPlan plan = horizon_plan(tree, log2);
            const auto mips = all_horizons(
                plan, HorizonScene(field_of(
                          tree, [](int x, int y) { return (x * 7919 + y * 104729) % 97 + 0.3 * x; }, 10, 20)));
            const auto tiles_x = static_cast<std::uint32_t>(tree.tiles_x);
            int compared = 0;
            for (std::uint32_t m = 0; m < mips.size(); ++m) {
                const auto side = static_cast<std::size_t>(plan.texels(MapKind::horizon, m, 0).columns);
                for (std::uint32_t tile = 0; tile < mips[m].size(); ++tile) {
                    const Texels& here = mips[m][tile].texels;
                    REQUIRE(mips[m][tile].blocks.size() == blocks_of(1u << (log2 - m)) * horizon_block_bytes);
                    if (here.empty()) continue;
                    for (std::size_t i = 0; i < side; ++i)
                        for (std::size_t c = 0; c < horizon_planes; ++c, ++compared) {
                            if (tile % tiles_x + 1 < tiles_x)
                                REQUIRE(here[(i * side + side - 1) * horizon_planes + c] ==
                                        mips[m][tile + 1].texels[i * side * horizon_planes + c]);
                            if (tile / tiles_x + 1 < static_cast<std::uint32_t>(tree.tiles_y))
                                REQUIRE(here[((side - 1) * side + i) * horizon_planes + c] ==
                                        mips[m][tile + tiles_x].texels[i * horizon_planes + c]);
                        }
                }
            }
            REQUIRE(compared > 0);
        }
}

TEST_CASE("a window's horizons are those of a larger one") {
    std::mt19937 random(9);
    const Dem dem = random_dem(random, 150, 131, Shape::fractal);
    const HorizonScene scene(field_of(dem));
    for (const int stride_log2 : {0, 1, 2, 3}) {
        const Window all{0, 0, ((dem.columns - 2) >> stride_log2) + 2, ((dem.rows - 2) >> stride_log2) + 2};
        const TexelPlanes whole = scene.of(stride_log2, all);
        for (const Window& part : {Window{3, 5, 7, 4}, Window{all.columns - 4, all.rows - 3, 4, 3}}) {
            const TexelPlanes here = scene.of(stride_log2, part);
            for (int c = 0; c < static_cast<int>(horizon_planes); ++c)
                for (std::int32_t y = part.y; y < part.y + part.rows; ++y)
                    for (std::int32_t x = 0; x < part.columns; ++x)
                        REQUIRE(here.row(c, y)[x] == whole.row(c, y)[part.x + x]);
        }
    }
}

TEST_CASE("a baked pack holds horizon maps that verify finds sound, with holes too, and tells that it has them") {
    std::mt19937 random(10);
    for (const int spacing : {2, 4}) {
        Dem dem = random_dem(random, 150, 101, Shape::fractal);
        if (spacing == 4) add_random_holes(random, dem, 5);
        BakeOptions options = small_bake(5);
        options.max_texture_log2 = 5;
        const auto without = bake_and_load(dem, options);
        CHECK(without.pack.header.features == 0);
        options.horizon_spacing = spacing;
        const auto pack = bake_and_load(dem, options);
        CHECK(pack.pack.header.features == pack_has_horizons);
        CHECK(1u << pack.pack.header.horizon_log2 == 32u / static_cast<unsigned>(spacing));
        CHECK(io::check_all_chunks(pack.pack, pack.path) == pack.pack.header.directory_count);
        const MapsReport report = check_maps(pack.pack);
        CAPTURE(spacing, report.first);
        CHECK(report.ok());
        CHECK(report.horizon_border_most > 0); // of compression
    }
}
