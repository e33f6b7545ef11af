// The built programs, as a user or a script runs them: bake a small terrain, fly it, read what they write, and give
// them every wrong thing.
#include <algorithm>
#include <filesystem>
#include <string>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "support/program.h"
#include "support/rounds.h"
#include "support/temporary_folder.h"

using namespace fjell;

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

using test::Run;
using test::slurp;
using test::spit;
using test::TemporaryFolder;

// One folder for the whole program, with a terrain of 4 x 4 tiles of 64 cells in it.
class Place {
public:
    Place() {
        spit(folder / "recipe.json",
             R"({"columns": 257, "rows": 257, "spacing_m": 60, "seed": 7, "relief_m": 2500, "feature_m": 6000})");
        const std::string bake = FJELL_BIN_DIR "/fjell-bake";
        REQUIRE(run(bake + " synth recipe.json -o dem.tif").code == 0);
        REQUIRE(run(bake + " dem.tif -o small.fjell --tile 64 --quiet").code == 0);
    }
    Run run(const std::string& command) const { return test::run_in(folder, command); }
    Run fly(const std::string& arguments) const { return run(FJELL_BIN_DIR "/fjell-fly " + arguments); }
    // In a sanitized build Mesa's own 128 bytes would count as a leak of ours.
    Run fly_with_gl(const std::string& arguments) const {
        return run("ASAN_OPTIONS=detect_leaks=0 " FJELL_BIN_DIR "/fjell-fly " + arguments);
    }
    [[nodiscard]] std::vector<std::string> files() const {
        std::vector<std::string> names;
        for (const auto& entry : fs::recursive_directory_iterator(folder)) names.push_back(entry.path().filename());
        std::sort(names.begin(), names.end());
        return names;
    }

    const TemporaryFolder home;
    const fs::path folder = home.path;
};

const Place& place() {
    static const Place one;
    return one;
}

// Fails with this code and one line that holds this text; leaves nothing behind.
void refuses(const std::string& arguments, int code, const std::string& part) {
    const auto before = place().files();
    const Run r = place().fly(arguments);
    INFO(arguments << "\n" << r.err);
    CHECK(r.code == code);
    CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
    CHECK(r.err.starts_with("fjell-fly: "));
    CHECK(r.err.find(part) != std::string::npos);
    CHECK(r.out.empty());
    CHECK(place().files() == before);
}

// Of a CSV row, counted from 0.
std::string column(const std::string& row, std::size_t n) {
    std::size_t at = 0;
    for (; n > 0; --n) at = row.find(',', at) + 1;
    return row.substr(at, row.find(',', at) - at);
}

std::vector<std::string> lines(const std::string& text) {
    std::istringstream stream(text);
    std::vector<std::string> result;
    for (std::string line; std::getline(stream, line);) result.push_back(line);
    return result;
}

} // namespace

TEST_CASE("a headless flight measures its own error and finds it within the threshold") {
    for (const char* flags : first_of(
             6, {"", "--hysteresis 0.5", "--corner-safe --fov 90", "--method recursive --topology strip",
                 "--method recursive --cull off", "--method recursive --metric depth", "--seed 3", "--method recursive",
                 "--method recursive --corner-safe --fov 90", "--method recursive --seed 3"})) {
        const Run r =
            place().fly(std::string("small.fjell --headless --frames 40 --error-px 2 --verify 10 --json - ") + flags);
        INFO(flags << "\n" << r.err);
        REQUIRE(r.code == 0);
        const json j = json::parse(r.out);
        CHECK(j["frames"] == 40);
        CHECK(j["converged_frames"] == 40);
        CHECK(j["verified_frames"] == 4);
        CHECK(j["verified_ok"] == true);
        CHECK(j["verified_error_px_max"].get<double>() > 0.2); // the corner-safe one at 90 degrees refines to 2 / 5.2
        CHECK(j["verified_error_px_max"].get<double>() < 2.1);
        CHECK(j["vertices_mean"].get<double>() > 100);
        CHECK(j["method"] == (std::string(flags).starts_with("--method recursive") ? "recursive" : "incremental"));
    }
}

TEST_CASE("both methods select the same triangles in every frame when neither culls") {
    const auto selected = [](const std::string& method) { // vertices, or triangles, of every frame
        const Run r =
            place().fly("small.fjell --headless --frames 30 --error-px 2 --cull off --csv - --method " + method);
        INFO(r.err);
        REQUIRE(r.code == 0);
        std::vector<std::string> triangles;
        for (const std::string& row : lines(r.out)) triangles.push_back(column(row, 3));
        return triangles;
    };
    const auto incremental = selected("incremental");
    REQUIRE(incremental.size() == 31);
    CHECK(incremental == selected("recursive"));
}

