// The one decision everything rests on: does a vertex belong to the mesh at this distance? (invariants 4, 7, 8)
//
// Thesis 5.4.1 with Lindstrom's isotropic distance: epsilon = error * lambda / (distance - radius) >= threshold, turned
// into distance < radius + error * q with q = lambda / threshold, and squared. One fixed float expression
// (view/decision-inl.h), compiled for floats here and for vectors in cut/evaluate.cpp; nothing of it may be contracted
// or reassociated.
//
// Why it is safe. Every rounding in d2 and in reach is relative, a few units of 2^-24 of the result, except that the
// eye is rounded to float, which `pad` covers, and that positions are, which the baker put into the leaves' radii.
// `grow` enlarges reach by 2^-20, more than all relative roundings together, so the screen bound holds in exact
// arithmetic. pad and grow are the same for all vertices: nesting (invariant 2, with its margins of mu and of the
// radii) survives them.
#pragma once

#include <cmath>

#include "fjell/view.h"
#include "shared/compiler.h"
#include "shared/record.h"

namespace fjell {

struct Reach {
    float eye_x, eye_y, eye_z;
    float q;   // lambda / threshold, pixels over pixels
    float pad; // distance between the eye and its rounding, rounded up
};

inline constexpr float reach_grow = 1.0f + 0x1p-20f;

[[nodiscard]] inline Reach make_reach(const View& view, double threshold_px) {
    Reach r{static_cast<float>(view.eye_m.x), static_cast<float>(view.eye_m.y), static_cast<float>(view.eye_m.z),
            static_cast<float>(focal_length_px(view) / threshold_px), 0};
    // Half a unit in the last place of each coordinate, and no more is lost. Not measured: g++ 12 drops the rounding
    // from double(float(x)) where it vectorises, and what is left of the difference is nothing.
    const double largest = std::abs(view.eye_m.x) + std::abs(view.eye_m.y) + std::abs(view.eye_m.z);
    r.pad = static_cast<float>(largest * 0x1p-24) * reach_grow;
    return r;
}

inline constexpr float slack_rounding = 0x1p-19f; // share of reach and distance that a slack leaves out

// What the expression is made of, one float at a time.
namespace floats {
struct One {};
inline float Set(One, float x) {
    return x;
}
inline float Add(float a, float b) {
    return a + b;
}
inline float Sub(float a, float b) {
    return a - b;
}
inline float Mul(float a, float b) {
    return a * b;
}
inline float Max(float a, float b) {
    return a < b ? b : a;
}
inline float Abs(float a) {
    return std::abs(a);
}
inline bool Lt(float a, float b) {
    return a < b;
}
inline bool Or(bool a, bool b) {
    return a || b;
}
#include "view/decision-inl.h"
} // namespace floats

// x2, z2: squared distances from the eye along x and z.
[[nodiscard]] inline bool wanted_at(const Reach& r, float x2, float y, float z2, float error_m, float radius_m) {
    return floats::is_within(floats::squared_sum(x2, y - r.eye_y, z2),
                             floats::reach_m(floats::One(), r, error_m, radius_m));
}

[[nodiscard]] inline bool wanted(const Reach& r, float x, float y, float z, float error_m, float radius_m) {
    return floats::is_within(floats::squared_distance(floats::One(), r, x, y, z),
                             floats::reach_m(floats::One(), r, error_m, radius_m));
}

} // namespace fjell
