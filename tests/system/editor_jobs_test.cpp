// Bake, tune, benchmark and export by the built editor without a window, as a script asks for them.
#include <algorithm>
#include <filesystem>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "fjell/io/live_terrain.h"
#include "fjell/profile.h"
#include "session/record.h"
#include "support/program.h"
#include "support/temporary_folder.h"

using namespace fjell;

namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::Run;
using test::slurp;
using test::spit;

class EditorFiles {
public:
    EditorFiles() {
        spit(folder / "hills.json",
             R"({"columns": 513, "rows": 513, "spacing_m": 60, "seed": 7, "relief_m": 2500, "feature_m": 6000})");
    }

    // What the state is after these commands, and `more` besides on the command line, after `before` in the shell. No
    // pixel is looked at, so few cases fill them, and those with the light that software draws fastest.
    [[nodiscard]] json after(const std::vector<std::string>& commands, const std::string& more = "",
                             const std::string& before = "") const {
        // In a sanitized build Mesa's own bytes would count as a leak of ours.
        std::string line = before + (fills_pixels ? "" : test::no_pixels) +
                           "ASAN_OPTIONS=detect_leaks=0 " FJELL_BIN_DIR
                           "/fjell-editor --headless --size 640x480 --profile '" +
                           (profiles() / "plain.toml").string() + "' " + more;
        for (const std::string& c : commands) line += " --do '" + c + "'";
        const Run r = test::run_in(folder, line + " --do 'dump state.json'");
        INFO(line << "\n" << r.err);
        last_code = r.code;
        REQUIRE(r.code <= 3);
        json state = json::parse(slurp(folder / "state.json"));
        fs::remove(folder / "state.json");
        return state;
    }
    // A state that the commands have dumped on their way.
    [[nodiscard]] json dumped(const std::string& name) const {
        json state = json::parse(slurp(folder / name));
        fs::remove(folder / name);
        return state;
    }
    // Baked once a process, by the editor as in the first case below.
    void bake() const { spit(folder / "hills.fjell", baked_hills().bytes); }
    struct Baked {
        std::string bytes;
        json state;
        std::vector<std::string> files;
    };
    [[nodiscard]] static const Baked& baked_hills() {
        static const Baked baked = [] {
            const EditorFiles place;
            json state = place.after({"bake hills.json hills.fjell tile=128", "wait"});
            REQUIRE(place.last_code == 0);
            return Baked{slurp(place.folder / "hills.fjell"), std::move(state), place.files()};
        }();
        return baked;
    }
    [[nodiscard]] std::vector<std::string> files() const { return own.names(); }

    test::TemporaryFolder own;
    fs::path folder = own.path;
    bool fills_pixels = false; // for what is said of the time that drawing takes
    mutable int last_code = 0; // of after(): the first failure's, for scripts

private:
    [[nodiscard]] static const fs::path& profiles() {
        static const test::TemporaryFolder folder_of_all;
        // Little memory to clear: most of these programs live for a few frames.
        spit(folder_of_all / "plain.toml", "[budget]\nvertices = 262144\ntriangles = 524288\n"
                                           "[view]\nwidth_px = 640\nheight_px = 360\n"
                                           "[light]\nair = \"simple\"\ndetail = false\ndither = false\n");
        return folder_of_all.path;
    }
};

std::string last_message(const json& state) {
    const json& all = state["messages"];
    return all.empty() ? "" : all.back()["text"].get<std::string>();
}

} // namespace

TEST_CASE("a bake by command writes the pack and opens it") {
    const auto& [bytes, state, files] = EditorFiles::baked_hills();
    CHECK(state["scene"]["path"] == "hills.fjell");
    CHECK(state["scene"]["columns"] == 513);
    CHECK(state["scene"]["tiles"] == json({4, 4}));
    CHECK(state["job"]["problem"] == "");
    CHECK(files == std::vector<std::string>{"hills.fjell", "hills.json"});
}

TEST_CASE("a bake that cannot be, or is cancelled, is a message and leaves nothing") {
    const EditorFiles place;
    const json state =
        place.after({"bake none.tif x.fjell", "wait", "dump none.json", "bake hills.json x.fjell tile=100", "wait",
                     "dump tile.json", "bake hills.json x.fjell", "cancel", "wait"});
    CHECK_THAT(last_message(place.dumped("none.json")), Catch::Contains("none.tif"));
    CHECK_THAT(last_message(place.dumped("tile.json")), Catch::Contains("100"));
    CHECK(state["job"]["cancelled"] == true);
    CHECK_THAT(last_message(state), Catch::Contains("bake cancelled"));
    CHECK(place.files() == std::vector<std::string>{"hills.json"});
}

