// fjell-fly --edits: the ground of a flight moves, and its mesh, its errors, its pictures, its exports and its
// recordings follow.
#include <algorithm>
#include <filesystem>
#include <string>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "support/program.h"
#include "support/rounds.h"
#include "support/temporary_folder.h"

using namespace fjell;
using namespace fjell::test;

namespace {

using nlohmann::json;

// The north-west of the hills that content/edits/craters.json is for: 10 x 7 tiles of 128 cells.
struct EditPlace {
    EditPlace() {
        json recipe = json::parse(slurp(FJELL_SOURCE_DIR "/content/terrain/hills.json"));
        recipe["columns"] = 1281;
        recipe["rows"] = 897;
        spit(folder.path / "hills.json", recipe.dump());
        const std::string bake = FJELL_BIN_DIR "/fjell-bake";
        REQUIRE(run_in(folder.path, bake + " synth hills.json -o dem.tif").code == 0);
        REQUIRE(run_in(folder.path, bake + " dem.tif -o hills.fjell --tile 128 --quiet").code == 0);
        spit(folder.path / "slots.toml", "[stream]\npage_slots = 200\n");
    }
    [[nodiscard]] Run fly(const std::string& arguments) const {
        return run_in(folder.path, "ASAN_OPTIONS=detect_leaks=0 " FJELL_BIN_DIR "/fjell-fly hills.fjell " + arguments);
    }
    TemporaryFolder folder;
};

const EditPlace& edit_place() {
    static const EditPlace one;
    return one;
}

const std::string over = "--headless --frames 6 --size 640x400 --eye 990,85,600 --look 1000,45,560 --error-px 0.3 ";
const std::string edits = "--edits " FJELL_SOURCE_DIR "/content/edits/craters.json ";

} // namespace

TEST_CASE("the error of a flight over moving ground is measured against the new ground, and is what was claimed") {
    for (const char* flags : first_of(3, {"", "--stream on --wait --profile slots.toml", "--method recursive",
                                          "--stream on --profile slots.toml", "--morph time", "--items 300",
                                          "--method recursive --topology strip"})) {
        const Run r = edit_place().fly(over + edits + "--verify 1 --json - " + flags);
        INFO(flags << "\n" << r.err);
        REQUIRE(r.code == 0);
        const json j = json::parse(r.out), e = j["edits"];
        CHECK(j["frames"] == 6);
        CHECK((e["stamps"] == 10 && e["refused"] == 0 && e["loose"] == 0));
        CHECK(e["applied"].get<int>() + e["waiting"].get<int>() == 10);
        if (std::string(flags).find("--stream on --profile") == std::string::npos) {
            CHECK(e["applied"] == 10);
            CHECK(e["samples"].get<int>() > 3000);
            CHECK((e["blocks"].get<int>() > 8 && e["blocks_capacity"] == 1024));
            CHECK((e["apply_us"].get<double>() > 0 && e["measure_us"].get<double>() > 0));
        }
        CHECK(j["verified_ok"] != false);
    }
    const Run still = edit_place().fly(over + "--json -");
    REQUIRE(still.code == 0);
    CHECK(json::parse(still.out)["edits"].is_null());
}

TEST_CASE("ground that takes its time is measured on its way, and a recording of it is repeated bit for bit") {
    const std::string crater =
        R"({"shape": "crater", "at": [1000, 545], "radius_m": 20, "falloff_m": 9, "amount_m": 7,)";
    spit(edit_place().folder.path / "slow.json",
         R"({"stamps": [)" + crater + R"( "morph_s": 0.06}, )" + crater + R"( "morph_s": 1}]})");
    const Run r = edit_place().fly(over + "--edits slow.json --verify 1 --record slow.record.json --json -");
    INFO(r.err);
    REQUIRE(r.code == 0);
    const json j = json::parse(r.out), e = j["edits"];
    CHECK((e["applied"] == 1 && e["refused"] == 0)); // the second has to wait for the first, and is on its way
    CHECK(e["samples"].get<int>() > 3000);           // those of several steps
    CHECK(j["verified_ok"] != false);
    const Run again = edit_place().fly("--headless --replay slow.record.json --verify 1 --json -");
    INFO(again.err);
    REQUIRE(again.code == 0);
    CHECK(json::parse(again.out)["edits"]["samples"] == e["samples"]);
}

