// Height fields in degrees become metres, and the same ones whatever is read.
#include <cmath>
#include <thread>

#include "baker/georeference/projection.h"
#include "baker/georeference/warp.h"
#include "source_check.h"

using namespace fjell::baker;
using namespace fjell::test;

namespace {

// Heights over longitude and latitude: eastings of UTM zone 32, so that a reprojected field is a plane.
struct Eastings {
    std::unique_ptr<OGRCoordinateTransformation> to_utm;
    Eastings() {
        register_drivers();
        OGRSpatialReference degrees, utm;
        degrees.importFromEPSG(4326);
        degrees.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
        utm.importFromEPSG(32632);
        to_utm.reset(OGRCreateCoordinateTransformation(&degrees, &utm));
    }
    double at(double longitude, double latitude) const {
        REQUIRE(to_utm->Transform(1, &longitude, &latitude));
        return longitude / 100 + latitude / 1000;
    }
};

// 0.86 x 0.4 degrees at (8.2 E, 61 N), 3 seconds apart.
Raster degrees(const std::function<double(double, double)>& height) {
    constexpr double step = 0.6 / 700;
    Raster r = raster(1000, 470, [=](int x, int y) { return height(8.2 + step * x, 61 - step * y); });
    r.geotransform = {8.2 - step / 2, step, 0, 61 + step / 2, 0, -step};
    r.crs = "EPSG:4326";
    return r;
}
std::string crs_of(double west, double south, double east, double north, int geographic = 4326) {
    OGRSpatialReference crs;
    crs.importFromEPSG(geographic);
    const auto chosen = crs_for(crs, west, south, east, north);
    if (!chosen) return "none";
    const char* code = chosen->GetAuthorityCode(nullptr);
    return code ? code : chosen->GetAttrValue("PROJECTION");
}
double rough(double longitude, double latitude) {
    return 1000 + 300 * std::sin(longitude * 300) * std::cos(latitude * 500);
}

} // namespace

TEST_CASE("a projection is chosen that suits a place and its extents") {
    CHECK(crs_of(8, 46, 10, 48) == "32632");
    CHECK(crs_of(-3, 36, -2, 37) == "32630");
    CHECK(crs_of(150, -35, 152, -33) == "32756");
    CHECK(crs_of(357, 36, 358, 37) == "32630"); // longitudes from 0 to 360
    CHECK(crs_of(179, 0, 181, 2) == "32601");
    CHECK(crs_of(8, 46, 10, 48, 4258) == "25832");
    CHECK(crs_of(-123, 42, -122, 43, 4269) == "26910");
    CHECK(crs_of(8, 46, 10, 48, 4326) == "32632");
    CHECK(crs_of(8, 46, 9, 47, 4313) == "Transverse_Mercator"); // keeps a datum of its own
    CHECK(crs_of(-10, 36, 30, 70) == "Lambert_Azimuthal_Equal_Area");
    CHECK(crs_of(10, 79, 20, 86) == "Polar_Stereographic");
    CHECK(crs_of(-180, -90, 180, -60) == "3031");
    CHECK(crs_of(0, 75, 360, 90) == "3995");
    CHECK(crs_of(0, 75, 360, 90, 4258) == "Polar_Stereographic");
    CHECK(crs_of(-180, 50, 180, 90) == "none");
    CHECK(crs_of(-180, -90, 180, 90) == "none");
    CHECK(crs_of(0, 0, 120, 20) == "none");
}

