// What hands and commands do to the editor's camera path beside its list of points: times, speeds, targets, closing,
// and every step of it back and forward.
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
    std::vector<double> times_s;
    std::size_t poses = 0, targets = 0;
    double seconds = 0;
    bool closed = false, eases = false;
    friend bool operator==(const Snapshot&, const Snapshot&) = default;
};
Snapshot snapshot(const Route& r) {
    const auto targets = std::ranges::count_if(r.targets(), [](const auto& target) { return target.has_value(); });
    return {r.points(), r.times_s(), r.poses().size(), static_cast<std::size_t>(targets), r.requested_seconds(),
            r.closed(), r.eases()};
}

// What holds of every path, whatever was done to it.
void check_sound(const Route& route) {
    const std::size_t n = route.points().size();
    CHECK((route.times_s().empty() || route.times_s().size() == n));
    CHECK((route.targets().empty() || route.targets().size() == n));
    CHECK_FALSE(flight::first_bad_time(route.times_s()));
    if (route.selected()) CHECK(*route.selected() < n);
    for (std::size_t i = 0; i < route.targets().size(); ++i) {
        if (!route.targets()[i]) continue;
        const ControlPoint& p = route.points()[i];
        CHECK(length(Vec3{p[3], p[4], p[5]} - normalised(*route.targets()[i] - position(p))) < 1e-12);
    }
    if (!route.closed()) return;
    CHECK(n >= 3);
    CHECK(route.points().front() == route.points().back());
    if (!route.targets().empty()) CHECK(route.targets().front().has_value() == route.targets().back().has_value());
}

// Anything that can be done, now and then what cannot.
void edit_somehow(Random& random, Route& route, int number) {
    const auto n = static_cast<int>(route.points().size());
    const auto any = [&] { return static_cast<std::size_t>(pick(random, 0, std::max(n - 1, 0))); };
    const std::size_t at = any(), other = any();
    // Near each other: a path without a duration takes as long as its way, which is what the tests' time goes to.
    const double x = uniform(random, 3500, 5500), z = uniform(random, 2500, 4500), y = uniform(random, 100, 900);
    switch (pick(random, 0, 13)) {
    case 0:
        (void)route.select(at);
        route.add(level_pose(x, z, 0.1 * number), plain());
        break;
    case 1: route.insert(uniform(random, 0, 1), plain()); break;
    case 2: route.replace(at, level_pose(x, z, 0.1 * number), plain()); break;
    case 3: route.remove(at, plain()); break;
    case 4: route.move(at, other, plain()); break;
    case 5: {
        const Route::Range range = route.time_range(at);
        route.set_time(at, uniform(random, range.least, std::min(range.most, 12.0)), false, plain());
        break;
    }
    case 6: route.set_mean_speed(at, uniform(random, 250, 4000), false, plain()); break;
    case 7: route.set_pace(pick(random, 0, 1) == 0 ? Pace::constant : Pace::ease, plain()); break;
    case 8: route.place(at, x, z, false, plain()); break;
    case 9: route.place(at, x, z, false, plain(), y); break;
    case 10: route.aim(x, z, plain(), std::min(at, other), std::max(at, other)); break;
    case 11: route.free(plain(), std::min(at, other), std::max(at, other)); break;
    case 12: route.close(!route.closed(), plain()); break;
    default: route.set_seconds(pick(random, 0, 3) == 0 ? 0 : uniform(random, 1, 18), plain());
    }
}

} // namespace

