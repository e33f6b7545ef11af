#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <memory>

#include <stb_image.h>

#include "baker/check/picture.h"
#include "shared/terrain_data.h"
#include "support/rounds.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::baker;
using namespace fjell::test;

namespace {

Dem level(std::int32_t columns, std::int32_t rows) {
    Dem dem;
    dem.columns = columns;
    dem.rows = rows;
    dem.spacing_m[0] = dem.spacing_m[1] = 30;
    dem.heights_m.assign(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), 100);
    return dem;
}

void dig(Dem& dem, std::int32_t x, std::int32_t y, std::int32_t columns = 1, std::int32_t rows = 1) {
    dem.voids.resize(dem.heights_m.size());
    for (std::int32_t j = y; j < std::min(y + rows, dem.rows); ++j)
        for (std::int32_t i = x; i < std::min(x + columns, dem.columns); ++i) dem.voids[dem.index(i, j)] = 1;
}

Picture picture_of(const io::LoadedPack& pack, std::uint32_t longest_px, int threads = 1) {
    return make_picture(pack.terrain, {longest_px, threads});
}

bool shows_hole(const Rgb8& rgb) {
    return rgb == hole_rgb || rgb == hole_line_rgb;
}
bool is_grey(const Rgb8& rgb) {
    return rgb[0] == rgb[1] && rgb[1] == rgb[2];
}
double luminance(const Rgb8& rgb) {
    return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}
// Relief scales all three alike, so the share of red is the ramp's alone. It grows from blue to red.
double redness(const Rgb8& rgb) {
    return static_cast<double>(rgb[0]) / (rgb[0] + rgb[1] + rgb[2]);
}

} // namespace

TEST_CASE("a picture has a hole where the samples have no height, and nowhere else") {
    Dem dem = level(96, 64);
    dig(dem, 20, 10, 15, 30); // across tiles
    dig(dem, 70, 50);
    dig(dem, 95, 63);
    const Dem original = dem;
    const Picture picture = picture_of(bake_and_load(std::move(dem), small_bake(4)), 96);
    REQUIRE(picture.width == 96);
    REQUIRE(picture.height == 64);
    int different = 0, lines = 0;
    for (std::uint32_t y = 0; y < 64; ++y)
        for (std::uint32_t x = 0; x < 96; ++x) {
            const bool hole = original.is_void(static_cast<std::int32_t>(x), static_cast<std::int32_t>(y));
            const bool line = (x > 0 && x % 16 == 0) || (y > 0 && y % 16 == 0);
            different += shows_hole(picture.pixel(x, y)) != hole;
            lines += hole && (picture.pixel(x, y) == hole_line_rgb) != line;
        }
    CHECK(different == 0);
    CHECK(lines == 0);
}

TEST_CASE("a pixel shows a hole when any of its samples is one, however small the picture") {
    Random random(5);
    int holes = 0, solid = 0;
    for (int round = 0; round < rounds(8, 24); ++round) {
        Dem dem = random_dem(random, pick(random, 65, 500), pick(random, 65, 500),
                             static_cast<Shape>(pick(random, 0, static_cast<int>(Shape::count) - 1)));
        for (int k = pick(random, 1, 12); k > 0; --k)
            dig(dem, pick(random, 0, dem.columns - 1), pick(random, 0, dem.rows - 1), pick(random, 1, 60),
                pick(random, 1, 4));
        // And single ones on the east and south rim, whose vertices may lie beyond it.
        dig(dem, dem.columns - 1, pick(random, 0, dem.rows - 1));
        dig(dem, pick(random, 0, dem.columns - 1), dem.rows - 1);
        const Dem original = dem;
        BakeOptions options = small_bake(pick(random, 1, 9));
        options.estimate = pick(random, 0, 1) ? ErrorEstimate::max : ErrorEstimate::midpoint;
        const Picture picture =
            picture_of(bake_and_load(std::move(dem), options), static_cast<std::uint32_t>(pick(random, 64, 300)));
        const auto first = [](std::uint32_t pixel, std::uint32_t pixels, std::int32_t samples) {
            return static_cast<std::int32_t>(std::int64_t{pixel} * samples / pixels);
        };
        int different = 0;
        for (std::uint32_t y = 0; y < picture.terrain_height; ++y)
            for (std::uint32_t x = 0; x < picture.width; ++x) {
                const std::int32_t x0 = first(x, picture.width, original.columns),
                                   y0 = first(y, picture.terrain_height, original.rows);
                const std::int32_t x1 = std::max(first(x + 1, picture.width, original.columns), x0 + 1),
                                   y1 = std::max(first(y + 1, picture.terrain_height, original.rows), y0 + 1);
                bool hole = false;
                for (std::int32_t j = y0; j < y1; ++j)
                    for (std::int32_t i = x0; i < x1; ++i) hole = hole || original.is_void(i, j);
                different += shows_hole(picture.pixel(x, y)) != hole;
                ++(hole ? holes : solid);
            }
        INFO("round " << round);
        CHECK(different == 0);
    }
    CHECK(holes > 1000);
    CHECK(solid > 1000);
}

