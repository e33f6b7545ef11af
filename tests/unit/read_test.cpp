#include <algorithm>
#include <cmath>
#include <limits>

#include "baker/synth/write_dem.h"
#include "read_support.h"

using namespace fjell::baker;
using namespace fjell::test;

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
        CHECK(dem.crs_origin[1] == Approx(2000));
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
    CHECK(dem.crs_origin[0] == 1000);
    CHECK(dem.crs_origin[1] == 2000);
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
    CHECK(dem.crs_origin[0] == 1000);
    CHECK(dem.crs_origin[1] == 2000);
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
        CHECK(back.crs_origin[0] == 0);
        CHECK(back.native_quantum_m == 0.1);
        CHECK(back.crs_wkt.empty());
    }
    const Refusal lost = refusal([&] { write_dem(dem, dir / "missing/a.tif"); });
    check_refusal(lost, 1, dir / "missing", {});
}

TEST_CASE("axes that a netCDF file calls longitudes are degrees, with units or without") {
    const TempDir dir;
    for (const char* entry : {"lon#units=degrees_east", "x#long_name=longitude", "lon#standard_name=longitude",
                              "x#long_name=Longitude [degrees_east]"}) {
        CAPTURE(entry);
        Raster r = raster(40, 30, slope);
        r.geotransform = {-30, 1.0 / 60, 0, 35, 0, -1.0 / 60};
        r.more = [=](GDALDataset& file) {
            const std::string text = entry;
            const auto at = text.find('=');
            file.SetMetadataItem(text.substr(0, at).c_str(), text.substr(at + 1).c_str());
        };
        CHECK(!read_dem(write(r, dir / "a.tif"), {}).crs_wkt.empty());
    }
}

TEST_CASE("depths are not taken for heights, until the user says which they are") {
    const TempDir dir;
    for (const auto& [key, value] : {std::pair{"positive", "down"}, {"standard_name", "sea_floor_depth_below_geoid"}}) {
        Raster r = raster(9, 9, slope);
        r.more = [&, key = key, value = value](GDALDataset& file) {
            file.GetRasterBand(1)->SetMetadataItem(key, value);
        };
        const std::string path = write(r, dir / "a.tif");
        check_refusal(refused(path), 1, path, {"depths", "--zscale -1", "--zscale 1 "});
        ReadOptions o;
        o.zscale = -1;
        CHECK(read_dem(path, o).at(3, 4) == -static_cast<float>(slope(3, 4)));
        o.zscale = 1;
        CHECK(read_dem(path, o).at(3, 4) == static_cast<float>(slope(3, 4)));
    }
}
