// The editor's camera path: what is written is read back, and no edit loses anything.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <variant>

#include "editor/route.h"
#include "editor/scene/lines.h"
#include "fjell/glm.h"
#include "fjell/io/failure.h"
#include "support/ground.h"
#include "support/program.h"
#include "support/rounds.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::editor;
using namespace fjell::test;
using session::ControlPoint;
using session::Pose;

namespace {

Pose random_pose(Random& random) {
    const double heading = uniform(random, -3, 3), pitch = uniform(random, -1.4, 1.4),
                 roll = uniform(random, -0.8, 0.8);
    const Vec3 direction{std::sin(heading) * std::cos(pitch), std::sin(pitch), -std::cos(heading) * std::cos(pitch)};
    const Vec3 level = normalised(Vec3{0, 1, 0} - direction * direction.y);
    const Vec3 up = level * std::cos(roll) + cross(direction, level) * std::sin(roll);
    return {{uniform(random, -1e5, 1e5), uniform(random, -400, 9000), uniform(random, -1e5, 1e5)}, direction, up};
}

// Poses that turn a little from one to the next: a path through them can be held upright.
Pose gentle_pose(Random& random, int i) {
    const double heading = 0.2 * i + uniform(random, -0.1, 0.1), pitch = uniform(random, -0.4, 0.1);
    const Vec3 d{std::sin(heading) * std::cos(pitch), std::sin(pitch), -std::cos(heading) * std::cos(pitch)};
    return {{300.0 * i + uniform(random, 0, 100), uniform(random, 500, 900), uniform(random, 0, 7000)},
            d,
            normalised(Vec3{0, 1, 0} - d * d.y)};
}

ControlPoint point_of(const Pose& p) {
    return session::unit_point({p.position_m.x, p.position_m.y, p.position_m.z, p.direction.x, p.direction.y,
                                p.direction.z, p.up.x, p.up.y, p.up.z});
}

std::vector<ControlPoint> lay(Random& random, Route& route, int count) {
    std::vector<ControlPoint> points;
    for (int i = 0; i < count; ++i) {
        const Pose pose = gentle_pose(random, i);
        route.add(pose, plain());
        points.push_back(point_of(pose));
    }
    return points;
}

std::vector<ControlPoint> points_in(const session::CameraPath& path) {
    std::vector<ControlPoint> points;
    const auto& spline = std::get<session::SplinePath>(path.kind).spline;
    for (const double knot : spline.knots()) points.push_back(spline.at(knot));
    return points;
}

} // namespace

TEST_CASE("a path's text reads back to the last bit") {
    for (unsigned seed = 0; seed < 200; ++seed) {
        Random random(seed);
        INFO("seed " << seed);
        std::vector<ControlPoint> points;
        for (int i = pick(random, 2, 30); i > 0; --i) points.push_back(point_of(random_pose(random)));
        session::CameraPath path;
        path.name = "laid";
        path.seconds = pick(random, 0, 1) == 1 ? uniform(random, 0.001, 3600) : 0;
        std::vector<double> knots = session::chord_knots(points, path.name);
        path.kind = session::SplinePath{session::CubicSpline<9>(knots, points)};
        const std::string text = session::path_text(path);
        const session::CameraPath back = session::parse_path(text, "back");
        CHECK(points_in(back) == points);
        CHECK(back.seconds == path.seconds);
        CHECK(back.units == session::Units::metres);
        CHECK(session::path_text(back) == text);
    }
}

TEST_CASE("orbits and lines keep their text too, and recorded frames have none") {
    for (const char* text :
         {R"({"units": "terrain", "orbit": {"radius": 0.3, "turns": -2.5}})",
          R"({"orbit": {"centre": [100, 200], "radius": 1000, "height": 400}})",
          R"({"units": "terrain", "seconds": 12, "straight": {"from": [0, 0.1, 0.5], "to": [1, 0.1, 0.5],
              "cells_per_frame": 1.5, "pitch_deg": -10}})"}) {
        const session::CameraPath path = session::parse_path(text, "p");
        const std::string written = session::path_text(path);
        const session::CameraPath back = session::parse_path(written, "back");
        CHECK(session::path_text(back) == written);
        CHECK(back.units == path.units);
        CHECK(back.seconds == path.seconds);
        const auto a = session::resample(path, plain(), 50), b = session::resample(back, plain(), 50);
        for (std::size_t i = 0; i < a.size(); ++i) CHECK(length(a[i].position_m - b[i].position_m) == 0);
    }
    const session::CameraPath recorded =
        session::parse_path("F 0 1 0 0 0 1 0 0 0 1 0.1 0.2 0.3 1\nF 0 1 0 0 0 1 0 0 0 1 0.2 0.2 0.3 1\n", "r");
    CHECK_THROWS_AS(session::path_text(recorded), io::Failure);
}

