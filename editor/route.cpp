#include "editor/route.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "fjell/io/failure.h"
#include "flight/path_timing.h"
#include "io/file.h"

namespace fjell::editor {

namespace {

using flight::CameraPath;
using flight::ControlPoint;
using flight::Pose;
using io::Failure;

constexpr double turned_rad = 0.07;          // 4 degrees: a point at least so often while recording
constexpr std::size_t points_of_flight = 65; // of a path that is not made of points

ControlPoint point_of(const Pose& p) {
    return flight::unit_point({p.position_m.x, p.position_m.y, p.position_m.z, p.direction.x, p.direction.y,
                               p.direction.z, p.up.x, p.up.y, p.up.z});
}

Pose pose_of(const ControlPoint& p) {
    const Vec3 direction = normalised(Vec3{p[3], p[4], p[5]}), up{p[6], p[7], p[8]};
    return {{p[0], p[1], p[2]}, direction, normalised(up - direction * dot(up, direction))};
}

// No way of one camera to the other but what numbers round to, through which no curve can be laid.
bool same_place(const ControlPoint& a, const ControlPoint& b) {
    constexpr double least_m = 1e-3, least_turn = 1e-5;
    double moved = 0, turned = 0;
    for (std::size_t i = 0; i < 3; ++i) moved = std::max(moved, std::abs(a[i] - b[i]));
    for (std::size_t i = 3; i < 9; ++i) turned = std::max(turned, std::abs(a[i] - b[i]));
    return moved < least_m && turned < least_turn;
}

CameraPath spline_through(std::vector<ControlPoint> points, std::vector<double> times_s, double seconds) {
    CameraPath path;
    path.name = "camera path";
    path.seconds = seconds;
    std::vector<double> knots = flight::chord_knots(points, path.name);
    path.kind = flight::SplinePath{flight::CubicSpline<9>(std::move(knots), std::move(points)), std::move(times_s)};
    return path;
}

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

double length_m(std::span<const ControlPoint> points) {
    double sum = 0;
    for (std::size_t i = 1; i < points.size(); ++i)
        sum += length(Vec3{points[i][0], points[i][1], points[i][2]} -
                      Vec3{points[i - 1][0], points[i - 1][1], points[i - 1][2]});
    return sum;
}

void require_apart(std::span<const double> times_s) {
    if (flight::first_bad_time(times_s))
        throw Failure(2, fmt::format("two points would be less than {} s apart; make the path longer, or remove one",
                                     flight::least_between_times_s));
    if (!times_s.empty() && times_s.back() > flight::max_path_seconds)
        throw Failure(2, fmt::format("the path would be longer than {} seconds; make it shorter first",
                                     flight::max_path_seconds));
}

std::size_t frames_for(double seconds) {
    return std::max<std::size_t>(static_cast<std::size_t>(std::lround(seconds * poses_a_second)), 2);
}

struct Keys {
    std::vector<ControlPoint> points;
    std::vector<double> times_s, shares; // shares: of the flight's time
};

// The spline's own where it is in metres; otherwise some of its flight.
Keys keys_of(const CameraPath& path, std::span<const Pose> poses) {
    Keys keys;
    const auto* spline = std::get_if<flight::SplinePath>(&path.kind);
    if (spline != nullptr && path.units == flight::Units::metres && spline->spline.knots().size() <= most_points) {
        for (const double knot : spline->spline.knots())
            keys.points.push_back(flight::unit_point(spline->spline.at(knot)));
        keys.times_s = spline->times_s;
        keys.shares = flight::shares(*spline);
        return keys;
    }
    const bool timed = spline != nullptr && !spline->times_s.empty();
    const std::size_t count = std::min(points_of_flight, poses.size()), last = poses.size() - 1;
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t at = i * last / std::max<std::size_t>(count - 1, 1);
        const ControlPoint p = point_of(poses[at]);
        if (!keys.points.empty() && p == keys.points.back()) continue;
        keys.points.push_back(p);
        keys.shares.push_back(static_cast<double>(at) / static_cast<double>(std::max<std::size_t>(last, 1)));
        if (timed) keys.times_s.push_back(keys.shares.back() * path.seconds);
    }
    if (keys.points.size() < 2) keys.times_s.clear();
    return keys;
}

} // namespace

void Route::open(const std::string& path, const flight::Ground& ground) {
    Content next;
    CameraPath read = flight::read_path(path);
    next.seconds = read.seconds > 0 ? read.seconds : static_cast<double>(flight::default_frames) / poses_a_second;
    next.poses = flight::resample(read, ground, frames_for(next.seconds));
    Keys keys = keys_of(read, next.poses);
    next.points = std::move(keys.points);
    next.times_s = std::move(keys.times_s);
    next.shares = std::move(keys.shares);
    next.path = path;
    next.as_read = std::move(read);
    take_over(std::move(next));
    share_ = 0;
    playing_ = recording_ = false;
}

void Route::save(const std::string& path) {
    const std::string& to = path.empty() ? now_.path : path;
    if (to.empty()) throw Failure(2, "the camera path has no file yet; say where to save it");
    if (now_.points.size() < 2) throw Failure(2, "a camera path needs at least 2 points; add some before saving it");
    CameraPath written;
    if (now_.as_read && now_.as_read->units != flight::Units::recorded)
        written = *now_.as_read;
    else
        written = spline_through(now_.points, now_.times_s, now_.seconds);
    written.seconds = now_.seconds;
    const std::string text = flight::path_text(written);
    io::AtomicFile file(to);
    file.write(std::as_bytes(std::span(text)));
    file.commit();
    now_.path = std::string(to);
    now_.unsaved = false;
}

