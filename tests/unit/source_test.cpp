// Height sources read by windows: the same whatever is read in whatever order.
#include <cmath>
#include <map>

#include "baker/read/decode.h"
#include "baker/read/windows.h"
#include "source_check.h"
#include "support/dem.h"

using namespace fjell::baker;
using namespace fjell::test;

namespace {

// Heights with a tag, NaN, and implausible ones, in a file of tiles or strips that runs any way.
std::string rough_file(const std::string& path, bool tiled, bool flip_x, bool flip_y) {
    register_drivers();
    char* tiles[] = {const_cast<char*>("TILED=YES"), const_cast<char*>("BLOCKXSIZE=64"),
                     const_cast<char*>("BLOCKYSIZE=32"), const_cast<char*>("COMPRESS=DEFLATE"), nullptr};
    char* strips[] = {const_cast<char*>("BLOCKYSIZE=8"), nullptr};
    auto* const file = GetGDALDriverManager()->GetDriverByName("GTiff")->Create(path.c_str(), 301, 203, 1, GDT_Float32,
                                                                                tiled ? tiles : strips);
    double t[6] = {1000, flip_x ? -10.0 : 10.0, 0, 2000, 0, flip_y ? 10.0 : -10.0};
    file->SetGeoTransform(t);
    file->GetRasterBand(1)->SetNoDataValue(-9999);
    std::vector<float> values;
    for (int i = 0; i < 301 * 203; ++i) {
        const int h = i * 7919 % 10007;
        values.push_back(h % 311 == 0 ? -9999.0f : h % 509 == 0 ? NAN : h == 77 ? 1e30f : static_cast<float>(h / 10.0));
    }
    REQUIRE(file->GetRasterBand(1)->RasterIO(GF_Write, 0, 0, 301, 203, values.data(), 301, 203, GDT_Float32, 0, 0,
                                             nullptr) == CE_None);
    GDALClose(file);
    return path;
}

} // namespace

TEST_CASE("windows cover an area once, keep to blocks and to the size asked for") {
    std::mt19937 random(3);
    const auto up_to = [&](int n) { return 1 + static_cast<std::int32_t>(random() % static_cast<unsigned>(n)); };
    for (int round = 0; round < 300; ++round) {
        const Window area{up_to(50) - 1, up_to(50) - 1, up_to(90), up_to(90)};
        Blocks blocks{up_to(120), up_to(40), 0, 0};
        blocks.x = up_to(blocks.columns) - 1;
        blocks.y = up_to(blocks.rows) - 1;
        const std::size_t most = static_cast<std::size_t>(up_to(4000));
        std::map<std::pair<int, int>, int> seen;
        const bool whole_blocks =
            blocks.columns < area.columns || static_cast<std::size_t>(area.columns * blocks.rows) <= most;
        for (const Window& w : cut_along(area, blocks, most)) {
            for (int y = w.y; y < w.y + w.rows; ++y)
                for (int x = w.x; x < w.x + w.columns; ++x) ++seen[{x, y}];
            const auto least = static_cast<std::size_t>(std::max(area.columns, blocks.columns * blocks.rows));
            CHECK(w.area() <= std::max(most, least));
            const auto border = [](int at, int first, int size) { return ((at - first) % size + size) % size == 0; };
            if (whole_blocks) CHECK((w.y == area.y || border(w.y, blocks.y, blocks.rows)));
            CHECK((w.x == area.x || border(w.x, blocks.x, blocks.columns)));
        }
        REQUIRE(seen.size() == area.area());
        for (const auto& [place, times] : seen) REQUIRE(times == 1);
    }
}

TEST_CASE("any windows in any order give the heights and the statistics of one read") {
    const TempDir dir;
    for (const bool tiled : {false, true})
        for (const bool flip_x : {false, true})
            for (const bool flip_y : {false, true}) {
                INFO("tiled " << tiled << ", flip_x " << flip_x << ", flip_y " << flip_y);
                const auto source = open_source({rough_file(dir / "a.tif", tiled, flip_x, flip_y)}, with(NoData::hole));
                check_windows(*source);
                const Field whole = read_whole(*source);
                CHECK(whole.statistics.per_unit == 10);
                CHECK(whole.statistics.implausible.count > 0);
                CHECK(whole.statistics.implausible_m == 1e30f);
                CHECK(source->properties(whole.statistics).holes);
                CHECK(source->readers(4) == 4);
            }
}

