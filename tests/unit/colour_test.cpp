#include <algorithm>
#include <cmath>

#include "baker/colour.h"
#include "baker/read.h"
#include "raster.h"

using namespace fjell;
using namespace fjell::baker;
using namespace fjell::test;

namespace {

Dem dem_of(const Tree& tree, const std::function<double(int, int)>& height) {
    Dem dem;
    dem.columns = tree.columns();
    dem.rows = tree.rows();
    dem.spacing_m[0] = 10;
    dem.spacing_m[1] = 20;
    for (int y = 0; y < dem.rows; ++y)
        for (int x = 0; x < dem.columns; ++x) dem.heights_m.push_back(static_cast<float>(height(x, y)));
    return dem;
}
double bumps(int x, int y) {
    return (x * 7919 + y * 104729) % 97 + 0.3 * x;
}

Image noise(int width, int height) {
    Image image{width, height, {}};
    std::uint32_t state = 1;
    for (int i = 0; i < width * height * 3; ++i)
        image.rgb.push_back(static_cast<std::uint8_t>((state = state * 1664525 + 1013904223) >> 24));
    return image;
}

int as_signed(std::uint8_t v) {
    return static_cast<std::int8_t>(v);
}

// Texels of the shared column (or row) of two neighbours, equal bit for bit.
void check_borders(const Tree& tree, std::uint32_t log2, std::size_t channels,
                   const std::function<std::vector<std::uint8_t>(std::uint32_t tile, std::uint32_t mip)>& make) {
    const auto wide = static_cast<std::uint32_t>(tree.tiles_x);
    for (std::uint32_t mip = 0; log2 - mip >= 2; ++mip) {
        const std::size_t n = std::size_t{1} << (log2 - mip);
        const auto here = make(0, mip), east = make(1, mip), south = make(wide, mip);
        REQUIRE(here.size() == n * n * channels);
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t c = 0; c < channels; ++c) {
                REQUIRE(here[(i * n + n - 1) * channels + c] == east[i * n * channels + c]);
                REQUIRE(here[((n - 1) * n + i) * channels + c] == south[i * channels + c]);
            }
    }
}

Ramp grey_ramp() {
    return {{{0, {0, 0, 0}}, {255, {255, 255, 255}}}, false};
}

} // namespace

TEST_CASE("neighbouring tiles store equal texels on their border, in every mip") {
    const Tree tree{4, 3, 2};
    const Dem dem = dem_of(tree, bumps);
    for (const std::uint32_t log2 : {4u, 6u, 3u}) {
        const MapBuilder maps{dem, tree, log2, log2};
        const Ramp ramp = grey_ramp();
        for (const int width : {49, 211, 20}) {
            const Image image = noise(width, width * 2 / 3);
            check_borders(tree, log2, 3,
                          [&](auto tile, auto mip) { return colour_mip(maps, &image, nullptr, tile, mip); });
        }
        check_borders(tree, log2, 3, [&](auto tile, auto mip) { return colour_mip(maps, nullptr, &ramp, tile, mip); });
        check_borders(tree, log2, 2, [&](auto tile, auto mip) { return normal_mip(maps, tile, mip); });
    }
}

TEST_CASE("a constant image gives constant mips of the same colour") {
    const Tree tree{4, 2, 1};
    const Dem dem = dem_of(tree, bumps);
    for (int v = 0; v < 256; ++v) {
        Image image{37, 23, {}};
        for (int i = 0; i < 37 * 23; ++i)
            for (const int c : {v, 255 - v, v / 2}) image.rgb.push_back(static_cast<std::uint8_t>(c));
        const MapBuilder maps{dem, tree, 4, 4};
        for (std::uint32_t mip = 0; mip <= 2; ++mip) {
            const auto rgb = colour_mip(maps, &image, nullptr, 1, mip);
            for (std::size_t i = 0; i < rgb.size(); ++i) REQUIRE(rgb[i] == image.rgb[i % 3]);
        }
    }
}

