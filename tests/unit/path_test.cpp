#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>

#include <catch2/catch.hpp>
#include <fmt/format.h>

#include "fjell/io/failure.h"
#include "session/path.h"
#include "support/ground.h"

using namespace fjell;
using namespace fjell::session;
using fjell::test::ridges;

namespace {

Ground flat(double height_m = 0) {
    Ground g = ridges();
    g.height_m = [=](double, double) { return height_m; };
    return g;
}

std::string points(const std::string& list, const char* units = "metres") {
    return fmt::format(R"({{"units": "{}", "points": [{}]}})", units, list);
}
constexpr const char* four = R"({"position": [0, 500, 0], "direction": [1, 0, 0]},
    {"position": [900, 700, 300], "direction": [2, 0, 2], "up": [0.2, 2, 0]},
    {"position": [1000, 600, 1500], "direction": [0, -0.5, 3]},
    {"position": [-500, 900, 2500], "direction": [-1, 0, 0], "up": [0, 1, 0.3]})";

std::string path_refusal(const std::string& text) {
    try {
        (void)parse_path(text, "p.json");
    } catch (const io::Failure& failure) {
        CHECK(failure.exit_code == 1);
        CHECK(std::string(failure.what()).find('\n') == std::string::npos);
        return failure.what();
    }
    return "accepted";
}

double distance(Vec3 a, Vec3 b) {
    return length(a - b);
}

void check_orthonormal(const std::vector<Pose>& poses) {
    double worst = 0;
    for (const Pose& p : poses)
        worst = std::max(
            {worst, std::abs(length(p.direction) - 1), std::abs(length(p.up) - 1), std::abs(dot(p.direction, p.up))});
    CHECK(worst < 1e-14);
}

CubicSpline<9> spline_of(const CameraPath& path) {
    return std::get<SplinePath>(path.kind).spline;
}

} // namespace

TEST_CASE("a spline through three points is the natural cubic computed by hand") {
    // Knots 0, 1, 2 and values 0, 1, 0: the one inner equation 2 (1 + 1) m = 6 (-1 - 1) gives m = -3, so
    // s(1/2) = 1/2 + ((1/2)^3 - 1/2) (-3) / 6 = 11/16, s'(0) = 1 + 3/6 = 3/2 and s''(1/2) = -3/2.
    const CubicSpline<1> s({0, 1, 2}, {{0}, {1}, {0}});
    CHECK(s.at(0.5)[0] == Approx(11.0 / 16).epsilon(1e-14));
    CHECK(s.at(1.5)[0] == Approx(11.0 / 16).epsilon(1e-14));
    CHECK(s.at(0, 1)[0] == Approx(1.5).epsilon(1e-14));
    CHECK(s.at(0.5, 2)[0] == Approx(-1.5).epsilon(1e-14));
    CHECK(s.at(0, 2)[0] == 0);
    CHECK(s.at(2, 2)[0] == 0);
}

TEST_CASE("a spline through points on a line is the line, whatever the knots") {
    const CubicSpline<2> s({0, 0.1, 2, 2.5, 7}, {{1, 0}, {1.2, -0.1}, {5, -2}, {6, -2.5}, {15, -7}});
    double worst = 0;
    for (int i = 0; i <= 700; ++i) {
        const double t = i * 0.01;
        worst = std::max({worst, std::abs(s.at(t)[0] - (1 + 2 * t)), std::abs(s.at(t)[1] + t)});
    }
    CHECK(worst < 1e-13);
}

TEST_CASE("a path's spline passes through every control point, in all nine dimensions") {
    const CameraPath path = parse_path(points(four), "p.json");
    const CubicSpline<9> s = spline_of(path);
    REQUIRE(s.knots().size() == 4);
    const ControlPoint second = s.at(s.knots()[1]);
    const double r = std::sqrt(0.5), u = std::sqrt(4.04);
    const ControlPoint expected{900, 700, 300, r, 0, r, 0.2 / u, 2 / u, 0};
    for (std::size_t d = 0; d < 9; ++d) CHECK(second[d] == Approx(expected[d]).margin(1e-12));
    CHECK(s.at(s.knots().back())[2] == Approx(2500));
    CHECK(s.at(s.knots().front())[1] == Approx(500));
}

