#include "editor/scene/route_lines.h"

#include <algorithm>
#include <cmath>

namespace fjell::editor {

namespace {

constexpr gl::Rgba8 path_rgba{255, 120, 200, 210}, selected_rgba{255, 255, 255, 255}, recorded_rgba{240, 105, 95, 230};
constexpr double point_px = 10, selected_px = 14;

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
    for (std::size_t i = 0; i < points.size(); i += step)
        if (route.selected() != i) add_square(place_of(points[i]), view, point_px, path_rgba, to);
    if (route.selected()) add_square(place_of(points[*route.selected()]), view, selected_px, selected_rgba, to);
}

} // namespace fjell::editor
