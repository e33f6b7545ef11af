// Ramps and images: what they mean, and what is refused.
#include <algorithm>
#include <bit>
#include <cmath>

#include <cpl_string.h>

#include "baker/georeference/open_source.h"
#include "baker/maps/colour.h"
#include "baker/maps/image.h"
#include "raster.h"
#include "support/dem.h"
#include "support/rounds.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::baker;
using namespace fjell::test;

namespace {

double hills(int x, int y) {
    return (x * 7919 + y * 104729) % 97 + 0.3 * x;
}

std::vector<int> painted(const Ramp& ramp, double height, double degrees = 0) {
    float rgb[3];
    RampPainter(ramp).paint(static_cast<float>(height), static_cast<float>(std::cos(degrees * 3.14159265358979 / 180)),
                            rgb);
    return {static_cast<int>(rgb[0] + 0.5f), static_cast<int>(rgb[1] + 0.5f), static_cast<int>(rgb[2] + 0.5f)};
}

// A terrain of that many samples without a CRS: images are stretched over it.
Frame plain(int columns, int rows) {
    return {columns, rows, {0, 0}, {0, 0}, ""};
}

Frame over(int columns, int rows, const double (&step)[2], const double (&origin)[2], const std::string& crs) {
    return {columns, rows, {origin[0], origin[1]}, {step[0], step[1]}, crs};
}

// UTM zone 32, as WKT.
std::string utm() {
    OGRSpatialReference crs;
    crs.importFromEPSG(32632);
    char* text = nullptr;
    crs.exportToWkt(&text);
    const std::string wkt = text;
    CPLFree(text);
    return wkt;
}

std::vector<std::uint8_t> pixels(const ImageSource& image, const Window& w, std::size_t layer = 0) {
    std::vector<std::uint8_t> rgba(w.area() * 4);
    image.reader()->read(layer, w, rgba.data());
    return rgba;
}

} // namespace

TEST_CASE("a ramp colours heights between its stops, and holds beyond them") {
    const Ramp ramp{{{0, {10, 20, 30}}, {100, {110, 220, 30}}}, false, {}};
    CHECK(painted(ramp, -50) == std::vector<int>{10, 20, 30});
    CHECK(painted(ramp, 0) == std::vector<int>{10, 20, 30});
    CHECK(painted(ramp, 50) == std::vector<int>{60, 120, 30});
    CHECK(painted(ramp, 100) == std::vector<int>{110, 220, 30});
    CHECK(painted(ramp, 1e6) == std::vector<int>{110, 220, 30});
    CHECK(painted(ramp, 50, 89) == std::vector<int>{60, 120, 30}); // without slopes steepness does not matter
}

TEST_CASE("steep ground passes into the colours of its slope, in proportion to the cosine") {
    const Ramp ramp{{{0, {0, 0, 0}}, {100, {0, 0, 0}}},
                    false,
                    {{30, 40, {{0, {100, 0, 0}}, {100, {200, 0, 0}}}}, {60, 70, {{0, {0, 0, 250}}}}}};
    CHECK(painted(ramp, 50, 0) == std::vector<int>{0, 0, 0});
    CHECK(painted(ramp, 50, 29.9) == std::vector<int>{0, 0, 0});
    CHECK(painted(ramp, 50, 40.1) == std::vector<int>{150, 0, 0});
    CHECK(painted(ramp, 100, 59.9) == std::vector<int>{200, 0, 0});
    CHECK(painted(ramp, 50, 80) == std::vector<int>{0, 0, 250});
    const double half = std::acos((std::cos(30 * 3.14159265358979 / 180) + std::cos(40 * 3.14159265358979 / 180)) / 2) *
                        180 / 3.14159265358979;
    CHECK(painted(ramp, 100, half) == std::vector<int>{100, 0, 0});
}

TEST_CASE("a relative ramp spans the terrain's own heights, slopes included") {
    const Ramp relative{{{0, {0, 0, 0}}, {1, {255, 255, 255}}}, true, {{10, 20, {{0.5, {1, 2, 3}}, {1, {4, 5, 6}}}}}};
    const Ramp metres = absolute(relative, 300, 620);
    CHECK_FALSE(metres.relative);
    CHECK(metres.stops[0].height_m == 300);
    CHECK(metres.stops[1].height_m == 620);
    CHECK(metres.slopes[0].stops[0].height_m == 460);
    for (const float height_m : {4.9999995f, 5.0f, 5.0000005f}) // level: the lowest colour, however heights round
        CHECK(painted(absolute(relative, 5, 5), height_m) == std::vector<int>{0, 0, 0});
}

