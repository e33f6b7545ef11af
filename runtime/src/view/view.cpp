#include "fjell/view.h"

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
    view.fov_y_rad = fov_y_rad;
    view.width_px = width_px;
    view.height_px = height_px;
    view.near_m = near_m;
    view.far_m = far_m;
    view.lambda_px = height_px / (2 * std::tan(fov_y_rad / 2));
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

} // namespace

Status validate(const View& view) {
    const auto bad = [](const char* field) { return Status{Code::out_of_range, field}; };
    if (!finite(view.eye_m) || length(view.eye_m) > farthest_m) return bad("View::eye_m");
    if (!unit(view.forward)) return bad("View::forward");
    if (!unit(view.up) || std::abs(dot(view.up, view.forward)) > 1e-6) return bad("View::up");
    if (!(view.fov_y_rad > 1e-4 && view.fov_y_rad < 3.1)) return bad("View::fov_y_rad");
    if (view.width_px < 1 || view.width_px > 65536) return bad("View::width_px");
    if (view.height_px < 1 || view.height_px > 65536) return bad("View::height_px");
    if (!(view.near_m > 0 && view.near_m < view.far_m)) return bad("View::near_m");
    if (!(view.far_m <= 1e9)) return bad("View::far_m");
    if (!(view.lambda_px > 1e-3 && view.lambda_px < 1e9)) return bad("View::lambda_px");
    return {};
}

// tan(fov_y / 2), from the number that is given and not computed: these two decide, and must decide alike everywhere.
static double half_height(const View& view) {
    return view.height_px / (2 * view.lambda_px);
}

Frustum make_frustum(const View& view) {
    const Vec3 right = cross(view.forward, view.up);
    const double ty = half_height(view), tx = ty * view.width_px / view.height_px;
    // The side plane that leans outwards by t holds dot(right, p) <= t * dot(forward, p); its normal is unit length
    // after division by sqrt(1 + t^2).
    const auto side = [&](Vec3 axis, double t) { return (view.forward * t - axis) * (1 / std::sqrt(1 + t * t)); };
    return {{view.forward, view.forward * -1, side(right * -1, tx), side(right, tx), side(view.up * -1, ty),
             side(view.up, ty)},
            {view.near_m, -view.far_m, 0, 0, 0, 0}};
}

double corner_factor(const View& view) {
    const double ty = half_height(view), tx = ty * view.width_px / view.height_px;
    return 1 + tx * tx + ty * ty;
}

} // namespace fjell
