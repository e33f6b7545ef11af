// What was baked wrongly without a word, kind by kind: units, depths, axes, metres that are not the ground's, spacings,
// the antimeridian. Each with what is right, and with more of its kind.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "baker/georeference/crs_label.h"
#include "baker/maps/image.h"
#include "read_support.h"
#include "support/rounds.h"

using namespace fjell::baker;
using namespace fjell::test;

namespace {

// A field whose heights, or colours, follow from where its samples lie: longitudes from 0 to 360.
struct Placed {
    const char* name;
    const char* crs;
    double west, north, step; // of the first pixel's corner
    int columns, rows;
};
std::string write_placed(const Placed& p, const std::function<double(double longitude, double latitude)>& value,
                         const std::string& path, bool image = false) {
    register_drivers();
    OGRSpatialReference degrees, crs;
    degrees.importFromEPSG(4326);
    degrees.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    crs.SetFromUserInput(p.crs);
    crs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    const std::unique_ptr<OGRCoordinateTransformation> to_degrees(OGRCreateCoordinateTransformation(&crs, &degrees));
    Raster r = raster(p.columns, p.rows, [&](int i, int j) {
        double x = p.west + (i + 0.5) * p.step, y = p.north - (j + 0.5) * p.step;
        if (crs.IsProjected()) (void)to_degrees->Transform(1, &x, &y);
        return value(x - 360 * std::floor(x / 360), y);
    });
    if (image) r.type = GDT_Byte, r.bands = 3;
    r.geotransform = {p.west, p.step, 0, p.north, 0, -p.step};
    r.crs = p.crs;
    return write(r, path);
}

// Grey at a sample, of the uppermost image that has something there; -1: none has.
int grey_at(const ImageSource& images, ImageReader& reader, int column, int row) {
    int grey = -1;
    for (std::size_t i = 0; i < images.layers.size(); ++i) {
        const ImageLayer& l = images.layers[i];
        const auto x = static_cast<int>(std::floor(l.first_px[0] + column * l.per_sample[0]));
        const auto y = static_cast<int>(std::floor(l.first_px[1] + row * l.per_sample[1]));
        if (x < 0 || y < 0 || x >= l.columns || y >= l.rows) continue;
        std::uint8_t rgba[4];
        reader.read(i, {x, y, 1, 1}, rgba);
        if (rgba[3] > 0) grey = rgba[0];
    }
    return grey;
}

} // namespace

TEST_CASE("a CRS in feet gives a spacing in metres, and heights without a unit are asked about") {
    const TempDir dir;
    Raster r = raster(4, 3, slope);
    r.crs = "EPSG:2263"; // New York, US survey feet
    constexpr double us_ft = 1200.0 / 3937;
    const std::string path = write(r, dir / "a.tif");
    // Whether what counts feet across counts them upwards only the user knows.
    check_refusal(refused(path), 1, path, {"0.3048006", "--vertical-unit us-ft if", "--vertical-unit m if"});
    const auto read = [](const std::string& file, const std::string& unit) {
        ReadOptions o;
        o.vertical_unit = unit;
        return read_dem(file, o);
    };
    for (const auto& [unit, metre] : {std::pair{"us-ft", us_ft},
                                      {"ft", 0.3048},
                                      {"m", 1.0},
                                      {"US survey foot", us_ft},
                                      {"fath", 1.8288},
                                      {"yd", 0.9144},
                                      {"ind-ft", 0.30479841}}) {
        const Dem dem = read(path, unit);
        CHECK(dem.spacing_m[0] == Approx(10 * us_ft).epsilon(1e-12));
        CHECK(dem.heights_m[5] == Approx(slope(1, 1) * metre).epsilon(1e-7));
    }
    check_refusal(refusal([&] { (void)read(path, "elephants"); }), 2, "--vertical-unit elephants", {"us-ft"});
    r.crs = "EPSG:3139"; // Vanua Levu, links
    check_refusal(refused(write(r, dir / "links.tif")), 1, dir / "links.tif", {"--vertical-unit link if"});
    // One that is named counts, and may be said again, but not otherwise.
    r.more = [](GDALDataset& file) { file.GetRasterBand(1)->SetUnitType("US survey foot"); };
    const std::string named = write(r, dir / "b.tif");
    for (const char* const unit : {"", "us-ft"}) CHECK(read(named, unit).heights_m[0] == Approx(slope(0, 0) * us_ft));
    check_refusal(refusal([&] { (void)read(named, "m"); }), 1, named, {"\"US survey foot\"", "--zscale 3.28083"});
    r.more = [](GDALDataset& file) { file.GetRasterBand(1)->SetUnitType("cubits"); };
    const std::string odd = write(r, dir / "c.tif");
    check_refusal(refused(odd), 1, odd, {"\"cubits\"", "--vertical-unit"});
    CHECK(read(odd, "dm").heights_m[0] == Approx(slope(0, 0) * 0.1));
}