TEST_CASE("a frame never does more work than --items, and the flight says that it lagged") {
    for (const char* flags : {"--items 1", "--items 200", "--items 200 --profile limited.toml"}) {
        spit(place().folder / "limited.toml", "[budget]\nmax_work = 100000\n");
        const Run r =
            place().fly(std::string("small.fjell --headless --frames 30 --error-px 1 --verify 10 --json j.json "
                                    "--csv - ") +
                        flags);
        INFO(flags << "\n" << r.err);
        REQUIRE(r.code == 0); // a frame that lags promises nothing
        const std::uint32_t limit = std::string(flags).starts_with("--items 1") ? 1 : 200;
        const auto rows = lines(r.out);
        REQUIRE(rows.size() == 31);
        for (std::size_t i = 1; i < rows.size(); ++i) {
            CHECK(std::stoul(column(rows[i], 11)) <= limit);
            CHECK(column(rows[i], 8) == "items");
        }
        const json j = json::parse(slurp(place().folder / "j.json"));
        CHECK(j["items_max"] == limit);
        CHECK(j["overruns"] == 0);
        CHECK(j["exhausted"] == json::array({"items"}));
        CHECK(j["converged_frames"] == 0);
        CHECK(j["rebuilt_frames"] == 0);
        CHECK(j["waiting_max"] > 0);
        CHECK(j["verified_frames"] == 0);
        CHECK(j["verified_error_px_max"].is_null());
        CHECK(j["verified_lagging_error_px_max"] > 1);
        fs::remove(place().folder / "limited.toml");
        fs::remove(place().folder / "j.json");
    }
}

TEST_CASE("a profile's items bound every frame but the first, which is built from nothing") {
    spit(place().folder / "limited.toml", "[budget]\nmax_work = 100000\n");
    const Run r = place().fly("small.fjell --headless --frames 30 --profile limited.toml --json -");
    INFO(r.err);
    REQUIRE(r.code == 0);
    const json j = json::parse(r.out);
    CHECK(j["rebuilt_frames"] == 1);
    CHECK(j["rebuild_us"] > 0);
    CHECK(j["converged_frames"] == 30);
    CHECK(j["overruns"] == 0);
    CHECK(j["items_max"] <= 100000);
    CHECK(j["changes_mean"] > 0);
    // 28 bytes a vertex slot, 12 a triangle slot, and not a byte more.
    CHECK(j["bytes_uploaded_mean"].get<double>() ==
          Approx(28 * j["vertices_written_mean"].get<double>() + 12 * j["triangles_written_mean"].get<double>()));
    fs::remove(place().folder / "limited.toml");
}

TEST_CASE("an update that --budget-us cuts short names the time") {
    const Run r = place().fly("small.fjell --headless --frames 10 --error-px 0.5 --budget-us 20 --json -");
    INFO(r.err);
    REQUIRE(r.code == 0);
    const json j = json::parse(r.out);
    CHECK(j["exhausted"] == json::array({"time"}));
    CHECK(j["converged_frames"] == 0);
}

TEST_CASE("a morphing flight keeps its promises") {
    for (const char* morph : {"none", "error", "time"}) {
        const Run r = place().fly(
            std::string("small.fjell --headless --frames 20 --error-px 2 --verify 10 --json - --morph ") + morph);
        INFO(morph << "\n" << r.err);
        REQUIRE(r.code == 0);
        CHECK(json::parse(r.out)["morph"] == morph);
    }
}

TEST_CASE("a recorded flight is repeated bit for bit, and one that was changed, or of another pack, is refused") {
    for (const char* limits : {"", "--items 40", "--budget-us 20 --morph time --hysteresis 0.2"}) {
        REQUIRE(place().fly("small.fjell --headless --frames 90 --record r.json " + std::string(limits)).code == 0);
        CHECK(place().fly("small.fjell --headless --replay r.json --csv -").code == 0);
    }
    std::string text = slurp(place().folder / "r.json");
    const std::size_t at = text.find("\"mesh\":\"", text.size() / 2) + 8;
    text[at] = text[at] == '0' ? '1' : '0';
    spit(place().folder / "changed.json", text);
    refuses("small.fjell --headless --replay changed.json", 1, "is not the recorded one");
    text.replace(text.find("\"pack\":\"") + 8, 4, "beef");
    spit(place().folder / "other.json", text);
    refuses("small.fjell --headless --replay other.json", 1, "another pack");
    refuses("small.fjell --headless --replay r.json --frames 3", 2, "leave out");
    refuses("small.fjell --replay r.json", 2, "--headless");
    refuses("small.fjell --headless --method recursive --record x.json", 2, "incremental");
    for (const char* name : {"r.json", "changed.json", "other.json"}) fs::remove(place().folder / name);
}

