// What fjell-fly exports: the mesh of a frame as it stands, of packs that are loaded or streamed, and what it says of
// it.
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "fjell/gl/image.h"
#include "support/program.h"
#include "support/temporary_folder.h"

using namespace fjell;
using namespace fjell::test;

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// A terrain of 4 x 4 tiles of 64 cells, 80 pages or so.
struct ExportPlace {
    ExportPlace() {
        spit(folder.path / "recipe.json",
             R"({"columns": 257, "rows": 257, "spacing_m": 60, "seed": 7, "relief_m": 2500, "feature_m": 6000})");
        REQUIRE(run_in(folder.path, FJELL_BIN_DIR "/fjell-bake synth recipe.json -o dem.tif").code == 0);
        REQUIRE(run_in(folder.path, FJELL_BIN_DIR "/fjell-bake dem.tif -o small.fjell --tile 64 --quiet").code == 0);
        spit(folder.path / "slots.toml", "[stream]\npage_slots = 20\n");
    }
    [[nodiscard]] Run fly(const std::string& arguments) const {
        return run_in(folder.path, "ASAN_OPTIONS=detect_leaks=0 " FJELL_BIN_DIR "/fjell-fly " + arguments);
    }
    TemporaryFolder folder;
};

const ExportPlace& export_place() {
    static const ExportPlace one;
    return one;
}

void refuses_export(const std::string& arguments, int code, const std::string& part) {
    const Run r = export_place().fly(arguments);
    INFO(arguments << "\n" << r.err);
    CHECK(r.code == code);
    CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
    CHECK(r.err.find(part) != std::string::npos);
}

std::vector<std::string> rows_of(const std::string& csv) {
    std::istringstream text(csv);
    std::vector<std::string> rows;
    for (std::string row; std::getline(text, row);) rows.push_back(row);
    return rows;
}

// Of a CSV row, counted from 0.
std::string cell(const std::string& row, std::size_t n) {
    std::size_t at = 0;
    for (; n > 0; --n) at = row.find(',', at) + 1;
    return row.substr(at, row.find(',', at) - at);
}

json extras_of(const std::string& name) {
    const std::string glb = slurp(export_place().folder.path / name);
    std::uint32_t length = 0;
    REQUIRE(glb.size() > 20);
    std::memcpy(&length, glb.data() + 12, sizeof length);
    return json::parse(glb.substr(20, length))["scenes"][0]["extras"]["fjell"];
}
} // namespace

TEST_CASE("an export is the mesh of its frame, and says what was asked, what it keeps and what it lacks") {
    spit(export_place().folder.path / "few.toml", "[budget]\nvertices = 2000\n");
    struct Case {
        const char* flags;
        double asked_px;
        bool converged, morphed, lagging, culled;
    };
    for (const Case& c : {Case{"", 1, true, false, false, false}, Case{"--items 50", 1, false, false, true, false},
                          Case{"--profile few.toml --error-px 0.25", 0.25, false, false, false, false},
                          Case{"--morph error --error-px 2", 2, true, true, false, false},
                          Case{"--corner-safe --error-px 3", 3, true, false, false, false},
                          Case{"--method recursive", 1, false, false, false, true},
                          Case{"--method recursive --cull off --topology strip", 1, true, false, false, false}}) {
        const Run r =
            export_place().fly(std::string("small.fjell --headless --frames 30 --export 3:f.glb --csv - ") + c.flags);
        INFO(c.flags << "\n" << r.err);
        REQUIRE(r.code == 0);
        const json e = extras_of("f.glb");
        const std::string row = rows_of(r.out)[4];
        CHECK(std::to_string(e["triangles"].get<int>()) ==
              cell(row, std::string(c.flags).find("recursive") == std::string::npos ? 18 : 3));
        CHECK(e["error_px"] == c.asked_px);
        CHECK(e["error_px_effective"].get<double>() >= c.asked_px);
        CHECK((e["error_px_effective"] == c.asked_px) == c.converged);
        CHECK(e["corner_safe"] == (std::string(c.flags).find("corner") != std::string::npos));
        CHECK(e["converged"] == c.converged);
        CHECK(e["morphed"] == c.morphed);
        CHECK(e["lagging"] == c.lagging);
        CHECK(e["culled"] == c.culled);
    }
    const Run settled =
        export_place().fly("small.fjell --headless --frames 30 --export 3:f.glb --export-converged --items 50");
    INFO(settled.err);
    REQUIRE(settled.code == 0);
    CHECK(extras_of("f.glb")["converged"] == true);
    refuses_export("small.fjell --headless --frames 3 --export-converged", 2, "needs --export");
    refuses_export("small.fjell --headless --frames 3 --export-texel 30", 2, "needs --export");
    for (const char* name : {"few.toml", "f.glb"}) fs::remove(export_place().folder.path / name);
}

