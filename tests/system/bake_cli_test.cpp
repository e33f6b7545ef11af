// fjell-bake as a user meets it: what it does with good input, and with everything else.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <xxhash.h>

#include "bake_cli.h"
#include "support/program.h"
#include "support/real_data.h"
#include "support/rounds.h"
#include "support/terrain_fixture.h"

using namespace fjell::test;

TEST_CASE("synth, bake, info and verify, one after the other") {
    const TemporaryFolder folder;
    spit(folder / "recipe.json", R"({"columns": 200, "rows": 130, "spacing_m": 60})");
    REQUIRE(run_in(folder.path, bake + "synth recipe.json -o dem.tif").code == 0);
    const Run baked = run_in(folder.path, bake + "dem.tif -o out.fjell --tile 32 --json bake.json");
    REQUIRE(baked.code == 0);
    CHECK(baked.out.find("200 x 130 samples in 7 x 5 tiles of 32 cells") != std::string::npos);
    const auto summary = nlohmann::json::parse(slurp(folder / "bake.json"));
    CHECK(summary["columns"] == 200);
    CHECK(summary["file_bytes"] == std::filesystem::file_size(folder / "out.fjell"));
    const auto info = nlohmann::json::parse(run_in(folder.path, bake + "info out.fjell --json").out);
    CHECK(info["rows"] == 130);
    CHECK(info["spacing_m"][0] == 60);
    CHECK(run_in(folder.path, bake + "info out.fjell").out.find("pack_hash") != std::string::npos);
    const Run verified = run_in(folder.path, bake + "verify out.fjell --against dem.tif");
    CHECK(verified.code == 0);
    CHECK(verified.out.find("0 off by more than half a quantum") != std::string::npos);
    // Another height field is not what this pack was baked from, and baking it again would not help.
    spit(folder / "recipe.json", R"({"columns": 200, "rows": 130, "spacing_m": 60, "seed": 5})");
    REQUIRE(run_in(folder.path, bake + "synth recipe.json -o other.tif").code == 0);
    refused(folder, bake + "verify out.fjell --against other.tif", 1, "these are not the heights of other.tif");
    CHECK(folder.names() == std::vector<std::string>{"bake.json", "dem.tif", "other.tif", "out.fjell", "recipe.json"});
}