TEST_CASE("a point's time changes between its neighbours' and nothing else does, and the last one's is the duration") {
    for (int seed = 0; seed < rounds(20, 400); ++seed) {
        INFO("seed " << seed);
        Random random(static_cast<unsigned>(seed));
        Route route = line_of(random, pick(random, 3, 8));
        route.set_seconds(8, plain());
        const std::size_t n = route.points().size(), last = n - 1;
        const std::vector<ControlPoint> points = route.points();
        for (int edit = 0; edit < 6; ++edit) {
            const auto at = static_cast<std::size_t>(pick(random, 1, static_cast<int>(last)));
            std::vector<double> model;
            for (std::size_t i = 0; i < n; ++i) model.push_back(route.time_of(i));
            const Route::Range range = route.time_range(at);
            CHECK(range.least >= model[at - 1]);
            if (at < last) CHECK(range.most <= model[at + 1]);
            model[at] = uniform(random, range.least, std::min(range.most, 16.0));
            route.set_time(at, model[at], false, plain());
            REQUIRE(route.times_s().size() == n);
            for (std::size_t i = 0; i < n; ++i) CHECK(route.times_s()[i] == Approx(model[i]).margin(1e-9));
            CHECK(route.times_s()[at] == model[at]);
            CHECK(route.requested_seconds() == route.times_s().back());
            CHECK(route.points() == points);
            CHECK(route.selected() == at);
            const double beyond = at < last ? route.time_of(at + 1) : 3601;
            CHECK_THROWS_WITH(route.set_time(at, beyond, false, plain()), Catch::Contains("between its neighbours"));
            CHECK_THROWS_AS(route.set_time(at, route.time_of(at - 1), false, plain()), io::Failure);
        }
        CHECK_THROWS_WITH(route.set_time(0, 1, false, plain()), Catch::Contains("the first point's time is 0"));
        CHECK_THROWS_AS(route.set_time(n, 1, false, plain()), io::Failure);
    }
}

TEST_CASE("a path that gets times by an edit that changes none is flown as before") {
    Random random(3);
    Route route = line_of(random, 6);
    const std::vector<Pose> before = route.poses();
    const double seconds = route.seconds();
    route.set_time(3, route.time_of(3), false, plain());
    REQUIRE(route.poses().size() == before.size());
    // Even before by the spline's knots, which are chords; now by times between which the way is a cubic. On a line
    // both differ by how unevenly the spline runs through uneven points: a part of a stretch.
    double worst_m = 0;
    for (std::size_t i = 0; i < before.size(); ++i)
        worst_m = std::max(worst_m, length(route.poses()[i].position_m - before[i].position_m));
    CHECK(worst_m < 0.02 * length(before.back().position_m - before.front().position_m));
    CHECK(route.times_s().back() == Approx(seconds));
}

TEST_CASE("a stretch flies at the mean speed that it is given; points before it keep their times, those after follow") {
    for (int seed = 0; seed < rounds(20, 400); ++seed) {
        INFO("seed " << seed);
        Random random(static_cast<unsigned>(seed));
        Route route = line_of(random, pick(random, 3, 8));
        route.set_seconds(60, plain());
        const auto at = static_cast<std::size_t>(pick(random, 0, static_cast<int>(route.points().size()) - 2));
        std::vector<double> before;
        for (std::size_t i = 0; i < route.points().size(); ++i) before.push_back(route.time_of(i));
        const double m_s = uniform(random, 20, 400);
        route.set_mean_speed(at, m_s, false, plain());
        const double way_m = route.points()[at + 1][0] - route.points()[at][0];
        const std::vector<double>& after = route.times_s();
        CHECK(way_m / (after[at + 1] - after[at]) == Approx(m_s).epsilon(2e-3)); // a pose's share of a stretch
        for (std::size_t i = 0; i < after.size(); ++i)
            CHECK(after[i] - before[i] == Approx(i <= at ? 0 : after[at + 1] - before[at + 1]).margin(1e-9));
        CHECK_THROWS_AS(route.set_mean_speed(at, 0, false, plain()), io::Failure);
        CHECK_THROWS_WITH(route.set_mean_speed(after.size() - 1, 50, false, plain()),
                          Catch::Contains("no stretch begins"));
        CHECK_THROWS_WITH(route.set_mean_speed(at, 0.001, false, plain()), Catch::Contains("longer than 3600 seconds"));
    }
}