TEST_CASE("a plane on the ground is a plane after reprojection, at its place, square and about as fine as before") {
    const TempDir dir;
    const Eastings plane;
    const std::string path = write(degrees([&](double x, double y) { return plane.at(x, y); }), dir / "a.tif");
    const Dem dem = read_dem(path, {});
    CHECK(dem.spacing_m[0] == dem.spacing_m[1]);
    CHECK(dem.spacing_m[0] == Approx(66.5).epsilon(0.01)); // 46.4 m x 95.5 m at 60.8 N
    CHECK(std::fmod(dem.crs_origin[0], dem.spacing_m[0]) == Approx(dem.spacing_m[0] / 2));
    CHECK(dem.crs_wkt.find("\"32632\"") != std::string::npos);
    CHECK(dem.native_quantum_m == 0);
    double worst = 0;
    std::uint64_t holes = 0;
    for (int y = 0; y < dem.rows; ++y)
        for (int x = 0; x < dem.columns; ++x) {
            if (dem.is_void(x, y)) {
                ++holes;
                continue;
            }
            const double east = dem.crs_origin[0] + x * dem.spacing_m[0],
                         north = dem.crs_origin[1] - y * dem.spacing_m[1];
            worst = std::max(worst, std::abs(dem.at(x, y) - (east / 100 + north / 1000)));
        }
    // Cubic interpolation of a plane is that plane but within two samples of the rim, where it is cut off: half a
    // sample of 0.7 m at most. Floats near 11,000 m are 0.001 m apart.
    CHECK(worst < 0.4);
    CHECK(holes > 0); // corners
    CHECK(static_cast<double>(holes) < 0.1 * dem.columns * dem.rows);
}

namespace {

// A plane with one hill, on a field of 161 x 141 samples in a CRS around a place. Its top is 25% of the width and 30%
// of the height from the middle, to the east and to the north of it as the Earth has them.
struct Hill {
    Raster field;
    double east_m = 0, north_m = 0; // of the top from the middle, on the ground
};
Hill hill_in(const std::string& name, double longitude, double latitude, double step) {
    register_drivers();
    OGRSpatialReference degrees, crs;
    degrees.importFromEPSG(4326);
    degrees.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    crs.SetFromUserInput(name.c_str());
    crs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    const std::unique_ptr<OGRCoordinateTransformation> there(OGRCreateCoordinateTransformation(&degrees, &crs));
    constexpr double metre = 1 / 111'200.0; // of latitude, in degrees: to 0.6%
    double x[2] = {longitude, longitude + 1500 * metre / std::cos(latitude * M_PI / 180)};
    double y[2] = {latitude, latitude + 1200 * metre};
    REQUIRE(there->Transform(2, x, y));
    Hill hill;
    hill.east_m = 1500, hill.north_m = 1200;
    hill.field = raster(161, 141, [&](int i, int j) {
        const double px = x[0] + (i - 80) * step, py = y[0] - (j - 70) * step;
        return 100 + 200 * std::exp(-(std::pow(px - x[1], 2) + std::pow(py - y[1], 2)) / (200 * step * step));
    });
    hill.field.geotransform = {x[0] - 80.5 * step, step, 0, y[0] + 70.5 * step, 0, -step};
    hill.field.crs = name;
    return hill;
}

} // namespace