TEST_CASE("freezing before anything was drawn freezes what is seen then") {
    const EditorFiles place;
    place.bake();
    const json s = place.after({"freeze on", "frames 2"}, "hills.fjell");
    CHECK(s["camera"]["refining_eye_m"] == s["camera"]["view_eye_m"]);
    const json& view = s["interface"]["view_px"];
    CHECK(s["camera"]["refining_px"] == json({view[2], view[3]}));
    // The same of a pack that a script opens, when none was before.
    const json opened = place.after({"open hills.fjell", "freeze on", "frames 2"});
    CHECK(opened["camera"]["refining_px"] == json({view[2], view[3]}));
}

TEST_CASE("a tuning by command sets the threshold only when it shall, as one undo step, and writes its curve") {
    const EditorFiles place;
    place.bake();
    const std::string words = "tune frames=20 budget_us=1000000 least_px=2 csv=";
    const json applied = place.after({"set refine.max_error_px 5", words + "curve0.csv", "wait", "dump tuned.json",
                                      words + "curve1.csv apply=yes", "wait"},
                                     "hills.fjell");
    const json tuned = place.dumped("tuned.json");
    for (const bool apply : {false, true}) {
        const json& state = apply ? applied : tuned;
        INFO(last_message(state));
        CHECK(state["job"]["best_px"] == 2);
        CHECK(state["profile"]["refine.max_error_px"] == (apply ? 2 : 5));
        CHECK(state["document"]["undo"] == (apply ? 2 : 1));
        CHECK(state["job"]["curve"].size() == 5);
        const std::string csv = slurp(place.folder / (apply ? "curve1.csv" : "curve0.csv"));
        CHECK(std::count(csv.begin(), csv.end(), '\n') == 6);
        CHECK_THAT(last_message(state), Catch::Contains("2 px, the smallest allowed, over an orbit: p99 ") &&
                                            Catch::Contains(" of 1,000 ms, mostly for "));
    }
}

TEST_CASE("a tuning of whole frames draws them in a context of its own") {
    EditorFiles place;
    place.fills_pixels = true;
    place.bake();
    const std::string words = "tune frames=10 budget_us=1000000 least_px=8 measure=";
    const json update =
        place.after({words + "frame", "wait", "dump frame.json", words + "update", "wait"}, "hills.fjell");
    const auto p50_us = [&](const json& state) {
        INFO(last_message(state));
        CHECK(state["job"]["best_px"] == 8);
        return state["job"]["curve"].back()["p50_us"].get<double>();
    };
    // Drawing takes far longer than finding some hundred vertices.
    CHECK(p50_us(place.dumped("frame.json")) > 2 * p50_us(update));
}

TEST_CASE("a benchmark and an export by command write their files, and a preview says how large one will be") {
    const EditorFiles place;
    place.bake();
    // The mesh as it stands lags where a frame may do nothing; the one that its view settles on does not.
    const json own = place.after({"benchmark b.csv 25",
                                  "wait",
                                  "dump flown.json",
                                  "set refine.max_error_px 3",
                                  "wait",
                                  "preview",
                                  "wait",
                                  "dump preview.json",
                                  "export m.glb",
                                  "wait",
                                  "dump written.json",
                                  "export n.glb 12",
                                  "wait",
                                  "dump own.json",
                                  "set budget.max_work 1",
                                  "set refine.max_error_px 0.5",
                                  "frames 1",
                                  "export l.glb",
                                  "set budget.max_work 0",
                                  "wait",
                                  "dump stands.json",
                                  "set refine.max_error_px 3",
                                  "wait",
                                  "set budget.max_work 1",
                                  "set refine.max_error_px 0.5",
                                  "frames 1",
                                  "export c.glb converged",
                                  "set budget.max_work 0",
                                  "wait"}, // waits until the view has settled
                                 "hills.fjell");
    CHECK_THAT(last_message(place.dumped("flown.json")), Catch::Contains("b.csv: 25 frames"));
    const std::string csv = slurp(place.folder / "b.csv");
    CHECK(std::count(csv.begin(), csv.end(), '\n') == 26);
    const json preview = place.dumped("preview.json")["job"]["preview"];
    CHECK(preview["error_px"] == 3);
    CHECK(preview == place.dumped("written.json")["job"]["preview"]);
    CHECK(fs::file_size(place.folder / "m.glb") == preview["bytes"]);
    const json stands = place.dumped("stands.json")["job"]["preview"], settles = own["job"]["preview"];
    CHECK(stands["error_px"].get<double>() > 0.5);
    CHECK(settles["error_px"] == 0.5);
    CHECK(settles["triangles"].get<int>() > stands["triangles"].get<int>());
    CHECK(place.dumped("own.json")["job"]["preview"]["error_px"] == 12);
    CHECK(fs::file_size(place.folder / "n.glb") < fs::file_size(place.folder / "m.glb"));
}