TEST_CASE("an export is smaller where it may round, compress or lose some of its colours, and says so") {
    const ExportPlace& place = export_place();
    REQUIRE(run_in(place.folder.path,
                   FJELL_BIN_DIR "/fjell-bake dem.tif -o painted.fjell --tile 64 --quiet --ramp " FJELL_SOURCE_DIR
                                 "/content/ramps/alpine.json")
                .code == 0);
    const auto text_of = [&](const std::string& flags) {
        const Run r = place.fly("painted.fjell --headless --frames 2 --error-px 0.5 --export 1:s.glb " + flags);
        INFO(flags << "\n" << r.err);
        REQUIRE(r.code == 0);
        const std::string glb = slurp(place.folder.path / "s.glb");
        std::uint32_t length = 0;
        std::memcpy(&length, glb.data() + 12, sizeof length);
        return std::pair{glb.size(), json::parse(glb.substr(20, length))};
    };
    const auto [plain, floats] = text_of("");
    CHECK_FALSE(floats.contains("extensionsRequired"));
    CHECK(floats["images"][0]["mimeType"] == "image/png");
    CHECK(extras_of("s.glb")["rounding_m"] == 0);
    const auto [rounded, numbers] = text_of("--export-quantised");
    CHECK(rounded < plain);
    CHECK(numbers["extensionsRequired"] == json{"KHR_mesh_quantization"});
    CHECK(numbers["nodes"][0].contains("scale"));
    CHECK(extras_of("s.glb")["rounding_m"] > 0);
    CHECK(extras_of("s.glb")["rounding_m"] < 1e-3); // the heights are on the lattice, but for a float's digits
    const auto [packed, views] = text_of("--export-quantised --export-meshopt");
    CHECK(packed < rounded);
    CHECK(views["extensionsRequired"] == json{"EXT_meshopt_compression", "KHR_mesh_quantization"});
    const auto [lossy, pictures] = text_of("--export-texture jpeg");
    CHECK(lossy < plain);
    for (const json& image : pictures["images"]) {
        const bool colour = image["name"].get<std::string>().ends_with("colour");
        CHECK(image["mimeType"] == (colour ? "image/jpeg" : "image/png"));
    }
    for (const std::string option : {"--export-quantised", "--export-meshopt", "--export-texture jpeg"})
        refuses_export("small.fjell --headless --frames 3 " + option, 2, "needs --export");
    refuses_export("small.fjell --headless --frames 3 --export 1:s.glb --export-texture webp", 2, "--export-texture");
    for (const char* name : {"painted.fjell", "s.glb"}) fs::remove(place.folder.path / name);
}

