// A camera, and what refinement needs of it.
#pragma once

#include <cstdint>

#include "fjell/export.h"
#include "fjell/status.h"

#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) || __FINITE_MATH_ONLY__ || defined(_M_FP_FAST)
#error "Fjell must be compiled without -ffast-math: it would accept a NaN, and decide otherwise than elsewhere"
#endif

FJELL_API_BEGIN
namespace fjell {

// A place or a direction.
struct Vec3 {
    double x = 0, y = 0, z = 0;
    friend constexpr Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
    friend constexpr Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
    friend constexpr Vec3 operator*(Vec3 a, double f) { return {a.x * f, a.y * f, a.z * f}; }
};
[[nodiscard]] constexpr double dot(Vec3 a, Vec3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
[[nodiscard]] constexpr Vec3 cross(Vec3 a, Vec3 b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
[[nodiscard]] double length(Vec3 v);
[[nodiscard]] Vec3 normalised(Vec3 v); // (0, 0, 0) stays

// The picture's four sides are given by the tangents of their angles from the direction of sight, so that off-centre
// projections exist: a tile of a larger picture, an eye of a headset. Numbers and not angles, because a replay on
// another machine must decide alike, and a tangent may differ there. Orthographic views do not exist: every decision,
// its slack and every bound of a page is a distance to the eye. An eye that is far away comes as near to one as is
// wanted: at n times the terrain's extent the scale differs by 1 / n over the picture.
struct View {
    Vec3 eye_m;             // scene axes: x east, y up, z south
    Vec3 forward{0, 0, -1}; // unit length
    Vec3 up{0, 1, 0};       // unit length, orthogonal to forward
    // Tangents, -1000 to 1000: left < right, bottom < top.
    double left = -0.7363796664410578, right = 0.7363796664410578;
    double bottom = -0.41421356237309503, top = 0.41421356237309503;
    std::uint32_t width_px = 1280, height_px = 720;
    double near_m = 1, far_m = 1e6;
    // The threshold of this view, 0.001 to 1e6; 0: that of the settings (CutSettings, RefineSettings).
    double max_error_px = 0;
};

// Pixels a unit of tangent: height_px / (top - bottom); where pixels are narrower than high, those of the width.
[[nodiscard]] constexpr double focal_length_px(const View& view) {
    const double high = view.height_px / (view.top - view.bottom), wide = view.width_px / (view.right - view.left);
    return wide > high * (1 + 1e-12) ? wide : high; // as square as rounding lets them be: one number, not two
}

// The view's own threshold where it has one, or that of the settings.
[[nodiscard]] constexpr double view_max_error_px(const View& view, double settings_px) {
    return view.max_error_px > 0 ? view.max_error_px : settings_px;
}

// A view with its direction of sight in the middle of the picture and square pixels. Makes forward and up orthonormal,
// keeps forward. forward and up must not be parallel or zero.
// Example:
//     const fjell::View view = fjell::make_view(eye_m, {1, -1, 1}, {0, 1, 0}, 0.8, 1280, 720, 1, 1e5);
[[nodiscard]] View make_view(Vec3 eye_m, Vec3 forward, Vec3 up, double fov_y_rad, std::uint32_t width_px,
                             std::uint32_t height_px, double near_m, double far_m);

// Every number finite, unit and orthogonal vectors, sides in order, 0 < near < far, viewport at least 1x1, error_px in
// its range.
Status validate(const View& view);

// Plane i holds points p with dot(normal, p - eye) >= offset inside. Order: near, far, left, right, bottom, top.
struct Frustum {
    Vec3 normal[6];
    double offset[6];
};
// The six planes of what a view sees.
[[nodiscard]] Frustum make_frustum(const View& view);

// How much larger than its angular measure a vertical error in the image can be: at most 1 / cos^2 of the farthest
// corner's angle, and 1 / cos for a camera that looks level. Changes with pitch and roll, in steps of a half; not with
// heading. At least 1.
[[nodiscard]] double corner_factor(const View& view);

} // namespace fjell
FJELL_API_END
