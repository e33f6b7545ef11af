#include <algorithm>
#include <cmath>
#include <limits>

#include "baker/read.h"
#include "raster.h"

using namespace fjell::baker;
using namespace fjell::test;

namespace {

ReadOptions spaced(double spacing_m) {
    ReadOptions o;
    o.spacing_m = spacing_m;
    return o;
}
ReadOptions with(NoData nodata) {
    ReadOptions o;
    o.nodata = nodata;
    return o;
}
ReadOptions filling() {
    return with(NoData::fill);
}
constexpr NoData every_nodata[] = {NoData::automatic, NoData::hole, NoData::fill, NoData::refuse};
// What a refusal of heights that may be voids has to offer.
const std::vector<std::string> remedies{"--nodata hole to leave them open", "--nodata fill to fill them"};
Refusal refused(const std::string& path, const ReadOptions& options = {}) {
    return refusal([&] { (void)read_dem(path, options); });
}
double slope(int x, int y) {
    return 100 + 3 * x + 7 * y;
}
// Touches a border and is no mirror image of itself, so that a flip cannot hide.
bool in_hole(int x, int y) {
    return std::hypot(x - 10, y - 4) < 6 || (x == 30 && y > 20 && y < 25);
}
Raster slope_with(double nothing) {
    return raster(41, 31, [=](int x, int y) { return in_hole(x, y) ? nothing : slope(x, y); });
}
// "N of 1271": what a refusal counts.
std::string holes_of_all() {
    const Raster r = slope_with(-9999);
    const auto holes = std::count(r.values.begin(), r.values.end(), -9999);
    return std::to_string(holes) + " of " + std::to_string(r.values.size());
}
void tag(Raster& r, double nothing) {
    r.more = [=](GDALDataset& file) { file.GetRasterBand(1)->SetNoDataValue(nothing); };
}

void check_slope(const Dem& dem, int columns, int rows) {
    REQUIRE(dem.columns == columns);
    REQUIRE(dem.rows == rows);
    int wrong = 0;
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns; ++x) wrong += dem.at(x, y) != static_cast<float>(slope(x, y));
    CHECK(wrong == 0);
}

// Holes where in_hole says and nowhere else, the slope around them, and ground of the same kind under them.
void check_holes(const Dem& dem) {
    REQUIRE(dem.columns == 41);
    REQUIRE(dem.rows == 31);
    REQUIRE(dem.voids.size() == dem.heights_m.size());
    std::uint64_t holes = 0;
    int misplaced = 0, wrong = 0;
    for (int y = 0; y < 31; ++y)
        for (int x = 0; x < 41; ++x) {
            const float height = dem.at(x, y);
            holes += in_hole(x, y);
            misplaced += dem.is_void(x, y) != in_hole(x, y);
            if (in_hole(x, y)) // means of neighbours lie between the lowest and the highest, on the source's step
                wrong += !(height >= slope(0, 0) && height <= slope(40, 30)) || height != std::round(height);
            else
                wrong += height != static_cast<float>(slope(x, y));
        }
    CHECK(misplaced == 0);
    CHECK(wrong == 0);
    CHECK(void_count(dem) == holes);
    CHECK(dem.native_quantum_m == 1);
}

} // namespace

