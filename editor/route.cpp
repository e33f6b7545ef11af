#include "editor/route.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "editor/route_parts.h"
#include "editor/strings.h"
#include "fjell/io/failure.h"
#include "flight/path_timing.h"
#include "io/file.h"

namespace fjell::editor {

namespace {

using flight::CameraPath;
using flight::ControlPoint;
using flight::Pose;
using io::Failure;
using route_parts::frames_for;
using route_parts::point_of;

constexpr double turned_rad = 0.07;          // 4 degrees: a point at least so often while recording
constexpr std::size_t points_of_flight = 65; // of a path that is not made of points

std::vector<double>* times_in(CameraPath& path) {
    auto* spline = std::get_if<flight::SplinePath>(&path.kind);
    return spline != nullptr && !spline->times_s.empty() ? &spline->times_s : nullptr;
}

// None for 0.
void stretch(std::vector<double>& times_s, double seconds) {
    if (times_s.empty()) return;
    const double by = seconds / times_s.back();
    for (double& time_s : times_s) time_s *= by;
    times_s.back() = seconds;
    if (seconds == 0) times_s.clear();
}

} // namespace

// The spline's own where it is in metres; otherwise some of its flight, which is in content.poses.
void Route::take_keys(Content& content, const CameraPath& path) {
    const auto* spline = std::get_if<flight::SplinePath>(&path.kind);
    content.points.clear();
    content.times_s.clear();
    content.shares.clear();
    content.targets.clear();
    content.closed = spline != nullptr && spline->spline.closed();
    content.eases = spline != nullptr && spline->eases;
    if (spline != nullptr && path.units == flight::Units::metres && spline->spline.knots().size() <= most_points) {
        for (const double knot : spline->spline.knots())
            content.points.push_back(flight::unit_point(spline->spline.at(knot)));
        content.times_s = spline->times_s;
        content.shares = flight::shares(*spline);
        content.targets = spline->targets;
        return;
    }
    const std::vector<Pose>& poses = content.poses;
    const bool timed = spline != nullptr && !spline->times_s.empty();
    const std::size_t count = std::min(points_of_flight, poses.size()), last = poses.size() - 1;
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t at = i * last / std::max<std::size_t>(count - 1, 1);
        const ControlPoint p = point_of(poses[at]);
        if (!content.points.empty() && p == content.points.back()) continue;
        content.points.push_back(p);
        content.shares.push_back(static_cast<double>(at) / static_cast<double>(std::max<std::size_t>(last, 1)));
        if (timed) content.times_s.push_back(content.shares.back() * path.seconds);
    }
    if (content.points.size() < 2) content.times_s.clear();
    if (content.closed) content.points.back() = content.points.front();
}

void Route::open(const std::string& path, const flight::Ground& ground) {
    Content next;
    CameraPath read = flight::read_path(path);
    next.seconds = read.seconds > 0 ? read.seconds : static_cast<double>(flight::default_frames) / poses_a_second;
    next.poses = flight::resample(read, ground, frames_for(next.seconds));
    take_keys(next, read);
    next.path = path;
    next.as_read = std::move(read);
    if (now_.points.empty())
        now_ = std::move(next); // no step: nothing was there to come back to
    else
        take_over(std::move(next));
    share_ = 0;
    playing_ = recording_ = false;
}

void Route::save(const std::string& path) {
    const std::string& to = path.empty() ? now_.path : path;
    if (to.empty()) throw Failure(2, strings::refusals::path_without_file);
    if (now_.points.size() < 2) throw Failure(2, strings::refusals::path_too_short);
    CameraPath written;
    if (now_.as_read && now_.as_read->units != flight::Units::recorded)
        written = *now_.as_read;
    else
        written = path_of(now_, now_.seconds);
    written.seconds = now_.seconds;
    const std::string text = flight::path_text(written);
    io::AtomicFile file(to);
    file.write(std::as_bytes(std::span(text)));
    file.commit();
    const std::string saved_to = to;
    for (std::vector<Step>* const steps : {&undo_, &redo_}) // which were saved there once, and are not any more
        for (Step& step : *steps)
            if (step.content.path == saved_to) step.content.unsaved = true;
    now_.path = saved_to;
    now_.unsaved = false;
}

