// fjell-fly over packs that it streams: what scripts read of it, and what becomes of it when the disk or the pack
// fails.
#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <sstream>
#include <string>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "fjell/gl/image.h"
#include "support/program.h"
#include "support/rounds.h"
#include "support/temporary_folder.h"

using namespace fjell;
using namespace fjell::test;

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// A terrain of 4 x 4 tiles of 128 cells, 96 pages, with maps; and profiles with too few and too many slots.
class StreamedPlace {
public:
    StreamedPlace() {
        spit(folder.path / "recipe.json",
             R"({"columns": 513, "rows": 513, "spacing_m": 60, "seed": 7, "relief_m": 2500, "feature_m": 6000})");
        REQUIRE(run(FJELL_BIN_DIR "/fjell-bake synth recipe.json -o dem.tif").code == 0);
        REQUIRE(run(FJELL_BIN_DIR "/fjell-bake dem.tif -o t.fjell --tile 128 --quiet").code == 0);
        spit(folder.path / "few.toml", "[stream]\npage_slots = 30\n[budget]\nmax_work = 400\n");
        spit(folder.path / "all.toml", "[stream]\npage_slots = 96\n");
    }
    [[nodiscard]] Run run(const std::string& command) const { return run_in(folder.path, command); }
    [[nodiscard]] Run fly(const std::string& arguments, const std::string& before = "") const {
        return run(before + FJELL_BIN_DIR "/fjell-fly " + arguments);
    }
    // Flies headless and answers with its JSON.
    [[nodiscard]] json flight(const std::string& arguments, const std::string& before = "") const {
        const Run r = fly(arguments + " --headless --error-px 2 --json -", before);
        INFO(arguments << "\n" << r.err);
        REQUIRE(r.code == 0);
        return json::parse(r.out);
    }
    TemporaryFolder folder;
};

const StreamedPlace& streamed_place() {
    static const StreamedPlace one;
    return one;
}

void refuses_streamed(const std::string& arguments, int code, const std::string& part) {
    const auto before = streamed_place().folder.names();
    const Run r = streamed_place().fly(arguments);
    INFO(arguments << "\n" << r.err);
    CHECK(r.code == code);
    CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
    CHECK(r.err.starts_with("fjell-fly: "));
    CHECK(r.err.find(part) != std::string::npos);
    CHECK(streamed_place().folder.names() == before);
}

// Rows of a CSV, of these columns.
std::vector<std::string> columns(const std::string& csv, std::size_t first, std::size_t last) {
    std::vector<std::string> rows;
    std::istringstream text(csv);
    for (std::string line; std::getline(text, line);) {
        std::istringstream cells(line);
        std::string row;
        std::size_t n = 0;
        for (std::string cell; std::getline(cells, cell, ','); ++n)
            if (n >= first && n <= last) row += cell + ",";
        rows.push_back(row);
    }
    return rows;
}

// Of a binary glTF: its JSON, and the smallest upward component of all normals.
json json_of(const std::string& glb) {
    std::uint32_t length = 0;
    REQUIRE(glb.size() > 20);
    std::memcpy(&length, glb.data() + 12, sizeof length);
    return json::parse(glb.substr(20, length));
}
float least_up(const std::string& glb) {
    const json scene = json_of(glb);
    std::uint32_t length = 0;
    std::memcpy(&length, glb.data() + 12, sizeof length);
    float least = 1;
    for (const json& mesh : scene["meshes"]) {
        const json& accessor = scene["accessors"][mesh["primitives"][0]["attributes"]["NORMAL"].get<std::size_t>()];
        REQUIRE(accessor["componentType"] == 5126); // float
        const json& view = scene["bufferViews"][accessor["bufferView"].get<std::size_t>()];
        const std::size_t first = 28 + length + view.value("byteOffset", 0u) + accessor.value("byteOffset", 0u),
                          stride = view.value("byteStride", 12u);
        for (std::size_t i = 0; i < accessor["count"].get<std::size_t>(); ++i) {
            float up = 0;
            REQUIRE(first + i * stride + 12 <= glb.size());
            std::memcpy(&up, glb.data() + first + i * stride + 4, sizeof up);
            least = std::min(least, up);
        }
    }
    return least;
}

