// Recipe files: what they may say, and where their paths lead.
#include <catch2/catch.hpp>

#include "baker/bake/recipe.h"
#include "raster.h"

using namespace fjell::baker;
using namespace fjell::test;

namespace {

Recipe full() {
    Recipe r;
    r.inputs = {"a.tif", "/data/b.tif", "NETCDF:\"c.nc\":z"};
    r.output = "out.fjell";
    r.texture = {"image.png"};
    r.ramp = "ramp.json";
    r.nodata = "hole";
    r.crs = "EPSG:32633";
    r.encoding = "terrarium";
    r.tile = "512";
    r.estimate = "midpoint";
    r.order = "hz";
    r.spacing = 0.1;
    r.zscale = 14.4;
    r.vertical_unit = "us-ft";
    r.zoffset = -127;
    r.nesting = 0.07;
    r.quantum = 1.0 / 3;
    r.bbox = {{-3.25, 36, 1e6, 4e6}};
    r.voids = DeclaredVoids{{-9999, 0.1}, true};
    return r;
}
Refusal bad(const std::string& text) {
    return refusal([&] { (void)parse_recipe(text, "r.json"); });
}

} // namespace

TEST_CASE("a recipe that is written comes back bit for bit") {
    CHECK(parse_recipe(recipe_text(full()), "r.json") == full());
    CHECK(parse_recipe("{}", "r.json") == Recipe{});
    CHECK(parse_recipe(R"({"tile": 64})", "r.json").tile == "64");
}

TEST_CASE("a recipe's key is read by the name that it had, and a line names the new one") {
    std::vector<std::string> renamed;
    CHECK(parse_recipe(R"({"layers": "l.json", "control": "full"})", "r.json", &renamed).splat == "full");
    CHECK(renamed ==
          std::vector<std::string>{"r.json: \"control\" is called splat now, and read by its old name until 0.4"});
    renamed.clear();
    CHECK(parse_recipe(R"({"splat": "full"})", "r.json", &renamed).splat == "full");
    CHECK(renamed.empty());
    check_refusal(bad(R"({"splat": "full", "control": "half"})"), 1, "r.json", {"\"control\" is now \"splat\""});
    CHECK(recipe_text(parse_recipe(R"({"control": "full"})", "r.json")).find("control") == std::string::npos);
}