TEST_CASE("what is called _m is in metres, also in a CRS that counts feet") {
    const ExportPlace& place = export_place();
    std::string grid = "ncols 5\nnrows 5\nxllcorner 6000000\nyllcorner 2000000\ncellsize 100\n";
    for (int i = 0; i < 25; ++i) grid += std::to_string(1000 + 10 * i) + " ";
    spit(place.folder.path / "feet.asc", grid);
    spit(
        place.folder.path / "feet.prj",
        R"(PROJCS["California 1",GEOGCS["NAD83",DATUM["D_North_American_1983",SPHEROID["GRS_1980",6378137,298.257222101]],)"
        R"(PRIMEM["Greenwich",0],UNIT["Degree",0.0174532925199433]],PROJECTION["Lambert_Conformal_Conic"],)"
        R"(PARAMETER["Standard_Parallel_1",40],PARAMETER["Standard_Parallel_2",41.66666666666666],)"
        R"(PARAMETER["Latitude_Of_Origin",39.33333333333334],PARAMETER["Central_Meridian",-122],)"
        R"(PARAMETER["False_Easting",6561666.666666666],PARAMETER["False_Northing",1640416.666666667],)"
        R"(UNIT["Foot_US",0.30480060960121924]])");
    const Run baked = run_in(place.folder.path,
                             FJELL_BIN_DIR "/fjell-bake feet.asc -o feet.fjell --vertical-unit us-ft && " FJELL_BIN_DIR
                                           "/fjell-bake info feet.fjell --json info.json");
    INFO(baked.err);
    REQUIRE(baked.code == 0);
    REQUIRE(place.fly("feet.fjell --headless --frames 1 --export 0:feet.glb").code == 0);
    constexpr double foot_m = 1200.0 / 3937;
    for (const json& said : {json::parse(slurp(place.folder.path / "info.json")), extras_of("feet.glb")}) {
        CHECK(said["crs_origin"] == json::array({6'000'050, 2'000'450}));
        CHECK(said["crs_step"] == json::array({100, 100}));
        CHECK(said["origin_m"][0].get<double>() == Approx(6'000'050 * foot_m).epsilon(1e-12));
        CHECK(said["origin_m"][1].get<double>() == Approx(2'000'450 * foot_m).epsilon(1e-12));
        CHECK(said["spacing_m"][0].get<double>() == Approx(100 * foot_m).epsilon(1e-12));
    }
    CHECK(json::parse(slurp(place.folder.path / "info.json"))["height_m"][1].get<double>() ==
          Approx(1240 * foot_m).epsilon(1e-6));
}

TEST_CASE("a still camera stands where it was put and looks where it was told") {
    const Run r = export_place().fly(
        "small.fjell --headless --frames 3 --eye 1000,4000.5,9000 --look 7000,500,-5000 --export 2:s.glb --csv -");
    INFO(r.err);
    REQUIRE(r.code == 0);
    CHECK(extras_of("s.glb")["eye"] == json::array({1000, 4000.5, 9000}));
    const auto rows = rows_of(r.out);
    for (int frame = 2; frame <= 3; ++frame) CHECK(cell(rows[static_cast<std::size_t>(frame)], 5) == "0"); // written
    CHECK(export_place().fly("small.fjell --headless --frames 2 --eye 5000,9000,5000 --look 5000,0,5000").code == 0);
    refuses_export("small.fjell --headless --eye 1,2,3", 2, "--look");
    refuses_export("small.fjell --headless --look 1,2,3", 2, "--eye");
    refuses_export("small.fjell --headless --eye 1,2,3 --look 1,2,3", 2, "one point");
    for (const char* place_text : {"1,2", "1,2,3,4", "1,2,x", "1;2;3", "nan,1,2", "1e99,0,0", "1,2,3,"})
        refuses_export(std::string("small.fjell --headless --look 0,0,0 --eye '") + place_text + "'", 2, "X,Y,Z");
    refuses_export("small.fjell --headless --eye 1,2,3 --look 3,2,1 --seed 3", 2, "--eye");
    refuses_export("small.fjell --headless --eye 1,2,3 --look 3,2,1 --path p.json", 2, "--eye");
    fs::remove(export_place().folder.path / "s.glb");
}

TEST_CASE("what is exported or drawn of a streamed pack waits for its pages, or says what it lacks") {
    const std::string flight = "small.fjell --headless --frames 2 --export 1:f.glb ";
    REQUIRE(export_place().fly(flight + "--stream off").code == 0);
    const json whole = extras_of("f.glb");
    for (const char* flags : {"--stream on", "--stream on --items 500", "--stream on --morph time"}) {
        const Run r = export_place().fly(flight + flags);
        INFO(flags << "\n" << r.err);
        REQUIRE(r.code == 0);
        for (const std::string& line : rows_of(r.err)) CHECK(line.find(" waits: ") != std::string::npos);
        const json e = extras_of("f.glb");
        if (std::string(flags).find("morph") != std::string::npos) continue;
        CHECK(e["converged"] == true);
        CHECK(e["triangles"] == whole["triangles"]);
    }
    // Too few slots, and no time to wait: the file is there, and says no more than it is.
    struct Short {
        const char *flags, *part;
        int code;
    };
    for (const Short& s :
         {Short{"--profile slots.toml", "page_slots (20) do not suffice", 1},
          Short{"--stream on --realtime --hz 1000 --read-mb-s 0.05", "--realtime waits for nothing", 0}}) {
        fs::remove(export_place().folder.path / "f.glb");
        refuses_export(flight + s.flags, s.code, s.part);
        const json e = extras_of("f.glb");
        CHECK(e["converged"] == false);
        CHECK(e["lagging"] == true);
        CHECK(e["error_px"] == 1);
        CHECK(e["error_px_effective"].get<double>() > 1);
    }
    fs::create_directory(export_place().folder.path / "p");
    const std::string pictures = "small.fjell --headless --frames 2 --size 160x120 --render p ";
    CHECK(export_place().fly(pictures + "--stream on").code == 0);
    refuses_export(pictures + "--profile slots.toml", 1, "the picture of frame 0 lacks pages");
    CHECK(fs::exists(export_place().folder.path / "p/frame_00001.png"));
    fs::remove_all(export_place().folder.path / "p");
    fs::remove(export_place().folder.path / "f.glb");
}

