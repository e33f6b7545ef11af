// Tiles in the programs that they are for: CesiumJS and three.js fly over them in headless Chromium (viewers/show.mjs),
// and decoders of others read every one (viewers/read.mjs). In full rounds only: a browser and packages of npm, 100 MB.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <string>

#include <nlohmann/json.hpp>

#include "bake_cli.h"
#include "support/rounds.h"

using namespace fjell::test;
using nlohmann::json;

namespace {

const std::string viewers = FJELL_VIEWERS;

// False: it has said why.
bool can_view(const std::string& browser) {
    if (!full_rounds()) return false; // the checkers of tiles_test measure the same without a viewer
    if (browser.empty()) {
        std::cout << "skipped: viewers of tiles; there is no chromium, which ./dev test --long installs\n";
        return false;
    }
    const TemporaryFolder folder;
    output_of(folder, "cmake -DFOLDER=" + viewers + " -P " FJELL_SOURCE_DIR "/tests/system/gltf/npm_install.cmake");
    return true;
}

json node(const TemporaryFolder& folder, const std::string& script) {
    return json::parse(output_of(folder, "node " + viewers + "/" + script));
}

// Mountains in Norway, made up.
void bake_mountains(const TemporaryFolder& folder) {
    output_of(
        folder,
        bake +
            "synth " FJELL_SOURCE_DIR "/content/terrain/mountains-small.json -o dem.tif --quiet && "
            "gdal_translate -q -srcwin 100 100 257 257 -a_srs EPSG:32632 -a_ullr 430000 6800000 445420 6784580 dem.tif "
            "placed.tif && " +
            bake + "placed.tif -o pack.fjell --quiet");
    write_points(folder, "EPSG:32632");
}

} // namespace

TEST_CASE("CesiumJS and three.js show tiles without a gap and no farther from the ground than they say") {
    const TemporaryFolder folder;
    const Run which = run_in(folder.path, "command -v chromium");
    const std::string browser = which.out.substr(0, which.out.find('\n'));
    if (!can_view(browser)) return;
    bake_mountains(folder);
    struct Viewer {
        std::string program, way;
    };
    for (const Viewer& viewer : {Viewer{"cesium", ""}, Viewer{"three", " --format 3dtiles --implicit"},
                                 Viewer{"three", " --format 3dtiles --colours --quantised --meshopt --max-level 12"}}) {
        CAPTURE(viewer.program, viewer.way);
        const json said = json::parse(
            output_of(folder, "rm -rf out; " + bake + "tiles pack.fjell -o out --quiet --json -" + viewer.way));
        const json finest = said["levels"].back();
        const std::string picture = viewers + "/" + viewer.program + ".png";
        const json seen = node(folder, "show.mjs " + viewer.program + " out points.txt " + finest["error_m"].dump() +
                                           " " + picture + " " + browser);
        CAPTURE(seen.dump());
        CHECK(seen["failures"].empty());
        CHECK(seen["requests"] > finest["tiles"]);
        CHECK(seen["places"] == 1000);
        CHECK(seen["worst_m"] <= finest["error_m"]);
        CHECK(seen["worst_m"].get<double>() > 0.5 * finest["error_m"].get<double>());
        CHECK(seen["frames"] >= 7);
        CHECK(seen["under_horizon"] == 0);
        CHECK(seen["sky_seen"] > 10000);
        if (seen.contains("without_skirts")) CHECK(seen["without_skirts"] > 100); // gaps are seen where they are

        const json read = node(folder, "read.mjs out");
        CAPTURE(read.dump());
        CHECK(read["faults"].empty());
        std::uint64_t tiles = 0, triangles = 0;
        for (const json& level : said["levels"])
            tiles += level["tiles"].get<std::uint64_t>(), triangles += level["triangles"].get<std::uint64_t>();
        CHECK(read["files"] == tiles);
        CHECK(read["triangles"] >= triangles);                           // glTF's has walls as well
        CHECK(read["tiles"] == (viewer.program == "three" ? tiles : 0)); // by 3d-tiles-tools, from the root on
    }
    // Compressed, the last is that of plain tiles with rounded places.
    CHECK(node(folder, "unpack.mjs out")["files"] > 30);
    output_of(folder, bake + "tiles pack.fjell -o plain --quiet --format 3dtiles");
    output_of(folder, "shuf -n 9000 --random-source=points.txt points.txt >few.txt && python3 " FJELL_SOURCE_DIR
                      "/tests/system/tiles/check3d.py out few.txt plain");
}

TEST_CASE("MapLibre shows pictures of heights, and finds the heights that they have") {
    const TemporaryFolder folder;
    const Run which = run_in(folder.path, "command -v chromium");
    const std::string browser = which.out.substr(0, which.out.find('\n'));
    if (!can_view(browser)) return;
    bake_mountains(folder);
    for (const std::string way : {"terrain-rgb", "terrarium --image webp"}) {
        CAPTURE(way);
        const json said = json::parse(output_of(
            folder, "rm -rf out; " + bake + "tiles pack.fjell -o out --quiet --tile-px 256 --json - --format " + way));
        const json finest = said["levels"].back();
        const std::string picture = viewers + "/maplibre-" + way.substr(0, way.find(' ')) + ".png";
        const json seen = node(folder, "show.mjs maplibre out points.txt " + finest["error_m"].dump() + " " + picture +
                                           " " + browser);
        CAPTURE(seen.dump());
        CHECK(seen["failures"].empty());
        CHECK(seen["requests"] > 5);
        CHECK(seen["places"] == 8);
        CHECK(seen["frames"] == 4);
        CHECK(seen["shades"] > 60); // the hillshade has slopes of all kinds
        CHECK(seen["sky_seen"] > 1000);
    }
}

TEST_CASE("a snapshot that is compressed is the one that is not, with rounded numbers") {
    if (!can_view("node alone")) return;
    const TemporaryFolder folder;
    bake_mountains(folder);
    const std::string fly = FJELL_BIN_DIR "/fjell-fly pack.fjell --headless --frames 2 --error-px 2 --export 1:";
    output_of(folder, "mkdir small && " + fly + "plain.glb && " + fly + "small/packed.glb --export-quantised " +
                          "--export-meshopt && " + fly + "round.glb --export-quantised");
    CHECK(std::filesystem::file_size(folder / "small/packed.glb") < std::filesystem::file_size(folder / "round.glb"));
    CHECK(node(folder, "unpack.mjs small")["files"] == 1);
    // The same vertices, and the same triangles, though some begin with another corner.
    const json found = json::parse(output_of(folder, "node " + viewers + "/same.mjs round.glb small/packed.glb"));
    CAPTURE(found.dump());
    CHECK(found["triangles"] > 1000);
    CHECK(found["different"] == 0);
}
