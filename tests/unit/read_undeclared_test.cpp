// Numbers that stand for no height without the file saying so, and ground that looks a little like them.
#include <algorithm>
#include <cmath>
#include <random>

#include "source_check.h"
#include "support/rounds.h"

using namespace fjell::baker;
using namespace fjell::test;

namespace {

ReadOptions voids(const std::vector<double>& numbers, NoData nodata = NoData::automatic) {
    ReadOptions o = with(nodata);
    o.voids.numbers = numbers;
    return o;
}
ReadOptions all_ground() {
    ReadOptions o;
    o.voids.no_others = true;
    return o;
}

// 0..229 m, and a basin's outside of 799 samples.
Raster basin(double nothing) {
    return raster(80, 62, [=](int x, int y) {
        const int at = y * 80 + x;
        return at >= 161 && at < 960 ? nothing : std::floor(115 + 115 * std::sin(x * 0.13) * std::cos(y * 0.09));
    });
}

// A sea floor from 0 down to deep, every metre of it.
Raster sea_floor(double deep, const std::function<bool(int)>& marked, double marker) {
    return raster(200, 150, [=](int x, int y) {
        const int at = y * 200 + x;
        return marked(at) ? marker : std::round(deep * (at * 7919 % 30000) / 30000);
    });
}

SourceProperties properties_of(const std::string& path, const ReadOptions& options = {}) {
    const auto source = open_source({path}, options);
    return source->properties(read_whole(*source).statistics);
}

// Adds a file to the folder and reads it as it is.
struct Baked {
    TempDir dir;
    int files = 0;
    std::string path(const Raster& r) { return write(r, dir / (std::to_string(files++) + ".tif")); }
    void is_ground(const Raster& r) {
        const Refusal answer = refused(path(r));
        INFO(answer.line);
        CHECK(answer.code == 0);
    }
};

} // namespace

TEST_CASE("numbers that look like voids are refused with count and place, until the user says what they are") {
    Baked b;
    const std::string path = b.path(basin(-9999));
    for (const NoData nodata : every_nodata)
        check_refusal(refused(path, with(nodata)), 1, path,
                      {"799 of 4960 heights are -9999", "the first at column 1, row 2", "lie from 0 to 229;",
                       "give --void -9999 ", "--nodata fill", "--void none"});
    const Dem dem = read_dem(path, voids({-9999}));
    CHECK(void_count(dem) == 799);
    CHECK(dem.is_void(1, 2));
    CHECK(*std::min_element(dem.heights_m.begin(), dem.heights_m.end()) >= 0);
    CHECK(void_count(read_dem(path, voids({-9999}, NoData::fill))) == 0);
    check_refusal(refused(path, voids({-9999}, NoData::refuse)), 1, path, {"799 of 4960 samples are no-data"});
    CHECK(read_dem(path, all_ground()).at(1, 2) == -9999);
    for (const double nothing : {-9999.0, -999.0, -2000.5, 7777.0, -10000.0, 9999.0}) {
        CAPTURE(nothing);
        const std::string other = b.path(basin(nothing));
        check_refusal(refused(other), 1, other, {"--void " + number_text(nothing) + " "});
        CHECK(void_count(read_dem(other, voids({nothing}))) == 799);
    }
    for (const double nothing : {-32768.0, -32767.0, 1e20, 3.4e38, -3.4028234663852886e38}) { // implausible
        CAPTURE(nothing);
        const std::string other = b.path(basin(nothing));
        check_refusal(refused(other), 1, other, {"799 of 4960 heights lie outside"});
        CHECK(void_count(read_dem(other, voids({nothing}))) == 799);
    }
}

TEST_CASE("several numbers that look like voids are named at once, and one marker is enough") {
    Baked b;
    Raster r = basin(-9999);
    for (std::size_t i = 0; i < r.values.size(); i += 97)
        if (r.values[i] != -9999) r.values[i] = -999;
    const auto count = std::count(r.values.begin(), r.values.end(), -999);
    r.values[4000] = 9999;
    const std::string path = b.path(r);
    check_refusal(refused(path), 1, path,
                  {"799 of 4960 heights are -9999", std::to_string(count) + " of 4960 heights are -999",
                   "1 of 4960 heights are 9999, the first at column 0, row 50",
                   "--void -9999 --void -999 --void 9999"});
    check_refusal(refused(path, voids({-999, 9999})), 1, path, {"--void -9999 "});
    CHECK(void_count(read_dem(path, voids({-9999, 9999, -999}))) == 799 + static_cast<std::uint64_t>(count) + 1);
    const std::string nothing_else = b.path(raster(9, 9, [](int, int) { return -9999; }));
    check_refusal(refused(nothing_else), 1, nothing_else, {"81 of 81 heights are -9999"});
    const std::string flat = b.path(raster(9, 9, [](int x, int) { return x == 4 ? -9999 : 3; }));
    check_refusal(refused(flat), 1, flat, {"9 of 81 heights are -9999", "from 3 to 3"});
}