void Route::clear() {
    take_over({});
    share_ = 0;
    playing_ = recording_ = false;
    recorded_points_.clear();
}

void Route::restore() {
    if (!can_restore()) throw Failure(2, "there is no earlier camera path to restore");
    std::swap(now_, before_);
    share_ = 0;
    playing_ = false;
}

void Route::play(bool on) {
    if (on && empty()) throw Failure(2, "there is no camera path to play; open one, record one or add points");
    if (on && share_ >= 1) share_ = 0;
    playing_ = on;
}

void Route::seek(double share) {
    share_ = std::clamp(share, 0.0, 1.0);
}

void Route::set_seconds(double seconds, const flight::Ground& ground) {
    if (!(seconds == 0 || (seconds >= 1 && seconds <= flight::max_path_seconds)))
        throw Failure(2, fmt::format("a path lasts 1 to {} seconds, or 0 for a duration chosen from the terrain's size",
                                     flight::max_path_seconds));
    Content next = now_;
    next.seconds = seconds;
    stretch(next.times_s, seconds);
    if (next.as_read) { // the same flight, only slower or faster
        std::vector<double>* times_s = times_in(*next.as_read);
        if (times_s != nullptr) stretch(*times_s, seconds);
        next.as_read->seconds = seconds;
        require_apart(next.times_s);
        next.poses =
            flight::resample(*next.as_read, ground, seconds > 0 ? frames_for(seconds) : flight::default_frames);
        if (times_s != nullptr && seconds == 0) { // another flight after all
            Keys keys = keys_of(*next.as_read, next.poses);
            next.points = std::move(keys.points);
            next.shares = std::move(keys.shares);
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

Pose Route::pose() const {
    const std::vector<Pose>& poses = now_.poses;
    const double at = share_ * static_cast<double>(poses.size() - 1);
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
    if (next.points.size() < 2) throw Failure(2, "nothing was recorded, because the camera did not move");
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

void Route::edit(Content next, const flight::Ground& ground) {
    if (std::ranges::adjacent_find(next.points, same_place) != next.points.end())
        throw Failure(2, "an adjacent point has the same pose already; move the camera first");
    require_apart(next.times_s);
    if (!next.times_s.empty()) next.seconds = next.times_s.back();
    next.poses.clear();
    next.shares.clear();
    next.as_read.reset();
    next.unsaved = !next.points.empty() || !next.path.empty();
    if (next.points.size() >= 2) {
        const double cruising_m_s = ground.longer_m() / 60;
        const double seconds = next.seconds > 0
                                   ? next.seconds
                                   : std::clamp(length_m(next.points) / cruising_m_s, 2.0, flight::max_path_seconds);
        const CameraPath path = spline_through(next.points, next.times_s, seconds);
        next.poses = flight::resample(path, ground, frames_for(seconds));
        next.shares = flight::shares(std::get<flight::SplinePath>(path.kind));
    }
    take_over(std::move(next));
    if (empty()) playing_ = false;
}

void Route::take_over(Content next) {
    dragged_.reset();
    if (!now_.points.empty()) before_ = std::move(now_);
    now_ = std::move(next);
}

void Route::require(std::size_t point) const {
    if (point >= now_.points.size())
        throw Failure(2, now_.points.empty() ? std::string("the camera path has no points")
                                             : fmt::format("there is no point {}; the path has 0 to {}", point,
                                                           now_.points.size() - 1));
}

void Route::add(const Pose& pose, const flight::Ground& ground) {
    if (now_.points.size() >= most_points)
        throw Failure(2, fmt::format("a camera path has at most {} points; remove some", most_points));
    Content next = now_;
    const std::size_t at = next.selected ? *next.selected + 1 : next.points.size();
    next.points.insert(next.points.begin() + static_cast<std::ptrdiff_t>(at), point_of(pose));
    if (std::vector<double>& t = next.times_s; !t.empty())
        t.insert(t.begin() + static_cast<std::ptrdiff_t>(at),
                 at < t.size() ? (t[at - 1] + t[at]) / 2 : 2 * t[at - 1] - t[at - 2]);
    next.selected = at;
    edit(std::move(next), ground);
}

void Route::replace(std::size_t point, const Pose& pose, const flight::Ground& ground) {
    require(point);
    Content next = now_;
    next.points[point] = point_of(pose);
    next.selected = point;
    edit(std::move(next), ground);
}

void Route::remove(std::size_t point, const flight::Ground& ground) {
    require(point);
    Content next = now_;
    next.points.erase(next.points.begin() + static_cast<std::ptrdiff_t>(point));
    if (std::vector<double>& t = next.times_s; !t.empty()) {
        t.erase(t.begin() + static_cast<std::ptrdiff_t>(point));
        const double first_s = t.front(); // when there were two at least
        for (double& time_s : t) time_s -= first_s;
        if (t.size() < 2) t.clear();
    }
    next.selected.reset();
    if (!next.points.empty()) next.selected = std::min(point, next.points.size() - 1);
    edit(std::move(next), ground);
}

void Route::move(std::size_t point, std::size_t to, const flight::Ground& ground) {
    require(point);
    require(to);
    Content next = now_;
    const auto at = [&](std::size_t i) { return next.points.begin() + static_cast<std::ptrdiff_t>(i); };
    if (point < to)
        std::rotate(at(point), at(point + 1), at(to + 1));
    else
        std::rotate(at(to), at(point), at(point + 1));
    next.selected = to;
    edit(std::move(next), ground);
}

Pose Route::select(std::size_t point) {
    require(point);
    now_.selected = point;
    return pose_of(now_.points[point]);
}

} // namespace fjell::editor
