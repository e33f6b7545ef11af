// Where the terrain ends: at its rim, at the horizon, and at a shore.
#include <cmath>
#include <vector>

#include "picture_scene.h"

using namespace pictures;

namespace {

constexpr std::uint32_t wide = 240, high = 160;

double luminance_of(const gl::Image& image, std::uint32_t x, std::uint32_t y) {
    const std::uint8_t* rgb = image.pixel(x, y);
    return 0.2126 * linear(rgb[0]) + 0.7152 * linear(rgb[1]) + 0.0722 * linear(rgb[2]);
}
double row_mean(const gl::Image& image, std::uint32_t y) {
    double sum = 0;
    for (std::uint32_t x = 0; x < wide; ++x) sum += luminance_of(image, x, y);
    return sum / wide;
}

struct Landscape {
    Scene scene;
    OwnMesh mesh;
    explicit Landscape(baker::Dem dem) : scene(std::move(dem), 6), mesh(full_resolution(scene.loaded.terrain)) {
        scene.target = gl::Target::create({wide, high, 1});
        scene.light = {.dither = false, .detail = false};
    }
    [[nodiscard]] View camera(double east, double south, double above_m, double heading_deg, double pitch_deg) const {
        View view = scene.camera(east, south, above_m, heading_deg, pitch_deg);
        view.width_px = wide;
        view.height_px = high;
        view.right = view.top * wide / high;
        view.left = -view.right;
        return view;
    }
    Picture draw(const View& view, bool haze = true) { return scene.draw(mesh.view(), view, {.haze = haze}); }
};

// Whole metres: a sea at 0, a plain that rises one in 50, cut into bays.
baker::Dem coast() {
    baker::Dem dem;
    dem.columns = dem.rows = 129;
    dem.spacing_m[0] = dem.spacing_m[1] = 30;
    for (int y = 0; y < 129; ++y)
        for (int x = 0; x < 129; ++x)
            dem.heights_m.push_back(static_cast<float>(
                std::max(0L, std::lround(0.6 * (x - 64) + 9 * std::sin(0.21 * y) + 5 * std::sin(0.13 * x + 0.4 * y)))));
    return dem;
}

} // namespace

TEST_CASE("beyond the terrain's rim ground goes on in its colours, and is in no depth buffer", "[picture]") {
    Landscape l(pictures::mountains(129));
    const View view = l.camera(0.5, 0.5, 1500, 20, -24);
    const Picture with = l.draw(view), without = l.draw(view, false);
    CHECK(with.depth == without.depth);
    // From the last ground to what is four pixels further: less than between the rim and the sky's ground without.
    const auto step_of = [&](const Picture& picture) {
        double sum = 0;
        int count = 0;
        for (std::uint32_t x = 0; x < wide; ++x)
            for (std::uint32_t y = 4; y < high; ++y) {
                if (picture.depth[std::size_t{y} * wide + x] == 0) continue;
                for (std::size_t c = 0; c < 3; ++c)
                    sum += std::abs(picture.colour.pixel(x, y)[c] - picture.colour.pixel(x, y - 4)[c]);
                ++count;
                break;
            }
        return sum / (3.0 * count);
    };
    const double gone_on = step_of(with), cut_off = step_of(without);
    CAPTURE(gone_on, cut_off);
    CHECK(cut_off > 20); // the measure sees the rim
    CHECK(gone_on < 12);
}

