// Runs of benchmarks by place, points that are added to a camera path, bookmarks, and their verbs.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "editor/command.h"
#include "editor/files/settings.h"
#include "editor/route.h"
#include "editor/runs.h"
#include "fjell/io/failure.h"
#include "support/program.h"
#include "support/temporary_folder.h"

using namespace fjell;
using namespace fjell::editor;
using namespace fjell::test;

namespace {

struct Flown {
    std::vector<session::FrameEntry> frames;
    std::vector<session::Pose> poses;
};

// Frame i is at x = i. All cost 100 us at 1 px; the first, built from nothing, 1 s.
Flown flown(std::size_t count) {
    Flown f;
    for (std::size_t i = 0; i < count; ++i) {
        session::FrameEntry e;
        e.update_us = i == 0 ? 1e6 : 100;
        e.error_px_requested = e.error_bound_px = 1;
        f.frames.push_back(e);
        f.poses.push_back({{static_cast<double>(i), 0, 0}, {0, 0, -1}, {0, 1, 0}});
    }
    return f;
}

session::Ground slope() {
    session::Ground ground;
    ground.extent_x_m = ground.extent_z_m = 1000;
    ground.height_m = [](double x, double) { return 0.5 * x; };
    return ground;
}

Vec3 point_position(const session::ControlPoint& p) {
    return {p[0], p[1], p[2]};
}

Route two_points() {
    Route route;
    route.add({{100, 80, 100}, {0, 0, -1}, {0, 1, 0}}, slope());
    route.add({{500, 300, 400}, {1, 0, 0}, {0, 1, 0}}, slope());
    return route;
}

} // namespace

TEST_CASE("a run's places hold the dearest frame, the largest error and every budget of their stretch") {
    Flown f = flown(2001); // four frames to a place, or three
    f.frames[1500].update_us = 900;
    f.frames[1498].error_bound_px = 7;
    f.frames[1499].exhausted = session::exhausted_items;
    f.frames[300].update_us = 500;
    f.frames[330].update_us = 499; // near the last: the same hill
    f.frames[800].error_bound_px = 3;
    const FlownRun run = make_run(f.frames, f.poses);
    CHECK(run.frames == 2000); // without the first
    CHECK(run.max_us == 900);
    CHECK(run.p50_us == 100);
    REQUIRE(run.places.size() == most_places);
    for (std::size_t i = 1; i < run.places.size(); ++i) CHECK(run.places[i - 1].frame < run.places[i].frame);
    REQUIRE(run.worst[0].size() == worst_places);
    const FlownPlace& dearest = run.places[run.worst[0][0]];
    CHECK(dearest.frame == 1500);
    CHECK(dearest.pose.position_m.x == 1500);
    CHECK(dearest.error_px == 7);
    CHECK(dearest.exhausted == session::exhausted_items);
    CHECK(run.places[run.worst[0][1]].frame == 300);
    CHECK(run.places[run.worst[0][2]].update_us == 100); // not the one at 330
    REQUIRE(run.worst[1].size() == 2);                   // no others are beyond the threshold
    CHECK(run.places[run.worst[1][0]].error_px == 7);
    CHECK(run.places[run.worst[1][1]].error_px == 3);
    CHECK(run.place_at(0) == 0);
    CHECK(run.place_at(1) == most_places - 1);
    CHECK(run.place_at(run.share_of(run.worst[0][0])) == run.worst[0][0]);
}

TEST_CASE("a run of few frames has a place for each, and one of a single frame none") {
    const Flown f = flown(12);
    CHECK(make_run(f.frames, f.poses).places.size() == 11);
    const Flown one = flown(1);
    CHECK(make_run(one.frames, one.poses).places.empty());
}

TEST_CASE("the oldest run goes when there are too many, and a chosen place with it") {
    Runs runs;
    for (int i = 0; i < 10; ++i) {
        FlownRun run;
        run.name = std::to_string(i);
        runs.add(std::make_shared<const FlownRun>(run));
        runs.chosen = ChosenPlace{0, 0};
    }
    CHECK(runs.all.size() == most_runs);
    CHECK(runs.all.front()->name == "9");
    CHECK(runs.all.back()->name == "2");
    runs.forget(0);
    CHECK(runs.all.front()->name == "8");
    CHECK_FALSE(runs.chosen);
}