TEST_CASE("a pack in linear order is flown by the recursive method, and the incremental one says so") {
    REQUIRE(place().run(FJELL_BIN_DIR "/fjell-bake dem.tif -o linear.fjell --tile 64 --order linear --quiet").code ==
            0);
    refuses("linear.fjell --headless", 1, "bake it with --order planar, or fly it with --method recursive");
    CHECK(place().fly("linear.fjell --headless --frames 3 --method recursive").code == 0);
    fs::remove(place().folder / "linear.fjell");
}

TEST_CASE("a flight that exceeds its threshold says so and fails, with its outputs written") {
    // The mid-point estimate promises nothing about samples off the middle, so measuring finds it out.
    REQUIRE(place().run(FJELL_BIN_DIR "/fjell-bake dem.tif -o mid.fjell --tile 64 --estimate midpoint --quiet").code ==
            0);
    const Run r = place().fly("mid.fjell --headless --frames 20 --error-px 2 --verify 1 --json -");
    INFO(r.err);
    CHECK(r.code == 1);
    CHECK(r.err.find("px measured where") != std::string::npos);
    CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
    const json j = json::parse(r.out);
    CHECK(j["verified_ok"] == false);
    CHECK(j["verified_error_px_max"].get<double>() > 2);
    fs::remove(place().folder / "mid.fjell");
}

TEST_CASE("the JSON of a flight has every key that scripts rely on") {
    REQUIRE(place()
                .fly("small.fjell --headless --frames 10 --json flight.json --csv flight.csv --size 640x480 --fov 60")
                .code == 0);
    const json j = json::parse(slurp(place().folder / "flight.json"));
    for (const char* key : {"frames",
                            "vertices_mean",
                            "triangles_mean",
                            "triangles_drawn_mean",
                            "changes_mean",
                            "update_us",
                            "overruns",
                            "allocations",
                            "converged_frames",
                            "verified_error_px_max",
                            "bytes_uploaded_mean",
                            "pages_loaded",
                            "pages_requested",
                            "stream",
                            "textures_loaded",
                            "pack",
                            "error_px",
                            "error_px_effective_max",
                            "edits",
                            "exhausted",
                            "selected_ns_per_vertex",
                            "items_max",
                            "evaluations_mean",
                            "activations_mean",
                            "deactivations_mean",
                            "waiting_max",
                            "vertices_peak",
                            "triangles_peak",
                            "viewport",
                            "fov_y_deg"})
        CHECK(j.contains(key));
    CHECK(j["changes_mean"].is_number());
    CHECK(json::parse(place().fly("small.fjell --headless --frames 3 --json - --method recursive").out)["changes_mean"]
              .is_null());
    for (const char* key : {"p50", "p99", "p9999", "max"}) CHECK(j["update_us"][key].get<double>() > 0);
    CHECK(j["allocations"].is_null());
    CHECK(j["verified_error_px_max"].is_null());
    CHECK(j["viewport"] == json::array({640, 480}));
    CHECK(j["pack"]["columns"] == 257);
    CHECK(j["pack"]["tiles"] == json::array({4, 4}));

    const auto rows = lines(slurp(place().folder / "flight.csv"));
    REQUIRE(rows.size() == 11);
    CHECK(rows[0] == "frame,update_us,vertices,triangles,tiles,written,error_px_asked,error_px_effective,exhausted,"
                     "converged,verified_px,items,evaluations,activations,deactivations,waiting,blocked,rising,"
                     "triangles_drawn,rebuilt,bytes_uploaded,prepare_us,refine_us,output_us,stream_us,pages_taken,"
                     "pages_left,pages_wanted,pages_draining,pages_failed,page_slots,mips_taken,mips_left,requested,"
                     "bytes_read,map_upload_bytes,missing_px,missing_mips,stream_converged,polls,at_s");
    CHECK(rows[10].starts_with("9,"));
    for (const std::string& row : rows) CHECK(std::count(row.begin(), row.end(), ',') == 40);
    fs::remove(place().folder / "flight.json");
    fs::remove(place().folder / "flight.csv");
}

