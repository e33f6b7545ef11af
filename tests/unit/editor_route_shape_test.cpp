// What hands and commands do to the editor's camera path beside its list of points, and every step of it back and
// forward.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "editor/document.h"
#include "editor/route.h"
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

Pose level_pose(double x, double z, double heading = 0, double y = 600) {
    return {{x, y, z}, {std::sin(heading), 0, -std::cos(heading)}, {0, 1, 0}};
}

// Eastwards, unevenly far from one another, all looking north: the camera does not turn, so a way is metres alone.
Route line_of(Random& random, int count) {
    Route route;
    double x = 0;
    for (int i = 0; i < count; ++i) {
        route.add(level_pose(x, 3000), plain());
        x += uniform(random, 200, 1200);
    }
    return route;
}

// Round about the middle of the plain. seconds: its duration, or 0 for the usual one. A path is resampled in every
// step of it, sixty poses a second, so random ones that are edited often are short.
Route ring_of(Random& random, int count, double seconds = 0) {
    Route route;
    if (seconds > 0) route.set_seconds(seconds, plain());
    for (int i = 0; i < count; ++i) {
        const double angle = 6.283185307179586 * (i + uniform(random, -0.2, 0.2)) / count;
        route.add(level_pose(4500 + 2000 * std::cos(angle), 3500 + 2000 * std::sin(angle), angle), plain());
    }
    return route;
}

Vec3 position(const ControlPoint& p) {
    return {p[0], p[1], p[2]};
}

struct Snapshot {
    std::vector<ControlPoint> points;
    std::size_t poses = 0;
    double seconds = 0;
    friend bool operator==(const Snapshot&, const Snapshot&) = default;
};
Snapshot snapshot(const Route& r) {
    return {r.points(), r.poses().size(), r.requested_seconds()};
}

// What holds of every path, whatever was done to it.
void check_sound(const Route& route) {
    if (route.selected()) CHECK(*route.selected() < route.points().size());
}

// Anything that can be done, now and then what cannot.
void edit_somehow(Random& random, Route& route, int number) {
    const auto n = static_cast<int>(route.points().size());
    const auto any = [&] { return static_cast<std::size_t>(pick(random, 0, std::max(n - 1, 0))); };
    const std::size_t at = any(), other = any();
    // Near each other: a path without a duration takes as long as its way, which is what the tests' time goes to.
    const double x = uniform(random, 3500, 5500), z = uniform(random, 2500, 4500), y = uniform(random, 100, 900);
    switch (pick(random, 0, 7)) {
    case 0:
        (void)route.select(at);
        route.add(level_pose(x, z, 0.1 * number), plain());
        break;
    case 1: route.insert(uniform(random, 0, 1), plain()); break;
    case 2: route.replace(at, level_pose(x, z, 0.1 * number), plain()); break;
    case 3: route.remove(at, plain()); break;
    case 4: route.move(at, other, plain()); break;
    case 5: route.place(at, x, z, false, plain()); break;
    case 6: route.place(at, x, z, false, plain(), y); break;
    default: route.set_seconds(pick(random, 0, 3) == 0 ? 0 : uniform(random, 1, 18), plain());
    }
}

} // namespace

TEST_CASE("a point is inserted on the path, and the others stay") {
    for (int seed = 0; seed < rounds(20, 400); ++seed) {
        INFO("seed " << seed);
        Random random(static_cast<unsigned>(seed));
        Route route = ring_of(random, 6, seed % 3 == 0 ? 0 : 3);
        const std::vector<ControlPoint> before = route.points();
        const auto stretch = static_cast<std::size_t>(pick(random, 0, 4)); // of which neither end is near
        const double share = std::lerp(route.share_of(stretch), route.share_of(stretch + 1), uniform(random, 0.1, 0.9));
        const Pose there = route.pose_at(share);
        route.insert(share, plain());
        const std::size_t at = route.selected().value();
        CHECK(position(route.points()[at]).x == there.position_m.x);
        CHECK(position(route.points()[at]).z == there.position_m.z);
        std::vector<ControlPoint> rest = route.points();
        rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(at));
        CHECK(rest == before);
        CHECK_THROWS_WITH(route.insert(route.share_of(at), plain()), Catch::Contains("a point there already"));
    }
    Route none;
    CHECK_THROWS_AS(none.insert(0.5, plain()), io::Failure);
}

TEST_CASE("a drag is one step however often it changes something, and none when it ends where it began") {
    Random random(5);
    Route route = line_of(random, 5);
    route.set_seconds(30, plain());
    const Snapshot before = snapshot(route);
    const std::size_t steps = route.undo_steps();
    const auto drags = [&](const std::function<void(double share, bool dragging)>& move, double back) {
        for (const double share : {0.1, 0.5, 0.9}) move(share, true);
        move(0.7, false);
        CHECK(route.undo_steps() == steps + 1);
        CHECK_FALSE(snapshot(route) == before);
        route.undo();
        CHECK(snapshot(route) == before);
        CHECK(route.undo_steps() == steps);
        move(0.2, true);
        CHECK_FALSE(snapshot(route) == before);
        move(back, false);
        CHECK(snapshot(route) == before);
        CHECK(route.undo_steps() == steps);
    };
    const ControlPoint p = before.points[2];
    const auto off = [](double share) { return share == -1 ? 0 : 900 * share; };
    drags([&](double share,
              bool dragging) { route.place(2, p[0] + off(share), p[2] + off(share), dragging, plain(), p[1]); },
          -1);
}