TEST_CASE("of a flight that ends early the CSV keeps the frames that were measured, and nothing else is left") {
    const fs::path& folder = export_place().folder.path;
    const auto names = export_place().folder.names();
    const struct {
        const char* what;
        int code;
        std::size_t frames;
    } ends[] = {{"EACCES", 3, 5}, {"interrupt", 130, 6}};
    for (const auto& end : ends) {
        spit(folder / "flight.csv", "of an earlier flight");
        const Run r = run_in(folder, "ASAN_OPTIONS=$ASAN_OPTIONS:verify_asan_link_order=0:detect_leaks=0 "
                                     "LD_PRELOAD=" FJELL_FAULTS " FJELL_FAULT='rename five.glb " +
                                         std::string(end.what) +
                                         " 1' " FJELL_BIN_DIR
                                         "/fjell-fly small.fjell --headless --frames 20 --csv flight.csv --json j.json "
                                         "--record r.record --export 5:five.glb");
        CAPTURE(r.err);
        CHECK(r.code == end.code);
        CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
        CHECK(r.err.find("flight.csv has the " + std::to_string(end.frames) + " frames before") != std::string::npos);
        CHECK(rows_of(slurp(folder / "flight.csv")).size() == 1 + end.frames);
        fs::remove(folder / "flight.csv");
        fs::remove(folder / "five.glb"); // the interrupted one was finished
        CHECK(export_place().folder.names() == names);
    }
}

TEST_CASE("pictures overwrite pictures, but no other file that has the name of one") {
    const fs::path& folder = export_place().folder.path;
    fs::create_directory(folder / "pictures");
    const std::string flight = "small.fjell --headless --frames 1 --render pictures/ ";
    refuses_export(flight + "--csv pictures/frame_00000.png", 2, "would overwrite");
    fs::create_symlink("../small.fjell", folder / "pictures/frame_00000.png");
    const std::string pack = slurp(folder / "small.fjell");
    refuses_export(flight, 2, "would overwrite the input small.fjell");
    fs::create_symlink("small.fjell", folder / "link.glb");
    refuses_export("small.fjell --headless --frames 1 --export 0:link.glb", 2, "the input");
    fs::remove(folder / "link.glb");
    CHECK(slurp(folder / "small.fjell") == pack);
    fs::remove_all(folder / "pictures");
}

TEST_CASE("a pack of more tiles than a profile holds is refused with the tile size that fits, which then flies") {
    const TemporaryFolder folder;
    std::string heights = "ncols 2\nnrows 2049\nxllcorner 0\nyllcorner 0\ncellsize 30\n";
    for (int i = 0; i < 2049; ++i) heights += std::to_string(i % 7) + " " + std::to_string(i % 5) + "\n";
    spit(folder / "strip.asc", heights);
    const auto bake = [&](const std::string& tile) {
        return run_in(folder.path, FJELL_BIN_DIR "/fjell-bake strip.asc -o strip.fjell --tile " + tile).code;
    };
    const auto fly = [&](const std::string& how) {
        return run_in(folder.path, FJELL_BIN_DIR
                                       "/fjell-fly strip.fjell --headless --frames 2 --profile " FJELL_SOURCE_DIR
                                       "/profiles/tiny.toml " +
                                       how);
    };
    REQUIRE(bake("2") == 0);
    for (const char* how : {"--stream off", "--stream on", "--method recursive"}) {
        const Run r = fly(how);
        CAPTURE(how, r.err);
        CHECK(r.code == 1);
        CHECK(r.err.find("--tile 8: 256 tiles instead of 1024") != std::string::npos);
    }
    REQUIRE(bake("8") == 0);
    for (const char* how : {"--stream off", "--stream on", "--method recursive"}) CHECK(fly(how).code == 0);
}