gl::Image picture(const char* folder, const char* name) {
    return gl::read_png((streamed_place().folder.path / folder / name).string());
}

// A byte in the middle of a stored page or map changed.
void damage(const std::string& from, const std::string& to, std::size_t at) {
    std::string bytes = slurp(streamed_place().folder.path / from);
    bytes[at] = static_cast<char>(bytes[at] ^ 8);
    spit(streamed_place().folder.path / to, bytes);
}

} // namespace

TEST_CASE("a streamed flight that waits draws what a flight over the whole pack draws, frame by frame") {
    for (const char* flags : {"", "--corner-safe --seed 3", "--method recursive"}) {
        const std::string flight = std::string("t.fjell --headless --frames 20 --error-px 2 --csv - ") + flags;
        const Run whole = streamed_place().fly(flight + " --stream off"),
                  streamed = streamed_place().fly(flight + " --stream on --wait");
        INFO(flags << "\n" << streamed.err);
        REQUIRE(whole.code == 0);
        REQUIRE(streamed.code == 0);
        // Vertices, triangles, and that the threshold is the one asked for.
        CHECK(columns(whole.out, 2, 4) == columns(streamed.out, 2, 4));
        CHECK(columns(whole.out, 6, 7) == columns(streamed.out, 6, 7));
        CHECK(columns(whole.out, 9, 9) == columns(streamed.out, 9, 9));
    }
}

TEST_CASE("the JSON of a streamed flight says what came, how long it took and where memory went") {
    const json j = streamed_place().flight("t.fjell --frames 30 --stream on --wait --verify 10");
    CHECK(j["streamed"] == true);
    CHECK(j["converged_frames"] == 30);
    CHECK(j["verified_ok"] == true);
    CHECK(j["verified_frames"] == 3);
    CHECK(j["pages_loaded"] > 16); // one a tile and more
    CHECK(j["pages_loaded"] <= 96);
    CHECK(j["textures_loaded"] > 0);
    const json& s = j["stream"];
    CHECK(s["converged_frames"] == 30);
    CHECK(s["maps_converged_frames"] == 30);
    CHECK(s["first_picture_frame"] == 0);
    CHECK(s["first_picture_s"] > 0);
    CHECK(s["coarse_s"] <= s["first_picture_s"]);
    CHECK(s["missing_px_max"] <= 2);
    CHECK(s["failed"] == 0);
    CHECK(s["pages_taken"] == j["pages_loaded"]);
    CHECK(s["reader"]["errors"] == 0);
    CHECK(s["reader"]["bytes"] >= s["bytes_read"]);
    CHECK(s["page_slots"]["capacity"] == 96);
    CHECK(s["page_slots"]["peak"] >= s["page_slots"]["used"]);
    CHECK(s["map_bytes"]["used"] <= s["map_bytes"]["capacity"]);
    CHECK(s["map_upload_bytes"] > 0);
    for (const char* pool : {"terrain", "method", "stream", "maps_on_gpu"}) CHECK(s["memory_bytes"][pool] > 0);
    CHECK(s["memory_bytes"]["terrain"] == j["pack"]["terrain_bytes"]);
    for (const char* time : {"p50", "p99", "p9999", "max", "mean"}) CHECK(s["update_us"][time] > 0);
    const json whole = streamed_place().flight("t.fjell --frames 3 --stream off");
    CHECK(whole["streamed"] == false);
    CHECK(whole["stream"].is_null());
    CHECK(whole["pages_requested"] == 0);
}

TEST_CASE("auto streams exactly when the pack has more pages than there are slots") {
    CHECK(streamed_place().flight("t.fjell --frames 2 --profile few.toml")["streamed"] == true);
    CHECK(streamed_place().flight("t.fjell --frames 2 --profile all.toml")["streamed"] == false);
    CHECK(streamed_place().flight("t.fjell --frames 2 --profile all.toml --stream on")["streamed"] == true);
    CHECK(streamed_place().flight("t.fjell --frames 2 --profile few.toml --stream off")["streamed"] == false);
}