TEST_CASE("two flights of one path select the same vertices in every frame") {
    const auto columns = [](const std::string& csv) { // without the times
        std::string kept;
        for (const std::string& row : lines(csv))
            for (std::size_t n = 2; n < 21; ++n) kept += column(row, n) + (n < 20 ? "," : "\n");
        return kept;
    };
    for (const char* flags : {"", " --items 500", " --method recursive"}) {
        const std::string flight = std::string("small.fjell --headless --frames 30 --seed 11 --csv -") + flags;
        const std::string first = columns(place().fly(flight).out);
        CHECK(std::count(first.begin(), first.end(), '\n') == 31);
        CHECK(first == columns(place().fly(flight).out));
    }
}

TEST_CASE("a small budget is named, raises the threshold and keeps the measured error within it") {
    const auto fly_with = [](const char* budget, const char* method) {
        spit(place().folder / "mean.toml", std::string("[budget]\n") + budget);
        const Run r = place().fly(
            std::string("small.fjell --headless --frames 20 --error-px 0.5 --profile mean.toml --verify 1 --json - ") +
            "--method " + method);
        fs::remove(place().folder / "mean.toml");
        INFO(budget << method << "\n" << r.err);
        REQUIRE(r.code == 0);
        json j = json::parse(r.out);
        CHECK(j["converged_frames"].get<int>() < 20);
        CHECK(j["error_px_effective_max"].get<double>() > 0.5);
        CHECK(j["verified_ok"] != false); // null: no frame was settled
        return j;
    };
    CHECK(fly_with("vertices = 300\nindices = 1500\n", "recursive")["verified_ok"] == true);
    const json vertices = fly_with("vertices = 300\n", "incremental");
    CHECK(vertices["exhausted"] == json::array({"vertices"}));
    CHECK(vertices["vertices_max"] <= 300);
    CHECK(vertices["vertices_peak"] > 200);
    const json triangles = fly_with("triangles = 1000\n", "incremental");
    CHECK(triangles["exhausted"] == json::array({"triangles"}));
    CHECK(triangles["triangles_max"] <= 1000);
}

// What software draws fastest: tests of light draw the others.
const std::string cheap_light = "--light air=simple,tone_curve=none,dither=false,detail=false --samples 1 ";

TEST_CASE("pictures and snapshots of a flight are written where they were asked for") {
    const fs::path pictures = place().folder / "pictures";
    // Each mode is drawn and looked at in system_render.
    for (const char* mode : first_of(
             2, {"shaded", "shaded --method recursive", "wire", "levels", "tiles", "mips", "residency", "distance"})) {
        REQUIRE(!fs::exists(pictures)); // it is made
        const Run r = place().fly_with_gl(
            std::string("small.fjell --headless --frames 9 --render pictures --render-every 4 --size 160x120 " +
                        cheap_light + "--export 3:snap.glb --export 8:last.glb --mode ") +
            mode);
        INFO(r.err);
        REQUIRE(r.code == 0);
        CHECK(slurp(place().folder / "snap.glb").starts_with("glTF"));
        CHECK(slurp(place().folder / "last.glb").starts_with("glTF"));
        int count = 0;
        for (const auto& entry : fs::directory_iterator(pictures)) {
            ++count;
            CHECK(slurp(entry).starts_with("\x89PNG"));
        }
        CHECK(count == 3);
        CHECK(fs::exists(pictures / "frame_00008.png"));
        fs::remove_all(pictures);
        fs::remove(place().folder / "snap.glb");
        fs::remove(place().folder / "last.glb");
    }
}

TEST_CASE("both methods draw the same pictures, to the byte of the file, however many frames lie between") {
    for (const char* mode : first_of(1, {"shaded", "wire", "levels"})) {
        const auto draw = [&](const std::string& method) {
            fs::create_directory(place().folder / method);
            const Run r = place().fly_with_gl("small.fjell --headless --frames 9 --render-every 4 --size 320x240 " +
                                              cheap_light + "--error-px 3 --cull off --mode " + std::string(mode) +
                                              " --method " + method + " --render " + method);
            INFO(r.err);
            REQUIRE(r.code == 0);
        };
        draw("incremental");
        draw("recursive");
        for (const char* frame : {"frame_00000.png", "frame_00004.png", "frame_00008.png"}) {
            INFO(mode << ' ' << frame);
            CHECK((slurp(place().folder / "incremental" / frame) == slurp(place().folder / "recursive" / frame)));
        }
        fs::remove_all(place().folder / "incremental");
        fs::remove_all(place().folder / "recursive");
    }
}