namespace {

// A file's first texture whose name ends so; empty: there is none.
gl::Image texture_of(const std::string& name, const std::string& end) {
    const fs::path& folder = export_place().folder.path;
    const std::string glb = slurp(folder / name);
    std::uint32_t length = 0;
    std::memcpy(&length, glb.data() + 12, sizeof length);
    const json document = json::parse(glb.substr(20, length));
    gl::Image image;
    for (const json& texture : document.value("images", json::array())) {
        if (!texture["name"].get<std::string>().ends_with(end)) continue;
        const json& view = document["bufferViews"][texture["bufferView"].get<std::size_t>()];
        spit(folder / "texture.png",
             glb.substr(28 + length + view.value("byteOffset", std::size_t{0}), view["byteLength"].get<std::size_t>()));
        image = gl::read_png((folder / "texture.png").string());
        break;
    }
    return image;
}

} // namespace

TEST_CASE("an export has the colours of layers, at the texel size that is asked for") {
    const fs::path& folder = export_place().folder.path;
    fs::create_directory(folder / "stuff");
    spit(
        folder / "stuff/red.json",
        R"({"size_m": 4, "base": [188, 90, 90], "steps": [{"draw": "noise", "cells": 4, "octaves": 1, "height_m": 0.01}]})");
    spit(
        folder / "stuff/blue.json",
        R"({"size_m": 4, "base": [90, 90, 188], "steps": [{"draw": "noise", "cells": 4, "octaves": 1, "height_m": 0.01}]})");
    REQUIRE(run_in(folder, FJELL_BIN_DIR "/fjell-bake materials stuff --size 16 -o two.fjell-materials").code == 0);
    spit(folder / "rules.json", R"({"rules": [{"layer": "red"}, {"layer": "blue", "height_m": [350, null]}]})");
    REQUIRE(run_in(folder, FJELL_BIN_DIR "/fjell-bake dem.tif -o named.fjell --tile 64 --layers rules.json "
                                         "--splat full --quiet")
                .code == 0);
    spit(folder / "tint.toml", "[layers]\ntint = 0\n");
    const std::string flight = " --headless --frames 2 --eye 7000,9000,7000 --look 7100,0,7100 --export 1:l.glb "
                               "--export-texel 31 --profile tint.toml --materials two.fjell-materials";
    for (const std::string pack :
         {"named.fjell --stream off", "named.fjell --stream on", "small.fjell --layers rules.json"}) {
        const Run r = export_place().fly(pack + flight);
        INFO(pack << "\n" << r.err);
        REQUIRE(r.code == 0);
        const gl::Image texture = texture_of("l.glb", " colour");
        CHECK(texture.width == 128); // of 64 cells of 60 m: 30.2 m
        std::size_t red = 0, blue = 0;
        for (std::size_t i = 0; i < texture.rgb.size(); i += 3) {
            red += texture.rgb[i] > 150 && texture.rgb[i + 2] < 110;
            blue += texture.rgb[i] < 110 && texture.rgb[i + 2] > 150;
        }
        CHECK(red + blue > texture.rgb.size() / 3 * 8 / 10);
        CHECK(red > texture.rgb.size() / 30);
        CHECK(blue > texture.rgb.size() / 30);
    }
    // Without layers the colours are the map's, and no texel is finer than it has.
    spit(folder / "off.toml", "[layers]\non = false\n");
    REQUIRE(export_place()
                .fly("small.fjell --headless --frames 2 --export 1:l.glb --export-texel 31 --profile off.toml "
                     "--materials two.fjell-materials --layers rules.json")
                .code == 0);
    CHECK(texture_of("l.glb", " colour").width == 32); // as the map is
    spit(folder / "rules_off.toml", "[layers]\nsplat = false\n");
    refuses_export("named.fjell --headless --frames 2 --export 1:l.glb --profile rules_off.toml "
                   "--materials two.fjell-materials",
                   2, "give rules too");
}