TEST_CASE("with too few slots a streamed flight names them, goes on, and keeps what it promises") {
    const json j = streamed_place().flight("t.fjell --frames 30 --profile few.toml --wait --verify 10");
    const auto names = j["exhausted"].get<std::vector<std::string>>();
    CHECK(std::find(names.begin(), names.end(), "page_slots") != names.end());
    CHECK(j["stream"]["page_slots"]["peak"] == 30);
    CHECK(j["verified_ok"] != false); // null: no frame was settled
    CHECK(j["stream"]["pages_taken"] > 30);
}

TEST_CASE("a streamed flight is recorded with its pages and repeated bit for bit from the whole pack") {
    // With few slots pages go in the order in which the cut was asked for them; seeds for which another one shows.
    for (const char* flags :
         first_of(3, {"--profile few.toml --seed 5",
                      "--stream on --read-mb-s 3 --read-latency-ms 1 --budget-us 60 --morph time",
                      "--profile few.toml --realtime --hz 400 --morph error --hysteresis 0.2", "--stream on",
                      "--profile few.toml --seed 6", "--profile few.toml --wait --seed 5"})) {
        const Run flown =
            streamed_place().fly(std::string("t.fjell --headless --frames 60 --error-px 1 --record r.json ") + flags);
        INFO(flags << "\n" << flown.err);
        REQUIRE(flown.code == 0);
        const Run again = streamed_place().fly("t.fjell --headless --replay r.json --verify 20");
        INFO(again.err);
        CHECK(again.code == 0);
    }
    // What a replay tells is true of the flight, not of the defaults that it was replayed with.
    const std::string verify = " --headless --verify 6 --json -";
    const Run flown = streamed_place().fly("t.fjell --frames 10 --record r.json --profile few.toml --morph error "
                                           "--hysteresis 0.2 --corner-safe --size 640x480 --fov 70" +
                                           verify);
    const Run again = streamed_place().fly("t.fjell --replay r.json" + verify);
    CAPTURE(flown.err, again.err);
    REQUIRE((flown.code == 0 && again.code == 0));
    const json told = json::parse(flown.out), repeated = json::parse(again.out);
    for (const char* key : {"morph", "hysteresis", "corner_safe", "error_px", "viewport", "metric", "triangles_mean",
                            "error_px_effective_max", "verified_error_px_max", "converged_frames"}) {
        CAPTURE(key, told[key], repeated[key]);
        REQUIRE(told.contains(key));
        CHECK(told[key] == repeated[key]);
    }
    CHECK(told["fov_y_deg"].get<double>() == Approx(repeated["fov_y_deg"].get<double>()));
    for (const char* flag : {"--error-px 2", "--corner-safe", "--fov 50", "--size 64x64", "--items 5", "--budget-us 9",
                             "--hysteresis 0.1", "--morph none"})
        refuses_streamed(std::string("t.fjell --headless --replay r.json ") + flag, 2, "leave out --error-px");
    // Without one of its pages it is not the same flight.
    std::string text = slurp(streamed_place().folder.path / "r.json");
    const std::size_t at = text.find("\"pages\":[[") + 9;
    text.erase(at, text.find(']', at) + 2 - at);
    spit(streamed_place().folder.path / "r.json", text);
    refuses_streamed("t.fjell --headless --replay r.json", 1, "frame ");
    refuses_streamed("t.fjell --headless --replay r.json --stream on", 2, "leave out --stream");
    fs::remove(streamed_place().folder.path / "r.json");
}

