// Pictures far from the origin: they are those near it, and hold still as well.
#include <cmath>
#include <vector>

#include "fjell/query.h"
#include "picture_scene.h"
#include "support/dem.h"

using namespace pictures;

namespace {

// Pyramids that repeat every 8 samples, so that the eye can move by whole periods.
baker::Dem pyramids(std::int32_t columns, std::int32_t rows, double spacing_m, double step_m) {
    baker::Dem dem;
    dem.columns = columns;
    dem.rows = rows;
    dem.spacing_m[0] = dem.spacing_m[1] = spacing_m;
    for (std::int32_t y = 0; y < rows; ++y)
        for (std::int32_t x = 0; x < columns; ++x)
            dem.heights_m.push_back(static_cast<float>(step_m * std::min({x & 7, 8 - (x & 7), y & 7, 8 - (y & 7)})));
    return dem;
}

} // namespace

TEST_CASE("a picture far from the origin is bit for bit the one near it", "[picture]") {
    Scene scene(pyramids(8193, 17, 1000, 100), 4);
    const OwnMesh mesh = full_resolution(scene.loaded.terrain);
    const auto look = [&](double column) {
        const View view =
            make_view({column * 1000, 2000, 9250}, {0.8, -0.6, 0}, {0.6, 0.8, 0}, pi / 8, width_px, height_px, 1, 1e5);
        return scene.draw(mesh.view(), view, {.haze = false});
    };
    const Picture near_by = look(16.125), far_away = look(16.125 + 8 * 1016);
    CHECK(std::count(near_by.depth.begin(), near_by.depth.end(), 0.0f) == 0);
    CHECK((near_by.depth == far_away.depth)); // parentheses: on failure Catch would print millions of numbers
    CHECK((look(16.125 + 0.000001).depth != near_by.depth)); // one millimetre is seen
}

TEST_CASE("10,000 km from the origin a picture is the one near it, under motion of less than a metre too",
          "[picture]") {
    constexpr double spacing_m = 10'000, period_m = 1024 * spacing_m; // 10,240 km; a whole number of tiles
    Scene scene(pyramids(1057, 33, spacing_m, 750), 4);
    const OwnMesh mesh = full_resolution(scene.loaded.terrain);
    const auto look = [&](double x, double above_m) {
        const View view =
            make_view({x, above_m, 155'000}, {0.8, -0.6, 0}, {0.6, 0.8, 0}, pi / 8, width_px, height_px, 100, 1e7);
        return scene.draw(mesh.view(), view, {.haze = false});
    };
    constexpr double start_m = 83'125, above_m = 30'000;
    // Steps that a double holds exactly, so that the eye stands in its cell exactly alike: the same bits.
    Picture before = look(start_m, above_m);
    CHECK(std::count(before.depth.begin(), before.depth.end(), 0.0f) == 0);
    for (int i = 1; i <= 4; ++i) {
        const double moved_m = i / 8.0;
        const Picture near_by = look(start_m + moved_m, above_m), far = look(start_m + moved_m + period_m, above_m);
        CHECK((near_by.depth == far.depth)); // parentheses: on failure Catch would print millions of numbers
        CHECK((near_by.colour.rgb == far.colour.rgb));
        CHECK((near_by.depth != before.depth)); // an eighth of a metre is seen
        before = near_by;
    }
    // Steps of a tenth: the eye's place in its cell, below 10,000 m, is a float and may be rounded to its neighbour,
    // 2^-10 m beside, where the double's last bit differs. Rays fall at 26 degrees or more on slopes of 4.3 (750 m over
    // 10 km), so a place moved by s is seen 1 / sin(21) s = 2.8 s nearer at most. Depths are floats of positions that
    // are sums and products of floats: 2^-20 of the distance (render_test.cpp).
    for (int i = 1; i <= 5; ++i) {
        const double moved_m = 0.1 * i;
        const Picture near_by = look(start_m + moved_m, above_m), far = look(start_m + moved_m + period_m, above_m);
        double worst = 0;
        for (std::size_t p = 0; p < near_by.distance_m.size(); ++p) {
            const double d = near_by.distance_m[p];
            worst = std::max(worst, std::abs(d - far.distance_m[p]) / (2.8 / 1024 + d / (1 << 20)));
        }
        INFO(worst);
        CHECK(worst <= 1);
    }
    // A whole metre, what a float holds 10,000 km away, is more than that: the measure sees it.
    const Picture here = look(start_m, above_m), there = look(start_m + 1 + period_m, above_m);
    double apart = 0;
    for (std::size_t p = 0; p < here.distance_m.size(); ++p)
        apart = std::max<double>(apart, std::abs(here.distance_m[p] - there.distance_m[p]) /
                                            (2.8 / 1024 + here.distance_m[p] / (1 << 20)));
    CHECK(apart > 2);
}

TEST_CASE("a picture far from the origin stands where queries find the ground, though no float holds the spacing",
          "[picture]") {
    // The nearest float is 0.4 mm short, which makes 0.4 m of 1,024 columns. On slopes of 14 degrees that is seen 0.1 m
    // nearer and more, twice what is allowed below.
    constexpr double spacing_m = 10'000.0004, period_m = 1024 * spacing_m;
    Scene scene(pyramids(1057, 33, spacing_m, 2500), 4);
    const OwnMesh mesh = full_resolution(scene.loaded.terrain);
    const auto view_at = [&](double x) {
        return make_view({x, 30'000, 155'000}, {0.8, -0.6, 0}, {0.6, 0.8, 0}, pi / 8, width_px, height_px, 100, 1e7);
    };
    for (const double x : {83'125.0, 83'125.1, 91'000.7}) {
        const View here = view_at(x), there = view_at(x + period_m);
        const GroundHit hit_here = cast_ray(scene.loaded.terrain, here.eye_m, here.forward, 1e7),
                        hit_there = cast_ray(scene.loaded.terrain, there.eye_m, there.forward, 1e7);
        REQUIRE(hit_here.hit);
        REQUIRE(hit_there.hit);
        // The eye's double is off by 2^-30 m at most. Rays fall at 26 degrees or more: 1 / sin(26 - 14) times nearer.
        CHECK(std::abs(hit_here.distance_m - hit_there.distance_m) < 1e-6);
        const Picture near_by = scene.draw(mesh.view(), here, {.haze = false}),
                      far = scene.draw(mesh.view(), there, {.haze = false});
        double worst = 0;
        for (std::size_t p = 0; p < near_by.distance_m.size(); ++p) {
            const double d = near_by.distance_m[p];
            worst = std::max(worst, std::abs(d - far.distance_m[p]) / (4.8 / 1024 + d / (1 << 20)));
        }
        INFO(worst);
        CHECK(worst <= 1);
    }
}