TEST_CASE("many texels are painted as each of them alone, bit for bit") {
    Random random(17);
    for (int round = 0; round < rounds(30, 300); ++round) {
        const auto stops = [&] {
            std::vector<Ramp::Stop> all(static_cast<std::size_t>(pick(random, 1, 6)));
            double height_m = pick(random, -500, 500);
            for (Ramp::Stop& stop : all) {
                stop = {height_m, {0, 0, 0}};
                for (double& v : stop.rgb) v = pick(random, 0, 255);
                height_m += pick(random, 0, 3) * 100; // some stand at one height
            }
            return all;
        };
        Ramp ramp{stops(), false, {}};
        for (int degrees = 5, layers = pick(random, 0, 3); layers > 0; --layers, degrees += 20)
            ramp.slopes.push_back({degrees + 0.0, degrees + pick(random, 1, 18) + 0.0, stops()});
        // Rows that lie in one layer and stop, or pass through all of them; whole pieces and parts of them.
        const auto count = static_cast<std::size_t>(pick(random, 1, 300));
        const double middle_m = pick(random, -900, 900), range_m = pick(random, 0, 2) * 300;
        const double least = pick(random, 0, 70), range = pick(random, 0, 20);
        std::vector<float> heights_m, up;
        for (std::size_t i = 0; i < count; ++i) {
            const double at = pick(random, 0, 1000) / 1000.0;
            heights_m.push_back(static_cast<float>(middle_m + (at - 0.5) * range_m));
            up.push_back(static_cast<float>(std::cos((least + at * range) * 3.14159265358979 / 180)));
        }
        std::vector<float> light[3] = {heights_m, heights_m, heights_m};
        RampPainter painter(ramp);
        painter.paint_light(heights_m.data(), up.data(), count, {light[0].data(), light[1].data(), light[2].data()});
        for (std::size_t i = 0; i < count; ++i) {
            float rgb[3];
            painter.paint(heights_m[i], up[i], rgb);
            for (std::size_t c = 0; c < 3; ++c) {
                CAPTURE(round, i, c);
                REQUIRE(std::bit_cast<std::uint32_t>(light[c][i]) ==
                        std::bit_cast<std::uint32_t>(light_of_srgb(rgb[c])));
            }
        }
    }
}

TEST_CASE("light and sRGB are each other's inverse for every code") {
    for (int v = 0; v < 256; ++v) {
        const float light = light_of_srgb(static_cast<float>(v));
        CHECK(srgb_of_light()[static_cast<std::size_t>(light * 65535 + 0.5f)] == v);
    }
    CHECK(light_of_srgb(188) == Approx(0.503).margin(0.002));
}

TEST_CASE("a map's size keeps its source's detail up to the limit") {
    CHECK(fitting_log2(1, 10) == 2);
    CHECK(fitting_log2(256, 10) == 8);
    CHECK(fitting_log2(257, 10) == 8);
    CHECK(fitting_log2(300, 10) == 9);
    CHECK(fitting_log2(1e9, 10) == 10);
    for (double t = 1; t < 1024; ++t) CHECK((1u << fitting_log2(t, 10)) * 1.125 >= t);
}

