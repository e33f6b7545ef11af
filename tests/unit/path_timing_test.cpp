// Camera paths whose points have times: passed when they say, smoothly and forwards, and kept in the file.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <catch2/catch.hpp>
#include <fmt/format.h>

#include "fjell/io/failure.h"
#include "flight/path.h"
#include "flight/path_timing.h"
#include "support/ground.h"
#include "support/rounds.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::flight;
using fjell::test::pick;
using fjell::test::Random;
using fjell::test::ridges;
using fjell::test::rounds;
using fjell::test::uniform;

namespace {

constexpr int frames_a_second = 20; // of these tests: times are whole frames

// Gentle turns, legs of very different lengths and durations.
CameraPath random_timed(Random& random, Units units, bool turns = true) {
    const bool metres = units == Units::metres;
    std::vector<ControlPoint> points;
    std::vector<double> times_s;
    double x = 0, z = 0;
    int frame = 0;
    for (int i = pick(random, 2, 9); i > 0; --i) {
        const double heading = uniform(random, -0.7, 0.7), looks = turns ? heading : 0, unit = metres ? 1 : 1e-5;
        const double y = uniform(random, 100, 900), down = uniform(random, -0.4, 0.1);
        points.push_back(
            unit_point({x * unit, y * unit, z * unit, std::cos(looks), turns ? down : 0, std::sin(looks), 0, 1, 0}));
        times_s.push_back(static_cast<double>(frame) / frames_a_second);
        const double leg = std::exp(uniform(random, std::log(30.0), std::log(9000.0)));
        x += leg * std::cos(heading);
        z += leg * std::sin(heading);
        frame += pick(random, 1, 200);
    }
    CameraPath path;
    path.name = "timed";
    path.units = units;
    path.seconds = times_s.back();
    std::vector<double> knots = chord_knots(points, path.name);
    path.kind = SplinePath{CubicSpline<9>(std::move(knots), std::move(points)), std::move(times_s)};
    return path;
}

const SplinePath& timed_spline(const CameraPath& path) {
    return std::get<SplinePath>(path.kind);
}

Vec3 position_at(const SplinePath& path, double knot) {
    const ControlPoint p = path.spline.at(knot);
    return {p[0], p[1], p[2]};
}

// Points along a line, all looking along it, so that the way is the distance and nothing else.
std::string on_a_line(const std::vector<double>& x, const std::vector<std::string>& times, const char* before = "") {
    std::string list;
    for (std::size_t i = 0; i < x.size(); ++i)
        list += fmt::format("{}{{{}\"position\": [{}, 500, 0], \"direction\": [1, 0, 0]}}", i > 0 ? ", " : "",
                            times[i].empty() ? "" : "\"time_s\": " + times[i] + ", ", x[i]);
    return fmt::format("{{{}\"points\": [{}]}}", before, list);
}

std::string time_refusal(const std::string& text) {
    try {
        (void)parse_path(text, "p.json");
    } catch (const io::Failure& failure) {
        CHECK(failure.exit_code == 1);
        return failure.what();
    }
    return "accepted";
}

} // namespace

TEST_CASE("a path with times passes every point at its time, in any units, over any ground") {
    for (int seed = 0; seed < rounds(60, 2000); ++seed) {
        INFO("seed " << seed);
        Random random(static_cast<unsigned>(seed));
        const bool metres = seed % 2 == 0;
        const CameraPath path = random_timed(random, metres ? Units::metres : Units::terrain);
        const SplinePath& kind = timed_spline(path);
        const Ground ground = ridges();
        const auto frames = static_cast<std::size_t>(std::lround(path.seconds * frames_a_second)) + 1;
        const std::vector<Pose> poses = resample(path, ground, frames);
        const std::vector<double> share = shares(kind);
        REQUIRE(share.size() == kind.times_s.size());
        for (std::size_t i = 0; i < share.size(); ++i) {
            CHECK(share[i] * path.seconds == Approx(kind.times_s[i]).margin(1e-12));
            const Pose& pose = poses[static_cast<std::size_t>(std::lround(kind.times_s[i] * frames_a_second))];
            const ControlPoint p = kind.spline.at(kind.spline.knots()[i]);
            // Times up to 80 s are rounded to 1e-14 s, and nobody flies a metre in a microsecond here; places are
            // rounded to 1e-11 m.
            constexpr double near_m = 1e-7;
            CHECK(std::abs(pose.position_m.x - p[0] * (metres ? 1 : ground.extent_x_m)) < near_m);
            CHECK(std::abs(pose.position_m.z - p[2] * (metres ? 1 : ground.extent_z_m)) < near_m);
            CHECK(length(pose.direction - normalised(Vec3{p[3], p[4], p[5]})) < 1e-9);
        }
    }
}

