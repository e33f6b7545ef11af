// Real height fields far apart in a VRT, planned for a pack set, baked in shards, verified and flown: nothing between
// them costs anything. In full rounds both sides have more samples than a pack may have.
#include <catch2/catch.hpp>

#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "bake_cli.h"
#include "support/real_data.h"

using namespace fjell::test;

namespace {

struct Placed {
    std::string file;
    int columns, rows, x, y;
};

std::string vrt_of(int columns, int rows, const std::vector<Placed>& files) {
    std::string text = fmt::format("<VRTDataset rasterXSize=\"{}\" rasterYSize=\"{}\"><SRS>EPSG:32633</SRS>"
                                   "<GeoTransform>300000, 30, 0, 8000000, 0, -30</GeoTransform>"
                                   "<VRTRasterBand dataType=\"Float32\" band=\"1\"><NoDataValue>-9999</NoDataValue>",
                                   columns, rows);
    for (const Placed& f : files)
        text += fmt::format("<SimpleSource><SourceFilename>{}</SourceFilename><SourceBand>1</SourceBand>"
                            "<SrcRect xOff=\"0\" yOff=\"0\" xSize=\"{}\" ySize=\"{}\"/>"
                            "<DstRect xOff=\"{}\" yOff=\"{}\" xSize=\"{}\" ySize=\"{}\"/></SimpleSource>",
                            f.file, f.columns, f.rows, f.x, f.y, f.columns, f.rows);
    return text + "</VRTRasterBand></VRTDataset>";
}

} // namespace

TEST_CASE("real height fields far apart are baked to a sparse set in shards, which verifies and is flown over ground") {
    const std::string norway = real("dem/norway_jotunheimen_117m_512_f32.tif"),
                      crater = real("dem/craterlake_elev_i16_30m.tif");
    if (norway.empty() || crater.empty()) return;
    const bool full = full_rounds();
    const TemporaryFolder folder;
    const int columns = full ? 70'000 : 2'600, rows = full ? 68'000 : 2'000;
    spit(folder / "far.vrt",
         vrt_of(columns, rows,
                {{norway, 512, 512, full ? 60'000 : 1'950, full ? 50'000 : 1'400}, {crater, 429, 279, 70, 90}}));
    const std::string packs = full ? "68x66" : "20x15", options = " --tile 128 --void -32767 --crs keep ";
    REQUIRE(run_in(folder.path, bake + "plan far.vrt -o plan --shards 16 --packs " + packs + options).code == 0);
    const Run refused = run_in(folder.path, bake + "launch plan -o far.fjell --threads 1");
    CHECK(refused.code == 2);
    CHECK(refused.err.find("give --packs " + packs) != std::string::npos);
    const Run launched = run_in(folder.path, bake + "launch plan -o far --threads 1 --at-once 2 --packs " + packs);
    CAPTURE(launched.err);
    REQUIRE(launched.code == 0);
    if (!full) {
        REQUIRE(run_in(folder.path, bake + "far.vrt -o one.fjell" + options + "&& " + bake +
                                        "split one.fjell -o split --packs " + packs + " && diff -r far split")
                    .code == 0);
    }
    const Run verified = run_in(folder.path, bake + "verify far" + (full ? "" : " --against far.vrt --void -32767"));
    CHECK(verified.code == 0);
    CHECK(std::stoull(verified.out) < 10'000'000); // vertices that there are, not those that would have room
    const auto info = nlohmann::json::parse(run_in(folder.path, bake + "info far --json").out);
    CHECK(info.at("packs") < (full ? 6 : 40));
    CHECK(info.at("columns") == columns);
    // From over the ground nearest to the empty middle: from there the rest of the set is a few triangles a tile.
    const Run flown =
        run_in(folder.path, FJELL_BIN_DIR "/fjell-fly far --headless --wait --frames 2 --json flight.json");
    CAPTURE(flown.err);
    REQUIRE(flown.code == 0);
    const auto flight = nlohmann::json::parse(slurp(folder / "flight.json"));
    INFO(flight.dump());
    CHECK(flight.at("triangles_drawn_mean").get<double>() > 5000);
}
