// Shadows in pictures, against rays to the sun.
#include <cmath>
#include <cstdint>
#include <string>

#include "fjell/query.h"
#include "picture_scene.h"
#include "support/terrain_fixture.h"

using namespace pictures;

namespace {

constexpr double radians_a_degree = 3.14159265358979323846 / 180;

// Without film and air a picture is in proportion to its light.
constexpr gl::LightSettings shadow_light{.azimuth_deg = 0,
                                         .elevation_deg = 0,
                                         .air = gl::Air::simple,
                                         .exposure = gl::Exposure::fixed,
                                         .ev100 = 14,
                                         .tone_curve = gl::ToneCurve::none,
                                         .dither = false,
                                         .detail = false};

// A plain with gentle waves and single peaks of 200 to 500 m, whose shadows fall far.
baker::Dem peaks() {
    baker::Dem dem = pictures::mountains(129);
    test::Random random(5);
    for (std::int32_t y = 0, i = 0; y < dem.rows; ++y)
        for (std::int32_t x = 0; x < dem.columns; ++x, ++i)
            dem.heights_m[static_cast<std::size_t>(i)] =
                static_cast<float>(10 * std::sin(x * 0.1) * std::cos(y * 0.13));
    for (int peak = 0; peak < 12; ++peak) {
        const double east = test::uniform(random, 0, 128), south = test::uniform(random, 0, 128),
                     high_m = test::uniform(random, 200, 500);
        for (std::int32_t y = 0, i = 0; y < dem.rows; ++y)
            for (std::int32_t x = 0; x < dem.columns; ++x, ++i) {
                float& h = dem.heights_m[static_cast<std::size_t>(i)];
                h = std::max(h, static_cast<float>(high_m - 24 * std::hypot(x - east, y - south)));
            }
    }
    return dem;
}

struct Shadowed {
    Scene scene{peaks(), 6, PageOrder::planar, 2};
    OwnMesh mesh = full_resolution(scene.loaded.terrain);

    gl::Image draw(const View& view, gl::LightSettings light, bool shadows) {
        light.shadows = shadows;
        scene.light = light;
        return scene.draw(mesh.view(), view, {.haze = false}).colour;
    }
};

Vec3 towards(double azimuth_deg, double elevation_deg) {
    const double level = std::cos(elevation_deg * radians_a_degree);
    return {std::sin(azimuth_deg * radians_a_degree) * level, std::sin(elevation_deg * radians_a_degree),
            -std::cos(azimuth_deg * radians_a_degree) * level};
}

// The ground at a pixel's centre.
Vec3 ground_at(const View& view, const Picture& picture, std::uint32_t x, std::uint32_t y) {
    const double u = view.left + (x + 0.5) / width_px * (view.right - view.left),
                 v = view.top - (y + 0.5) / height_px * (view.top - view.bottom);
    const Vec3 ray = view.forward + cross(view.forward, view.up) * u + view.up * v;
    return view.eye_m + ray * static_cast<double>(picture.distance_m[y * width_px + x]);
}

double light_of(const gl::Image& image, std::uint32_t x, std::uint32_t y) {
    double sum = 0;
    for (std::size_t c = 0; c < 3; ++c) sum += linear(image.pixel(x, y)[c]);
    return sum;
}

} // namespace

TEST_CASE("the ground lies in shadow where a ray to the sun meets other ground, whatever its azimuth", "[picture]") {
    Shadowed shadowed;
    const Terrain& terrain = shadowed.scene.loaded.terrain;
    const View above = shadowed.scene.camera(0.5, 0.5, 3840 / (2 * std::tan(pi / 8)), 0, -90); // all of it
    const Picture depths = shadowed.scene.draw(shadowed.mesh.view(), above);
    for (const double azimuth_deg : {90.0, 200.0, 337.5}) {
        gl::LightSettings light = shadow_light;
        light.azimuth_deg = azimuth_deg;
        light.elevation_deg = 14;
        const gl::Image with = shadowed.draw(above, light, true), without = shadowed.draw(above, light, false);
        int lit = 0, dark = 0, wrongly_lit = 0, wrongly_dark = 0;
        for (std::uint32_t y = 4; y < height_px; y += 7)
            for (std::uint32_t x = 4; x < width_px; x += 7) {
                const Vec3 place = ground_at(above, depths, x, y);
                const GroundHeight ground = ground_height(terrain, place.x, place.z);
                const Vec3 from{place.x, ground.height_m + 0.5, place.z};
                // Grazing light is as dark as shadow.
                if (!ground.inside || dot(ground.normal, towards(azimuth_deg, 14)) < 0.15) continue;
                // The penumbra is 1.15 degrees wide to both sides, and horizons are good to 2 degrees or so.
                const bool surely_dark = cast_ray(terrain, from, towards(azimuth_deg, 14 + 3), 1e6).hit,
                           surely_lit = !cast_ray(terrain, from, towards(azimuth_deg, 14 - 3), 1e6).hit;
                const bool drawn_lit = light_of(with, x, y) > 0.6 * light_of(without, x, y);
                lit += surely_lit;
                dark += surely_dark;
                wrongly_dark += surely_lit && !drawn_lit;
                wrongly_lit += surely_dark && drawn_lit;
            }
        CAPTURE(azimuth_deg, lit, dark, wrongly_lit, wrongly_dark);
        CHECK(lit > 400);
        CHECK(dark > 100);
        CHECK(wrongly_dark * 25 <= lit);
        CHECK(wrongly_lit * 10 <= dark);
    }
}
