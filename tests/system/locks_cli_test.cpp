// fjell-bake --locks and --coarse: files of several kinds and CRSs, what it says, and what it refuses.
#include <catch2/catch.hpp>

#include <cmath>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "bake_cli.h"
#include "support/rounds.h"

using namespace fjell::test;
using nlohmann::json;

namespace {

// 120 x 90 samples, 30 m apart, with a CRS: dem.tif.
void write_ground(const TemporaryFolder& folder) {
    std::string text = "ncols 120\nnrows 90\nxllcorner 430000\nyllcorner 6790000\ncellsize 30\n";
    for (int y = 0; y < 90; ++y) {
        for (int x = 0; x < 120; ++x) text += std::to_string(900 + 200 * std::sin(x * 0.2) * std::cos(y * 0.17)) + " ";
        text += "\n";
    }
    spit(folder / "dem.asc", text);
    output_of(folder, "gdal_translate -q -a_srs EPSG:32632 dem.asc dem.tif");
}

std::string feature(const std::string& properties, const std::string& kind, const std::string& coordinates) {
    return R"({"type":"Feature","properties":)" + properties + R"(,"geometry":{"type":")" + kind +
           R"(","coordinates":)" + coordinates + "}}";
}
std::string collection(const std::vector<std::string>& features) {
    std::string text;
    for (const std::string& f : features) text += (text.empty() ? "" : ",") + f;
    return R"({"type":"FeatureCollection","crs":{"type":"name","properties":{"name":"EPSG:32632"}},"features":[)" +
           text + "]}";
}
const std::string road = "[[430100,6790200],[431500,6791700],[433300,6792500]]";
const std::string yard = "[[[431000,6790500],[431300,6790500],[431300,6790800],[431000,6790500]]]";

json baked(const TemporaryFolder& folder, const std::string& options) {
    return json::parse(output_of(folder, bake + "dem.tif -o locked.fjell --json - " + options));
}

} // namespace

TEST_CASE("locks come from any vector file in any CRS, and the pack tells of them") {
    const TemporaryFolder folder;
    write_ground(folder);
    spit(folder / "locks.geojson", collection({feature(R"({"error_m":0.05,"width_m":12})", "LineString", road),
                                               feature(R"({"error_px":"0.5"})", "Polygon", yard),
                                               feature(R"({"error_m":0})", "MultiPoint", "[[432000,6790400],[0,0]]")}));
    const json said = baked(folder, "--locks locks.geojson");
    const std::string text = said["locks"];
    CHECK(text == "1 point, 1 line, 1 area; 1 beside the terrain left out; " + said["always_drawn"].dump() +
                      " vertices are always drawn");
    CHECK(said["always_drawn"] > 300);
    output_of(folder, bake + "verify locked.fjell --against dem.tif --quiet");
    CHECK(json::parse(output_of(folder, bake + "info locked.fjell --json -"))["locks"] == text);
    CHECK(output_of(folder, bake + "info locked.fjell").find("locks: " + text) != std::string::npos);
    // The same in degrees, in a database.
    output_of(folder, "ogr2ogr locks.gpkg locks.geojson -t_srs EPSG:4326");
    const json again = baked(folder, "--locks locks.gpkg");
    CHECK(std::abs(again["always_drawn"].get<double>() - said["always_drawn"].get<double>()) <
          0.05 * said["always_drawn"].get<double>());
    // Without locks a pack is what it was, and so is one baked of it; that is said.
    const json bare = baked(folder, "");
    CHECK(bare["locks"].is_null());
    CHECK(bare["always_drawn"] == 0);
    baked(folder, "--locks locks.geojson");
    const std::string out = output_of(folder, bake + "locked.fjell -o next.fjell");
    CHECK(out.find("locked.fjell has locks, and the new pack none; give --locks again") != std::string::npos);
    CHECK(output_of(folder, bake + "locked.fjell --locks locks.geojson -o next.fjell").find("none") ==
          std::string::npos);
}