TEST_CASE("a hill lies where it is on the ground, as far as it is, in any projected CRS") {
    const TempDir dir;
    struct Case {
        const char* crs;
        double longitude, latitude, step; // in units of the CRS, some 30 m of ground
        bool reprojected;
    };
    for (const Case& c : {Case{"EPSG:32632", 9, 47, 30, false},
                          {"EPSG:25833", 15, 62, 30, false},
                          {"EPSG:3857", 15, 62, 63.8, true},
                          {"EPSG:3857", -120, 38, 38, true},
                          {"EPSG:3857", 37, 0.1, 30, true},
                          {"EPSG:32662", 10, 60, 40, true},
                          {"EPSG:54009", 100, -40, 30, true},
                          {"ESRI:54009", 100, -40, 30, true},
                          {"EPSG:2048", 19, -33, 30, true},
                          {"EPSG:5513", 15, 50, 30, true},
                          {"EPSG:2065", 15, 50, 30, true},
                          {"EPSG:32631", 25, 45, 30, true}}) {
        OGRSpatialReference known;
        const GdalMessages quiet;
        if (known.SetFromUserInput(c.crs) != OGRERR_NONE) continue; // not in every PROJ
        const Hill hill = hill_in(c.crs, c.longitude, c.latitude, c.step);
        const std::string path = write(hill.field, dir / "hill.tif");
        const Dem dem = read_dem(path, {});
        CAPTURE(c.crs, c.latitude, dem.columns, dem.rows, dem.spacing_m[0]);
        const auto source = open_source({path}, {});
        CHECK(source->facts.reprojected_from.empty() == !c.reprojected);
        // The top, and the middle of the plane: the mean of all places that are there.
        double top = 0, middle_x = 0, middle_y = 0, count = 0;
        int top_x = 0, top_y = 0;
        for (int y = 0; y < dem.rows; ++y)
            for (int x = 0; x < dem.columns; ++x) {
                if (!dem.voids.empty() && dem.is_void(x, y)) continue;
                middle_x += x, middle_y += y, ++count;
                if (dem.at(x, y) > top) top = dem.at(x, y), top_x = x, top_y = y;
            }
        CHECK(top == Approx(300).margin(3));
        const double east_m = (top_x - middle_x / count) * dem.spacing_m[0];
        const double north_m = (middle_y / count - top_y) * dem.spacing_m[1];
        // To a cell, the half percent that is allowed, and what two planes are turned against each other.
        CHECK(std::hypot(east_m, north_m) == Approx(std::hypot(hill.east_m, hill.north_m)).epsilon(0.012).margin(45));
        if (c.reprojected) {
            CHECK(east_m == Approx(hill.east_m).margin(110));
            CHECK(north_m == Approx(hill.north_m).margin(110));
        }
    }
    // As it is, when that is asked for, and another spacing is resampled to.
    const Hill hill = hill_in("EPSG:3857", 15, 62, 63.8);
    const std::string path = write(hill.field, dir / "hill.tif");
    ReadOptions keep;
    keep.crs = "keep";
    CHECK(open_source({path}, keep)->spacing_m[0] == Approx(63.8));
    CHECK(open_source({path}, keep)->facts.ground_scale[1] == Approx(2.12).margin(0.02));
    const Hill utm = hill_in("EPSG:32633", 15, 62, 30);
    ReadOptions wider;
    wider.spacing_m = 90;
    const auto resampled = open_source({write(utm.field, dir / "utm.tif")}, wider);
    CHECK(resampled->spacing_m[0] == 90);
    CHECK(resampled->columns == Approx(161 / 3.0).margin(2));
}

TEST_CASE("degrees on a sphere become metres of a transverse Mercator on it, and other bodies are no Earth") {
    const TempDir dir;
    for (const double radius_m : {1'737'400.0, 3'396'190.0, 6'371'229.0}) { // the Moon, Mars, a weather model
        Raster r = raster(301, 201, [](int x, int y) {
            return 100 + 200 * std::exp(-(std::pow(x - 200, 2) + std::pow(y - 60, 2)) / 200.0);
        });
        r.geotransform = {20, 0.01, 0, 12, 0, -0.01};
        r.crs = "+proj=longlat +R=" + std::to_string(radius_m) + " +no_defs";
        const Dem dem = read_dem(write(r, dir / "sphere.tif"), {});
        int top_x = 0, top_y = 0;
        double middle_x = 0, middle_y = 0, count = 0;
        for (int y = 0; y < dem.rows; ++y)
            for (int x = 0; x < dem.columns; ++x) {
                if (!dem.voids.empty() && dem.is_void(x, y)) continue;
                middle_x += x, middle_y += y, ++count;
                if (dem.at(x, y) > dem.at(top_x, top_y)) top_x = x, top_y = y;
            }
        const double degree_m = radius_m * M_PI / 180, cell_m = 0.01 * degree_m;
        CHECK((top_x - middle_x / count) * dem.spacing_m[0] ==
              Approx(0.5 * degree_m * std::cos(11.4 * M_PI / 180)).margin(3 * cell_m));
        CHECK((middle_y / count - top_y) * dem.spacing_m[1] == Approx(0.4 * degree_m).margin(3 * cell_m));
    }
}