TEST_CASE("position, first and second derivative of a path are continuous at every control point") {
    const CubicSpline<9> s = spline_of(parse_path(points(four), "p.json"));
    constexpr double h = 1e-9; // the third derivative is at most about 1e6 here: 2 h of it stays below the tolerances
    for (const double knot : {s.knots()[1], s.knots()[2]})
        for (int derivative = 0; derivative <= 2; ++derivative) {
            const ControlPoint before = s.at(knot - h, derivative), after = s.at(knot + h, derivative);
            for (std::size_t d = 0; d < 9; ++d) CHECK(std::abs(after[d] - before[d]) < 1e-2);
        }
    // And the derivatives are those of the curve.
    for (const double t : {0.05, 0.31, 0.66, 0.93})
        for (int derivative = 0; derivative <= 1; ++derivative) {
            constexpr double e = 1e-5;
            const ControlPoint a = s.at(t - e, derivative), b = s.at(t + e, derivative),
                               slope = s.at(t, derivative + 1);
            for (std::size_t d = 0; d < 9; ++d)
                CHECK((b[d] - a[d]) / (2 * e) == Approx(slope[d]).epsilon(1e-4).margin(1e-3));
        }
}

TEST_CASE("a path is resampled to as many orthonormal frames as asked, from its first to its last control point") {
    const CameraPath path = parse_path(points(four), "p.json");
    CHECK(resample(path, ridges()).size() == 840);
    for (const std::size_t frames : {1u, 2u, 3u, 100u}) {
        const std::vector<Pose> poses = resample(path, ridges(), frames);
        REQUIRE(poses.size() == frames);
        check_orthonormal(poses);
        CHECK(distance(poses.front().position_m, {0, 500, 0}) < 1e-9);
        if (frames > 1) CHECK(distance(poses.back().position_m, {-500, 900, 2500}) < 1e-9);
    }
}

TEST_CASE("resampling finer visits the same places") {
    const CameraPath path = parse_path(points(four), "p.json");
    const std::vector<Pose> coarse = resample(path, ridges(), 11), fine = resample(path, ridges(), 101);
    for (std::size_t i = 0; i < coarse.size(); ++i)
        CHECK(distance(coarse[i].position_m, fine[10 * i].position_m) < 1e-9);
}

TEST_CASE("a camera that only turns moves on at an even pace") {
    const CameraPath path = parse_path(points(R"({"position": [5, 5, 5], "direction": [0, 0, -1]},
        {"position": [5, 5, 5], "direction": [1, 0, 0]}, {"position": [5, 5, 5], "direction": [0, 0, 1]})"),
                                       "p.json");
    const std::vector<Pose> poses = resample(path, flat(), 101);
    check_orthonormal(poses);
    CHECK(poses[50].direction.x == Approx(1));
    CHECK(distance(poses[70].position_m, {5, 5, 5}) < 1e-12);
}

TEST_CASE("in units of the terrain a path keeps its height above the ground, between control points too") {
    // From valley to valley straight over the ridges, one hundredth of 40 km above them.
    const CameraPath path = parse_path(points(R"({"position": [0.05, 0.01, 0.5], "direction": [1, 0, 0]},
        {"position": [0.95, 0.01, 0.5], "direction": [1, 0, 0]})",
                                              "terrain"),
                                       "p.json");
    const Ground ground = ridges();
    double lowest = 1e9, roughest = 0;
    const std::vector<Pose> poses = resample(path, ground);
    for (std::size_t i = 0; i < poses.size(); ++i) {
        const Vec3 p = poses[i].position_m;
        lowest = std::min(lowest, p.y - ground.height_m(p.x, p.z));
        if (i > 0 && i + 1 < poses.size())
            roughest = std::max(roughest, std::abs(poses[i - 1].position_m.y - 2 * p.y + poses[i + 1].position_m.y));
    }
    CHECK(lowest >= 400);
    CHECK(roughest < 10); // metres a frame and frame, at 43 m a frame
    CHECK(poses.front().position_m.x == Approx(2000));
    CHECK(poses.front().position_m.z == Approx(10000));
}

TEST_CASE("at height zero a path climbs a cliff before it, not through it") {
    const CameraPath path = parse_path(points(R"({"position": [0.05, 0, 0.5], "direction": [1, 0, 0]},
        {"position": [0.95, 0, 0.5], "direction": [1, 0, 0]})",
                                              "terrain"),
                                       "p.json");
    Ground cliff = flat();
    cliff.height_m = [](double x, double) { return x > 20000 && x < 20300 ? 1500.0 : 0.0; };
    double lowest = 1e9;
    for (const Pose& p : resample(path, cliff, 5000))
        lowest = std::min(lowest, p.position_m.y - cliff.height_m(p.position_m.x, p.position_m.z));
    CHECK(lowest > -1e-6);
}