TEST_CASE("a recipe of very many keys is refused as soon as it is read") { // each against each would take minutes
    std::string text = "{\"k0\": 1";
    for (int i = 1; i < 100'000; ++i) text += ", \"k" + std::to_string(i) + "\": 1";
    check_refusal(bad(text + "}"), 1, "r.json", {"\"k0\" is no key"});
}

TEST_CASE("what is no recipe is refused in one line that names the key") {
    check_refusal(bad("{"), 1, "r.json", {"is not JSON"});
    check_refusal(bad("{\"tile\": 64,\n\"tile\": 32}"), 1, "r.json:2", {"\"tile\" is there twice"});
    check_refusal(bad("[]"), 1, "r.json", {"not a JSON object"});
    check_refusal(bad(R"({"spaceing": 3})"), 1, "r.json", {"\"spaceing\" is no key"});
    check_refusal(bad("{\"a\\nb\": 3}"), 1, "r.json", {"a?b"});
    check_refusal(bad(R"({"spacing": "3"})"), 1, "r.json", {"\"spacing\" must be a number"});
    check_refusal(bad(R"({"spacing": 1e999})"), 1, "r.json", {});
    check_refusal(bad(R"({"crs": 32633})"), 1, "r.json", {"\"crs\" must be text"});
    check_refusal(bad(R"({"nodata": "holes"})"), 1, "r.json", {"\"nodata\" is \"holes\"", "hole, fill, refuse"});
    check_refusal(bad(R"({"tile": 3})"), 1, "r.json", {"\"tile\""});
    check_refusal(bad(R"({"inputs": "a.tif"})"), 1, "r.json", {"\"inputs\" must be a list"});
    check_refusal(bad(R"({"inputs": ["a.tif", 3]})"), 1, "r.json", {"entry 1"});
    check_refusal(bad(R"({"inputs": ["a\u0000.tif"]})"), 1, "r.json", {"entry 0"});
    check_refusal(bad(R"({"void": -9999})"), 1, "r.json", {"\"void\" must be a list"});
    check_refusal(bad(R"({"void": [-9999, "any"]})"), 1, "r.json", {"\"void\" must be a number"});
    check_refusal(bad(R"({"bbox": [1, 2, 3]})"), 1, "r.json", {"\"bbox\""});
    check_refusal(bad(R"({"bbox": [1, 2, 3, null]})"), 1, "r.json", {"\"bbox\" must be a number"});
}

TEST_CASE("every cut of a recipe is refused or a recipe") {
    const std::string text = recipe_text(full());
    for (std::size_t length = 0; length < text.size(); ++length) {
        const Refusal r = bad(text.substr(0, length));
        CHECK((r.code == 1 || length + 1 >= text.size()));
        CHECK(r.line.find('\n') == std::string::npos);
    }
}

TEST_CASE("what is given wins over the recipe") {
    Recipe given;
    given.inputs = {"x.tif"};
    given.zscale = 1;
    const Recipe both = merged(given, full());
    CHECK(both.inputs == std::vector<std::string>{"x.tif"});
    CHECK(both.zscale == 1);
    CHECK(both.spacing == 0.1);
    CHECK(both.bbox == full().bbox);
    CHECK(merged({}, full()) == full());
}

TEST_CASE("relative paths in a recipe start at its folder, others stay") {
    const TempDir dir;
    std::filesystem::create_directories(dir / "sub");
    write_text(dir / "sub/r.json", recipe_text(full()));
    const Recipe loaded = load_recipe(dir / "sub/r.json");
    CHECK(loaded.inputs == std::vector<std::string>{dir / "sub/a.tif", "/data/b.tif", "NETCDF:\"c.nc\":z"});
    CHECK(loaded.output == dir / "sub/out.fjell");
    CHECK(loaded.ramp == dir / "sub/ramp.json");
    CHECK(loaded.crs == "EPSG:32633");
    const Recipe beside = for_file(full(), "other/r.json");
    CHECK(beside.inputs == std::vector<std::string>{"../a.tif", "/data/b.tif", "NETCDF:\"c.nc\":z"});
    CHECK(beside.texture == std::vector<std::string>{"../image.png"});
    CHECK(for_file(full(), "r.json") == full());
    CHECK(refusal([&] { (void)load_recipe(dir / "missing.json"); }).code == 1);
}

TEST_CASE("a box is four numbers with commas") {
    CHECK(parse_bbox("-3,36.5,-2,1e2") == std::array<double, 4>{-3, 36.5, -2, 100});
    for (const char* text :
         {"", "1,2,3", "1,2,3,4,5", "1,2,3,4,", "1 2 3 4", "a,2,3,4", "nan,2,3,4", "1,2,3,inf", "1,,3,4"})
        CHECK(refusal([&] { (void)parse_bbox(text); }).code == 2);
}

TEST_CASE("voids are numbers or none, one by one or with commas") {
    std::optional<DeclaredVoids> all;
    parse_voids("-9999", all);
    parse_voids("1e20,-32768", all);
    CHECK(all == DeclaredVoids{{-9999, 1e20, -32768}, false});
    parse_voids("none", all);
    CHECK(all->no_others);
    CHECK(all->numbers.size() == 3);
    for (const char* text : {"", "a", "1,", ",1", "nan", "inf", "1 2", "none,", "0x10"})
        CHECK(refusal([&] { parse_voids(text, all); }).code == 2);
    Recipe given;
    given.voids.emplace();
    CHECK(merged(given, full()).voids == DeclaredVoids{});
}
