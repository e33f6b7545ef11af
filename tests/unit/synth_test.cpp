#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "baker/bake/bake.h"
#include "support/dem.h"

#include "baker/georeference/open_source.h"
#include "baker/synth/synth.h"
#include "baker/synth/write_dem.h"
#include "raster.h"
#include "support/temporary_folder.h"

using namespace fjell::baker;
using namespace fjell::test;

namespace {

// FNV-1a over the heights' bits.
std::uint64_t hash_of(const Dem& dem) {
    std::uint64_t hash = 0xcbf29ce484222325u;
    for (const float h : dem.heights_m) {
        std::uint32_t bits = 0;
        std::memcpy(&bits, &h, sizeof bits);
        for (int k = 0; k < 4; ++k) hash = (hash ^ (bits >> (8 * k) & 0xff)) * 0x100000001b3u;
    }
    return hash;
}

std::string recipe(int columns, int rows, double spacing_m, const std::string& more = "") {
    return "{\"columns\": " + std::to_string(columns) + ", \"rows\": " + std::to_string(rows) +
           ", \"spacing_m\": " + std::to_string(spacing_m) + ", \"seed\": 7" + more + "}";
}

std::string content(const char* name) {
    return std::string(FJELL_SOURCE_DIR) + "/content/terrain/" + name;
}

} // namespace

TEST_CASE("a recipe makes the same bytes whatever the number of threads, and every time") {
    const std::string text = recipe(200, 150, 60);
    const std::uint64_t once = hash_of(synthesise_text(text, 1));
    CHECK(hash_of(synthesise_text(text, 1)) == once);
    CHECK(hash_of(synthesise_text(text, 2)) == once);
    CHECK(hash_of(synthesise_text(text, 7)) == once);
    CHECK(hash_of(synthesise_text(recipe(200, 150, 60, ", \"roughness\": 0.6"), 1)) != once);
}

// The number changes when the landscape does: benchmarks before and after are then not of the same terrain. Say so in
// CHANGELOG.md.
TEST_CASE("mountains-small is the landscape it was") {
    const Dem dem = synthesise(content("mountains-small.json"));
    CHECK(dem.columns == 513);
    CHECK(dem.rows == 513);
    CHECK(hash_of(dem) == 0x1e8d82fea377f73cu);
}

TEST_CASE("the benchmark terrain continues the small one") {
    std::ifstream file(content("mountains.json"));
    std::string text{std::istreambuf_iterator<char>(file), {}};
    // Its first rows are enough, and 16 times faster.
    text.replace(text.find("\"rows\": 4097"), 12, "\"rows\": 33");
    const Dem large = synthesise_text(text), small = synthesise(content("mountains-small.json"));
    REQUIRE(large.columns == 4097);
    for (int y = 0; y < 33; ++y)
        CHECK(std::equal(small.heights_m.begin() + y * 513, small.heights_m.begin() + (y + 1) * 513,
                         large.heights_m.begin() + y * 4097));
}

TEST_CASE("a finer spacing shows the same mountains") {
    const Dem coarse = synthesise_text(recipe(65, 65, 240)), fine = synthesise_text(recipe(257, 257, 60));
    double sum = 0, sum_a = 0, sum_b = 0, aa = 0, bb = 0;
    for (int y = 0; y < 65; ++y)
        for (int x = 0; x < 65; ++x) {
            const double a = coarse.at(x, y), b = fine.at(4 * x, 4 * y);
            sum += a * b, sum_a += a, sum_b += b, aa += a * a, bb += b * b;
        }
    constexpr double n = 65 * 65;
    const double correlation =
        (sum - sum_a * sum_b / n) / std::sqrt((aa - sum_a * sum_a / n) * (bb - sum_b * sum_b / n));
    CHECK(correlation > 0.98);
}

