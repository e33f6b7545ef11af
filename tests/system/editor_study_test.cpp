// Two profiles in one picture, runs by place and rendered pictures, by the built editor without a window: state, files
// and pixels.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "fjell/gl/image.h"
#include "support/editor_pack.h"
#include "support/program.h"
#include "support/temporary_folder.h"

using namespace fjell;
using namespace fjell::test;
using nlohmann::json;

namespace {

namespace fs = std::filesystem;

class Studies {
public:
    // The state after these commands. The light is what software draws fastest, and what does not adapt.
    [[nodiscard]] json after(const std::vector<std::string>& commands, double error_px = 3) const {
        spit(folder / "profile.toml", "[view]\nwidth_px = 320\nheight_px = 180\nsamples = 1\n"
                                      "[refine]\nmax_error_px = " +
                                          std::to_string(error_px) +
                                          "\n[light]\nair = \"simple\"\ndetail = false\ndither = false\n");
        std::string line = "ASAN_OPTIONS=detect_leaks=0 " FJELL_BIN_DIR
                           "/fjell-editor --headless --size 480x320 --scale "
                           "0.5 --profile profile.toml '" +
                           small_pack() + "'";
        for (const std::string& c : commands) line += " --do '" + c + "'";
        const Run r = run_in(folder.path, line + " --do 'dump state.json'");
        INFO(line << "\n" << r.err);
        code = r.code;
        REQUIRE(r.code <= 3);
        return json::parse(slurp(folder / "state.json"));
    }
    [[nodiscard]] gl::Image picture(const std::string& name) const { return gl::read_png(folder / name); }

    TemporaryFolder folder;
    mutable int code = 0;
};

// Of the columns from..to, how many pixels differ.
std::size_t differing(const gl::Image& a, const gl::Image& b, std::uint32_t from, std::uint32_t to) {
    REQUIRE(a.width == b.width);
    REQUIRE(a.height == b.height);
    std::size_t count = 0;
    for (std::uint32_t y = 0; y < a.height; ++y)
        for (std::uint32_t x = from; x < to; ++x) count += !std::equal(a.pixel(x, y), a.pixel(x, y) + 3, b.pixel(x, y));
    return count;
}

} // namespace

TEST_CASE("beyond the divider the picture is that of the other threshold, before it that of the profile's") {
    const Studies s;
    (void)s.after({"wait", "screenshot coarse.png terrain"}, 40);
    const json both =
        s.after({"wait", "screenshot fine.png terrain", "compare-picture 40", "divider 0.25", "wait",
                 "screenshot both.png terrain", "compare-view difference", "wait", "screenshot apart.png terrain",
                 "compare-picture 2", "wait", "screenshot alike.png terrain"},
                2);
    CHECK(both["compared_picture"]["there"] == true);
    const gl::Image fine = s.picture("fine.png"), coarse = s.picture("coarse.png"), split = s.picture("both.png");
    const std::uint32_t at = fine.width / 4, all = fine.width;
    CHECK(differing(fine, split, 0, at) == 0);
    CHECK(differing(coarse, split, at, all) == 0);
    CHECK(differing(fine, coarse, 0, at) > 100); // so each side is told apart
    CHECK(differing(fine, coarse, at, all) > 100);
    const gl::Image apart = s.picture("apart.png"), alike = s.picture("alike.png");
    CHECK(std::ranges::count(alike.rgb, 0) == static_cast<std::ptrdiff_t>(alike.rgb.size()));
    std::size_t wrong = 0;
    for (std::uint32_t y = 0; y < apart.height; ++y)
        for (std::uint32_t x = 0; x < all; ++x) {
            const bool same = std::equal(fine.pixel(x, y), fine.pixel(x, y) + 3, coarse.pixel(x, y));
            const std::uint8_t* const p = apart.pixel(x, y);
            wrong += same != (p[0] == 0 && p[1] == 0 && p[2] == 0);
        }
    CHECK(wrong == 0);
}