TEST_CASE("a bad pack is refused with what is wrong about it") {
    const fs::path& folder = place().folder;
    const std::string pack = slurp(folder / "small.fjell");
    fs::create_directory(folder / "directory");
    spit(folder / "cut.fjell", pack.substr(0, pack.size() / 2));
    spit(folder / "head.fjell", pack.substr(0, 100));
    spit(folder / "empty.fjell", "");
    spit(folder / "text.fjell", std::string(5000, 'x'));
    std::string other = pack;
    other[8] = 99; // PackHeader::version
    spit(folder / "version.fjell", other);
    std::string flipped = pack;
    flipped[400] = static_cast<char>(flipped[400] ^ 1);
    spit(folder / "flipped.fjell", flipped);

    refuses("nowhere.fjell --headless", 1, "nowhere.fjell: No such file");
    refuses("directory --headless", 1, "directory: is a folder");
    for (const char* name : {"cut", "head", "empty", "text", "version", "flipped"})
        refuses(std::string(name) + ".fjell --headless", 1, std::string(name) + ".fjell: ");
    refuses("version.fjell --headless", 1, "version");
    refuses("cut.fjell --headless --json j.json --csv c.csv", 1, "cut.fjell: ");
}

TEST_CASE("wrong usage is one line and exit code 2") {
    refuses("small.fjell --headless --frames 1 --csv - --json -", 2, "standard output");
    refuses("", 2, "PACK");
    refuses("small.fjell --headless --csv ''", 2, "after --csv");
    refuses("small.fjell --headless --unknown", 2, "--unknown");
    refuses("small.fjell other.fjell --headless", 2, "other.fjell");
    refuses("small.fjell --headless --method stochastic", 2, "--method");
    refuses("small.fjell --headless --metric manhattan", 2, "--metric");
    refuses("small.fjell --headless --method recursive --metric depth --cull off", 2, "--cull on");
    refuses("small.fjell --headless --metric depth", 2, "--metric depth needs --method recursive");
    refuses("small.fjell --headless --topology strip", 2, "--topology strip needs --method recursive");
    refuses("small.fjell --headless --cull on", 2, "--cull on needs --method recursive");
    for (const char* flag : {"--items 9", "--budget-us 9", "--hysteresis 1", "--offscreen-factor 4", "--morph none"})
        refuses(std::string("small.fjell --headless --method recursive ") + flag, 2, "needs --method incremental");
    refuses("small.fjell --headless --items -1", 2, "--items");
    refuses("small.fjell --headless --items 4294967295", 2, "--items");
    refuses("small.fjell --headless --budget-us nan", 2, "--budget-us");
    refuses("small.fjell --headless --hysteresis 11", 2, "--hysteresis");
    refuses("small.fjell --headless --offscreen-factor 0", 2, "--offscreen-factor");
    refuses("small.fjell --headless --morph slowly", 2, "--morph");
    refuses("small.fjell --headless --error-px 0", 2, "--error-px");
    refuses("small.fjell --headless --error-px nan", 2, "--error-px");
    refuses("small.fjell --headless --frames 0", 2, "--frames");
    refuses("small.fjell --headless --frames -3", 2, "--frames");
    refuses("small.fjell --headless --size 640", 2, "--size 640: must be WIDTHxHEIGHT");
    refuses("small.fjell --headless --size 0x10", 2, "--size");
    refuses("small.fjell --headless --samples 0", 2, "--samples");
    refuses("small.fjell --headless --light elevation_deg=91", 2,
            "--light elevation_deg=91: must be a number from -18 to 90");
    refuses("small.fjell --headless --light air=thick", 2, "--light air=thick: must be");
    refuses("small.fjell --headless --light water=true,moon=1", 2,
            "--light moon=1: must be KEY=VALUE, with one of the keys sun, ");
    refuses("small.fjell --headless --fov 180", 2, "--fov");
    refuses("small.fjell --headless --hz nan", 2, "--hz");
    refuses("small.fjell --headless --export out.glb", 2, "FRAME:OUT.glb");
    for (const char* const name : {"x.gltf", "x.obj", "x", "x.glb.zip"})
        refuses(std::string("small.fjell --headless --export 0:") + name, 2, "give it a name that ends in .glb");
    refuses("small.fjell --headless --frames 10 --export 10:out.glb", 2, "frames 0 to 9");
    refuses("small.fjell --headless --csv same --json same", 2, "would overwrite the output same");
    refuses("small.fjell --headless --seed 1 --path p.json", 2, "exclude each other");
    refuses("small.fjell --headless --mode shiny", 2, "--mode");
    refuses("small.fjell --render .", 2, "--headless");
}