TEST_CASE("tiles on both sides of the antimeridian are neighbours, whichever way their longitudes count") {
    const TempDir dir;
    const auto tile = [&](const char* name, double west, int first) {
        Raster r = raster(121, 121, [=](int x, int y) { return 100 + 3 * (first + x) + y; });
        const double step = 1 / 120.0;
        r.geotransform = {west - step / 2, step, 0, 1 + step / 2, 0, -step};
        r.crs = "EPSG:4326";
        return write(r, dir / name);
    };
    const std::string west = tile("w.tif", 179, 0), east = tile("e.tif", -180, 120), same = tile("s.tif", 180, 120);
    const Dem plain = read_dem({west, same}, {});
    CHECK(plain.columns < 260);
    for (const std::vector<std::string>& files : {std::vector{west, east}, {east, west}, {east, same, west}}) {
        for (const char* const crs : {"auto", "EPSG:32601"}) {
            ReadOptions o;
            o.crs = crs;
            const Dem dem = read_dem(files, o);
            CHECK(dem.columns == plain.columns);
            CHECK(dem.rows == plain.rows);
            CHECK(dem.heights_m == plain.heights_m);
        }
    }
    // Far apart they make more of nothing than anybody wants.
    ReadOptions named;
    named.crs = "EPSG:3395";
    const std::string far = tile("far.tif", 60, 0);
    CHECK(refusal([&] { (void)open_source({west, far, tile("polar.tif", -60, 0)}, named); }).says("--bbox for a part"));
}

TEST_CASE("reprojection digs no trench beside a cliff and builds no wall on it, whatever the spacing") {
    const TempDir dir;
    // An island, level and 300 m high, in a level sea.
    const auto island = [](double longitude, double latitude) {
        return std::hypot((longitude - 8.63) * 0.5, latitude - 60.8) < 0.1 ? 300.0 : 0.0;
    };
    const std::string file = write(degrees(island), dir / "island.tif");
    for (const double spacing_m : {0.0, 20.0, 90.0, 300.0, 900.0}) { // 0: the source's own, 47 by 95 m
        ReadOptions options;
        if (spacing_m > 0) {
            options.crs = "EPSG:32632";
            options.spacing_m = spacing_m;
        }
        const Dem dem = read_dem(file, options);
        std::size_t outside = 0, sea = 0, land = 0;
        for (std::size_t i = 0; i < dem.heights_m.size(); ++i) {
            if (!dem.voids.empty() && dem.voids[i] != 0) continue;
            const float height = dem.heights_m[i];
            outside += height < 0 || height > 300;
            sea += height == 0;
            land += height == 300;
        }
        CAPTURE(spacing_m, outside, sea, land, dem.heights_m.size());
        CHECK(outside == 0);
        CHECK(sea > dem.heights_m.size() / 3);
        CHECK(land > 100);
    }
}

TEST_CASE("what is reprojected is the same bit for bit in any windows, orders, readers, threads and caches") {
    const TempDir dir;
    Raster r = degrees([](double x, double y) { return x > 8.4 && x < 8.42 && y < 60.8 ? -9999 : rough(x, y); });
    tag(r, -9999);
    const std::string path = write(r, dir / "a.tif");
    const auto source = open_source({path}, {});
    REQUIRE(source->columns > warp_block);
    REQUIRE(source->rows > warp_block);
    check_windows(*source);
    const Field whole = read_whole(*source);
    limit_gdal_cache(1 << 16);
    std::vector<int> wrong(3);
    std::vector<std::thread> threads;
    for (std::size_t t = 0; t < 3; ++t)
        threads.emplace_back([&, t] {
            const auto reader = source->reader();
            std::vector<Window> windows = source->windows(20000);
            std::shuffle(windows.begin(), windows.end(), std::mt19937(static_cast<unsigned>(t)));
            ReadStatistics unused;
            for (const Window& w : windows) wrong[t] += !same_bits(*reader, *source, whole, w, unused);
        });
    for (std::thread& t : threads) t.join();
    limit_gdal_cache(std::size_t{64} << 20);
    CHECK(wrong == std::vector<int>(3));
}