TEST_CASE("a damaged page is one line on stderr, coarser ground, and exit code 1 when the flight is over") {
    // The finest pages lie last of the pages; the last colour or normal chunk lies before the directory.

    const std::size_t bytes = fs::file_size(streamed_place().folder.path / "t.fjell");
    std::size_t reported = 0;
    for (const std::size_t at : {bytes / 8, bytes / 4, bytes / 3, bytes / 2}) {
        damage("t.fjell", "bad.fjell", at);
        const Run r =
            streamed_place().fly("bad.fjell --headless --frames 20 --error-px 0.5 --stream on --wait --json -");
        INFO(at << "\n" << r.err);
        REQUIRE((r.code == 0 || r.code == 1)); // 0: it was never wanted
        const json j = json::parse(r.out);
        const auto lines = std::count(r.err.begin(), r.err.end(), '\n');
        CHECK(j["stream"]["failed"] == (lines > 0 ? 1 : 0));
        CHECK(lines == (r.code == 0 ? 0 : 1));
        CHECK(j["stream"]["reader"]["damaged"] == j["stream"]["failed"]);
        if (r.code == 0) continue;
        ++reported;
        CHECK(r.err.find("fjell-fly: bad.fjell: ") == 0);
        CHECK(r.err.find(" of tile ") != std::string::npos);
        CHECK(r.err.find("1 damaged and 0 unreadable chunks") != std::string::npos);
    }
    CHECK(reported >= 2);
    fs::remove(streamed_place().folder.path / "bad.fjell");
}

TEST_CASE("a disk that fails costs what it did not give, and exit code 3, and signals and short reads cost nothing") {
    const std::string preload = "LD_PRELOAD=" FJELL_FAULTS " FJELL_FAULT=";
    const std::string flight = "t.fjell --frames 20 --stream on --wait";
    const json healthy = streamed_place().flight(flight);
    for (const char* fault : {"'pread t.fjell EINTR %2' ", "'pread t.fjell short %2' "}) {
        const json j = streamed_place().flight(flight, preload + fault);
        CHECK(j["pages_loaded"] == healthy["pages_loaded"]);
        CHECK(j["converged_frames"] == 20);
    }
    const Run r =
        streamed_place().fly(flight + " --headless --error-px 2 --json -", preload + "'pread t.fjell EIO %40' ");
    INFO(r.err);
    CHECK(r.code == 3);
    CHECK(r.err.find(": Input/output error (") != std::string::npos);
    CHECK(r.err.find("unreadable chunks") != std::string::npos);
    const json j = json::parse(r.out);
    CHECK(j["stream"]["failed"] > 1);
    CHECK(j["stream"]["reader"]["errors"] == j["stream"]["failed"]);
    CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1); // the first, and how many
    CHECK(r.err.find(" and " + std::to_string(j["stream"]["failed"].get<int>()) + " unreadable") != std::string::npos);
    // Not even the header: nothing to fly over.
    const Run none = streamed_place().fly(flight + " --headless", preload + "'pread t.fjell EIO 1' ");
    INFO(none.err);
    CHECK(none.code == 3);
    CHECK(std::count(none.err.begin(), none.err.end(), '\n') == 1);
}

TEST_CASE("a streamed flight exports what is there") {
    const Run r =
        streamed_place().fly("t.fjell --headless --frames 2 --error-px 4 --stream on --wait --export 1:s.glb");
    INFO(r.err);
    REQUIRE(r.code == 0);
    REQUIRE(streamed_place().fly("t.fjell --headless --frames 2 --error-px 4 --stream off --export 1:w.glb").code == 0);
    const auto scene = [&](const char* name) {
        return json_of(slurp(streamed_place().folder.path / name))["scenes"][0]["extras"]["fjell"];
    };
    CHECK(scene("s.glb")["converged"] == true);
    CHECK(scene("s.glb")["triangles"] == scene("w.glb")["triangles"]);
    CHECK(scene("s.glb") == scene("w.glb"));
    for (const char* name : {"s.glb", "w.glb"}) fs::remove(streamed_place().folder.path / name);
    // Nothing has come after one frame from a slow disk that is not waited for, and the export says so.
    const Run early = streamed_place().fly(
        "t.fjell --headless --frames 1 --stream on --realtime --read-latency-ms 10000 --export 0:e.glb");
    INFO(early.err);
    REQUIRE(early.code == 0);
    CHECK(scene("e.glb")["converged"] == false);
    CHECK(scene("e.glb")["triangles"] >= 32); // two a tile
    // Normals are those of the ground that is there: its relief is a third of a tile's width, so none lies flat.
    CHECK(least_up(slurp(streamed_place().folder.path / "e.glb")) > 0.5f);
    fs::remove(streamed_place().folder.path / "e.glb");
}

