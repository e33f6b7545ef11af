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
[[nodiscard]] Vec3 normalised(Vec3 v); // (0, 0, 0) is returned as it is

// A camera. The four sides of the picture are tangents of angles from the direction of sight. So a projection may be
// off-centre: a part of a larger picture, or an eye of a headset. They are tangents and not angles because a replay on
// another machine must decide alike, and its tan() may differ.
// Orthographic views do not exist, because every decision rests on a distance to the eye. An eye that is far away comes
// close to one: at n times the terrain's extent the scale varies by 1 / n over the picture.
struct View {
    Vec3 eye_m;             // scene axes in metres: x east, y up, z south
    Vec3 forward{0, 0, -1}; // unit length
    Vec3 up{0, 1, 0};       // unit length, orthogonal to forward
    // Tangents, -1000 to 1000: left < right, bottom < top.
    double left = -0.7363796664410578, right = 0.7363796664410578;
    double bottom = -0.41421356237309503, top = 0.41421356237309503;
    std::uint32_t width_px = 1280, height_px = 720;
    double near_m = 1, far_m = 1e6;
    // The threshold of this view in pixels, 0.001 to 1e6; 0: the threshold of the settings (CutSettings,
    // RefineSettings).
    double max_error_px = 0;
};

// The focal length in pixels: height_px / (top - bottom). If pixels are narrower than high, width_px / (right - left).
[[nodiscard]] constexpr double focal_length_px(const View& view) {
    const double high = view.height_px / (view.top - view.bottom), wide = view.width_px / (view.right - view.left);
    return wide > high * (1 + 1e-12) ? wide : high; // within rounding they are square: one number, not two
}

// The view's own threshold if it has one; otherwise that of the settings.
[[nodiscard]] constexpr double view_max_error_px(const View& view, double settings_px) {
    return view.max_error_px > 0 ? view.max_error_px : settings_px;
}

// Makes a view with square pixels whose direction of sight is the middle of the picture. Makes forward and up
// orthonormal; the direction of forward stays. forward and up must not be parallel or zero.
// Example:
//     const fjell::View view = fjell::make_view(eye_m, {1, -1, 1}, {0, 1, 0}, 0.8, 1280, 720, 1, 1e5);
[[nodiscard]] View make_view(Vec3 eye_m, Vec3 forward, Vec3 up, double fov_y_rad, std::uint32_t width_px,
                             std::uint32_t height_px, double near_m, double far_m);

// Whether every number is finite, the vectors are unit and orthogonal, the sides are in order, 0 < near < far, the
// viewport has at least 1 x 1 pixels, and max_error_px is in its range. The Status names the field at fault.
Status validate(const View& view);

// The six planes of a view. Point p is inside plane i if dot(normal[i], p - eye) >= offset[i]. Order: near, far, left,
// right, bottom, top.
struct Frustum {
    Vec3 normal[6];
    double offset[6];
};
// The planes of what a view sees.
[[nodiscard]] Frustum make_frustum(const View& view);

// How much larger a vertical error may be in the picture than as an angle: at most 1 / cos^2 of the angle of the
// farthest corner, and 1 / cos for a camera that looks level. It depends on pitch and roll, in steps of a half, and not
// on heading. At least 1.
[[nodiscard]] double corner_factor(const View& view);

} // namespace fjell
FJELL_API_END
