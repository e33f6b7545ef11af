// fjell-bake journal and rebase: layers of stamps beside a pack, flown, baked, carried over; and what a full disk, a
// kill or another program leaves of them.
#include <filesystem>
#include <tuple>
#include <utility>

#include <nlohmann/json.hpp>

#include "system/bake_faults.h"

using namespace fjell::test;

namespace {

using nlohmann::json;

const std::string journal_tool = FJELL_BIN_DIR "/fjell-bake ";

std::string crater(double x, double z, double depth) {
    return json{{"shape", "crater"}, {"at", {x, z}}, {"radius_m", 25}, {"falloff_m", 12}, {"amount_m", depth}}.dump();
}

struct JournalPlace {
    JournalPlace() {
        json recipe = json::parse(slurp(FJELL_SOURCE_DIR "/content/terrain/hills.json"));
        recipe["columns"] = recipe["rows"] = 257;
        spit(folder / "hills.json", recipe.dump());
        made("synth hills.json -o dem.tif");
        made("dem.tif -o hills.fjell --tile 128 --quiet");
        made("dem.tif -o other.fjell --tile 64 --quiet");
        spit(folder / "low.json", R"({"stamps": [)" + crater(80, 90, 5) + "]}");
        spit(folder / "high.json", R"({"stamps": [)" + crater(95, 90, 4) + ", " + crater(180, 150, 6) + "]}");
    }
    [[nodiscard]] Run run(const std::string& arguments) const { return run_in(folder.path, journal_tool + arguments); }
    void made(const std::string& arguments) const {
        const Run r = run(arguments);
        INFO(arguments << "\n" << r.err);
        REQUIRE(r.code == 0);
    }
    [[nodiscard]] json journal(const std::string& changes = "") const {
        const Run r = run("journal hills.fjell --json - " + changes);
        INFO(r.err);
        REQUIRE(r.code == 0);
        return json::parse(r.out);
    }
    void refused(const std::string& arguments, int code, const std::string& part) const {
        const Run r = run(arguments);
        INFO(arguments << "\n" << r.err);
        CHECK((r.code == code && one_line(r.err) && r.err.find(part) != std::string::npos));
    }
    TemporaryFolder folder;
};

} // namespace

TEST_CASE("a journal's layers are flown and baked as they are switched, and belong to one pack") {
    const JournalPlace place;
    place.refused("journal hills.fjell", 1, "hills.fjell.journal");
    (void)place.journal("--add low.json --layer low");
    json j = place.journal("--add high.json --layer high");
    CHECK((j["layers"][0]["name"] == "low" && j["layers"][1]["name"] == "high" && j["layers"][1]["stamps"] == 2));
    const auto baked = [&](const std::string& edits) {
        place.made("hills.fjell --edits " + edits + " -o out.fjell --tile 128 --quiet");
        return slurp(place.folder / "out.fjell");
    };
    // The notes of a pack name its files; so the same stamps come from a file of the same name.
    const auto stamps_of = [&](const std::string& stamps) {
        spit(place.folder / "hills.fjell.journal.json", R"({"stamps": [)" + stamps + "]}");
        place.made("heights hills.fjell --edits hills.fjell.journal.json -o a.tif");
        place.made("heights hills.fjell --edits hills.fjell.journal -o b.tif");
        return slurp(place.folder / "a.tif") == slurp(place.folder / "b.tif");
    };
    const std::string low = crater(80, 90, 5), high = crater(95, 90, 4) + ", " + crater(180, 150, 6);
    CHECK(stamps_of(low + ", " + high));
    const std::string both = baked("hills.fjell.journal");
    j = place.journal("--off high --strength low=0.5");
    CHECK((j["layers"][0]["strength"] == 0.5 && j["layers"][1]["on"] == false));
    json half = json::parse(low);
    half["strength"] = 0.5;
    CHECK(stamps_of(half.dump()));
    CHECK((baked("hills.fjell.journal") != both));
    (void)place.journal("--on high --strength low=1 --move low=1");
    CHECK(stamps_of(high + ", " + low));
    (void)place.journal("--move low=0");
    CHECK((baked("hills.fjell.journal") == both));
    CHECK(place.journal()["dead_bytes"] > 0);
    CHECK(place.journal("--compact --stamps all.json")["dead_bytes"] == 0);
    CHECK(stamps_of(low + ", " + high));
    CHECK(json::parse(slurp(place.folder / "all.json"))["stamps"].size() == 3);
    // Flown: as many stamps, and the mesh is measured against the ground that they make.
    const Run r = run_in(place.folder.path, "ASAN_OPTIONS=detect_leaks=0 " FJELL_BIN_DIR
                                            "/fjell-fly hills.fjell --headless --frames 4 --size 320x200 --edits "
                                            "hills.fjell.journal --verify 1 --json -");
    INFO(r.err);
    REQUIRE(r.code == 0);
    const json flown = json::parse(r.out);
    CHECK((flown["edits"]["applied"] == 3 && flown["edits"]["refused"] == 0 && flown["verified_ok"] != false));
    // Another pack's.
    place.refused("other.fjell --edits hills.fjell.journal -o out.fjell", 1, "fjell-bake rebase");
    place.refused("dem.tif --edits hills.fjell.journal -o out.fjell", 1, "belongs to a pack");
    place.refused("journal other.fjell --journal hills.fjell.journal", 1, "fjell-bake rebase");
    place.made("rebase hills.fjell.journal other.fjell");
    place.made("heights other.fjell --edits other.fjell.journal -o a.tif");
    place.made("heights hills.fjell --edits hills.fjell.journal -o b.tif");
    CHECK((slurp(place.folder / "a.tif") == slurp(place.folder / "b.tif")));
    place.refused("journal hills.fjell --off nothing", 1, "its layers are low, high");
    place.refused("journal hills.fjell --strength low", 2, "NAME=NUMBER");
    place.refused("journal hills.fjell --move low=7", 2, "0 (the bottom) to 1");
    place.refused("journal hills.fjell --add low.json", 2, "--layer");
    place.refused("journal hills.fjell --stamps hills.fjell.journal", 2, "would overwrite");
    (void)place.journal("--remove low --remove high");
    place.refused("journal hills.fjell --stamps none.json", 1, "no stamp of it applies");
}