TEST_CASE("what a bake says names units, holes, the CRS and what was reprojected, and the largest error of ground") {
    const TemporaryFolder folder;
    std::string text = "ncols 120\nnrows 90\nxllcorner 0\nyllcorner 0\ncellsize 1\nNODATA_value -99\n";
    for (int i = 0; i < 120 * 90; ++i) // gentle: a few feet from sample to sample
        text +=
            i % 120 > 40 && i % 120 < 50 && i / 120 % 50 > 30 ? "-99 " : std::to_string(900 + i % 120 + i / 120) + " ";
    spit(folder / "dem.asc", text);
    spit(folder / "feet.vrt", R"(<VRTDataset rasterXSize="120" rasterYSize="90"><SRS>EPSG:4326</SRS>
        <GeoTransform>10, 0.001, 0, 46, 0, -0.001</GeoTransform><VRTRasterBand dataType="Float32" band="1">
        <NoDataValue>-99</NoDataValue><UnitType>ft</UnitType><SimpleSource>
        <SourceFilename relativeToVRT="1">dem.asc</SourceFilename><SourceBand>1</SourceBand></SimpleSource>
        </VRTRasterBand></VRTDataset>)");
    const Run baked = run_in(folder.path, bake + "feet.vrt -o out.fjell --json bake.json");
    CAPTURE(baked.out, baked.err);
    REQUIRE(baked.code == 0);
    for (const char* part : {"(VRT, Float32; the file's unit is ft; 1 in it is 0.3048 m", "voids by no-data -99",
                             " samples are holes (", "in WGS 84 / UTM zone 32N (EPSG:32632)",
                             "reprojected from WGS 84 (EPSG:4326), where they are 0.001 degrees apart"})
        CHECK(baked.out.find(part) != std::string::npos);
    const auto told = nlohmann::json::parse(slurp(folder / "bake.json"));
    const auto info = nlohmann::json::parse(run_in(folder.path, bake + "info out.fjell --json").out);
    // The pack says what its bake said, in words and as JSON.
    for (const char* key :
         {"driver",        "type",           "band",      "voids",    "holes", "height_m",     "height_unit",
          "height_unit_m", "ground_error_m", "spacing_m", "crs_name", "epsg",  "ground_scale", "reprojected_from",
          "resampled",     "images",         "columns",   "rows",     "tiles", "tile_cells",   "max_error_m"}) {
        CAPTURE(key);
        CHECK((told.contains(key) && told[key] == info[key]));
    }
    const std::string heights = baked.out.substr(baked.out.find("\nheights ") + 1);
    const std::string lines = heights.substr(0, heights.find("\n", heights.find("\nsamples ") + 1) + 1);
    CHECK(std::count(lines.begin(), lines.end(), '\n') == 2);
    CHECK(run_in(folder.path, bake + "info out.fjell").out.rfind(lines, 0) == 0);
    for (const auto& j : {told, info}) {
        CAPTURE(j.dump());
        CHECK(j["resampled"] == "cubic");
        CHECK(j["reprojected_from"]["axes"] == "east, north");
        CHECK((j["driver"] == "VRT" && j["type"] == "Float32" && j["voids"] == "no-data -99"));
        CHECK(j["height_unit"] == "ft");
        CHECK(j["height_unit_m"] == Approx(0.3048));
        CHECK(j["reprojected_from"]["crs_name"] == "WGS 84 (EPSG:4326)");
        CHECK(j["reprojected_from"]["spacing"][1] == Approx(0.001));
        CHECK(j["reprojected_from"]["unit"] == "degrees");
        CHECK(j["epsg"] == 32632);
        CHECK(j["holes"] > 0);
        // A rim's diamonds are as wrong as they are large; no ground is further off than it rises.
        CHECK(j["max_error_m"] > 1000);
        CHECK(j["ground_error_m"] < j["height_m"][1].get<double>() - j["height_m"][0].get<double>());
        CHECK(j["ground_error_m"] > 0);
    }
    CHECK(baked.out.find("off by up to " + fmt::format("{:.4g} m", told["ground_error_m"].get<double>())) !=
          std::string::npos);
    REQUIRE(run_in(folder.path, bake + "dem.asc -o plain.fjell --spacing 30 --zscale 0.5 --nodata fill").code == 0);
    CHECK(nlohmann::json::parse(run_in(folder.path, bake + "info plain.fjell --json").out)["height_unit_m"] == 0.5);
}

TEST_CASE("every command takes --quiet, and --json or says that it does not") {
    const TemporaryFolder folder;
    for (const std::string command :
         {"info", "verify", "heights", "split", "join", "synth", "materials", "plan", "shard", "launch", "merge"}) {
        CAPTURE(command);
        CHECK(run_in(folder.path, bake + command + " --help").out.find("--quiet") != std::string::npos);
        const Run json = run_in(folder.path, bake + command + " none none -o none --json -");
        const bool has = run_in(folder.path, bake + command + " --help").out.find("--json") != std::string::npos;
        CHECK((json.err.find("has no summary for scripts; leave --json out") == std::string::npos) == has);
    }
    spit(folder / "dem.asc", ascii_grid(20, 20, "5"));
    REQUIRE(run_in(folder.path, bake + "dem.asc -o out.fjell --quiet").code == 0);
    CHECK(run_in(folder.path, bake + "verify out.fjell --against dem.asc")
              .out.find("as GDAL alone reads it: AAIGrid Int32, 5 to 5 m, 5 samples") != std::string::npos);
}

TEST_CASE("with --json - standard output holds JSON and nothing else") {
    const TemporaryFolder folder;
    spit(folder / "dem.asc", ascii_grid(20, 20, "5"));
    for (const char* command : {"dem.asc -o out.fjell --json -", "info out.fjell --json -", "info --json out.fjell",
                                "verify out.fjell --json - --against dem.asc"}) {
        const Run r = run_in(folder.path, bake + command);
        CAPTURE(command, r.out, r.err);
        CHECK(r.code == 0);
        CHECK(nlohmann::json::accept(r.out));
        CHECK(r.err.empty());
    }
    CHECK(run_in(folder.path, bake + "verify out.fjell --against dem.asc --json report.json").code == 0);
    const auto report = nlohmann::json::parse(slurp(folder / "report.json"));
    CHECK((report["ok"] == true && report["height_mismatches"] == 0 && report["vertices"] > 400));
    refused(folder, bake + "verify out.fjell --json out.fjell", 2, "overwrite");
    refused(folder, bake + "info --json", 2, "no pack given");
}