TEST_CASE("what is exported is the terrain that is shown, whenever its pack is baked again") {
    const EditorFiles place;
    spit(place.folder / "p.json", R"({"columns": 129, "rows": 129, "spacing_m": 60, "seed": 7, "relief_m": 2500})");
    spit(place.folder / "q.json", R"({"columns": 193, "rows": 193, "spacing_m": 60, "seed": 8, "relief_m": 2500})");
    for (const std::string name : {"p", "q"})
        REQUIRE(
            test::run_in(place.folder, FJELL_BIN_DIR "/fjell-bake " + name + ".json -o " + name + " --quiet").code ==
            0);
    fs::copy_file(place.folder / "p", place.folder / "t.fjell");
    fs::copy_file(place.folder / "q", place.folder / "t.fjell.new");
    // Before the first of the reads that an export makes.
    const json state = place.after({"export e.glb 2", "wait"}, "t.fjell",
                                   "LD_PRELOAD=" FJELL_FAULTS " FJELL_FAULT='pread t.fjell replace 6' ");
    REQUIRE(fs::file_size(place.folder / "t.fjell") == fs::file_size(place.folder / "q")); // it was replaced
    CHECK(state["scene"]["columns"] == 129);
    CHECK(slurp(place.folder / "e.glb").find("\"size\":[129,129]") != std::string::npos);
}

TEST_CASE("a disk that takes no more bytes is a message, and nothing half-written stays") {
    const EditorFiles place;
    place.bake();
    const auto before = place.files();
    // A limit on file sizes stands for a full disk: writing fails in the same place.
    const json flown =
        place.after({"frames 3", "export m.glb 1", "wait", "dump exported.json", "benchmark b.csv 2000", "wait"},
                    "hills.fjell", "ulimit -f 64; ");
    const json exported = place.dumped("exported.json");
    for (const json* const state : {&exported, &flown}) {
        INFO(last_message(*state));
        CHECK((*state)["messages"].back()["severity"] == "error");
        CHECK((*state)["job"]["problem"] != "");
    }
    CHECK(place.last_code == 3);
    CHECK(place.files() == before);
}

TEST_CASE("quitting in the middle of a job cancels it and leaves nothing") {
    const EditorFiles place;
    place.bake();
    const auto before = place.files();
    const Run r = test::run_in(place.folder, test::no_pixels +
                                                 "ASAN_OPTIONS=detect_leaks=0 " FJELL_BIN_DIR
                                                 "/fjell-editor hills.fjell --headless --size 640x480 "
                                                 "--do 'benchmark b.csv 1000000' --do 'frames 3' --do 'quit discard'");
    CHECK(r.code == 0);
    CHECK(place.files() == before);
}

TEST_CASE("jobs without a terrain, beside another job or out of range are refused in a line") {
    const EditorFiles place;
    const json none = place.after({"tune", "benchmark b.csv", "export m.glb", "preview"});
    CHECK_THAT(last_message(none), Catch::Contains("no terrain is open; open a pack first"));
    CHECK(none["messages"].back()["times"] == 4);
    CHECK(place.last_code == 2);
    place.bake();
    const json beside = place.after(
        {"frames 2", "export no/m.glb", "wait", "dump out.json", "benchmark b.csv 1000000", "preview"}, "hills.fjell");
    CHECK_THAT(last_message(place.dumped("out.json")), Catch::Contains("no/m.glb"));
    CHECK_THAT(last_message(beside), Catch::Contains("another job is running"));
}

TEST_CASE("heights that a script opens are baked beside themselves without a dialog, and never over a file") {
    const EditorFiles place;
    spit(place.folder / "dem.asc", "ncols 3\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize 30\n1 2 3\n3 4 5\n5 6 7\n");
    const json refused = place.after({"open dem.asc", "set refine.max_error_px 3", "dump baked.json", "open dem.asc"});
    const json state = place.dumped("baked.json");
    for (const json& message : state["messages"]) CHECK(message["severity"] != "error");
    CHECK(state["interface"]["dialog"] == "none");
    CHECK(state["scene"]["path"] == "dem.fjell");
    CHECK(place.last_code == 2);
    CHECK(last_message(refused).find("dem.fjell: exists already") != std::string::npos);
    CHECK(refused["scene"] == state["scene"]);
    CHECK(place.files() == std::vector<std::string>{"dem.asc", "dem.fjell", "hills.json"});
}

