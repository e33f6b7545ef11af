// Pyramids of tiles for globes, read by a program that shares nothing with ours (tiles/check.py) and compared with
// heights that GDAL has read and placed.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <random>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "bake_cli.h"
#include "support/program.h"
#include "support/rounds.h"
#include "support/temporary_folder.h"

using namespace fjell::test;
using nlohmann::json;

namespace {

// Mountains at a place of a CRS, with a cliff and a hole, as pack.fjell; and its samples as GDAL places them, in
// points.txt: "longitude latitude height".
struct Place {
    std::string name, crs;
    int columns, rows, spacing_m;
    long west, south; // of its corner, in the CRS
};
void bake_at(const TemporaryFolder& folder, const Place& p) {
    std::string text = "ncols " + std::to_string(p.columns) + "\nnrows " + std::to_string(p.rows) + "\nxllcorner " +
                       std::to_string(p.west) + "\nyllcorner " + std::to_string(p.south) + "\ncellsize " +
                       std::to_string(p.spacing_m) + "\nNODATA_value -9999\n";
    for (int y = 0; y < p.rows; ++y) {
        for (int x = 0; x < p.columns; ++x) {
            const int relief_m = std::min(p.spacing_m, 150);
            const double waves = 900 + relief_m * (7 * std::sin(x * 0.23) * std::cos(y * 0.31) + std::sin(x * 1.7 + y));
            const bool hole = std::abs(x - 33) < 4 && std::abs(y - 21) < 3;
            text += hole ? "-9999 " : std::to_string(waves + (x > 40 && y > 25 ? 3 * relief_m : 0)) + " ";
        }
        text += "\n";
    }
    spit(folder / "dem.asc", text);
    output_of(folder, "gdal_translate -q -a_srs " + p.crs + " dem.asc placed.tif && " + bake +
                          "placed.tif -o pack.fjell --quiet --crs none");
    write_points(folder, p.crs);
}

std::map<std::string, std::string> files_under(const std::filesystem::path& folder) {
    std::map<std::string, std::string> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
        if (entry.is_regular_file())
            files[std::filesystem::relative(entry.path(), folder).string()] = slurp(entry.path());
    return files;
}

json checked(const TemporaryFolder& folder, const std::string& tiles, const std::string& checker = "check.py",
             const std::string& plain = "") {
    return json::parse(output_of(folder, "python3 " FJELL_SOURCE_DIR "/tests/system/tiles/" + checker + " " + tiles +
                                             " points.txt " + plain));
}

// False: it has said why.
bool has_webp(const TemporaryFolder& folder) {
    if (run_in(folder.path, "gdalinfo --formats | grep -q ' WEBP '").code == 0) return true;
    WARN("this GDAL has no WebP driver: such pictures are not tested");
    return false;
}

} // namespace

TEST_CASE("no sample is farther from a globe's tile than the tile says, and tiles meet") {
    constexpr int wide = 46, high = 34; // behind the hole and the cliff there is ground yet
    const std::vector<Place> places{
        {"a fjord", "EPSG:32632", wide, high, 30, 430000, 6790000},
        {"the antimeridian", "EPSG:32660", wide, high, 300, 826000, 6000},
        {"the pole", "EPSG:3413", wide, high, 2000, -51000, 49000},
    };
    for (const Place& place : places) {
        const TemporaryFolder folder;
        CAPTURE(place.name);
        bake_at(folder, place);
        for (const std::string way : {"geographic", "mercator", "geographic --format 3dtiles",
                                      "mercator --format 3dtiles", "geographic --format 3dtiles --implicit"}) {
            const bool mercator = way.starts_with("mercator"), implicit = way.ends_with("--implicit"),
                       tileset = implicit || way.ends_with("3dtiles");
            if (implicit && !full_rounds() && place.name != "the pole") continue;
            if (mercator && place.name != "a fjord") continue; // whose map does not reach the pole
            if (!full_rounds() && !tileset && place.name == "the pole") continue;
            if (!full_rounds() && mercator && tileset) continue;
            CAPTURE(way);
            const json said = json::parse(
                output_of(folder, "rm -rf out; " + bake + "tiles pack.fjell -o out --json - --tiling " + way));
            const json found = checked(folder, "out", tileset ? "check3d.py" : "check.py");
            CHECK(found["levels"] == said["levels"].size());
            CHECK(found["samples"] >= (place.columns * place.rows - 35) * found["levels"].get<int>());
            CHECK(found["normals"] == found["tiles"]);
            CHECK(found["border_vertices"].get<int>() > 2 * found["borders"].get<int>());
            CHECK(found["tightness"].get<double>() > 0.5); // an error is not only never too small
            std::uint64_t triangles = 0;
            for (const json& level : said["levels"]) {
                triangles += level["triangles"].get<std::uint64_t>();
                CHECK(level["tiles_above"] == 0);
            }
            CHECK(found["triangles"] == triangles);
            if (implicit) CHECK(found["subtrees"] > (said["levels"].size() > 5 ? 4 : 0)); // the roots', and below them
            if (!tileset || place.name == "the pole") continue; // where longitudes cannot be told from places
            if (!full_rounds() && (mercator || place.name != "a fjord")) continue;
            const json rounded =
                json::parse(output_of(folder, "rm -rf rounded; " + bake +
                                                  "tiles pack.fjell -o rounded --quantised --json - --tiling " + way));
            CHECK(checked(folder, "rounded", "check3d.py", "out")["triangles"] == triangles);
            for (std::size_t i = 0; i < said["levels"].size(); ++i) {
                CHECK(rounded["levels"][i]["error_m"] > said["levels"][i]["error_m"]);
                CHECK(rounded["levels"][i]["bytes"] < said["levels"][i]["bytes"]);
            }
        }
    }
}