TEST_CASE("heights over a vertical axis that points down are asked about, whatever the axis is called") {
    const TempDir dir;
    for (const auto& [vertical, down] : {std::pair{5715, true},
                                         {5861, true},
                                         {5866, true},
                                         {5336, true}, // depths
                                         {5714, false},
                                         {5703, false},
                                         {5773, false},
                                         {8228, false}}) {
        Raster r = raster(9, 9, slope);
        r.crs = "EPSG:32633+" + std::to_string(vertical);
        const std::string path = write(r, dir / "a.tif");
        const double unit = vertical == 8228 ? 0.3048 : 1; // NAVD88 in feet
        CAPTURE(vertical);
        if (down) check_refusal(refused(path), 1, path, {"depths", "--zscale -1", "--zscale 1"});
        for (const double zscale : {-1.0, 1.0}) {
            ReadOptions o;
            if (down || zscale < 0) o.zscale = zscale;
            CHECK(read_dem(path, o).at(3, 4) == Approx(zscale * unit * slope(3, 4)).epsilon(1e-6));
        }
    }
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
                          {"EPSG:2049", 21, -33, 30, true},
                          {"EPSG:22275", 15, -28, 30, true},
                          {"EPSG:32631", 25, 45, 30, true},
                          {"EPSG:27572", 2, 46.5, 30, false},
                          {"EPSG:27572", 2, 40, 30, true}, // true to 0.9%, if grads are taken for grads
                          {"EPSG:5016", -24, 38, 30, true},
                          {"+proj=robin +datum=WGS84 +units=m", 20, 50, 30, true},
                          {"EPSG:3395", 10, 55, 52, true}}) {
        OGRSpatialReference known;
        const GdalMessages quiet;
        if (known.SetFromUserInput(c.crs) != OGRERR_NONE) continue; // not in every PROJ
        const Hill hill = hill_in(c.crs, c.longitude, c.latitude, c.step);
        const std::string path = write(hill.field, dir / "hill.tif");
        const Dem dem = read_dem(path, {});
        CAPTURE(c.crs, c.latitude, dem.columns, dem.rows, dem.spacing_m[0]);
        const auto source = open_source({path}, {});
        CHECK(source->facts.reprojected_from.empty() == !c.reprojected);
        CHECK(source->facts.resampled == (c.reprojected ? "cubic" : ""));
        const std::string crs = c.crs;
        CHECK(source->facts.axes == (crs == "EPSG:2048" || crs == "EPSG:2049" || crs == "EPSG:22275" ? "west, south"
                                     : crs == "EPSG:5513" || crs == "EPSG:2065"                      ? "south, west"
                                                                                                     : ""));
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
    // As it is, when that is asked for.
    const Hill hill = hill_in("EPSG:3857", 15, 62, 63.8);
    const std::string path = write(hill.field, dir / "hill.tif");
    ReadOptions keep;
    keep.crs = "keep";
    CHECK(open_source({path}, keep)->spacing_m[0] == Approx(63.8));
    CHECK(open_source({path}, keep)->facts.ground_scale[1] == Approx(2.12).margin(0.02));
}