TEST_CASE("a single hole in level ground is seen, also on a rim that cuts tiles") {
    Random random(12);
    for (int round = 0; round < rounds(20, 60); ++round) {
        Dem dem = level(pick(random, 66, 300), pick(random, 66, 300));
        const std::int32_t x = round % 3 == 0 ? dem.columns - 1 : pick(random, 0, dem.columns - 1),
                           y = round % 3 == 1 ? dem.rows - 1 : pick(random, 0, dem.rows - 1);
        dig(dem, x, y);
        INFO("hole at " << x << ", " << y << " of " << dem.columns << " x " << dem.rows);
        const Picture picture = picture_of(bake_and_load(std::move(dem), small_bake(pick(random, 1, 9))), 64);
        int holes = 0;
        for (std::uint32_t j = 0; j < picture.height; ++j)
            for (std::uint32_t i = 0; i < picture.width; ++i) holes += shows_hole(picture.pixel(i, j));
        CHECK(holes == 1);
    }
}

TEST_CASE("lines run through the samples that tiles share, and nowhere else") {
    const Picture picture = picture_of(bake_and_load(level(97, 70), small_bake(5)), 97);
    REQUIRE(picture.width == 97);
    const Rgb8 ground = picture.pixel(1, 1);
    CHECK(is_grey(ground));
    int different = 0;
    for (std::uint32_t y = 0; y < 70; ++y)
        for (std::uint32_t x = 0; x < 97; ++x) {
            const bool line = x == 32 || x == 64 || y == 32 || y == 64;
            different += (picture.pixel(x, y) != ground) != line;
        }
    CHECK(different == 0);
}

TEST_CASE("tile lines are visible on light and on dark ground") {
    // Heights depend on x alone, so rows that are a multiple of two apart look alike but for the line.
    Dem dem = level(130, 70);
    for (std::int32_t y = 0; y < dem.rows; ++y)
        for (std::int32_t x = 0; x < dem.columns; ++x)
            dem.heights_m[dem.index(x, y)] = static_cast<float>(2000 + 300 * std::sin(x * 0.12) * std::sin(x * 0.011));
    const Picture picture = picture_of(bake_and_load(std::move(dem), small_bake(6)), 130);
    REQUIRE(picture.width == 130);
    int lightened = 0, darkened = 0;
    double least = 255;
    for (std::uint32_t x = 0; x < 130; ++x) {
        if (x == 64 || x == 128) continue;
        const double line = luminance(picture.pixel(x, 64)), ground = luminance(picture.pixel(x, 62));
        ++(line > ground ? lightened : darkened);
        least = std::min(least, std::abs(line - ground));
    }
    CHECK(lightened > 10);
    CHECK(darkened > 10);
    // Below 105 half of what is missing to 255 is added, from there on 70 % is taken away: 73.5, less the rounding.
    CHECK(least > 72.5);
}

TEST_CASE("where tiles are smaller than a line has room, some lines are left out and the others stay where they were") {
    const Picture picture = picture_of(bake_and_load(level(129, 129), small_bake(1)), 129);
    const Rgb8 ground = picture.pixel(1, 1);
    int different = 0;
    for (std::uint32_t x = 0; x < 129; ++x)
        different += (picture.pixel(x, 1) != ground) != (x > 0 && x < 128 && x % 16 == 0);
    CHECK(different == 0);
}

