// fjell-bake join and verify over packs that were baked apart.
#include <catch2/catch.hpp>

#include <filesystem>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "bake_cli.h"
#include "support/program.h"

using namespace fjell::test;

TEST_CASE("join makes a set of packs that agree where they meet, and join and verify name two that do not") {
    const TemporaryFolder folder;
    spit(folder / "recipe.json", R"({"columns": 65, "rows": 33, "spacing_m": 60})");
    REQUIRE(run_in(folder.path, bake + "recipe.json -o one.fjell --tile 32 && " + bake +
                                    "split one.fjell -o whole --packs 2x1 && rm whole/set.json")
                .code == 0);
    const Run joined = run_in(folder.path, bake + "join whole");
    CAPTURE(joined.err);
    CHECK(joined.code == 0);
    CHECK(joined.out.find("whole: 2 packs") == 0);
    CHECK(joined.out.find("33 vertices where packs meet: heights, holes, errors and radii agree") != std::string::npos);
    CHECK(run_in(folder.path, bake + "verify whole").code == 0);
    // Two halves of one field, each baked alone: heights from 0 to 200 in both, so that they are on one scale.
    for (const int half : {0, 1}) {
        std::string text = fmt::format("ncols 33\nnrows 33\nxllcenter {}\nyllcenter 1000\ncellsize 30\n", half * 960);
        for (int y = 0; y < 33; ++y)
            for (int x = 32 * half; x <= 32 * (half + 1); ++x)
                text += fmt::format("{}{}",
                                    x % 32 == 9 && y == 9    ? 200
                                    : x % 32 == 10 && y == 9 ? 0
                                                             : x * y % 89 + (x / 7 * 31 + y / 5 * 17) % 53,
                                    x == 32 * (half + 1) ? "\n" : " ");
        spit(folder / fmt::format("{}.asc", half), text);
        REQUIRE(run_in(folder.path,
                       "mkdir -p apart && " + bake +
                           fmt::format("{}.asc -o apart/{}.fjell --tile 32", half, half == 0 ? "west" : "east"))
                    .code == 0);
    }
    const std::string line = "west.fjell and east.fjell: ";
    refused(folder, bake + "join apart", 1, "apart/" + line);
    CHECK(!std::filesystem::exists(folder / "apart/set.json"));
    spit(folder / "apart/set.json",
         R"({"fjell_set": 1, "columns": 65, "rows": 33, "tile_cells": 32, "spacing_m": [30, 30], "packs": [
            {"file": "west.fjell", "tile_x": 0, "tile_y": 0, "tiles_x": 1, "tiles_y": 1},
            {"file": "east.fjell", "tile_x": 1, "tile_y": 0, "tiles_x": 1, "tiles_y": 1}]})");
    refused(folder, bake + "verify apart --json -", 1, "apart: " + line);
    const auto report = nlohmann::json::parse(run_in(folder.path, bake + "verify apart --json - || true").out);
    CHECK(report["border_mismatches"] > 0);
    const auto first = report["first"].get<std::string>();
    CAPTURE(first);
    CHECK(first.find("of 33 errors on their border differ, most at sample (32, ") != std::string::npos);
}

TEST_CASE("packs in degrees that were baked apart on both sides of the antimeridian are refused, and baked as one they "
          "join") {
    const TemporaryFolder folder;
    for (const auto& [name, west] : {std::pair{"a", 179.0}, {"b", -180.0}}) {
        std::string text = fmt::format("ncols 65\nnrows 65\nxllcenter {}\nyllcenter 10\ncellsize 0.015625\n", west);
        for (int y = 0; y < 65; ++y)
            for (int x = 0; x < 65; ++x)
                text += fmt::format("{}{}", 100 + (x + (*name == 'b' ? 64 : 0)) % 128 + y, x == 64 ? "\n" : " ");
        spit(folder / fmt::format("{}.asc", name), text);
        spit(folder / fmt::format("{}.prj", name), R"(GEOGCS["GCS_WGS_1984",DATUM["D_WGS_1984",)"
                                                   R"(SPHEROID["WGS_1984",6378137.0,298.257223563]],)"
                                                   R"(PRIMEM["Greenwich",0.0],UNIT["Degree",0.0174532925199433]])");
    }
    for (const auto& [options, says] :
         {std::pair{" --spacing 1700", "lie in degrees on both sides of the antimeridian"},
          {"", "are in different CRSs, WGS 84 / UTM zone 60N and WGS 84 / UTM zone 1N"}}) {
        CAPTURE(options);
        const std::string words = std::string(options) + " --tile 32 --quiet && ";
        REQUIRE(run_in(folder.path, "rm -rf apart as_one && mkdir apart && " + bake + "a.asc -o apart/a.fjell" + words +
                                        bake + "b.asc -o apart/b.fjell" + words + "true")
                    .code == 0);
        refused(folder, bake + "join apart", 1, std::string("a.fjell and b.fjell: ") + says);
        refused(folder, bake + "join apart", 1, "fjell-bake split ONE.fjell -o FOLDER");
        CHECK(run_in(folder.path, bake + "a.asc b.asc -o ONE.fjell" + words + bake +
                                      "split ONE.fjell -o as_one --packs 2x1 && rm as_one/set.json && " + bake +
                                      "join as_one")
                  .code == 0);
    }
}