TEST_CASE("a chunk decoded at once is what its samples give one by one") {
    std::mt19937 random(5);
    for (const bool scaled : {false, true})
        for (const int kind : {0, 1, 2}) {
            Decoding d;
            if (scaled) d.scaling = {0.25, 12, -1.5, 3};
            std::vector<float> raw(5000);
            for (float& v : raw)
                v = static_cast<float>(static_cast<int>(random() % 20000) - 5000) * (kind == 2 ? 0.013f : 1.0f);
            if (kind == 1)
                for (std::size_t i = 0; i < raw.size(); i += 700) raw[i] = i % 1400 ? NAN : 1e9f;
            std::vector<float> at_once(raw.size()), single(raw.size());
            ReadStatistics one, other;
            decode_row(raw.data(), nullptr, at_once.data(), raw.size(), d, {}, one);
            const std::uint8_t invalid = 0, valid = 255;
            // A row of two, one of them void, is decoded one by one.
            for (std::size_t i = 0; i < raw.size(); ++i) {
                const float pair[2] = {raw[i], 0};
                const std::uint8_t marks[2] = {valid, invalid};
                float to[2];
                decode_row(pair, marks, to, 2, d, {static_cast<std::int32_t>(i), 0, 1}, other);
                single[i] = to[0];
            }
            other.voids.count -= raw.size();
            CHECK(std::memcmp(at_once.data(), single.data(), raw.size() * 4) == 0);
            CHECK(one.least_m == other.least_m);
            CHECK(one.most_m == other.most_m);
            CHECK(one.per_unit == other.per_unit);
            CHECK(one.per_unit == (kind == 2 ? 1000 : 1));
            CHECK(one.implausible.count == other.implausible.count);
            CHECK(one.voids.count == other.voids.count);
            CHECK((one.implausible.count > 0) == (kind == 1));
        }
}

TEST_CASE("a Dem is a source whose voids have no height") {
    Dem dem;
    dem.columns = 40;
    dem.rows = 30;
    dem.native_quantum_m = 1;
    for (int i = 0; i < 1200; ++i) dem.heights_m.push_back(static_cast<float>(i % 97));
    dem.voids.resize(1200);
    dem.voids[77] = 1;
    const DemSource source(dem);
    check_windows(source);
    const Field whole = read_whole(source);
    CHECK(std::isnan(whole.heights_m[77]));
    CHECK(whole.heights_m[78] == 78);
    const SourceProperties properties = source.properties(whole.statistics);
    CHECK(properties.holes);
    CHECK(properties.native_quantum_m == 1);
    Dem other = dem;
    other.heights_m[5] += 1;
    CHECK(DemSource(other).identity() != source.identity());
    CHECK(DemSource(dem).identity() == source.identity());
    std::fill(dem.voids.begin(), dem.voids.end(), std::uint8_t{1});
    const DemSource nothing(dem);
    CHECK(refusal([&] { (void)nothing.properties(read_whole(nothing).statistics); }).code == 1);
}

TEST_CASE("a box keeps the samples inside it, at their place, both ends included") {
    const TempDir dir;
    for (const bool flip : {false, true}) {
        Raster r = raster(20, 15, [=](int x, int y) { return slope(x, flip ? 14 - y : y); });
        if (flip) r.geotransform = {995, 10, 0, 2005 - 150, 0, 10};
        const std::string path = write(r, dir / "a.tif");
        ReadOptions o;
        o.bbox = {{1020, 1900, 1059, 1955}}; // samples stand at 1000 + 10 x, 2000 - 10 y
        const Dem dem = read_dem(path, o);
        CHECK(dem.columns == 4);
        CHECK(dem.rows == 6);
        CHECK(dem.crs_origin[0] == 1020);
        CHECK(dem.crs_origin[1] == 1950);
        CHECK(dem.at(0, 0) == slope(2, 5));
        CHECK(dem.at(3, 5) == slope(5, 10));
        check_windows(*open_source({path}, o));
        o.bbox = {{0, 0, 900, 900}};
        check_refusal(refused(path, o), 1, path, {"--bbox 0,0,900,900 lies outside", "1000,1860,1190,2000"});
        o.bbox = {{1020, 1900, 1025, 1955}};
        check_refusal(refused(path, o), 1, path, {"fewer than 2 x 2"});
        o.bbox = {{1059, 1900, 1020, 1955}};
        CHECK(refused(path, o).code == 2);
        o.bbox = {{1020, 1955, 1059, 1900}};
        CHECK(refused(path, o).code == 2);
    }
}

TEST_CASE("a box of a picture counts columns and rows from the north-west") {
    const TempDir dir;
    Raster r = raster(20, 15, slope);
    r.geotransform.clear();
    r.type = GDT_Byte;
    const std::string path = write(r, dir / "a.png", "PNG");
    ReadOptions o = spaced(60);
    o.bbox = {{3, 9, 7, 4}};
    const Dem dem = read_dem(path, o);
    CHECK(dem.columns == 5);
    CHECK(dem.rows == 6);
    CHECK(dem.at(0, 0) == slope(3, 4));
    CHECK(open_source({path}, o)->readers(4) == 1);
}

TEST_CASE("a source knows itself by its files and its options") {
    const TempDir dir;
    const std::string path = write(raster(20, 15, slope), dir / "a.tif");
    const std::string before = open_source({path}, {})->identity();
    CHECK(open_source({path}, {})->identity() == before);
    CHECK(open_source({path}, spaced(5))->identity() != before);
    write(raster(20, 16, slope), path);
    CHECK(open_source({path}, {})->identity() != before);
}