TEST_CASE("pictures of a streamed flight that waits are those of the whole pack") {
    // Finer texels than any pixel asks for, so that no mip is left out that the sampler would take. Light in
    // proportion, because a film's curve and noise on the ground make more of a code than one.
    const std::string light = " --light air=simple,tone_curve=none,dither=false,detail=false ";
    spit(streamed_place().folder.path / "fine.toml", "[stream]\ntexel_px = 0.1\n");
    for (const char* flags : {"", "--method recursive"}) {
        const auto pictures = [&](const char* folder, const char* how) {
            fs::create_directory(streamed_place().folder.path / folder);
            const Run r =
                streamed_place().fly(std::string("t.fjell --headless --frames 4 --size 320x240 --render-every 3 ") +
                                         flags + light + " --render " + folder + " " + how,
                                     "ASAN_OPTIONS=detect_leaks=0 ");
            INFO(r.err);
            REQUIRE(r.code == 0);
        };
        pictures("whole", "--stream off");
        pictures("streamed", "--stream on --wait --profile fine.toml");
        for (const char* name : {"frame_00000.png", "frame_00003.png"}) {
            const gl::Image whole = picture("whole", name), streamed = picture("streamed", name);
            REQUIRE(streamed.rgb.size() == whole.rgb.size());
            int largest = 0;
            for (std::size_t i = 0; i < whole.rgb.size(); ++i)
                largest = std::max(largest, std::abs(whole.rgb[i] - streamed.rgb[i]));
            CAPTURE(flags, name);
            // A tile in an array of another size counts mips from elsewhere: a step of the weight between two, 1/256 of
            // their contrast, and one for rounding the result (maps_render_test.cpp).
            CHECK(largest <= 2);
            const auto [darkest, brightest] = std::minmax_element(whole.rgb.begin(), whole.rgb.end());
            CHECK(*brightest - *darkest > 100); // there is something to see
        }
        for (const char* folder : {"whole", "streamed"}) fs::remove_all(streamed_place().folder.path / folder);
    }
    fs::remove(streamed_place().folder.path / "fine.toml");
}

TEST_CASE("what does not go with streaming is refused in one line") {
    refuses_streamed("t.fjell --stream maybe --headless", 2, "--stream");
    refuses_streamed("t.fjell --wait", 2, "--wait needs --headless");
    refuses_streamed("t.fjell --realtime", 2, "--realtime needs --headless");
    refuses_streamed("t.fjell --headless --wait --realtime", 2, "exclude each other");
    refuses_streamed("t.fjell --headless --stream on --read-mb-s -1", 2, "--read-mb-s");
    refuses_streamed("t.fjell --headless --frames 1 --stream off --cold", 2, "leave them out");
    refuses_streamed("t.fjell --headless --frames 1 --stream off --read-mb-s 1", 2, "leave them out");
    refuses_streamed("gone.fjell --headless --stream on", 1, "gone.fjell");
    spit(streamed_place().folder.path / "least.toml", "[stream]\npage_slots = 15\n");
    refuses_streamed("t.fjell --headless --frames 1 --profile least.toml", 1, "page_slots (one a tile)");
    fs::remove(streamed_place().folder.path / "least.toml");
    REQUIRE(streamed_place()
                .run(FJELL_BIN_DIR "/fjell-bake dem.tif -o linear.fjell --tile 128 --order linear --quiet")
                .code == 0);
    refuses_streamed("linear.fjell --headless --method recursive --frames 1 --stream on", 1, "linear order");
    CHECK(streamed_place().flight("linear.fjell --method recursive --frames 1 --profile few.toml")["streamed"] ==
          false);
    fs::remove(streamed_place().folder.path / "linear.fjell");
}