TEST_CASE("a point that is dragged keeps its height above the ground, and the whole drag is one step") {
    Route route = two_points();
    const std::vector<session::ControlPoint> before = route.points();
    for (const double x : {200.0, 300.0, 600.0}) route.place(0, x, 250, true, slope());
    route.place(0, 640, 260, false, slope());
    CHECK(point_position(route.points()[0]).x == 640);
    CHECK(point_position(route.points()[0]).y == Approx(0.5 * 640 + 30)); // 80 m over ground of 50 m at first
    CHECK(point_position(route.points()[0]).z == 260);
    CHECK(route.points()[1] == before[1]);
    route.restore();
    CHECK(route.points() == before);
    route.place(0, 5000, -5, false, slope());
    CHECK(point_position(route.points()[0]).x == 1000); // the rim
    CHECK(point_position(route.points()[0]).z == 0);
    route.place(1, 10, 10, false, slope()); // another step
    route.restore();
    CHECK(point_position(route.points()[0]).x == 1000);
    CHECK_THROWS_AS(route.place(2, 0, 0, false, slope()), io::Failure);
}

TEST_CASE("bookmarks come back as they were kept, and a damaged file is told") {
    const TemporaryFolder folder;
    const Bookmark mark{"The valley", "/a/b.fjell", {{1.25, 2, 3}, {0, 0, -1}, {0, 1, 0}}};
    Bookmark other = mark;
    other.name = "another";
    write_bookmarks(folder.path, {other, mark});
    std::string problem;
    std::vector<Bookmark> read = read_bookmarks(folder.path, problem);
    CHECK(problem.empty());
    REQUIRE(read.size() == 2);
    CHECK(read[1].name == "The valley");
    CHECK(read[1].pack == "/a/b.fjell");
    CHECK(read[1].pose.position_m.x == 1.25);
    spit(folder / "bookmarks.json", "{\"bookmarks\": [{\"name\": 3}]}");
    CHECK(read_bookmarks(folder.path, problem).empty());
    CHECK_THAT(problem, Catch::Contains("bookmarks.json"));
}

TEST_CASE("verbs of studies become their commands, and refuse what is out of range") {
    const auto render = std::get<RenderPicture>(*parse_command("render out.png width=640 height=360"));
    CHECK(render.path == "out.png");
    CHECK(render.width == 640);
    CHECK(render.height == 360);
    const auto compared = std::get<ComparePictures>(*parse_command("compare-picture 2.5"));
    CHECK(compared.with == CompareWith::threshold);
    CHECK(compared.error_px == 2.5);
    CHECK(std::get<ComparePictures>(*parse_command("compare-picture profile")).with == CompareWith::profile);
    CHECK(std::get<AddBookmark>(*parse_command("add-bookmark \"The big one\"")).name == "The big one");
    for (const char* line : {"render", "render a.png sideways", "render a.png width=8", "divider 1.5", "heat warm",
                             "compare-picture -1", "run-place 0 2", "place-point 0 1"})
        CHECK_THROWS_AS(parse_command(line), io::Failure);
}

TEST_CASE("a distant point that is added to a path of a fixed time gets the time that its distance needs") {
    Route route = two_points();
    route.set_seconds(10, slope());
    const double way_m = length(point_position(route.points()[1]) - point_position(route.points()[0]));
    const double speed_m_s = way_m / route.seconds();
    route.select(1);
    route.add({{500 + 20 * way_m, 300, 400}, {1, 0, 0}, {0, 1, 0}}, slope());
    CHECK(route.requested_seconds() == Approx(10 * 21));
    CHECK(route.seconds() == Approx(21 * way_m / speed_m_s).epsilon(0.02));
}

TEST_CASE("the first recording replaces nothing; a later one would replace what was not saved") {
    Route route;
    route.record(true, {{100, 80, 100}, {0, 0, -1}, {0, 1, 0}}, slope());
    for (int i = 1; i < 5; ++i) (void)route.follow({{100.0 + 50 * i, 80, 100}, {0, 0, -1}, {0, 1, 0}}, 1);
    CHECK(route.unsaved()); // an editor that ends would lose it
    CHECK_FALSE(route.unsaved_before_recording());
    route.record(false, {{400, 80, 100}, {0, 0, -1}, {0, 1, 0}}, slope());
    route.record(true, {{100, 80, 100}, {0, 0, -1}, {0, 1, 0}}, slope());
    CHECK(route.unsaved_before_recording());
}