TEST_CASE("a flight opens the journal beside its pack, or flies without it, and says which") {
    const JournalPlace place;
    const auto fly = [&](const std::string& arguments) {
        return run_in(place.folder.path, "ASAN_OPTIONS=detect_leaks=0 " FJELL_BIN_DIR
                                         "/fjell-fly hills.fjell --headless --json - " +
                                             arguments);
    };
    const auto flown = [&](const std::string& arguments, bool says) {
        const Run r = fly(arguments);
        INFO(arguments << "\n" << r.err);
        REQUIRE(r.code == 0);
        CHECK((says ? one_line(r.err) && r.err.find("hills.fjell.journal: 1 stamps") != std::string::npos
                    : r.err.empty()));
        return json::parse(r.out)["edits"];
    };
    const std::string frames = "--frames 2 --size 320x200 ";
    CHECK(flown(frames, false).is_null());
    (void)place.journal("--add low.json --layer low");
    const json asked = flown(frames + "--edits hills.fjell.journal", false);
    CHECK((asked["applied"] == 1 && asked["samples"] > 0));
    const json found = flown(frames + "--record r.json", true);
    CHECK((found["applied"] == 1 && found["samples"] == asked["samples"]));
    CHECK(flown(frames + "--edits high.json", false)["applied"] == 2); // in its place
    CHECK(flown(frames + "--edits none", false).is_null());
    (void)place.journal("--off low");
    CHECK(flown(frames, false).is_null()); // nothing applies
    CHECK(flown("--replay r.json", false)["applied"] == 1);
    const std::string journal = place.folder / "hills.fjell.journal";
    for (const bool damaged : {false, true}) {
        std::filesystem::remove(journal);
        if (damaged)
            spit(journal, "FJELLJN");
        else
            place.made("journal other.fjell --journal hills.fjell.journal --add low.json --layer low --quiet");
        const Run r = fly(frames);
        INFO(r.err);
        CHECK((r.code == 0 && one_line(r.err) && json::parse(r.out)["edits"].is_null()));
        CHECK(r.err.find("without its journal: hills.fjell.journal: ") != std::string::npos);
        CHECK(flown(frames + "--edits none", false).is_null());
    }
}

TEST_CASE("info says what journal lies beside a pack, whether it is the pack's, and what is wrong with it") {
    const JournalPlace place;
    const auto told = [&] {
        const Run table = place.run("info hills.fjell"), r = place.run("info hills.fjell --json -");
        REQUIRE((table.code == 0 && table.err.empty() && r.code == 0 && r.err.empty()));
        const std::size_t at = table.out.find("\njournal  ");
        const std::size_t line = at == std::string::npos ? at : at + 1;
        return std::pair(json::parse(r.out)["journal"],
                         at == std::string::npos ? "" : table.out.substr(line, table.out.find('\n', line) - line));
    };
    CHECK(told() == std::pair(json(), std::string()));
    (void)place.journal("--add low.json --layer low");
    const json whole = place.journal("--add high.json --layer high --off low");
    auto [j, line] = told();
    CHECK((j["of_this_pack"] == true && j["layers"] == whole["layers"] && j["bytes"] == whole["bytes"]));
    const std::string journal = place.folder / "hills.fjell.journal";
    CHECK(j["bytes"] == std::filesystem::file_size(journal));
    CHECK(line.find("hills.fjell.journal: 2 edit layers, 3 stamps, " + j["bytes"].dump() + " bytes; of this pack") !=
          std::string::npos);
    place.made("hills.fjell --quantum 0.5 -o hills.fjell.new --quiet");
    std::filesystem::rename(place.folder / "hills.fjell.new", place.folder / "hills.fjell");
    std::tie(j, line) = told();
    CHECK((j["of_this_pack"] == false && j["layers"] == whole["layers"]));
    CHECK(line.find("fjell-bake rebase") != std::string::npos);
    spit(journal, "FJELLJN");
    std::tie(j, line) = told();
    CHECK((!j.contains("layers") && j["problem"].get<std::string>().find("hills.fjell.journal") != std::string::npos));
    CHECK(line.find(j["problem"].get<std::string>()) != std::string::npos);
}