TEST_CASE("the larger an error, the nearer its colour to the ramp's red end") {
    Dem dem = level(120, 70);
    const double spikes[] = {1, 3, 10, 30, 100, 300, 1000};
    std::int32_t at = 11;
    for (const double spike : spikes) dem.heights_m[dem.index(at, 30)] += static_cast<float>(spike), at += 14;
    dem.native_quantum_m = 1;
    const auto pack = bake_and_load(std::move(dem), small_bake(7));
    const Picture picture = picture_of(pack, 120);
    REQUIRE(picture.width == 120);
    double before = 0;
    for (std::uint32_t x = 11; x < 109; x += 14) {
        const double red = redness(picture.pixel(x, 30));
        INFO("spike at " << x);
        CHECK(red > before + 0.01);
        before = red;
    }
    const Rgb8 least = picture.pixel(11, 30), largest = picture.pixel(95, 30);
    CHECK(least[2] > least[0]);
    CHECK(largest[0] > 3 * largest[2]);
    CHECK(is_grey(picture.pixel(60, 60)));
    float least_m = HUGE_VALF, largest_m = 0;
    for (std::int32_t y = 0; y < 70; ++y)
        for (std::int32_t x = 0; x < 120; ++x) {
            const float error_m = (x | y) & 1 ? data_of(pack.terrain).vertex({x, y}).error_m : 0;
            if (error_m > 0) least_m = std::min(least_m, error_m);
            largest_m = std::max(largest_m, error_m);
        }
    CHECK(picture.least_error_m >= least_m); // the least of pixels, each of which shows its largest
    CHECK(picture.least_error_m < 3);
    CHECK(picture.largest_error_m == largest_m);
}

TEST_CASE("a single spike is not lost, wherever it is and however many samples a pixel has") {
    Random random(6);
    for (int round = 0; round < rounds(20, 60); ++round) {
        Dem dem = level(pick(random, 20, 300), pick(random, 20, 300));
        const std::int32_t columns = dem.columns, rows = dem.rows;
        const std::int32_t x = round % 3 == 0 ? columns - 1 : pick(random, 0, columns - 1),
                           y = round % 3 == 1 ? rows - 1 : pick(random, 0, rows - 1);
        dem.heights_m[dem.index(x, y)] += 50;
        const auto pack = bake_and_load(std::move(dem), small_bake(pick(random, 1, 9)));
        const Picture picture = picture_of(pack, 64);
        // The diamond that it is under has its centre in the spike's pixel or sample, or in the next one.
        const auto width = static_cast<std::int32_t>(picture.width), height = static_cast<std::int32_t>(picture.height);
        const std::int32_t px = (2 * x + 1) * width / (2 * columns), py = (2 * y + 1) * height / (2 * rows);
        const std::int32_t rx = width / columns + 1, ry = height / rows + 1;
        bool seen = false;
        for (std::int32_t j = std::max(py - ry, 0); j <= std::min(py + ry, height - 1); ++j)
            for (std::int32_t i = std::max(px - rx, 0); i <= std::min(px + rx, width - 1); ++i)
                seen = seen || !is_grey(picture.pixel(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j)));
        INFO("spike at " << x << ", " << y << " of " << columns << " x " << rows);
        CHECK(seen);
    }
}

TEST_CASE("where every vertex has an error, every pixel shows one") {
    Random random(11);
    for (int round = 0; round < rounds(7, 20); ++round) {
        // Whole tiles: next to a rim that cuts one there may be no triangle to err.
        const int tile_log2 = pick(random, 1, 7), side = 1 << tile_log2;
        Dem dem = level(pick(random, 1, 250 / side) * side + 1, pick(random, 1, 250 / side) * side + 1);
        dem.spacing_m[1] = uniform(random, 10, 90);
        for (std::int32_t y = 0; y < dem.rows; ++y)
            for (std::int32_t x = 0; x < dem.columns; ++x)
                dem.heights_m[dem.index(x, y)] = static_cast<float>(100 * ((x + y) % 2) + uniform(random, 0, 50));
        const auto pack = bake_and_load(std::move(dem), small_bake(tile_log2));
        const Picture picture = picture_of(pack, static_cast<std::uint32_t>(pick(random, 64, 255)));
        int grey = 0;
        for (std::uint32_t y = 0; y < picture.height; ++y)
            for (std::uint32_t x = 0; x < picture.width; ++x) grey += is_grey(picture.pixel(x, y));
        INFO("round " << round << ", " << data_of(pack.terrain).tree.columns() << " x "
                      << data_of(pack.terrain).tree.rows());
        CHECK(grey == 0);
    }
}

