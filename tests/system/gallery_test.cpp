// The gallery's pictures against their commands: docs/pictures.py makes three of them again, a tenth as wide and high.
//
// Compared is light, averaged over 32 x 18 equal rectangles. What a rectangle shows does not depend on how a driver
// rasterises edges, filters textures or places samples, which another version of Mesa may do otherwise: such changes
// cancel out over 16 pixels. Of the levels 0..255 the smaller picture itself differs by 2 to 3, because its mesh and
// its mips are coarser; a quarter of a stop of exposure makes 10.
#include <catch2/catch.hpp>

#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include <stb_image.h>

#include "support/program.h"
#include "support/temporary_folder.h"

using fjell::test::run_in;
using fjell::test::TemporaryFolder;

namespace {

constexpr double tolerance = 5; // of 255

// sRGB levels, three for each rectangle, of its mean light (2.2 in place of sRGB's curve).
std::vector<double> levels(const std::string& path) {
    constexpr int columns = 32, rows = 18;
    int wide = 0, high = 0, channels = 0;
    INFO(path);
    unsigned char* const pixels = stbi_load(path.c_str(), &wide, &high, &channels, 3);
    REQUIRE(pixels);
    REQUIRE((wide % columns == 0 && high % rows == 0));
    std::vector<double> light(std::size_t{3} * columns * rows);
    const int w = wide / columns, h = high / rows;
    for (int i = 0; i < 3 * wide * high; ++i) {
        const int x = i / 3 % wide / w, y = i / 3 / wide / h;
        light[static_cast<std::size_t>(3 * (y * columns + x) + i % 3)] += std::pow(pixels[i] / 255.0, 2.2) / (w * h);
    }
    stbi_image_free(pixels);
    for (double& value : light) value = 255 * std::pow(value, 1 / 2.2);
    return light;
}

// Draws a picture again, perhaps with other options of fjell-fly: how far it is from the stored one, in mean levels.
double difference(const std::string& name, const std::string& options = {}) {
    const TemporaryFolder folder;
    const auto run = run_in(FJELL_SOURCE_DIR, "python3 docs/pictures.py " FJELL_BIN_DIR " --tenth '" +
                                                  folder.path.string() + "' " + name + options);
    INFO(run.out << run.err);
    REQUIRE(run.code == 0);
    const auto stored = levels(FJELL_SOURCE_DIR "/docs/pictures/" + name + ".jpg"),
               drawn = levels(folder / (name + ".png"));
    double sum = 0;
    for (std::size_t i = 0; i < stored.size(); ++i) sum += std::fabs(stored[i] - drawn[i]);
    return sum / static_cast<double>(stored.size());
}

} // namespace

TEST_CASE("three pictures of the gallery are what their commands draw, and other light or another camera is noticed") {
    for (const char* const name : {"gallery-valley-road", "gallery-valley-terraces", "gallery-valley-above"}) {
        INFO(name << ": ./dev pictures makes it again");
        CHECK(difference(name) < tolerance);
    }
    CHECK(difference("gallery-valley-terraces", " -- --light exposure_bias_ev=-0.3") > tolerance);
    CHECK(difference("gallery-valley-terraces", " -- --fov 48") > tolerance);
}