TEST_CASE("a tile may have more vertices than 16 bits count") {
    if (!full_rounds()) return; // the checker takes half a minute
    const TemporaryFolder folder;
    constexpr int side = 200;
    std::string text = "ncols 200\nnrows 200\nxllcorner 490280\nyllcorner 6754900\ncellsize 60\n";
    std::minstd_rand random(7); // nothing but cliffs
    for (int i = 0; i < side * side; ++i)
        text += std::to_string(1000 + random() % 3000) + (i % side < 199 ? " " : "\n");
    spit(folder / "dem.asc", text);
    output_of(folder, "gdal_translate -q -a_srs EPSG:32632 dem.asc placed.tif && " + bake +
                          "placed.tif -o pack.fjell --quiet --crs none");
    write_points(folder, "EPSG:32632");
    const json said = json::parse(output_of(folder, bake + "tiles pack.fjell -o out --max-level 7 --json -"));
    const json finest = said["levels"].back();
    REQUIRE(finest["vertices"].get<double>() > 65536 * finest["tiles"].get<double>());
    const json found = checked(folder, "out");
    CHECK(found["samples"] == side * side * 8);
    std::uint64_t triangles = 0;
    for (const json& level : said["levels"]) triangles += level["triangles"].get<std::uint64_t>();
    CHECK(found["triangles"] == triangles);
}

TEST_CASE("tiles of a pack set are those of the pack that it was split from") {
    const TemporaryFolder folder;
    bake_at(folder, {"mountains", "EPSG:32632", 90, 70, 30, 430000, 6790000});
    output_of(folder, bake + "placed.tif -o small.fjell --tile 32 --quiet --crs none && " + bake +
                          "split small.fjell -o set --packs 2x2");
    for (const std::string format : {"", " --format 3dtiles"}) {
        CAPTURE(format);
        output_of(folder, "rm -rf of_pack of_set; " + bake + "tiles small.fjell -o of_pack --quiet" + format + " && " +
                              bake + "tiles set -o of_set --quiet" + format);
        auto of_pack = files_under(folder.path / "of_pack"), of_set = files_under(folder.path / "of_set");
        for (const std::string index : {"layer.json", "tileset.json"}) // which name their source
            CHECK(of_pack.erase(index) == of_set.erase(index));
        CHECK(of_pack.size() > (format.empty() ? 30u : 10u));
        CHECK(of_set == of_pack);
    }
    CHECK(checked(folder, "of_set", "check3d.py")["samples"] > 1000);
}

