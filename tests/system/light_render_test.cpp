// Light and air in pictures.
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "picture_scene.h"
#include "support/rounds.h"

using namespace pictures;

namespace {

constexpr std::uint32_t lit_wide = 160, lit_high = 120;

// Small pictures of 4 km of mountains.
struct Lit {
    Scene scene{pictures::mountains(129), 6};
    OwnMesh mesh = full_resolution(scene.loaded.terrain);
    Lit() { scene.target = gl::Target::create({lit_wide, lit_high, 1}); }
    [[nodiscard]] View camera(double east, double south, double above_m, double heading_deg, double pitch_deg) const {
        View view = scene.camera(east, south, above_m, heading_deg, pitch_deg);
        view.width_px = lit_wide;
        view.height_px = lit_high;
        return view;
    }
    gl::Image draw(const View& view, const gl::LightSettings& light, bool haze = true, double time_s = 0) {
        scene.light = light;
        return scene.draw(mesh.view(), view, {.haze = haze, .time_s = time_s}).colour;
    }
};

// One for all tests: what is dear is compiling its shaders. Never destroyed, like its context.
Lit& shared() {
    static Lit& lit = *new Lit;
    return lit;
}

double mean_of(const gl::Image& image) {
    double sum = 0;
    for (const std::uint8_t code : image.rgb) sum += linear(code);
    return sum / static_cast<double>(image.rgb.size());
}
// Of green light.
double spread_of(const gl::Image& image) {
    double sum = 0, squares = 0;
    for (std::size_t i = 1; i < image.rgb.size(); i += 3) {
        sum += linear(image.rgb[i]);
        squares += linear(image.rgb[i]) * linear(image.rgb[i]);
    }
    const double n = static_cast<double>(image.rgb.size()) / 3;
    return std::sqrt(squares / n - sum / n * (sum / n));
}
double mean_apart(const gl::Image& a, const gl::Image& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.rgb.size(); ++i) sum += std::abs(a.rgb[i] - b.rgb[i]);
    return sum / static_cast<double>(a.rgb.size());
}

constexpr gl::LightSettings cheap_light{.air = gl::Air::simple, .dither = false, .detail = false};
constexpr gl::LightSettings plain_light{.dither = false, .detail = false};

} // namespace

TEST_CASE("from above a clear day does not wash the terrain out, and a hazy one does", "[picture]") {
    Lit& lit = shared();
    const View above = lit.camera(0.5, 0.5, 2500, 0, -90); // ground all over
    for (gl::LightSettings clear : {plain_light, cheap_light}) {
        clear.exposure = gl::Exposure::fixed; // in proportion to the light, so that spreads compare
        clear.tone_curve = gl::ToneCurve::none;
        gl::LightSettings dull = clear;
        dull.visibility_km = 3;
        const double without = spread_of(lit.draw(above, clear, false)), with = spread_of(lit.draw(above, clear));
        // Through 2.5 km of air straight down come 0.95 of green light (lighting.h).
        CHECK(with > 0.9 * without);
        CHECK(spread_of(lit.draw(above, dull)) < 0.8 * without); // the measure sees haze
    }
}

namespace {

// The step from the last pixel of what lies behind to the first of the ground, down each column.
double edge_of(Scene& scene, const OwnMesh& mesh, const View& view, bool haze) {
    scene.light = plain_light;
    const Picture picture = scene.draw(mesh.view(), view, {.haze = haze});
    int sum = 0;
    for (std::uint32_t x = 0; x < lit_wide; ++x)
        for (std::uint32_t y = 0; y + 1 < lit_high; ++y) {
            if (picture.depth[y * lit_wide + x] != 0 || picture.depth[(y + 1) * lit_wide + x] == 0) continue;
            sum += std::abs(picture.colour.pixel(x, y)[1] - picture.colour.pixel(x, y + 1)[1]);
            break;
        }
    return static_cast<double>(sum) / lit_wide;
}

} // namespace

TEST_CASE("the terrain's rim is no edge where ground lies behind it", "[picture]") {
    Lit& lit = shared();
    const View above = lit.camera(0.5, 0.5, 1500, 20, -30);
    const double with = edge_of(lit.scene, lit.mesh, above, true), without = edge_of(lit.scene, lit.mesh, above, false);
    CAPTURE(with, without);
    CHECK(without > 6); // without air there is no ground behind: the measure sees the rim
    CHECK(with < without / 3);
}