TEST_CASE(
    "a still view is drawn once, a moving one at half resolution if asked, and what stands still again is whole") {
    EditorFiles place;
    place.fills_pixels = true;
    place.bake();
    const auto draws = [](const json& s) { return s["terrain_draws"].get<std::uint64_t>(); };
    const json stopped =
        place.after({"wait", "frames 4", "dump before.json", "frames 30", "dump still.json",
                     "interface half-resolution on", "navigate orbit", "add-point", "jump 9000 9000", "add-point",
                     "play-path on", "frames 20", "frame-report 5", "dump flown.json", "play-path off", "wait"},
                    "hills.fjell");
    const json before = place.dumped("before.json"), still = place.dumped("still.json"),
               flown = place.dumped("flown.json");
    CHECK(still["frame"] >= before["frame"].get<std::uint64_t>() + 30);
    CHECK(draws(still) == draws(before));
    // A report is of one frame, whose parts make the whole.
    CHECK(draws(flown) > draws(still) + 15);
    const json& view = flown["interface"]["view_px"];
    const bool software = flown["graphics"].get<std::string>().find("llvmpipe") != std::string::npos;
    CHECK((flown["half_draws"] > 10) == software); // where a GPU draws, a picture costs too little for that
    CHECK(still["half_draws"] == 0);
    const json& f = flown["measures"]["chosen"];
    REQUIRE(f.is_object());
    double parts_us = 0;
    for (const char* part : {"update_us", "stream_us", "upload_us", "draw_us", "present_us", "editor_us"})
        parts_us += f[part].get<double>();
    CHECK(parts_us <= f["frame_us"].get<double>());
    CHECK(parts_us > 0.5 * f["frame_us"].get<double>());
    CHECK(stopped["drawn_px"] == json({view[2], view[3]}));
}

TEST_CASE("a profile that is tuned in the editor gives a host the mesh that fjell-fly has with it") {
    const EditorFiles place;
    place.bake();
    (void)place.after({"open hills.fjell", "set refine.max_error_px 3", "set refine.morph none",
                       "set budget.vertices 90000", "set budget.triangles 180000", "save-profile mine.toml"});
    const std::string file = (place.folder / "mine.toml").string();
    const Run fly = test::run_in(place.folder, FJELL_BIN_DIR
                                 "/fjell-fly hills.fjell --headless --frames 5 --seed 6 --stream on --wait "
                                 "--profile mine.toml --csv f.csv --record f.rec");
    INFO(fly.err);
    REQUIRE(fly.code == 0);
    const session::Recording flown = session::parse_recording(slurp(place.folder / "f.rec"), "f.rec");
    std::istringstream lines(slurp(place.folder / "f.csv"));
    std::string line;
    std::getline(lines, line);
    const auto cells = [](const std::string& row) {
        std::vector<std::string> found;
        std::istringstream text(row);
        for (std::string cell; std::getline(text, cell, ',');) found.push_back(cell);
        return found;
    };
    const std::vector<std::string> names = cells(line);
    const auto column = [&](const char* name) {
        const auto at = std::ranges::find(names, name);
        REQUIRE(at != names.end());
        return static_cast<std::size_t>(at - names.begin());
    };
    const std::size_t vertices = column("vertices"), triangles = column("triangles");
    io::LiveTerrain terrain((place.folder / "hills.fjell").string(), live_options(read_profile(file)));
    CHECK(terrain.options().cut.vertices == 90'000);
    double now_s = 0;
    int frames = 0;
    for (std::size_t i = 0; i < flown.frames.size(); ++i) {
        const session::RecordedFrame& frame = flown.frames[i]; // the last update of those that the picture waited for
        if (i + 1 < flown.frames.size() && length(flown.frames[i + 1].views[0].eye_m - frame.views[0].eye_m) == 0)
            continue;
        REQUIRE(std::getline(lines, line));
        do {
            (void)terrain.update(frame.views, now_s += 1.0 / 60);
            (void)terrain.take_map_commands();
            std::this_thread::yield();
        } while (!terrain.frame().settled);
        CHECK(terrain.frame().converged);
        CHECK(terrain.frame().cut.vertices == std::stoul(cells(line)[vertices]));
        CHECK(terrain.frame().cut.triangles == std::stoul(cells(line)[triangles]));
        ++frames;
    }
    CHECK(frames == 5);
}