TEST_CASE("the ramp's largest error is at least that of every finest vertex") {
    Random random(7);
    for (int round = 0; round < rounds(5, 12); ++round) {
        const auto pack = bake_and_load(random_dem(random, pick(random, 2, 400), pick(random, 2, 400),
                                                   pick(random, 0, 1) ? Shape::fractal : Shape::spikes),
                                        small_bake(pick(random, 1, 8)));
        const Terrain& terrain = pack.terrain;
        float largest_m = 0;
        for (std::int32_t y = 0; y < data_of(terrain).tree.rows(); ++y)
            for (std::int32_t x = 0; x < data_of(terrain).tree.columns(); ++x)
                if ((x | y) & 1) largest_m = std::max(largest_m, data_of(terrain).vertex({x, y}).error_m);
        CHECK(picture_of(pack, 64).largest_error_m >= largest_m);
        CHECK(picture_of(pack, 500).largest_error_m >= largest_m);
    }
}

TEST_CASE("errors that are nearly the same look nearly the same, and a hole's rim does not change their colour") {
    const auto sloping = [](bool with_hole) {
        Dem dem = level(100, 100);
        dem.native_quantum_m = 0.5;
        for (std::int32_t y = 0; y < 100; ++y)
            for (std::int32_t x = 0; x < 100; ++x)
                dem.heights_m[dem.index(x, y)] = static_cast<float>((x + y) % 2 ? 100 : 104);
        if (with_hole) dig(dem, 50, 50, 5, 5);
        return dem;
    };
    const Picture without = picture_of(bake_and_load(sloping(false), small_bake(7)), 100);
    CHECK(without.largest_error_m >= 9.99f * without.least_error_m);
    CHECK(without.least_error_m < 4);
    CHECK(without.largest_error_m > 4);
    const Picture with = picture_of(bake_and_load(sloping(true), small_bake(7)), 100);
    // Scales of errors differ by their steps, of 30 % at most.
    CHECK(with.least_error_m == Approx(without.least_error_m).epsilon(0.3));
    CHECK(with.largest_error_m == Approx(without.largest_error_m).epsilon(0.3));
    CHECK(redness(with.pixel(49, 52)) > redness(with.pixel(20, 20)) + 0.2);
}

TEST_CASE("north is up and light comes from the north-west") {
    Dem dem = level(101, 101);
    for (std::int32_t y = 0; y < 101; ++y)
        for (std::int32_t x = 0; x < 101; ++x)
            dem.heights_m[dem.index(x, y)] = static_cast<float>(1000 - 8 * std::hypot(x - 50, y - 50));
    dig(dem, 40, 0, 20, 1);
    const Picture picture = picture_of(bake_and_load(std::move(dem), small_bake(7)), 101);
    CHECK(shows_hole(picture.pixel(50, 0)));
    CHECK_FALSE(shows_hole(picture.pixel(50, 100)));
    const double north_west = luminance(picture.pixel(30, 30)), south_east = luminance(picture.pixel(70, 70)),
                 north_east = luminance(picture.pixel(70, 30)), south_west = luminance(picture.pixel(30, 70));
    CHECK(north_west > north_east + 20);
    CHECK(north_west > south_west + 20);
    CHECK(south_east < north_east - 20);
    CHECK(south_east < south_west - 20);
}

TEST_CASE("a picture keeps the aspect ratio in metres and the size that was asked for") {
    Dem dem = level(100, 100);
    dem.spacing_m[0] = 30;
    dem.spacing_m[1] = 10;
    const auto pack = bake_and_load(std::move(dem), small_bake(5));
    for (const std::uint32_t longest : {64u, 65u, 100u, 255u, 256u, 999u}) {
        const Picture picture = picture_of(pack, longest);
        INFO(longest);
        CHECK(picture.width == longest);
        CHECK(picture.terrain_height == static_cast<std::uint32_t>(std::lround(longest / 3.0)));
        CHECK((picture.height > picture.terrain_height) == (longest >= legend_from_px));
        CHECK(picture.rgb.size() == std::size_t{3} * picture.width * picture.height);
    }
    CHECK(picture_of(pack, 1).width == min_picture_px);
    CHECK(picture_of(pack, 1000000).width == max_picture_px);

    const Picture narrow = picture_of(bake_and_load(level(3, 900), small_bake(5)), 300);
    CHECK(narrow.width == 1);
    CHECK(narrow.height == 300);
}