TEST_CASE("verify reads a height field as the pack says that it was read") {
    const TemporaryFolder folder;
    std::string text = "ncols 60\nnrows 50\nxllcorner 0\nyllcorner 0\ncellsize 1\nNODATA_value -99\n";
    for (int i = 0; i < 3000; ++i) text += i % 97 == 0 ? "-99 " : std::to_string(i * 7919 % 1000) + " ";
    spit(folder / "dem.asc", text);
    spit(folder / "recipe.json", R"({"columns": 60, "rows": 50})");
    for (const char* read : {"--spacing 30", "--spacing 30 --zscale 0.1 --zoffset -7", "--spacing 2 --nodata fill",
                             "--spacing 12.5 --bbox 3,5,30,41 --zscale 3"}) {
        REQUIRE(run_in(folder.path, bake + "dem.asc -o out.fjell --tile 16 " + read).code == 0);
        const Run r = run_in(folder.path, bake + "verify out.fjell --against dem.asc");
        CAPTURE(read, r.out, r.err);
        CHECK(r.code == 0);
    }
    // What is given wins, and what does not fit is not the pack's fault.
    const Run other = run_in(folder.path, bake + "verify out.fjell --against dem.asc --zscale 7");
    CAPTURE(other.err);
    CHECK(other.code == 1);
    CHECK(other.err.find("\"zscale\":7") != std::string::npos);
    CHECK(other.err.find("bake it again") == std::string::npos);
    REQUIRE(run_in(folder.path, bake + "recipe.json -o made.fjell").code == 0);
    CHECK(run_in(folder.path, bake + "verify made.fjell --against recipe.json").code == 0);
    // Notes that are damaged are refused.
    std::string bytes = slurp(folder / "made.fjell");
    fjell::PackHeader h;
    std::memcpy(&h, bytes.data(), sizeof h);
    REQUIRE(h.notes_bytes > 10);
    bytes[h.notes_offset + 5] = static_cast<char>(bytes[h.notes_offset + 5] ^ 1);
    spit(folder / "bad.fjell", bytes);
    refused(folder, bake + "info bad.fjell", 1, "notes");
    refused(folder, bake + "verify bad.fjell", 1, "notes");
}

TEST_CASE("a pack's heights come back as a GeoTIFF that bakes to the same heights and holes") {
    const TemporaryFolder folder;
    std::string text = "ncols 90\nnrows 70\nxllcorner 1000\nyllcorner 1000\ncellsize 30\nNODATA_value -99\n";
    for (int i = 0; i < 6300; ++i) text += i % 90 > 40 && i % 90 < 50 ? "-99 " : std::to_string(i * 7919 % 1000) + " ";
    spit(folder / "dem.asc", text);
    REQUIRE(run_in(folder.path, bake + "dem.asc -o out.fjell --tile 32").code == 0);
    REQUIRE(run_in(folder.path, bake + "heights out.fjell -o back.tif").code == 0);
    CHECK(run_in(folder.path, bake + "verify out.fjell --against back.tif").code == 0);
    REQUIRE(run_in(folder.path, bake + "back.tif -o again.fjell --tile 32").code == 0);
    CHECK(run_in(folder.path, bake + "verify again.fjell --against dem.asc").code == 0);
    refused(folder, bake + "heights out.fjell -o back.bmp", 2, "give a name that ends so");
    refused(folder, bake + "heights missing.fjell -o other.tif", 1, "missing.fjell");
    refused(folder, bake + "heights out.fjell -o nowhere/other.tif", 1, "nowhere");
    std::filesystem::create_symlink("out.fjell", folder / "link.tif");
    refused(folder, bake + "heights out.fjell -o link.tif", 2, "overwrite");
    refused(folder, bake + "dem.asc heights out.fjell -o x.tif", 2, "bake nothing");
}