TEST_CASE("ground is not taken for voids: flat, terraced, stepped, deep, with spires and shafts") {
    Baked b;
    for (const double flat : {0.0, 5.5, -400.0, 8000.0}) b.is_ground(raster(30, 20, [=](int, int) { return flat; }));
    b.is_ground(raster(30, 20, [](int x, int) { return x < 15 ? 0 : 100; }));               // a cliff
    b.is_ground(raster(30, 20, [](int x, int) { return x < 9 ? 0 : x < 18 ? 10 : 1000; })); // terraces
    b.is_ground(raster(30, 20, [](int x, int) { return x < 15 ? -999 : -1000; }));          // a step at a marker
    b.is_ground(raster(30, 20, slope));                                                     // a ramp
    b.is_ground(raster(60, 60, [](int x, int y) { return x == 7 && y == 9 ? 2000 : slope(x, y); })); // a spire
    b.is_ground(raster(60, 60, [](int x, int y) { return std::max(0.0, slope(x, y) - 250); }));      // a coast
    b.is_ground(
        raster(60, 60, [](int x, int y) { return x < 5 ? 0 : 1500 + slope(x, y) * 5; }));     // sea beside mountains
    Raster counts = raster(60, 60, [](int x, int y) { return std::min(65535, x * y * 20); }); // a saturated height map
    counts.type = GDT_UInt16;
    ReadOptions tenth;
    tenth.zscale = 0.01;
    CHECK(refused(b.path(counts), tenth).code == 0);
    // Depths about a marker, and a few samples exactly there.
    for (const double marker : {-9999.0, -999.0}) {
        const double deep = marker - 901;
        b.is_ground(sea_floor(
            deep, [](int at) { return at == 7 || at == 1000; }, marker));
        b.is_ground(sea_floor(
            marker, [](int) { return false; }, 0)); // the deepest is the marker
        const std::string many = b.path(sea_floor(
            deep, [](int at) { return at % 50 == 3; }, marker));
        check_refusal(refused(many), 1, many, {" of 30000 heights are", "--void " + number_text(marker) + " "});
    }
}

TEST_CASE("a height that many samples share may be water: it is ground, and said") {
    Baked b;
    const std::string coast = b.path(raster(60, 60, [](int x, int y) { return std::max(0.0, slope(x, y) - 250); }));
    SourceProperties s = properties_of(coast);
    CHECK(s.lowest.number == 0);
    CHECK(s.lowest.share > 0.1);
    CHECK(s.lowest.column == 0);
    CHECK(s.lowest.row == 0);
    CHECK(s.highest.share == 0);
    ReadOptions o;
    o.zscale = -2;
    o.zoffset_m = 5;
    s = properties_of(b.path(raster(60, 60, [](int x, int y) { return x < 5 ? 10 : 1500 + slope(x, y) * 5; })), o);
    CHECK(s.lowest.number == 10);
    CHECK(s.lowest.height_m == -15);
    CHECK(s.lowest.share == Approx(5.0 / 60));
    s = properties_of(b.path(raster(60, 60, slope)));
    CHECK(s.lowest.share == 0);
    CHECK(s.highest.share == 0);
    CHECK(properties_of(coast, voids({0})).lowest.share == 0);
}

TEST_CASE("--void names numbers as the file has them: before its scale, in its own type, whichever way it runs") {
    Baked b;
    Raster scaled = basin(-999);
    scaled.type = GDT_Int16;
    scaled.more = [](GDALDataset& file) {
        file.GetRasterBand(1)->SetScale(0.1);
        file.GetRasterBand(1)->SetOffset(100);
    };
    const std::string path = b.path(scaled);
    check_refusal(refused(path), 1, path, {"799 of 4960 heights are -999, ", "as the file has them", "--void -999 "});
    ReadOptions o = voids({-999});
    o.zscale = 3;
    CHECK(void_count(read_dem(path, o)) == 799);
    Raster rounded = basin(0.1); // a float is named by its shortest text
    CHECK(void_count(read_dem(b.path(rounded), voids({0.1}))) == 799);
    rounded.type = GDT_Float64;
    CHECK(void_count(read_dem(b.path(rounded), voids({0.1}))) == 799);
    Raster flipped = basin(-9999);
    flipped.geotransform = {1000, -10, 0, 2000, 0, 10};
    const std::string turned = b.path(flipped);
    check_refusal(refused(turned), 1, turned, {"799 of 4960", "column 0, row 50"}); // 161..959 from the other end
    CHECK(void_count(read_dem(turned, voids({-9999}))) == 799);
    Raster odd = basin(-9999); // all that is finite is ground, if the user says so
    odd.values[0] = 40000;
    CHECK(read_dem(b.path(odd), all_ground()).at(0, 0) == 40000);
    odd.values[0] = HUGE_VAL;
    check_refusal(refused(b.path(odd), all_ground()), 1, "tif", {"inf m at column 0, row 0"});
}

