#include "editor/jobs/flights.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include <epoxy/gl.h>
#include <fmt/format.h>

#include "editor/jobs/threshold_search.h"
#include "editor/jobs/work.h"
#include "editor/measures.h"
#include "editor/number_text.h"
#include "fjell/gl/context.h"
#include "fjell/gl/target.h"
#include "fjell/io/failure.h"
#include "io/file.h"
#include "session/log.h"
#include "session/pictures.h"
#include "session/session.h"

namespace fjell::editor {

namespace {

// What this thread has had of the processor: what others took of it meanwhile is not the terrain's.
double thread_us() {
    timespec t{};
    (void)clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) * 1e6 + static_cast<double>(t.tv_nsec) * 1e-3;
}

Vec3 mix(Vec3 a, Vec3 b, double share) {
    return a * (1 - share) + b * share;
}

session::Pose between(const session::Pose& a, const session::Pose& b, double share) {
    session::Pose pose{mix(a.position_m, b.position_m, share), mix(a.direction, b.direction, share), {}};
    const double long_m = length(pose.direction);
    if (!(long_m > 1e-6)) return share < 0.5 ? a : b; // turned right about: no direction lies between
    pose.direction = pose.direction * (1 / long_m);
    const Vec3 right = cross(pose.direction, mix(a.up, b.up, share));
    const double wide = length(right);
    if (!(wide > 1e-6)) return share < 0.5 ? a : b;
    pose.up = cross(right * (1 / wide), pose.direction);
    return pose;
}

} // namespace

std::vector<session::Pose> in_frames(const std::vector<session::Pose>& route, std::size_t frames) {
    if (route.empty() || frames == 0 || frames == route.size()) return route;
    std::vector<session::Pose> poses;
    poses.reserve(frames);
    const auto last = static_cast<double>(route.size() - 1);
    for (std::size_t i = 0; i < frames; ++i) {
        const double at = frames == 1 ? 0 : last * static_cast<double>(i) / static_cast<double>(frames - 1);
        const auto before = std::min(static_cast<std::size_t>(at), route.size() - 1);
        const std::size_t after = std::min(before + 1, route.size() - 1);
        poses.push_back(between(route[before], route[after], at - static_cast<double>(before)));
    }
    return poses;
}

struct MeasuredFlight::Impl { // in the order of destruction, last first: GL objects need their context, and all the
                              // terrain
    MeasuredFlightPlan plan;
    JobControl& control;
    std::vector<session::Pose> poses;
    session::Session session;
    std::unique_ptr<gl::Headless> context;
    std::unique_ptr<gl::Target> target;
    std::unique_ptr<gl::Renderer> renderer;
    double now_s = 0; // never runs backwards, from flight to flight

    void open();
    void make_graphics(const session::FlightOptions& options);
    FlownTimes update(const View& view, session::FrameEntry& entry); // the dearest update with its upload
    double draw(const View& view);
};

void MeasuredFlight::Impl::open() {
    control.progress("open", 0, 1);
    const session::FlightOptions options = options_of(plan.pack, plan.profile);
    session::open_session(options, session);
    control.check();
    const std::size_t frames = plan.frames != 0 ? plan.frames : session::default_frames;
    poses = plan.route.empty() ? session::resample(session::path_of(options), session.ground(), frames)
                               : in_frames(plan.route, plan.frames);
    if (plan.draws) make_graphics(options);
}

void MeasuredFlight::Impl::make_graphics(const session::FlightOptions& options) {
    context = gl::Headless::create();
    target = gl::Target::create({plan.profile.width_px, plan.profile.height_px, 1});
    renderer = session::make_renderer(options, session);
}