TEST_CASE("a CRS that is named is reprojected to, and a box and a spacing count in it") {
    const TempDir dir;
    const Eastings plane;
    const std::string path = write(degrees([&](double x, double y) { return plane.at(x, y); }), dir / "a.tif");
    ReadOptions o;
    o.crs = "EPSG:25833";
    o.spacing_m = 100;
    const Dem other = read_dem(path, o);
    CHECK(other.spacing_m[0] == 100);
    CHECK(other.crs_wkt.find("25833") != std::string::npos);
    o.crs = "EPSG:32632";
    o.bbox = {{460000, 6735000, 470000, 6740000}};
    const Dem box = read_dem(path, o);
    CHECK(box.columns == 100);
    CHECK(box.rows == 50);
    CHECK(box.crs_origin[0] == 460050);
    CHECK(box.crs_origin[1] == 6739950);
    CHECK(box.voids.empty());
    CHECK(box.at(10, 10) == Approx(461050 / 100.0 + 6738950 / 1000.0).margin(0.01));
    o.bbox = {{0, 0, 1000, 1000}};
    check_refusal(refused(path, o), 1, path, {"--bbox 0,0,1000,1000 lies outside", "it spans"});
    o.bbox.reset();
    for (const char* bad : {"EPSG:4326", "EPSG:4978"}) {
        o.crs = bad;
        check_refusal(refused(path, o), 2, bad, {"is not projected"});
    }
    for (const char* bad : {"", "EPSG:1", "nonsense", "/etc/passwd"}) {
        o.crs = bad;
        check_refusal(refused(path, o), 2, bad, {"no CRS that GDAL knows"});
    }
    o.crs = "EPSG:32632";
    const std::string local = write(raster(20, 15, slope), dir / "local.tif");
    check_refusal(refused(local, o), 1, local, {"has no CRS of its own", "-a_srs"});
    Raster projected = raster(20, 15, slope);
    projected.crs = "EPSG:32632";
    o.spacing_m.reset();
    check_slope(read_dem(write(projected, dir / "same.tif"), o), 20, 15); // it is there already
}

TEST_CASE("extents that no plane holds are refused with what can be done") {
    const TempDir dir;
    Raster r = raster(36, 18, slope);
    r.geotransform = {-180, 10, 0, 90, 0, -10};
    r.crs = "EPSG:4326";
    const std::string path = write(r, dir / "earth.tif");
    check_refusal(refused(path), 1, path,
                  {"spans 360 x 180 degrees", "--spacing M", "--bbox", "in degrees", "--crs EPSG:6933"});
    CHECK(read_dem(path, spaced(1000)).columns == 36);
    ReadOptions o;
    o.crs = "EPSG:32632";
    o.spacing_m = 100000;
    o.bbox = {{0, 4000000, 1000000, 5000000}};
    const Dem part = read_dem(path, o);
    CHECK(part.columns == 10);
    CHECK(part.voids.empty());
}

TEST_CASE("voids of a file stay where they are, and smear nothing, and undeclared ones are refused before they could") {
    const TempDir dir;
    const auto hole = [](double x, double y) { return x > 8.4 && x < 8.5 && y < 60.8 && y > 60.7; };
    Raster r = degrees([&](double x, double y) { return hole(x, y) ? -9999 : 500; });
    tag(r, -9999);
    const std::string path = write(r, dir / "a.tif");
    Raster undeclared = degrees([&](double x, double y) { return hole(x, y) ? -32767 : 500; });
    const std::string odd = write(undeclared, dir / "b.tif");
    for (const auto& [file, nodata] : {std::pair{path, NoData::automatic}, {odd, NoData::hole}}) {
        const Dem dem = read_dem(file, with(nodata));
        int wrong = 0;
        for (int i = 0; i < dem.columns * dem.rows; ++i)
            wrong += !dem.voids[static_cast<std::size_t>(i)] &&
                     std::abs(dem.heights_m[static_cast<std::size_t>(i)] - 500) > 1e-3f;
        CHECK(wrong == 0);
        // 0.01 square degrees of 0.35, and the corners
        CHECK(static_cast<double>(void_count(dem)) > 0.03 * dem.columns * dem.rows);
    }
    check_refusal(refused(odd), 1, odd, {"-32767 m at column", "--nodata hole", "--nodata fill"});
    check_refusal(refused(path, with(NoData::refuse)), 1, path, {"no-data or NaN", "--nodata hole"});
    CHECK(read_dem(path, filling()).voids.empty());
}