TEST_CASE("materials are baked from recipes and flown over, and what is wrong with them is said in one line") {
    const TemporaryFolder folder;
    spit(folder / "dem.asc", ascii_grid(40, 40, "7"));
    std::filesystem::create_directory(folder / "set");
    spit(folder / "set/grass.json", R"({"base": [90, 110, 50], "steps": [{"draw": "noise", "height_m": 0.1}]})");
    spit(folder / "rules.json", R"({"rules": [{"layer": "grass"}]})");
    REQUIRE(run_in(folder.path, bake + "dem.asc -o out.fjell").code == 0);
    const std::string materials = bake + "materials set -o m.materials --size ";
    REQUIRE(run_in(folder.path, materials + "32").code == 0);
    const std::string fly = FJELL_BIN_DIR "/fjell-fly out.fjell --headless --frames 1 --size 64x64 --render pictures ";
    CHECK(run_in(folder.path, fly + "--materials m.materials --layers rules.json").code == 0);
    const Run swapped = run_in(folder.path, fly + "--materials rules.json --layers m.materials");
    CHECK(swapped.code == 1);
    CHECK(swapped.err ==
          "fjell-fly: rules.json: is not a file of materials; make it again with fjell-bake materials\n");
    refused(folder, materials + "100", 2, "must be a power of two from 16 to 2048");
    refused(folder, bake + "materials nothing -o m.materials", 1, "nothing");
    spit(folder / "set/mud.json", R"({"base": [90, 70, 50], "steps": [{"draw": "mud"}]})");
    refused(folder, materials + "32", 1, "set/mud.json: step 0: \"draw\" must be one of noise, ");
}

TEST_CASE("verify looks at maps too: a tile with another's colours fails, though every checksum holds") {
    const TemporaryFolder folder;
    std::string text = "ncols 193\nnrows 129\nxllcorner 1000\nyllcorner 1000\ncellsize 30\n"; // smooth
    for (int y = 0; y < 129; ++y)
        for (int x = 0; x < 193; ++x)
            text += std::to_string(600 + 300 * std::sin(x * 0.03) + 280 * std::cos(y * 0.021)) + " ";
    spit(folder / "dem.asc", text);
    REQUIRE(run_in(folder.path, bake + "dem.asc -o out.fjell --tile 64").code == 0);
    const Run good = run_in(folder.path, bake + "verify out.fjell");
    CHECK(good.code == 0);
    CHECK(good.out.find("on borders of tiles: 0 mip, 0 border, 0 length, 0 weight violations") != std::string::npos);
    // Swap two entries of the directory, and make both hashes fit.
    std::string bytes = slurp(folder / "out.fjell");
    fjell::PackHeader h;
    std::memcpy(&h, bytes.data(), sizeof h);
    char* const directory = bytes.data() + h.directory_offset;
    const auto at = [&](std::uint32_t tile) {
        return directory + fjell::chunk_index(h, {fjell::ChunkKind::colour, tile, 0}) * sizeof(fjell::ChunkEntry);
    };
    std::swap_ranges(at(1), at(1) + sizeof(fjell::ChunkEntry), at(4));
    h.directory_hash = XXH3_64bits(directory, h.directory_count * sizeof(fjell::ChunkEntry));
    h.header_hash = XXH3_64bits(&h, offsetof(fjell::PackHeader, header_hash));
    std::memcpy(bytes.data(), &h, sizeof h);
    spit(folder / "swapped.fjell", bytes);
    const Run bad = run_in(folder.path, bake + "verify swapped.fjell");
    CAPTURE(bad.out, bad.err);
    CHECK(bad.code == 1);
    CHECK(bad.out.find("chunks: all checksums agree") != std::string::npos);
    CHECK(bad.err.find("colour map of tile") != std::string::npos);
}

TEST_CASE("height fields that are not are refused in one line with a remedy, and nothing is left") {
    const TemporaryFolder folder;
    refused(folder, bake + "missing.tif -o out.fjell", 1, "missing.tif");
    refused(folder, bake + ". -o out.fjell", 1, "folder");
    spit(folder / "text.tif", "this is not a picture\n");
    refused(folder, bake + "text.tif -o out.fjell", 1, "text.tif");
    spit(folder / "empty.png", "");
    refused(folder, bake + "empty.png -o out.fjell", 1, "empty.png");
    spit(folder / "one.asc", ascii_grid(1, 1, "5"));
    refused(folder, bake + "one.asc -o out.fjell", 1, "one.asc");
    spit(folder / "nan.asc", ascii_grid(9, 9, "nan"));
    refused(folder, bake + "nan.asc -o out.fjell", 1, "nan.asc");
    spit(folder / "void.asc", ascii_grid(9, 9, "-9999", "NODATA_value -9999\n"));
    refused(folder, bake + "void.asc -o out.fjell", 1, "void.asc");
    refused(folder, bake + "void.asc -o out.fjell --nodata fill", 1, "void.asc");
    spit(folder / "high.asc", ascii_grid(9, 9, "1e30"));
    refused(folder, bake + "high.asc -o out.fjell", 1, "high.asc");
}

