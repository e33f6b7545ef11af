// A camera, and what refinement needs of it.
#pragma once

#include <cstdint>

#include "fjell/export.h"
#include "fjell/status.h"

#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) || __FINITE_MATH_ONLY__
#error "Fjell must be compiled without -ffast-math: it would accept a NaN, and decide otherwise than elsewhere"
#endif

FJELL_API_BEGIN
namespace fjell {

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

struct View {
    Vec3 eye_m;             // scene axes: x east, y up, z south
    Vec3 forward{0, 0, -1}; // unit length
    Vec3 up{0, 1, 0};       // unit length, orthogonal to forward
    double fov_y_rad = 0.7853981633974483;
    std::uint32_t width_px = 1280, height_px = 720;
    double near_m = 1, far_m = 1e6;
    // Pixels a unit of tangent: height / (2 tan(fov_y / 2)). Given, not computed in update(), so that a replay on
    // another machine decides alike.
    double lambda_px = 869.1168824543142;
};

// Makes forward and up orthonormal, keeps forward; fills lambda_px. forward and up must not be parallel or zero.
[[nodiscard]] View make_view(Vec3 eye_m, Vec3 forward, Vec3 up, double fov_y_rad, std::uint32_t width_px,
                             std::uint32_t height_px, double near_m, double far_m);

// Every number finite, unit and orthogonal vectors, 0 < fov < pi, 0 < near < far, viewport at least 1x1.
Status validate(const View& view);

// Plane i holds points p with dot(normal, p - eye) >= offset inside. Order: near, far, left, right, bottom, top.
struct Frustum {
    Vec3 normal[6];
    double offset[6];
};
[[nodiscard]] Frustum make_frustum(const View& view);

// How much larger than its angular measure an error at the corner of the image can be: 1 / cos^2 of the half diagonal.
[[nodiscard]] double corner_factor(const View& view);

} // namespace fjell
FJELL_API_END