TEST_CASE("a vertical axis in feet counts where the band says nothing, and one that contradicts it is refused") {
    const TempDir dir;
    Raster r = raster(20, 15, slope);
    r.crs = "EPSG:2263+6360"; // New York, NAVD88 in US survey feet
    const std::string path = write(r, dir / "a.tif");
    CHECK(read_dem(path, {}).at(3, 4) == Approx(slope(3, 4) * 1200 / 3937));
    // GDAL makes a band's unit of a GeoTIFF's axis; a VRT has only what it says.
    write_text(dir / "a.vrt",
               "<VRTDataset rasterXSize=\"20\" rasterYSize=\"15\"><SRS>EPSG:2263+6360</SRS><GeoTransform>"
               "995,10,0,2005,0,-10</GeoTransform><VRTRasterBand dataType=\"Float32\" band=\"1\">"
               "<SimpleSource><SourceFilename relativeToVRT=\"1\">a.tif</SourceFilename><SourceBand>1"
               "</SourceBand></SimpleSource></VRTRasterBand></VRTDataset>");
    CHECK(read_dem(dir / "a.vrt", {}).at(3, 4) == Approx(slope(3, 4) * 1200 / 3937));
    r.more = [](GDALDataset& file) { file.GetRasterBand(1)->SetUnitType("metre"); };
    const std::string both = write(r, dir / "b.tif");
    check_refusal(refused(both), 1, both, {"\"metre\"", "US survey foot", "--vertical-unit"});
    ReadOptions o;
    o.vertical_unit = "m";
    CHECK(read_dem(both, o).at(3, 4) == static_cast<float>(slope(3, 4)));
}

TEST_CASE("real fields in degrees are reprojected to where GDAL's own program puts them") {
    const std::string path = data_file("formats/N37W003.hgt");
    if (path.empty()) return;
    const Dem dem = read_dem(path, {});
    CHECK(dem.crs_wkt.find("\"32630\"") != std::string::npos);
    const TempDir dir;
    char command[512];
    std::snprintf(command, sizeof command,
                  "gdalwarp -q -et 0 -r cubic -dstnodata -9999 -ot Float32 -t_srs EPSG:32630 -te %.9f %.9f %.9f %.9f "
                  "-ts %d %d %s %s",
                  dem.crs_origin[0] - dem.spacing_m[0] / 2, dem.crs_origin[1] - (dem.rows - 0.5) * dem.spacing_m[1],
                  dem.crs_origin[0] + (dem.columns - 0.5) * dem.spacing_m[0], dem.crs_origin[1] + dem.spacing_m[1] / 2,
                  dem.columns, dem.rows, path.c_str(), (dir / "w.tif").c_str());
    if (std::system(command) != 0) {
        WARN("skipped: gdalwarp does not run");
        return;
    }
    ReadOptions as_it_is;
    as_it_is.nodata = NoData::hole;
    const Dem gdal = read_dem(dir / "w.tif", as_it_is);
    double sum = 0, worst = 0;
    int compared = 0, rim = 0;
    for (std::size_t i = 0; i < dem.heights_m.size(); ++i) {
        if ((dem.voids[i] != 0) != (gdal.voids[i] != 0)) ++rim;
        if (dem.voids[i] || gdal.voids[i]) continue;
        const double off = std::abs(dem.heights_m[i] - gdal.heights_m[i]);
        sum += off, worst = std::max(worst, off), ++compared;
    }
    CHECK(rim < 100);
    CHECK(sum / compared < 0.5); // its chunks make another resampling ratio
    CHECK(worst < 60);
}
