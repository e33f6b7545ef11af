// What an analyst reads off the editor: coordinates, distances, areas, contours, slopes, exports, measured errors. All
// over a plane whose every number is known, baked from a file with a CRS.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "fjell/gl/image.h"
#include "fjell/gl/palette.h"
#include "support/editor_pack.h"
#include "support/program.h"
#include "support/temporary_folder.h"

using namespace fjell;
using namespace fjell::test;
using nlohmann::json;

namespace {

constexpr const char* utm33 =
    R"(PROJCS["WGS 84 / UTM zone 33N",GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],)"
    R"(PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],)"
    R"(PARAMETER["latitude_of_origin",0],PARAMETER["central_meridian",15],PARAMETER["scale_factor",0.9996],)"
    R"(PARAMETER["false_easting",500000],PARAMETER["false_northing",0],UNIT["metre",1],AUTHORITY["EPSG","32633"]])";

// 101 x 101 samples, 10 m apart, sample (0, 0) at 499500 E 5200500 N; heights from 100 m in the west, 0.5 m a metre.
class Plane {
public:
    Plane() {
        std::string text = "ncols 101\nnrows 101\nxllcorner 499495\nyllcorner 5199495\ncellsize 10\n";
        for (int i = 0; i < 101 * 101; ++i) text += std::to_string(100 + 5 * (i % 101)) + (i % 101 == 100 ? "\n" : " ");
        spit(folder / "plane.asc", text);
        spit(folder / "plane.prj", utm33);
        spit(folder / "profile.toml",
             "[view]\nwidth_px = 320\nheight_px = 240\nsamples = 1\n[refine]\nmax_error_px = 1\n"
             "[light]\nair = \"simple\"\ndetail = false\ndither = false\n");
    }
    [[nodiscard]] json after(const std::vector<std::string>& commands) const {
        std::string line = "ASAN_OPTIONS=detect_leaks=0 " FJELL_BIN_DIR
                           "/fjell-editor --headless --size 640x480 --scale 0.5 --profile profile.toml";
        for (const std::string& c : commands) line += " --do '" + c + "'";
        const Run r = run_in(folder.path, line + " --do 'dump state.json'");
        INFO(line << "\n" << r.err);
        out = r.out + r.err;
        code = r.code;
        REQUIRE(r.code <= 3);
        return json::parse(slurp(folder / "state.json"));
    }
    TemporaryFolder folder;
    mutable std::string out;
    mutable int code = 0;
};

} // namespace

TEST_CASE(
    "the probe tells projected and geographic coordinates, and the CRS is told after a bake and of what is open") {
    const Plane plane;
    const json baked = plane.after({"bake plane.asc plane.fjell", "wait", "camera 500 900 620 0 -80",
                                    "interface probe on", "probe 0.5 0.5", "wait", "frames 2"});
    CHECK(plane.out.find("WGS 84 / UTM zone 33N (EPSG:32633)") != std::string::npos);
    CHECK(baked["scene"]["crs"] == "WGS 84 / UTM zone 33N (EPSG:32633)");
    REQUIRE(baked["probe"].contains("ground"));
    const json& g = baked["probe"]["ground"];
    const double x = g["position_m"][0], z = g["position_m"][2];
    CHECK(g["in_crs"][0].get<double>() == Approx(499500 + x).epsilon(1e-12));
    CHECK(g["in_crs"][1].get<double>() == Approx(5200500 - z).epsilon(1e-12));
    // gdaltransform has 15 E 46.9535292 N for 500000 E 5200000 N; from there by the ellipsoid's metres to a degree.
    CHECK(g["degrees"][0].get<double>() == Approx(46.9535292 + (500 - z) / 0.9996 / 111165).margin(2e-6));
    CHECK(g["degrees"][1].get<double>() == Approx(15 + (x - 500) / 0.9996 / 76100).margin(2e-6));
}