TEST_CASE("water lies over the ground below its level and nowhere else, and moves with the given time alone",
          "[picture]") {
    Lit& lit = shared();
    const Terrain& terrain = lit.scene.loaded.terrain;
    const View above = lit.camera(0.5, 0.5, 3000, 0, -90);
    gl::LightSettings wet = plain_light;
    wet.water = true;
    wet.water_level_m = 0.5 * (terrain.header().min_m + terrain.header().max_m);
    const gl::Image dry = lit.draw(above, plain_light, false), flooded = lit.draw(above, wet, false);
    const Picture depths = lit.scene.draw(lit.mesh.view(), above);
    std::size_t below = 0, missed = 0, wrong = 0;
    for (std::uint32_t y = 0; y < lit_high; ++y)
        for (std::uint32_t x = 0; x < lit_wide; ++x) {
            const double height = above.eye_m.y - static_cast<double>(depths.distance_m[y * lit_wide + x]);
            const bool same = std::equal(dry.pixel(x, y), dry.pixel(x, y) + 3, flooded.pixel(x, y));
            below += height < wet.water_level_m;
            missed += height < wet.water_level_m - 1 && same;
            wrong += height > wet.water_level_m + 1 && !same;
        }
    CHECK(below > std::size_t{lit_wide} * lit_high / 10);
    CHECK(below < std::size_t{lit_wide} * lit_high * 9 / 10);
    CHECK(missed == 0);
    CHECK(wrong == 0);
    CHECK((lit.draw(above, wet, false).rgb == flooded.rgb));
    CHECK((lit.draw(above, wet, false, 5).rgb != flooded.rgb));
    CHECK((lit.draw(above, plain_light, false, 5).rgb == dry.rgb)); // nothing else moves
}

