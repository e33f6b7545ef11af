// Where longitudes end or meet: over the antimeridian, towards the poles and around them.
#include <array>
#include <cmath>
#include <numbers>
#include <tuple>

#include "baker/georeference/projection.h"
#include "source_check.h"
#include "support/rounds.h"

using namespace fjell::baker;
using namespace fjell::test;

namespace {

// A plane cut through the globe: smooth, and the same whatever a longitude is called.
double on_globe(double longitude, double latitude) {
    const double l = longitude * std::numbers::pi / 180, b = latitude * std::numbers::pi / 180;
    return 1000 + 4000 * std::cos(b) * std::cos(l) + 3000 * std::cos(b) * std::sin(l);
}

struct Degrees {
    double west, north, step;
    int columns, rows;
};

std::string written(const Degrees& f, const std::string& path) {
    Raster r =
        raster(f.columns, f.rows, [&](int x, int y) { return on_globe(f.west + f.step * x, f.north - f.step * y); });
    r.geotransform = {f.west - f.step / 2, f.step, 0, f.north + f.step / 2, 0, -f.step};
    r.crs = "EPSG:4326";
    return write(r, path);
}

struct Found {
    double inner_worst_m = 0;    // two samples and more from the source's rim
    double rim_worst_m = 0;      // elsewhere
    std::uint64_t misplaced = 0; // holes inside the source, or heights outside of it
    std::uint64_t inside = 0;
};

// Every sample against the truth at its own place.
Found compare(const Dem& dem, const Degrees& f) {
    OGRSpatialReference plane, degrees;
    plane.importFromWkt(dem.crs_wkt.c_str());
    plane.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    degrees.importFromEPSG(4326);
    degrees.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    const std::unique_ptr<OGRCoordinateTransformation> back(OGRCreateCoordinateTransformation(&plane, &degrees));
    Found found;
    for (int y = 0; y < dem.rows; ++y)
        for (int x = 0; x < dem.columns; ++x) {
            double longitude = dem.crs_origin[0] + x * dem.crs_step[0],
                   latitude = dem.crs_origin[1] - y * dem.crs_step[1];
            REQUIRE(back->Transform(1, &longitude, &latitude));
            const bool whole = f.columns * f.step > 359.999;
            double column = (longitude - f.west) / f.step;
            column -= 360 / f.step * std::floor((column + 0.5) * f.step / 360); // -0.5 <= column < 360 / step - 0.5
            const double row = (f.north - latitude) / f.step;
            const double ways[4] = {whole ? 9 : column + 0.5, whole ? 9 : f.columns - 0.5 - column, row + 0.5,
                                    f.rows - 0.5 - row};
            const bool pole = f.north + f.step / 2 > 89.999;
            const double depth = std::min({ways[0], ways[1], pole ? 9 : ways[2], ways[3]});
            if (std::abs(depth) > 0.05) found.misplaced += (depth > 0) == dem.is_void(x, y);
            if (depth <= 0.05 || dem.is_void(x, y)) continue;
            ++found.inside;
            const double off = std::abs(dem.at(x, y) - on_globe(longitude, latitude));
            // Beside the seam and around the pole interpolation is cut off too.
            const double seam = whole ? std::min(column + 0.5, f.columns - 0.5 - column) : 9;
            double& worst = std::min({depth, seam, pole ? ways[2] : 9}) > 2 ? found.inner_worst_m : found.rim_worst_m;
            worst = std::max(worst, off);
        }
    return found;
}

// A place is right to 0.01 samples along each axis (warp.cpp), a cubic to far less on something this smooth; at the
// source's rim its outermost samples reach half a sample out. No slope is steeper than 5,000 m a radian.
void check(const Dem& dem, const Degrees& f) {
    const Found found = compare(dem, f);
    const double per_sample = 5000 * f.step * std::numbers::pi / 180;
    CAPTURE(f.west, f.north, f.step, dem.columns, dem.rows, found.inside, void_count(dem));
    CHECK(found.misplaced == 0);
    CHECK(found.inside > 10000);
    CHECK(found.inner_worst_m <= 0.02 * per_sample + 1e-3);
    CHECK(found.rim_worst_m <= 0.75 * per_sample);
}

} // namespace

TEST_CASE("a field across the antimeridian is one piece at its place, whatever its longitudes are called") {
    const TempDir dir;
    for (const double west : {179.0, -181.0, 178.5, 539.0, -541.0, 359.0, -361.0}) {
        const Degrees f{west, 52, 1.0 / 120, 241, 241};
        const std::string path = written(f, dir / "a.tif");
        const Dem dem = read_dem(path, {});
        CHECK(dem.columns < 300);
        check(dem, f);
    }
}

TEST_CASE("a field close to a pole is at its place, and the pole no hole in it") {
    const TempDir dir;
    const Degrees far_north{-20, 89.5, 0.05, 1201, 111};
    check(read_dem(written(far_north, dir / "a.tif"), {}), far_north);
    const Degrees across{150, 88, 0.05, 1201, 121}; // over the antimeridian too
    check(read_dem(written(across, dir / "b.tif"), {}), across);
    const Degrees south{-20, -84, 0.05, 1201, 111};
    check(read_dem(written(south, dir / "c.tif"), {}), south);
}

