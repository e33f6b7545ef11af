#include "fjell/view.h"

#include <algorithm>
#include <cmath>

namespace fjell {

double length(Vec3 v) {
    return std::sqrt(dot(v, v));
}

Vec3 normalised(Vec3 v) {
    const double l = length(v);
    return l > 0 ? v * (1 / l) : v;
}

View make_view(Vec3 eye_m, Vec3 forward, Vec3 up, double fov_y_rad, std::uint32_t width_px, std::uint32_t height_px,
               double near_m, double far_m) {
    View view;
    view.eye_m = eye_m;
    view.forward = normalised(forward);
    view.up = normalised(up - view.forward * dot(up, view.forward));
    view.top = std::tan(fov_y_rad / 2);
    view.bottom = -view.top;
    view.right = view.top * width_px / height_px;
    view.left = -view.right;
    view.width_px = width_px;
    view.height_px = height_px;
    view.near_m = near_m;
    view.far_m = far_m;
    return view;
}

namespace {

bool finite(Vec3 v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}
bool unit(Vec3 v) {
    return finite(v) && std::abs(dot(v, v) - 1) < 1e-6;
}

constexpr double farthest_m = 1e8; // as fjell/pack.h limits the terrain's extent
constexpr double widest = 1000;    // a tangent: a twentieth of a degree short of a right angle

bool in_order(double low, double high) {
    return low >= -widest && high <= widest && high - low > 1e-9;
}

} // namespace

Status validate(const View& view) {
    const auto bad = [](const char* field) { return Status{StatusCode::out_of_range, field}; };
    if (!finite(view.eye_m) || length(view.eye_m) > farthest_m) return bad("View::eye_m");
    if (!unit(view.forward)) return bad("View::forward");
    if (!unit(view.up) || std::abs(dot(view.up, view.forward)) > 1e-6) return bad("View::up");
    if (!in_order(view.left, view.right)) return bad("View::left, right");
    if (!in_order(view.bottom, view.top)) return bad("View::bottom, top");
    if (view.width_px < 1 || view.width_px > 65536) return bad("View::width_px");
    if (view.height_px < 1 || view.height_px > 65536) return bad("View::height_px");
    if (!(view.near_m > 0 && view.near_m < view.far_m)) return bad("View::near_m");
    if (!(view.far_m <= 1e9)) return bad("View::far_m");
    if (view.max_error_px != 0 && !(view.max_error_px >= 1e-3 && view.max_error_px <= 1e6))
        return bad("View::max_error_px (0, or 0.001 to 1e6)");
    if (const double lambda = focal_length_px(view); !(lambda > 1e-3 && lambda < 1e9))
        return bad("View::width_px, height_px (pixels a unit of tangent: 1e-3 to 1e9)");
    return {};
}

Frustum make_frustum(const View& view) {
    const Vec3 right = cross(view.forward, view.up);
    // The side plane that leans outwards by t holds dot(right, p) <= t * dot(forward, p); its normal is unit length
    // after division by sqrt(1 + t^2).
    const auto side = [&](Vec3 axis, double t) { return (view.forward * t - axis) * (1 / std::sqrt(1 + t * t)); };
    return {{view.forward, view.forward * -1, side(right * -1, -view.left), side(right, view.right),
             side(view.up * -1, -view.bottom), side(view.up, view.top)},
            {view.near_m, -view.far_m, 0, 0, 0, 0}};
}

// A point in the picture stands at depth * (t, 1), with t = (tx, ty) between the picture's sides and the third axis
// along the view. Let u be the vertical in these axes. A small error e along u moves the point's picture by
//   lambda e / depth |t u_z - u_xy|,
// where its angle is e / (depth sqrt(1 + |t|^2)). So the factor is the product of
//   |t u_z - u_xy| and sqrt(1 + |t|^2),
// both convex in t and so largest in corners of the picture; by Cauchy and Schwarz it is never above 1 / cos^2 of the
// farthest one's angle. A level camera needs only the second: errors are vertical, and it sees those from the side.
// The factor changes as the camera pitches and rolls, which changes every decision; in steps of a half it does so
// seldom.
double corner_factor(const View& view) {
    const double up_x = cross(view.forward, view.up).y, up_y = view.up.y, up_z = view.forward.y;
    double across = 0, far = 0; // squared
    for (const double tx : {view.left, view.right})
        for (const double ty : {view.bottom, view.top}) {
            const double x = tx * up_z - up_x, y = ty * up_z - up_y;
            across = std::max(across, x * x + y * y);
            far = std::max(far, 1 + tx * tx + ty * ty);
        }
    const double factor = std::sqrt(across * far);
    double step = 1;
    while (step < factor && step < far) step *= 1.5;
    return std::min(step, far);
}

} // namespace fjell