TEST_CASE("a path that is laid, saved and opened is the same path") {
    const TemporaryFolder folder;
    for (unsigned seed = 0; seed < rounds<unsigned>(5, 20); ++seed) {
        Random random(seed);
        INFO("seed " << seed);
        Route route, opened;
        const std::vector<ControlPoint> points = lay(random, route, pick(random, 2, 25));
        if (seed % 2 == 0) route.set_seconds(uniform(random, 1, 40), plain());
        CHECK(route.points() == points);
        CHECK(route.unsaved());
        route.save(folder / "p.json");
        CHECK_FALSE(route.unsaved());
        opened.open(folder / "p.json", plain());
        CHECK(opened.points() == points);
        CHECK_FALSE(opened.unsaved());
        if (seed % 2 != 0) continue;
        REQUIRE(opened.poses().size() == route.poses().size());
        for (std::size_t i = 0; i < route.poses().size(); ++i)
            CHECK(length(opened.poses()[i].position_m - route.poses()[i].position_m) == 0);
    }
}

TEST_CASE("a flight is called after the file of its path, the path before it is saved, and an orbit without one") {
    const TemporaryFolder folder;
    Random random(1);
    Route route;
    CHECK(std::string(route.flight_name().text) == "an orbit");
    (void)lay(random, route, 4);
    CHECK(std::string(route.flight_name().text) == "the camera path");
    route.save(folder / "valley.json");
    CHECK(std::string(route.flight_name().text) == "the path valley.json");
    route.clear();
    CHECK(std::string(route.flight_name().text) == "an orbit");
    route.open(folder / "valley.json", plain());
    CHECK(std::string(route.flight_name().text) == "the path valley.json");
}

TEST_CASE("a path passes through all of its points, as long as it was asked to") {
    for (unsigned seed = 0; seed < rounds<unsigned>(5, 20); ++seed) {
        Random random(seed);
        Route route;
        const std::vector<ControlPoint> points = lay(random, route, pick(random, 2, 12));
        const double seconds = uniform(random, 5, 60);
        route.set_seconds(seconds, plain());
        INFO("seed " << seed);
        CHECK(std::abs(route.seconds() - seconds) <= 0.5 / poses_a_second + 1e-9);
        double step_m = 0; // the camera is between two poses when it passes a point
        for (std::size_t i = 1; i < route.poses().size(); ++i)
            step_m = std::max(step_m, length(route.poses()[i].position_m - route.poses()[i - 1].position_m));
        for (const ControlPoint& p : points) {
            double nearest = 1e9;
            for (const Pose& pose : route.poses())
                nearest = std::min(nearest, length(pose.position_m - Vec3{p[0], p[1], p[2]}));
            CHECK(nearest <= step_m);
        }
    }
}

TEST_CASE("playing goes through the path once in its seconds, and begins again or stops") {
    Random random(7);
    Route route;
    (void)lay(random, route, 5);
    route.set_seconds(10, plain());
    route.play(true);
    for (int i = 0; i < 300; ++i) REQUIRE(route.advance(1.0 / 60));
    CHECK(route.share() == Approx(0.5).margin(1e-9));
    route.play(false);
    CHECK_FALSE(route.advance(1.0 / 60));
    CHECK(route.share() == Approx(0.5).margin(1e-9));
    route.play(true);
    for (int i = 0; i < 330; ++i) REQUIRE(route.advance(1.0 / 60));
    CHECK(route.share() == Approx(0.05).margin(1e-9)); // once round
    route.loop(false);
    for (int i = 0; i < 600 && route.playing(); ++i) (void)route.advance(1.0 / 60);
    CHECK_FALSE(route.playing());
    CHECK(route.share() == 1);
    CHECK(length(route.pose().position_m - route.poses().back().position_m) == 0);
    route.play(true); // from the beginning
    CHECK(route.share() == 0);
}

TEST_CASE("a recording keeps near the flight and takes its time") {
    Random random(11);
    Route route;
    const auto at = [](double s) { // a wave over the plain, 20 seconds long
        const Vec3 position{400 * s, 600 + 100 * std::sin(s / 3), 3000 + 800 * std::sin(s / 4)};
        const Vec3 d = normalised(Vec3{400, 0, 200 * std::cos(s / 4)});
        return Pose{position, d, {0, 1, 0}};
    };
    route.record(true, at(0), plain());
    for (int i = 1; i <= 1200; ++i) REQUIRE(route.follow(at(i / 60.0), 1.0 / 60));
    CHECK(route.empty()); // until it ends
    route.record(false, at(20), plain());
    CHECK(route.points().size() > 50);
    CHECK(route.seconds() == Approx(20).margin(0.1));
    CHECK(route.unsaved());
    double worst = 0;
    for (const Pose& pose : route.poses()) {
        const Pose flown = at(pose.position_m.x / 400);
        worst = std::max(worst, length(flown.position_m - pose.position_m));
    }
    CHECK(worst < 60); // points are two cells apart at least, 60 m
}