TEST_CASE("the horizon is the brightest of a clear day's picture, and nothing dark lies below it", "[picture]") {
    Landscape l(pictures::mountains(129));
    for (const auto air : {gl::Air::physical, gl::Air::simple})
        for (const double heading : {0.0, 110.0, 230.0}) {
            l.scene.light.air = air;
            // From over the rim, outwards: no ground but that around.
            View view = l.camera(0.5, 0.5, 2500, heading, -6);
            view.eye_m = view.eye_m + Vec3{view.forward.x, 0, view.forward.z} * 3500;
            const gl::Image image = l.draw(view).colour;
            const double degree = high / (45.0 * 1.0); // rows, near the middle
            const auto horizon = static_cast<std::uint32_t>(high / 2 - 6 * degree);
            double brightest = 0, darkest = 10;
            for (std::uint32_t y = horizon - 2; y <= horizon + 2; ++y)
                brightest = std::max(brightest, row_mean(image, y));
            for (auto y = horizon; y < horizon + static_cast<std::uint32_t>(8 * degree); ++y)
                darkest = std::min(darkest, row_mean(image, y));
            CAPTURE(heading, brightest, darkest);
            CHECK(row_mean(image, horizon - static_cast<std::uint32_t>(8 * degree)) < brightest);
            CHECK(darkest > 0.8 * brightest);
        }
}

TEST_CASE("ground at exactly the water's level is water, and no polygon of it is dry", "[picture]") {
    Landscape l(coast());
    const View above = l.camera(0.3, 0.5, 2500, 0, -90);
    l.scene.light.elevation_deg = 12; // the sun's glint is elsewhere
    const gl::Image dry = l.draw(above, false).colour;
    l.scene.light.water = true;
    l.scene.light.water_level_m = 0;
    const Picture wet = l.draw(above, false);
    std::size_t sea = 0, left_dry = 0;
    double darkest = 1, brightest = 0;
    for (std::uint32_t y = 0; y < high; ++y)
        for (std::uint32_t x = 0; x < wide; ++x) {
            const double along = static_cast<double>(wet.distance_m[std::size_t{y} * wide + x]);
            if (!(std::abs(above.eye_m.y - along) < 0.05)) continue; // at the level; shores are wider
            const double east = above.eye_m.x + (above.left + (above.right - above.left) * (x + 0.5) / wide) * along;
            if (east > 0.3 * 3840) continue; // all sea
            ++sea;
            const double before = luminance_of(dry, x, y), now = luminance_of(wet.colour, x, y);
            left_dry += now > 0.7 * before;
            darkest = std::min(darkest, now), brightest = std::max(brightest, now);
        }
    CHECK(sea > 2000);
    CHECK(left_dry == 0);
    CAPTURE(darkest, brightest);
    CHECK(brightest < 2 * darkest); // one sea, not pieces of it
}

TEST_CASE("a flat shore is no edge: water begins as thin as it is", "[picture]") {
    Landscape l(coast());
    l.scene.light.water = true;
    l.scene.light.water_level_m = 6.5; // between two whole metres
    l.scene.light.azimuth_deg = 300;
    l.scene.light.elevation_deg = 20;
    const View view = l.camera(0.38, 0.5, 25, 90, -4);
    const gl::Image image = l.draw(view, false).colour;
    const Picture depths = l.draw(view, false);
    // Across the shore, from pixel to pixel; of what lies between the ground six pixels above and the water six below.
    double steps = 0, contrast = 0;
    std::size_t shores = 0;
    for (std::uint32_t x = 0; x < wide; ++x)
        for (std::uint32_t y = 6; y + 6 < high; ++y) {
            const auto rise = [&](std::uint32_t row) {
                const double along = static_cast<double>(depths.distance_m[std::size_t{row} * wide + x]);
                const double v = view.top + (view.bottom - view.top) * (row + 0.5) / high;
                return view.eye_m.y + along * (view.forward.y + view.up.y * v) - 6.5;
            };
            const auto apart = [&](std::uint32_t from, std::uint32_t to) {
                double sum = 0;
                for (std::size_t c = 0; c < 3; ++c)
                    sum += std::abs(linear(image.pixel(x, from)[c]) - linear(image.pixel(x, to)[c]));
                return sum;
            };
            const double step = apart(y, y + 1), all = apart(y - 6, y + 6);
            if (!(rise(y - 6) > 0) || !(rise(y) > 0) || rise(y + 1) > 0 || rise(y + 6) > 0 || all < 0.05) continue;
            steps += step, contrast += all;
            ++shores;
        }
    REQUIRE(shores > 40);

    CHECK(steps < 0.18 * contrast);
}