TEST_CASE("between times a camera never flies backwards, nor faster than three times its mean speed there") {
    for (int seed = 0; seed < rounds(60, 2000); ++seed) {
        INFO("seed " << seed);
        Random random(static_cast<unsigned>(seed));
        const bool turns = seed % 2 == 0;
        const SplinePath path = timed_spline(random_timed(random, Units::metres, turns));
        const PathTiming timing(path.spline, path.times_s, {1, 1, 1});
        constexpr int steps = 300;
        for (std::size_t piece = 0; piece + 1 < path.times_s.size(); ++piece) {
            const double from_s = path.times_s[piece], seconds = path.times_s[piece + 1] - from_s;
            double knot = path.spline.knots()[piece], fastest = 0, way = 0;
            CHECK(timing.knot_at(from_s) == knot);
            bool forwards = true;
            for (int i = 1; i <= steps; ++i) {
                const double next = timing.knot_at(i == steps ? path.times_s[piece + 1] : from_s + seconds * i / steps);
                forwards = forwards && next >= knot;
                const double moved_m = length(position_at(path, next) - position_at(path, knot));
                fastest = std::max(fastest, moved_m);
                way += moved_m;
                knot = next;
            }
            CHECK(forwards);
            CHECK(knot == path.spline.knots()[piece + 1]);
            // The cubic's derivative is at most three times its mean, reached where it begins or ends; of the turning's
            // hundredth of the way it says nothing.
            if (!turns) CHECK(fastest <= 3 * way / steps);
        }
    }
}

TEST_CASE("the speed of a camera on its times is continuous, at the points and between them") {
    for (int seed = 0; seed < rounds(60, 2000); ++seed) {
        INFO("seed " << seed);
        Random random(static_cast<unsigned>(seed));
        const SplinePath path = timed_spline(random_timed(random, Units::metres));
        const PathTiming timing(path.spline, path.times_s, {1, 1, 1});
        const double last_s = path.times_s.back(), way_m = length(position_at(path, path.spline.knots().back()));
        // Speeds of `step_s` before and after; their difference goes with the step where the speed is continuous, and
        // stays where it is not.
        const auto jump_m_s = [&](double time_s, double step_s) {
            const Vec3 before = position_at(path, timing.knot_at(time_s - step_s)),
                       here = position_at(path, timing.knot_at(time_s)),
                       after = position_at(path, timing.knot_at(time_s + step_s));
            return length((after - here) - (here - before)) / step_s;
        };
        std::vector<double> times_s(path.times_s.begin() + 1, path.times_s.end() - 1);
        for (int i = 0; i < 20; ++i) times_s.push_back(uniform(random, 0.02, std::max(last_s - 0.02, 0.021)));
        for (const double time_s : times_s) {
            if (time_s > last_s - 0.01) continue;
            const double coarse = jump_m_s(time_s, 0.004), fine = jump_m_s(time_s, 0.004 / 64);
            // 64 but for higher derivatives; and a millionth of the mean speed, because places are rounded.
            CHECK(fine <= coarse / 8 + 1e-6 * way_m / last_s);
        }
    }
}

TEST_CASE("equal speeds between times are an even flight, and unequal ones the cubic computed by hand") {
    const CameraPath even = parse_path(on_a_line({0, 100, 400}, {"0", "1", "4"}), "p.json");
    const std::vector<Pose> poses = resample(even, Ground{}, 401);
    double worst_m = 0;
    for (std::size_t i = 0; i < poses.size(); ++i)
        worst_m = std::max(worst_m, std::abs(poses[i].position_m.x - static_cast<double>(i)));
    CHECK(worst_m < 1e-9);
    // 100 m in 1 s, then 300 m in 1 s: means 100 and 300, at the middle point 6 / (3 / 100 + 3 / 300) = 150, at the
    // ends (3 * 100 - 150) / 2 = 75 and (3 * 300 - 150) / 2 = 375. Halfway through the pieces 50 + (75 - 150) / 8 and
    // 100 + 150 + (150 - 375) / 8.
    const CameraPath faster = parse_path(on_a_line({0, 100, 400}, {"0", "1", "2"}), "p.json");
    const std::vector<Pose> halves = resample(faster, Ground{}, 5);
    CHECK(halves[1].position_m.x == Approx(40.625).epsilon(1e-12));
    CHECK(halves[2].position_m.x == Approx(100).epsilon(1e-12));
    CHECK(halves[3].position_m.x == Approx(221.875).epsilon(1e-12));
    CHECK(faster.seconds == 2);
}