TEST_CASE("the same heights read alike from every format") {
    const TempDir dir;
    Raster r = raster(20, 15, slope);
    SECTION("GeoTIFF, every number type") {
        for (const GDALDataType type :
             {GDT_Byte, GDT_UInt16, GDT_Int16, GDT_UInt32, GDT_Int32, GDT_Float32, GDT_Float64}) {
            r.type = type;
            check_slope(read_dem(write(r, dir / "a.tif"), {}), 20, 15);
        }
    }
    SECTION("PNG of 8 and 16 bits, and BMP") {
        r.geotransform.clear();
        r.type = GDT_Byte;
        check_slope(read_dem(write(r, dir / "a.png", "PNG"), spaced(60)), 20, 15);
        check_slope(read_dem(write(r, dir / "a.bmp", "BMP"), spaced(60)), 20, 15);
        r.type = GDT_UInt16;
        check_slope(read_dem(write(r, dir / "b.png", "PNG"), spaced(60)), 20, 15);
    }
    SECTION("ASCII grid") {
        check_slope(read_dem(write(r, dir / "a.asc", "AAIGrid"), {}), 20, 15);
    }
    SECTION("netCDF, which stores the southern row first") {
        r.crs = "EPSG:32632";
        const Dem dem = read_dem(write(r, dir / "a.nc", "netCDF"), {});
        check_slope(dem, 20, 15);
        CHECK(dem.spacing_m[0] == Approx(10));
        CHECK(dem.origin_m[1] == Approx(2000));
    }
    SECTION("USGS DEM") {
        r = raster(20, 15, slope);
        r.type = GDT_Int16;
        r.crs = "EPSG:26710";
        r.geotransform = {500000 - 15, 30, 0, 5100000 + 15, 0, -30};
        const Dem dem = read_dem(write(r, dir / "a.dem", "USGSDEM"), {});
        CHECK(dem.spacing_m[0] == 30);
        check_slope(dem, 20, 15);
    }
    SECTION("HGT") {
        constexpr int side = 1201;
        std::string bytes;
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) {
                const int h = static_cast<int>(slope(x, y));
                bytes += static_cast<char>(h >> 8);
                bytes += static_cast<char>(h & 0xff);
            }
        write_text(dir / "N10E020.hgt", bytes);
        check_slope(read_dem(dir / "N10E020.hgt", spaced(90)), side, side);
        write_text(dir / "other.hgt", bytes);
        check_refusal(refused(dir / "other.hgt", spaced(90)), 1, dir / "other.hgt", {"must be named like"});
    }
}

TEST_CASE("raster pixels are samples, and place and spacing are kept") {
    const TempDir dir;
    Raster r = raster(20, 15, slope);
    r.geotransform = metres(10, 20);
    r.crs = "EPSG:32632";
    const Dem dem = read_dem(write(r, dir / "a.tif"), {});
    CHECK(dem.spacing_m[0] == 10);
    CHECK(dem.spacing_m[1] == 20);
    CHECK(dem.origin_m[0] == 1000);
    CHECK(dem.origin_m[1] == 2000);
    CHECK(dem.crs_wkt.find("32632") != std::string::npos);
    const Dem wider = read_dem(dir / "a.tif", spaced(12));
    CHECK(wider.spacing_m[0] == 12);
    CHECK(wider.spacing_m[1] == 12);
}

TEST_CASE("row 0 is north and column 0 is west, whichever way the file runs") {
    const TempDir dir;
    Raster r = raster(20, 15, [](int x, int y) { return slope(19 - x, 14 - y); });
    r.geotransform = {1000 + 195, -10, 0, 2000 - 145, 0, 10};
    const Dem dem = read_dem(write(r, dir / "a.tif"), {});
    check_slope(dem, 20, 15);
    CHECK(dem.origin_m[0] == 1000);
    CHECK(dem.origin_m[1] == 2000);
}

