// The points of the editor's camera path: what an edit is, its steps back and forward, and points that come, go and
// change places.
#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "editor/edit_stamp.h"
#include "editor/route.h"
#include "editor/route_parts.h"
#include "editor/strings.h"
#include "fjell/io/failure.h"
#include "flight/path_timing.h"

namespace fjell::editor {

namespace route_parts {

using flight::ControlPoint;
using flight::Pose;
using io::Failure;

ControlPoint point_of(const Pose& p) {
    return flight::unit_point({p.position_m.x, p.position_m.y, p.position_m.z, p.direction.x, p.direction.y,
                               p.direction.z, p.up.x, p.up.y, p.up.z});
}

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
        sum += length(Vec3{points[i][0], points[i][1], points[i][2]} -
                      Vec3{points[i - 1][0], points[i - 1][1], points[i - 1][2]});
    return sum;
}

void require_apart(std::span<const double> times_s) {
    if (flight::first_bad_time(times_s))
        throw Failure(2, fmt::format(strings::refusals::points_too_close, flight::least_between_times_s));
    if (!times_s.empty() && times_s.back() > flight::max_path_seconds)
        throw Failure(2, fmt::format(strings::refusals::path_too_long, flight::max_path_seconds));
}

std::size_t frames_for(double seconds) {
    return std::max<std::size_t>(static_cast<std::size_t>(std::lround(seconds * poses_a_second)), 2);
}

ControlPoint looking(const Vec3& from, const Vec3& at) {
    const Vec3 direction = normalised(at - from);
    const Vec3 right = cross(direction, {0, 1, 0});
    if (length(direction) < 0.5 || length(right) < 1e-3) throw Failure(2, strings::refusals::target_below_point);
    const Vec3 up = normalised(cross(normalised(right), direction));
    return flight::unit_point({from.x, from.y, from.z, direction.x, direction.y, direction.z, up.x, up.y, up.z});
}

} // namespace route_parts

namespace {

using flight::CameraPath;
using flight::ControlPoint;
using flight::Pose;
using io::Failure;

constexpr std::size_t most_path_steps = 100, most_path_bytes = std::size_t{64} << 20;

Pose pose_of(const ControlPoint& p) {
    const Vec3 direction = normalised(Vec3{p[3], p[4], p[5]}), up{p[6], p[7], p[8]};
    return {{p[0], p[1], p[2]}, direction, normalised(up - direction * dot(up, direction))};
}

// Of a list with an entry for each point, or none at all.
template <typename T>
void erase_at(std::vector<T>& list, std::size_t at) {
    if (!list.empty()) list.erase(list.begin() + static_cast<std::ptrdiff_t>(at));
}
template <typename T>
void insert_at(std::vector<T>& list, std::size_t at, const T& value) {
    if (!list.empty()) list.insert(list.begin() + static_cast<std::ptrdiff_t>(at), value);
}
// So that its point-th becomes the to-th.
template <typename T>
void rotate_to(std::vector<T>& list, std::size_t point, std::size_t to) {
    if (list.empty()) return;
    const auto at = [&](std::size_t i) { return list.begin() + static_cast<std::ptrdiff_t>(i); };
    if (point < to)
        std::rotate(at(point), at(point + 1), at(to + 1));
    else
        std::rotate(at(to), at(point), at(point + 1));
}

bool same_target(const std::optional<Vec3>& a, const std::optional<Vec3>& b) {
    return a.has_value() == b.has_value() && (!a || length(*a - *b) == 0);
}

} // namespace

CameraPath Route::path_of(const Content& content, double seconds) {
    CameraPath path;
    path.name = strings::steps::camera_path;
    path.seconds = seconds;
    std::vector<double> knots = flight::chord_knots(content.points, path.name);
    path.kind = flight::SplinePath{flight::CubicSpline<9>(std::move(knots), content.points, content.closed),
                                   content.times_s, content.eases, content.targets};
    return path;
}

void Route::complete(Content& next, const flight::Ground& ground) {
    if (next.closed) {
        next.points.back() = next.points.front();
        if (!next.targets.empty()) next.targets.back() = next.targets.front();
    }
    if (std::ranges::none_of(next.targets, [](const auto& target) { return target.has_value(); })) next.targets.clear();
    for (std::size_t i = 0; i < next.targets.size(); ++i) {
        const ControlPoint& p = next.points[i];
        if (next.targets[i]) next.points[i] = route_parts::looking({p[0], p[1], p[2]}, *next.targets[i]);
    }
    if (std::ranges::adjacent_find(next.points, route_parts::same_place) != next.points.end())
        throw Failure(2, strings::refusals::same_pose);
    route_parts::require_apart(next.times_s);
    next.eases = next.eases && !next.times_s.empty();
    if (!next.times_s.empty()) next.seconds = next.times_s.back();
    next.poses.clear();
    next.shares.clear();
    next.as_read.reset();
    next.unsaved = !next.points.empty() || !next.path.empty();
    if (next.points.size() < 2) return;
    const double cruising_m_s = ground.longer_m() / 60;
    const double seconds =
        next.seconds > 0 ? next.seconds
                         : std::clamp(route_parts::length_m(next.points) / cruising_m_s, 2.0, flight::max_path_seconds);
    const CameraPath path = path_of(next, seconds);
    next.poses = flight::resample(path, ground, route_parts::frames_for(seconds));
    next.shares = flight::shares(std::get<flight::SplinePath>(path.kind));
}

void Route::edit(Content next, const flight::Ground& ground) {
    complete(next, ground);
    take_over(std::move(next));
    if (empty()) playing_ = false;
}