TEST_CASE("synthetic heights are finite whole decimetres about the size asked for") {
    const Dem dem = synthesise_text(recipe(400, 400, 240, ", \"base_m\": 500, \"relief_m\": 2000"));
    CHECK(dem.native_quantum_m == 0.1);
    CHECK(dem.spacing_m[0] == 240);
    const auto [least, most] = std::minmax_element(dem.heights_m.begin(), dem.heights_m.end());
    CHECK(*least > 500 - 400);
    CHECK(*least < 500 + 400);
    CHECK(*most > 500 + 1400);
    CHECK(*most < 500 + 2800);
    for (const float h : dem.heights_m)
        if (h != static_cast<float>(std::round(h * 10.0) * 0.1)) FAIL("not a whole decimetre: " << h);
}

TEST_CASE("no relief is a plane, and the smallest grid is 2 x 2") {
    const Dem dem = synthesise_text(recipe(2, 2, 60, ", \"base_m\": 12.5, \"relief_m\": 0"));
    CHECK(dem.heights_m == std::vector<float>(4, 12.5f));
}

TEST_CASE("every corner of the recipe's ranges gives finite heights") {
    for (const char* more : {", \"gullies\": 0, \"warp\": 0, \"lowland\": 0, \"roughness\": 0",
                             ", \"gullies\": 1, \"warp\": 1, \"lowland\": 1, \"roughness\": 1, \"octaves\": 16",
                             ", \"feature_m\": 240", ", \"feature_m\": 10000000", ", \"octaves\": 1"}) {
        const Dem dem = synthesise_text(recipe(65, 33, 60, more));
        INFO(more);
        CHECK(std::all_of(dem.heights_m.begin(), dem.heights_m.end(), [](float h) { return std::abs(h) < 20000; }));
    }
}

TEST_CASE("a recipe that is not one is refused, naming the field") {
    const auto refused = [](const std::string& text) { return refusal([&] { (void)synthesise_text(text); }); };
    check_refusal(refused("not json"), 1, "recipe", {"is not JSON"});
    check_refusal(refused(R"({"seed": 1, "seed": 2})"), 1, "recipe", {"\"seed\" is there twice"});
    check_refusal(refused("[1, 2]"), 1, "recipe", {"JSON object", "mountains.json"});
    check_refusal(refused("{\"colums\": 5}"), 1, "\"colums\"", {"unknown field", "content/README.md"});
    check_refusal(refused("{\"seed\": \"x\"}"), 1, "\"seed\"", {"must be a number"});
    check_refusal(refused("{\"columns\": 1}"), 1, "\"columns\"", {"whole number in 2..65537"});
    check_refusal(refused("{\"rows\": 2.5}"), 1, "\"rows\"", {"whole number"});
    check_refusal(refused("{\"relief_m\": 1e9}"), 1, "\"relief_m\"", {"0..20000"});
    check_refusal(refused("{\"spacing_m\": 100, \"feature_m\": 300}"), 1, "\"feature_m\"", {"4 spacings"});
    check_refusal(refused("{\"spacing_m\": 0.001, \"feature_m\": 1e7}"), 1, "\"feature_m\"", {"1e9 spacings"});
    check_refusal(refusal([] { (void)synthesise("no/such.json"); }), 1, "no/such.json", {"No such file"});
}

TEST_CASE("any window of a landscape is what the whole has there") {
    const std::string text = recipe(150, 90, 60);
    const Dem whole = synthesise_text(text);
    const auto source = synth_source(text);
    REQUIRE(source->columns == 150);
    REQUIRE(source->rows == 90);
    CHECK(source->spacing_m[1] == 60);
    for (const Window& w : {Window{0, 0, 150, 90}, Window{149, 89, 1, 1}, Window{37, 21, 64, 5}, Window{3, 0, 1, 90}}) {
        std::vector<float> heights(w.area());
        ReadStatistics statistics;
        source->reader()->read(w, heights.data(), statistics);
        for (int y = 0; y < w.rows; ++y)
            CHECK(std::equal(heights.begin() + y * w.columns, heights.begin() + (y + 1) * w.columns,
                             whole.heights_m.begin() + (w.y + y) * 150 + w.x));
        CHECK(statistics.least_m == *std::min_element(heights.begin(), heights.end()));
        CHECK(statistics.most_m == *std::max_element(heights.begin(), heights.end()));
    }
    std::size_t samples = 0;
    for (const Window& w : source->windows(1000)) samples += w.area();
    CHECK(samples == 150 * 90);
    CHECK(source->properties({}).native_quantum_m == 0.1);
    CHECK(source->identity() == synth_source("/* the same */ " + text)->identity());
    CHECK(source->identity() != synth_source(recipe(150, 90, 60, ", \"warp\": 0.25"))->identity());
}