FlownTimes MeasuredFlight::Impl::update(const View& view, session::FrameEntry& entry) {
    FlownTimes dearest;
    double since_us = thread_us();
    entry = session::update_until_there(session, view, plan.profile, now_s, [&](const session::FrameEntry& poll) {
        control.check();
        FlownTimes times{std::min(poll.update_us + poll.stream_us, thread_us() - since_us), 0, 0};
        if (renderer) {
            const auto start = Clock::now();
            session::upload_mesh(*renderer, session, poll);
            times.upload_us = microseconds(Clock::now() - start);
        }
        if (times.all_us() > dearest.all_us()) dearest = times;
        since_us = thread_us();
    });
    return dearest;
}

double MeasuredFlight::Impl::draw(const View& view) {
    const auto start = Clock::now();
    renderer->draw_uploaded(session.mesh(), view, session::draw_options(session::PictureMode::shaded, plan.profile, 0),
                            *target);
    glFinish();
    return microseconds(Clock::now() - start);
}

MeasuredFlight::MeasuredFlight(MeasuredFlightPlan plan, JobControl& control)
    : impl_(new Impl{std::move(plan), control, {}, {}, {}, {}, {}, 0}) {
    impl_->open();
}

MeasuredFlight::~MeasuredFlight() = default;

std::size_t MeasuredFlight::frames() const {
    return impl_->poses.size();
}

const std::vector<session::Pose>& MeasuredFlight::poses() const {
    return impl_->poses;
}

bool MeasuredFlight::incremental() const {
    return session::facts_of(impl_->session.method->kind).keeps_mesh;
}

double MeasuredFlight::error_px() const {
    return impl_->plan.profile.refine.max_error_px;
}

void MeasuredFlight::fly(double error_px, const Each& each) {
    Impl& s = *impl_;
    s.plan.profile.refine.max_error_px = error_px;
    s.session.begun = s.session.streamed != nullptr; // streamed, there is nothing to build from
    for (std::size_t i = 0; i < s.poses.size(); ++i) {
        s.control.check();
        const View view = session::view_of(s.poses[i], s.session.terrain(), s.plan.profile);
        session::FrameEntry entry;
        FlownTimes times = s.update(view, entry);
        if (s.renderer) times.draw_us = s.draw(view);
        s.now_s += 1.0 / 60;
        each(entry, times, i);
    }
}

// --- Jobs that fly: the one that tunes, and the one that writes a line a frame.