TEST_CASE("an undo in the middle of a drag ends it: what the hand still says is not heard until it lets go") {
    Random random(6);
    Route route = line_of(random, 4);
    const Snapshot before = snapshot(route);
    route.place(1, 500, 500, true, plain());
    route.place(1, 600, 600, true, plain());
    route.undo();
    route.place(1, 700, 700, true, plain());
    CHECK(snapshot(route) == before);
    route.place(1, 800, 800, false, plain());
    CHECK(snapshot(route) == before);
    route.place(1, 900, 900, false, plain()); // another one
    CHECK(route.points()[1][0] == 900);
}

TEST_CASE("whatever is done is undone step by step and done again, and holds together at every one") {
    for (int seed = 0; seed < rounds(20, 400); ++seed) {
        INFO("seed " << seed);
        Random random(static_cast<unsigned>(seed));
        Route route = ring_of(random, pick(random, 3, 7), seed % 3 == 0 ? 0 : 3);
        const std::size_t first = route.undo_steps();
        std::vector<Snapshot> past{snapshot(route)};
        for (int edit = 0; edit < 30; ++edit) {
            const std::size_t steps = route.undo_steps();
            try {
                edit_somehow(random, route, edit);
            } catch (const io::Failure&) { // what cannot be changes nothing
                CHECK(snapshot(route) == past.back());
                CHECK(route.undo_steps() == steps);
                continue;
            }
            check_sound(route);
            if (route.undo_steps() > steps) past.push_back(snapshot(route));
        }
        REQUIRE(route.undo_steps() - first + 1 == past.size());
        for (std::size_t i = past.size() - 1; i-- > 0;) {
            const std::uint64_t stamp = route.undo_stamp();
            route.undo();
            CHECK(snapshot(route) == past[i]);
            CHECK(route.redo_stamp() == stamp);
        }
        for (std::size_t i = 1; i < past.size(); ++i) {
            route.redo();
            CHECK(snapshot(route) == past[i]);
        }
        CHECK_THROWS_AS(route.redo(), io::Failure);
        if (past.size() < 2) continue;
        route.undo();
        route.add(level_pose(10, 10), plain());
        CHECK(route.redo_steps() == 0);
    }
}

TEST_CASE("the duration of a path whose points are all gone is a step too") {
    Random random(7);
    Route route = ring_of(random, 3);
    while (!route.points().empty()) route.remove(0, plain());
    const std::size_t steps = route.undo_steps();
    route.set_seconds(20, plain());
    CHECK(route.undo_steps() == steps + 1);
    route.undo();
    CHECK(route.requested_seconds() == 0);
}

TEST_CASE("a path is kept through a file, and steps that it overwrites are unsaved") {
    const TemporaryFolder folder;
    for (int seed = 0; seed < rounds(20, 300); ++seed) {
        INFO("seed " << seed);
        Random random(static_cast<unsigned>(seed));
        Route route = ring_of(random, 5, seed % 3 == 0 ? 0 : 3);
        for (int edit = 0; edit < 12; ++edit) {
            try {
                edit_somehow(random, route, edit);
            } catch (const io::Failure&) {
            }
        }
        if (route.points().size() < 2) continue;
        route.save(folder / "a.json");
        Route opened;
        opened.open(folder / "a.json", plain());
        CHECK(opened.points() == route.points());
        CHECK(opened.requested_seconds() > 0);
        try {
            route.add(level_pose(20, 20), plain());
        } catch (const io::Failure&) { // a turn that cannot be
            continue;
        }
        route.save("");
        CHECK_FALSE(route.unsaved());
        route.undo(); // the file has another path by now
        CHECK(route.unsaved());
    }
}

TEST_CASE("a point that is put at a height keeps it over hills, and stays above the ground") {
    Route route;
    route.add(level_pose(1000, 5000, 0, 3000), ridges());
    route.add(level_pose(9000, 5000, 0, 3000), ridges());
    for (double x = 0; x <= 40000; x += 1700) {
        route.place(0, x, 4000, true, ridges(), 2500.0);
        CHECK(route.points()[0][1] == 2500);
        route.place(0, x, 4000, true, ridges(), -100.0);
        CHECK(route.points()[0][1] == Approx(ridges().height_m(x, 4000) + ridges().cell_m));
    }
}

TEST_CASE("of the steps of profile and path the later one is undone first and done again last") {
    Document document;
    Route route;
    const fjell::ProfileKey& key = *fjell::find_profile_key("refine.max_error_px");
    document.set(key, 3, false);
    route.add(level_pose(1, 1), plain());
    CHECK(route.undo_stamp() > document.undo_stamp());
    document.set(key, 4, false);
    CHECK(document.undo_stamp() > route.undo_stamp());
    document.undo();
    CHECK(route.undo_stamp() > document.undo_stamp());
    route.undo();
    CHECK(route.undo_stamp() == 0);
    CHECK(route.redo_stamp() < document.redo_stamp());
}
