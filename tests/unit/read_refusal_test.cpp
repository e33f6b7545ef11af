#include <algorithm>
#include <cmath>
#include <limits>

#include "read_support.h"

using namespace fjell::baker;
using namespace fjell::test;

TEST_CASE("what only looks like degrees is refused until a spacing settles it, as degrees are without reprojection") {
    const TempDir dir;
    Raster r = raster(20, 15, slope);
    r.geotransform = {8, 0.01, 0, 61, 0, -0.01};
    const std::string path = write(r, dir / "a.tif");
    check_refusal(refused(path), 1, path, {"looks as if it is in degrees; give --spacing M", "-a_srs EPSG:4326"});
    CHECK(read_dem(path, spaced(90)).spacing_m[1] == 90);
    const std::string grid = write(r, dir / "a.asc", "AAIGrid");
    check_refusal(refused(grid), 1, grid, {"in degrees"});
    r.crs = "EPSG:4326";
    const std::string named = write(r, dir / "b.tif");
    ReadOptions none;
    none.crs = "none";
    check_refusal(refused(named, none), 1, named, {"is in degrees; give --spacing M (metres between samples)"});
    CHECK(read_dem(named, spaced(90)).spacing_m[1] == 90);
    r.crs = "EPSG:4807"; // NTF (Paris)
    const std::string grads = write(r, dir / "c.tif");
    check_refusal(refused(grads, none), 1, grads, {"is in grads; give --spacing M"});
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

TEST_CASE("rasters too small are refused") {
    const TempDir dir;
    for (const auto& [columns, rows] : {std::pair{1, 1}, {1, 5}, {5, 1}}) {
        const std::string path = write(raster(columns, rows, slope), dir / "a.tif");
        check_refusal(refused(path), 1, path, {"at least 2 x 2"});
    }
    check_slope(read_dem(write(raster(2, 2, slope), dir / "b.tif"), {}), 2, 2);
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
    check_slope(read_dem(write(r, dir / "grey.png", "PNG"), spaced(60)), 8, 8); // grey heights that were saved as one
    r.more = [](GDALDataset& file) {                                            // but for one sample
        std::uint8_t other = 1;
        REQUIRE(file.GetRasterBand(3)->RasterIO(GF_Write, 7, 7, 1, 1, &other, 1, 1, GDT_Byte, 0, 0, nullptr) ==
                CE_None);
    };
    const std::string path = write(r, dir / "a.png", "PNG");
    check_refusal(refused(path, spaced(60)), 1, path, {"3 bands", "--encoding terrarium or terrain-rgb", "first"});
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
    check_refusal(refused(palette, spaced(60)), 1, palette,
                  {"palette", "--encoding terrarium or terrain-rgb", "gdal_translate -expand gray"});
}
