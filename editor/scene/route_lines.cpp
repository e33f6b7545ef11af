#include "editor/scene/route_lines.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace fjell::editor {

namespace {

constexpr gl::Rgba8 path_rgba{255, 120, 200, 210}, selected_rgba{255, 255, 255, 255}, recorded_rgba{240, 105, 95, 230};
constexpr double point_px = 10, selected_px = 14, apart_px = 16;

Vec3 place_of(const flight::ControlPoint& p) {
    return {p[0], p[1], p[2]};
}

// Through n places, by no more than most_route_pieces straight lines.
template <typename Place>
void add_way(std::size_t n, const Place& place, gl::Rgba8 rgba, std::vector<gl::Line>& to) {
    if (n < 2) return;
    const std::size_t pieces = std::min(n - 1, most_route_pieces);
    Vec3 from = place(0);
    for (std::size_t i = 1; i <= pieces; ++i) {
        const Vec3 next = place(i * (n - 1) / pieces);
        to.push_back({from, next, rgba});
        from = next;
    }
}

// In pixels from the picture's middle; none: behind the eye.
std::optional<std::array<double, 2>> seen_px(const Vec3& place, const View& view) {
    const Vec3 way = place - view.eye_m;
    const double ahead_m = dot(way, view.forward);
    if (ahead_m <= view.near_m) return {};
    const double scale = lambda_px(view) / ahead_m;
    return std::array{dot(way, cross(view.forward, view.up)) * scale, dot(way, view.up) * scale};
}

void add_square(const Vec3& centre, const View& view, double side_px, gl::Rgba8 rgba, std::vector<gl::Line>& to) {
    const double ahead_m = dot(centre - view.eye_m, view.forward);
    if (ahead_m <= view.near_m) return;
    const double half_m = side_px / (2 * lambda_px(view)) * ahead_m;
    const Vec3 up = view.up * half_m, right = cross(view.forward, view.up) * half_m;
    const Vec3 corners[] = {centre - right - up, centre + right - up, centre + right + up, centre - right + up};
    for (std::size_t i = 0; i < 4; ++i) to.push_back({corners[i], corners[(i + 1) % 4], rgba});
}

} // namespace

void add_route_lines(const Route& route, const View& view, std::vector<gl::Line>& to) {
    const auto& poses = route.poses();
    add_way(
        poses.size(), [&](std::size_t i) { return poses[i].position_m; }, path_rgba, to);
    const auto& recorded = route.recorded_points();
    add_way(
        recorded.size(), [&](std::size_t i) { return place_of(recorded[i]); }, recorded_rgba, to);
    const auto& points = route.points();
    const std::size_t step = points.size() / most_route_marks + 1;
    // Squares that would lie over each other are one: those of a path of many points, from afar, would be a bar.
    std::optional<std::array<double, 2>> before;
    for (std::size_t i = 0; i < points.size(); i += step) {
        const auto now = seen_px(place_of(points[i]), view);
        if (!now || route.selected() == i) continue;
        if (before && std::hypot((*now)[0] - (*before)[0], (*now)[1] - (*before)[1]) < apart_px) continue;
        before = now;
        add_square(place_of(points[i]), view, point_px, path_rgba, to);
    }
    if (route.selected()) add_square(place_of(points[*route.selected()]), view, selected_px, selected_rgba, to);
}

} // namespace fjell::editor