TEST_CASE("what says no error takes that of the command line, and a million places take no time to speak of") {
    const TemporaryFolder folder;
    write_ground(folder);
    spit(folder / "plain.geojson", collection({feature("{}", "LineString", road)}));
    refused(folder, bake + "dem.tif -o new.fjell --locks plain.geojson", 1,
            "plain.geojson: lock 1: has neither error_m nor error_px; give --lock-error-m for all such");
    const json fine = baked(folder, "--locks plain.geojson --lock-error-m 0.05");
    const json coarse = baked(folder, "--locks plain.geojson --lock-error-m 20");
    CHECK(fine["always_drawn"] > coarse["always_drawn"]);
    std::string places;
    const int count = rounds(100'000, 1'000'000);
    for (int i = 0; i < count; ++i) {
        const double t = i * 0.01;
        places += (i == 0 ? "[" : ",[") + std::to_string(431800 + 1700 * std::sin(t * 1.01)) + "," +
                  std::to_string(6791300 + 1300 * std::sin(t * 0.7)) + "]";
    }
    spit(folder / "many.geojson", collection({feature("{}", "LineString", "[" + places + "]")}));
    CHECK(baked(folder, "--locks many.geojson --lock-error-m 0.05")["always_drawn"] > fine["always_drawn"]);
}

TEST_CASE("locks of a file are laid on a pack as a layer, and are those that a bake holds, flown and baked") {
    const TemporaryFolder folder;
    write_ground(folder);
    const auto said = [&](const std::string& arguments) {
        return json::parse(output_of(folder, bake + arguments + " --json -"));
    };
    output_of(folder, bake + "dem.tif -o plain.fjell --room-for-locks yes --quiet");
    CHECK(said("info plain.fjell")["room_for_locks"] == true);
    spit(folder / "locks.geojson",
         collection({feature(R"({"error_m":0.05,"width_m":12})", "LineString", road),
                     feature(R"({"error_m":0.5})", "Polygon", yard), feature("{}", "Point", "[432000,6790400]")}));
    const std::string file = "locks.geojson --lock-error-m 0", edits = "--edits plain.fjell.journal ";
    const json held = said("plain.fjell --locks " + file + " -o held.fjell");
    CHECK(held["always_drawn"] > 300);
    const json laid = said("locks plain.fjell " + file);
    CHECK((laid["layer"] == "locks" && laid["locks"] == "1 point, 1 line, 1 area" && laid["stamps"] > 3));
    CHECK(said("plain.fjell " + edits + "-o laid.fjell")["always_drawn"] == held["always_drawn"]);
    const auto flown = [&] {
        const json flight = json::parse(output_of(
            folder, std::string(FJELL_BIN_DIR) + "/fjell-fly plain.fjell --headless --frames 2 --json - " + edits));
        CHECK(flight["edits"]["refused"] == 0);
        return flight["edits"]["always_drawn"].get<double>();
    };
    CHECK(std::abs(flown() - held["always_drawn"].get<double>()) < 20); // it counts those at the far rims, too
    refused(folder, bake + "locks plain.fjell " + file, 1, "has a layer \"locks\"; give --replace");
    output_of(folder, bake + "locks plain.fjell " + file + " --replace --quiet");
    CHECK(said("plain.fjell " + edits + "-o laid.fjell")["always_drawn"] == held["always_drawn"]);
    output_of(folder, bake + "journal plain.fjell --strength locks=0.4 --quiet");
    CHECK(said("plain.fjell " + edits + "-o laid.fjell")["always_drawn"] == 0);
    // What stamps cannot hold, and where no pack can.
    spit(folder / "px.geojson", collection({feature(R"({"error_px":0.5})", "LineString", road)}));
    refused(folder, bake + "locks plain.fjell px.geojson --layer more", 1, "px.geojson: a lock has error_px");
    refused(folder, bake + "locks plain.fjell locks.geojson --layer more", 1, "give --lock-error-m for all such");
    output_of(folder, bake + "dem.tif -o guess.fjell --estimate midpoint --quiet");
    refused(folder, bake + "locks guess.fjell " + file, 1, "guess.fjell: has no room for locks");
    spit(folder / "lock.json", R"({"stamps": [{"shape": "lock", "at": [900, 900], "radius_m": 90, "amount_m": 1}]})");
    refused(folder, bake + "dem.tif --edits lock.json --estimate midpoint -o new.fjell", 2, "--estimate midpoint");
}

TEST_CASE("locks that are none are refused in one line, and no pack is made or changed") {
    const TemporaryFolder folder;
    write_ground(folder);
    const auto refuses = [&](const std::string& properties, const std::string& coordinates, const std::string& says) {
        spit(folder / "bad.geojson", collection({feature(properties, "LineString", coordinates)}));
        refused(folder, bake + "dem.tif -o new.fjell --locks bad.geojson", 1, says);
    };
    refuses(R"({"error_m":-1})", road, "bad.geojson: lock 1: error_m is -1, and must be 0 to 1000000");
    refuses(R"({"error_m":"nan"})", road, "bad.geojson: lock 1: error_m is nan");
    refuses(R"({"error_px":2})", road, "error_px is 2, and must be 0.001 to 1");
    refuses(R"({"error_m":1,"width_m":-3})", road, "width_m is -3");
    refuses(R"({"error_m":1})", "[[0,0],[9,9]]", "bad.geojson: its 1 locks all lie beside the terrain");
    refuses(R"({"error_m":1})", "[[\"a\",0],[9,9]]", "bad.geojson");
    spit(folder / "empty.geojson", collection({}));
    refused(folder, bake + "dem.tif -o new.fjell --locks empty.geojson", 1,
            "empty.geojson: has no point, line or polygon");
    refused(folder, bake + "dem.tif -o new.fjell --locks missing.gpkg", 1, "missing.gpkg");
    refused(folder, bake + "dem.tif -o new.fjell --locks dem.tif", 1, "dem.tif: is no file of locks");
    refused(folder, bake + "dem.tif -o new.fjell --lock-error-m 1", 2, "give their file with --locks");
    spit(folder / "good.geojson", collection({feature(R"({"error_m":1})", "LineString", road)}));
    refused(folder, bake + "dem.tif -o new.fjell --locks good.geojson --lock-error-m -1", 2, "--lock-error-m");
    refused(folder, bake + "dem.tif -o new.fjell --locks good.geojson --estimate midpoint", 2, "--estimate midpoint");
    refused(folder, bake + "dem.tif -o good.geojson --locks good.geojson", 2, "good.geojson");
}

namespace {

const std::string sea = "[[[430300,6790300],[433000,6790300],[433000,6792400],[430300,6792400],[430300,6790300]]]";

} // namespace

TEST_CASE("places with less detail come from any vector file, take fewer triangles, and the pack tells of them") {
    const TemporaryFolder folder;
    write_ground(folder);
    spit(folder / "sea.geojson", collection({feature(R"({"detail_m":130})", "Polygon", sea)}));
    const json all = baked(folder, ""), said = baked(folder, "--coarse sea.geojson");
    CHECK(all["coarse"].is_null());
    const std::string text = said["coarse"];
    CHECK(text == "1 area with 4 samples between heights");
    CHECK(json::parse(output_of(folder, bake + "info locked.fjell --json -"))["coarse"] == text);
    CHECK(output_of(folder, bake + "info locked.fjell").find("coarse           " + text) != std::string::npos);
    output_of(folder, bake + "verify locked.fjell");
    CHECK(said["file_bytes"] < all["file_bytes"]);

    // The same from another CRS, from a pack, in little memory, and as shards.
    const auto pack = [&](const std::string& name) { return slurp(folder / name); };
    output_of(folder, "cp locked.fjell first.fjell && ogr2ogr sea.gpkg sea.geojson -t_srs EPSG:4326");
    CHECK(baked(folder, "--coarse sea.gpkg")["file_bytes"] == said["file_bytes"]);
    baked(folder, "--coarse sea.geojson --memory 128 --threads 3");
    CHECK(pack("locked.fjell") == pack("first.fjell"));
    const std::string in_tiles = "dem.tif --tile 64 --coarse sea.geojson ";
    output_of(folder, bake + in_tiles + "-o whole.fjell --quiet && " + bake + "plan " + in_tiles +
                          "-o plan --shards 2 && " + bake + "launch plan -o locked.fjell");
    CHECK(pack("locked.fjell") == pack("whole.fjell"));

    // Stamps come before, and locks count as everywhere: here the bed is as exact as the lock says.
    spit(folder / "pit.json",
         R"({"stamps": [{"shape": "raise", "at": [1500, 900], "radius_m": 200, "amount_m": -40}]})");
    spit(folder / "quay.geojson", collection({feature(R"({"error_m":0.5})", "LineString", road)}));
    const json both =
        baked(folder, "--edits pit.json --coarse sea.geojson --locks quay.geojson --coarse-detail-m 5000");
    CHECK(both["coarse"] == text); // its own number counts
    CHECK(both["always_drawn"] > 10);
    output_of(folder, bake + "verify locked.fjell");

    // What is drawn: fewer triangles of the same view, and the error that the frame says.
    output_of(folder, bake + "dem.tif -o plain.fjell --quiet");
    const auto flown = [&](const std::string& name) {
        return json::parse(output_of(folder, FJELL_BIN_DIR "/fjell-fly " + name +
                                                 " --headless --frames 2 --error-px 0.3 --verify 1 --json -"));
    };
    const json coarse = flown("first.fjell"), fine = flown("plain.fjell");
    CAPTURE(coarse.dump(), fine.dump());
    CHECK(coarse["triangles_max"].get<int>() * 3 < fine["triangles_max"].get<int>() * 2);
    CHECK(coarse["verified_error_px_max"] <= coarse["error_px_effective_max"]);
}

TEST_CASE("places with less detail that are none are refused in one line, and no pack is made") {
    const TemporaryFolder folder;
    write_ground(folder);
    const auto refuses = [&](const std::string& properties, const std::string& kind, const std::string& coordinates,
                             const std::string& says) {
        spit(folder / "bad.geojson", collection({feature(properties, kind, coordinates)}));
        refused(folder, bake + "dem.tif -o new.fjell --coarse bad.geojson", 1, says);
    };
    refuses("{}", "Polygon", sea, "bad.geojson: polygon 1: has no detail_m; give --coarse-detail-m");
    refuses(R"({"detail_m":59})", "Polygon", sea, "detail_m is 59, and must be 60 to 1000000");
    refuses(R"({"detail_m":"nan"})", "Polygon", sea, "detail_m is nan");
    refuses(R"({"detail_m":100})", "LineString", road, "bad.geojson: has no polygon");
    refuses(R"({"detail_m":100})", "Polygon", "[[[0,0],[9,9],[9,0],[0,0]]]",
            "bad.geojson: its 1 polygons all lie beside the terrain");
    refused(folder, bake + "dem.tif -o new.fjell --coarse missing.gpkg", 1, "missing.gpkg");
    refused(folder, bake + "dem.tif -o new.fjell --coarse-detail-m 100", 2, "give their file with --coarse");
    spit(folder / "good.geojson", collection({feature("{}", "Polygon", sea)}));
    refused(folder, bake + "dem.tif -o good.geojson --coarse good.geojson --coarse-detail-m 100", 2, "good.geojson");
}
