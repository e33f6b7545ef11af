// Camera paths that close, ease, and look at a place: no jump where one could be, and kept in the file.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <catch2/catch.hpp>
#include <fmt/format.h>

#include "fjell/io/failure.h"
#include "flight/path.h"
#include "flight/path_timing.h"
#include "support/rounds.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::flight;
using fjell::test::pick;
using fjell::test::Random;
using fjell::test::rounds;
using fjell::test::uniform;

namespace {

ControlPoint looking_along(double x, double y, double z, double heading) {
    return unit_point({x, y, z, std::sin(heading), -0.1, -std::cos(heading), 0, 1, 0});
}

// Round about a circle, in order; the last is the first.
std::vector<ControlPoint> random_ring(Random& random, int count) {
    std::vector<ControlPoint> points;
    for (int i = 0; i < count; ++i) {
        const double angle = 2 * std::numbers::pi * (i + uniform(random, -0.3, 0.3)) / count;
        const double radius = uniform(random, 1500, 2500);
        points.push_back(looking_along(radius * std::cos(angle), uniform(random, 300, 700), radius * std::sin(angle),
                                       angle + uniform(random, -0.5, 0.5)));
    }
    points.push_back(points.front());
    return points;
}

std::vector<double> random_times(Random& random, std::size_t count) {
    std::vector<double> times_s{0};
    while (times_s.size() < count) times_s.push_back(times_s.back() + uniform(random, 1, 6));
    return times_s;
}

CameraPath path_of(std::vector<ControlPoint> points, std::vector<double> times_s, bool closed) {
    CameraPath path;
    path.name = "p.json";
    std::vector<double> knots = chord_knots(points, path.name);
    path.kind = SplinePath{CubicSpline<9>(std::move(knots), std::move(points), closed), std::move(times_s)};
    path.seconds = times_s.empty() ? 0 : times_s.back();
    return path;
}

SplinePath& spline_of(CameraPath& path) {
    return std::get<SplinePath>(path.kind);
}

// How much a step differs from the one before it: at its most within the flight, and from its end to its beginning.
// Halving a step quarters the first; a jump of the speed is only halved.
struct Unevenness {
    double within = 0, across = 0;
};
template <typename What>
Unevenness unevenness(const std::vector<Pose>& poses, const What& what) {
    Unevenness u;
    const std::size_t n = poses.size();
    for (std::size_t i = 2; i < n; ++i)
        u.within = std::max(u.within, length(what(poses[i]) - what(poses[i - 1]) * 2.0 + what(poses[i - 2])));
    u.across = length((what(poses[1]) - what(poses[0])) - (what(poses[n - 1]) - what(poses[n - 2])));
    return u;
}

Vec3 position_of(const Pose& p) {
    return p.position_m;
}
Vec3 direction_of(const Pose& p) {
    return p.direction;
}

std::string refusal(const std::string& text) {
    try {
        (void)parse_path(text, "p.json");
    } catch (const io::Failure& failure) {
        return failure.what();
    }
    return "accepted";
}

} // namespace

TEST_CASE("a closed spline passes its points, and both derivatives go on across its seam as at every knot") {
    for (int seed = 0; seed < rounds(50, 1000); ++seed) {
        INFO("seed " << seed);
        Random random(static_cast<unsigned>(seed));
        std::vector<double> knots{0};
        std::vector<std::array<double, 2>> points;
        for (int i = pick(random, 2, 12); i > 0; --i) {
            points.push_back({uniform(random, -1, 1), uniform(random, -1, 1)});
            knots.push_back(knots.back() + std::exp(uniform(random, -2, 2)));
        }
        points.push_back(points.front());
        const CubicSpline<2> s(knots, points, true);
        const std::size_t n = knots.size() - 1;
        double largest = 0; // second derivative
        for (const double knot : knots)
            for (const double m : s.at(knot, 2)) largest = std::max(largest, std::abs(m));
        for (std::size_t i = 0; i <= n; ++i) {
            CHECK(s.at(knots[i]) == points[i]);
            const double before = i == 0 ? knots[n] : knots[i], inside = i == 0 ? knots[n - 1] : knots[i - 1];
            const double after = i == n ? knots[0] : knots[i];
            for (std::size_t d = 0; d < 2; ++d) {
                // The slope at a piece's end, from its points and second derivatives; some dozens of operations round.
                const double h = before - inside;
                const double slope =
                    (s.at(before)[d] - s.at(inside)[d]) / h + h / 6 * (s.at(inside, 2)[d] + 2 * s.at(before, 2)[d]);
                CHECK(slope == Approx(s.at(after, 1)[d]).margin(1e-11 * (1 + largest * h)));
                CHECK(s.at(before, 2)[d] == Approx(s.at(after, 2)[d]).margin(1e-12 * largest));
            }
        }
    }
}

