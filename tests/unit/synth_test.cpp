#include <algorithm>
#include <cmath>
#include <cstring>

#include "baker/read.h"
#include "raster.h"

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
    check_refusal(refused("not json"), 1, "recipe", {"JSON object", "mountains.json"});
    check_refusal(refused("[1, 2]"), 1, "recipe", {"JSON object"});
    check_refusal(refused("{\"colums\": 5}"), 1, "\"colums\"", {"unknown field", "content/README.md"});
    check_refusal(refused("{\"seed\": \"x\"}"), 1, "\"seed\"", {"must be a number"});
    check_refusal(refused("{\"columns\": 1}"), 1, "\"columns\"", {"whole number in 2..65537"});
    check_refusal(refused("{\"rows\": 2.5}"), 1, "\"rows\"", {"whole number"});
    check_refusal(refused("{\"relief_m\": 1e9}"), 1, "\"relief_m\"", {"0..20000"});
    check_refusal(refused("{\"spacing_m\": 100, \"feature_m\": 300}"), 1, "\"feature_m\"", {"4 spacings"});
    check_refusal(refusal([] { (void)synthesise("no/such.json"); }), 1, "no/such.json", {"No such file"});
}