TEST_CASE("a constant pace flies every stretch as fast, an easing one from rest to rest, both in the same duration") {
    for (int seed = 0; seed < rounds(10, 200); ++seed) {
        INFO("seed " << seed);
        Random random(static_cast<unsigned>(seed));
        Route route = line_of(random, pick(random, 2, 8));
        route.set_seconds(20, plain());
        if (route.points().size() > 2) route.set_time(1, route.time_range(1).most / 2, false, plain());
        const std::vector<ControlPoint> points = route.points();
        route.set_pace(Pace::constant, plain());
        CHECK(route.times_s().back() == 20);
        CHECK_FALSE(route.eases());
        const std::vector<Pose>& poses = route.poses();
        const double whole_m = points.back()[0] - points.front()[0];
        for (std::size_t i = 0; i < poses.size(); ++i) // the way by trapezia of 64 a stretch: to a thousandth of it
            CHECK(poses[i].position_m.x ==
                  Approx(whole_m * static_cast<double>(i) / static_cast<double>(poses.size() - 1))
                      .margin(1e-3 * whole_m));
        route.set_pace(Pace::ease, plain());
        CHECK(route.times_s().back() == 20);
        CHECK(route.eases());
        CHECK(route.points() == points);
        const auto step = [&](std::size_t i) {
            return length(route.poses()[i + 1].position_m - route.poses()[i].position_m);
        };
        const std::size_t n = route.poses().size();
        const double mean_m = whole_m / static_cast<double>(n - 1);
        CHECK(step(0) < 0.02 * mean_m);
        CHECK(step(n - 2) < 0.02 * mean_m);
        for (std::size_t i = 0; i < points.size(); ++i) { // at every point the smooth step of the time
            const double f = route.times_s()[i] / 20;
            CHECK(points[i][0] - points[0][0] == Approx(whole_m * f * f * (3 - 2 * f)).margin(1e-3 * whole_m));
        }
        route.set_pace(Pace::constant, plain());
        CHECK_FALSE(route.eases());
    }
}

