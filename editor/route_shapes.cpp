// Edits of a camera path that move or turn points: dragged, aimed at a place, laid in a circle.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "editor/route.h"
#include "fjell/io/failure.h"

namespace fjell::editor {

namespace {

using flight::ControlPoint;
using io::Failure;

constexpr std::size_t circle_points = 24;

// From there to that place, upright.
ControlPoint looking(const Vec3& from, const Vec3& at) {
    const Vec3 direction = normalised(at - from);
    const Vec3 right = cross(direction, {0, 1, 0});
    if (length(direction) < 0.5 || length(right) < 1e-3)
        throw Failure(2, "a point lies straight above or below that place; choose another place to look at");
    const Vec3 up = normalised(cross(normalised(right), direction));
    return flight::unit_point({from.x, from.y, from.z, direction.x, direction.y, direction.z, up.x, up.y, up.z});
}

} // namespace

void Route::place(std::size_t point, double x_m, double z_m, bool dragging, const flight::Ground& ground) {
    require(point);
    const bool continues = dragged_ == point;
    dragged_.reset();
    Content next = now_;
    ControlPoint& p = next.points[point];
    const double above_m = p[1] - ground.height_m(p[0], p[2]);
    p[0] = std::clamp(x_m, 0.0, ground.extent_x_m);
    p[2] = std::clamp(z_m, 0.0, ground.extent_z_m);
    p[1] = ground.height_m(p[0], p[2]) + above_m;
    next.selected = point;
    Content before = continues ? std::move(before_) : Content{}; // of the whole drag
    try {
        edit(std::move(next), ground);
    } catch (...) {
        if (continues) before_ = std::move(before);
        throw;
    }
    if (continues) before_ = std::move(before);
    if (dragging) dragged_ = point;
}

void Route::aim(double x_m, double z_m, const flight::Ground& ground) {
    require(0);
    Content next = now_;
    const Vec3 at{x_m, ground.height_m(x_m, z_m), z_m};
    for (ControlPoint& p : next.points) p = looking({p[0], p[1], p[2]}, at);
    edit(std::move(next), ground);
}

void Route::circle(const Vec3& centre_m, const Vec3& from_m, double seconds, double least_above_m,
                   const flight::Ground& ground) {
    if (!(seconds >= 1 && seconds <= flight::max_path_seconds))
        throw Failure(2, fmt::format("a path lasts 1 to {} seconds", flight::max_path_seconds));
    const double east = from_m.x - centre_m.x, south = from_m.z - centre_m.z;
    if (std::hypot(east, south) < 1e-3)
        throw Failure(2, "the camera is straight above what it looks at; look at it from a side first");
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
        next.points.push_back(looking(p, centre_m));
    }
    edit(std::move(next), ground);
    share_ = 0;
}

} // namespace fjell::editor
