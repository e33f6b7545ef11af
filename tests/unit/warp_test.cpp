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