TEST_CASE("another spacing resamples what has a CRS, and stretches nothing") {
    const TempDir dir;
    struct Case {
        const char* crs;
        double step[2];   // in units of the CRS
        double spacing_m; // that is asked for
        double west, north;
        double unit_m = 1; // of the CRS
    };
    for (const Case& c : {Case{"EPSG:32633", {30, 30}, 90, 500000, 6875000},
                          {"EPSG:32633", {30, 30}, 12, 500000, 6875000},
                          {"EPSG:32633", {30, 20}, 25, 500000, 6875000},
                          {"EPSG:2225", {100, 100}, 60, 6500000, 2000000, 1200.0 / 3937},
                          {"EPSG:2222", {100, 50}, 30, 650000, 1000000, 0.3048}}) {
        const auto plain = [&](double x, double y) { // 3 m and 7 m to 100 m of ground
            return 500 + 0.03 * (x - c.west) * c.unit_m + 0.07 * (c.north - y) * c.unit_m;
        };
        Raster r = raster(257, 257, [&](int i, int j) {
            return plain(c.west + (i + 0.5) * c.step[0], c.north - (j + 0.5) * c.step[1]);
        });
        r.geotransform = {c.west, c.step[0], 0, c.north, 0, -c.step[1]};
        r.crs = c.crs;
        ReadOptions o;
        o.spacing_m = c.spacing_m;
        o.vertical_unit = "m";
        const std::string path = write(r, dir / "a.tif");
        const Dem dem = read_dem(path, o);
        if (c.spacing_m == 90) CHECK(open_source({path}, o)->facts.resampled == "cubic over 3 samples");
        CAPTURE(c.crs, c.step[0], c.spacing_m, dem.columns, dem.rows);
        CHECK(dem.spacing_m[0] == Approx(c.spacing_m));
        CHECK(dem.spacing_m[1] == Approx(c.spacing_m));
        CHECK(dem.crs_step[0] == Approx(c.spacing_m / c.unit_m));
        CHECK(dem.columns == Approx(257 * c.step[0] * c.unit_m / c.spacing_m).margin(1.5));
        CHECK(dem.rows == Approx(257 * c.step[1] * c.unit_m / c.spacing_m).margin(1.5));
        double worst = 0;
        for (int y = 8; y < dem.rows - 8; ++y)
            for (int x = 8; x < dem.columns - 8; ++x)
                worst = std::max(worst, std::abs(dem.at(x, y) - plain(dem.crs_origin[0] + x * dem.crs_step[0],
                                                                      dem.crs_origin[1] - y * dem.crs_step[1])));
        // A tenth of a sample: GDAL's kernel is as wide along rows as along columns, and no wider than it has to be.
        CHECK(worst < 0.1 * (0.03 * c.step[0] + 0.07 * c.step[1]) * c.unit_m);
    }
}

TEST_CASE("reprojection digs no trench beside a cliff and builds no wall on it, whatever the spacing") {
    const TempDir dir;
    struct Case {
        const char* name;
        std::function<double(int, int)> height;
        double low, high, least_share; // of samples that are low, in the whole
    };
    const auto at_240 = [](int x, int y) { return std::hypot(x - 120, y - 120); };
    const std::vector<Case> cases{
        {"island", [&](int x, int y) { return at_240(x, y) < 60 ? 300 : 0; }, 0, 300, 0.6},
        {"shelf", [](int x, int y) { return 2 * x + y < 300 ? 0 : 1234; }, 0, 1234, 0.2},
        {"steps", [](int x, int) { return x / 9 % 2 ? 9 : 0; }, 0, 9, 0.2},
        {"pillars", [](int x, int y) { return x % 12 == 0 && y % 12 == 0 ? 50 : -20; }, -20, 50, 0.5}};
    for (const Case& c : cases) {
        Raster r = raster(241, 241, c.height);
        r.geotransform = {8, 1 / 3600.0, 0, 47, 0, -1 / 3600.0};
        r.crs = "EPSG:4326";
        const std::string file = write(r, dir / "cliff.tif");
        for (const double spacing_m : {0.0, 8.0, 90.0, 300.0}) { // 0: the source's own, 21 by 31 m
            ReadOptions o;
            if (spacing_m > 0) o.crs = "EPSG:32632", o.spacing_m = spacing_m;
            const Dem dem = read_dem(file, o);
            std::size_t outside = 0, low = 0, high = 0, all = 0;
            for (std::size_t i = 0; i < dem.heights_m.size(); ++i) {
                if (!dem.voids.empty() && dem.voids[i] != 0) continue;
                const auto height = static_cast<double>(dem.heights_m[i]);
                outside += height < c.low || height > c.high;
                low += height == c.low;
                high += height == c.high;
                ++all;
            }
            CAPTURE(c.name, spacing_m, outside, low, high, all);
            CHECK(outside == 0);
            if (spacing_m > 30) continue; // means over what is smaller
            CHECK(static_cast<double>(low) > c.least_share * static_cast<double>(all));
            if (c.high > 100) CHECK(static_cast<double>(high) > 0.1 * static_cast<double>(all));
        }
    }
}