TEST_CASE("a closed path goes round without a jump in position, direction or speed, with times and without") {
    constexpr std::size_t frames = 40'001;
    for (int seed = 0; seed < rounds(6, 60); ++seed) {
        INFO("seed " << seed);
        Random random(static_cast<unsigned>(seed));
        const std::vector<ControlPoint> points = random_ring(random, pick(random, 3, 9));
        const bool timed = seed % 2 == 1;
        const std::vector<double> times_s = timed ? random_times(random, points.size()) : std::vector<double>{};
        const std::vector<Pose> poses = resample(path_of(points, times_s, true), Ground{}, frames);
        CHECK(length(poses.front().position_m - poses.back().position_m) == 0);
        CHECK(length(poses.front().direction - poses.back().direction) == 0);
        const Unevenness moving = unevenness(poses, position_of), turning = unevenness(poses, direction_of);
        CHECK(moving.across <= 1.01 * moving.within);
        CHECK(turning.across <= 1.01 * turning.within);
        // The same points without: there is a jump that this would find.
        const std::vector<Pose> open = resample(path_of(points, times_s, false), Ground{}, frames);
        const Unevenness jump = unevenness(open, position_of);
        CHECK(jump.across > 5 * jump.within);
    }
}

TEST_CASE("an eased flight between two points is the smooth step, and between more begins and ends at rest") {
    const auto along = [](double x) { return looking_along(x, 0, 0, 0); };
    CameraPath two = path_of({along(0), along(800)}, {0, 10}, false);
    spline_of(two).eases = true;
    const std::vector<Pose> poses = resample(two, Ground{}, 101);
    for (std::size_t i = 0; i < poses.size(); ++i) {
        const double f = static_cast<double>(i) / 100;
        CHECK(poses[i].position_m.x == Approx(800 * f * f * (3 - 2 * f)).margin(1e-9));
    }
    Random random(4);
    for (int round = 0; round < 10; ++round) {
        std::vector<ControlPoint> points;
        for (int i = pick(random, 3, 8); i > 0; --i)
            points.push_back(along(points.empty() ? 0 : points.back()[0] + uniform(random, 100, 900)));
        const std::vector<double> times_s = random_times(random, points.size());
        CameraPath path = path_of(points, times_s, false);
        spline_of(path).eases = true;
        const std::size_t frames = 1 + static_cast<std::size_t>(times_s.back() * 100);
        const std::vector<Pose> flown = resample(path, Ground{}, frames);
        const double step_s = times_s.back() / static_cast<double>(frames - 1);
        const std::size_t n = points.size() - 1;
        // From rest a monotone cubic gets at most 3 f^2 of its piece.
        const double first = step_s / times_s[1], last = step_s / (times_s[n] - times_s[n - 1]);
        CHECK(flown[1].position_m.x <= 3 * first * first * points[1][0]);
        CHECK(points[n][0] - flown[frames - 2].position_m.x <= 3 * last * last * (points[n][0] - points[n - 1][0]));
    }
}

TEST_CASE("the camera looks at its target all along a stretch, turns smoothly into it, and flies as without") {
    constexpr std::size_t frames = 20'001;
    for (int seed = 0; seed < rounds(6, 60); ++seed) {
        INFO("seed " << seed);
        Random random(static_cast<unsigned>(seed));
        const std::vector<ControlPoint> points = random_ring(random, 8);
        const std::vector<double> times_s = random_times(random, points.size());
        const std::vector<Pose> without = resample(path_of(points, times_s, true), Ground{}, frames);
        CameraPath path = path_of(points, times_s, true);
        const Vec3 target{uniform(random, -300, 300), 0, uniform(random, -300, 300)}, other{0, 900, 0};
        auto& targets = spline_of(path).targets;
        targets.resize(points.size());
        targets[2] = targets[3] = targets[4] = target;
        targets[5] = other;
        const std::vector<Pose> poses = resample(path, Ground{}, frames);
        for (std::size_t i = 0; i < frames; ++i) {
            const double time_s = times_s.back() * static_cast<double>(i) / (frames - 1);
            CHECK(length(poses[i].position_m - without[i].position_m) == 0);
            if (time_s >= times_s[2] && time_s <= times_s[4]) {
                const Vec3 way = normalised(target - poses[i].position_m);
                CHECK(length(poses[i].direction - way) < 1e-12);
                CHECK(std::abs(poses[i].up.x * way.z - poses[i].up.z * way.x) < 1e-12); // upright: across is level
            } else if (time_s <= times_s[1] || time_s >= times_s[6]) {
                CHECK(length(poses[i].direction - without[i].direction) < 1e-12);
            }
        }
        // A direction that jumped would be as uneven as a step is long, and one whose turning jumped nearly so.
        double step = 0;
        for (std::size_t i = 1; i < frames; ++i)
            step = std::max(step, length(poses[i].direction - poses[i - 1].direction));
        CHECK(unevenness(poses, direction_of).within < 0.05 * step);
    }
}