TEST_CASE("what has no CRS tells none") {
    const Plane plane;
    std::filesystem::remove(plane.folder / "plane.prj");
    const json baked = plane.after({"bake plane.asc plane.fjell", "wait", "camera 500 900 620 0 -80",
                                    "interface probe on", "probe 0.5 0.5", "wait", "frames 2"});
    CHECK(baked["scene"]["crs"] == "");
    REQUIRE(baked["probe"].contains("ground"));
    CHECK_FALSE(baked["probe"]["ground"].contains("in_crs"));
    CHECK_FALSE(baked["probe"]["ground"].contains("degrees"));
}

TEST_CASE("marks measure the distance on the map and along the ground, and the area within them") {
    const Plane plane;
    const json three = plane.after({"bake plane.asc plane.fjell", "wait", "interface probe on", "mark 100 100",
                                    "mark 500 100", "mark 500 400", "frames 2", "dump three.json", "remove-mark",
                                    "frames 2", "dump two.json", "clear-marks", "frames 2"});
    CHECK(three["probe"]["marks"].empty());
    const double steep = std::sqrt(1.25);
    const json all = json::parse(slurp(plane.folder / "three.json"))["probe"]["profile"];
    CHECK(all["length_m"].get<double>() == Approx(700));
    CHECK(all["ground_length_m"].get<double>() == Approx(400 * steep + 300).epsilon(1e-3));
    CHECK(all["area_m2"].get<double>() == Approx(60000));
    CHECK(all["ground_area_m2"].get<double>() == Approx(60000 * steep).epsilon(1e-3));
    CHECK(all["lowest_m"].get<double>() == Approx(150).margin(0.1));
    CHECK(all["highest_m"].get<double>() == Approx(350).margin(0.1));
    const json two = json::parse(slurp(plane.folder / "two.json"))["probe"]["profile"];
    CHECK(two["length_m"].get<double>() == Approx(400));
    CHECK(two["ground_length_m"].get<double>() == Approx(400 * steep).epsilon(1e-3));
    CHECK(two["area_m2"] == 0);
}

TEST_CASE("contours have the interval that was asked for, and their heights beside them") {
    const Plane plane;
    const json state =
        plane.after({"bake plane.asc plane.fjell", "wait", "camera 500 900 900 0 -45", "overlay contours on", "wait",
                     "frames 3", "dump auto.json", "contours 7", "wait", "frames 3"});
    const json automatic = json::parse(slurp(plane.folder / "auto.json"))["contours"];
    CHECK(automatic["every_m"] == 50);
    CHECK(state["contours"]["every_m"] == 7);
    REQUIRE(state["contours"]["labels"].size() >= 5);
    for (const json& label : state["contours"]["labels"])
        CHECK(std::abs(std::remainder(label[2].get<double>(), 7)) < 1e-9);
}

TEST_CASE("slopes have the colours of their legend") {
    const Plane plane; // of 26.6 degrees
    (void)plane.after({"bake plane.asc plane.fjell", "wait", "camera 500 900 620 0 -80", "overlay slope on", "wait",
                       "screenshot slope.png terrain"});
    const gl::Image image = gl::read_png(plane.folder / "slope.png");
    const std::uint8_t* const middle = image.pixel(image.width / 2, image.height / 2);
    for (std::size_t k = 0; k < 3; ++k) {
        CAPTURE(k, int{middle[k]});
        CHECK(std::abs(int{middle[k]} - int{gl::slope_rgb[1][k]}) <= 26);
    }
}