TEST_CASE("tiles are the same bytes for any number of threads, and when they were interrupted") {
    const TemporaryFolder folder;
    bake_at(folder, {"mountains", "EPSG:32632", 90, 70, 30, 430000, 6790000});
    output_of(folder, bake + "tiles pack.fjell -o one --threads 1 --quiet");
    output_of(folder, bake + "tiles pack.fjell -o three --threads 3 --quiet");
    const auto one = files_under(folder.path / "one");
    REQUIRE(one.size() > 30);
    CHECK(files_under(folder.path / "three") == one);
    CHECK_FALSE(std::filesystem::exists(folder / "one.work"));
    output_of(folder, bake + "tiles pack.fjell -o one3d --format 3dtiles --threads 1 --quiet");
    output_of(folder, bake + "tiles pack.fjell -o three3d --format 3dtiles --threads 3 --quiet");
    CHECK(files_under(folder.path / "three3d") == files_under(folder.path / "one3d"));
    CHECK(slurp(folder / "one3d/tileset.json").find("\"version\":\"1.1\"") != std::string::npos);

    // A disk that is full wherever it is: each run gets some files further.
    output_of(folder, bake + "tiles pack.fjell -o implicit --format 3dtiles --implicit --quiet");
    const int step_kb = full_rounds() ? 24 : 80;
    for (const auto& [options, whole] :
         first_of<std::pair<std::string, std::string>>(2, {{" --quiet", "one"},
                                                           {" --quiet --format 3dtiles --implicit", "implicit"},
                                                           {" --quiet --format 3dtiles", "one3d"}})) {
        output_of(folder, "rm -rf cut");
        int runs = 0;
        for (int code = 3; code == 3; ++runs) {
            REQUIRE(runs < 40);
            const std::string some = std::to_string(8 + step_kb * runs); // KB that a file may have
            const std::string limited = "trap '' XFSZ; ulimit -f " + some + "; " + bake + "tiles pack.fjell -o cut";
            code = run_in(folder.path, limited + options).code;
            // What is half done is another pyramid to whoever asks for something else.
            if (code == 3) {
                const Run other = run_in(folder.path, bake + "tiles pack.fjell -o cut --no-normals" + options);
                CHECK(other.code == 1);
                CHECK(other.err.find("holds something else") != std::string::npos);
            }
        }
        CHECK(runs > 1);
        CHECK(files_under(folder.path / "cut") == files_under(folder.path / whole));
    }

    // Killed in the middle, with a tile half-written.
    output_of(folder,
              bake +
                  "tiles pack.fjell -o killed --quiet & p=$!; "
                  "until [ -d killed/12 ] || ! kill -0 $p 2>/dev/null; do sleep 0.01; done; kill -9 $p; wait $p; true");
    if (std::filesystem::exists(folder / "killed.work")) {
        for (const auto& [name, bytes] : files_under(folder.path / "killed"))
            if (name.starts_with("12/")) spit(folder.path / "killed" / name, bytes); // as they are
        output_of(folder, bake + "tiles pack.fjell -o killed --quiet");
    }
    CHECK(files_under(folder.path / "killed") == one);
}

TEST_CASE("tiles need a place on the globe and a folder of their own") {
    const TemporaryFolder folder;
    spit(folder / "dem.asc", ascii_grid(17, 17, "5"));
    output_of(folder, bake + "dem.asc -o pack.fjell --quiet");
    refused(folder, bake + "tiles pack.fjell -o out", 1, "has no CRS");
    output_of(folder, "gdal_translate -q -a_srs EPSG:32632 -a_ullr 430000 6800000 430510 6799490 dem.asc dem.tif");
    output_of(folder, bake + "dem.tif -o pack.fjell --quiet");
    std::filesystem::create_directory(folder / "taken");
    spit(folder / "taken/letter.txt", "dear");
    refused(folder, bake + "tiles pack.fjell -o taken", 1, "holds something else");
    refused(folder, bake + "tiles pack.fjell -o out --max-level 20", 1, "give --max-level");
    refused(folder, bake + "tiles pack.fjell -o no/where/out", 1, "does not exist");
    refused(folder, bake + "tiles missing.fjell -o out", 1, "missing.fjell");
    refused(folder, bake + "tiles pack.fjell -o out --quantised", 2, "--format 3dtiles");
    refused(folder, bake + "tiles pack.fjell -o out --tiling polar", 2, "must be one of");
    output_of(folder, bake + "tiles pack.fjell -o out --max-level 9 --no-gzip --no-normals --quiet");
    const json layer = json::parse(slurp(folder / "out/layer.json"));
    CHECK(layer["maxzoom"] == 9);
    CHECK(layer["extensions"] == json{"metadata"});
    CHECK(layer["fjell"]["crs"] == "WGS 84 / UTM zone 32N (EPSG:32632)");
    CHECK(layer["fjell"]["vertical_unit"] == "m");
    CHECK(layer["fjell"]["vertical_datum"].is_null());
    refused(folder, bake + "tiles pack.fjell -o out", 1, "holds something else");
    refused(folder, bake + "tiles pack.fjell -o out --format 3dtiles", 1, "holds something else");
    refused(folder, bake + "tiles pack.fjell -o new --implicit", 2, "--format 3dtiles");
    refused(folder, bake + "tiles pack.fjell -o new --format 3dtiles --implicit --tiling mercator", 2,
            "halves degrees");
    refused(folder, bake + "tiles pack.fjell -o new --image webp", 2, "--format terrain-rgb");
    output_of(folder, "gdal_translate -q -a_srs EPSG:32632+5773 dem.tif over_sea.tif && " + bake +
                          "over_sea.tif -o over_sea.fjell --quiet && " + bake +
                          "tiles over_sea.fjell -o over_sea --max-level 5 --quiet");
    CHECK(json::parse(slurp(folder / "over_sea/layer.json"))["fjell"]["vertical_datum"] == "EGM96 height");
}