TEST_CASE("images of every kind become red, green, blue and alpha") {
    const TempDir dir;
    Raster r = raster(6, 5, [](int x, int y) { return 10 * x + y; });
    r.geotransform.clear();
    r.type = GDT_Byte;
    const auto texel = [](const std::string& path) {
        const auto image = open_images({path}, plain(3, 3));
        REQUIRE(image->layers.size() == 1);
        CHECK(image->layers[0].columns == 6);
        CHECK(image->layers[0].rows == 5);
        CHECK(image->layers[0].per_sample[0] == 3);     // stretched: two cells for six pixels
        const auto rgba = pixels(*image, {2, 1, 3, 3}); // (3, 2) is in its middle
        return std::vector<int>(rgba.begin() + 16, rgba.begin() + 20);
    };
    SECTION("grey") {
        CHECK(texel(write(r, dir / "a.png", "PNG")) == std::vector<int>{32, 32, 32, 255});
    }
    SECTION("grey with a value that means nothing") {
        r.more = [](GDALDataset& file) { file.GetRasterBand(1)->SetNoDataValue(32); };
        CHECK(texel(write(r, dir / "a.tif")) == std::vector<int>{32, 32, 32, 0});
    }
    SECTION("grey of 16 bits") {
        r.type = GDT_UInt16;
        for (double& v : r.values) v *= 257;
        CHECK(texel(write(r, dir / "a.png", "PNG")) == std::vector<int>{32, 32, 32, 255});
    }
    SECTION("red, green, blue, with and without alpha") {
        for (const int bands : {3, 4}) {
            r.bands = bands;
            r.more = [=](GDALDataset& file) {
                file.GetRasterBand(2)->Fill(200);
                if (bands == 4) file.GetRasterBand(4)->Fill(77);
            };
            CHECK(texel(write(r, dir / "a.png", "PNG")) == std::vector<int>{32, 200, 32, bands == 4 ? 77 : 255});
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
        CHECK(texel(write(r, dir / "a.png", "PNG")) == std::vector<int>{32, 64, 223, 255});
    }
}

TEST_CASE("a georeferenced image lies by its coordinates") {
    const TempDir dir;
    // 40 x 30 pixels of 5 m; its outer corner at (900, 2100).
    Raster r = raster(40, 30, [](int x, int y) { return 5 * x + y; });
    r.type = GDT_Byte;
    r.geotransform = {900, 5, 0, 2100, 0, -5};
    r.crs = "EPSG:32632";
    const std::string path = write(r, dir / "a.tif");
    const double spacing[2] = {10, 20}, origin[2] = {1000, 2000};
    const Frame ground = over(9, 3, spacing, origin, utm());
    const auto image = open_images({path}, ground);
    CHECK(image->layers[0].first_px[0] == 20);
    CHECK(image->layers[0].first_px[1] == 20);
    CHECK(image->layers[0].per_sample[0] == 2);
    CHECK(image->layers[0].per_sample[1] == 4);
    CHECK(image->pixels_per_sample() == 4);
    SECTION("several make a mosaic, the last uppermost") {
        CHECK(open_images({path, path}, ground)->layers.size() == 2);
        r.geotransform.clear();
        const std::string plain_image = write(r, dir / "b.tif");
        check_refusal(refusal([&] {
                          (void)open_images({path, plain_image}, ground);
                      }),
                      1, plain_image, {"georeference"});
    }
    SECTION("beside the terrain it is refused with both places") {
        const double far_away[2] = {9000, 2000};
        check_refusal(refusal([&] { (void)open_images({path}, over(9, 3, spacing, far_away, utm())); }), 1, path,
                      {"beside the terrain", "900", "9000"});
    }
    SECTION("over a terrain without CRS, or of unknown step, it is stretched") {
        CHECK(open_images({path}, plain(9, 3))->layers[0].first_px[0] == 0);
        const double unknown[2] = {0, 0};
        CHECK(open_images({path}, over(9, 3, unknown, origin, utm()))->layers[0].first_px[0] == 0);
    }
    SECTION("its identity names the file and changes with it") {
        const std::string before = image->identity();
        CHECK(before.find("a.tif") != std::string::npos);
        CHECK(open_images({path}, ground)->identity() == before);
        std::filesystem::last_write_time(path, std::filesystem::file_time_type::clock::now() + std::chrono::seconds(9));
        CHECK(open_images({path}, ground)->identity() != before);
    }
}

TEST_CASE("an image lies by its coordinates whatever --spacing makes of a height field, and whole turns do not count") {
    const TempDir dir;
    // Heights on 30 x 20 samples a tenth of a degree apart from (8, 46) on; an image of its middle third.
    Raster heights = raster(30, 20, [](int x, int y) { return x + y; });
    heights.geotransform = {7.95, 0.1, 0, 46.05, 0, -0.1};
    heights.crs = "EPSG:4326";
    const std::string dem = write(heights, dir / "dem.tif");
    Raster r = raster(100, 100, [](int x, int y) { return x + y; });
    r.type = GDT_Byte;
    r.geotransform = {9, 0.01, 0, 45.5, 0, -0.01};
    r.crs = "EPSG:4326";
    ReadOptions o;
    o.spacing_m = 5000;
    const auto source = open_source({dem}, o);
    CHECK(source->spacing_m[0] == 5000);
    CHECK(source->crs_step[0] == Approx(0.1));
    for (const double turn : {0.0, 360.0, -720.0}) {
        r.geotransform[0] = 9 + turn;
        const auto image = open_images({write(r, dir / "image.tif")}, frame_of(*source));
        CHECK(image->layers[0].first_px[0] == Approx(-100));
        CHECK(image->layers[0].first_px[1] == Approx(-50));
        CHECK(image->layers[0].per_sample[0] == Approx(10));
        CHECK(image->layers[0].per_sample[1] == Approx(10));
    }
    // Metres that are overridden, and feet.
    heights.geotransform = {500000, 300, 0, 5000000, 0, -300};
    for (const auto& [crs, unit_m] : {std::pair{"EPSG:32632", 1.0}, {"EPSG:2225", 1200.0 / 3937}}) {
        heights.crs = crs;
        ReadOptions as_it_is;
        as_it_is.zscale = 1; // what counts feet across is asked about
        const std::string path = write(heights, dir / "projected.tif");
        const auto own = open_source({path}, as_it_is);
        CHECK(own->spacing_m[1] == Approx(300 * unit_m));
        CHECK(own->crs_step[1] == 300);
        ReadOptions wider; // resampled
        wider.spacing_m = 600;
        wider.zscale = 1;
        CHECK(open_source({path}, wider)->crs_step[1] == Approx(600 / unit_m));
        CHECK(frame_of(*open_source({path}, wider)).step[0] == Approx(600 / unit_m));
        CHECK(DemSource(read_dem(path, as_it_is)).crs_step[0] == 300);
        Dem made = read_dem(path, as_it_is);
        made.crs_step[0] = made.crs_step[1] = 0;
        CHECK(DemSource(made).crs_step[0] == Approx(300)); // follows from the spacing
        CHECK(DemSource(read_dem(path, wider)).crs_step[0] == Approx(600 / unit_m));
    }
}

TEST_CASE("an image in another CRS is warped, and its pixels do not depend on how they are read") {
    const TempDir dir;
    // A degree and a half around 9 E, 45 N (zone 32's middle): red rises eastwards.
    Raster r = raster(700, 400, [](int x, int) { return x / 3; });
    r.type = GDT_Byte;
    r.bands = 3;
    r.geotransform = {8.25, 1.5 / 700, 0, 45.5, 0, -1.0 / 400};
    r.crs = "EPSG:4326";
    const std::string path = write(r, dir / "a.tif");
    const double spacing[2] = {100, 100}, origin[2] = {490000, 4990000};
    const auto image = open_images({path}, over(201, 101, spacing, origin, utm()));
    const ImageLayer& l = image->layers[0];
    // The middle of the terrain is (500000, 4985000), 9 E: the middle of the image, 350 / 3.
    const auto x = static_cast<int>(l.first_px[0] + 100 * l.per_sample[0]);
    const auto y = static_cast<int>(l.first_px[1] + 50 * l.per_sample[1]);
    const auto middle = pixels(*image, {x, y, 1, 1});
    CHECK(std::abs(middle[0] - 350 / 3) <= 1);
    CHECK(middle[3] == 255);
    // Outside of the source, in the corner of the warped frame, there is nothing.
    CHECK(pixels(*image, {0, 0, 1, 1})[3] == 0);
    const Window all{3, 5, std::min(l.columns, 640) - 3, std::min(l.rows, 300) - 5};
    const auto whole = pixels(*image, all);
    const auto reader = image->reader();
    for (int round = 40; round-- > 0;) { // windows of all kinds, backwards
        const Window w{all.x + round * 13, all.y + round * 5, 1 + round % 60, 1 + round % 7 * 11};
        std::vector<std::uint8_t> rgba(w.area() * 4);
        reader->read(0, w, rgba.data());
        for (int j = 0; j < w.rows; ++j)
            for (int i = 0; i < 4 * w.columns; ++i)
                REQUIRE(rgba[static_cast<std::size_t>(j * 4 * w.columns + i)] ==
                        whole[static_cast<std::size_t>((w.y - all.y + j) * 4 * all.columns + 4 * (w.x - all.x) + i)]);
    }
}

TEST_CASE("of 16 bits as many count as NBITS says, or without it as the largest number has") {
    const TempDir dir;
    // 40 x 30 pixels of a quarter of white; one of them white, unless the file says its bits. The second file is turned
    // by a hair, so that it is warped.
    struct Case {
        int bits;
        bool says;
        int quarter; // what a quarter of white is of 255
    };
    for (const Case& c : {Case{10, true, 64},
                          {11, true, 64},
                          {12, true, 64},
                          {10, false, 64},
                          {11, false, 64},
                          {12, false, 64},
                          {8, false, 64},
                          {16, false, 64},
                          {13, false, 8}})
        for (const double turn : {0.0, 1.0})
            for (const int bands : {1, 3, 4}) {
                const int white = (1 << c.bits) - 1, quarter = (white + 1) / 4;
                const std::string path = dir / "a.tif";
                Raster r = raster(40, 30, [&](int x, int y) { return !c.says && x == 3 && y == 29 ? white : quarter; });
                r.type = GDT_UInt16;
                r.bands = bands;
                r.crs = "EPSG:32632";
                r.geotransform = {900, 5, turn, 2100, -turn, -5};
                r.more = [&](GDALDataset& file) {
                    if (bands == 4) {
                        file.GetRasterBand(4)->SetColorInterpretation(GCI_AlphaBand);
                        file.GetRasterBand(4)->Fill(white);
                    }
                };
                if (c.says) r.creation = {"NBITS=" + std::to_string(c.bits)};
                write(r, path);
                const double spacing[2] = {5, 5}, origin[2] = {950, 2050};
                const auto image = open_images({path}, over(9, 9, spacing, origin, utm()));
                const auto at = static_cast<std::int32_t>(image->layers[0].first_px[0]) + 4;
                const auto row = static_cast<std::int32_t>(image->layers[0].first_px[1]) + 4;
                const auto rgba = pixels(*image, {at, row, 1, 1});
                INFO(c.bits << " bits, said " << c.says << ", turned " << turn << ", " << bands << " bands");
                CHECK(static_cast<int>(rgba[0]) == c.quarter);
                if (c.bits != 13) CHECK(static_cast<int>(rgba[3]) == 255);
                CHECK(image->accounts.at(0).find(std::to_string(c.bits == 13 ? 65535 : white)) != std::string::npos);
            }
}

TEST_CASE("an image's colours are the bands that say so, or those that are asked for") {
    const TempDir dir;
    const double spacing[2] = {5, 5}, origin[2] = {950, 2050};
    struct Case {
        std::vector<std::string> says; // of each band, which holds 40 times its number: a colour's or another name
        bool by_name = false;
        std::string asked;
        std::vector<int> right; // empty: refused
    };
    const std::vector<Case> cases{
        {{"red", "green", "blue"}, false, "", {40, 80, 120}},
        {{"blue", "green", "red"}, false, "", {120, 80, 40}},
        {{"Blue", "Green", "Red", "NIR"}, true, "", {120, 80, 40}},
        {{"", "", "", "", ""}, true, "", {}},
        {{"", "", "", ""}, true, "", {40, 80, 120}}, // near infrared behind them
        {{"", ""}, true, "", {}},
        {{"grey", "alpha of some kind"}, true, "", {}},
        {{""}, true, "", {40, 40, 40}},
        {{"B01", "B02", "B03", "B04", "B08"}, true, "B04,B03,B02", {160, 120, 80}},
        {{"B01", "blue", "green", "red", "B08"}, true, "", {160, 120, 80}},
        {{"", "", "", "", ""}, true, "5,1,3", {200, 40, 120}},
        {{"", "", "", "", ""}, true, "4", {160, 160, 160}},
        {{"", "", ""}, true, "2", {80, 80, 80}},
        {{"", ""}, true, "2", {80, 80, 80}},
        {{"", "", ""}, true, "1,2", {}},
        {{"", "", ""}, true, "3,2,4", {}},
        {{"", "", ""}, true, "green", {}},
    };
    for (std::size_t i = 0; i < cases.size(); ++i)
        for (const double turn : {0.0, 1.0})
            for (const bool wide : {false, true}) {
                const Case& c = cases[i];
                Raster r = raster(40, 30, [](int, int) { return 0; });
                r.type = wide ? GDT_UInt16 : GDT_Byte;
                if (wide) r.creation = {"NBITS=10"};
                r.bands = static_cast<int>(c.says.size());
                r.crs = "EPSG:32632";
                r.geotransform = {900, 5, turn, 2100, -turn, -5};
                r.more = [&](GDALDataset& file) {
                    for (int b = 1; b <= r.bands; ++b) {
                        const std::string& word = c.says[static_cast<std::size_t>(b) - 1];
                        GDALRasterBand& band = *file.GetRasterBand(b);
                        band.SetColorInterpretation(c.by_name        ? b == 1 ? GCI_GrayIndex : GCI_Undefined
                                                    : word == "red"  ? GCI_RedBand
                                                    : word == "blue" ? GCI_BlueBand
                                                                     : GCI_GreenBand);
                        if (c.by_name) band.SetDescription(word.c_str());
                        REQUIRE(band.Fill(wide ? 40 * b * 1023 / 255.0 : 40 * b) == CE_None);
                    }
                };
                const std::string path = write(r, dir / "a.tif");
                const Frame ground = over(9, 9, spacing, origin, utm());
                CAPTURE(i, turn, wide);
                if (c.right.empty()) {
                    CHECK(refusal([&] { (void)open_images({path}, ground, c.asked); }).code != 0);
                    continue;
                }
                const auto image = open_images({path}, ground, c.asked);
                const auto rgba = pixels(*image, {static_cast<std::int32_t>(image->layers[0].first_px[0]) + 4,
                                                  static_cast<std::int32_t>(image->layers[0].first_px[1]) + 4, 1, 1});
                for (std::size_t k = 0; k < 3; ++k) CHECK(static_cast<int>(rgba[k]) == c.right[k]);
                CHECK(static_cast<int>(rgba[3]) == 255);
            }
    Raster r = raster(40, 30, [](int, int) { return 1; });
    r.type = GDT_Byte;
    r.bands = 5;
    r.geotransform.clear();
    const std::string path = write(r, dir / "five.tif");
    check_refusal(refusal([&] { (void)open_images({path}, plain(5, 5)); }), 1, path, {"--texture-bands R,G,B"});
    // What says where there is a picture goes with the bands that are chosen.
    r.more = [](GDALDataset& file) {
        file.GetRasterBand(5)->SetColorInterpretation(GCI_AlphaBand);
        REQUIRE(file.GetRasterBand(5)->Fill(7) == CE_None);
    };
    const auto image = open_images({write(r, dir / "alpha.tif")}, plain(5, 5), "4,3,2");
    CHECK(pixels(*image, {20, 20, 1, 1}) == std::vector<std::uint8_t>{1, 1, 1, 7});
    CHECK(image->accounts[0].find(": bands 4, 3, 2, 8 bits;") != std::string::npos);
}

TEST_CASE("an image with control points lies where they are") {
    const TempDir dir;
    // Pixels of 5 m, turned by a quarter: columns run north, rows east. Column 20 to 40 is bright.
    const auto east = [](double, double line) { return 900 + 5 * line; };
    const auto north = [](double pixel, double) { return 1900 + 5 * pixel; };
    const auto write_points = [&](const std::string& path, double bent, bool with_crs) {
        Raster r = raster(40, 60, [](int x, int) { return x < 20 ? 50 : 200; });
        r.type = GDT_Byte;
        r.geotransform.clear();
        r.more = [&](GDALDataset& file) {
            std::vector<GDAL_GCP> points(9);
            GDALInitGCPs(9, points.data());
            for (int i = 0; i < 9; ++i) {
                GDAL_GCP& p = points[static_cast<std::size_t>(i)];
                p.dfGCPPixel = i % 3 * 20, p.dfGCPLine = i / 3 * 30;
                p.dfGCPX = east(p.dfGCPPixel, p.dfGCPLine) + (i % 2 ? bent : 0);
                p.dfGCPY = north(p.dfGCPPixel, p.dfGCPLine);
            }
            OGRSpatialReference crs;
            crs.SetFromUserInput("EPSG:32632");
            REQUIRE(file.SetGCPs(9, points.data(), with_crs ? &crs : nullptr) == CE_None);
            GDALDeinitGCPs(9, points.data());
        };
        return write(r, path);
    };
    const double spacing[2] = {10, 10}, origin[2] = {950, 2090}; // its row 9 is at 2000, where column 20 is
    const Frame ground = over(20, 19, spacing, origin, utm());
    for (const bool with_crs : {true, false}) {
        const auto image = open_images({write_points(dir / "a.tif", 0, with_crs)}, ground);
        const ImageLayer& l = image->layers.at(0);
        const auto grey = [&](int x, int y) {
            const auto px = static_cast<std::int32_t>(std::floor(l.first_px[0] + x * l.per_sample[0]));
            const auto py = static_cast<std::int32_t>(std::floor(l.first_px[1] + y * l.per_sample[1]));
            return static_cast<int>(pixels(*image, {px, py, 1, 1})[0]);
        };
        for (int x = 1; x < 19; ++x) {
            CHECK(grey(x, 7) == 200);
            CHECK(grey(x, 11) == 50);
        }
        CHECK(image->accounts[0].find("placed by its 9 control points, off the worst by") != std::string::npos);
    }
    // Points that no polynomial goes through.
    const auto image = open_images({write_points(dir / "b.tif", 40, true)}, ground);
    CHECK(image->accounts[0].find("placed by its 9 control points, through each of them") != std::string::npos);
}

TEST_CASE("what has no coordinates is stretched and says so, with both extents; a sensor's model is refused") {
    const TempDir dir;
    const double spacing[2] = {10, 20}, origin[2] = {1000, 2000};
    Raster r = raster(40, 30, [](int x, int y) { return 5 * x + y; });
    r.type = GDT_Byte;
    r.geotransform.clear();
    const std::string plain_image = write(r, dir / "a.tif");
    CHECK(open_images({plain_image}, over(9, 3, spacing, origin, utm()))->accounts[0] ==
          plain_image +
              ": 8 bits; stretched over the terrain, because it has no coordinates: 40 x 30 pixels over 9 x 3 "
              "samples at x 1000..1080, y 1960..2000");
    r.more = [](GDALDataset& file) {
        CPLStringList rpc;
        for (const char* const key : {"LINE_OFF", "SAMP_OFF", "LAT_OFF", "LONG_OFF", "HEIGHT_OFF"})
            rpc.SetNameValue(key, "0");
        for (const char* const key : {"LINE_SCALE", "SAMP_SCALE", "LAT_SCALE", "LONG_SCALE", "HEIGHT_SCALE"})
            rpc.SetNameValue(key, "1");
        for (const char* const key : {"LINE_NUM_COEFF", "LINE_DEN_COEFF", "SAMP_NUM_COEFF", "SAMP_DEN_COEFF"})
            rpc.SetNameValue(key, "1 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0");
        file.SetMetadata(rpc.List(), "RPC");
    };
    const std::string sensor = write(r, dir / "rpc.tif");
    check_refusal(refusal([&] { (void)open_images({sensor}, over(9, 3, spacing, origin, utm())); }), 1, sensor,
                  {"RPC", "gdalwarp -rpc -to RPC_DEM=DEM"});
    r.more = {};
    r.geotransform = {900, 5, 0, 2100, 0, -5};
    const std::string placed_image = write(r, dir / "g.tif");
    CHECK(open_images({placed_image}, plain(9, 3))->accounts[0] ==
          placed_image + ": 8 bits; stretched over the terrain, because the terrain has no CRS: 40 x 30 pixels at x "
                         "900..1100, y 1950..2100 over 9 x 3 samples");
}

TEST_CASE("what is no image is refused with what to do") {
    const TempDir dir;
    const auto refused = [](const std::string& path) {
        return refusal([&] { (void)open_images({path}, plain(5, 5)); });
    };
    check_refusal(refused(dir / "missing.png"), 1, dir / "missing.png", {"no such file"});
    check_refusal(refused(dir / "."), 1, dir / ".", {"is a folder"});
    write_text(dir / "text.jpg", "no picture");
    check_refusal(refused(dir / "text.jpg"), 1, dir / "text.jpg", {"cannot be read as an image"});
    const std::string heights = write(raster(5, 5, hills), dir / "a.tif");
    check_refusal(refused(heights), 1, heights, {"Float32", "gdal_translate -ot Byte -scale 0 WHITE 0 255"});
}

TEST_CASE("an image that is cut short is refused while it is read") {
    const TempDir dir;
    Raster r = raster(300, 300, hills);
    r.type = GDT_Byte;
    r.geotransform.clear();
    const std::string path = write(r, dir / "a.png", "PNG");
    std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
    check_refusal(refusal([&] {
                      (void)pixels(*open_images({path}, plain(5, 5)), {0, 0, 300, 300});
                  }),
                  1, path, {"cut short"});
}

TEST_CASE("the ramps in content/ are ramps") {
    const std::string folder = std::string(FJELL_SOURCE_DIR) + "/content/ramps/";
    const Ramp alpine = read_ramp(folder + "alpine.json"), standard = default_ramp();
    CHECK(alpine.relative);
    CHECK(alpine.slopes.size() == 2);
    CHECK(standard.stops.size() == alpine.stops.size());
    CHECK(standard.slopes.back().stops.back().rgb[2] == alpine.slopes.back().stops.back().rgb[2]);
    CHECK(read_ramp(folder + "canyon.json").slopes.empty()); // what was a ramp before still is one
    const Ramp earth = read_ramp(folder + "earth.json");
    CHECK_FALSE(earth.relative);
    CHECK(earth.stops.front().height_m <= -10000);
    CHECK(earth.stops.back().height_m >= 8000);
    for (const char* coast : {"cascades.json", "sierra.json"}) { // blue at the sea's height, and not above
        const Ramp ramp = read_ramp(folder + coast);
        CHECK_FALSE(ramp.relative);
        CHECK(ramp.slopes.size() == 1);
        CHECK(ramp.stops.front().height_m == 0);
        CHECK(ramp.stops.front().rgb[2] > ramp.stops.front().rgb[0]);
    }
}

TEST_CASE("by default heights below 0 are water: blue down to the deepest, without meadows and snow, and land above") {
    const auto rgb = [](double least_m, double most_m, double height_m, float up = 1) {
        RampPainter painter(default_ramp(least_m, most_m));
        std::array<float, 3> c{};
        float out[3];
        painter.paint(static_cast<float>(height_m), up, out);
        std::copy_n(out, 3, c.begin());
        return c;
    };
    const auto blue = [](const std::array<float, 3>& c) { return c[2] > c[1] && c[1] > c[0]; };
    for (const float up : {1.0f, 0.85f, 0.7f, 0.5f}) { // level to steep
        for (const double most_m : {-10.0, 0.0, 0.2, 3000.0, 8848.0})
            for (const double least_m : {-50.0, -4000.0, -11000.0})
                for (const double part : {1.0, 0.6, 0.3, 0.1, 0.02}) {
                    const double height_m = std::min(most_m, 0.0) + part * (least_m - std::min(most_m, 0.0));
                    CAPTURE(up, most_m, least_m, height_m);
                    CHECK(blue(rgb(least_m, most_m, height_m, up)));
                    if (part < 1) // deeper is darker
                        CHECK(rgb(least_m, most_m, least_m, up)[1] < rgb(least_m, most_m, height_m, up)[1]);
                }
        // Land beside water has the colours of land from its shore to its summits.
        CHECK(rgb(-4000, 3000, 1500, up) == rgb(0, 3000, 1500, up));
        CHECK(rgb(-4000, 3000, 3000, up) == rgb(0, 3000, 3000, up));
        CHECK_FALSE(blue(rgb(-4000, 3000, 1, up)));
        // Noise below the sea's height is shallow water; a low island in a deep sea has no snow.
        CHECK(rgb(-2, 3000, -2, up)[1] > rgb(-4000, 3000, -2000, up)[1]);
        CHECK(rgb(-4000, 30, 30, up)[0] < 200);
        // Without heights below 0 nothing has changed.
        CHECK(rgb(100, 3000, 100, up) == rgb(0, 2900, 0, up));
    }
    const std::string folder = std::string(FJELL_SOURCE_DIR) + "/content/ramps/";
    const Ramp land = read_ramp(folder + "alpine.json"), sea = read_ramp(folder + "sea.json");
    REQUIRE(sea.slopes.size() == land.slopes.size()); // they are joined layer by layer
    for (std::size_t i = 0; i < sea.slopes.size(); ++i) {
        CHECK(sea.slopes[i].from_degrees == land.slopes[i].from_degrees);
        CHECK(sea.slopes[i].degrees == land.slopes[i].degrees);
    }
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
    check_refusal(refused("oops"), 1, path, {"is not JSON"});
    check_refusal(refused("{\"stops\": [" + a + "]}"), 1, path, {"at least two"});
    check_refusal(refused("{\"stops\": [" + a + ", {\"rgb\": [1, 1, 1],\n\"rgb\": [2, 2, 2]}]}"), 1, path + ":2",
                  {"\"rgb\" is there twice"});
    check_refusal(refused("{\"stops\": [" + b + ", " + a + "]}"), 1, path, {"stop 1", "rise"});
    check_refusal(refused("{\"stops\": [" + b + ", " + b + "]}"), 1, path, {"stop 1", "rise"});
    check_refusal(refused("{\"stops\": [" + a + ", {\"height_m\": 9, \"rgb\": [9, 9, 999]}]}"), 1, path,
                  {"stop 1", "0..255"});
    check_refusal(refused("{\"stops\": [" + a + ", {\"height_m\": 9, \"rgb\": [9, 9]}]}"), 1, path,
                  {"stop 1", "three numbers"});
    check_refusal(refused("{\"stops\": [" + a + ", {\"height\": 9, \"rgb\": [9, 9, 9]}]}"), 1, path,
                  {"stop 1", "height_m"});
    check_refusal(refused("{\"stopps\": []}"), 1, path, {"unknown field \"stopps\""});
    const auto sloped = [&](const std::string& slopes) {
        return refused("{\"stops\": [" + a + ", " + b + "], \"slopes\": " + slopes + "}");
    };
    const std::string rock = R"("rgb": [1, 2, 3])";
    CHECK(sloped(R"([{"from_degrees": 20, "degrees": 30, )" + rock + "}]").code == 0);
    CHECK(sloped(R"([{"from_degrees": 20, "degrees": 30, "stops": [)" + a + ", " + b + "]}]").code == 0);
    check_refusal(sloped("{}"), 1, path, {"\"slopes\" must be a list"});
    check_refusal(sloped(R"([{"degrees": 30, )" + rock + "}]"), 1, path, {"slope 0", "from_degrees"});
    check_refusal(sloped(R"([{"from_degrees": 20, "degrees": 30}])"), 1, path, {"slope 0", "\"rgb\"", "\"stops\""});
    check_refusal(sloped(R"([{"from_degrees": 20, "degrees": 95, )" + rock + "}]"), 1, path, {"slope 0", "0..90"});
    check_refusal(sloped(R"([{"from_degrees": 30, "degrees": 30, )" + rock + "}]"), 1, path, {"slope 0", "above"});
    check_refusal(sloped(R"([{"from_degrees": 20, "degrees": 30, "rgb": [1, 2]}])"), 1, path,
                  {"slope 0", "three numbers"});
    check_refusal(sloped(R"([{"from_degrees": 20, "degrees": 30, "stops": [)" + b + ", " + a + "]}]"), 1, path,
                  {"slope 0, stop 1", "rise"});
    check_refusal(sloped(R"([{"from_degrees": 20, "degrees": 30, )" + rock +
                         R"(}, {"from_degrees": 29, "degrees": 40, )" + rock + "}]"),
                  1, path, {"slope 1", "ends"});
    check_refusal(refusal([&] { (void)read_ramp(dir / "none.json"); }), 1, dir / "none.json", {"No such file"});
}
