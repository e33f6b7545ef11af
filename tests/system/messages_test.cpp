// What every program says about a bad input or a wrong word: one line of ours, with the file in it, and its exit code.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string>
#include <vector>

#include "support/program.h"
#include "support/rounds.h"
#include "support/temporary_folder.h"

using namespace fjell::test;

namespace {

struct Bad {
    std::string command; // with {bake}, {fly} or {editor} for the program, {fault} for the interposer
    int code = 1;
    std::string says; // in the line
};

class BadInputs {
public:
    BadInputs() {
        put("land.json", R"({"columns": 129, "rows": 129, "spacing_m": 60, "seed": 7, "relief_m": 2500})");
        REQUIRE(run("{bake} land.json -o p.fjell --tile 64 --quiet").code == 0);
        REQUIRE(run("{fly} p.fjell --headless --frames 2 --record r.json").code == 0);
        const std::string pack = slurp(folder.path / "p.fjell"), recording = slurp(folder.path / "r.json");
        put("empty.fjell", "");
        put("short.fjell", pack.substr(0, pack.size() / 2));
        put("header.fjell", changed(pack, 100));
        put("directory.fjell", changed(pack, pack.size() - 5));
        put("page.fjell", changed(pack, pack.size() / 8));
        put("text.fjell", "a pack of lies");
        put("text.tif", "no raster");
        put("cut.asc", "ncols 9\nnrows 9\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3\n");
        put("comma.json", "{\"columns\": 9,}");
        put("twice.json", "{\"columns\": 9,\n \"columns\": 8}");
        put("word.json", R"({"inputs": ["a.tif"], "nodata": "holes"})");
        put("comma.toml", "[refine]\nmax_error_px = 1,\n");
        put("twice.toml", "[refine]\nmax_error_px = 1\nmax_error_px = 2\n");
        put("word.toml", "[refine]\nmethod = \"magic\"\n");
        put("units.json", "{\"units\": \"feet\", \"orbit\": {}}");
        put("orbits.json", "{\"orbit\": {},\n\"orbit\": {}}");
        put("cut.rec", recording.substr(0, recording.size() - 3));
        put("morph.rec", replaced(recording, "\"morph\":\"none\"", "\"morph\":\"slow\""));
        put("twice.rec", replaced(recording, "\"morph\":\"none\"", "\"morph\":\"none\",\"morph\":\"none\""));
        put("other.rec", replaced(recording, "\"pack\":\"", "\"pack\":\"f\",\"was\":\""));
        put("error.rec", replaced(recording, "\"error_px\":", "\"error_px\":-"));
        put("ramp.json", R"({"stops": [], "stops": []})");
        std::filesystem::create_directory(folder.path / "folder.fjell");
    }
    [[nodiscard]] Run run(std::string command) const {
        for (const auto& [name, value] : std::vector<std::pair<std::string, std::string>>{
                 {"{bake}", FJELL_BIN_DIR "/fjell-bake"},
                 {"{fly}", FJELL_BIN_DIR "/fjell-fly"},
                 {"{editor}", "ASAN_OPTIONS=detect_leaks=0 " FJELL_BIN_DIR "/fjell-editor --headless --size 320x320"},
                 {"{fault}", "LD_PRELOAD=" FJELL_FAULTS " FJELL_FAULT="}})
            command = replaced(command, name, value);
        return run_in(folder.path, no_pixels + command);
    }
    TemporaryFolder folder;

private:
    void put(const std::string& name, const std::string& text) const { spit(folder.path / name, text); }
    [[nodiscard]] static std::string changed(std::string bytes, std::size_t at) {
        bytes[at] = static_cast<char>(bytes[at] ^ 4);
        return bytes;
    }
    [[nodiscard]] static std::string replaced(std::string text, const std::string& what, const std::string& by) {
        const std::size_t at = text.find(what);
        return at == std::string::npos ? text : text.replace(at, what.size(), by);
    }
};

// What no reader of a command line should have to see.
std::string forbidden_in(const std::string& text) {
    for (const char* part : {"exception", "json.", "toml::", "terminate", "what()", "see the header", "std::", "ERROR ",
                             "filesystem error", "stoull", "[json", "CLI", "error_category", "not in {", "Could not"})
        if (text.find(part) != std::string::npos) return part;
    std::size_t digits = 0;
    for (const char c : text) {
        digits = std::isdigit(static_cast<unsigned char>(c)) != 0 ? digits + 1 : 0;
        if (digits == 30) return "thirty digits";
    }
    return {};
}

// A run of fjell-bake costs a tenth of a second, most of it GDAL's start: what resembles another is for full rounds.
std::vector<Bad> bad_inputs() {
    std::vector<Bad> all{
        // Packs.
        {"{bake} info none.fjell", 1, "none.fjell: No such file or directory; give an existing file"},
        {"{bake} verify page.fjell", 1, "page.fjell: page "},
        {"{fault}'open p.fjell EACCES 1' {bake} verify p.fjell", 1, "p.fjell: Permission denied"},
        {"{fault}'open p.fjell EMFILE 1' {fly} p.fjell --headless --frames 1", 3,
         "p.fjell: cannot open: Too many open files"},
        {"{fly} none.fjell --headless --frames 1", 1, "none.fjell: "},
        {"{fly} folder.fjell --headless --frames 1", 1, "is a folder"},
        {"{fly} page.fjell --headless --frames 1 --stream off", 1, "page.fjell: "},
        {"{fly} text.fjell --headless --frames 1", 1, "not a Fjell pack"},
        // Heights and recipes.
        {"{bake} text.tif -o o.fjell", 1, "text.tif: "},
        {"{bake} cut.asc -o o.fjell", 1, "cut.asc: "},
        {"{fault}'open cut.asc EACCES 1+' {bake} cut.asc -o o.fjell", 1, "cut.asc: Permission denied"},
        {"{bake} comma.json -o o.fjell", 1, "comma.json:1: is not JSON"},
        {"{bake} twice.json -o o.fjell", 1, "twice.json:2: \"columns\" is there twice"},
        {"{bake} --recipe word.json -o o.fjell", 1,
         "word.json: \"nodata\" is \"holes\", but must be one of hole, fill, refuse"},
        {"{bake} land.json -o o.fjell --ramp ramp.json --quiet", 1, "ramp.json:1: \"stops\" is there twice"},
        {"{bake} land.json -o none/o.fjell --quiet", 1, "the output folder does not exist"},
        {"{bake} land.json -o /dev/full --quiet", 3,
         "/dev/full: cannot write: No space left on device; free some space"},
        // Profiles, paths, recordings.
        {"{fly} p.fjell --headless --profile none.toml", 1, "none.toml: "},
        {"{fly} p.fjell --headless --profile comma.toml", 1, "comma.toml:2: "},
        {"{fly} p.fjell --headless --profile twice.toml", 1, "twice.toml:3: a key or a table is there twice"},
        {"{fly} p.fjell --headless --profile word.toml", 1,
         "word.toml:2: refine.method: must be \"incremental\" or \"recursive\""},
        {"{fly} p.fjell --headless --path comma.json", 1, "comma.json:1: is not JSON"},
        {"{fly} p.fjell --headless --path units.json", 1, "units.json: units: must be \"metres\" or \"terrain\""},
        {"{fly} p.fjell --headless --path orbits.json", 1, "orbits.json:2: \"orbit\" is there twice"},
        {"{fly} p.fjell --headless --replay none.rec", 1, "none.rec: "},
        {"{fly} p.fjell --headless --replay comma.json", 1, "comma.json:1: "},
        {"{fly} p.fjell --headless --replay cut.rec", 1, "cut.rec:3: the recording ends in the middle"},
        {"{fly} p.fjell --headless --replay morph.rec", 1,
         "morph.rec:2: not a recording: \"morph\" must be one of none, error, time"},
        {"{fly} p.fjell --headless --replay twice.rec", 1, "twice.rec:2: \"morph\" is there twice"},
        {"{fly} p.fjell --headless --replay other.rec", 1, "other.rec"},
        {"{fly} p.fjell --headless --replay error.rec", 1, "error.rec: CutSettings::max_error_px"},
        {"{fly} p.fjell --headless --frames 1 --csv none/f.csv", 1, "the output folder does not exist"},
        {"{fly} p.fjell --headless --frames 1 --json folder.fjell", 1, "folder.fjell: is a folder"},
        {"{fly} p.fjell --headless --frames 1 --csv /dev/full", 3, "No space left on device"},
        {"{fly} p.fjell --headless --frames 1 --export 0:none/f.glb", 1, "the output folder does not exist"},
        // Words.
        {"{bake} --what", 2, "--what: no such option"},
        {"{bake} land.json -o o.fjell --order snail", 2, "--order: snail: must be one of planar, hz, linear"},
        {"{bake} land.json -o o.fjell --quantum 1e999", 2, "--quantum"},
        {"{bake} land.json -o o.fjell --zscale x", 2, "--zscale = x: must be a number"},
        {"{bake} land.json -o o.fjell --json ''", 2, "an empty word after --json"},
        {"{bake} info", 2, "no pack given"},
        {"{fly}", 2, "PACK is missing"},
        {"{fly} p.fjell more.fjell", 2, "more.fjell: no such option, or a word too many"},
        {"{fly} p.fjell --json=", 2, "nothing after ="},
        {"{fly} p.fjell --frames 0", 2, "--frames: 0: must be a whole number from 1 to 10000000"},
        {"{fly} p.fjell --frames 99999999999999999999999999", 2, "--frames"},
        {"{fly} p.fjell --frames 1 --frames 2", 2, "--frames"},
        {"{fly} p.fjell --error-px nan", 2, "--error-px"},
        {"{fly} p.fjell --error-px 1e999", 2, "--error-px"},
        {"{fly} p.fjell --mode pretty", 2, "--mode: pretty: must be one of shaded"},
        {"{fly} p.fjell --headless=maybe", 2, "--headless = maybe: takes no value"},
        {"{fly} p.fjell --seed x", 2, "--seed = x: must be a number"},
        {"{fly} p.fjell --size 0x0", 2, "--size 0x0"},
        {"{editor} p.fjell ''", 2, "an empty word"},
        {"{editor} p.fjell --profile comma.toml", 1, "comma.toml:2: "},
        {"{editor} p.fjell --script none.txt", 1, "none.txt: "},
    };
    const std::vector<Bad> alike{
        {"{bake} info folder.fjell", 1, "folder.fjell: is a folder"},
        {"{bake} info empty.fjell", 1, "empty.fjell: "},
        {"{bake} info short.fjell", 1, "short.fjell: "},
        {"{bake} info header.fjell", 1, "header.fjell: "},
        {"{bake} verify directory.fjell", 1, "directory.fjell: "},
        {"{bake} verify text.fjell", 1, "not a Fjell pack"},
        {"{bake} heights page.fjell -o h.tif", 1, "page.fjell: page "},
        {"{bake} none.tif -o o.fjell", 1, "none.tif: "},
        {"{bake} folder.fjell -o o.fjell", 1, "folder.fjell: is a folder"},
        {"{bake} synth comma.json -o o.tif", 1, "comma.json:1: is not JSON"},
        {"{bake} synth none.json -o o.tif", 1, "none.json: "},
        {"{bake} --recipe twice.json -o o.fjell", 1, "twice.json:2: \"columns\" is there twice"},
        {"{bake} land.json -o o.fjell --texture text.tif --quiet", 1, "text.tif: "},
        {"{bake} land.json -o folder.fjell --quiet", 1, "folder.fjell: is a folder"},
        {"{fault}'open o.fjell EACCES 1+' {bake} land.json -o o.fjell --quiet", 3, "Permission denied"},
        {"{bake} land.json -o land.json --quiet", 2, "land.json: would overwrite the input"},
        {"{bake} land.json", 2, "-o OUT.fjell"},
        {"{bake} land.json -o", 2, "its value is missing"},
        {"{bake} land.json -o o.fjell --threads -1", 2, "--threads: -1: must be a whole number from 0 to 1024"},
        {"{bake} land.json -o o.fjell --checkpoint nan", 2, "must be a number from 0 to 3600"},
        {"{bake} land.json -o o.fjell --memory 1e9", 2, "--memory"},
        {"{bake} land.json -o o.fjell --quantum 0", 2, "--quantum"},
        {"{bake} land.json -o o.fjell --quantum nan", 2, "--quantum"},
        {"{bake} land.json -o o.fjell --tile 3", 2, "--tile 3"},
        {"{bake} info p.fjell --picture-size 7", 2, "--picture-size"},
        {"{bake} verify ''", 2, "an empty word"},
        {"{editor} --what", 2, "--what: no such option"},
        {"{editor} --scale nan", 2, "--scale"},
    };
    if (full_rounds()) all.insert(all.end(), alike.begin(), alike.end());
    return all;
}

} // namespace

