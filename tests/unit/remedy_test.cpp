// What a refusal tells the user to do is done here, as the line has it, and gives the right ground.
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "read_support.h"
#include "support/program.h"

using namespace fjell::baker;
using namespace fjell::test;

namespace {

struct Place {
    double x, y;
};

// The command of a line, whose output is OUT.tif, run in the folder.
std::string do_it(const TempDir& dir, const Refusal& refusal, const std::string& program) {
    const std::size_t from = refusal.line.find(program + " "), end = refusal.line.find(" OUT.tif", from);
    INFO(refusal.line);
    REQUIRE(from != std::string::npos);
    REQUIRE(end != std::string::npos);
    std::filesystem::remove(dir / "OUT.tif");
    const Run r = run_in(dir.path, refusal.line.substr(from, end - from) + " OUT.tif");
    INFO(r.err);
    REQUIRE(r.code == 0);
    return dir / "OUT.tif";
}

} // namespace

TEST_CASE(
    "heights that are turned, or placed by control points or arrays of coordinates, are refused with the gdalwarp "
    "that makes a grid of them") {
    constexpr int columns = 60, rows = 40;
    struct Case {
        const char* what;
        std::string crs;
        std::function<Place(double, double)> at; // of a pixel and a line
        std::string says;
        int bent_m = 0; // every other point
        bool turned = false, arrays = false;
    };
    const auto quarter = [](double pixel, double line) { return Place{500'000 + 30 * line, 5e6 + 30 * pixel}; };
    const auto degrees = [](double pixel, double line) { return Place{15 + pixel / 1200, 47 - line / 1200}; };
    const auto turned = [](double pixel, double line) {
        return Place{500'000 + 30 * pixel + 6 * line, 5e6 + 6 * pixel - 30 * line};
    };
    for (const Case& c : {Case{"a quarter round", "EPSG:32633", quarter, "control points"},
                          {"in degrees", "EPSG:4326", degrees, "control points"},
                          {"without a CRS", "", quarter, "control points"},
                          {"bent", "EPSG:32633", quarter, "-tps", 240},
                          {"turned", "EPSG:32633", turned, "rotated", 0, true},
                          {"arrays", "EPSG:4326", degrees, "-geoloc", 0, false, true}}) {
        CAPTURE(c.what);
        const TempDir dir;
        // A plane on the ground: 500 m in the middle of the first column and row, and 100 m up over 1,000 pixels'
        // length.
        const auto height = [&](Place p) {
            const Place first = c.at(0.5, 0.5), far = c.at(1000.5, 0.5), low = c.at(0.5, 1000.5);
            const double length = std::hypot(far.x - first.x, far.y - first.y),
                         down = std::hypot(low.x - first.x, low.y - first.y);
            const double along = ((p.x - first.x) * (far.x - first.x) + (p.y - first.y) * (far.y - first.y)) / length;
            const double across = ((p.x - first.x) * (low.x - first.x) + (p.y - first.y) * (low.y - first.y)) / down;
            return 500 + 1000 * along / length + 3000 * across / down;
        };
        Raster r = raster(columns, rows, [&](int x, int y) { return height(c.at(x + 0.5, y + 0.5)); });
        r.geotransform.clear();
        if (c.turned) {
            const Place o = c.at(0, 0), x = c.at(1, 0), y = c.at(0, 1);
            r.geotransform = {o.x, x.x - o.x, y.x - o.x, o.y, x.y - o.y, y.y - o.y};
            r.crs = c.crs;
        }
        r.more = [&](GDALDataset& file) {
            OGRSpatialReference crs;
            crs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
            if (!c.crs.empty()) crs.SetFromUserInput(c.crs.c_str());
            if (c.arrays) {
                Raster x = raster(columns, rows, [&](int i, int j) { return c.at(i + 0.5, j + 0.5).x; });
                Raster y = raster(columns, rows, [&](int i, int j) { return c.at(i + 0.5, j + 0.5).y; });
                x.type = y.type = GDT_Float64;
                CPLStringList words;
                words.SetNameValue("X_DATASET", write(x, dir / "x.tif").c_str());
                words.SetNameValue("Y_DATASET", write(y, dir / "y.tif").c_str());
                for (const char* const one : {"X_BAND", "Y_BAND", "PIXEL_STEP", "LINE_STEP"})
                    words.SetNameValue(one, "1");
                for (const char* const none : {"PIXEL_OFFSET", "LINE_OFFSET"}) words.SetNameValue(none, "0");
                words.SetNameValue("GEOREFERENCING_CONVENTION", "PIXEL_CENTER");
                words.SetNameValue("SRS", SRS_WKT_WGS84_LAT_LONG);
                REQUIRE(file.SetMetadata(words.List(), "GEOLOCATION") == CE_None);
            } else if (!c.turned) {
                std::vector<GDAL_GCP> points(9);
                GDALInitGCPs(9, points.data());
                for (int i = 0; i < 9; ++i) {
                    GDAL_GCP& p = points[static_cast<std::size_t>(i)];
                    p.dfGCPPixel = i % 3 * (columns / 2.0), p.dfGCPLine = i / 3 * (rows / 2.0);
                    const Place at = c.at(p.dfGCPPixel, p.dfGCPLine);
                    p.dfGCPX = at.x + i % 2 * c.bent_m, p.dfGCPY = at.y;
                }
                REQUIRE(file.SetGCPs(9, points.data(), c.crs.empty() ? nullptr : &crs) == CE_None);
                GDALDeinitGCPs(9, points.data());
            }
        };
        const std::string path = write(r, dir / "in.tif");
        const Refusal line = refused(path);
        check_refusal(line, 1, path, {c.says});
        ReadOptions options; // as they lie: degrees stay degrees
        if (c.crs == "EPSG:4326") options = spaced(90);
        if (!c.turned) {
            ReadOptions to_utm;
            to_utm.crs = "EPSG:32633";
            CHECK(refused(path, to_utm).line == line.line);
            CHECK(refusal([&] { (void)read_dem({path, path}, options); }).says(c.says));
            check_refusal(refused(path, spaced(30)), 0, "", {}); // without a place
        }
        const Dem dem = read_dem(do_it(dir, line, "gdalwarp"), options);
        int wrong = 0, there = 0;
        for (int y = 0; y < dem.rows; ++y)
            for (int x = 0; x < dem.columns; ++x) {
                if (dem.is_void(x, y)) continue;
                ++there;
                const Place p{dem.crs_origin[0] + x * dem.crs_step[0], dem.crs_origin[1] - y * dem.crs_step[1]};
                // Of bent ones the middle, through which a spline goes. Beyond the middles of the outermost pixels
                // their heights go on: half of a row and of a column.
                const Place middle = c.at(columns / 2.0, rows / 2.0);
                if (c.bent_m && std::hypot(p.x - middle.x, p.y - middle.y) > 25) continue;
                wrong += std::abs(static_cast<double>(dem.at(x, y)) - height(p)) > 1.6;
            }
        CHECK(wrong == 0);
        CHECK(there > 0.9 * columns * rows);
    }
}
