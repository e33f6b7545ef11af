// Heights packed into colours.
#include <cmath>

#include "source_check.h"

using namespace fjell::baker;
using namespace fjell::test;

namespace {

// A picture of 24-bit numbers, fully opaque but where there is none (-1).
std::string picture(const std::string& path, int columns, int rows, const std::function<int(int, int)>& packed) {
    register_drivers();
    GDALDataset* const file =
        GetGDALDriverManager()->GetDriverByName("MEM")->Create("", columns, rows, 4, GDT_Byte, nullptr);
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns; ++x) {
            const int v = packed(x, y);
            int parts[4] = {v >> 16 & 255, v >> 8 & 255, v & 255, 255};
            if (v < 0) std::fill_n(parts, 4, 0);
            for (int b = 0; b < 4; ++b)
                REQUIRE(file->GetRasterBand(b + 1)->RasterIO(GF_Write, x, y, 1, 1, &parts[b], 1, 1, GDT_Int32, 0, 0,
                                                             nullptr) == CE_None);
        }
    file->GetRasterBand(4)->SetColorInterpretation(GCI_AlphaBand);
    GDALClose(GetGDALDriverManager()->GetDriverByName("PNG")->CreateCopy(path.c_str(), file, FALSE, nullptr, nullptr,
                                                                         nullptr));
    GDALClose(file);
    return path;
}

} // namespace

TEST_CASE("Terrarium and Terrain-RGB pictures are heights, and holes where they are transparent") {
    const TempDir dir;
    const auto height = [](int x, int y) { return -400 + 37 * x + 3 * y; };
    const auto hole = [](int x, int y) { return x == 5 && y == 7; };
    ReadOptions o = spaced(30);
    o.encoding = Encoding::terrarium;
    const std::string terrarium = picture(
        dir / "t.png", 40, 30, [&](int x, int y) { return hole(x, y) ? -1 : (height(x, y) + 32768) * 256 + x; });
    const Dem t = read_dem(terrarium, o);
    const std::string mapbox = picture(
        dir / "m.png", 40, 30, [&](int x, int y) { return hole(x, y) ? -1 : (height(x, y) + 10000) * 10 + x % 10; });
    o.encoding = Encoding::terrain_rgb;
    const Dem m = read_dem(mapbox, o);
    CHECK(t.native_quantum_m == 1.0 / 256);
    CHECK(m.native_quantum_m == 0.1);
    CHECK(void_count(t) == 1);
    CHECK(void_count(m) == 1);
    int wrong = 0;
    for (int y = 0; y < 30; ++y)
        for (int x = 0; x < 40; ++x) {
            if (hole(x, y)) continue;
            wrong += t.at(x, y) != static_cast<float>(height(x, y) + x / 256.0);
            wrong += m.at(x, y) != static_cast<float>((height(x, y) * 10 + x % 10) / 10.0);
        }
    CHECK(wrong == 0);
    CHECK(t.is_void(5, 7));
    check_windows(*open_source({mapbox}, o));
    check_refusal(refused(terrarium, spaced(30)), 1, terrarium, {"4 bands of colour", "--encoding terrarium"});
    const std::string grey = write(raster(9, 9, slope), dir / "g.tif");
    check_refusal(refused(grey, o), 1, grey, {"1 bands of Float32", "--encoding"});
}

TEST_CASE("a real Terrarium picture is decoded to its heights") {
    const std::string path = data_file("formats/terrarium_256.png");
    if (path.empty()) return;
    ReadOptions o = spaced(100);
    o.encoding = Encoding::terrarium;
    const Dem dem = read_dem(path, o);
    const auto [least, most] = std::minmax_element(dem.heights_m.begin(), dem.heights_m.end());
    CHECK(*least == Approx(715).margin(1));
    CHECK(*most == Approx(2489).margin(1));
    CHECK(dem.voids.empty());
}
