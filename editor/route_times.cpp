// When the editor's camera path passes its points, and how fast it flies between them.
#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "editor/route.h"
#include "editor/strings.h"
#include "fjell/io/failure.h"
#include "flight/path_timing.h"

namespace fjell::editor {

namespace {

using io::Failure;

constexpr double least_apart_s = 1 / poses_a_second; // of what a hand sets
constexpr int way_pieces = 32;                       // of a stretch whose way is measured

} // namespace

double Route::time_of(std::size_t point) const {
    return point < now_.times_s.size() ? now_.times_s[point] : share_of(point) * seconds();
}

void Route::give_times(Content& content) const {
    if (content.points.size() < 2) throw Failure(2, strings::refusals::path_too_short);
    if (!content.times_s.empty()) return;
    const double whole_s = content.seconds > 0 ? content.seconds : seconds();
    for (const double share : content.shares) content.times_s.push_back(share * whole_s);
    content.times_s.back() = whole_s;
}

Route::Range Route::time_range(std::size_t point) const {
    const std::size_t n = now_.points.size();
    if (point == 0 || point >= n) return {};
    const double now_s = time_of(point);
    const Range range{time_of(point - 1) + least_apart_s,
                      point + 1 < n ? time_of(point + 1) - least_apart_s : flight::max_path_seconds};
    return {std::min(range.least, now_s), std::max(range.most, now_s)};
}

void Route::set_time(std::size_t point, double time_s, bool dragging, const flight::Ground& ground) {
    (void)require(point);
    if (point == 0) throw Failure(2, strings::refusals::first_point_time);
    const Range range = time_range(point);
    if (!(time_s >= range.least && time_s <= range.most))
        throw Failure(2, fmt::format(strings::refusals::bad_point_time, point, range.least, range.most));
    Content next = now_;
    give_times(next);
    next.times_s[point] = time_s;
    next.selected = point;
    drag(std::move(next), {Grip::time, point}, dragging, ground);
}

double Route::mean_speed_m_s(std::size_t point) const {
    if (empty() || point + 1 >= now_.points.size()) return 0;
    const double from = share_of(point), step = (share_of(point + 1) - from) / way_pieces;
    double way_m = 0;
    Vec3 at = pose_at(from).position_m;
    for (int i = 1; i <= way_pieces; ++i) {
        const Vec3 next = pose_at(from + i * step).position_m;
        way_m += length(next - at);
        at = next;
    }
    return way_m / std::max(time_of(point + 1) - time_of(point), flight::least_between_times_s);
}

void Route::set_mean_speed(std::size_t point, double m_s, bool dragging, const flight::Ground& ground) {
    (void)require(point);
    if (point + 1 >= now_.points.size()) throw Failure(2, fmt::format(strings::refusals::no_stretch, point));
    const double now_m_s = mean_speed_m_s(point);
    if (!(m_s > 0)) throw Failure(2, strings::refusals::bad_stretch_speed);
    if (!(now_m_s > 0)) throw Failure(2, strings::refusals::stretch_turns_only);
    Content next = now_;
    give_times(next);
    std::vector<double>& t = next.times_s;
    const double lasts_s = t[point + 1] - t[point], later_s = lasts_s * (now_m_s / m_s - 1);
    for (std::size_t i = point + 1; i < t.size(); ++i) t[i] += later_s;
    drag(std::move(next), {Grip::speed, point}, dragging, ground);
}

void Route::set_pace(Pace pace, const flight::Ground& ground) {
    Content next = now_;
    give_times(next);
    const double whole_s = next.times_s.back();
    const flight::CameraPath path = path_of(next, whole_s);
    const auto& kind = std::get<flight::SplinePath>(path.kind);
    const flight::PathTiming timing(kind.spline, kind.times_s, {1, 1, 1});
    const std::size_t last = next.points.size() - 1;
    for (std::size_t i = 1; i < last; ++i) {
        const double way = timing.way_to(i) / timing.way_to(last);
        // The smooth step f^2 (3 - 2 f) turned round.
        next.times_s[i] = whole_s * (pace == Pace::ease ? 0.5 - std::sin(std::asin(1 - 2 * way) / 3) : way);
    }
    next.eases = pace == Pace::ease;
    edit(std::move(next), ground);
}

} // namespace fjell::editor