TEST_CASE("a recording of a camera that stood still is refused, and the path before it stays") {
    Random random(3);
    Route route;
    const std::vector<ControlPoint> points = lay(random, route, 4);
    const Pose still = gentle_pose(random, 1);
    route.record(true, still, plain());
    for (int i = 0; i < 100; ++i) (void)route.follow(still, 1.0 / 60);
    CHECK_THROWS_AS(route.record(false, still, plain()), io::Failure);
    CHECK_FALSE(route.recording());
    CHECK(route.points() == points);
}

TEST_CASE("a recording ends itself when it is full") {
    Route route;
    const auto at = [](int i) { return Pose{{100.0 * i, 500, 0}, {1, 0, 0}, {0, 1, 0}}; };
    route.record(true, at(0), plain());
    int i = 1;
    while (route.follow(at(i), 0.01)) ++i;
    CHECK(route.recorded() == most_points);
    route.record(false, at(i), plain());
    CHECK(route.points().size() == most_points);
}

TEST_CASE("edits do to the list what they say, and restoring takes the last one back") {
    for (unsigned seed = 0; seed < rounds<unsigned>(6, 30); ++seed) {
        Random random(seed);
        INFO("seed " << seed);
        Route route;
        std::vector<ControlPoint> model = lay(random, route, pick(random, 3, 10));
        for (int edit = 0; edit < 12; ++edit) {
            const std::vector<ControlPoint> before = model;
            const auto n = static_cast<int>(model.size());
            const auto at = static_cast<std::size_t>(pick(random, 0, n - 1));
            const auto to = static_cast<std::size_t>(pick(random, 0, n - 1));
            const Pose pose = gentle_pose(random, 100 + edit);
            const auto place = [&](std::size_t i) { return model.begin() + static_cast<std::ptrdiff_t>(i); };
            switch (pick(random, 0, 3)) {
            case 0:
                (void)route.select(at);
                route.add(pose, plain());
                model.insert(place(at + 1), point_of(pose));
                CHECK(route.selected() == at + 1);
                break;
            case 1:
                route.replace(at, pose, plain());
                model[at] = point_of(pose);
                break;
            case 2:
                if (n <= 3) continue;
                route.remove(at, plain());
                model.erase(place(at));
                break;
            default: {
                const ControlPoint moved = model[at];
                route.move(at, to, plain());
                model.erase(place(at));
                model.insert(place(to), moved);
            }
            }
            CHECK(route.points() == model);
            if (pick(random, 0, 2) != 0) continue;
            route.restore();
            CHECK(route.points() == before);
            model = before;
        }
        route.clear();
        CHECK(route.points().empty());
        CHECK(route.empty());
        route.restore();
        CHECK(route.points() == model);
        CHECK(route.unsaved());
    }
}

TEST_CASE("what cannot be leaves the path as it was") {
    Random random(5);
    Route route;
    const std::vector<ControlPoint> points = lay(random, route, 4);
    CHECK_THROWS_AS(route.remove(4, plain()), io::Failure);
    CHECK_THROWS_AS(route.select(99), io::Failure);
    CHECK_THROWS_AS(route.set_seconds(0.5, plain()), io::Failure);
    CHECK_THROWS_AS(route.open("/nowhere/at all.json", plain()), io::Failure);
    CHECK_THROWS_AS(route.save(""), io::Failure);
    CHECK_THROWS_AS(route.save("/nowhere/at all.json"), io::Failure);
    const Pose last = route.select(3);
    CHECK_THROWS_AS(route.add(last, plain()), io::Failure); // the same place twice
    Pose rounded = last;                                    // as a camera has it that was put there
    rounded.position_m.x += 1e-9;
    rounded.direction = normalised(rounded.direction + rounded.up * 1e-15);
    CHECK_THROWS_WITH(route.add(rounded, plain()), Catch::Contains("move the camera first"));
    CHECK(route.points() == points);
    CHECK(route.unsaved());
}

TEST_CASE("an orbit is played and saved as it is until it is edited") {
    const TemporaryFolder folder;
    spit(folder / "o.json", R"({"units": "terrain", "orbit": {"radius": 0.2}})");
    Route route;
    route.open(folder / "o.json", plain());
    CHECK(route.as_read());
    CHECK(route.points().size() > 10);
    CHECK(route.poses().size() == session::default_frames);
    route.save(folder / "same.json");
    CHECK(std::holds_alternative<session::Orbit>(session::read_path(folder / "same.json").kind));
    const Pose on_it = route.poses()[100];
    route.replace(3, route.poses()[45], plain());
    CHECK_FALSE(route.as_read());
    CHECK(route.unsaved());
    double nearest = 1e9;
    for (const Pose& pose : route.poses()) nearest = std::min(nearest, length(pose.position_m - on_it.position_m));
    CHECK(nearest < 0.01 * plain().longer_m()); // still round there
    route.save("");
    CHECK(std::holds_alternative<session::SplinePath>(session::read_path(folder / "same.json").kind));
}