TEST_CASE("an orbit keeps its distance and looks at the middle of the ground") {
    const CameraPath path =
        parse_path(R"({"units": "terrain", "orbit": {"radius": 0.25, "height": 0.1, "turns": 2}})", "p.json");
    const std::vector<Pose> poses = resample(path, flat(1000), 81);
    check_orthonormal(poses);
    for (const Pose& p : poses) {
        CHECK(distance(p.position_m, {20000, 5000, 10000}) == Approx(10000));
        const Vec3 to_centre = normalised(Vec3{20000, 1000, 10000} - p.position_m);
        CHECK(distance(to_centre, p.direction) < 1e-12);
    }
    CHECK(distance(poses[0].position_m, {20000, 5000, 20000}) < 1e-6);  // south, looking north
    CHECK(distance(poses[10].position_m, {10000, 5000, 10000}) < 1e-6); // then west: clockwise
    CHECK(distance(poses[40].position_m, poses[0].position_m) < 1e-6);
}

TEST_CASE("a straight flight goes at the asked number of cells a frame") {
    const CameraPath path = parse_path(
        R"({"straight": {"from": [0, 900, 100], "to": [300, 900, 500], "cells_per_frame": 3.3, "pitch_deg": -10}})",
        "p.json");
    const std::vector<Pose> poses = resample(path, ridges(), 50);
    check_orthonormal(poses);
    for (std::size_t i = 1; i < poses.size(); ++i)
        CHECK(distance(poses[i].position_m, poses[i - 1].position_m) == Approx(3.3 * 50));
    CHECK(poses[0].direction.y == Approx(std::sin(-10 * M_PI / 180)));
    CHECK(poses[0].direction.x / poses[0].direction.z == Approx(0.75));
    // Without a speed it ends where it says.
    const CameraPath whole = parse_path(R"({"straight": {"from": [0, 900, 100], "to": [300, 950, 500]}})", "p.json");
    CHECK(distance(resample(whole, ridges(), 7).back().position_m, {300, 950, 500}) < 1e-9);
}

TEST_CASE("recorded frames are placed by the terrain's width, from its south-west corner") {
    const std::string text = "F 0  1 0 0  0 1 0  0 0 1  0.25 0.125 0.01  0.5\nf 0 0 0\nkeys Dt\n"
                             "F 0  0 2 0  -2 0 0  0 0 2  0.50 0.250 0.01  0.5\n";
    const CameraPath path = parse_path(text, "f.frames");
    const std::vector<Pose> poses = resample(path, ridges(), 2);
    CHECK(distance(poses[0].position_m, {10000, 400, 15000}) < 1e-9);
    CHECK(distance(poses[1].position_m, {20000, 400, 10000}) < 1e-9);
    CHECK(distance(poses[0].direction, {1, 0, 0}) < 1e-12);  // their x is east
    CHECK(distance(poses[1].direction, {0, 0, -1}) < 1e-12); // their y is north
    CHECK(distance(poses[1].up, {0, 1, 0}) < 1e-12);
    CHECK(path_refusal("F 0 1 0 0\n").find("line 1: a frame is F and 14 numbers") != std::string::npos);
}

TEST_CASE("a seed's random path is the same every time, over the terrain and above the ground") {
    const Ground ground = ridges();
    for (const std::uint64_t seed : {0u, 1u, 2002u}) {
        const std::vector<Pose> once = resample(random_path(seed), ground, 200),
                                again = resample(random_path(seed), ground, 200);
        check_orthonormal(once);
        for (std::size_t i = 0; i < once.size(); ++i) {
            const Vec3 p = once[i].position_m;
            CHECK(distance(p, again[i].position_m) == 0);
            CHECK(p.y > ground.height_m(p.x, p.z));
            CHECK((p.x > -0.1 * ground.extent_x_m && p.x < 1.1 * ground.extent_x_m));
        }
    }
    CHECK(distance(resample(random_path(1), ground, 2)[0].position_m,
                   resample(random_path(2), ground, 2)[0].position_m) > 1);
}