TEST_CASE("black and white average in light, not in code values") {
    const Tree tree{6, 1, 1};
    const Dem dem = dem_of(tree, bumps);
    Image image{256, 256, {}};
    for (int y = 0; y < 256; ++y)
        for (int x = 0; x < 256; ++x) image.rgb.insert(image.rgb.end(), 3, (x + y) % 2 ? 255 : 0);
    const auto rgb = colour_mip({dem, tree, 4, 4}, &image, nullptr, 0, 0);
    // Half the light is code 188; the tent's 17 pixels a side leave less than 1/17 of it uneven.
    for (const std::uint8_t v : rgb) CHECK(std::abs(v - 188) <= 6);
}

TEST_CASE("an image lies with its outer edge on the outermost samples") {
    const Tree tree{4, 2, 1};
    const Dem dem = dem_of(tree, bumps);
    // Red rises from west to east, green from north to south, linearly in light at the pixels' middles.
    Image image{320, 160, {}};
    for (int y = 0; y < 160; ++y)
        for (int x = 0; x < 320; ++x)
            for (const int c : {x * 255 / 319, y * 255 / 159, 0}) image.rgb.push_back(static_cast<std::uint8_t>(c));
    const MapBuilder maps{dem, tree, 5, 4};
    for (std::uint32_t tile = 0; tile < 2; ++tile) {
        const auto rgb = colour_mip(maps, &image, nullptr, tile, 0);
        for (std::size_t j = 0; j < 32; ++j)
            for (std::size_t i = 0; i < 32; ++i) {
                const double u = (static_cast<double>(i) / 31 + tile) / 2, v = static_cast<double>(j) / 31;
                // Within a texel's footprint of 5 pixels: 255 * 5 / 160 on the coarser axis.
                CHECK(std::abs(rgb[(j * 32 + i) * 3] - 255 * u) <= 8);
                CHECK(std::abs(rgb[(j * 32 + i) * 3 + 1] - 255 * v) <= 8);
            }
    }
}

TEST_CASE("a mirrored image gives mirrored mips") {
    const Tree tree{4, 1, 1};
    const Dem dem = dem_of(tree, bumps);
    for (const int width : {7, 16, 90}) {
        const Image image = noise(width, width);
        Image turned = image; // half a turn: both axes at once
        for (std::size_t i = 0, n = image.rgb.size() / 3; i < n; ++i)
            std::copy_n(image.rgb.begin() + static_cast<std::ptrdiff_t>(3 * (n - 1 - i)), 3,
                        turned.rgb.begin() + static_cast<std::ptrdiff_t>(3 * i));
        for (std::uint32_t mip = 0; mip <= 2; ++mip) {
            const auto a = colour_mip({dem, tree, 4, 4}, &image, nullptr, 0, mip);
            const auto b = colour_mip({dem, tree, 4, 4}, &turned, nullptr, 0, mip);
            const std::size_t n = a.size() / 3;
            for (std::size_t i = 0; i < a.size(); ++i) // sums in the other order: a code at a tie
                REQUIRE(std::abs(a[i] - b[3 * (n - 1 - i / 3) + i % 3]) <= 1);
        }
    }
}

TEST_CASE("an image covers the terrain, not its tiles; texels beyond the rim take the nearest colour") {
    const Tree tree = Tree::covering(9, 17, 4); // the eastern half of the tile lies beyond
    const Dem dem = dem_of(tree, bumps);
    REQUIRE(dem.columns == 9);
    Image image{330, 330, {}};
    for (int i = 0; i < 330 * 330; ++i)
        for (const int c : {i % 330 * 255 / 329, 0, 0}) image.rgb.push_back(static_cast<std::uint8_t>(c));
    const auto rgb = colour_mip({dem, tree, 4, 4}, &image, nullptr, 0, 0);
    CHECK(std::abs(rgb[4 * 3] - 255 * 4 * 16 / 15 / 8) <=
          12); // texel 4 of 0..15 over 16 cells of which 8 carry the image
    for (std::size_t x = 9; x < 16; ++x) CHECK(rgb[x * 3] == 255);
}