TEST_CASE("cameras with times that only turn, stand still or reverse are where their times say") {
    const std::string turning = R"({"points": [
        {"time_s": 0, "position": [5, 5, 5], "direction": [0, 0, -1]},
        {"time_s": 1, "position": [5, 5, 5], "direction": [1, 0, 0]},
        {"time_s": 9, "position": [5, 5, 5], "direction": [0, 0, 1]}]})";
    const std::vector<Pose> turned = resample(parse_path(turning, "p.json"), Ground{}, 10);
    CHECK(length(turned[1].direction - Vec3{1, 0, 0}) < 1e-9);
    CHECK(length(turned[9].direction - Vec3{0, 0, 1}) < 1e-9);
    for (std::size_t i = 1; i < turned.size(); ++i) CHECK(length(turned[i].direction - turned[i - 1].direction) > 0.01);

    const CameraPath still = parse_path(on_a_line({7, 7}, {"0", "12"}), "p.json");
    CHECK(still.seconds == 12);
    for (const Pose& pose : resample(still, Ground{}, 5)) CHECK(pose.position_m.x == 7);

    const std::vector<Pose> there_and_back =
        resample(parse_path(on_a_line({0, 600, 0}, {"0", "2", "3"}), "p.json"), Ground{}, 31);
    CHECK(there_and_back[20].position_m.x == Approx(600));
    for (std::size_t i = 1; i < there_and_back.size(); ++i)
        CHECK((there_and_back[i].position_m.x > there_and_back[i - 1].position_m.x) == (i <= 20));
}

TEST_CASE("a path's times are written and read to the last bit, and a path without has none") {
    for (int seed = 0; seed < rounds(40, 1000); ++seed) {
        INFO("seed " << seed);
        Random random(static_cast<unsigned>(seed));
        CameraPath path = random_timed(random, seed % 2 == 0 ? Units::metres : Units::terrain);
        std::vector<double>& times_s = std::get<SplinePath>(path.kind).times_s;
        const double stretch = uniform(random, 0.5, 1.7); // to times of many digits
        for (double& time_s : times_s) time_s *= stretch;
        path.seconds = times_s.back();
        const std::string text = path_text(path);
        const CameraPath back = parse_path(text, "back");
        CHECK(timed_spline(back).times_s == times_s);
        CHECK(back.seconds == path.seconds);
        CHECK(path_text(back) == text);
        const std::vector<Pose> a = resample(path, ridges(), 40), b = resample(back, ridges(), 40);
        for (std::size_t i = 0; i < a.size(); ++i) CHECK(length(a[i].position_m - b[i].position_m) == 0);
    }
    const CameraPath without = parse_path(on_a_line({0, 1, 3}, {"", "", ""}, R"("seconds": 8, )"), "p.json");
    CHECK(timed_spline(without).times_s.empty());
    CHECK(without.seconds == 8);
    CHECK(path_text(without).find("time_s") == std::string::npos);
}

TEST_CASE("times that cannot be flown are refused in a line that names the point") {
    const auto refuses = [](const std::vector<std::string>& times, const std::string& line, const char* before = "") {
        CHECK(time_refusal(on_a_line({0, 100, 200}, times, before)) == line);
    };
    refuses({"0", "1", "2"}, "accepted");
    refuses({"0", "0.001", "3600"}, "accepted");
    refuses({"0", "1", "1.001"}, "accepted"); // whose difference is less in binary
    refuses({"0", "1", "2"}, "accepted", R"("seconds": 2, )");
    refuses({"0", "1", "2"}, "p.json: seconds: must be the last point's time_s, 2; or remove it", R"("seconds": 3, )");
    refuses({"", "1", "2"}, "p.json: points[0].time_s: is missing; give it to all points or to none");
    refuses({"0", "", "2"}, "p.json: points[1].time_s: is missing; give it to all points or to none");
    refuses({"0", "1", ""}, "p.json: points[2].time_s: is missing; give it to all points or to none");
    refuses({"0.5", "1", "2"}, "p.json: points[0].time_s: must be 0; times count from the first point");
    refuses({"0", "2", "2"},
            "p.json: points[2].time_s: must be at least 0.001 s after the point before it, which is at 2 s");
    refuses({"0", "2.5", "1"},
            "p.json: points[2].time_s: must be at least 0.001 s after the point before it, which is at 2.5 s");
    refuses({"0", "1", "3601"}, "p.json: points[2].time_s: must be from 0 to 3600");
    refuses({"0", "-1", "2"}, "p.json: points[1].time_s: must be from 0 to 3600");
    refuses({"0", "\"1\"", "2"}, "p.json: points[1].time_s: must be a number");
    CHECK(time_refusal(on_a_line({0}, {"0"})) ==
          "p.json: points[0].time_s: a single point has no time; remove it, or add a point");
}