TEST_CASE("two profiles in a picture are compared by number: what each kept, and how many pixels differ visibly") {
    const Studies s;
    const json other = s.after({"wait", "screenshot fine.png terrain", "set refine.max_error_px 40", "wait",
                                "screenshot coarse.png terrain", "undo", "compare-picture 40", "wait"},
                               2);
    const gl::Image fine = s.picture("fine.png"), coarse = s.picture("coarse.png");
    std::size_t visible = 0;
    for (std::size_t i = 0; i < fine.rgb.size(); i += 3) {
        int most = 0;
        for (std::size_t c = i; c < i + 3; ++c) most = std::max(most, std::abs(fine.rgb[c] - coarse.rgb[c]));
        visible += most >= 4;
    }
    const double share = static_cast<double>(visible) / (fine.width * fine.height);
    CHECK(share > 0.01);
    CHECK(other["compared_picture"]["differing"].get<double>() == Approx(share).margin(1e-9));
    CHECK(other["compared_picture"]["asked_px"] == 40);
    CHECK(other["compared_picture"]["kept_px"] <= 40);
    CHECK(other["compared_picture"]["exhausted"].empty());
    CHECK(s.after({"compare-picture 2", "wait"}, 2)["compared_picture"]["differing"] == 0);
    // Of a profile that is short of vertices what it kept is told, not what was asked.
    spit(s.folder / "small.toml", "[budget]\nvertices = 3000\n[refine]\nmax_error_px = 1\n");
    const json small = s.after({"compare small.toml", "compare-picture profile", "wait"}, 2)["compared_picture"];
    CHECK(small["asked_px"] == 1);
    CHECK(small["kept_px"] > 1.5);
    CHECK(small["exhausted"] == json({"vertices"}));
}

TEST_CASE("a picture is compared with half its triangles") {
    const Studies s;
    const json state = s.after({"compare-picture half", "wait"}, 2);
    const json& half = state["compared_picture"];
    const double all = state["measures"]["triangles_drawn"];
    CHECK(2 * half["triangles"].get<double>() == Approx(all).epsilon(0.02));
    CHECK(half["asked_px"] > 2);
    CHECK(half["kept_px"].get<double>() <= half["asked_px"].get<double>() * 1.001);
}

TEST_CASE("materials are chosen for a pack, show in its picture, and are told by their shares under the camera") {
    const Studies s;
    const Run made = run_in(s.folder.path, FJELL_BIN_DIR "/fjell-bake materials " FJELL_SOURCE_DIR
                                                         "/content/materials -o m.fjell-materials --size 16");
    REQUIRE(made.code == 0);
    const json state = s.after({"camera 15000 4000 15000 0 -60", "wait", "screenshot bare.png terrain",
                                "materials m.fjell-materials nordic", "set layers.distance_m 100000", "wait",
                                "screenshot materials.png terrain"});
    CHECK(state["materials"]["rules"] == "nordic");
    CHECK(state["profile"]["layers.on"] == true);
    double all = 0;
    for (const auto& under : state["materials"]["under"].items()) all += under.value().get<double>();
    CHECK(all == Approx(1).margin(0.05));
    const gl::Image bare = s.picture("bare.png"), with = s.picture("materials.png");
    CHECK(differing(bare, with, 0, bare.width) > bare.width * bare.height / 4);
    CHECK(s.code == 0);
    const json none = s.after({"materials m.fjell-materials nordic", "materials none", "wait"});
    CHECK(none["materials"]["materials"] == "");
    CHECK(none["materials"]["under"].empty());
    // Of a file that is none the ground stays as it was.
    spit(s.folder / "no.fjell-materials", "FJELLMAT");
    const json kept = s.after({"materials m.fjell-materials nordic", "materials no.fjell-materials", "wait"});
    CHECK(kept["materials"]["materials"] == "m.fjell-materials");
    CHECK(s.code == 1);
}

TEST_CASE("a pack that says which materials lie where warns while there are none to draw") {
    const TemporaryFolder folder;
    const Run baked =
        run_in(folder.path, FJELL_BIN_DIR
               "/fjell-bake " FJELL_SOURCE_DIR "/content/terrain/mountains-small.json -o a.fjell --tile 64 "
               "--layers " FJELL_SOURCE_DIR "/content/materials/splat/alpine.json --splat quarter");
    INFO(baked.err);
    REQUIRE(baked.code == 0);
    REQUIRE(run_in(folder.path, FJELL_BIN_DIR "/fjell-bake materials " FJELL_SOURCE_DIR
                                              "/content/materials -o m.fjell-materials --size 16")
                .code == 0);
    const Run opened = run_in(folder.path, no_pixels + FJELL_BIN_DIR
                                               "/fjell-editor a.fjell --headless --size 480x320 --do 'dump bare.json' "
                                               "--do 'materials m.fjell-materials' --do wait --do 'dump with.json'");
    CHECK(opened.code == 0);
    CHECK(opened.err.find("Light > Materials") != std::string::npos);
    CHECK(json::parse(slurp(folder / "bare.json"))["materials"]["under"].empty());
    const json with = json::parse(slurp(folder / "with.json"))["materials"]["under"];
    double all = 0;
    for (const auto& under : with.items()) all += under.value().get<double>();
    CHECK(all > 0.5);
    CHECK(all <= 1.001);
}