TEST_CASE("whatever is wrong with a file or a word is one line of ours that names it, with its exit code") {
    const BadInputs place;
    for (const Bad& bad : bad_inputs()) {
        const Run r = place.run(bad.command);
        CAPTURE(bad.command, r.code, r.err);
        CHECK(r.code == bad.code);
        CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
        CHECK(r.err.starts_with("fjell-"));
        CHECK_THAT(r.err, Catch::Contains(bad.says));
        CHECK(forbidden_in(r.err).empty());
        CHECK(!std::filesystem::exists(place.folder.path / "o.fjell"));
    }
}

TEST_CASE("in a script every command that is malformed or fails is one line, and the rest is done") {
    const BadInputs place;
    spit(place.folder.path / "s.txt",
         "open none.fjell\nfly away\nset refine.max_error_px 1e999\nset refine.max_error_px \"\nopen folder.fjell\n"
         "open text.fjell\nopen-profile twice.toml\nopen units.json\nsave-profile none/p.toml\nmode pretty\n"
         "open p.fjell\nopen-path orbits.json\nset refine.max_error_px 3\ndump state.json\n");
    const Run r = place.run("{editor} --script s.txt --do 'frames x'");
    CAPTURE(r.err);
    CHECK(r.code == 2); // the first failure's
    CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 12);
    CHECK(forbidden_in(r.err).empty());
    for (const char* part : {"fjell-editor: --do: frames: ", "none.fjell: ", "s.txt:2: fly: no such command",
                             "s.txt:3: ", "s.txt:4: a quote is not closed", "folder.fjell: ", "text.fjell: ",
                             "twice.toml:3: ", "orbits.json:2: ", "none/p.toml: ", "s.txt:10: "})
        CHECK_THAT(r.err, Catch::Contains(part));
    CHECK_THAT(slurp(place.folder.path / "state.json"), Catch::Contains("\"refine.max_error_px\": 3"));
}

TEST_CASE("heights on the editor's command line are baked beside themselves without a window, and never over a file") {
    const BadInputs place;
    const std::string command = "{editor} land.json --do 'dump state.json'";
    const Run r = place.run(command);
    CAPTURE(r.err);
    CHECK(r.code == 0);
    CHECK(slurp(place.folder.path / "land.fjell").size() > 1000);
    CHECK_THAT(slurp(place.folder.path / "state.json"), Catch::Contains("\"path\": \"land.fjell\""));
    const std::string baked = slurp(place.folder.path / "land.fjell");
    const Run again = place.run(command);
    CHECK(again.code == 2);
    CHECK_THAT(again.err, Catch::Contains("land.fjell: exists already"));
    CHECK(std::count(again.err.begin(), again.err.end(), '\n') == 1);
    CHECK(slurp(place.folder.path / "land.fjell") == baked);
}