TEST_CASE("orders, quanta and holes are asked for on the command line and told by info") {
    const TemporaryFolder folder;
    spit(folder / "recipe.json", R"({"columns": 200, "rows": 130, "spacing_m": 60})");
    REQUIRE(run_in(folder.path, bake + "synth recipe.json -o dem.tif").code == 0);
    for (const std::string order : {"planar", "hz", "linear"}) {
        REQUIRE(run_in(folder.path, bake + "dem.tif -o out.fjell --quantum 0.25 --order " + order).code == 0);
        const auto info = nlohmann::json::parse(run_in(folder.path, bake + "info out.fjell --json").out);
        CHECK(info["order"] == order);
        CHECK(info["quantum_m"] == 0.25);
        CHECK(info["holes"] == 0);
        CHECK(info["pages_per_tile"] == 22); // of 256 cells; in linear order by chance the same
        CHECK(run_in(folder.path, bake + "verify out.fjell --against dem.tif").code == 0);
    }
    refused(folder, bake + "dem.tif -o other.fjell --quantum 0.0001", 2, "--quantum 0.0001 m is too small");
    refused(folder, bake + "dem.tif -o other.fjell --order random", 2, "--order");
    std::string text = ascii_grid(40, 30, "7", "NODATA_value -99\n");
    text.replace(text.rfind("7"), 1, "-99");
    spit(folder / "hole.asc", text);
    REQUIRE(run_in(folder.path, bake + "hole.asc -o hole.fjell --json bake.json").code == 0);
    CHECK(nlohmann::json::parse(slurp(folder / "bake.json"))["holes"] == 1);
    CHECK(run_in(folder.path, bake + "verify hole.fjell --against hole.asc").code == 0);
    const Run other = run_in(folder.path, bake + "verify hole.fjell --against hole.asc --nodata fill");
    CHECK(other.code == 1);
    CHECK(other.err.find("is a hole in one of the two") != std::string::npos);
}

TEST_CASE("several files, a region and a recipe make one pack, and the recipe makes it again from anywhere") {
    const TemporaryFolder folder;
    const std::string header = "ncols 40\nnrows 30\nyllcorner 1000\ncellsize 30\nNODATA_value -99\nxllcorner ";
    std::string heights;
    for (int i = 0; i < 1200; ++i) heights += std::to_string(100 + i * 7919 % 1000 / 40) + " ";
    std::filesystem::create_directories(folder / "in");
    spit(folder / "in/west.asc", header + "1000\n" + heights);
    spit(folder / "in/east.asc", header + "2200\n" + heights);
    const std::string files = "in/west.asc in/east.asc";
    REQUIRE(run_in(folder.path, bake + files + " -o whole.fjell").code == 0);
    CHECK(run_in(folder.path, bake + "verify whole.fjell --against " + files).code == 0);
    const std::string read = " --bbox 1300,1200,3000,1700 --zscale 2 --nodata fill";
    REQUIRE(run_in(folder.path, bake + files + " -o part.fjell --order hz --tile 16 --save-recipe in/part.json" + read)
                .code == 0);
    const auto info = nlohmann::json::parse(run_in(folder.path, bake + "info part.fjell --json").out);
    CHECK(info["columns"] == 57); // from 1315 to 2995
    CHECK(info["rows"] == 16);    // from 1225 to 1675
    CHECK(info["origin_m"][0] == 1315);
    const std::string pack = slurp(folder / "part.fjell");
    const auto recipe = nlohmann::json::parse(slurp(folder / "in/part.json"));
    CHECK(recipe["inputs"] == nlohmann::json{"west.asc", "east.asc"});
    CHECK(recipe["output"] == "../part.fjell");
    REQUIRE(run_in(folder.path, "rm part.fjell; cd /; " + bake + "--recipe " + (folder / "in/part.json")).code == 0);
    CHECK(slurp(folder / "part.fjell") == pack);
    CHECK(run_in(folder.path, bake + "verify part.fjell --recipe in/part.json").code == 0);
    CHECK(run_in(folder.path, bake + "verify part.fjell --against " + files + read).code == 0);
    REQUIRE(run_in(folder.path, bake + "--recipe in/part.json -o other.fjell --zscale 1").code == 0);
    CHECK(slurp(folder / "other.fjell") != pack);
    refused(folder, bake + "verify part.fjell --recipe in/part.json --zscale 1", 1, "");
    refused(folder, bake + "--recipe in/missing.json", 1, "missing.json");
    refused(folder, bake + "--recipe in/west.asc", 1, "is not JSON");
    refused(folder, bake + files + " -o part.fjell --save-recipe ./part.fjell", 2, "overwrite");
    refused(folder, bake + "--recipe in/part.json -o in/part.json", 2, "overwrite");
    spit(folder / "in/bad.json", R"({"inputs": ["west.asc"], "output": "x.fjell", "zscael": 2})");
    refused(folder, bake + "--recipe in/bad.json", 1, "\"zscael\" is no key");
}