TEST_CASE("an export's size is told before it is written, and larger texels make it smaller") {
    const Plane plane;
    const json fine = plane.after({"bake plane.asc plane.fjell", "wait", "preview", "wait", "dump fine.json",
                                   "preview texel_m=100", "wait", "export coarse.glb texel_m=100", "wait"});
    const double coarse_bytes = fine["job"]["preview"]["bytes"],
                 fine_bytes = json::parse(slurp(plane.folder / "fine.json"))["job"]["preview"]["bytes"];
    const auto written = static_cast<double>(std::filesystem::file_size(plane.folder / "coarse.glb"));
    CHECK(coarse_bytes < fine_bytes);
    CHECK(coarse_bytes == Approx(written).epsilon(0.1));
    const json lean = plane.after({"open plane.fjell", "wait", "preview quantised=yes meshopt=yes texture=jpeg", "wait",
                                   "export lean.glb quantised=yes meshopt=yes texture=jpeg", "wait"});
    const std::string glb = slurp(plane.folder / "lean.glb");
    CHECK(glb.size() < fine_bytes);
    CHECK(lean["job"]["result"].get<std::string>().find("lean.glb") != std::string::npos);
    for (const std::string part : {"KHR_mesh_quantization", "EXT_meshopt_compression", "image/jpeg"})
        CHECK(glb.find(part) != std::string::npos);
    CHECK(plane.after({"open plane.fjell", "wait", "export a.glb texel_m=-1"})["job"]["kind"] == "none");
    CHECK(plane.code == 2);
}

TEST_CASE("a benchmark measures the error along its path, where bounds say the threshold everywhere") {
    const TemporaryFolder folder;
    spit(folder / "profile.toml", "[view]\nwidth_px = 320\nheight_px = 180\nsamples = 1\n[refine]\nmax_error_px = 3\n"
                                  "[light]\nair = \"simple\"\ndetail = false\ndither = false\n");
    const Run r = run_in(folder.path, no_pixels +
                                          FJELL_BIN_DIR "/fjell-editor --headless --size 480x320 --profile "
                                                        "profile.toml '" +
                                          small_pack() +
                                          "' --do 'benchmark a.csv 60' --do wait --do 'heat error' --do 'dump s.json'");
    INFO(r.err);
    REQUIRE(r.code == 0);
    const json run = json::parse(slurp(folder / "s.json"))["runs"]["all"][0];
    REQUIRE(run["measured_px"].size() == 59);
    double least = 1e9, most = 0;
    for (const json& px : run["measured_px"]) {
        least = std::min(least, px.get<double>());
        most = std::max(most, px.get<double>());
    }
    CHECK(least > 0);
    CHECK(most <= 3.001);
    CHECK(least < 0.97 * most); // they differ from place to place
}

TEST_CASE("auto-tuning tries other keys as well, and what it found is set in one step") {
    const TemporaryFolder folder;
    spit(folder / "profile.toml", "[view]\nwidth_px = 320\nheight_px = 180\nsamples = 1\n"
                                  "[light]\nair = \"simple\"\ndetail = false\ndither = false\n");
    const Run r = run_in(folder.path,
                         no_pixels + FJELL_BIN_DIR "/fjell-editor --headless --size 480x320 --profile profile.toml '" +
                             small_pack() +
                             "' --do 'tune budget_us=1000000 frames=20 least_px=8 also=yes' --do wait "
                             "--do 'dump found.json' --do use-tuned --do 'frames 2' --do 'dump set.json'");
    INFO(r.err);
    REQUIRE(r.code == 0);
    const json found = json::parse(slurp(folder / "found.json")), set = json::parse(slurp(folder / "set.json"));
    CHECK(found["job"]["best_px"] == 8);
    CHECK(found["job"]["tuned_keys"]["refine.morph"] == 1); // a second has room for it
    CHECK(found["document"]["undo"] == 0);
    CHECK(set["document"]["undo"] == 1);
    CHECK(set["profile"]["refine.max_error_px"] == 8);
    CHECK(set["profile"]["refine.morph"] == "error");
    for (const char* key : {"refine.hysteresis", "refine.offscreen_factor"})
        if (found["job"]["tuned_keys"].contains(key)) CHECK(set["profile"][key] == found["job"]["tuned_keys"][key]);
}