TEST_CASE("a path in the picture goes on beyond the divider, and is no difference between two profiles") {
    const Studies s;
    (void)s.after({"camera 3000 5000 15000 90 -10",
                   "add-point",
                   "camera 27000 5000 15000 90 -10",
                   "add-point",
                   "home",
                   "wait",
                   "screenshot path.png terrain",
                   "overlay path off",
                   "wait",
                   "screenshot bare.png terrain",
                   "compare-picture 2",
                   "wait",
                   "compare-view difference",
                   "wait",
                   "screenshot black.png terrain",
                   "overlay path on",
                   "wait",
                   "screenshot apart.png terrain",
                   "compare-view split",
                   "wait",
                   "screenshot both.png terrain"},
                  2);
    const gl::Image path = s.picture("path.png"), bare = s.picture("bare.png"), both = s.picture("both.png");
    CHECK(differing(path, bare, 0, path.width / 2) > 100); // on either side of the divider
    CHECK(differing(path, bare, path.width / 2, path.width) > 100);
    CHECK(differing(path, both, 0, path.width) == 0);
    // Over the difference it has its own colour, or white where a point is selected; small differences are blue.
    const gl::Image black = s.picture("black.png"), apart = s.picture("apart.png");
    CHECK(std::ranges::count(black.rgb, 0) == static_cast<std::ptrdiff_t>(black.rgb.size()));
    for (std::uint32_t y = 0; y < apart.height; ++y)
        for (std::uint32_t x = 0; x < apart.width; ++x) {
            const std::uint8_t* const p = apart.pixel(x, y);
            if (p[0] + p[1] + p[2] > 30) REQUIRE(p[0] >= p[1]);
        }
}

TEST_CASE("benchmarks are kept as runs, the latest first, and a place of one is looked from") {
    const Studies s;
    const json state = s.after({"run-place 0 0.5", "benchmark a.csv 60", "wait", "set refine.max_error_px 30",
                                "benchmark b.csv 40", "wait", "run-place 1 0.5", "heat error", "frames 2"});
    const json& all = state["runs"]["all"];
    REQUIRE(all.size() == 2);
    CHECK(all[0]["name"] == "b.csv");
    CHECK(all[0]["error_px"] == 30);
    CHECK(all[0]["frames"] == 39);
    CHECK(all[1]["frames"] == 59);
    CHECK(all[1]["worst"][0].size() >= 5);
    CHECK(all[1]["worst"][0][0]["update_us"].get<double>() == Approx(all[1]["max_us"].get<double>()));
    CHECK(state["runs"]["chosen"]["run"] == 1);
    const json &chosen = state["runs"]["chosen"]["position_m"], &eye = state["camera"]["view_eye_m"];
    for (int i = 0; i < 3; ++i) CHECK(eye[i].get<double>() == Approx(chosen[i].get<double>()));
    // The dearest place is the frame that the CSV has as its dearest, but for the first.
    const std::string csv = slurp(s.folder / "a.csv");
    double dearest_us = 0;
    long dearest = -1;
    for (std::size_t from = csv.find('\n') + 1; from < csv.size(); from = csv.find('\n', from) + 1) {
        const long frame = std::stol(csv.substr(from, csv.find(',', from) - from));
        const double us = std::stod(csv.substr(csv.find(',', from) + 1));
        if (frame == 0 || us <= dearest_us) continue;
        dearest_us = us;
        dearest = frame;
    }
    CHECK(all[1]["worst"][0][0]["frame"] == dearest);
    CHECK(s.code == 2); // of the place before there was a run
}

TEST_CASE("a picture is rendered at any size") {
    const Studies s;
    const json one = s.after({"wait", "render large.png width=1000 height=300", "wait"});
    INFO(one["messages"].dump());
    const gl::Image large = s.picture("large.png");
    CHECK(large.width == 1000);
    CHECK(large.height == 300);
}

TEST_CASE("a bookmark leads back") {
    const Studies s;
    const json state = s.after({"wait", "add-bookmark Start", "wait", "jump 9000 9000", "wait", "add-bookmark", "wait",
                                "bookmark 0", "wait", "remove-bookmark 1", "frames 2"});
    REQUIRE(state["bookmarks"].size() == 1);
    const json& b = state["bookmarks"][0];
    CHECK(b["name"] == "Start");
    for (int i = 0; i < 3; ++i)
        CHECK(state["camera"]["view_eye_m"][i].get<double>() == Approx(b["position_m"][i].get<double>()));
}