TEST_CASE("no sample is farther from pictures of heights than their metadata says") {
    for (const Place& place : first_of<Place>(1, {{"a fjord", "EPSG:32632", 46, 34, 30, 430000, 6790000},
                                                  {"the antimeridian", "EPSG:32660", 46, 34, 300, 826000, 6000}})) {
        const TemporaryFolder folder;
        CAPTURE(place.name);
        bake_at(folder, place);
        for (const std::string& way :
             first_of<std::string>(1, {"terrain-rgb --tile-px 256", "terrain-rgb --tile-px 256 --image webp",
                                       "terrarium --tile-px 256"})) {
            CAPTURE(way);
            if (way.ends_with("webp") && (!has_webp(folder) || place.name != "a fjord")) continue;
            const json said = json::parse(
                output_of(folder, "rm -rf out; " + bake + "tiles pack.fjell -o out --json - --format " + way));
            const json found = checked(folder, "out", "check_raster.py");
            CHECK(found["levels"] == said["levels"].size());
            CHECK(found["levels"] > 5);
            CHECK(found["samples"] == place.columns * place.rows - 35);
            CHECK(found["tightness"].get<double>() > 0.99);
        }
    }
}

TEST_CASE("one file has the tiles that a folder has, whatever interrupted its writing") {
    const TemporaryFolder folder;
    bake_at(folder, {"mountains", "EPSG:32632", 90, 70, 30, 430000, 6790000});
    const auto same = [&](const std::string& a, const std::string& b) {
        return std::stoi(
            output_of(folder, "python3 " FJELL_SOURCE_DIR "/tests/system/tiles/archive.py " + a + " " + b));
    };
    const auto tiles = [](const std::string& name, const std::string& options) {
        return bake + "tiles pack.fjell --quiet -o " + name + " " + options;
    };
    output_of(folder, tiles("mesh", "--tiling mercator"));
    output_of(folder, tiles("mesh.pmtiles", "--tiling mercator"));
    output_of(folder, tiles("mesh.mbtiles", "--tiling mercator --threads 1"));
    CHECK(same("mesh", "mesh.pmtiles") > 30);
    CHECK(same("mesh", "mesh.mbtiles") > 30);
    const std::string rgb = "--format terrain-rgb --tile-px 256" + std::string(full_rounds() ? "" : " --max-level 10");
    output_of(folder, tiles("rgb", rgb));
    output_of(folder, tiles("rgb.pmtiles", rgb + " --threads 1"));
    CHECK(same("rgb", "rgb.pmtiles") > (full_rounds() ? 10 : 5));
    if (full_rounds() && has_webp(folder)) {
        output_of(folder, tiles("webp", "--format terrarium --tile-px 256 --image webp --max-level 9"));
        for (const std::string name : {"webp.pmtiles", "webp.mbtiles"}) {
            output_of(folder, tiles(name, "--format terrarium --tile-px 256 --image webp --max-level 9"));
            CHECK(same("webp", name) > 5);
        }
    }
    for (const std::string name : {"cut.pmtiles", "cut.mbtiles"}) {
        CAPTURE(name);
        int runs = 0;
        for (int code = 3; code == 3; ++runs) {
            REQUIRE(runs < 40);
            CHECK_FALSE(std::filesystem::exists(folder / name));
            const std::string some = std::to_string(8 << (full_rounds() ? runs : 2 * runs)); // KB that a file may have
            code =
                run_in(folder.path, "trap '' XFSZ; ulimit -f " + some + "; " + tiles(name, "--tiling mercator")).code;
        }
        CHECK(runs > 1);
        CHECK(slurp(folder / name) == slurp(folder / ("mesh" + name.substr(3))));
        CHECK_FALSE(std::filesystem::exists(folder / (name + ".work")));
    }
    refused(folder, tiles("mesh.pmtiles", "--tiling mercator"), 1, "choose a new name");
    refused(folder, tiles("new.pmtiles", ""), 2, "add --tiling mercator");
    refused(folder, tiles("new.mbtiles", "--format 3dtiles"), 2, "written as a folder");
    refused(folder, tiles("new", "--format terrarium --tiling geographic"), 2, "leave it out");
    refused(folder, tiles("new", "--format terrarium --tile-px 300"), 2, "--tile-px");
}

