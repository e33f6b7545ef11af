// The gallery's pictures against their commands: docs/pictures.py makes three of them again, a tenth as wide and high.
//
// Compared is light, averaged over 32 x 18 equal rectangles. What a rectangle shows does not depend on how a driver
// rasterises edges, filters textures or places samples, which another version of Mesa may do otherwise: such changes
// cancel out over 16 pixels. Of the levels 0..255 the smaller picture itself differs by 2 to 3, because its mesh and
// its mips are coarser; a quarter of a stop of exposure makes 10.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include <stb_image.h>

#include "fjell/view.h"
#include "support/program.h"
#include "support/rounds.h"
#include "support/temporary_folder.h"

using fjell::Vec3;
using fjell::test::first_of;
using fjell::test::full_rounds;
using fjell::test::run_in;
using fjell::test::TemporaryFolder;

namespace {

constexpr double tolerance = 5; // of 255

struct Pixels {
    explicit Pixels(const std::string& path) : all(nullptr, stbi_image_free) {
        INFO(path);
        int channels = 0;
        all.reset(stbi_load(path.c_str(), &wide, &high, &channels, 3));
        REQUIRE(all);
    }
    [[nodiscard]] int at(int x, int y, int channel) const { return all.get()[3 * (y * wide + x) + channel]; }

    std::unique_ptr<unsigned char, void (*)(void*)> all;
    int wide = 0, high = 0;
};

// sRGB levels, three for each rectangle, of its mean light (2.2 in place of sRGB's curve).
std::vector<double> levels(const std::string& path) {
    constexpr int columns = 32, rows = 18;
    const Pixels pixels(path);
    REQUIRE((pixels.wide % columns == 0 && pixels.high % rows == 0));
    std::vector<double> light(std::size_t{3} * columns * rows);
    const int w = pixels.wide / columns, h = pixels.high / rows;
    for (int i = 0; i < 3 * pixels.wide * pixels.high; ++i) {
        const int x = i / 3 % pixels.wide / w, y = i / 3 / pixels.wide / h;
        light[static_cast<std::size_t>(3 * (y * columns + x) + i % 3)] +=
            std::pow(pixels.all.get()[i] / 255.0, 2.2) / (w * h);
    }
    for (double& value : light) value = 255 * std::pow(value, 1 / 2.2);
    return light;
}

// Draws a picture of the gallery again, perhaps with other options of fjell-fly, and gives its path.
std::string drawn(const TemporaryFolder& folder, const std::string& name, const std::string& options) {
    const auto run = run_in(FJELL_SOURCE_DIR, "python3 docs/pictures.py " FJELL_BIN_DIR " --tenth '" +
                                                  folder.path.string() + "' " + name + options);
    INFO(run.out << run.err);
    REQUIRE(run.code == 0);
    return folder / (name + ".png");
}

// How far a picture that is drawn again is from the stored one, in mean levels.
double difference(const std::string& name, const std::string& options = {}) {
    const TemporaryFolder folder;
    const auto stored = levels(FJELL_SOURCE_DIR "/docs/pictures/" + name + ".jpg"),
               now = levels(drawn(folder, name, options));
    double sum = 0;
    for (std::size_t i = 0; i < stored.size(); ++i) sum += std::fabs(stored[i] - now[i]);
    return sum / static_cast<double>(stored.size());
}

// Where a still camera stands, as fjell-fly has it: to the middle of the picture, to the right, and up.
struct Camera {
    Camera(Vec3 eye, Vec3 look, double fov) : eye_m(eye), fov_deg(fov) { turn_to(look - eye); }
    void turn_to(Vec3 to) {
        forward = normalised(to);
        right = normalised(cross(forward, {0, 1, 0}));
        up = cross(right, forward);
    }
    [[nodiscard]] std::string options() const {
        const Vec3 look = eye_m + forward * 100.0;
        char text[256];
        (void)std::snprintf(text, sizeof text, " --eye %.9f,%.9f,%.9f --look %.9f,%.9f,%.9f --fov %g", eye_m.x, eye_m.y,
                            eye_m.z, look.x, look.y, look.z, fov_deg);
        return text;
    }

