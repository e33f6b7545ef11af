// Several files that make one height field.
#include <filesystem>

#include "source_check.h"

using namespace fjell::baker;
using namespace fjell::test;

namespace {

// Samples [x, x + columns) by [y, y + rows) of the slope.
Raster piece(int x, int y, int columns, int rows) {
    Raster r = raster(columns, rows, [=](int i, int j) { return slope(x + i, y + j); });
    r.geotransform = {995 + 10.0 * x, 10, 0, 2005 - 10.0 * y, 0, -10};
    r.crs = "EPSG:32632";
    return r;
}
Refusal refused_all(const std::vector<std::string>& paths) {
    return refusal([&] { (void)read_dem(paths, {}); });
}

} // namespace

TEST_CASE("files side by side, in any order and direction, read as one") {
    const TempDir dir;
    Raster west = piece(0, 0, 130, 100), south = piece(0, 100, 200, 80);
    Raster east = raster(70, 100, [](int x, int y) { return slope(199 - x, 99 - y); }); // the other way round
    east.geotransform = {995 + 2000, -10, 0, 2005 - 1000, 0, 10};
    east.crs = "EPSG:32632";
    west.type = GDT_Int16;
    const std::string w = write(west, dir / "w.tif"), e = write(east, dir / "e.tif"), s = write(south, dir / "s.tif");
    const Dem dem = read_dem({s, e, w}, {});
    check_slope(dem, 200, 180);
    CHECK(dem.voids.empty());
    CHECK(dem.crs_origin[0] == 1000);
    CHECK(dem.crs_origin[1] == 2000);
    CHECK(dem.native_quantum_m == 1);
    check_windows(*open_source({s, e, w}, {}));
}

TEST_CASE("where files overlap the later one is on top, but for its voids, and gaps are holes") {
    const TempDir dir;
    Raster below = piece(0, 0, 120, 100), above = piece(70, 80, 120, 100);
    for (double& v : above.values) v += 1000;
    above.values[5 * 120 + 7] = -1;   // at (77, 85), over the other file
    above.values[90 * 120 + 90] = -1; // at (160, 170), over nothing
    tag(above, -1);
    tag(below, -9999);
    below.values[0] = -1; // a height: the other file's tag is not this one's
    const std::vector<std::string> paths{write(below, dir / "a.tif"), write(above, dir / "b.tif")};
    const Dem dem = read_dem(paths, {});
    REQUIRE(dem.columns == 190);
    REQUIRE(dem.rows == 180);
    int wrong = 0;
    for (int y = 0; y < 180; ++y)
        for (int x = 0; x < 190; ++x) {
            const bool in_above = x >= 70 && y >= 80 && !(x == 77 && y == 85) && !(x == 160 && y == 170);
            const bool in_below = x < 120 && y < 100;
            wrong += dem.is_void(x, y) != (!in_above && !in_below);
            if (!dem.is_void(x, y) && (x || y))
                wrong += dem.at(x, y) != static_cast<float>(slope(x, y) + (in_above ? 1000 : 0));
        }
    CHECK(wrong == 0);
    CHECK(dem.at(0, 0) == -1);
    check_windows(*open_source(paths, {}));
}

TEST_CASE("files that do not fit together are refused, naming both and the command that helps") {
    const TempDir dir;
    const std::string a = write(piece(0, 0, 50, 40), dir / "a.tif");
    Raster b = piece(50, 0, 50, 40);
    b.crs = "EPSG:32633";
    check_refusal(refused_all({a, write(b, dir / "b.tif")}), 1, dir / "b.tif",
                  {"another CRS than", a, "gdalwarp -t_srs"});
    b = piece(50, 0, 50, 40);
    b.geotransform[1] = 20;
    check_refusal(refused_all({a, write(b, dir / "c.tif")}), 1, dir / "c.tif",
                  {"samples are 20 apart", a, "-tr 10 10"});
    b = piece(50, 0, 50, 40);
    b.geotransform[0] += 4;
    check_refusal(refused_all({a, write(b, dir / "d.tif")}), 1, dir / "d.tif", {"lie between those of", a, "gdalwarp"});
    b.geotransform.clear();
    check_refusal(refused_all({a, write(b, dir / "e.tif")}), 1, dir / "e.tif", {"has no georeference", a});
    CHECK(refused_all({a, dir / "missing.tif"}).says("no such file"));
    CHECK(refused_all({}).code == 2);
}

TEST_CASE("more files than a reader keeps open are read all the same") {
    const TempDir dir;
    std::vector<std::string> paths;
    for (int i = 0; i < 49; ++i) {
        const std::string number = std::to_string(i);
        paths.push_back(write(piece(i % 7 * 64, i / 7 * 64, 65, 65), (dir / number).append(".tif")));
    }
    check_slope(read_dem(paths, {}), 449, 449);
}

TEST_CASE("a VRT is read, and one whose file is gone is refused in one line") {
    const TempDir dir;
    const std::string path = write(piece(0, 0, 60, 50), dir / "a.tif");
    write_text(dir / "a.vrt", "<VRTDataset rasterXSize=\"60\" rasterYSize=\"50\"><GeoTransform>995,10,0,2005,0,-10"
                              "</GeoTransform><VRTRasterBand dataType=\"Float32\" band=\"1\"><SimpleSource>"
                              "<SourceFilename relativeToVRT=\"1\">a.tif</SourceFilename><SourceBand>1</SourceBand>"
                              "</SimpleSource></VRTRasterBand></VRTDataset>");
    check_slope(read_dem(dir / "a.vrt", {}), 60, 50);
    check_windows(*open_source({dir / "a.vrt"}, {}));
    std::filesystem::remove(path);
    check_refusal(refused(dir / "a.vrt"), 1, dir / "a.vrt", {"missing or damaged", "a.tif", "gdalbuildvrt"});
}
