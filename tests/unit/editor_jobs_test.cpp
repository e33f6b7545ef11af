// Jobs beside the frame: one at a time, told of, cancelled, and nothing half-written.
#include <catch2/catch.hpp>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <functional>
#include <new>
#include <string>
#include <thread>
#include <vector>

#include "editor/jobs/jobs.h"
#include "editor/jobs/work.h"
#include "fjell/io/failure.h"
#include "session/session.h"
#include "support/program.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::editor;
using namespace fjell::test;

namespace {

// Until the job has ended; each: after every poll.
JobView finish(Jobs& jobs, const std::function<void(const JobView&)>& each = {}) {
    JobView view;
    while (!jobs.poll(view)) {
        if (each) each(view);
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return view;
}

JobView run(JobKind kind, Jobs::Body body) {
    Jobs jobs;
    jobs.start(kind, std::move(body));
    return finish(jobs);
}

// A pack of 9 tiles at most in its file.
struct JobPlace {
    explicit JobPlace(unsigned seed) {
        Random random(seed);
        (void)baker::bake(random_dem(random, 300, 260, Shape::fractal), small_bake(7), folder / "t.fjell");
    }
    [[nodiscard]] std::shared_ptr<const io::PackFile> pack() const {
        return std::make_shared<const io::PackFile>(folder / "t.fjell");
    }
    [[nodiscard]] MeasuredFlightPlan plan(std::size_t frames) const {
        MeasuredFlightPlan p{pack(), {}, {}, frames, false};
        p.profile.refine.max_error_px = 2;
        return p;
    }
    [[nodiscard]] MeasuredFlightPlan streamed(std::size_t frames) const {
        MeasuredFlightPlan p = plan(frames);
        p.profile.page_slots = slots();
        session::FlightOptions options;
        options.file = p.pack;
        options.profile = p.profile;
        session::Session session;
        session::open_session(options, session);
        REQUIRE(session.streamed != nullptr); // more pages than slots
        return p;
    }
    // One page has no place.
    [[nodiscard]] std::uint32_t slots() const {
        return io::load_pack(folder / "t.fjell", io::LoadTerrain::yes).terrain.page_count() - 1;
    }
    [[nodiscard]] ExportPlan snapshot(const std::string& path, bool streamed = false) const {
        session::FlightOptions options;
        options.pack = folder / "t.fjell";
        options.streaming = session::Streaming::off;
        session::Session session;
        session::open_session(options, session);
        ExportPlan p{pack(), path, {}, streamed, options.profile, {}, 2};
        if (streamed) p.profile.page_slots = slots();
        p.view = session::view_of(session::resample(session::path_of(options), session.ground(), 5)[2],
                                  session.terrain(), p.profile);
        return p;
    }
    TemporaryFolder folder;
};

} // namespace

TEST_CASE("a job tells of its stage and share while it runs, and of its result when it is done") {
    Jobs jobs;
    std::atomic<bool> seen{false};
    jobs.start(JobKind::benchmark, [&](JobControl& control) {
        control.progress("first", 1, 4);
        while (!seen) std::this_thread::sleep_for(std::chrono::milliseconds(1));
        control.publish([](JobView& view) { view.result = "all well"; });
    });
    const JobView view = finish(jobs, [&](const JobView& now) {
        if (now.stage != "first") return;
        CHECK(now.running);
        CHECK(now.share == 0.25);
        CHECK(now.kind == JobKind::benchmark);
        seen = true;
    });
    CHECK_FALSE(view.running);
    CHECK_FALSE(view.cancelled);
    CHECK(view.problem.empty());
    CHECK(view.result == "all well");
    CHECK(view.finished == 1);
    CHECK_FALSE(jobs.running());
}

TEST_CASE("an export is one bar from its beginning to its end, whatever its stages are") {
    const JobPlace place(5);
    Jobs jobs;
    jobs.start(JobKind::snapshot, export_job(place.snapshot(place.folder / "a.glb", true)));
    double share = 0;
    const JobView done = finish(jobs, [&](const JobView& view) {
        CHECK(view.share >= share);
        share = view.share;
    });
    INFO(done.problem);
    REQUIRE(done.problem.empty());
    CHECK(done.share == 1);
}

TEST_CASE("what a job throws, whatever it is, is its problem, and the next one starts again") {
    Jobs jobs;
    const auto problem = [&](Jobs::Body body) {
        jobs.start(JobKind::bake, std::move(body));
        return finish(jobs);
    };
    CHECK(problem([](JobControl&) { throw io::Failure(1, "the disk is square"); }).problem == "the disk is square");
    CHECK_THAT(problem([](JobControl&) { throw std::bad_alloc(); }).problem, Catch::Contains("out of memory"));
    CHECK_FALSE(problem([](JobControl&) { throw 7; }).problem.empty());
    const JobView well = problem([](JobControl&) {});
    CHECK(well.problem.empty());
    CHECK(well.finished == 4);
}

TEST_CASE("a second job is refused in one line while one runs, and the first goes on") {
    Jobs jobs;
    std::atomic<bool> go{false};
    jobs.start(JobKind::tune, [&](JobControl&) {
        while (!go) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    });
    CHECK_THROWS_WITH(jobs.start(JobKind::bake, [](JobControl&) {}), Catch::Contains("another job is running"));
    go = true;
    CHECK(finish(jobs).kind == JobKind::tune);
}

TEST_CASE("a job that is cancelled ends at its next word of progress, without a problem, also by what it throws then") {
    for (const bool as_failure : {false, true}) {
        Jobs jobs;
        jobs.start(JobKind::bake, [&](JobControl& control) {
            for (;;) {
                if (as_failure && control.cancelled()) throw io::Failure(130, "interrupted");
                if (!as_failure) control.progress("wait", 1, 2);
            }
        });
        jobs.cancel();
        const JobView view = finish(jobs);
        CHECK(view.cancelled);
        CHECK(view.problem.empty());
    }
}

TEST_CASE("jobs that are destroyed while one runs cancel it and wait for it") {
    std::atomic<bool> begun{false}, ended{false};
    {
        Jobs jobs;
        jobs.start(JobKind::bake, [&](JobControl& control) {
            begun = true;
            while (!control.cancelled()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
            ended = true;
        });
        while (!begun) std::this_thread::yield();
    }
    CHECK(ended);
}

TEST_CASE("a benchmark writes a line a frame, of a whole terrain and of a streamed one, which waits for its pages") {
    const JobPlace place(11);
    for (const bool streamed : {false, true}) {
        const std::string csv = place.folder / (streamed ? "s.csv" : "w.csv");
        const JobView view =
            run(JobKind::benchmark, benchmark_job(streamed ? place.streamed(30) : place.plan(30), csv));
        INFO(view.problem);
        CHECK(view.problem.empty());
        const std::string text = slurp(csv);
        CHECK(std::count(text.begin(), text.end(), '\n') == 31);
        CHECK(text.starts_with("frame,update_us,"));
        CHECK_THAT(view.result, Catch::Contains("30 frames, 30 of them converged"));
    }
}

TEST_CASE("a benchmark that is cancelled, or cannot write, leaves nothing") {
    const JobPlace place(12);
    Jobs jobs;
    jobs.start(JobKind::benchmark, benchmark_job(place.plan(1'000'000), place.folder / "b.csv"));
    const JobView view = finish(jobs, [&](const JobView& now) {
        if (now.stage == "fly") jobs.cancel();
    });
    CHECK(view.cancelled);
    CHECK(view.stage == "fly");
    CHECK(place.folder.names() == std::vector<std::string>{"t.fjell"});
    CHECK_THROWS_AS(benchmark_job(place.plan(10), place.folder / "no/b.csv"), io::Failure);
    CHECK_THROWS_AS(benchmark_job(place.plan(10), place.folder / "t.fjell"), io::Failure);
    CHECK_THROWS_AS(benchmark_job(place.plan(10), ""), io::Failure);
}

TEST_CASE("a tuning flies its path again and again, tells its curve and keeps to what it measured") {
    const JobPlace place(13);
    for (const bool streamed : {false, true}) {
        TuneSettings settings;
        settings.frames = 40;
        settings.least_px = 4;
        settings.budget_us = 1e6;
        const std::string csv = place.folder / "c.csv";
        const JobView view = run(JobKind::tune, tune_job(streamed ? place.streamed(0) : place.plan(0), settings, csv));
        INFO(view.problem << " " << view.result);
        REQUIRE(view.problem.empty());
        CHECK(view.best_px == 4); // a second a frame is no limit for some hundred vertices
        REQUIRE(view.curve.size() == 4);
        CHECK(view.curve.front().error_px == 32);
        CHECK(view.curve.back().error_px == 4);
        for (const TunePoint& p : view.curve) CHECK(p.frames == 39);
        CHECK(view.curve.back().vertices > view.curve.front().vertices);
        CHECK(slurp(csv).starts_with("threshold_px,"));
        settings.budget_us = 10; // 1 px: some hundred vertices a frame change
        settings.least_px = 0.05;
        settings.most_px = 0.1;
        const JobView none = run(JobKind::tune, tune_job(place.plan(0), settings, ""));
        INFO(none.result);
        CHECK(none.best_px == 0);
        CHECK_THAT(none.result, Catch::Contains("no threshold"));
    }
}

TEST_CASE("a preview of an export has the counts and the size of the file that is then written") {
    const JobPlace place(14);
    for (const bool streamed : {false, true}) {
        const JobView preview = run(JobKind::preview, export_job(place.snapshot("", streamed)));
        INFO(preview.problem);
        REQUIRE(preview.problem.empty());
        CHECK(place.folder.names() == std::vector<std::string>{"t.fjell"});
        const std::string path = place.folder / "m.glb";
        const JobView written = run(JobKind::snapshot, export_job(place.snapshot(path, streamed)));
        REQUIRE(written.problem.empty());
        CHECK(written.preview.vertices == preview.preview.vertices);
        CHECK(written.preview.triangles == preview.preview.triangles);
        CHECK(preview.preview.triangles > 10);
        CHECK(std::filesystem::file_size(path) == preview.preview.bytes);
        CHECK(written.output == path);
        std::filesystem::remove(path);
    }
}

TEST_CASE("a job works on the pack that was open when it was asked for, or says that the file was changed") {
    const JobPlace place(16);
    const JobView before = run(JobKind::preview, export_job(place.snapshot("")));
    REQUIRE(before.problem.empty());
    const ExportPlan plan = place.snapshot("");
    MeasuredFlightPlan flight = place.plan(3);
    flight.pack = plan.pack;
    // Another terrain in its place, as fjell-bake puts it there: renamed.
    Random random(17);
    (void)baker::bake(random_dem(random, 200, 150, Shape::fractal), small_bake(6), place.folder / "t.fjell");
    CHECK(run(JobKind::preview, export_job(place.snapshot(""))).preview.vertices != before.preview.vertices);
    CHECK(run(JobKind::preview, export_job(plan)).preview.vertices == before.preview.vertices);
    CHECK(run(JobKind::benchmark, benchmark_job(flight, place.folder / "b.csv")).problem.empty());
    // Written over its own bytes, as cp does.
    const ExportPlan open = place.snapshot("");
    MeasuredFlightPlan over = place.plan(3);
    over.pack = open.pack;
    const JobPlace other(18);
    spit(place.folder / "t.fjell", slurp(other.folder / "t.fjell"));
    const JobView exported = run(JobKind::preview, export_job(open)),
                  flown = run(JobKind::benchmark, benchmark_job(over, place.folder / "b.csv"));
    for (const JobView& job : {exported, flown}) {
        CHECK(job.exit_code == 1);
        CHECK(job.problem == place.folder / "t.fjell" + ": was changed after it was opened; open it again");
    }
}

TEST_CASE("an export that is cancelled, or has no place, leaves what was there") {
    const JobPlace place(15);
    const std::string path = place.folder / "m.glb";
    spit(path, "older");
    Jobs jobs;
    jobs.start(JobKind::snapshot, [body = export_job(place.snapshot(path))](JobControl& control) {
        while (!control.cancelled()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
        body(control);
    });
    jobs.cancel();
    CHECK(finish(jobs).cancelled);
    CHECK(slurp(path) == "older");
    const JobView nowhere = run(JobKind::snapshot, export_job(place.snapshot(place.folder / "no/m.glb")));
    CHECK_FALSE(nowhere.problem.empty());
    CHECK(place.folder.names() == std::vector<std::string>{"m.glb", "t.fjell"});
    CHECK_THROWS_AS(export_job(place.snapshot(place.folder / "t.fjell")), io::Failure);
}

namespace {
constexpr const char* recipe =
    R"({"columns": 1025, "rows": 1025, "spacing_m": 60, "seed": 7, "relief_m": 2500, "feature_m": 6000})";
}

TEST_CASE("a bake beside the frame writes the pack that opens, with the options it was given") {
    const TemporaryFolder folder;
    spit(folder / "hills.json", recipe);
    CHECK(pack_beside("/x/hills.tif") == "/x/hills.fjell");
    BakePack bake;
    bake.inputs = {folder / "hills.json"};
    bake.tile = 128;
    const JobView view = run(JobKind::bake, bake_job(bake));
    INFO(view.problem);
    REQUIRE(view.problem.empty());
    CHECK(view.output == folder / "hills.fjell");
    const io::LoadedPack loaded = io::load_pack(view.output, io::LoadTerrain::yes);
    CHECK(loaded.pack.header.columns == 1025);
    CHECK(loaded.pack.header.tile_log2 == 7);
}

TEST_CASE("a bake that is cancelled leaves no pack, and one that cannot begin says why at once") {
    const TemporaryFolder folder;
    spit(folder / "hills.json", recipe);
    BakePack bake;
    bake.inputs = {folder / "hills.json"};
    bake.output = folder / "p.fjell";
    Jobs jobs;
    jobs.start(JobKind::bake, bake_job(bake));
    const JobView view = finish(jobs, [&](const JobView& now) {
        if (!now.stage.empty() && now.stage != "open") jobs.cancel();
    });
    CHECK(view.cancelled);
    CHECK(view.result == "no files remain");
    CHECK(folder.names() == std::vector<std::string>{"hills.json"});
    const auto refuses = [&](auto change, const std::string& part) {
        BakePack wrong = bake;
        change(wrong);
        CHECK_THROWS_WITH(bake_job(wrong), Catch::Contains(part));
    };
    refuses([](BakePack& b) { b.inputs.clear(); }, "choose a file");
    refuses([](BakePack& b) { b.order = "snail"; }, "order=snail");
    refuses([](BakePack& b) { b.tile = 100; }, "100");
    refuses([](BakePack& b) { b.spacing_m = -1; }, "spacing");
    refuses([](BakePack& b) { b.memory_mb = 1; }, "memory_mb");
    refuses([](BakePack& b) { b.output = b.inputs[0]; }, "hills.json");
    bake.inputs = {folder / "none.tif"};
    CHECK_THAT(run(JobKind::bake, bake_job(bake)).problem, Catch::Contains("none.tif"));
}

TEST_CASE("a bake that is cancelled midway and keeps its folder is gone on with by the same bake") {
    const TemporaryFolder folder;
    spit(folder / "hills.json", recipe);
    BakePack bake;
    bake.inputs = {folder / "hills.json"};
    bake.output = folder / "p.fjell";
    bake.checkpoint_s = 0; // or all of it would fit the memory
    Jobs jobs;
    jobs.start(JobKind::bake, bake_job(bake));
    const JobView view = finish(jobs, [&](const JobView& now) {
        if (now.stage == "vertices" || now.stage == "maps") jobs.cancel();
    });
    REQUIRE(view.cancelled);
    CHECK_THAT(view.result, Catch::Contains("p.fjell.work remains"));
    const JobView again = run(JobKind::bake, bake_job(bake));
    CHECK_THAT(again.result, Catch::Contains("resumed from an earlier bake"));
    CHECK(folder.names() == std::vector<std::string>{"hills.json", "p.fjell"});
}

TEST_CASE("a route in other frames begins and ends where it did and holds the camera upright") {
    std::vector<session::Pose> route;
    for (int i = 0; i <= 10; ++i) {
        const double a = 0.2 * i;
        route.push_back({{10.0 * i, 5, 0}, {std::cos(a), 0, std::sin(a)}, {0, 1, 0}});
    }
    const std::vector<session::Pose> more = in_frames(route, 41);
    REQUIRE(more.size() == 41);
    CHECK(more.front().position_m.x == 0);
    CHECK(more.back().position_m.x == 100);
    CHECK(more[2].position_m.x == Approx(5));
    for (const session::Pose& p : more) {
        CHECK(length(p.direction) == Approx(1));
        CHECK(length(p.up) == Approx(1));
        CHECK(std::abs(dot(p.direction, p.up)) < 1e-12);
    }
    CHECK(in_frames(route, 0).size() == route.size());
    CHECK(in_frames(route, 1).size() == 1);
    CHECK(in_frames({}, 5).empty());
}
