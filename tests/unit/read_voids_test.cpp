#include <algorithm>
#include <cmath>
#include <limits>

#include "read_support.h"

using namespace fjell::baker;
using namespace fjell::test;

TEST_CASE("what the file marks as no-data becomes a hole, at its place") {
    const TempDir dir;
    Raster r = slope_with(-9999);
    SECTION("a tag, in every format that has one") {
        tag(r, -9999);
        check_holes(read_dem(write(r, dir / "a.tif"), {}));
        check_holes(read_dem(write(r, dir / "a.asc", "AAIGrid"), {}));
        r.crs = "EPSG:32632";
        check_holes(read_dem(write(r, dir / "a.nc", "netCDF"), {}));
        r.type = GDT_Int16;
        check_holes(read_dem(write(r, dir / "b.tif"), {}));
        Raster odd_step = slope_with(-9999.25); // the marker says nothing about the step of the heights
        tag(odd_step, -9999.25);
        check_holes(read_dem(write(odd_step, dir / "c.tif"), {}));
    }
    SECTION("a mask, and a tag beside it") {
        const auto masked = [](GDALDataset& file, const auto& valid) {
            REQUIRE(file.GetRasterBand(1)->CreateMaskBand(GMF_PER_DATASET) == CE_None);
            std::vector<std::uint8_t> mask;
            for (int y = 0; y < 31; ++y)
                for (int x = 0; x < 41; ++x) mask.push_back(valid(x, y) ? 255 : 0);
            REQUIRE(file.GetRasterBand(1)->GetMaskBand()->RasterIO(GF_Write, 0, 0, 41, 31, mask.data(), 41, 31,
                                                                   GDT_Byte, 0, 0, nullptr) == CE_None);
        };
        r.more = [&](GDALDataset& file) { masked(file, [](int x, int y) { return !in_hole(x, y); }); };
        check_holes(read_dem(write(r, dir / "mask.tif"), {}));
        r.more = [&](GDALDataset& file) {
            file.GetRasterBand(1)->SetNoDataValue(-9999);
            masked(file, [](int x, int y) { return x < 30 || !in_hole(x, y); });
        };
        check_holes(read_dem(write(r, dir / "both.tif"), {}));
    }
    SECTION("whichever way the file runs") {
        for (const bool flip_x : {false, true})
            for (const bool flip_y : {false, true}) {
                INFO("flip_x " << flip_x << ", flip_y " << flip_y);
                Raster flipped = raster(41, 31, [&](int x, int y) {
                    return r.values[static_cast<std::size_t>((flip_y ? 30 - y : y) * 41 + (flip_x ? 40 - x : x))];
                });
                tag(flipped, -9999);
                flipped.geotransform = {1000, flip_x ? -10.0 : 10.0, 0, 2000, 0, flip_y ? 10.0 : -10.0};
                check_holes(read_dem(write(flipped, dir / "a.tif"), {}));
            }
    }
}

TEST_CASE("NaN becomes a hole, infinite heights are refused, naming the first") {
    const TempDir dir;
    check_holes(read_dem(write(slope_with(std::numeric_limits<double>::quiet_NaN()), dir / "nan.tif"), {}));
    for (const double bad : {HUGE_VAL, -HUGE_VAL}) {
        const std::string path = write(slope_with(bad), dir / "a.tif");
        check_refusal(refused(path), 1, path, remedies);
        check_refusal(refused(path), 1, path, {holes_of_all() + " heights lie outside", "inf m at column 6, row 0"});
        check_holes(read_dem(path, with(NoData::hole)));
        for (const float h : read_dem(path, filling()).heights_m) CHECK(std::isfinite(h));
    }
}

TEST_CASE("voids are filled when asked, smoothly and on the source's own step") {
    const TempDir dir;
    const auto hole = [](int x, int y) { return std::hypot(x - 20, y - 20) < 8; };
    // Steps of a metre, from zero or from where the file's offset puts them.
    const double offset_m = GENERATE(0.0, 0.25);
    CAPTURE(offset_m);
    Raster r = raster(41, 41, [&](int x, int y) { return hole(x, y) ? -9999 : slope(x, y); });
    r.more = [&](GDALDataset& file) {
        file.GetRasterBand(1)->SetNoDataValue(-9999);
        file.GetRasterBand(1)->SetOffset(offset_m);
    };
    const std::string path = write(r, dir / "a.tif");
    const Dem dem = read_dem(path, filling());
    CHECK(dem.native_quantum_m == 1);
    CHECK(dem.voids.empty());
    double worst = 0;
    for (int y = 0; y < 41; ++y)
        for (int x = 0; x < 41; ++x) {
            const double steps = dem.at(x, y) - offset_m;
            CHECK(steps == std::round(steps));
            if (hole(x, y))
                worst = std::max(worst, std::abs(steps - slope(x, y)));
            else
                CHECK(steps == slope(x, y));
        }
    // A membrane over a plane is that plane. Means of coarser squares alone leave 6 m at 3 and 7 m a sample; settling
    // them at least halves that.
    CHECK(worst <= 3);
    CHECK(read_dem(path, filling()).heights_m == dem.heights_m);
    CHECK(read_dem(path, {}).heights_m == dem.heights_m); // under a hole lies what would have filled it
}

