#include "editor/route.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "editor/document.h"
#include "editor/number_text.h"
#include "fjell/io/failure.h"
#include "io/file.h"

namespace fjell::editor {

namespace {

using io::Failure;
using session::CameraPath;
using session::ControlPoint;
using session::Pose;

constexpr double turned_rad = 0.07;          // 4 degrees: a point at least so often while recording
constexpr std::size_t points_of_flight = 65; // of a path that is not made of points
constexpr std::size_t most_path_steps = 100, most_path_bytes = std::size_t{64} << 20;

ControlPoint point_of(const Pose& p) {
    return session::unit_point({p.position_m.x, p.position_m.y, p.position_m.z, p.direction.x, p.direction.y,
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

double length_m(std::span<const ControlPoint> points) {
    double sum = 0;
    for (std::size_t i = 1; i < points.size(); ++i)
        sum += length(pose_of(points[i]).position_m - pose_of(points[i - 1]).position_m);
    return sum;
}

std::size_t frames_for(double seconds) {
    return std::max<std::size_t>(static_cast<std::size_t>(std::lround(seconds * poses_a_second)), 2);
}

// The spline's own where it is in metres; otherwise some of its flight. With where they lie in its time.
void take_points(const CameraPath& path, const std::vector<Pose>& poses, std::vector<ControlPoint>& points,
                 std::vector<double>& shares) {
    const auto* spline = std::get_if<session::SplinePath>(&path.kind);
    if (spline != nullptr && path.units == session::Units::metres && spline->spline.knots().size() <= most_points) {
        for (const double knot : spline->spline.knots()) points.push_back(session::unit_point(spline->spline.at(knot)));
        shares = session::shares(*spline);
        return;
    }
    const std::size_t count = std::min(points_of_flight, poses.size()), last = poses.size() - 1;
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t at = i * last / std::max<std::size_t>(count - 1, 1);
        const ControlPoint p = point_of(poses[at]);
        if (!points.empty() && p == points.back()) continue;
        points.push_back(p);
        shares.push_back(static_cast<double>(at) / static_cast<double>(std::max<std::size_t>(last, 1)));
    }
}

} // namespace

void Route::open(const std::string& path, const session::Ground& ground) {
    Content next;
    CameraPath read = session::read_path(path);
    next.seconds = read.seconds > 0 ? read.seconds : static_cast<double>(session::default_frames) / poses_a_second;
    next.poses = session::resample(read, ground, frames_for(next.seconds));
    take_points(read, next.poses, next.points, next.shares);
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
    if (to.empty()) throw Failure(2, "the camera path has no file yet; say where to save it");
    if (now_.points.size() < 2) throw Failure(2, "a camera path needs at least 2 points; add some first");
    CameraPath written;
    if (now_.as_read && now_.as_read->units != session::Units::recorded)
        written = *now_.as_read;
    else
        written = path_of(now_, now_.seconds);
    written.seconds = now_.seconds;
    const std::string text = session::path_text(written);
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
    if (empty() || now_.path.empty())
        (void)std::snprintf(name.text, sizeof name.text, "%s", empty() ? "an orbit" : "the camera path");
    else
        (void)std::snprintf(name.text, sizeof name.text, "the path %.80s", file_name(now_.path));
    return name;
}

void Route::clear() {
    take_over({});
    share_ = 0;
    playing_ = recording_ = false;
    recorded_points_.clear();
}

void Route::play(bool on) {
    if (on && empty()) throw Failure(2, "there is no camera path yet; open one, record one or add points");
    if (on && share_ >= 1) share_ = 0;
    playing_ = on;
}

void Route::seek(double share) {
    share_ = std::clamp(share, 0.0, 1.0);
}

void Route::set_seconds(double seconds, const session::Ground& ground) {
    if (!(seconds == 0 || (seconds >= 1 && seconds <= session::max_path_seconds)))
        throw Failure(2, fmt::format("a path lasts 1 to {} seconds, or 0 for a duration chosen from the terrain's size",
                                     session::max_path_seconds));
    Content next = now_;
    next.seconds = seconds;
    if (!next.as_read) return edit(std::move(next), ground);
    next.as_read->seconds = seconds; // the same flight, only slower or faster
    next.poses = session::resample(*next.as_read, ground, seconds > 0 ? frames_for(seconds) : session::default_frames);
    next.unsaved = true;
    take_over(std::move(next));
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

void Route::record(bool on, const Pose& pose, const session::Ground& ground) {
    if (on == recording_) return;
    recording_ = on;
    if (on) {
        playing_ = false;
        step_m_ = std::max(2 * ground.cell_m, ground.longer_m() / 1000);
        recorded_s_ = 0;
        recorded_points_.clear();
        recorded_points_.reserve(most_points); // here, so that no frame has to
        recorded_points_.push_back(point_of(pose));
        return;
    }
    Content next;
    next.points = recorded_points_; // which stay until they are the path
    const ControlPoint last = point_of(pose);
    if (!next.points.empty() && next.points.back() != last && next.points.size() < most_points)
        next.points.push_back(last);
    if (next.points.size() < 2) throw Failure(2, "nothing was recorded, because the camera did not move");
    next.seconds = std::clamp(recorded_s_, 1.0, session::max_path_seconds);
    next.selected = {};
    edit(std::move(next), ground);
    recorded_points_.clear();
    share_ = 0;
}

bool Route::follow(const Pose& pose, double seconds) {
    if (!recording_) return true;
    const ControlPoint& last = recorded_points_.back();
    const double moved = length(pose.position_m - Vec3{last[0], last[1], last[2]});
    const double turned =
        length(pose.direction - Vec3{last[3], last[4], last[5]}) + length(pose.up - Vec3{last[6], last[7], last[8]});
    recorded_s_ += seconds;
    if (moved >= step_m_ || turned >= turned_rad) recorded_points_.push_back(point_of(pose));
    return recorded_points_.size() < most_points;
}

CameraPath Route::path_of(const Content& content, double seconds) {
    CameraPath path;
    path.name = "camera path";
    path.seconds = seconds;
    std::vector<double> knots = session::chord_knots(content.points, path.name);
    path.kind = session::SplinePath{session::CubicSpline<9>(std::move(knots), content.points)};
    return path;
}

void Route::complete(Content& next, const session::Ground& ground) {
    if (std::ranges::adjacent_find(next.points, same_place) != next.points.end())
        throw Failure(2, "an adjacent point has the same pose already; move the camera first");
    next.poses.clear();
    next.shares.clear();
    next.as_read.reset();
    next.unsaved = !next.points.empty() || !next.path.empty();
    if (next.points.size() < 2) return;
    const double cruising_m_s = ground.longer_m() / 60;
    const double seconds = next.seconds > 0
                               ? next.seconds
                               : std::clamp(length_m(next.points) / cruising_m_s, 2.0, session::max_path_seconds);
    const CameraPath path = path_of(next, seconds);
    next.poses = session::resample(path, ground, frames_for(seconds));
    next.shares = session::shares(std::get<session::SplinePath>(path.kind));
}

void Route::edit(Content next, const session::Ground& ground) {
    complete(next, ground);
    take_over(std::move(next));
    if (empty()) playing_ = false;
}

void Route::take_over(Content next) {
    held_.reset();
    if (!now_.points.empty() || !next.points.empty() || now_.seconds != next.seconds) {
        undo_.push_back({std::move(now_), next_edit_stamp()});
        redo_.clear();
    }
    now_ = std::move(next);
    std::size_t bytes = 0, kept = 0;
    for (; kept < std::min(undo_.size(), most_path_steps); ++kept) {
        const Content& c = undo_[undo_.size() - 1 - kept].content;
        bytes += c.poses.size() * sizeof(Pose) + c.points.size() * sizeof(ControlPoint);
        if (kept > 0 && bytes > most_path_bytes) break;
    }
    undo_.erase(undo_.begin(), undo_.end() - static_cast<std::ptrdiff_t>(kept));
}

void Route::exchange(std::vector<Step>& from, std::vector<Step>& to, const char* none) {
    if (from.empty()) throw Failure(2, none);
    if (held_) ignored_ = std::exchange(held_, {});
    to.push_back({std::exchange(now_, std::move(from.back().content)), from.back().stamp});
    from.pop_back();
    if (empty()) share_ = 0;
    playing_ = false;
}

void Route::undo() {
    exchange(undo_, redo_, "there is no earlier camera path to restore");
}

void Route::redo() {
    exchange(redo_, undo_, "there is no later camera path to restore");
}

void Route::restore() {
    redo_.empty() ? undo() : redo();
}

void Route::require(std::size_t point) const {
    if (now_.points.empty()) throw Failure(2, "the camera path has no points yet; add some first");
    if (point >= now_.points.size())
        throw Failure(2, fmt::format("there is no point {}; the path has 0 to {}", point, now_.points.size() - 1));
}

namespace {

double way_m(const std::vector<ControlPoint>& points) {
    double all_m = 0;
    for (std::size_t i = 1; i < points.size(); ++i)
        all_m += length(
            Vec3{points[i][0] - points[i - 1][0], points[i][1] - points[i - 1][1], points[i][2] - points[i - 1][2]});
    return all_m;
}

} // namespace

void Route::add(const Pose& pose, const session::Ground& ground) {
    if (now_.points.size() >= most_points)
        throw Failure(2, fmt::format("a camera path has at most {} points; remove some first", most_points));
    Content next = now_;
    const std::size_t at = next.selected ? *next.selected + 1 : next.points.size();
    const double before_m = way_m(next.points);
    next.points.insert(next.points.begin() + static_cast<std::ptrdiff_t>(at), point_of(pose));
    // As fast as before, however far it is to the new one.
    if (next.seconds > 0 && before_m > 0)
        next.seconds = std::min(next.seconds * way_m(next.points) / before_m, session::max_path_seconds);
    next.selected = at;
    edit(std::move(next), ground);
}

void Route::insert(double share, const session::Ground& ground) {
    if (empty()) throw Failure(2, "there is no camera path yet; open one, record one or add points");
    const auto later = std::upper_bound(now_.shares.begin(), now_.shares.end(), share);
    const auto at = static_cast<std::size_t>(later - now_.shares.begin());
    const double least = 1 / (poses_a_second * seconds()); // a pose from the points beside it
    if (at == 0 || later == now_.shares.end() || share - now_.shares[at - 1] < least || *later - share < least)
        throw Failure(2, "the camera path has a point there already; go to a place between two points");
    if (now_.points.size() >= most_points)
        throw Failure(2, fmt::format("a camera path has at most {} points; remove some first", most_points));
    Content next = now_;
    next.points.insert(next.points.begin() + static_cast<std::ptrdiff_t>(at), point_of(pose_at(share)));
    next.selected = at;
    edit(std::move(next), ground);
}

void Route::replace(std::size_t point, const Pose& pose, const session::Ground& ground) {
    require(point);
    Content next = now_;
    next.points[point] = point_of(pose);
    next.selected = point;
    edit(std::move(next), ground);
}

void Route::remove(std::size_t point, const session::Ground& ground) {
    require(point);
    Content next = now_;
    next.points.erase(next.points.begin() + static_cast<std::ptrdiff_t>(point));
    next.selected.reset();
    if (!next.points.empty()) next.selected = std::min(point, next.points.size() - 1);
    edit(std::move(next), ground);
}

void Route::move(std::size_t point, std::size_t to, const session::Ground& ground) {
    require(point);
    require(to);
    Content next = now_;
    const ControlPoint moved = next.points[point];
    next.points.erase(next.points.begin() + static_cast<std::ptrdiff_t>(point));
    next.points.insert(next.points.begin() + static_cast<std::ptrdiff_t>(to), moved);
    next.selected = to;
    edit(std::move(next), ground);
}

void Route::place(std::size_t point, double x_m, double z_m, bool dragging, const session::Ground& ground,
                  std::optional<double> y_m) {
    require(point);
    if (ignored_ == point) {
        if (!dragging) ignored_.reset();
        return;
    }
    ignored_.reset();
    const bool continues = held_ == point;
    if (!dragging) held_.reset();
    Content next = now_;
    ControlPoint& p = next.points[point];
    const double above_m = p[1] - ground.height_m(p[0], p[2]);
    p[0] = std::clamp(x_m, 0.0, ground.extent_x_m);
    p[2] = std::clamp(z_m, 0.0, ground.extent_z_m);
    const double ground_m = ground.height_m(p[0], p[2]);
    // What was below the ground, on purpose or by another terrain, may stay as deep.
    p[1] = y_m ? std::max(*y_m, ground_m + std::min(above_m, ground.cell_m)) : ground_m + above_m;
    next.selected = point;
    complete(next, ground);
    if (continues)
        now_ = std::move(next);
    else
        take_over(std::move(next));
    if (dragging) held_ = point;
    if (dragging || !continues || now_.points != undo_.back().content.points) return;
    now_ = std::move(undo_.back().content); // it came back to where it began
    now_.selected = point;
    undo_.pop_back();
}

Pose Route::select(std::size_t point) {
    require(point);
    now_.selected = point;
    return pose_of(now_.points[point]);
}

} // namespace fjell::editor