TEST_CASE("a ramp colours heights between its stops, and holds beyond them") {
    const Tree tree{4, 1, 1};
    const Ramp ramp{{{0, {10, 20, 30}}, {100, {110, 220, 30}}}, false};
    const auto colour = [&](double height) {
        const Dem dem = dem_of(tree, [=](int, int) { return height; });
        return colour_mip({dem, tree, 4, 4}, nullptr, &ramp, 0, 1);
    };
    const auto first = [](const std::vector<std::uint8_t>& rgb) {
        return std::vector<int>(rgb.begin(), rgb.begin() + 3);
    };
    CHECK(first(colour(-50)) == std::vector<int>{10, 20, 30});
    CHECK(first(colour(0)) == std::vector<int>{10, 20, 30});
    CHECK(first(colour(50)) == std::vector<int>{60, 120, 30});
    CHECK(first(colour(100)) == std::vector<int>{110, 220, 30});
    CHECK(first(colour(1e6)) == std::vector<int>{110, 220, 30});
}

TEST_CASE("a relative ramp spans the DEM's own heights") {
    const Tree tree{4, 2, 1};
    const Dem dem = dem_of(tree, [](int x, int) { return 300 + 10 * x; });
    Ramp relative{{{0, {0, 0, 0}}, {1, {255, 255, 255}}}, true};
    const Ramp metres = absolute(relative, dem);
    CHECK_FALSE(metres.relative);
    CHECK(metres.stops[0].height_m == 300);
    CHECK(metres.stops[1].height_m == 620);
    CHECK(colour_mip({dem, tree, 4, 4}, nullptr, &relative, 1, 0) ==
          colour_mip({dem, tree, 4, 4}, nullptr, &metres, 1, 0));
}

TEST_CASE("an inclined plane has its own normal everywhere, rim included, to a code") {
    const Tree tree{4, 2, 2};
    for (const auto& [east, south] : {std::pair{0.0, 0.0}, {0.5, 0.0}, {0.0, -0.25}, {-2.0, 1.0}, {3.0, 4.0}}) {
        const Dem dem = dem_of(tree, [e = east, s = south](int x, int y) { return 1000 + e * 10 * x + s * 20 * y; });
        const double up = 1 / std::sqrt(1 + east * east + south * south);
        for (std::uint32_t tile = 0; tile < 4; ++tile)
            for (std::uint32_t mip = 0; mip <= 3; ++mip) {
                const auto normals = normal_mip({dem, tree, 5, 5}, tile, mip);
                for (std::size_t i = 0; i < normals.size(); i += 2) {
                    REQUIRE(std::abs(as_signed(normals[i]) / 127.0 + east * up) <= 0.501 / 127);
                    REQUIRE(std::abs(as_signed(normals[i + 1]) / 127.0 + south * up) <= 0.501 / 127);
                }
            }
    }
}

TEST_CASE("a map's size keeps its source's detail up to the limit") {
    CHECK(fitting_log2(1, 10) == 2);
    CHECK(fitting_log2(256, 10) == 8);
    CHECK(fitting_log2(257, 10) == 8);
    CHECK(fitting_log2(300, 10) == 9);
    CHECK(fitting_log2(1e9, 10) == 10);
    for (double t = 1; t < 1024; ++t) CHECK((1u << fitting_log2(t, 10)) * 1.125 >= t);
}