TEST_CASE("regions, projections and encodings that cannot be are refused in one line") {
    const TemporaryFolder folder;
    spit(folder / "dem.asc", ascii_grid(20, 20, "5"));
    const std::string out = "dem.asc -o out.fjell ";
    refused(folder, bake + out + "--bbox 0,0,10,10", 1, "lies outside");
    refused(folder, bake + out + "--bbox -10,-10,-1,-1", 1, "lies outside");
    refused(folder, bake + out + "--bbox 0,0,10", 2, "WEST,SOUTH,EAST,NORTH");
    refused(folder, bake + out + "--bbox 5,5,1,9", 2, "--bbox");
    refused(folder, bake + out + "--crs EPSG:4326", 2, "is not projected");
    refused(folder, bake + out + "--crs Atlantis", 2, "no CRS that GDAL knows");
    refused(folder, bake + out + "--crs EPSG:32632", 1, "no CRS of its own");
    refused(folder, bake + out + "--encoding png", 2, "--encoding");
    refused(folder, bake + out + "--encoding terrarium", 1, "--encoding");
    spit(folder / "gone.vrt", "<VRTDataset rasterXSize=\"9\" rasterYSize=\"9\"><GeoTransform>0,1,0,1000,0,-1"
                              "</GeoTransform><VRTRasterBand dataType=\"Int16\" band=\"1\"><SimpleSource>"
                              "<SourceFilename>missing.tif</SourceFilename><SourceBand>1</SourceBand></SimpleSource>"
                              "</VRTRasterBand></VRTDataset>");
    refused(folder, bake + "gone.vrt -o out.fjell", 1, "missing.tif");
}

TEST_CASE(
    "a bake stays within the memory it is given, whatever the threads and the tiles, and comes to the same bytes") {
    const TemporaryFolder folder;
    spit(folder / "plain.json",
         R"({"columns": 2100, "rows": 1800, "spacing_m": 15, "gullies": 0, "octaves": 1, "warp": 0})");
    for (const std::string tile : {"1024", "256"}) {
        if (tile == "256" && !full_rounds()) continue;
        REQUIRE(run_in(folder.path, bake + "plain.json --quiet -o a.fjell --memory 2000 --tile " + tile).code == 0);
        const Run little = run_in(folder.path, bake +
                                                   "plain.json --quiet -o b.fjell --memory 192 --threads 12 "
                                                   "--checkpoint 5 --json bake.json --tile " +
                                                   tile);
        CAPTURE(tile, little.err);
        REQUIRE(little.code == 0);
        CHECK(slurp(folder / "a.fjell") == slurp(folder / "b.fjell"));
        const double resident_mb = nlohmann::json::parse(slurp(folder / "bake.json"))["resident_mb_max"];
#ifdef FJELL_SANITIZED
        WARN("skipped: how much memory a bake takes (" << resident_mb << " MB with a sanitizer's own)");
#else
        CHECK(resident_mb > 20);
        CHECK(resident_mb <= 192);
#endif
    }
    refused(folder, bake + "plain.json -o c.fjell --memory 130 --tile 4096 --checkpoint 5", 2, "--memory");

    // It says how much would have been enough.
    const std::string hint = "it worked in files beside the pack; with --memory ";
    const Run files = run_in(folder.path, bake + "plain.json -o c.fjell --memory 128");
    const std::size_t at = files.out.find(hint);
    REQUIRE(at != std::string::npos);
    const int enough = std::stoi(files.out.substr(at + hint.size()));
    CHECK(enough > 128);
    const auto says = [&](int memory_mb) {
        const Run run = run_in(folder.path, bake + "plain.json -o d.fjell --memory " + std::to_string(memory_mb));
        return run.out.find(hint) != std::string::npos;
    };
    CHECK_FALSE(says(enough));
    CHECK(says(enough - 2));
}