TEST_CASE("closing, easing and targets are written and read to the last bit") {
    Random random(9);
    for (int round = 0; round < rounds(20, 400); ++round) {
        const std::vector<ControlPoint> points = random_ring(random, 5);
        CameraPath path = path_of(points, random_times(random, points.size()), round % 2 == 0);
        path.seconds = spline_of(path).times_s.back();
        spline_of(path).eases = round % 3 == 0;
        auto& targets = spline_of(path).targets;
        targets.resize(points.size());
        targets[0] = targets[5] = Vec3{uniform(random, -900, 900), uniform(random, 0, 9), uniform(random, -900, 900)};
        const std::string text = path_text(path);
        CameraPath back = parse_path(text, "back");
        CHECK(path_text(back) == text);
        CHECK(spline_of(back).spline.closed() == (round % 2 == 0));
        CHECK(spline_of(back).eases == (round % 3 == 0));
        REQUIRE(spline_of(back).targets.size() == points.size());
        CHECK(length(*spline_of(back).targets[5] - *targets[5]) == 0);
        CHECK_FALSE(spline_of(back).targets[1]);
    }
    CameraPath plain = path_of(random_ring(random, 4), {}, false);
    for (const char* key : {"closed", "ease", "look_at"}) CHECK(path_text(plain).find(key) == std::string::npos);
}

TEST_CASE("what cannot be closed, eased or looked at is refused in a line that names it") {
    const std::string a = R"("position": [0, 5, 0], "direction": [1, 0, 0])",
                      b = R"("position": [9, 5, 0], "direction": [1, 0, 0])";
    const auto text = [](const std::string& root, const std::vector<std::string>& points) {
        std::string list;
        for (const std::string& p : points) list += (list.empty() ? "{" : ", {") + p + "}";
        return "{" + root + "\"points\": [" + list + "]}";
    };
    const auto refuses = [](const std::string& file, const std::string& line) { CHECK(refusal(file) == line); };
    refuses(text("\"closed\": true, ", {a, b, a}), "accepted");
    refuses(text("\"closed\": false, ", {a, b}), "accepted");
    refuses(text("\"closed\": 1, ", {a, b, a}), "p.json: closed: must be true or false");
    refuses(text("\"closed\": true, ", {a, a}),
            "p.json: closed: needs at least 3 points, of which the last is the first again");
    refuses(text("\"closed\": true, ", {a, b, b}),
            "p.json: points[2]: must be the first point again, because the path is closed");
    refuses(text("\"closed\": true, ", {a + R"(, "look_at": [0, 0, 0])", b, a}),
            "p.json: points[2]: must be the first point again, because the path is closed");
    refuses(text("\"ease\": true, ", {a, b}), "p.json: ease: is for points with time_s; give them times, or remove it");
    refuses(R"({"ease": true, "orbit": {}, "units": "terrain"})", "p.json: ease: is for points only; remove it");
    refuses(R"({"closed": true, "orbit": {}, "units": "terrain"})", "p.json: closed: is for points only; remove it");
    refuses(text("", {a + R"(, "look_at": [0, 5, 0])", b}),
            "p.json: points[0].look_at: is where the camera is; give another");
    refuses(text("", {a + R"(, "look_at": [0, 5])", b}), "p.json: points[0].look_at: must be 3 numbers");
    refuses(text("\"units\": \"terrain\", ", {a, b + R"(, "look_at": [0, 0, 0])"}),
            "p.json: points[1].look_at: is for units \"metres\" only; remove it, or give the path in metres");
}