namespace {

void write(io::AtomicFile& file, const std::string& text) {
    file.write(std::as_bytes(std::span(text)));
    file.commit();
}

// Shares of a run whose length becomes known on the way: never backwards.
class Share {
public:
    explicit Share(JobControl& control) : control_(control) {}
    void show(double done, double expected) {
        shown_ = std::max(shown_, std::min(done / std::max(expected, 1.0), 1.0));
        control_.progress("fly", static_cast<std::uint64_t>(shown_ * parts), parts);
    }

private:
    static constexpr std::uint64_t parts = 100'000;
    JobControl& control_;
    double shown_ = 0;
};

// Shares of the update are those that the method has timed itself; the recursive one has none, and refines.
CostParts parts_of(const session::FrameEntry& entry, const FlownTimes& times) {
    const double timed_us = entry.prepare_us + entry.refine_us + entry.output_us;
    const double stream_us = std::min(entry.streamed ? entry.stream_us : 0, times.update_us);
    const double update_us = times.update_us - stream_us;
    const auto part = [&](double us) { return timed_us > 0 ? update_us * us / timed_us : 0; };
    return {part(entry.prepare_us), timed_us > 0 ? part(entry.refine_us) : update_us,
            part(entry.output_us),  stream_us,
            times.upload_us,        times.draw_us};
}

// each: with the frame's number, to show how far it is.
FlightCost fly_once(MeasuredFlight& flight, double error_px, const std::function<void(std::size_t)>& each) {
    FlightCost flown;
    flown.times_us.reserve(flight.frames());
    flown.parts_us.reserve(flight.frames());
    double vertices = 0, reached = 0;
    flight.fly(error_px, [&](const session::FrameEntry& entry, const FlownTimes& times, std::size_t frame) {
        each(frame);
        if (frame == 0) return; // built from nothing, once
        flown.times_us.push_back(times.all_us());
        flown.parts_us.push_back(parts_of(entry, times));
        vertices += entry.vertices;
        reached += entry.converged ? 1 : 0;
    });
    if (flown.times_us.empty())
        throw io::Failure(2, "the path has a single frame, whose mesh is built from scratch; choose more frames");
    const auto frames = static_cast<double>(flown.times_us.size());
    flown.vertices = vertices / frames;
    flown.reached = reached / frames;
    return flown;
}

void tune(MeasuredFlightPlan plan, const TuneSettings& settings, io::AtomicFile* csv, JobControl& control) {
    control.publish([&](JobView& view) { view.tuned = settings; });
    const std::string flown = plan.flight_name;
    MeasuredFlight flight(std::move(plan), control);
    const auto frames = static_cast<double>(flight.frames());
    Share share(control);
    std::uint32_t flights = 0, expected = 16;
    const TuneResult result = find_threshold(
        settings,
        [&](double error_px) {
            return fly_once(flight, error_px, [&](std::size_t frame) {
                share.show(flights + static_cast<double>(frame) / frames, expected);
            });
        },
        [&](const TuneResult& so_far) {
            flights = so_far.flights;
            expected = so_far.expected;
            control.publish([&](JobView& view) {
                view.curve = so_far.curve;
                view.flights = so_far.flights;
            });
        });
    if (csv != nullptr) write(*csv, tune_csv(result.curve));
    control.publish([&](JobView& view) {
        view.best_px = result.best_px;
        view.result = tune_text(result, settings, flown);
    });
}

void benchmark(MeasuredFlightPlan plan, const std::string& path, io::AtomicFile& file, JobControl& control) {
    const double budget_us = plan.profile.cut.max_time_us;
    const std::string profile = plan.profile_name;
    MeasuredFlight flight(std::move(plan), control);
    session::FlightLog log;
    log.frames.reserve(flight.frames());
    const double error_px = flight.error_px();
    flight.fly(error_px, [&](const session::FrameEntry& entry, const FlownTimes&, std::size_t frame) {
        log.frames.push_back(entry);
        control.progress("fly", frame + 1, flight.frames());
    });
    write(file, session::csv(log));
    const session::Summary s = session::summarise(log, flight.incremental());
    auto run = std::make_shared<FlownRun>(make_run(log.frames, flight.poses()));
    run->name = file_name(path);
    run->profile = profile;
    run->budget_us = budget_us;
    control.publish([&](JobView& view) {
        if (!run->places.empty()) view.run = std::move(run);
        view.output = path;
        view.result = fmt::format("{}: {} frames, {} of them converged; update p50 {} ms, p99 {} ms", path, s.frames,
                                  s.converged, fine_ms_text(s.update_us.p50).text, fine_ms_text(s.update_us.p99).text);
    });
}

} // namespace

Jobs::Body tune_job(MeasuredFlightPlan plan, const TuneSettings& settings, const std::string& csv) {
    check(settings);
    plan.frames = settings.frames;
    plan.draws = settings.measure == TuneMeasure::frame;
    // Opened before the work, so that a missing folder does not cost a minute.
    io::refuse_overwriting({csv}, {plan.pack->path()});
    auto file = csv.empty() ? nullptr : std::make_shared<io::AtomicFile>(csv);
    return [plan = std::move(plan), settings, file](JobControl& control) { tune(plan, settings, file.get(), control); };
}

Jobs::Body benchmark_job(MeasuredFlightPlan plan, const std::string& csv) {
    if (csv.empty()) throw io::Failure(2, "give the CSV a file name");
    if (plan.frames > 1'000'000) throw io::Failure(2, "frames must be 1 to 1,000,000, or 0 for the path's own");
    io::refuse_overwriting({csv}, {plan.pack->path()});
    auto file = std::make_shared<io::AtomicFile>(csv);
    return [plan = std::move(plan), csv, file](JobControl& control) { benchmark(plan, csv, *file, control); };
}

} // namespace fjell::editor