TEST_CASE("the smallest height field has two by two samples") {
    const TemporaryFolder folder;
    spit(folder / "two.asc", ascii_grid(2, 2, "5"));
    REQUIRE(run_in(folder.path, bake + "two.asc -o out.fjell").code == 0);
    CHECK(run_in(folder.path, bake + "verify out.fjell --against two.asc").code == 0);
}

TEST_CASE("wrong usage is one line and exit code 2") {
    const TemporaryFolder folder;
    spit(folder / "dem.asc", ascii_grid(9, 9, "5"));
    refused(folder, bake, 2, "no height field");
    refused(folder, bake + "dem.asc", 2, "-o OUT.fjell");
    refused(folder, bake + "dem.asc -o out.fjell --no-such-option", 2, "--help");
    for (const char* spacing : {"0", "-1", "nan", "inf", "1e9", "x"})
        refused(folder, bake + "dem.asc -o out.fjell --spacing " + spacing, 2, "");
    for (const char* tile : {"3", "0", "-2", "8192", "big"})
        refused(folder, bake + "dem.asc -o out.fjell --tile " + tile, 2, "--tile");
    for (const char* nesting : {"0", "-1", "2", "nan"})
        refused(folder, bake + "dem.asc -o out.fjell --nesting " + nesting, 2, "--nesting");
    refused(folder, bake + "dem.asc -o out.fjell --zscale 0", 2, "");
    refused(folder, bake + "dem.asc -o out.fjell --estimate best", 2, "--estimate");
    refused(folder, bake + "synth", 2, "--help");
    for (const char* command : {"merge", "launch"})
        refused(folder, bake + command + " plan -o out/", 2,
                "out/: is a folder's name; add --packs AxB for a pack set, or name a file for a pack");
    // A shell variable that is not set does not mean "not given".
    refused(folder, bake + "dem.asc -o out.fjell --json ''", 2, "after --json");
    refused(folder, bake + "dem.asc -o out.fjell --json=", 2, "--json=");
    refused(folder, bake + "dem.asc -o ''", 2, "after -o");
    refused(folder, bake + "dem.asc -o out.fjell --checkpoint nan", 2, "--checkpoint");
}

TEST_CASE("packs of another version, cut or damaged are refused by info and verify") {
    const TemporaryFolder folder;
    spit(folder / "dem.asc", ascii_grid(17, 17, "5"));
    REQUIRE(run_in(folder.path, bake + "dem.asc -o good.fjell").code == 0);
    const std::string good = slurp(folder / "good.fjell");
    std::string bytes = good;
    bytes[8] = 99;
    spit(folder / "version.fjell", bytes);
    spit(folder / "cut.fjell", good.substr(0, good.size() / 2));
    bytes = good;
    bytes[300] = static_cast<char>(bytes[300] ^ 1);
    spit(folder / "flipped.fjell", bytes);
    spit(folder / "empty.fjell", "");
    refused(folder, bake + "info version.fjell", 1, "bake it again with this one: fjell-bake HEIGHTS -o PACK");
    refused(folder, bake + "info cut.fjell", 1, "too early");
    refused(folder, bake + "verify flipped.fjell", 1, "damaged");
    refused(folder, bake + "verify empty.fjell", 1, "not a Fjell pack");
    refused(folder, bake + "verify missing.fjell", 1, "missing.fjell");
    refused(folder, bake + "info dem.asc", 1, "not a Fjell pack");
}

TEST_CASE("the Grand Canyon is baked, verified and flown for 840 frames within two pixels") {
    const std::string dem = large_real("dem/grand_canyon_60m_4097x2049_u8.png");
    if (dem.empty()) return;
    const TemporaryFolder folder;
    const std::string read = " --spacing 60 --zscale 14.4 --zoffset 127";
    REQUIRE(run_in(folder.path, bake + dem + read + " --tile 512 -o canyon.fjell").code == 0);
    CHECK(run_in(folder.path, bake + "verify canyon.fjell --against " + dem + read).code == 0);
    REQUIRE(run_in(folder.path,
                   FJELL_BIN_DIR "/fjell-fly canyon.fjell --headless --frames 840 --error-px 2 --verify 60 "
                                 "--json flight.json --path " FJELL_SOURCE_DIR "/content/paths/canyon.json")
                .code == 0);
    const auto flight = nlohmann::json::parse(slurp(folder / "flight.json"));
    CHECK(flight["frames"] == 840);
    CHECK(flight["converged_frames"] == 840);
    CHECK(flight["verified_error_px_max"] <= 2.0);
    CHECK(flight["verified_error_px_max"] > 0.5);
    CHECK(flight["pack"]["tiles"] == nlohmann::json{8, 4});
}