TEST_CASE("undeclared voids of a mosaic are placed in it, and what lies below shows through them") {
    const TempDir dir;
    Raster below = raster(50, 40, [](int x, int y) { return slope(x, y); });
    Raster above = raster(50, 40, [](int x, int y) { return x < 10 && y < 10 ? -9999 : slope(x, y) + 300; });
    above.geotransform = {995 + 250.0, 10, 0, 2005 - 200.0, 0, -10};
    const std::vector<std::string> paths{write(below, dir / "a.tif"), write(above, dir / "b.tif")};
    check_refusal(refusal([&] { (void)read_dem(paths, {}); }), 1, paths[0],
                  {"100 of ", "heights are -9999, the first at column 25, row 20"});
    const Dem dem = read_dem(paths, voids({-9999}));
    CHECK(dem.at(25, 20) == static_cast<float>(slope(25, 20)));
    CHECK(dem.at(40, 35) == static_cast<float>(slope(15, 15) + 300));
    check_windows(*open_source(paths, voids({-9999})));
}

TEST_CASE("undeclared voids are counted before they are reprojected, and named ones smear nothing") {
    const TempDir dir;
    const auto hole = [](int x, int y) { return x > 500 && x < 540 && y > 500 && y < 530; };
    Raster r = raster(600, 560, [&](int x, int y) { return hole(x, y) ? -9999 : slope(x, y); });
    r.geotransform = {8.2, 0.001, 0, 61, 0, -0.001};
    r.crs = "EPSG:4326";
    const std::string path = write(r, dir / "a.tif");
    check_refusal(refused(path), 1, path,
                  {"1131 of 336000 heights are -9999, the first at column 501, row 501", "--void -9999 "});
    tag(r, -9999);
    const Dem tagged = read_dem(write(r, dir / "b.tif"), {}), named = read_dem(path, voids({-9999}));
    CHECK(named.voids == tagged.voids);
    CHECK(named.heights_m == tagged.heights_m);
    CHECK(*std::min_element(named.heights_m.begin(), named.heights_m.end()) >= 100);
}

TEST_CASE("what --void says is part of what a bake is resumed by") {
    Baked b;
    const std::string path = b.path(basin(-9999));
    std::vector<std::string> identities;
    for (const ReadOptions& o : {ReadOptions{}, voids({-9999}), voids({-9999, 3}), all_ground()})
        identities.push_back(open_source({path}, o)->identity());
    std::sort(identities.begin(), identities.end());
    CHECK(std::unique(identities.begin(), identities.end()) == identities.end());
}

TEST_CASE("the ends of what is read are the same however it is cut, and count what there is") {
    std::mt19937 random(11);
    for (int round = 0; round < rounds(60, 2000); ++round) {
        const auto below = [&](std::size_t n) { return random() % n; };
        const int columns = 1 + static_cast<int>(below(60)), rows = 1 + static_cast<int>(below(60));
        const std::size_t distinct = 1 + below(round % 2 ? 40 : 4000);
        std::vector<float> numbers(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
        for (float& n : numbers) n = static_cast<float>(below(distinct)) / 4;
        for (std::size_t i = 0; i < below(9); ++i) numbers[below(numbers.size())] = below(2) ? -9999 : 50000;
        RangeEnds whole, cut;
        for (int y = 0; y < rows; ++y) {
            const float* const row = numbers.data() + static_cast<std::ptrdiff_t>(y) * columns;
            whole.see(row, static_cast<std::size_t>(columns), {0, y, 1});
            const int y2 = rows - 1 - y, at = static_cast<int>(below(static_cast<std::size_t>(columns) + 1));
            const float* const row2 = numbers.data() + static_cast<std::ptrdiff_t>(y2) * columns;
            RangeEnds part;
            for (int x = at; x < columns; ++x) part.see(static_cast<double>(row2[x]), x, y2);
            cut.add(part);
            cut.see(row2, static_cast<std::size_t>(at), {0, y2, 1});
        }
        const VoidFindings a = find_voids(whole, true), c = find_voids(cut, true);
        REQUIRE(a.samples == numbers.size());
        REQUIRE(c.samples == a.samples);
        REQUIRE(a.voids.size() == c.voids.size());
        REQUIRE(a.repeated.size() == c.repeated.size());
        for (std::size_t i = 0; i < a.voids.size(); ++i) {
            const NumberTally &v = a.voids[i], &w = c.voids[i];
            const auto number = static_cast<float>(v.number);
            const auto first = std::find(numbers.begin(), numbers.end(), number) - numbers.begin();
            REQUIRE(v.number == w.number);
            REQUIRE(v.samples.count == static_cast<std::uint64_t>(std::count(numbers.begin(), numbers.end(), number)));
            for (const Tally& t : {v.samples, w.samples}) REQUIRE(t.row * columns + t.column == first);
        }
        if (std::count(numbers.begin(), numbers.end(), -9999.0f))
            REQUIRE(
                std::any_of(a.voids.begin(), a.voids.end(), [](const NumberTally& v) { return v.number == -9999; }));
    }
}