TEST_CASE("images of every kind become 8-bit RGB") {
    const TempDir dir;
    Raster r = raster(6, 5, [](int x, int y) { return 10 * x + y; });
    r.geotransform.clear();
    r.type = GDT_Byte;
    const auto texel = [](const Image& image, int x, int y) {
        const auto* at = &image.rgb[static_cast<std::size_t>(y * image.width + x) * 3];
        return std::vector<int>(at, at + 3);
    };
    SECTION("grey") {
        CHECK(texel(read_image(write(r, dir / "a.png", "PNG")), 3, 2) == std::vector<int>{32, 32, 32});
    }
    SECTION("grey of 16 bits") {
        r.type = GDT_UInt16;
        for (double& v : r.values) v *= 257;
        CHECK(texel(read_image(write(r, dir / "a.png", "PNG")), 3, 2) == std::vector<int>{32, 32, 32});
    }
    SECTION("red, green, blue, with and without alpha") {
        for (const int bands : {3, 4}) {
            r.bands = bands;
            r.more = [](GDALDataset& file) { file.GetRasterBand(2)->Fill(200); };
            const Image image = read_image(write(r, dir / "a.png", "PNG"));
            CHECK(image.width == 6);
            CHECK(image.height == 5);
            CHECK(texel(image, 3, 2) == std::vector<int>{32, 200, 32});
        }
    }
    SECTION("palette") {
        r.more = [](GDALDataset& file) {
            GDALColorTable table;
            for (int i = 0; i < 64; ++i) {
                const GDALColorEntry entry{static_cast<short>(i), static_cast<short>(2 * i),
                                           static_cast<short>(255 - i), 255};
                table.SetColorEntry(i, &entry);
            }
            file.GetRasterBand(1)->SetColorTable(&table);
        };
        CHECK(texel(read_image(write(r, dir / "a.png", "PNG")), 3, 2) == std::vector<int>{32, 64, 223});
    }
}

TEST_CASE("what is no image is refused with what to do") {
    const TempDir dir;
    const auto refused = [](const std::string& path) { return refusal([&] { (void)read_image(path); }); };
    check_refusal(refused(dir / "missing.png"), 1, dir / "missing.png", {"no such file"});
    check_refusal(refused(dir / "."), 1, dir / ".", {"is a folder"});
    write_text(dir / "text.jpg", "no picture");
    check_refusal(refused(dir / "text.jpg"), 1, dir / "text.jpg", {"cannot be read as an image"});
    const std::string heights = write(raster(5, 5, bumps), dir / "a.tif");
    check_refusal(refused(heights), 1, heights, {"Float32", "gdal_translate -ot Byte"});
}

TEST_CASE("the ramps in content/ are ramps") {
    const std::string folder = std::string(FJELL_SOURCE_DIR) + "/content/ramps/";
    CHECK(read_ramp(folder + "alpine.json").relative);
    const Ramp earth = read_ramp(folder + "earth.json");
    CHECK_FALSE(earth.relative);
    CHECK(earth.stops.front().height_m <= -10000);
    CHECK(earth.stops.back().height_m >= 8000);
}

TEST_CASE("a ramp that is not one is refused, naming the stop") {
    const TempDir dir;
    const std::string path = dir / "ramp.json";
    const auto refused = [&](const std::string& text) {
        write_text(path, text);
        return refusal([&] { (void)read_ramp(path); });
    };
    const std::string a = R"({"height_m": 0, "rgb": [0, 0, 0]})", b = R"({"height_m": 9, "rgb": [9, 9, 9]})";
    CHECK(refused("{\"stops\": [" + a + ", " + b + "]}").code == 0);
    check_refusal(refused("oops"), 1, path, {"not a JSON object", "content/ramps/earth.json"});
    check_refusal(refused("{\"stops\": [" + a + "]}"), 1, path, {"at least two"});
    check_refusal(refused("{\"stops\": [" + b + ", " + a + "]}"), 1, path, {"stop 1", "rise"});
    check_refusal(refused("{\"stops\": [" + a + ", {\"height_m\": 9, \"rgb\": [9, 9, 999]}]}"), 1, path,
                  {"stop 1", "0..255"});
    check_refusal(refused("{\"stops\": [" + a + ", {\"height_m\": 9, \"rgb\": [9, 9]}]}"), 1, path,
                  {"stop 1", "three numbers"});
    check_refusal(refused("{\"stops\": [" + a + ", {\"height\": 9, \"rgb\": [9, 9, 9]}]}"), 1, path,
                  {"stop 1", "height_m"});
    check_refusal(refused("{\"stopps\": []}"), 1, path, {"unknown field \"stopps\""});
    check_refusal(refusal([&] { (void)read_ramp(dir / "none.json"); }), 1, dir / "none.json", {"No such file"});
}