TEST_CASE("undeclared voids are refused, and baked as the user says, from the command line and from a recipe") {
    const TemporaryFolder folder;
    std::string basin = "ncols 60\nnrows 50\nxllcorner 1000\nyllcorner 1000\ncellsize 30\n", sea = basin;
    for (int i = 0; i < 3000; ++i) {
        basin += i < 799 ? "-9999 " : std::to_string(i * 7919 % 231) + " ";
        sea += std::to_string(std::max(0, i - 600) * 1.27) + " ";
    }
    spit(folder / "basin.asc", basin);
    spit(folder / "sea.asc", sea);
    refused(folder, bake + "basin.asc -o out.fjell", 1, "799 of 3000 heights are -9999, the first at column 0, row 0");
    refused(folder, bake + "basin.asc -o out.fjell --void x", 2, "--void \"x\"");
    const auto baked = [&](const std::string& words) {
        const Run r = run_in(folder.path, bake + words + " -o out.fjell --json bake.json");
        CAPTURE(words, r.err);
        REQUIRE(r.code == 0);
        return std::pair{nlohmann::json::parse(slurp(folder / "bake.json")), r.out};
    };
    CHECK(baked("--void -9999 --void -32768 basin.asc --save-recipe r.json").first["holes"] == 799);
    CHECK(run_in(folder.path, bake + "verify out.fjell --against basin.asc --void -9999").code == 0);
    CHECK(run_in(folder.path, bake + "verify out.fjell --recipe r.json").code == 0);
    CHECK(baked("--recipe r.json").first["holes"] == 799);
    const Run old_name = run_in(folder.path, bake + "basin.asc --control full -o old.fjell");
    CHECK(old_name.code == 2);
    CHECK(old_name.err == "fjell-bake: --control is called --splat now, and read by its old name until 0.4\n"
                          "fjell-bake: --splat says how fine splat maps are; give their rules with --layers\n");
    const auto ground = baked("--recipe r.json --void none").first;
    CHECK(ground["holes"] == 0);
    CHECK(ground["repeated_lowest"].is_null());
    const auto [summary, said] = baked("sea.asc");
    CHECK(summary["repeated_lowest"]["number"] == 0);
    CHECK(summary["repeated_lowest"]["first"] == nlohmann::json{0, 0});
    CHECK(said.find("% of the heights are 0 m, the lowest, the first at column 0, row 0: taken as ground; if they are "
                    "voids, give --void 0") != std::string::npos);
    // 3,048 m in one tile.
    CHECK(summary["quantum_range_m"] > 3000);
    CHECK(said.find("because 65536 steps of 16 bits span the 304") != std::string::npos);
    const auto finer = baked("sea.asc --tile 4");
    CHECK(finer.first["quantum_m"].get<double>() < 0.011);
    CHECK(finer.second.find("65536") == std::string::npos);
    refused(folder, bake + "sea.asc -o other.fjell --quantum 0.01", 2,
            "m within one tile of 64 cells; give at least 0.0");
}

TEST_CASE("outputs that must be files, heights that nobody can believe and quiet commands are said plainly") {
    const TemporaryFolder folder;
    spit(folder / "a.asc", ascii_grid(9, 9, "12"));
    spit(folder / "high.asc", ascii_grid(9, 9, "1000000"));
    refused(folder, bake + "a.asc -o -", 2, "-: this output cannot go to standard output");
    refused(folder, bake + "high.asc -o high.fjell", 1, "--zoffset M if they count from elsewhere, --void none");
    REQUIRE(run_in(folder.path, bake + "a.asc -o a.fjell --quiet").code == 0);
    for (const char* const command : {"verify a.fjell --against a.asc --quiet", "heights a.fjell -o h.tif --quiet",
                                      "split a.fjell -o set --packs 1x1 --quiet", "join set --quiet",
                                      "plan a.asc -o plan --shards 1 --tile 64 --quiet"}) {
        const Run r = run_in(folder.path, bake + command);
        CAPTURE(command, r.out, r.err);
        CHECK(r.code == 0);
        CHECK(r.out.empty());
        CHECK(r.err.empty());
    }
}