TEST_CASE("scale, offset and unit of the band, then --zscale and offset, make the height") {
    const TempDir dir;
    Raster r = raster(4, 3, [](int x, int y) { return 100 * x + y; });
    r.type = GDT_Int16;
    const auto read = [&](double scale, double offset, const char* unit, const ReadOptions& o) {
        r.more = [=](GDALDataset& file) {
            file.GetRasterBand(1)->SetScale(scale);
            file.GetRasterBand(1)->SetOffset(offset);
            file.GetRasterBand(1)->SetUnitType(unit);
        };
        return read_dem(write(r, dir / "a.tif"), o);
    };
    const Dem scaled = read(0.5, 20, "metre", {});
    CHECK(scaled.at(3, 2) == 302 * 0.5f + 20);
    CHECK(scaled.native_quantum_m == 0.5);
    const Dem feet = read(1, 0, "feet", {});
    CHECK(feet.at(3, 2) == static_cast<float>(302 * 0.3048));
    CHECK(feet.native_quantum_m == Approx(0.3048));
    CHECK(read(1, 0, "US survey foot", {}).at(3, 2) == static_cast<float>(302 * (1200.0 / 3937)));
    check_refusal(refusal([&] { (void)read(1, 0, "fathom", {}); }), 1, dir / "a.tif", {"fathom", "--zscale"});
    ReadOptions fathoms;
    fathoms.zscale = 1.8288;
    CHECK(read(1, 0, "fathom", fathoms).at(3, 2) == static_cast<float>(302 * 1.8288));
    ReadOptions asked;
    asked.zscale = -2;
    asked.zoffset_m = 5;
    const Dem both = read(1, 10, "", asked);
    CHECK(both.at(3, 2) == -(302 + 10) * 2 + 5);
    CHECK(both.native_quantum_m == 2);
    check_refusal(refusal([&] { (void)read(0, 0, "", {}); }), 1, dir / "a.tif", {"scale"});
}

TEST_CASE("a CRS in feet gives a spacing in metres") {
    const TempDir dir;
    Raster r = raster(4, 3, slope);
    r.crs = "EPSG:2263"; // New York, US survey feet
    CHECK(read_dem(write(r, dir / "a.tif"), {}).spacing_m[0] == Approx(10 * 1200.0 / 3937).epsilon(1e-12));
}

TEST_CASE("the step that heights are multiples of is found") {
    const TempDir dir;
    const auto quantum = [&](double unit) {
        const Raster r = raster(30, 30, [=](int x, int y) { return (1000 + 37 * x + 11 * y) * unit; });
        return read_dem(write(r, dir / "a.tif"), {}).native_quantum_m;
    };
    CHECK(quantum(1) == 1);
    CHECK(quantum(0.1) == 0.1);
    CHECK(quantum(0.01) == 0.01);
    CHECK(quantum(0.003) == 0);
}

TEST_CASE("degrees are refused until a spacing settles them") {
    const TempDir dir;
    Raster r = raster(20, 15, slope);
    r.geotransform = {8, 0.01, 0, 61, 0, -0.01};
    for (const char* crs : {"", "EPSG:4326"}) {
        r.crs = crs;
        const std::string path = write(r, dir / "a.tif");
        check_refusal(refused(path), 1, path, {"is in degrees; give --spacing M (metres between samples)"});
        CHECK(read_dem(path, spaced(90)).spacing_m[1] == 90);
    }
    const std::string grid = write(r, dir / "a.asc", "AAIGrid");
    check_refusal(refused(grid), 1, grid, {"is in degrees"});
}

TEST_CASE("a picture without a georeference wants a spacing") {
    const TempDir dir;
    Raster r = raster(20, 15, slope);
    r.geotransform.clear();
    r.type = GDT_Byte;
    for (const char* format : {"PNG", "BMP"}) {
        const std::string path = write(r, dir / "a", format);
        check_refusal(refused(path), 1, path, {"has no georeference; give --spacing M"});
    }
}

