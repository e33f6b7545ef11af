// The one decision everything rests on: does a vertex belong to the mesh at this distance? (invariants 4, 7, 8)
//
// Thesis 5.4.1 with Lindstrom's isotropic distance: epsilon = error * lambda / (distance - radius) >= threshold, turned
// into distance < radius + error * q with q = lambda / threshold, and squared. One fixed float expression, evaluated
// alike by every method; nothing here may be contracted or reassociated.
//
// Why it is safe. Every rounding in d2 and in reach is relative, a few units of 2^-24 of the result, except that the
// eye is rounded to float, which `pad` covers, and that positions are, which the baker put into the leaves' radii.
// `grow` enlarges reach by 2^-20, more than all relative roundings together, so the screen bound holds in exact
// arithmetic. pad and grow are the same for all vertices: nesting (invariant 2, with its margins of mu and of the
// radii) survives them.
#pragma once

#include <cmath>

#include "fjell/view.h"
#include "pack/record.h"

namespace fjell {

struct Reach {
    float eye_x, eye_y, eye_z;
    float q;   // lambda / threshold, pixels over pixels
    float pad; // distance between the eye and its rounding, rounded up
};

inline constexpr float reach_grow = 1.0f + 0x1p-20f;

[[nodiscard]] inline Reach make_reach(const View& view, double threshold_px) {
    Reach r{static_cast<float>(view.eye_m.x), static_cast<float>(view.eye_m.y), static_cast<float>(view.eye_m.z),
            static_cast<float>(lambda_px(view) / threshold_px), 0};
    // Half a unit in the last place of each coordinate, and no more is lost. Not measured: g++ 12 drops the rounding
    // from double(float(x)) where it vectorises, and what is left of the difference is nothing.
    const double largest = std::abs(view.eye_m.x) + std::abs(view.eye_m.y) + std::abs(view.eye_m.z);
    r.pad = static_cast<float>(largest * 0x1p-24) * reach_grow;
    return r;
}

// x2, z2: squared distances from the eye along x and z.
[[nodiscard]] inline bool wanted_at(const Reach& r, float x2, float y, float z2, float error_m, float radius_m) {
    const float dy = y - r.eye_y;
    const float reach = (radius_m + error_m * r.q) * reach_grow + r.pad;
    return x2 + dy * dy + z2 < reach * reach;
}

[[nodiscard]] inline bool wanted(const Reach& r, float x, float y, float z, float error_m, float radius_m) {
    const float dx = x - r.eye_x, dz = z - r.eye_z;
    return wanted_at(r, dx * dx, y, dz * dz, error_m, radius_m);
}

} // namespace fjell