TEST_CASE("detail roughens near ground and leaves far ground as it was baked", "[picture]") {
    Lit& lit = shared();
    gl::LightSettings detailed = plain_light;
    detailed.detail = true;
    const View near_by = lit.camera(0.5, 0.5, 20, 0, -20), far_off = lit.camera(0.5, 0.5, 15'000, 0, -90);
    CHECK(mean_apart(lit.draw(near_by, detailed), lit.draw(near_by, plain_light)) > 3);
    // A pixel is 100 m there, twice the longest noise.
    const gl::Image far_with = lit.draw(far_off, detailed), far_without = lit.draw(far_off, plain_light);
    const Picture depths = lit.scene.draw(lit.mesh.view(), far_off);
    std::size_t ground = 0;
    for (const float depth : depths.depth) ground += depth != 0;
    REQUIRE(ground > 500);
    CHECK(mean_apart(far_with, far_without) * (lit_wide * lit_high) / static_cast<double>(ground) <
          2); // codes; unfaded it is 7
}

TEST_CASE("exposure follows the sun and not the view, stops double the light, and dusk is darker than noon",
          "[picture]") {
    Lit& lit = shared();
    const View view = lit.camera(0.5, 0.5, 2000, 0, -90);
    gl::LightSettings light = plain_light;
    light.tone_curve = gl::ToneCurve::none;
    light.exposure_bias_ev = -2; // nothing is cut off
    const gl::Image once = lit.draw(view, light);
    (void)lit.draw(lit.camera(0.1, 0.1, 9000, 200, -80), light); // another view in between leaves no trace
    CHECK((lit.draw(view, light).rgb == once.rgb));
    gl::LightSettings brighter = light;
    brighter.exposure_bias_ev = -1;
    CHECK(mean_of(lit.draw(view, brighter)) == Approx(2 * mean_of(once)).epsilon(0.02));
    gl::LightSettings fixed = light, stopped_down = light;
    fixed.exposure = stopped_down.exposure = gl::Exposure::fixed;
    fixed.ev100 = 15;
    stopped_down.ev100 = 16;
    CHECK(mean_of(lit.draw(view, fixed)) == Approx(2 * mean_of(lit.draw(view, stopped_down))).epsilon(0.02));
    double before = 0;
    for (const double elevation : {-12.0, -3.0, 40.0}) {
        light.elevation_deg = elevation;
        const double now = mean_of(lit.draw(view, light));
        CHECK(now > 1.1 * before);
        before = now;
    }
}

TEST_CASE("a dithered sky has no bands", "[picture]") {
    Lit& lit = shared();
    const View sky = lit.camera(0.5, 0.5, 300, 150, 50);
    // Pixels like the one beside: in a band all of them are.
    const auto alike = [](const gl::Image& image) {
        std::size_t same = 0;
        for (std::size_t i = 3; i < image.rgb.size(); ++i) same += image.rgb[i] == image.rgb[i - 3];
        return static_cast<double>(same) / static_cast<double>(image.rgb.size());
    };
    gl::LightSettings dithered = plain_light;
    dithered.dither = true;
    const gl::Image with = lit.draw(sky, dithered), without = lit.draw(sky, plain_light);
    CHECK(alike(without) > 0.85);
    CHECK(alike(with) < 0.75);
    int most = 0;
    for (std::size_t i = 0; i < with.rgb.size(); ++i) most = std::max(most, std::abs(with.rgb[i] - without.rgb[i]));
    CHECK(most == 1); // half a step, rounded
}

TEST_CASE("every light draws, its tables are made anew when the sun moves, and one out of range is refused",
          "[picture]") {
    Lit& lit = shared();
    const View view = lit.camera(0.5, 0.9, 300, 0, -5);
    std::vector<gl::Image> images;
    for (const auto air : {gl::Air::simple, gl::Air::physical})
        for (const bool detail : {false, true})
            for (const bool water : {false, true}) {
                if (!test::full_rounds() && detail != water) continue;
                gl::LightSettings light = plain_light;
                light.air = air;
                light.detail = detail;
                light.water = water;
                light.water_level_m = lit.scene.loaded.terrain.header().max_m - 400;
                images.push_back(lit.draw(view, light));
            }
    gl::LightSettings later = plain_light;
    later.azimuth_deg = 90;
    images.push_back(lit.draw(view, later));
    for (std::size_t i = 0; i < images.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) CHECK((images[i].rgb != images[j].rgb));
    later.visibility_km = 0;
    CHECK_THROWS_WITH(lit.scene.renderer->draw(lit.mesh.view(), view, {.light = later}, *lit.scene.target),
                      "LightSettings::visibility_km must be a number from 1 to 280");
    CHECK(context().log().errors == 0);
}

TEST_CASE("a smooth slope has no creases where texels of its normals meet", "[picture]") {
    // Waves in the east, 5 cells long, 64 cells of 16 m; lit along them.
    constexpr int cells = 64;
    constexpr double cell_m = 16, waves_m = 5 * cell_m, texels_across = 4;
    constexpr std::uint32_t wide = 512, high = 64;
    baker::Dem dem;
    dem.columns = dem.rows = cells + 1;
    dem.spacing_m[0] = dem.spacing_m[1] = cell_m;
    for (int y = 0; y <= cells; ++y)
        for (int x = 0; x <= cells; ++x)
            dem.heights_m.push_back(static_cast<float>(8 * std::sin(2 * pi * x * cell_m / waves_m)));
    Scene scene(std::move(dem), 6);
    const OwnMesh mesh = full_resolution(scene.loaded.terrain);
    scene.target = gl::Target::create({wide, high, 1});
    scene.light.exposure = gl::Exposure::fixed;
    scene.light.tone_curve = gl::ToneCurve::none;
    scene.light.ev100 = 14;
    scene.light.azimuth_deg = 90;
    scene.light.elevation_deg = 60;
    scene.light.detail = true;
    // A few texels, from so high that lines of sight are as good as upright.
    const double map_texels = std::ldexp(1.0, static_cast<int>(scene.loaded.pack.header.normal_log2)),
                 texel_m = cells * cell_m / (map_texels - 1), eye_m = 20'000, wide_m = texels_across * texel_m,
                 pixel_m = wide_m / wide;
    const double x_m = 0.5 * cells * cell_m;
    // What columns have in common: noise differs from row to row.
    std::vector<double> light(wide);
    constexpr int pictures_down = 48;
    for (int i = 0; i < pictures_down; ++i) {
        const Vec3 eye{x_m, eye_m, cells * cell_m * (0.1 + 0.8 * i / pictures_down)};
        const View view =
            make_view(eye, {0, -1, 0}, {0, 0, -1}, 2 * std::atan(0.5 * high * pixel_m / eye_m), wide, high, 5, 1e6);
        const gl::Image image = scene.draw(mesh.view(), view, {.haze = false}).colour;
        for (std::uint32_t y = 0; y < high; ++y)
            for (std::uint32_t x = 0; x < wide; ++x) light[x] += linear(image.pixel(x, y)[1]) / (high * pictures_down);
    }
    // How much the light's slope changes around the lines where texels' centres lie, and half-way between them.
    constexpr std::uint32_t step = 12;
    double at_lines = 0, between = 0;
    for (std::uint32_t x = step; x + step < wide; ++x) {
        const double texel = (x_m + (x + 0.5 - wide / 2.0) * pixel_m) / texel_m, off = texel - std::floor(texel);
        const double change = std::abs(light[x - step] - 2 * light[x] + light[x + step]);
        if (off < 0.05 || off > 0.95) at_lines += change;
        if (std::abs(off - 0.5) < 0.05) between += change;
    }
    // Straight from texel to texel it is 0.8.
    CHECK(at_lines < 0.5 * between);
}