TEST_CASE("a point is inserted on the path, at its time, and the others stay") {
    for (int seed = 0; seed < rounds(20, 400); ++seed) {
        INFO("seed " << seed);
        Random random(static_cast<unsigned>(seed));
        Route route = ring_of(random, 6, seed % 3 == 0 ? 0 : 3);
        if (seed % 2 == 0) route.set_time(2, route.time_of(2), false, plain());
        const std::vector<ControlPoint> before = route.points();
        const auto stretch = static_cast<std::size_t>(pick(random, 0, 4)); // of which neither end is near
        const double share = std::lerp(route.share_of(stretch), route.share_of(stretch + 1), uniform(random, 0.1, 0.9)),
                     time_s = share * route.time_of(before.size() - 1);
        const Pose there = route.pose_at(share);
        route.insert(share, plain());
        const std::size_t at = route.selected().value();
        CHECK(position(route.points()[at]).x == there.position_m.x);
        CHECK(position(route.points()[at]).z == there.position_m.z);
        if (seed % 2 == 0) CHECK(route.times_s()[at] == Approx(time_s).margin(1e-9));
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
    route.set_time(1, route.time_of(1), false, plain()); // it has times
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
    const double least = before.times_s[1] + 0.5, most = before.times_s[3] - 0.5, time_s = before.times_s[2];
    const auto between = [&](double share) { return share == -1 ? time_s : least + share * (most - least); };
    drags([&](double share, bool dragging) { route.set_time(2, between(share), dragging, plain()); }, -1);
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

TEST_CASE(
    "the duration of a path whose points are all gone is a step too, and a closed path's last target goes with it") {
    Random random(7);
    Route route = ring_of(random, 3);
    while (!route.points().empty()) route.remove(0, plain());
    const std::size_t steps = route.undo_steps();
    route.set_seconds(20, plain());
    CHECK(route.undo_steps() == steps + 1);
    route.undo();
    CHECK(route.requested_seconds() == 0);

    Route closed = ring_of(random, 5);
    closed.close(true, plain());
    closed.aim(4500, 3500, plain(), 0, 0); // the first and, with it, the last
    closed.remove(0, plain());
    CHECK(closed.targets().empty());
}

TEST_CASE("a path keeps times, targets, closing and easing through a file, and steps that it overwrites are unsaved") {
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
        CHECK(opened.times_s() == route.times_s());
        CHECK(opened.closed() == route.closed());
        CHECK(opened.eases() == route.eases());
        REQUIRE(opened.targets().size() == route.targets().size());
        for (std::size_t i = 0; i < route.targets().size(); ++i) {
            REQUIRE(opened.targets()[i].has_value() == route.targets()[i].has_value());
            if (route.targets()[i]) CHECK(length(*opened.targets()[i] - *route.targets()[i]) == 0);
        }
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

TEST_CASE(
    "closing leads back to the first point, whose changes the last one follows, and opening takes that leg away") {
    Random random(11);
    Route route = ring_of(random, 5);
    route.set_time(2, route.time_of(2), false, plain());
    const Snapshot before = snapshot(route);
    route.close(true, plain());
    REQUIRE(route.points().size() == 6);
    CHECK(route.times_s()[5] > route.times_s()[4]);
    check_sound(route);
    for (const std::size_t end : {std::size_t{0}, std::size_t{5}}) {
        route.place(end, 4000 + 300 * static_cast<double>(end), 900, false, plain());
        CHECK(route.points()[0][0] == 4000 + 300 * static_cast<double>(end));
        check_sound(route);
    }
    const double seconds = route.times_s().back();
    route.remove(0, plain()); // the second is the first now, and the way round takes as long
    CHECK(route.points().size() == 5);
    CHECK(route.times_s().back() == Approx(seconds));
    check_sound(route);
    (void)route.select(4);
    route.add(level_pose(4500, 3500), plain()); // not behind the end
    CHECK(route.selected() == 4);
    check_sound(route);
    for (int i = 0; i < 3; ++i) route.undo();
    route.undo();
    route.close(false, plain());
    CHECK(route.points() == before.points);
    CHECK(route.times_s() == before.times_s);
    Route one;
    one.add(level_pose(1, 1), plain());
    CHECK_THROWS_AS(one.close(true, plain()), io::Failure);
}

TEST_CASE("a target holds wherever its points are put, also points that come into its stretch") {
    Random random(12);
    Route route = ring_of(random, 6);
    route.aim(4500, 3500, plain(), 1, 4);
    const auto looks_there = [&](double from, double to) {
        for (double share = from; share <= to; share += (to - from) / 50) {
            const Pose pose = route.pose_at(share);
            // Between two poses a direction is interpolated: a pose turns by some thousandths.
            CHECK(length(pose.direction - normalised(Vec3{4500, 0, 3500} - pose.position_m)) < 1e-4);
        }
    };
    looks_there(route.share_of(1), route.share_of(4));
    route.place(2, 7000, 6000, false, plain(), 900.0);
    looks_there(route.share_of(1), route.share_of(4));
    route.insert((route.share_of(2) + route.share_of(3)) / 2, plain());
    REQUIRE(route.targets()[3]);
    looks_there(route.share_of(1), route.share_of(5));
    (void)route.select(1);
    route.add(level_pose(6000, 2000, 1), plain());
    looks_there(route.share_of(1), route.share_of(6));
    check_sound(route);
    route.free(plain(), 3, 3);
    CHECK_FALSE(route.targets()[3]);
    route.free(plain());
    CHECK(route.targets().empty());
    CHECK_THROWS_AS(route.free(plain()), io::Failure);
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
    const flight::ProfileKey& key = *flight::find_profile_key("refine.error_px");
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