TEST_CASE("tiles and meshes have the colours of the pack where it has them") {
    const TemporaryFolder folder;
    bake_at(folder, {"a fjord", "EPSG:32632", 46, 34, 30, 430000, 6790000});
    refused(folder, bake + "tiles placed.tif -o out --format 3dtiles --colours", 1, "placed.tif");
    spit(folder / "red.json",
         R"({"stops": [{"height_m": 600, "rgb": [0, 0, 0]}, {"height_m": 1300, "rgb": [255, 0, 0]}]})");
    output_of(folder, bake + "placed.tif -o red.fjell --quiet --crs none --ramp red.json");
    const auto right = [&](const std::string& what) {
        const json found = json::parse(output_of(
            folder, "python3 " FJELL_SOURCE_DIR "/tests/system/tiles/check_colours.py " + what + " 600 1300"));
        CAPTURE(what, found.dump());
        CHECK(found["coloured"] > 300);
        CHECK(found["right"].get<double>() > 0.9 * found["coloured"].get<double>());
    };
    output_of(folder, bake + "tiles red.fjell -o out --format 3dtiles --colours --quiet");
    right("out");
    output_of(folder, bake + "mesh red.fjell -o red.glb --max-error-m 5 --colours --quantised");
    right("red.glb");
    refused(folder, bake + "mesh placed.tif -o new.glb --max-error-m 5 --colours", 2, "takes a pack's");
    refused(folder, bake + "mesh placed.tif -o new.glb --max-error-m 5 --occlusion", 2, "takes a pack's");
    refused(folder, bake + "mesh red.fjell -o new.glb --max-error-m 5 --occlusion", 1, "has no horizon maps");
    refused(folder, bake + "mesh red.fjell -o new.ply --max-error-m 5 --colours", 2, "is for .glb");
    refused(folder, bake + "tiles red.fjell -o new --colours", 2, "is for --format 3dtiles");
}

TEST_CASE("tiles know where the pack's splat maps have water") {
    const TemporaryFolder folder;
    bake_at(folder, {"a fjord", "EPSG:32632", 46, 34, 30, 430000, 6790000});
    // Below 800 m; rock on slopes, so that water has not the first number.
    spit(folder / "splat.json", R"({"rules": [{"layer": "rock", "slope_deg": [30, 90]},
                                              {"layer": "water", "height_m": [-100, 800]}]})");
    output_of(folder, bake + "placed.tif -o wet.fjell --quiet --crs none --layers splat.json --splat full");
    const std::string script = "python3 " FJELL_SOURCE_DIR "/tests/system/tiles/check_water.py ";
    output_of(folder, bake + "tiles wet.fjell -o wet --quiet");
    const json found = json::parse(output_of(folder, script + "wet points.txt 800"));
    CAPTURE(found.dump());
    CHECK(found["samples"] > 1000);
    CHECK(found["water"] > 100);
    CHECK(found["right"].get<double>() > 0.97 * found["samples"].get<double>());
    CHECK(found["uniform"] > 5); // tiles of one byte
    CHECK(checked(folder, "wet")["normals"] > 5);
    output_of(folder, bake + "tiles wet.fjell -o dry --quiet --no-water-mask");
    output_of(folder, bake + "tiles pack.fjell -o never --quiet");
    for (const std::string name : {"dry", "never"})
        CHECK(json::parse(slurp(folder / (name + "/layer.json")))["extensions"] ==
              json{"metadata", "octvertexnormals"});
}
