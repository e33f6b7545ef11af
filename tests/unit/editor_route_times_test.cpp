// The editor's camera path when its points have times: no edit loses them or breaks their order, and files keep them.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "editor/route.h"
#include "fjell/io/failure.h"
#include "flight/path_timing.h"
#include "support/ground.h"
#include "support/program.h"
#include "support/rounds.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::editor;
using namespace fjell::test;
using flight::ControlPoint;
using flight::Pose;

namespace {

Pose pose_there(Random& random, int i) {
    const double heading = 0.2 * i + uniform(random, -0.1, 0.1);
    return {{300.0 * i + uniform(random, 0, 100), uniform(random, 500, 900), uniform(random, 0, 7000)},
            {std::sin(heading), 0, -std::cos(heading)},
            {0, 1, 0}};
}

// A file of that many points with times up to a minute.
std::string timed_file(Random& random, const std::string& file, int count, const char* units = "metres") {
    const bool metres = std::string(units) == "metres";
    std::string list;
    double time_s = 0;
    for (int i = 0; i < count; ++i) {
        const Pose p = pose_there(random, i);
        const double x = metres ? p.position_m.x : 0.1 + 0.8 * i / count, z = metres ? p.position_m.z : 0.5;
        list += fmt::format(R"({}{{"time_s": {}, "position": [{}, {}, {}], "direction": [{}, {}, {}]}})",
                            i > 0 ? ",\n" : "", time_s, x, metres ? p.position_m.y : 0.02, z, p.direction.x,
                            p.direction.y, p.direction.z);
        time_s += uniform(random, 0.5, 6);
    }
    spit(file, fmt::format(R"({{"units": "{}", "points": [{}]}})", units, list));
    return file;
}

// Positions when the flight passes its points, by the poses that are played.
void check_passes(const Route& route) {
    double step_m = 0;
    for (std::size_t i = 1; i < route.poses().size(); ++i)
        step_m = std::max(step_m, length(route.poses()[i].position_m - route.poses()[i - 1].position_m));
    for (std::size_t i = 0; i < route.points().size(); ++i) {
        const double at = route.share_of(i) * static_cast<double>(route.poses().size() - 1);
        const ControlPoint& p = route.points()[i];
        const Pose& pose = route.poses()[static_cast<std::size_t>(std::lround(at))];
        CHECK(length(pose.position_m - Vec3{p[0], p[1], p[2]}) <= step_m);
        if (!route.times_s().empty())
            CHECK(route.share_of(i) == Approx(route.times_s()[i] / route.times_s().back()).margin(1e-12));
    }
}

} // namespace

TEST_CASE("points with times keep them through opening, playing and saving, to the last bit") {
    const TemporaryFolder folder;
    for (int seed = 0; seed < rounds(10, 200); ++seed) {
        INFO("seed " << seed);
        Random random(static_cast<unsigned>(seed));
        Route route;
        route.open(timed_file(random, folder / "a.json", pick(random, 2, 15)), plain());
        const auto read = std::get<flight::SplinePath>(flight::read_path(folder / "a.json").kind);
        CHECK(route.times_s() == read.times_s);
        CHECK(route.requested_seconds() == read.times_s.back());
        check_passes(route);
        route.save(folder / "b.json");
        CHECK(slurp(folder / "b.json").find("\"seconds\"") == std::string::npos);
        route.replace(0, pose_there(random, 0), plain());
        CHECK(route.times_s() == read.times_s);
        check_passes(route);
        route.save(folder / "c.json");
        for (const char* name : {"b.json", "c.json"})
            CHECK(std::get<flight::SplinePath>(flight::read_path(folder / name).kind).times_s == read.times_s);
    }
}