    Vec3 eye_m, forward, right, up;
    double fov_deg = 45;
};

// A cubic through four values (E. Catmull and R. Rom), between the second and the third.
double cubic(const double (&v)[4], double t) {
    return v[1] +
           0.5 * t *
               (v[2] - v[0] + t * (2 * v[0] - 5 * v[1] + 4 * v[2] - v[3] + t * (3 * (v[1] - v[2]) + v[3] - v[0])));
}

// The share of pixels, in percent, that change by more than 24 of 255 when the camera turns to the right by a pixel.
// Each pixel is compared with the place in the first picture that it shows. draw: options to the path of a picture.
template <typename Draw>
double changed_by_a_pixel(const Camera& before, const Draw& draw) {
    const Pixels first(draw(before.options()));
    const double a_pixel = 2 * std::tan(before.fov_deg * std::acos(-1.0) / 360) / first.high;
    Camera after = before;
    after.turn_to(before.forward + before.right * a_pixel);
    const Pixels second(draw(after.options()));
    REQUIRE((second.wide == first.wide && second.high == first.high));
    std::size_t changed = 0, compared = 0;
    for (int y = 0; y < second.high; ++y)
        for (int x = 0; x < second.wide; ++x) {
            const double u = (x + 0.5 - 0.5 * second.wide) * a_pixel, v = (0.5 * second.high - y - 0.5) * a_pixel;
            const Vec3 to = after.forward + after.right * u + after.up * v;
            const double far = dot(to, before.forward) * a_pixel;
            const double px = dot(to, before.right) / far + 0.5 * first.wide - 0.5,
                         py = 0.5 * first.high - 0.5 - dot(to, before.up) / far;
            const int x0 = static_cast<int>(std::floor(px)), y0 = static_cast<int>(std::floor(py));
            if (x0 < 1 || y0 < 1 || x0 + 2 >= first.wide || y0 + 2 >= first.high) continue;
            double most = 0;
            for (int c = 0; c < 3; ++c) {
                double rows[4];
                for (int j = 0; j < 4; ++j) {
                    const double row[4] = {static_cast<double>(first.at(x0 - 1, y0 - 1 + j, c)),
                                           static_cast<double>(first.at(x0, y0 - 1 + j, c)),
                                           static_cast<double>(first.at(x0 + 1, y0 - 1 + j, c)),
                                           static_cast<double>(first.at(x0 + 2, y0 - 1 + j, c))};
                    rows[j] = cubic(row, px - x0);
                }
                most = std::max(most, std::fabs(std::clamp(cubic(rows, py - y0), 0.0, 255.0) - second.at(x, y, c)));
            }
            changed += most > 24;
            ++compared;
        }
    REQUIRE(compared > 0);
    return 100.0 * static_cast<double>(changed) / static_cast<double>(compared);
}

} // namespace

TEST_CASE("pictures of the gallery are what their commands draw, and other light or another camera is noticed") {
    for (const char* const name :
         first_of(2, {"gallery-valley-terraces", "gallery-valley-above", "gallery-valley-road"})) {
        INFO(name << ": ./dev pictures makes it again");
        CHECK(difference(name) < tolerance);
    }
    CHECK(difference("gallery-valley-terraces", " -- --light exposure_bias_ev=-0.3") > tolerance);
    if (full_rounds()) CHECK(difference("gallery-valley-terraces", " -- --fov 48") > tolerance);
}

TEST_CASE("a camera that turns by a pixel changes hardly any pixel of the valley, and of sand and gravel underfoot") {
    const TemporaryFolder folder;
    struct Scene {
        const char* name;
        Camera camera;
    };
    for (const Scene& scene :
         first_of<Scene>(1, {{"gallery-valley-terraces", {{930, 458, 1100}, {800, 452, 1000}, 45}},
                             {"gallery-valley-road", {{1528, 453.3, 914}, {1380, 446, 972}, 50}},
                             {"gallery-valley-above", {{1250, 620, 1520}, {1170, 440, 1230}, 50}}})) {
        const double changed = changed_by_a_pixel(scene.camera, [&](const std::string& camera) {
            return drawn(folder, scene.name, " -- --size 640x360" + camera);
        });
        std::printf("%s, turned by a pixel: %.3f%% of the pixels change\n", scene.name, changed);
        CHECK(changed <= 0.5);
    }

    // Two metres above, where materials have their finest grain.
    const auto run = [&](const std::string& command) {
        const auto done = run_in(folder.path, FJELL_BIN_DIR "/" + command);
        INFO(command << '\n' << done.out << done.err);
        REQUIRE(done.code == 0);
    };
    run("fjell-bake synth " FJELL_SOURCE_DIR "/content/terrain/hills.json -o hills.tif");
    run("fjell-bake hills.tif -o hills.fjell");
    run("fjell-bake materials " FJELL_SOURCE_DIR "/content/materials --size 256 -o ground.fjell-materials");
    const double changed =
        changed_by_a_pixel(Camera{{930, 54, 700}, {1000, 44, 645}, 45}, [&](const std::string& camera) {
            run("fjell-fly hills.fjell --materials ground.fjell-materials --layers " FJELL_SOURCE_DIR
                "/content/materials/rules/canyon.json --light azimuth_deg=235,elevation_deg=35 --headless --stream on "
                "--wait --size 640x360 "
                "--frames 1 --profile " FJELL_SOURCE_DIR "/profiles/laptop.toml --render out" +
                camera);
            return folder / "out/frame_00000.png";
        });
    std::printf("sand and gravel, turned by a pixel: %.3f%% of the pixels change\n", changed);
    CHECK(changed <= 0.5);
}

TEST_CASE("no edge of a triangle shows in a lake") {
    const TemporaryFolder folder;
    const Pixels picture(drawn(folder, "gallery-valley-above", " -- --size 1280x720"));
    int least = 255, most = 0; // of red, which water has least of
    for (int y = 232; y < 350; ++y)
        for (int x = 1100; x < 1270; ++x) {
            least = std::min(least, picture.at(x, y, 0));
            most = std::max(most, picture.at(x, y, 0));
        }
    INFO(least << " to " << most);
    CHECK(most < least + 20);
}