TEST_CASE("a pack of a recipe is the pack of its height field") {
    const TemporaryFolder dir;
    const std::string text = recipe(200, 120, 60);
    BakeOptions options;
    options.tile_log2 = 5;
    bake(*synth_source(text), options, dir / "a.fjell");
    bake(synthesise_text(text), options, dir / "b.fjell");
    write_dem(*synth_source(text), dir / "dem.tif");
    bake(*open_source({dir / "dem.tif"}, {}), options, dir / "c.fjell");
    const auto bytes = [&](const char* name) {
        std::ifstream file(dir / name, std::ios::binary);
        return std::string(std::istreambuf_iterator<char>(file), {});
    };
    CHECK((bytes("a.fjell") == bytes("b.fjell")));
    CHECK(bytes("c.fjell").size() > 1000); // with a CRS
}

TEST_CASE("a source is written as its height field is, holes as ground") {
    const TemporaryFolder dir;
    const std::string text = recipe(300, 290, 60);
    write_dem(*synth_source(text), dir / "a.tif", DemForm::compact, 3);
    const Dem dem = synthesise_text(text), back = read_dem(dir / "a.tif", {});
    CHECK((back.heights_m == dem.heights_m));
    CHECK(back.native_quantum_m == 0.1);
    CHECK(back.spacing_m[0] == 60);
    Dem holed = dem;
    holed.native_quantum_m = 0; // floats
    holed.voids.assign(dem.heights_m.size(), 0);
    for (int i = 40 * 300; i < 80 * 300; ++i) holed.voids[static_cast<std::size_t>(i)] = i % 300 > 100 && i % 300 < 150;
    write_dem(DemSource(holed), dir / "b.tif", DemForm::compact, 2);
    const Dem filled = read_dem(dir / "b.tif", {});
    CHECK(filled.voids.empty());
    for (std::size_t i = 0; i < dem.heights_m.size(); ++i)
        if (holed.voids[i] ? !std::isfinite(filled.heights_m[i]) : filled.heights_m[i] != dem.heights_m[i])
            FAIL("sample " << i << ": " << filled.heights_m[i]);
    write_dem(holed, dir / "c.tif"); // keeps the ground it has
    CHECK((read_dem(dir / "c.tif", {}).heights_m == dem.heights_m));
    CHECK(std::distance(std::filesystem::directory_iterator(dir.path), {}) == 3);
}

// Counted by the kernel, in a child each, beyond what any write takes.
TEST_CASE("a height field of four times the size is written in the same memory") {
    const auto peak_kb = [](int side) {
        const TemporaryFolder dir;
        int pipe_ends[2];
        REQUIRE(pipe(pipe_ends) == 0);
        const pid_t child = fork();
        if (child == 0) {
            try {
                // Flat: what counts is how much there is of it.
                write_dem(*synth_source(recipe(side, side, 60, ", \"gullies\": 0, \"octaves\": 1")), dir / "a.tif",
                          DemForm::compact, 2);
            } catch (...) {
                _exit(1);
            }
            rusage used{};
            getrusage(RUSAGE_SELF, &used);
            (void)!write(pipe_ends[1], &used.ru_maxrss, sizeof used.ru_maxrss);
            _exit(0);
        }
        int status = 0;
        waitpid(child, &status, 0);
        REQUIRE(status == 0);
        long peak = 0;
        REQUIRE(read(pipe_ends[0], &peak, sizeof peak) == sizeof peak);
        close(pipe_ends[0]);
        close(pipe_ends[1]);
        return peak;
    };
    const long small = peak_kb(1537), large = peak_kb(3073);
    CAPTURE(small, large);
#ifndef FJELL_SANITIZED // which gives nothing back for a while
    // The larger one has 1,536 columns more, of 2 KB each and twice while it is read back; in one piece it would take
    // 28 MB more.
    CHECK(large - small < 10'000);
#endif
}