TEST_CASE("the smallest terrain has a picture, each sample a quarter") {
    Dem dem = level(2, 2);
    dem.heights_m = {0, 10, 20, 40};
    dig(dem, 1, 0);
    const Picture picture = picture_of(bake_and_load(std::move(dem), small_bake(1)), 64);
    REQUIRE(picture.width == 64);
    REQUIRE(picture.height == 64);
    int different = 0;
    for (std::uint32_t y = 0; y < 64; ++y)
        for (std::uint32_t x = 0; x < 64; ++x) different += shows_hole(picture.pixel(x, y)) != (x >= 32 && y < 32);
    CHECK(different == 0);
}

TEST_CASE("the legend leaves a margin at every size, and knows of holes only where there are some") {
    // Words as long as they get: two spacings, tiny tiles and errors, many holes.
    Random random(8);
    Dem dem = level(200, 150);
    dem.spacing_m[0] = 0.0123;
    dem.spacing_m[1] = 0.0234;
    for (float& h : dem.heights_m) h = static_cast<float>(uniform(random, 0, 4e-5));
    BakeOptions options = small_bake(1);
    options.quantum_m = 1e-5;
    const Dem solid = dem;
    dig(dem, 3, 3, 190, 100);
    const auto with = bake_and_load(std::move(dem), options), without = bake_and_load(solid, options);
    const auto step = rounds<std::uint32_t>(4 * 173, 173);
    for (std::uint32_t longest = 256 * 234 / 123; longest < 2400; longest += step) {
        const Picture picture = picture_of(with, longest);
        INFO(longest);
        REQUIRE(picture.width >= legend_from_px);
        const Rgb8 paper = picture.pixel(0, picture.height - 1);
        CHECK(is_grey(paper));
        int printed = 0, cut = 0, holes = 0;
        for (std::uint32_t y = picture.terrain_height; y < picture.height; ++y)
            for (std::uint32_t x = 0; x < picture.width; ++x) {
                const bool margin =
                    x < 3 || x + 3 >= picture.width || y < picture.terrain_height + 3 || y + 3 >= picture.height;
                printed += picture.pixel(x, y) != paper;
                cut += margin && picture.pixel(x, y) != paper;
                holes += picture.pixel(x, y) == hole_rgb;
            }
        CHECK(printed > 500);
        CHECK(cut == 0);
        CHECK(holes > 20);
        const Picture other = picture_of(without, longest);
        int wrong = 0;
        for (std::uint32_t y = 0; y < other.height; ++y)
            for (std::uint32_t x = 0; x < other.width; ++x) wrong += shows_hole(other.pixel(x, y));
        CHECK(wrong == 0);
    }
}

TEST_CASE("a picture does not depend on the number of threads") {
    Random random(9);
    Dem dem = random_dem(random, 300, 200, Shape::fractal);
    dig(dem, 50, 60, 70, 30);
    const auto pack = bake_and_load(std::move(dem), small_bake(5));
    const bool same = picture_of(pack, 260, 1).rgb == picture_of(pack, 260, 7).rgb;
    CHECK(same);
}

TEST_CASE("a picture's file holds its pixels, and appears only when it is complete") {
    Random random(10);
    const Picture picture = picture_of(bake_and_load(random_dem(random, 90, 60, Shape::fractal), small_bake(4)), 300);
    const TemporaryFolder folder;
    { const io::AtomicFile abandoned(folder / "picture.png"); }
    CHECK(folder.names().empty());
    io::AtomicFile file(folder / "picture.png");
    write_png(picture, file);
    CHECK(folder.names() == std::vector<std::string>{"picture.png"});
    int width = 0, height = 0, channels = 0;
    const std::unique_ptr<stbi_uc, void (*)(void*)> pixels(
        stbi_load((folder / "picture.png").c_str(), &width, &height, &channels, 0), stbi_image_free);
    REQUIRE(pixels);
    CHECK(channels == 3);
    REQUIRE(static_cast<std::uint32_t>(width) == picture.width);
    REQUIRE(static_cast<std::uint32_t>(height) == picture.height);
    CHECK(std::equal(picture.rgb.begin(), picture.rgb.end(), pixels.get()));
}