TEST_CASE("a rotated grid is refused") {
    const TempDir dir;
    Raster r = raster(20, 15, slope);
    r.geotransform = {0, 10, 3, 0, 3, -10};
    const std::string path = write(r, dir / "a.tif");
    check_refusal(refused(path, spaced(10)), 1, path, {"rotated", "gdalwarp"});
}

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
    Raster r = raster(41, 41, [&](int x, int y) { return hole(x, y) ? -9999 : slope(x, y); });
    tag(r, -9999);
    const std::string path = write(r, dir / "a.tif");
    const Dem dem = read_dem(path, filling());
    CHECK(dem.native_quantum_m == 1);
    CHECK(dem.voids.empty());
    double worst = 0;
    for (int y = 0; y < 41; ++y)
        for (int x = 0; x < 41; ++x) {
            CHECK(dem.at(x, y) == std::round(dem.at(x, y)));
            if (hole(x, y))
                worst = std::max(worst, std::abs(dem.at(x, y) - slope(x, y)));
            else
                CHECK(dem.at(x, y) == slope(x, y));
        }
    // A membrane over a plane is that plane. Means of coarser squares alone leave 6 m at 3 and 7 m a sample; settling
    // them at least halves that.
    CHECK(worst <= 3);
    CHECK(read_dem(path, filling()).heights_m == dem.heights_m);
    CHECK(read_dem(path, {}).heights_m == dem.heights_m); // under a hole lies what would have filled it
}