TEST_CASE("degrees on a sphere become metres of a transverse Mercator on it, and other bodies are no Earth") {
    const TempDir dir;
    struct Body {
        double radius_m;
        const char* shape;
    };
    for (const auto& [radius_m, shape] : {Body{1'737'400.0, "+R=1737400"},
                                          {3'396'190.0, "+R=3396190"},
                                          {6'371'229.0, "+R=6371229"}, // a weather model
                                          {2'439'700.0, "+R=2439700"},
                                          {3'396'190.0, "+a=3396190 +b=3376200"},
                                          {6'051'800.0, "+R=6051800"}}) {
        Raster r = raster(301, 201, [](int x, int y) {
            return 100 + 200 * std::exp(-(std::pow(x - 200, 2) + std::pow(y - 60, 2)) / 200.0);
        });
        r.geotransform = {20, 0.01, 0, 12, 0, -0.01};
        r.crs = std::string("+proj=longlat ") + shape + " +no_defs";
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
    // A box in degrees, also one that goes across; the same as it is and reprojected.
    for (const char* const crs : {"auto", "none"}) {
        ReadOptions o;
        o.crs = crs;
        if (o.crs == "none") o.spacing_m = 900;
        o.bbox = {{179.5, 0.2, 180.5, 0.8}};
        const Dem box = read_dem({west, east}, o);
        CHECK(box.columns == Approx(121).margin(1));
        CHECK(box.rows == Approx(73).margin(1));
        CHECK(box.at(box.columns / 2, box.rows / 2) == Approx(100 + 3 * 120 + 60).margin(3));
        for (const auto& same_box : {std::array{-180.5, 0.2, -179.5, 0.8}, {179.5, 0.2, -179.5, 0.8}}) {
            o.bbox = same_box;
            CHECK(read_dem({west, east}, o).heights_m == box.heights_m);
        }
    }
    ReadOptions metres_of;
    metres_of.bbox = {{200, 0, 100, 1}};
    check_refusal(refused(write(slope_with(-9), dir / "m.tif"), metres_of), 2, "--bbox", {"WEST 200 is not less"});
    // On a map whose edges are there: beyond one of them, and as two tiles.
    const double turn = 2 * M_PI * 6378137, step = turn / 36000;
    const auto mercator = [&](const char* name, double from, int columns) {
        return write_placed(
            {name, "EPSG:3857", from, 50 * step, step, columns, 100},
            [](double x, double y) { return 500 + 100 * (x - 180) + 10 * y; }, dir / name);
    };
    const Dem whole = read_dem(mercator("beyond.tif", turn / 2 - 80 * step, 200), {});
    const std::string left = mercator("left.tif", turn / 2 - 80 * step, 80);
    const std::string right = mercator("right.tif", -turn / 2, 120);
    CHECK(static_cast<double>(void_count(whole)) < 0.02 * whole.columns * whole.rows);
    CHECK(whole.columns == Approx(200).margin(3));
    CHECK(whole.at(whole.columns / 2, whole.rows / 2) == Approx(500 + 100 * 0.2).margin(2));
    CHECK(read_dem({left, right}, {}).heights_m == whole.heights_m);
    CHECK(read_dem({right, left}, {}).heights_m == whole.heights_m);
    // Far apart they make more of nothing than anybody wants.
    ReadOptions named;
    named.crs = "EPSG:3395";
    const std::string far = tile("far.tif", 60, 0);
    CHECK(refusal([&] { (void)open_source({west, far, tile("polar.tif", -60, 0)}, named); }).says("--bbox for a part"));
}

TEST_CASE("a CRS is named with its code in either version of WKT") {
    for (const int code : {32633, 3857, 6247, 8857, 27572}) { // 6247 and 8857 are none that the first version has
        OGRSpatialReference crs;
        crs.importFromEPSG(code);
        const CrsLabel label = crs_label(wkt_of(crs));
        CHECK(label.epsg == code);
        CHECK(label.name == crs.GetName());
    }
    OGRSpatialReference crs;
    crs.SetFromUserInput("+proj=tmerc +R=1737400");
    CHECK(crs_label(wkt_of(crs)).epsg == 0);
}

TEST_CASE("images lie where they are on both sides of the antimeridian, however their longitudes count") {
    const TempDir dir;
    const auto colour = [](double longitude, double) { return 100 + 40 * (longitude - 180); };
    const auto height = [](double longitude, double latitude) { return 500 + 100 * (longitude - 180) + latitude; };
    struct Case {
        std::vector<Placed> images;
        double west = 179, east = 181; // where they have colours
    };
    const std::vector<Case> cases{
        {{{"one", "EPSG:4326", 178.5, 1.5, 0.01, 300, 200}}},
        {{{"other", "EPSG:4326", -181.5, 1.5, 0.01, 300, 200}}},
        {{{"w", "EPSG:4326", 178.5, 1.5, 0.01, 150, 200}, {"e", "EPSG:4326", -180, 1.5, 0.01, 150, 200}}},
        {{{"w", "EPSG:4326", 178.5, 1.5, 0.01, 150, 200}}, 179, 180},
        {{{"e", "EPSG:4326", -180, 1.5, 0.01, 150, 200}}, 180, 181},
        {{{"world", "EPSG:4326", -180, 90, 0.25, 1440, 720}}},
        {{{"world0", "EPSG:4326", 0, 90, 0.25, 1440, 720}}},
        {{{"mercator", "EPSG:3857", -20037508.34, 20037508.34, 20037508.34 / 720, 1440, 1440}}},
        {{{"over", "EPSG:3857", 20037508.34 - 167'000, 167'000, 1000, 334, 334}}}, // beyond the edge of its map
        {{{"under", "EPSG:3857", -20037508.34 - 167'000, 167'000, 1000, 334, 334}}},
        {{{"plain", "EPSG:32662", 20037508.34 - 167'000, 167'000, 1000, 334, 334}}},
        {{{"all beyond", "EPSG:3395", 20037508.34 + 1000, 167'000, 1000, 166, 334}}, 180, 181}};
    const auto path_of = [&](const Placed& image) { return dir / (std::string(image.name) + ".tif"); };
    for (const Case& c : cases)
        for (const Placed& image : c.images) write_placed(image, colour, path_of(image), true);
    for (const Placed& ground :
         first_of<Placed>(3, {{"a", "EPSG:4326", 179, 1, 0.02, 100, 50},
                              {"c", "EPSG:32601", 60'000, 110'000, 2000, 100, 50},
                              {"f", "EPSG:3857", -20037508.34 - 100'000, 110'000, 2000, 100, 50},
                              {"b", "EPSG:4326", -181, 1, 0.02, 100, 50},
                              {"d", "EPSG:3832", 3'200'000, 110'000, 2000, 100, 50},
                              {"e", "EPSG:3857", 20037508.34 - 100'000, 110'000, 2000, 100, 50}})) {
        const std::string dem = write_placed(ground, height, dir / "dem.tif");
        for (const char* const crs : {"auto", "keep"}) {
            ReadOptions o;
            o.crs = crs;
            if (ground.step < 1 && o.crs == "keep") o.spacing_m = 2000;
            const auto source = open_source({dem}, o);
            const Frame frame = frame_of(*source);
            OGRSpatialReference degrees, own;
            degrees.importFromEPSG(4326);
            degrees.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
            own.importFromWkt(frame.crs_wkt.c_str());
            own.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
            const std::unique_ptr<OGRCoordinateTransformation> to_degrees(
                OGRCreateCoordinateTransformation(&own, &degrees));
            for (const Case& c : cases) {
                std::vector<std::string> paths;
                for (const Placed& image : c.images) paths.push_back(path_of(image));
                CAPTURE(ground.name, crs, c.images.front().name, c.east);
                const Refusal refused = refusal([&] { (void)open_images(paths, frame); });
                CHECK(refused.line == "");
                if (refused.code != 0) continue;
                // Paint lies as images do; what would lie on both sides of a terrain on its map is refused.
                if (paths.size() == 1) {
                    const auto paint = [&] {
                        return open_raster_map(paths[0], frame, RasterUse::paint)->layers.size();
                    };
                    const Refusal torn = refusal([&] { CHECK(paint() == open_images(paths, frame)->layers.size()); });
                    CHECK((torn.code == 0 || (torn.says("without --spacing and --crs") &&
                                              open_images(paths, frame)->layers.size() == 2)));
                }
                const auto images = open_images(paths, frame);
                const auto reader = images->reader();
                int wrong = 0, missing = 0, seen = 0;
                for (int row = 5; row < source->rows - 5; row += 7)
                    for (int column = 1; column < source->columns - 1; column += 3) {
                        double x = frame.origin[0] + column * frame.step[0], y = frame.origin[1] - row * frame.step[1];
                        if (own.IsProjected()) (void)to_degrees->Transform(1, &x, &y);
                        x -= 360 * std::floor(x / 360);
                        if (x < c.west + 0.3 || x > c.east - 0.3 || std::abs(x - 180) < 0.3) continue;
                        const int grey = grey_at(*images, *reader, column, row);
                        ++seen;
                        missing += grey < 0;
                        wrong += grey >= 0 && std::abs(grey - colour(x, y)) > 12;
                    }
                CHECK(seen > 20);
                CHECK(missing == 0);
                CHECK(wrong == 0);
            }
        }
    }
}
