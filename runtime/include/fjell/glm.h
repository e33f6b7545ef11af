// For engines that use GLM: the matrices of a View, and conversions. Optional: no other header includes this one, and
// the library does not link GLM.
//
// Axes are those of the scene: x east, y up, z south, metres. A camera looks along -z in its own space. Matrices
// multiply column vectors. All numbers are doubles: subtract the eye before you convert a position to float. Thread:
// any.
#pragma once

#include <optional>

#include <glm/ext/matrix_double4x4.hpp>
#include <glm/ext/matrix_transform.hpp>
#include <glm/ext/vector_double2.hpp>
#include <glm/ext/vector_double3.hpp>
#include <glm/ext/vector_double4.hpp>

#include "fjell/export.h"
#include "fjell/view.h"

FJELL_API_BEGIN
namespace fjell {

[[nodiscard]] inline glm::dvec3 to_glm(const Vec3& v) {
    return {v.x, v.y, v.z};
}
[[nodiscard]] inline Vec3 from_glm(const glm::dvec3& v) {
    return {v.x, v.y, v.z};
}

// From the scene to the camera.
[[nodiscard]] inline glm::dmat4 view_matrix(const View& view) {
    return glm::lookAt(to_glm(view.eye_m), to_glm(view.eye_m + view.forward), to_glm(view.up));
}

// From the camera to clip space with reversed depth: 1 at the near plane, 0 at the far plane. It suits a clip space
// with depths from 0 to 1 (glClipControl(..., GL_ZERO_TO_ONE), Vulkan, Direct3D) and a float depth buffer.
[[nodiscard]] inline glm::dmat4 reversed_projection(const View& view) {
    const double wide = view.right - view.left, high = view.top - view.bottom, range = view.far_m - view.near_m;
    glm::dmat4 m(0.0);
    m[0][0] = 2 / wide;
    m[1][1] = 2 / high;
    m[2][0] = (view.right + view.left) / wide;
    m[2][1] = (view.top + view.bottom) / high;
    m[2][2] = view.near_m / range;
    m[2][3] = -1;
    m[3][2] = view.near_m * view.far_m / range;
    return m;
}

// Where a point appears, in pixels from the upper left corner of the picture. Nothing for a point behind the eye or
// nearer than the near plane.
[[nodiscard]] inline std::optional<glm::dvec2> project(const View& view, const Vec3& point) {
    const glm::dvec4 clip = reversed_projection(view) * (view_matrix(view) * glm::dvec4(to_glm(point), 1.0));
    if (!(clip.w >= view.near_m)) return std::nullopt;
    return glm::dvec2{(1 + clip.x / clip.w) / 2 * view.width_px, (1 - clip.y / clip.w) / 2 * view.height_px};
}

} // namespace fjell
FJELL_API_END