TEST_CASE("a flight in which holes are cut is what it claims to be, by both methods, and is repeated bit for bit") {
    const std::string bin = FJELL_BIN_DIR, at = edit_place().folder.path.string(),
                      shafts = "--edits " FJELL_SOURCE_DIR "/content/edits/shafts.json ";
    const std::string bake = bin + "/fjell-bake dem.tif --tile 128 --quantum 0.001 --quiet -o "; // in fine steps
    REQUIRE(run_in(at, bake + "roomy.fjell --room-for-holes yes").code == 0);
    REQUIRE(run_in(at, bake + "fine.fjell").code == 0);
    const auto info = [&](const char* pack) {
        return json::parse(run_in(at, bin + "/fjell-bake info --json - " + pack).out)["room_for_holes"];
    };
    CHECK((info("roomy.fjell") == true && info("fine.fjell") == false));
    const auto fly = [&](const std::string& arguments) {
        return run_in(at, "ASAN_OPTIONS=detect_leaks=0 " + bin + "/fjell-fly " + arguments);
    };
    json samples;
    for (const char* flags : first_of(3, {"", "--stream on --wait --profile slots.toml", "--method recursive",
                                          "--method recursive --topology strip", "--morph time"})) {
        const bool recursive = std::string(flags).find("recursive") != std::string::npos; // which keeps nothing
        const std::string record = recursive ? "" : "--record holes.record.json ";
        const Run r = fly("roomy.fjell " + over + shafts + "--verify 1 --json - " + record + flags);
        INFO(flags << "\n" << r.err);
        REQUIRE(r.code == 0);
        const json j = json::parse(r.out), e = j["edits"];
        CHECK((e["applied"] == 6 && e["refused"] == 0 && e["loose"] == 0));
        CHECK((samples.is_null() || samples == e["samples"]));
        samples = e["samples"];
        CHECK(j["verified_ok"] != false);
        if (recursive) continue;
        const Run again = fly("roomy.fjell --headless --replay holes.record.json --verify 1 --json -");
        INFO(again.err);
        REQUIRE(again.code == 0);
        CHECK(json::parse(again.out)["edits"]["samples"] == samples);
    }
    // What is baked has the holes that were flown.
    const Run baked =
        run_in(at, bin + "/fjell-bake roomy.fjell " + shafts + "-o shafts.fjell --tile 128 --json - --quiet");
    INFO(baked.err);
    REQUIRE(baked.code == 0);
    CHECK(json::parse(baked.out)["holes"].get<int>() > 200);
    // A pack without room says so, and nothing is lost.
    const Run refused = fly("fine.fjell " + over + shafts);
    CHECK(refused.code == 1);
    CHECK(refused.err.find("bake") != std::string::npos);
    CHECK(std::count(refused.err.begin(), refused.err.end(), '\n') == 1);
}

TEST_CASE("pictures and snapshots of a flight show the new ground from its frame on") {
    REQUIRE(edit_place().fly(over + "--render still --export 5:still.glb").code == 0);
    const Run r = edit_place().fly(over + edits + "--render moved --export 0:first.glb --export 5:moved.glb");
    INFO(r.err);
    REQUIRE(r.code == 0);
    const auto same = [](const char* a, const char* b) { // said without the bytes
        return slurp(edit_place().folder.path / a) == slurp(edit_place().folder.path / b);
    };
    CHECK(!same("still/frame_00005.png", "moved/frame_00005.png"));
    CHECK(!same("moved/frame_00000.png", "moved/frame_00005.png"));
    CHECK(same("still/frame_00000.png", "still/frame_00005.png"));
    CHECK(!same("still.glb", "moved.glb"));
    CHECK(!same("first.glb", "moved.glb"));
}

TEST_CASE("a recorded flight over moving ground is repeated bit for bit") {
    for (const char* flags : {"", "--stream on --wait --profile slots.toml"}) {
        const Run flown = edit_place().fly(over + edits + "--record r.json " + flags);
        INFO(flags << "\n" << flown.err);
        REQUIRE(flown.code == 0);
        const Run again = edit_place().fly("--headless --replay r.json --verify 1 --json -");
        INFO(again.err);
        REQUIRE(again.code == 0);
        const json j = json::parse(again.out);
        CHECK((j["edits"]["applied"] == 10 && j["verified_ok"] != false));
    }
    std::string text = slurp(edit_place().folder.path / "r.json");
    const std::size_t depth = text.find("\"amount_m\":9.0");
    REQUIRE(depth != std::string::npos);
    text.replace(depth, 14, "\"amount_m\":8.5");
    spit(edit_place().folder.path / "other.json", text);
    const Run other = edit_place().fly("--headless --replay other.json");
    CHECK(other.code == 1);
    CHECK(other.err.find("is not the recorded one") != std::string::npos);
}

TEST_CASE("stamps that cannot be are refused in one line: before the flight what the file says, after it what the "
          "ground says") {
    const auto refused = [](const std::string& file, const std::string& arguments, const std::string& part) {
        spit(edit_place().folder.path / "bad.json", file);
        const Run r = edit_place().fly(over + "--edits bad.json " + arguments);
        INFO(file << "\n" << r.err);
        CHECK(r.code == 1);
        CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
        CHECK(r.err.starts_with("fjell-fly: bad.json"));
        CHECK(r.err.find(part) != std::string::npos);
    };
    refused("{\"stamps\": [\n{\"shape\": \"crater\", \"at\": [1, 2], \"radius_m\": \"9\", \"amount_m\": 1}]}", "",
            "bad.json:2: stamp 0: \"radius_m\" must hold numbers");
    refused("{\"stamps\": [", "", "is not JSON");
    refused(R"({"stamps": [{"frame": 6, "shape": "smooth", "at": [9, 9], "radius_m": 9}]})", "",
            "the flight has frames 0 to 5");
    const std::string large = R"({"stamps": [{"shape": "raise", "at": [600, 400], "radius_m": 200, "amount_m": 2}]})";
    refused(large, "--edit-blocks 4", "stamp 0: EditBudget::blocks");
    refused(R"({"stamps": [{"shape": "raise", "at": [600, 400], "radius_m": 9, "amount_m": 90000}]})", "",
            "stamp 0: Stamp (");
    const Run replay = edit_place().fly("--headless --replay r.json --edits bad.json");
    CHECK(replay.code == 2);
    CHECK(replay.err.find("leave out") != std::string::npos);
}