TEST_CASE("a bad path or profile is one line and exit code 1") {
    spit(place().folder / "bad.json", "{\"points\": [}");
    spit(place().folder / "bad.toml", "[refine]\nerror = 1\n");
    refuses("small.fjell --headless --path nowhere.json", 1, "nowhere.json: No such file");
    refuses("small.fjell --headless --path bad.json", 1, "bad.json:1: is not JSON");
    refuses("small.fjell --headless --profile bad.toml", 1, "bad.toml:2: refine.error: unknown key");
    spit(place().folder / "less.toml", "[budget]\nvertices = 16\nindices = 16\n");
    refuses("small.fjell --headless --profile less.toml", 1, "CutBudget::vertices (4 a tile): ");
    refuses("small.fjell --headless --profile less.toml --method recursive", 1, "RecursiveBudget");
    spit(place().folder / "less.toml", "[budget]\ntriangles = 64\n");
    refuses("small.fjell --headless --profile less.toml", 1, "CutBudget::triangles");
}

TEST_CASE("an output that cannot be written is found before the flight, and nothing is left behind") {
    // A flight of ten million frames would not end within the test's time.
    const std::string flight = "small.fjell --headless --frames 10000000 ";
    refuses(flight + "--json nowhere/j.json", 1, "the output folder does not exist");
    refuses(flight + "--csv c.csv --json nowhere/j.json", 1, "the output folder does not exist");
    refuses(flight + "--export 0:nowhere/o.glb", 1, "the output folder does not exist");
    refuses(flight + "--json j.json --render nowhere/pictures", 1, "the output folder does not exist");
    refuses(flight + "--render small.fjell", 1, "the output folder does not exist");
    refuses("small.fjell --headless --render made --path nowhere.json", 1, "nowhere.json");
    refuses(flight + "--json .", 1, "is a folder");
    refuses(flight + "--export 0:.", 1, "is a folder");
}

TEST_CASE("a full disk is told from the input's faults") {
    refuses("small.fjell --headless --frames 3 --csv /dev/full", 3, "No space left");
    refuses("small.fjell --headless --frames 3 --json /dev/full", 3, "No space left");
    refuses("small.fjell --headless --frames 3 --export 1:/dev/full", 3, "No space left");
    const Run r = place().run("(" FJELL_BIN_DIR "/fjell-fly small.fjell --headless --frames 3 > /dev/full)");
    CHECK(r.code == 3);
    CHECK(r.err.find("cannot write to the standard output") != std::string::npos);
}

TEST_CASE("an interrupted flight leaves nothing behind") {
    const auto before = place().files();
    const Run r =
        place().run("env --default-signal=INT " FJELL_BIN_DIR
                    "/fjell-fly small.fjell --headless --frames 10000000 --json j.json --record r.record & p=$!; " +
                    test::until_caught(0x2) + "kill -INT $p; wait $p");
    CHECK(r.err.find("interrupted") != std::string::npos);
    CHECK(place().files() == before);
}

TEST_CASE("without a display a window is refused, not crashed into") {
    const Run r = place().run("env -u DISPLAY -u WAYLAND_DISPLAY " FJELL_BIN_DIR "/fjell-fly small.fjell --frames 2");
    CHECK(r.code == 3);
    CHECK(r.err.find("--headless") != std::string::npos);
    CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
}

TEST_CASE("a window flies the asked number of frames and closes") {
    if (!std::getenv("DISPLAY")) {
        WARN("skipped: no display");
        return;
    }
    for (const char* method : {"incremental", "recursive"}) {
        const Run r =
            place().fly_with_gl(std::string("small.fjell --frames 5 --size 320x240 --json - --method ") + method);
        INFO(r.err);
        REQUIRE(r.code == 0);
        CHECK(json::parse(r.out)["frames"] == 5);
    }
}