void Route::drag(Content next, const Held& held, bool dragging, const flight::Ground& ground) {
    if (ignored_ == held) {
        if (!dragging) ignored_.reset();
        return;
    }
    ignored_.reset();
    const bool continues = held_ == held;
    const double seconds_before = seconds();
    if (!dragging) held_.reset();
    complete(next, ground);
    if (continues)
        now_ = std::move(next);
    else
        take_over(std::move(next));
    if (dragging) held_ = held;
    if (held.grip != Grip::place) keep_time(seconds_before);
    if (dragging || !continues) return;
    const Content& before = undo_.back().content;
    if (now_.points != before.points || now_.times_s != before.times_s) return;
    const std::optional<std::size_t> selected = now_.selected; // it came back to where it began
    now_ = std::move(undo_.back().content);
    now_.selected = selected;
    undo_.pop_back();
}

void Route::keep_time(double seconds_before) {
    share_ = empty() ? 0 : std::min(share_ * seconds_before / seconds(), 1.0);
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
    exchange(undo_, redo_, strings::refusals::no_earlier_path);
}

void Route::redo() {
    exchange(redo_, undo_, strings::refusals::no_later_path);
}

void Route::restore() {
    redo_.empty() ? undo() : redo();
}

std::size_t Route::require(std::size_t point) const {
    if (point >= now_.points.size())
        throw Failure(2, now_.points.empty()
                             ? std::string(strings::refusals::path_without_points)
                             : fmt::format(strings::refusals::no_such_point, point, now_.points.size() - 1));
    return now_.closed && point + 1 == now_.points.size() ? 0 : point;
}

void Route::add(const Pose& pose, const flight::Ground& ground) {
    if (now_.points.size() >= most_points)
        throw Failure(2, fmt::format(strings::refusals::too_many_points, most_points));
    Content next = now_;
    std::size_t at = next.selected ? *next.selected + 1 : next.points.size();
    if (next.closed) at = std::min(at, next.points.size() - 1); // before the closing point
    next.points.insert(next.points.begin() + static_cast<std::ptrdiff_t>(at), route_parts::point_of(pose));
    if (const std::vector<double>& t = next.times_s; !t.empty())
        insert_at(next.times_s, at, at < t.size() ? (t[at - 1] + t[at]) / 2 : 2 * t[at - 1] - t[at - 2]);
    if (const auto& t = next.targets; !t.empty()) // a stretch that looks at a place goes on doing so
        insert_at(next.targets, at,
                  at > 0 && at < t.size() && same_target(t[at - 1], t[at]) ? t[at] : std::optional<Vec3>());
    next.selected = at;
    edit(std::move(next), ground);
}

void Route::insert(double share, const flight::Ground& ground) {
    if (empty()) throw Failure(2, strings::refusals::no_path);
    const auto later = std::upper_bound(now_.shares.begin(), now_.shares.end(), share);
    const auto at = static_cast<std::size_t>(later - now_.shares.begin());
    const double least = 1 / (poses_a_second * seconds()); // a pose from the points beside it
    if (at == 0 || later == now_.shares.end() || share - now_.shares[at - 1] < least || *later - share < least)
        throw Failure(2, strings::refusals::point_there);
    if (now_.points.size() >= most_points)
        throw Failure(2, fmt::format(strings::refusals::too_many_points, most_points));
    Content next = now_;
    next.points.insert(next.points.begin() + static_cast<std::ptrdiff_t>(at), route_parts::point_of(pose_at(share)));
    insert_at(next.times_s, at, next.times_s.empty() ? 0 : share * next.times_s.back());
    if (const auto& t = next.targets; !t.empty())
        insert_at(next.targets, at, same_target(t[at - 1], t[at]) ? t[at] : std::optional<Vec3>());
    next.selected = at;
    edit(std::move(next), ground);
}

void Route::replace(std::size_t point, const Pose& pose, const flight::Ground& ground) {
    Content next = now_;
    next.points[require(point)] = route_parts::point_of(pose);
    next.selected = point;
    edit(std::move(next), ground);
}

void Route::remove(std::size_t point, const flight::Ground& ground) {
    const std::size_t at = require(point);
    Content next = now_;
    erase_at(next.points, at);
    erase_at(next.targets, at);
    if (std::vector<double>& t = next.times_s; !t.empty()) {
        t.erase(t.begin() + static_cast<std::ptrdiff_t>(at));
        const double first_s = t.front(); // when there were two at least
        for (double& time_s : t) time_s -= first_s;
        if (next.closed) t.back() += first_s; // the way round takes as long as before
        if (t.size() < 2) t.clear();
    }
    if (next.closed && next.points.size() < 3) { // one point, and itself again
        next.points.pop_back();
        if (!next.targets.empty()) next.targets.pop_back();
        next.times_s.clear();
        next.closed = false;
    }
    next.selected.reset();
    if (!next.points.empty()) next.selected = std::min(at, next.points.size() - 1);
    edit(std::move(next), ground);
}

void Route::move(std::size_t point, std::size_t to, const flight::Ground& ground) {
    point = require(point);
    to = require(to);
    Content next = now_; // times stay where they are, and so does a closing point, which is the first then
    rotate_to(next.points, point, to);
    rotate_to(next.targets, point, to);
    next.selected = to;
    edit(std::move(next), ground);
}

Pose Route::select(std::size_t point) {
    (void)require(point);
    now_.selected = point;
    return pose_of(now_.points[point]);
}

} // namespace fjell::editor