TEST_CASE("after a full disk, a failing one or a kill at any call a journal says what it said before or after") {
    const JournalPlace place;
    (void)place.journal("--add low.json --layer low");
    const std::string file = place.folder / "hills.fjell.journal", before_bytes = slurp(file);
    const json before = place.journal()["layers"];
    int failed = 0, killed = 0;
    for (const std::string change : {"--add high.json --layer high", "--compact --add high.json --layer high"}) {
        const std::string command = journal_tool + "journal hills.fjell --quiet " + change;
        spit(file, before_bytes);
        const json after = place.journal(change)["layers"];
        spit(file, before_bytes);
        const std::string calls = "open,pwrite,fsync,rename,close";
        const Run counted =
            run_in(place.folder.path, with({calls, "none", "1", "journal"}, command, place.folder / "count"));
        REQUIRE(counted.code == 0);
        const long count = std::strtol(slurp(place.folder / "count").c_str(), nullptr, 10);
        REQUIRE(count > 3);
        for (const char* const what : {"ENOSPC", "EIO", "short", "kill"})
            for (long call = 1; call <= count; ++call) {
                spit(file, before_bytes);
                const Run r = run_in(place.folder.path, with({calls, what, std::to_string(call), "journal"}, command));
                INFO(change << " " << what << " " << call << ": " << r.code << " " << r.err);
                const bool dies = std::string(what) == "kill";
                CHECK((dies ? r.code >= 128 : r.code == 0 || (r.code == 3 && one_line(r.err))));
                killed += dies, failed += r.code == 3;
                const Run read = place.run("journal hills.fjell --json -");
                REQUIRE(read.code == 0);
                const json now = json::parse(read.out)["layers"];
                const bool has_layer_only = now.size() == 2 && now[1]["stamps"] == 0; // a record of its own
                CHECK((now == before || now == after || has_layer_only));
                CHECK((r.code != 0 || now == after)); // confirmed
                // The next program goes on from there.
                if (now != after) CHECK(place.journal(change)["layers"] == after);
            }
    }
    CHECK((failed > 10 && killed > 10));
}

TEST_CASE("a journal is applied from what its stamps reach, or from all with a line that says why") {
    const JournalPlace place;
    json recipe = json::parse(slurp(FJELL_SOURCE_DIR "/content/terrain/hills.json"));
    recipe["columns"] = recipe["rows"] = 1025;
    spit(place.folder / "wide.json", recipe.dump());
    place.made("synth wide.json -o wide.tif");
    place.made("wide.tif -o rounded.fjell --tile 256 --quiet");
    place.made("rounded.fjell -o wide.fjell --tile 256 --quiet"); // baked from heights on its own steps
    const auto applied = [&](const std::string& arguments) {
        const Run r = place.run("apply " + arguments);
        CAPTURE(arguments, r.err);
        REQUIRE(r.code == 0);
        return r.out;
    };
    // Of its own journal, and of stamps in a file: the same.
    place.made("journal wide.fjell --add low.json --layer craters");
    CHECK(applied("wide.fjell -o dug.fjell").find("no stamp reaches") != std::string::npos);
    CHECK(applied("wide.fjell low.json -o again.fjell").find("no stamp reaches") != std::string::npos);
    CHECK(slurp(place.folder / "again.fjell") == slurp(place.folder / "dug.fjell"));
    CHECK(applied("rounded.fjell low.json -o sound.fjell").find("no stamp reaches") != std::string::npos);
    place.made("verify dug.fjell");
    place.made("verify sound.fjell");
    place.made("heights wide.fjell --edits low.json -o dug.tif");
    place.made("verify sound.fjell --against dug.tif");

    const auto all_baked = [&](const std::string& arguments, const std::string& why) {
        const std::string said = applied(arguments);
        CAPTURE(said);
        CHECK(said.find("all of it was baked: " + why) != std::string::npos);
    };
    all_baked("wide.fjell --nesting 0.1 -o all.fjell", "it was baked with other options");
    spit(place.folder / "peak.json",
         R"({"stamps": [{"shape": "raise", "at": [300, 300], "radius_m": 20, "amount_m": 900}]})");
    all_baked("wide.fjell peak.json -o all.fjell", "stamps move");
    place.refused("apply wide.tif -o all.fjell", 1, "is no pack");
    place.refused("apply hills.fjell -o all.fjell", 1, "hills.fjell.journal");
    place.refused("apply other.fjell wide.fjell.journal -o all.fjell", 1, "another pack");
}