TEST_CASE("voids are refused when asked, naming the first and both options") {
    const TempDir dir;
    const ReadOptions strict = with(NoData::refuse);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const double nothing : {-9999.0, nan}) {
        Raster r = raster(9, 9, [&](int x, int y) { return (x == 4 && y == 5) || y == 7 ? nothing : slope(x, y); });
        tag(r, -9999);
        const std::string path = write(r, dir / "a.tif");
        check_refusal(refused(path, strict), 1, path, remedies);
        check_refusal(refused(path, strict), 1, path, {"10 of 81 samples are no-data or NaN", "column 4, row 5"});
    }
}

TEST_CASE("the first void is named by its column in the terrain, however far along a row of the file it lies") {
    const TempDir dir;
    constexpr int columns = 1500;
    for (const bool flip_x : {false, true})
        for (const int column : {3, 511, 512, 700, 1499}) {
            CAPTURE(flip_x, column);
            const int in_file = flip_x ? columns - 1 - column : column;
            Raster r = raster(columns, 3, [&](int x, int y) { return x == in_file && y == 1 ? -9999 : slope(0, y); });
            tag(r, -9999);
            if (flip_x) r.geotransform = {1000, -10, 0, 2000, 0, -10};
            const std::string path = write(r, dir / "a.tif");
            check_refusal(refused(path, with(NoData::refuse)), 1, path,
                          {"1 of 4500 samples", "column " + std::to_string(column) + ", row 1;"});
        }
}

TEST_CASE("undeclared voids are refused until the user says what they are") {
    const TempDir dir;
    Raster r = slope_with(-32767);
    r.type = GDT_Int16;
    const std::string path = write(r, dir / "a.tif");
    for (const NoData nodata : {NoData::automatic, NoData::refuse}) {
        const Refusal answer = refused(path, with(nodata));
        check_refusal(answer, 1, path, remedies);
        check_refusal(answer, 1, path,
                      {holes_of_all() + " heights lie outside", "-32767 m at column 6, row 0", "--zscale"});
    }
    check_holes(read_dem(path, with(NoData::hole)));
    const Dem filled = read_dem(path, filling());
    CHECK(filled.voids.empty());
    for (const float h : filled.heights_m) CHECK(h >= 100);
}

TEST_CASE("odd heights beside declared voids are refused, and are holes like them when asked") {
    const TempDir dir;
    Raster r = slope_with(-9999);
    tag(r, -9999);
    for (std::size_t i = 0; i < r.values.size(); ++i)
        if (r.values[i] == -9999 && i % 41 == 30) r.values[i] = 1e38;
    const std::string path = write(r, dir / "a.tif");
    check_refusal(refused(path), 1, path, {"4 of 1271 heights lie outside", "column 30, row 21"});
    check_holes(read_dem(path, with(NoData::hole)));
}

TEST_CASE("a file without voids has no holes, whatever is asked") {
    const TempDir dir;
    Raster r = raster(20, 15, slope);
    tag(r, -9999);
    const std::string path = write(r, dir / "a.tif");
    for (const NoData nodata : every_nodata) {
        const Dem dem = read_dem(path, with(nodata));
        check_slope(dem, 20, 15);
        CHECK(dem.voids.empty());
        CHECK(void_count(dem) == 0);
        CHECK(!dem.is_void(3, 4));
    }
}

TEST_CASE("heights are odd only when they are so both before and after --zscale") {
    const TempDir dir;
    Raster r = raster(9, 9, [](int x, int y) { return 40000 + 10 * x + y; });
    r.type = GDT_UInt16;
    ReadOptions tenth, tenfold;
    tenth.zscale = 0.1;
    tenfold.zscale = 10;
    CHECK(read_dem(write(r, dir / "counts.tif"), tenth).at(8, 8) == static_cast<float>(40088 * 0.1));
    const std::string plain = write(raster(9, 9, [](int x, int y) { return 5000 + 10 * x + y; }), dir / "plain.tif");
    CHECK(read_dem(plain, tenfold).at(8, 8) == 50880);
    tenfold.zscale = 1e6;
    check_refusal(refused(plain, tenfold), 2, plain, {"--zscale"});
}

TEST_CASE("nothing but no-data is refused whatever is asked") {
    const TempDir dir;
    Raster r = raster(9, 9, [](int, int) { return -32768; });
    r.type = GDT_Int16;
    for (const bool tagged : {true, false}) {
        if (tagged)
            tag(r, -32768);
        else
            r.more = {};
        const std::string path = write(r, dir / "a.tif");
        for (const NoData nodata : every_nodata)
            check_refusal(refused(path, with(nodata)), 1, path, {"all 81 samples are no-data"});
    }
}