TEST_CASE("a polar cap is complete: no hole at the pole, none along the seam") {
    const TempDir dir;
    // Larger than one block of the target. With samples on the pole and the seam, and with pixels that end there.
    for (const Degrees& f : {Degrees{-179.975, 89.975, 0.05, 7200, 200},
                             {-180, 90, 0.1, 3601, 151},
                             {0.05, 90, 0.1, 3600, 151},
                             {-179.95, -79.95, 0.1, 3600, 101},
                             {0.05, -60.05, 0.1, 3600, 300},
                             {-90, 89.95, 0.1, 1800, 100}}) { // half a cap
        if (!full_rounds() && f.west != -180 && f.west != -90) continue;
        check(read_dem(written(f, dir / "a.tif"), {}), f);
    }
}

TEST_CASE("of a whole globe a part in degrees is reprojected, wherever its longitudes begin") {
    const TempDir dir;
    ReadOptions o;
    // Steps are rounded in files: those of the third go round a little more than once.
    for (const auto& [west, step] : {std::pair{-180.0, 0.25}, {0.0, 0.25}, {0.0, 0.250001}}) {
        const Degrees f{west + 0.125, 89.875, step, 1440, 719};
        const std::string path = written(f, dir / "a.tif");
        o.bbox = {{10, 20, 50, 50}};
        check(read_dem(path, o), f);
        o.bbox = {{-150, 20, -110, 50}};
        check(read_dem(path, o), f);
        o.bbox = {{370, 20, 410, 50}}; // the same, by another name
        CHECK(read_dem(path, o).columns > 100);
        for (const auto& [box, code, words] :
             {std::tuple{std::array<double, 4>{10, 50, 50, 20}, 2, "SOUTH 50 is not less than NORTH 20"},
              {std::array<double, 4>{-100, -20, 100, 50}, 1, "--bbox spans 200 x 70 degrees"},
              {std::array<double, 4>{0, 4e6, 1e6, 5e6}, 1, "give --bbox in degrees"}}) {
            o.bbox = box;
            const Refusal answer = refused(path, o);
            INFO(answer.line);
            CHECK(answer.code == code);
            CHECK(answer.says(words));
        }
    }
    // A square grid in degrees has an edge, which no box goes across; reprojected it does.
    const Degrees globe{-179.75, 89.75, 0.5, 720, 359};
    const std::string all = written(globe, dir / "c.tif");
    for (const auto& box : {std::array<double, 4>{160, -35, -160, 35}, {160, -35, 200, 35}, {-200, -35, -160, 35}}) {
        o = {};
        o.bbox = box;
        check(read_dem(all, o), globe);
        o.spacing_m = 5000;
        check_refusal(refused(all, o), 1, all, {"across -180", "leave out --spacing to"});
        o.crs = "none";
        check_refusal(refused(all, o), 1, all, {"leave out --spacing and --crs none to reproject it"});
    }
    o.bbox = {{-200, -10, 200, 10}}; // all longitudes
    CHECK(read_dem(all, o).columns == 720);
    o = {};
    Degrees half{-90, 45, 1, 200, 80};
    o.bbox = {{120, 20, 150, 40}};
    const std::string path = written(half, dir / "b.tif");
    check_refusal(refused(path, o), 1, path, {"lies outside of it", "degrees"});
}

TEST_CASE("the globe of another body is refused with what that body needs, and that works") {
    const TempDir dir;
    Raster r = raster(72, 36, [](int x, int y) { return slope(x, y); });
    r.geotransform = {-180, 5, 0, 90, 0, -5};
    struct Body {
        const char *degrees, *plane;
    };
    for (const Body& body :
         {Body{"+proj=longlat +a=3396190 +b=3376200 +no_defs", "+proj=eqc +a=3396190 +b=3376200 +units=m"},
          {"+proj=longlat +R=1737400 +no_defs", "+proj=eqc +R=1737400 +units=m"}}) {
        r.crs = body.degrees;
        const std::string path = write(r, dir / "a.tif");
        const Refusal answer = refused(path);
        check_refusal(answer, 1, path, {"--bbox", "in degrees", std::string("--crs \"") + body.plane + '"'});
        for (const char* earth : {"EPSG", "gdalwarp"}) CHECK(!answer.says(earth));
        ReadOptions o;
        o.crs = body.plane;
        const Dem all = read_dem(path, o);
        CHECK(all.columns >= 72);
        CHECK(all.columns <= 75);
        r.geotransform[0] = 0; // the map is cut in the middle of the file
        CHECK(read_dem(write(r, dir / "b.tif"), o).columns == all.columns);
        r.geotransform[0] = -180;
        ReadOptions part;
        part.bbox = {{10, 20, 50, 50}};
        const Dem region = read_dem(path, part);
        CHECK(region.columns >= 6);
        CHECK(region.crs_wkt.find(body.plane[11] == 'a' ? "3396190" : "1737400") != std::string::npos);
    }
}