TEST_CASE("voids are refused when asked, naming the first and both ways to settle them") {
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

TEST_CASE("what is no raster file is refused with what to do") {
    const TempDir dir;
    check_refusal(refused(dir / "missing.tif"), 1, dir / "missing.tif", {"no such file", "check the path"});
    check_refusal(refused(dir / "."), 1, dir / ".", {"is a folder"});
    check_refusal(refused("/dev/null"), 1, "/dev/null", {"not a regular file"});
    write_text(dir / "text.tif", "these are\nno heights\n");
    check_refusal(refused(dir / "text.tif"), 1, dir / "text.tif", {"cannot be read", "give a GeoTIFF"});
    write_text(dir / "empty.png", "");
    check_refusal(refused(dir / "empty.png"), 1, dir / "empty.png", {"cannot be read"});
    check_refusal(refused(""), 1, "", {"no such file"});
}

TEST_CASE("files cut at any place are refused or read right, never half") {
    const TempDir dir;
    Raster r = raster(64, 64, [](int x, int y) { return 500 + (x * 7919 + y * 104729) % 251; });
    r.crs = "EPSG:32632";
    const Dem whole = read_dem(write(r, dir / "whole.tif"), {});
    struct Kind {
        const char* name;
        const char* format;
        GDALDataType type;
    };
    for (const Kind& kind :
         {Kind{"a.tif", "GTiff", GDT_Float32}, Kind{"a.png", "PNG", GDT_UInt16}, Kind{"b.nc", "netCDF", GDT_Float32}}) {
        r.type = kind.type;
        const std::string path = write(r, dir / kind.name, kind.format);
        std::ifstream in(path, std::ios::binary);
        const std::string bytes{std::istreambuf_iterator<char>(in), {}};
        for (std::size_t length = 0; length < bytes.size(); length += 1 + bytes.size() / 97) {
            write_text(path, bytes.substr(0, length));
            std::filesystem::remove(path + ".aux.xml");
            Dem cut;
            const Refusal answer = refusal([&] { cut = read_dem(path, spaced(10)); });
            INFO(kind.name << " cut to " << length << " of " << bytes.size() << ": " << answer.line);
            CHECK((answer.code == 1 || (answer.code == 0 && cut.heights_m == whole.heights_m)));
            CHECK(answer.line.find('\n') == std::string::npos);
        }
    }
}

TEST_CASE("rasters too small or too large are refused") {
    const TempDir dir;
    for (const auto& [columns, rows] : {std::pair{1, 1}, {1, 5}, {5, 1}}) {
        const std::string path = write(raster(columns, rows, slope), dir / "a.tif");
        check_refusal(refused(path), 1, path, {"at least 2 x 2"});
    }
    check_slope(read_dem(write(raster(2, 2, slope), dir / "b.tif"), {}), 2, 2);
    ReadOptions little;
    little.memory_bytes = 20 * 20 * 28 - 1;
    const std::string path = write(raster(20, 20, slope), dir / "c.tif");
    check_refusal(refused(path, little), 3, path, {"20 x 20 samples", "--memory"});
    ++little.memory_bytes;
    check_slope(read_dem(path, little), 20, 20);
}

TEST_CASE("absurd options and spacings are refused") {
    const TempDir dir;
    Raster r = raster(4, 4, slope);
    const std::string path = write(r, dir / "a.tif");
    for (const double spacing : {0.0, -60.0, 1e-9, 1e9, std::numeric_limits<double>::quiet_NaN(), HUGE_VAL})
        CHECK(refused(path, spaced(spacing)).code == 2);
    for (const double scale : {0.0, 1e-9, 1e9, std::numeric_limits<double>::quiet_NaN(), HUGE_VAL}) {
        ReadOptions o;
        o.zscale = scale;
        CHECK(refused(path, o).code == 2);
        CHECK(refused(path, o).says("--zscale"));
    }
    ReadOptions o;
    o.zoffset_m = 1e9;
    CHECK(refused(path, o).code == 2);
    r.geotransform = {1e7, 1e7, 0, 1e7, 0, -1e7};
    check_refusal(refused(write(r, dir / "b.tif")), 1, dir / "b.tif", {"--spacing"});
}

TEST_CASE("an image is not taken for heights") {
    const TempDir dir;
    Raster r = raster(8, 8, slope);
    r.type = GDT_Byte;
    r.bands = 3;
    r.geotransform.clear();
    const std::string path = write(r, dir / "a.png", "PNG");
    check_refusal(refused(path, spaced(60)), 1, path, {"3 bands", "Terrarium", "first"});
    r.bands = 1;
    r.more = [](GDALDataset& file) {
        GDALColorTable table;
        for (int i = 0; i < 256; ++i) {
            const GDALColorEntry entry{static_cast<short>(255 - i), 10, 10, 255};
            table.SetColorEntry(i, &entry);
        }
        file.GetRasterBand(1)->SetColorTable(&table);
    };
    const std::string palette = write(r, dir / "b.png", "PNG");
    check_refusal(refused(palette, spaced(60)), 1, palette, {"palette"});
}

TEST_CASE("a DEM that is written comes back bit for bit") {
    const TempDir dir;
    Dem dem;
    dem.columns = 33;
    dem.rows = 17;
    dem.spacing_m[0] = 1.5;
    dem.spacing_m[1] = 2;
    for (int i = 0; i < 33 * 17; ++i) dem.heights_m.push_back(static_cast<float>((i * 7919 % 60000 - 500) * 0.1));
    const std::string path = dir / "a.tif";
    for (const double quantum : {0.1, 0.0}) {
        dem.native_quantum_m = quantum;
        write_dem(dem, path);
        const Dem back = read_dem(path, {});
        CHECK(back.heights_m == dem.heights_m);
        CHECK(back.spacing_m[0] == 1.5);
        CHECK(back.spacing_m[1] == 2);
        CHECK(back.origin_m[0] == 0);
        CHECK(back.native_quantum_m == 0.1);
        CHECK(back.crs_wkt.empty());
    }
    const Refusal lost = refusal([&] { write_dem(dem, dir / "missing/a.tif"); });
    check_refusal(lost, 1, dir / "missing", {});
}

TEST_CASE("real files of every format read as GDAL reads them") {
    const auto raw = [](const std::string& path, int x, int y) {
        const GdalMessages quiet;
        const GdalFile file(GDALDataset::Open(path.c_str(), GDAL_OF_RASTER));
        double value = 0;
        REQUIRE(file->GetRasterBand(1)->RasterIO(GF_Read, x, y, 1, 1, &value, 1, 1, GDT_Float64, 0, 0, nullptr) ==
                CE_None);
        return value;
    };
    for (const char* name :
         {"formats/N37W003.hgt", "formats/grand_canyon_copdem_512_f32.tif",
          "formats/luxembourg_terra_elev_i16_nodata.tif", "formats/luxembourg_elev_i16_nodata.asc",
          "formats/grand_canyon_crop_513_u8.bmp", "dem/grand_canyon_60m_4097x2049_u8.png",
          "dem/spain_sierra_nevada_srtm3_3601x2401_i16.tif", "dem/norway_jotunheimen_117m_512_f32.tif",
          "dem/SainteHelens_usgs.dem", "dem/craterlake_elev_i16_30m.tif"}) {
        const std::string path = data_file(name);
        if (path.empty()) continue;
        INFO(path);
        ReadOptions options = filling();
        options.spacing_m = 60;
        const Dem dem = read_dem(path, options);
        for (int k = 0; k < 50; ++k) {
            const int x = k * 7919 % dem.columns, y = k * 104729 % dem.rows;
            const double value = raw(path, x, y);
            if (value > -1000)
                CHECK(dem.at(x, y) == static_cast<float>(value));
            else
                CHECK(dem.at(x, y) > -1000); // filled
        }
    }
}

TEST_CASE("real files have holes exactly where GDAL reads their void value") {
    struct Holed {
        const char* name;
        NoData nodata;
        double nothing;
        double least, most; // share of holes
    };
    for (const Holed& holed :
         {Holed{"formats/luxembourg_terra_elev_i16_nodata.tif", NoData::automatic, -32768, 0.4, 0.5},
          {"formats/luxembourg_elev_i16_nodata.asc", NoData::automatic, -32768, 0.4, 0.5},
          {"dem/SainteHelens_usgs.dem", NoData::automatic, -32767, 0, 0.1},
          {"dem/craterlake_elev_i16_30m.tif", NoData::hole, -32767, 0.3, 0.4}}) {
        const std::string path = data_file(holed.name);
        if (path.empty()) continue;
        INFO(path);
        ReadOptions options = with(holed.nodata);
        options.spacing_m = 60;
        const Dem dem = read_dem(path, options);
        const GdalMessages quiet;
        const GdalFile file(GDALDataset::Open(path.c_str(), GDAL_OF_RASTER));
        std::vector<double> raw(dem.heights_m.size());
        REQUIRE(file->GetRasterBand(1)->RasterIO(GF_Read, 0, 0, dem.columns, dem.rows, raw.data(), dem.columns,
                                                 dem.rows, GDT_Float64, 0, 0, nullptr) == CE_None);
        int misplaced = 0, wrong = 0;
        for (int y = 0; y < dem.rows; ++y)
            for (int x = 0; x < dem.columns; ++x) {
                const double value = raw[dem.index(x, y)];
                misplaced += dem.is_void(x, y) != (value == holed.nothing);
                wrong += value != holed.nothing ? dem.at(x, y) != static_cast<float>(value) : dem.at(x, y) < 0;
            }
        CHECK(misplaced == 0);
        CHECK(wrong == 0);
        const double share = static_cast<double>(void_count(dem)) / static_cast<double>(raw.size());
        CHECK(share > holed.least);
        CHECK(share < holed.most);
    }
}

TEST_CASE("real files with traps in them are refused with the option that settles them") {
    struct Trap {
        const char* name;
        bool spacing;
        std::vector<std::string> words;
    };
    for (const Trap& trap : {Trap{"formats/N37W003.hgt", false, {"degrees"}},
                             {"formats/luxembourg_elev_i16_nodata.asc", false, {"degrees"}},
                             {"formats/terrarium_256.png", true, {"Terrarium"}},
                             {"formats/grand_canyon_crop_513_u8.bmp", false, {"--spacing"}},
                             {"dem/craterlake_elev_i16_30m.tif", true, {"-32767 m", "--nodata hole", "--nodata fill"}},
                             {"dem/puget_sound_160m_1025_u16.png", true, {"--zscale"}}}) {
        const std::string path = data_file(trap.name);
        if (path.empty()) continue;
        check_refusal(refused(path, trap.spacing ? spaced(60) : ReadOptions{}), 1, path, trap.words);
    }
}