TEST_CASE("a bad path is refused in one line that names the place") {
    const auto says = [](const std::string& text, const std::string& part) {
        const std::string line = path_refusal(text);
        INFO(line);
        CHECK(line.starts_with("p.json:")); // and the line, where a parser counts them
        CHECK(line.find(part) != std::string::npos);
    };
    const std::string good = R"({"position": [0, 0, 0], "direction": [1, 0, 0]})";
    says("", "not JSON");
    says("{\"points\": [", "not JSON");
    says("[1, 2]", "must be an object");
    says("{\n\"units\": \"metres\",\n\"units\": \"terrain\"}", "p.json:3: \"units\" is there twice");
    says("{}", "exactly one of points, orbit and straight");
    says(R"({"points": [], "orbit": {}})", "exactly one");
    says(points(""), "a control point");
    says(points(good + "," + good + "," + good), "points[1] repeats");
    says(points(good, "feet"), "units: must be \"metres\" or \"terrain\"");
    says(points(good + R"(, {"direction": [1, 0, 0]})"), "points[1].position: is missing");
    says(points(good + R"(, {"position": [1, 2], "direction": [1, 0, 0]})"), "points[1].position: must be 3 numbers");
    says(points(good + R"(, {"position": [1, 2, "3"], "direction": [1, 0, 0]})"),
         "points[1].position: must be 3 numbers");
    says(points(good + R"(, {"position": [1, 2, NaN], "direction": [1, 0, 0]})"), "not JSON");
    says(points(good + R"(, {"position": [1, 2, 1e999], "direction": [1, 0, 0]})"), "too large");
    says(points(good + R"(, {"position": [1, 2, 1e9], "direction": [1, 0, 0]})"), "within 1e8");
    says(points(good + R"(, {"position": [1, 2, 3], "direction": [0, 0, 0]})"), "points[1].direction: is zero");
    says(points(good + R"(, {"position": [1, 2, 3], "direction": [0, 3, 0]})"),
         "points[1].up: is parallel to direction");
    says(points(good + R"(, {"position": [1, 2, 3], "direction": [1, 0, 0], "up": [0, 0, 0]})"),
         "points[1].up: is zero");
    says(points(good + R"(, {"position": [1, 2, 3], "direction": [1, 0, 0], "roll": 3})"),
         "points[1].roll: unknown key");
    // Of version 0.2: closed, timed and aimed paths.
    says(R"({"closed": true, "points": [)" + good + "]}", "closed: is not read any more");
    says(R"({"ease": true, "orbit": {}, "units": "terrain"})", "ease: is not read any more");
    says(points(good + R"(, {"time_s": 3, "position": [1, 2, 3], "direction": [1, 0, 0]})"),
         "points[1].time_s: is not read any more");
    says(points(good + R"(, {"position": [1, 2, 3], "direction": [1, 0, 0], "look_at": [0, 0, 0]})"),
         "points[1].look_at: is not read any more");
    says(R"({"orbit": {"radius": 3}})", "orbit.centre: is missing");
    says(R"({"units": "terrain", "orbit": {"radius": -3}})", "orbit.radius: must be from");
    says(R"({"straight": {"from": [0, 0, 0], "to": [0, 5, 0]}})", "straight.to: must lie");
    CHECK_THROWS_WITH(read_path("/nowhere/p.json"),
                      Catch::Contains("/nowhere/p.json") && Catch::Contains("No such file"));
}

TEST_CASE("a path of one point, or of two equal ones, is a camera that stands still to the last bit") {
    const std::string point = R"({"position": [1e5, 0.1, 3e5], "direction": [0.3, -0.2, 0.7]})";
    for (const std::string& text : {point, point + "," + point}) {
        const CameraPath path = parse_path(points(text), "p.json");
        const std::vector<Pose> poses = resample(path, flat(), 7),
                                again = resample(parse_path(path_text(path), "p.json"), flat(), 7);
        REQUIRE(poses.size() == 7);
        check_orthonormal(poses);
        for (std::size_t i = 0; i < poses.size(); ++i) {
            CHECK(distance(poses[i].position_m, {1e5, 0.1, 3e5}) == 0);
            CHECK(distance(poses[i].direction, poses[0].direction) == 0);
            CHECK(distance(again[i].position_m, poses[i].position_m) == 0);
        }
    }
}

TEST_CASE("directions that cancel between two control points are refused, not divided by") {
    const CameraPath path = parse_path(points(R"({"position": [0, 0, 0], "direction": [1, 0, 0]},
        {"position": [10, 0, 0], "direction": [-1, 0, 0]})"),
                                       "p.json");
    CHECK_THROWS_WITH(resample(path, flat(), 3),
                      "p.json: frame 1: the direction vanishes between two points; add a point between them");
}

TEST_CASE("every shipped path flies over any ground without diving into it") {
    for (const char* name : {"flythrough", "earth", "orbit", "straight", "gallery-asia", "gallery-canyon",
                             "gallery-craterlake", "gallery-jotunheimen", "gallery-rainier", "gallery-spain"}) {
        const CameraPath path = read_path(fmt::format("{}/content/paths/{}.json", FJELL_SOURCE_DIR, name));
        const Ground ground = ridges();
        double lowest = 1e9;
        const std::vector<Pose> poses = resample(path, ground);
        check_orthonormal(poses);
        for (const Pose& p : poses)
            lowest = std::min(lowest, p.position_m.y - ground.height_m(p.position_m.x, p.position_m.z));
        INFO(name);
        CHECK(lowest > 0);
    }
    check_orthonormal(resample(read_path(std::string(FJELL_SOURCE_DIR) + "/content/paths/canyon.json"), flat()));
}