FlightName Route::flight_name() const {
    FlightName name{};
    const std::size_t slash = now_.path.find_last_of('/');
    const char* const file = now_.path.c_str() + (slash == std::string::npos ? 0 : slash + 1);
    if (empty() || now_.path.empty())
        (void)std::snprintf(name.text, sizeof name.text, "%s",
                            empty() ? strings::results::an_orbit : strings::results::the_path);
    else
        (void)std::snprintf(name.text, sizeof name.text, strings::results::path_file, file);
    return name;
}

void Route::clear() {
    take_over({});
    share_ = 0;
    playing_ = recording_ = false;
    recorded_points_.clear();
}

void Route::play(bool on) {
    if (on && empty()) throw Failure(2, strings::refusals::no_path);
    if (on && share_ >= 1) share_ = 0;
    playing_ = on;
}

void Route::seek(double share) {
    share_ = std::clamp(share, 0.0, 1.0);
}

void Route::set_seconds(double seconds, const flight::Ground& ground) {
    if (!(seconds == 0 || (seconds >= 1 && seconds <= flight::max_path_seconds)))
        throw Failure(2, fmt::format(strings::refusals::bad_duration, flight::max_path_seconds));
    Content next = now_;
    next.seconds = seconds;
    stretch(next.times_s, seconds);
    if (next.as_read) { // the same flight, only slower or faster
        std::vector<double>* times_s = times_in(*next.as_read);
        if (times_s != nullptr) {
            stretch(*times_s, seconds);
            if (seconds == 0) std::get<flight::SplinePath>(next.as_read->kind).eases = false;
        }
        next.as_read->seconds = seconds;
        route_parts::require_apart(next.times_s);
        next.poses =
            flight::resample(*next.as_read, ground, seconds > 0 ? frames_for(seconds) : flight::default_frames);
        if (times_s != nullptr && seconds == 0) { // another flight after all
            take_keys(next, *next.as_read);
            next.selected.reset();
        }
        next.unsaved = true;
        take_over(std::move(next));
        return;
    }
    edit(std::move(next), ground);
}

std::optional<Pose> Route::advance(double seconds) {
    if (!playing_ || empty()) return {};
    share_ += seconds / this->seconds();
    if (share_ >= 1) {
        playing_ = loops_;
        share_ = loops_ ? std::fmod(share_, 1.0) : 1;
    }
    return pose();
}

Pose Route::pose_at(double share) const {
    const std::vector<Pose>& poses = now_.poses;
    const double at = share * static_cast<double>(poses.size() - 1);
    const auto i = std::min(static_cast<std::size_t>(at), poses.size() - 1);
    const Pose &a = poses[i], &b = poses[std::min(i + 1, poses.size() - 1)];
    const double f = at - static_cast<double>(i);
    const auto between = [f](Vec3 from, Vec3 to) { return from * (1 - f) + to * f; };
    const Vec3 direction = normalised(between(a.direction, b.direction)), up = between(a.up, b.up);
    return {between(a.position_m, b.position_m), direction, normalised(up - direction * dot(up, direction))};
}

void Route::record(bool on, const Pose& pose, const flight::Ground& ground) {
    if (on == recording_) return;
    recording_ = on;
    if (on) {
        playing_ = false;
        step_m_ = std::max(2 * ground.cell_m, ground.longer_m() / 1000);
        recorded_s_ = 0;
        recorded_points_.clear();
        recorded_points_.reserve(most_points); // here, so that no frame has to
        record_point(pose);
        return;
    }
    Content next;
    next.points = recorded_points_; // which stay until they are the path
    const ControlPoint last = point_of(pose);
    if (!next.points.empty() && next.points.back() != last && next.points.size() < most_points)
        next.points.push_back(last);
    if (next.points.size() < 2) throw Failure(2, strings::refusals::nothing_recorded);
    next.seconds = std::clamp(recorded_s_, 1.0, flight::max_path_seconds);
    next.selected = {};
    edit(std::move(next), ground);
    recorded_points_.clear();
    share_ = 0;
}

void Route::record_point(const Pose& pose) {
    recorded_points_.push_back(point_of(pose));
}

bool Route::follow(const Pose& pose, double seconds) {
    if (!recording_) return true;
    const ControlPoint& last = recorded_points_.back();
    const double moved = length(pose.position_m - Vec3{last[0], last[1], last[2]});
    const double turned =
        length(pose.direction - Vec3{last[3], last[4], last[5]}) + length(pose.up - Vec3{last[6], last[7], last[8]});
    recorded_s_ += seconds;
    if (moved >= step_m_ || turned >= turned_rad) record_point(pose);
    return recorded_points_.size() < most_points;
}

} // namespace fjell::editor