TEST_CASE("edits give times to new points, take those of removed ones, and restore them") {
    const TemporaryFolder folder;
    for (int seed = 0; seed < rounds(10, 200); ++seed) {
        INFO("seed " << seed);
        Random random(static_cast<unsigned>(seed));
        Route route;
        route.open(timed_file(random, folder / "a.json", pick(random, 3, 8)), plain());
        std::vector<double> model = route.times_s();
        for (int edit = 0; edit < 12; ++edit) {
            const std::vector<double> before = model;
            const auto n = static_cast<int>(model.size());
            const auto at = static_cast<std::size_t>(pick(random, 0, n - 1));
            const auto place = [&](std::size_t i) { return model.begin() + static_cast<std::ptrdiff_t>(i); };
            switch (pick(random, 0, 3)) {
            case 0:
                (void)route.select(at);
                route.add(pose_there(random, 30 + edit), plain());
                if (at + 1 < model.size())
                    model.insert(place(at + 1), (model[at] + model[at + 1]) / 2);
                else
                    model.push_back(model[at] + (model[at] - model[at - 1]));
                break;
            case 1:
                if (n <= 3) continue;
                route.remove(at, plain());
                model.erase(place(at));
                if (at == 0)
                    for (double& time_s : model) time_s -= before[1];
                break;
            case 2: route.move(at, static_cast<std::size_t>(pick(random, 0, n - 1)), plain()); break;
            default: {
                const double seconds = uniform(random, 5, 90), by = seconds / model.back();
                for (double& time_s : model) time_s *= by;
                route.set_seconds(seconds, plain());
                CHECK(route.times_s().back() == seconds);
            }
            }
            REQUIRE(route.times_s().size() == model.size());
            REQUIRE(route.points().size() == model.size());
            for (std::size_t i = 0; i < model.size(); ++i) CHECK(route.times_s()[i] == Approx(model[i]).margin(1e-9));
            CHECK_FALSE(flight::first_bad_time(route.times_s()));
            CHECK(route.requested_seconds() == route.times_s().back());
            check_passes(route);
            if (pick(random, 0, 2) != 0) continue;
            route.restore();
            CHECK(route.times_s().size() == before.size());
            model = before;
        }
        route.save(folder / "b.json");
        Route opened;
        opened.open(folder / "b.json", plain());
        CHECK(opened.times_s() == route.times_s());
        CHECK(opened.points() == route.points());
    }
}

TEST_CASE("a duration of 0 drops the times of points, and restoring brings them back") {
    const TemporaryFolder folder;
    Random random(3);
    for (const char* units : {"metres", "terrain"})
        for (const bool edited : {false, true}) {
            INFO(units << (edited ? ", edited" : ", as read"));
            Route route;
            route.open(timed_file(random, folder / "a.json", 5, units), plain());
            if (edited) route.replace(1, pose_there(random, 1), plain());
            const std::vector<double> times_s = route.times_s();
            REQUIRE(times_s.size() == route.points().size());
            route.set_seconds(0, plain());
            CHECK(route.times_s().empty());
            check_passes(route);
            route.save(folder / "b.json");
            CHECK(slurp(folder / "b.json").find("time_s") == std::string::npos);
            route.restore();
            CHECK(route.times_s() == times_s);
            check_passes(route);
        }
}

TEST_CASE("a path with times in units of the terrain keeps its pace when its first edit makes points in metres of it") {
    const TemporaryFolder folder;
    Random random(8);
    Route route;
    route.open(timed_file(random, folder / "a.json", 4, "terrain"), plain());
    const std::vector<Pose> before = route.poses();
    route.replace(0, before.front(), plain());
    CHECK_FALSE(route.as_read());
    REQUIRE(route.poses().size() == before.size());
    double worst_m = 0;
    for (std::size_t i = 0; i < before.size(); ++i)
        worst_m = std::max(worst_m, length(route.poses()[i].position_m - before[i].position_m));
    CHECK(worst_m < 0.01 * length(before.back().position_m - before.front().position_m));
}

TEST_CASE("edits that times have no room for are refused, and the path stays") {
    const TemporaryFolder folder;
    spit(folder / "a.json", R"({"points": [{"time_s": 0, "position": [0, 500, 0], "direction": [1, 0, 0]},
        {"time_s": 0.001, "position": [900, 500, 0], "direction": [1, 0, 0]},
        {"time_s": 3600, "position": [1800, 500, 0], "direction": [1, 0, 0]}]})");
    Random random(1);
    Route route;
    route.open(folder / "a.json", plain());
    const std::vector<double> times_s = route.times_s();
    (void)route.select(0);
    CHECK_THROWS_WITH(route.add(pose_there(random, 5), plain()), Catch::Contains("less than 0.001 s apart"));
    (void)route.select(2);
    CHECK_THROWS_WITH(route.add(pose_there(random, 5), plain()), Catch::Contains("longer than 3600 seconds"));
    CHECK_THROWS_AS(route.set_seconds(60, plain()), io::Failure);
    CHECK(route.times_s() == times_s);
    CHECK_FALSE(route.unsaved());
}