namespace {

View view_from(const Pose& pose) {
    View view;
    view.eye_m = pose.position_m;
    view.forward = pose.direction;
    view.up = pose.up;
    view.top = std::tan(0.4), view.bottom = -view.top;
    view.right = view.top * 800 / 500, view.left = -view.right;
    view.near_m = 1;
    view.far_m = 1e6;
    view.width_px = 800;
    view.height_px = 500;
    return view;
}

bool one_of(const std::vector<Vec3>& standard_folders, const Vec3& place) {
    return std::ranges::any_of(standard_folders, [&](const Vec3& p) { return length(p - place) == 0; });
}

} // namespace

TEST_CASE("a path is shown from its beginning to its end, however long, and its points are squares around where they "
          "are seen") {
    for (unsigned seed = 0; seed < rounds<unsigned>(4, 12); ++seed) {
        INFO("seed " << seed);
        Random random(seed);
        Route route;
        const int count = pick(random, 2, 40);
        const std::vector<ControlPoint> points = lay(random, route, count);
        route.set_seconds(pick(random, 1, 60), plain());
        const auto selected = static_cast<std::size_t>(pick(random, 0, count - 1));
        (void)route.select(selected);
        const View view = view_from(random_pose(random));
        std::vector<gl::Line> lines;
        lines.reserve(most_route_lines);
        add_route_lines(route, view, lines);
        const std::size_t pieces = std::min(route.poses().size() - 1, most_route_pieces);
        REQUIRE(lines.size() >= pieces);
        std::vector<Vec3> way;
        for (const Pose& pose : route.poses()) way.push_back(pose.position_m);
        CHECK(length(lines[0].from - way.front()) == 0);
        CHECK(length(lines[pieces - 1].to - way.back()) == 0);
        for (std::size_t i = 0; i < pieces; ++i) {
            CHECK(one_of(way, lines[i].from));
            if (i > 0) CHECK(length(lines[i].from - lines[i - 1].to) == 0);
        }
        // What is left are the squares of those points that lie before the eye, the selected one last and larger. One
        // that would lie over the last (16 px) is left out.
        std::size_t at = pieces, before = 0;
        std::optional<std::array<double, 2>> last;
        for (std::size_t k = 0; k <= points.size(); ++k) {
            if (k == selected) continue;
            const ControlPoint& p = points[k == points.size() ? selected : k];
            const Vec3 place{p[0], p[1], p[2]};
            const auto middle = project(view, place);
            if (!middle) continue;
            if (k < points.size()) {
                if (last && std::hypot(middle->x - (*last)[0], middle->y - (*last)[1]) < 16) continue;
                last = {middle->x, middle->y};
            }
            ++before;
            REQUIRE(lines.size() >= at + 4);
            const double side_px = k == points.size() ? 14 : 10;
            for (std::size_t i = 0; i < 4; ++i, ++at) {
                const auto from = project(view, lines[at].from), to = project(view, lines[at].to);
                REQUIRE((from && to));
                CHECK(std::hypot(to->x - from->x, to->y - from->y) == Approx(side_px).epsilon(1e-6));
                CHECK(std::hypot(from->x - middle->x, from->y - middle->y) ==
                      Approx(side_px / std::sqrt(2)).epsilon(1e-6));
            }
        }
        CHECK(lines.size() == pieces + 4 * before);
    }
}

TEST_CASE("a path of thousands of points and a recording take no more lines than there is room for") {
    Random random(7);
    Route route;
    const Pose start = gentle_pose(random, 0);
    route.record(true, start, plain());
    for (int i = 1; i < 3000; ++i) (void)route.follow(gentle_pose(random, i), 1.0 / 60);
    std::vector<gl::Line> lines;
    add_route_lines(route, view_from(start), lines);
    CHECK(lines.size() == most_route_pieces);
    CHECK(length(lines.front().from - start.position_m) == 0);
    route.record(false, gentle_pose(random, 3000), plain());
    route.record(true, start, plain());
    for (int i = 1; i < 3000; ++i) (void)route.follow(gentle_pose(random, i), 1.0 / 60);
    lines.clear();
    add_route_lines(route, view_from(start), lines);
    CHECK(lines.size() > 2 * most_route_pieces);
    CHECK(lines.size() <= most_route_lines);
}
