// Edits of a camera path that move or turn points: dragged, aimed at a place, closed, laid in a circle.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "editor/route.h"
#include "editor/route_parts.h"
#include "editor/strings.h"
#include "fjell/io/failure.h"

namespace fjell::editor {

namespace {

using flight::ControlPoint;
using io::Failure;

constexpr std::size_t circle_points = 24;

} // namespace

void Route::place(std::size_t point, double x_m, double z_m, bool dragging, const flight::Ground& ground,
                  std::optional<double> y_m) {
    Content next = now_;
    ControlPoint& p = next.points[require(point)];
    const double above_m = p[1] - ground.height_m(p[0], p[2]);
    p[0] = std::clamp(x_m, 0.0, ground.extent_x_m);
    p[2] = std::clamp(z_m, 0.0, ground.extent_z_m);
    const double ground_m = ground.height_m(p[0], p[2]);
    // What was below the ground, on purpose or by another terrain, may stay as deep.
    p[1] = y_m ? std::max(*y_m, ground_m + std::min(above_m, ground.cell_m)) : ground_m + above_m;
    next.selected = point;
    drag(std::move(next), {Grip::place, point}, dragging, ground);
}

void Route::aim(double x_m, double z_m, const flight::Ground& ground, std::size_t first, std::size_t last) {
    (void)require(first);
    Content next = now_;
    next.targets.resize(next.points.size());
    last = std::min(last, next.points.size() - 1);
    const Vec3 target{x_m, ground.height_m(x_m, z_m), z_m};
    for (std::size_t i = first; i <= last; ++i) next.targets[i] = target;
    if (next.closed && last + 1 == next.points.size()) next.targets.front() = target;
    edit(std::move(next), ground);
}

void Route::free(const flight::Ground& ground, std::size_t first, std::size_t last) {
    (void)require(first);
    if (now_.targets.empty()) throw Failure(2, strings::refusals::no_targets);
    Content next = now_;
    last = std::min(last, next.points.size() - 1);
    for (std::size_t i = first; i <= last; ++i) next.targets[i].reset();
    if (next.closed && last + 1 == next.points.size()) next.targets.front().reset();
    edit(std::move(next), ground);
}

void Route::close(bool on, const flight::Ground& ground) {
    if (on == now_.closed) return;
    Content next = now_;
    if (!on) {
        next.points.pop_back();
        if (!next.targets.empty()) next.targets.pop_back();
        if (!next.times_s.empty()) next.times_s.pop_back();
        if (next.selected == next.points.size()) next.selected = 0;
    } else if (next.points.size() < 2) {
        throw Failure(2, strings::refusals::closed_path_too_short);
    } else if (!route_parts::same_place(next.points.front(), next.points.back())) {
        const std::vector<double>& t = next.times_s;
        const double before_m = route_parts::length_m(next.points);
        next.points.push_back(next.points.front());
        if (!next.targets.empty()) next.targets.push_back(next.targets.front());
        // At the mean speed of the others, and of a flight that only turns, as long as one of those takes in the mean.
        if (!t.empty())
            next.times_s.push_back(
                t.back() + t.back() * (before_m > 0 ? std::max(route_parts::length_m(next.points) / before_m - 1, 0.01)
                                                    : 1 / static_cast<double>(t.size() - 1)));
    } else if (next.points.size() < 3) {
        throw Failure(2, strings::refusals::closed_path_too_short);
    }
    next.closed = on;
    edit(std::move(next), ground);
}

void Route::circle(const Vec3& centre_m, const Vec3& from_m, double seconds, double least_above_m,
                   const flight::Ground& ground) {
    if (!(seconds >= 1 && seconds <= flight::max_path_seconds))
        throw Failure(2, fmt::format(strings::refusals::bad_turntable_duration, flight::max_path_seconds));
    const double east = from_m.x - centre_m.x, south = from_m.z - centre_m.z;
    if (std::hypot(east, south) < 1e-3) throw Failure(2, strings::refusals::camera_above_target);
    Content next;
    next.seconds = seconds;
    double highest_m = from_m.y; // a level circle, above every hill on the way
    std::vector<Vec3> places;
    for (std::size_t i = 0; i <= circle_points; ++i) {
        const double angle = 2 * std::numbers::pi * static_cast<double>(i % circle_points) / circle_points;
        const double s = std::sin(angle), c = std::cos(angle);
        places.push_back({centre_m.x + east * c - south * s, 0, centre_m.z + east * s + south * c});
        const double x = std::clamp(places.back().x, 0.0, ground.extent_x_m);
        const double z = std::clamp(places.back().z, 0.0, ground.extent_z_m);
        highest_m = std::max(highest_m, ground.height_m(x, z) + least_above_m);
    }
    for (Vec3& p : places) {
        p.y = highest_m;
        next.points.push_back(route_parts::looking(p, centre_m));
    }
    next.closed = true;
    next.targets.assign(next.points.size(), centre_m);
    edit(std::move(next), ground);
    share_ = 0;
}

} // namespace fjell::editor
