#include "editor/jobs/measured_flight.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <utility>

#include <epoxy/gl.h>

#include "editor/clock.h"
#include "fjell/gl/context.h"
#include "fjell/gl/target.h"
#include "fjell/io/failure.h"
#include "flight/pictures.h"
#include "flight/session.h"

namespace fjell::editor {

namespace {

// What this thread has had of the processor: what others took of it meanwhile is not the terrain's.
double thread_us() {
    timespec t{};
    (void)clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) * 1e6 + static_cast<double>(t.tv_nsec) * 1e-3;
}

void require(bool made, const std::string& error) {
    if (!made) throw io::Failure(3, error);
}

Vec3 mix(Vec3 a, Vec3 b, double share) {
    return a * (1 - share) + b * share;
}

flight::Pose between(const flight::Pose& a, const flight::Pose& b, double share) {
    flight::Pose pose{mix(a.position_m, b.position_m, share), mix(a.direction, b.direction, share), {}};
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

std::vector<flight::Pose> in_frames(const std::vector<flight::Pose>& route, std::size_t frames) {
    if (route.empty() || frames == 0 || frames == route.size()) return route;
    std::vector<flight::Pose> poses;
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
    std::vector<flight::Pose> poses;
    flight::Session session;
    std::unique_ptr<gl::Headless> context;
    std::unique_ptr<gl::Target> target;
    std::unique_ptr<gl::Renderer> renderer;
    double now_s = 0; // never runs backwards, from flight to flight

    void open();
    void make_graphics(const flight::FlightOptions& options);
    FlownTimes update(const View& view, flight::FrameEntry& entry); // the dearest update with its upload
    double draw(const View& view);
};

void MeasuredFlight::Impl::open() {
    control.progress("open", 0, 1);
    flight::FlightOptions options;
    options.pack = plan.pack->path();
    options.file = plan.pack;
    options.profile = plan.profile;
    flight::open_session(options, session);
    control.check();
    const std::size_t frames = plan.frames != 0 ? plan.frames : flight::default_frames;
    poses = plan.route.empty() ? flight::resample(flight::path_of(options), session.ground(), frames)
                               : in_frames(plan.route, plan.frames);
    if (plan.draws) make_graphics(options);
}

void MeasuredFlight::Impl::make_graphics(const flight::FlightOptions& options) {
    std::string error;
    context = gl::Headless::create({}, error);
    require(context != nullptr, error);
    target = gl::Target::create({plan.profile.width_px, plan.profile.height_px, 1}, error);
    require(target != nullptr, error);
    renderer = flight::make_renderer(options, session, error);
    require(renderer != nullptr, error);
}

FlownTimes MeasuredFlight::Impl::update(const View& view, flight::FrameEntry& entry) {
    FlownTimes dearest;
    double since_us = thread_us();
    entry = flight::update_until_there(session, view, plan.profile, now_s, [&](const flight::FrameEntry& poll) {
        control.check();
        FlownTimes times{std::min(poll.update_us + poll.stream_us, thread_us() - since_us), 0, 0};
        if (renderer) {
            const auto start = Clock::now();
            const std::string error = flight::upload_mesh(*renderer, session, poll);
            require(error.empty(), error);
            times.upload_us = microseconds(Clock::now() - start);
        }
        if (times.all_us() > dearest.all_us()) dearest = times;
        since_us = thread_us();
    });
    return dearest;
}

double MeasuredFlight::Impl::draw(const View& view) {
    const auto start = Clock::now();
    const std::string error = renderer->draw_uploaded(
        session.mesh(), view, flight::draw_options(flight::PictureMode::shaded, plan.profile, 0), *target);
    require(error.empty(), error);
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

const std::vector<flight::Pose>& MeasuredFlight::poses() const {
    return impl_->poses;
}

bool MeasuredFlight::incremental() const {
    return flight::facts_of(impl_->session.method->kind).keeps_mesh;
}

double MeasuredFlight::error_px() const {
    return impl_->plan.profile.refine.error_px;
}

void MeasuredFlight::fly(double error_px, const Each& each) {
    Impl& s = *impl_;
    s.plan.profile.refine.error_px = error_px;
    s.session.begun = s.session.streamed != nullptr; // streamed, there is nothing to build from
    for (std::size_t i = 0; i < s.poses.size(); ++i) {
        s.control.check();
        const View view = flight::view_of(s.poses[i], s.session.terrain(), s.plan.profile);
        flight::FrameEntry entry;
        FlownTimes times = s.update(view, entry);
        if (s.renderer) times.draw_us = s.draw(view);
        s.now_s += 1.0 / 60;
        each(entry, times, i);
    }
}

} // namespace fjell::editor
