// The colours of levels and errors, as eyes without one of the three kinds of cones see them: simulated after Machado,
// Oliveira and Fernandes, A Physiologically-based Model for Simulation of Color Vision Deficiency (2009), table 1,
// severity 1. Differences are CIELAB's of 1976: about 2 can just be seen, side by side.
#include <catch2/catch.hpp>

#include <algorithm>
#include <array>
#include <cmath>

#include "fjell/gl/palette.h"

using namespace fjell;

namespace {

using Linear = std::array<double, 3>;
using Matrix = std::array<Linear, 3>;
constexpr struct {
    const char* name;
    Matrix sees;
} eyes[] = {
    {"all cones", {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}},
    {"protanopia",
     {{{0.152286, 1.052583, -0.204868}, {0.114503, 0.786281, 0.099216}, {-0.003882, -0.048116, 1.051998}}}},
    {"deuteranopia",
     {{{0.367322, 0.860646, -0.227968}, {0.280085, 0.672501, 0.047413}, {-0.011820, 0.042940, 0.968881}}}},
    {"tritanopia",
     {{{1.255528, -0.076749, -0.178779}, {-0.078411, 0.930809, 0.147602}, {0.004733, 0.691367, 0.303900}}}},
};

Linear multiply(const Matrix& m, const Linear& v) {
    Linear r{};
    for (std::size_t i = 0; i < 3; ++i) r[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
    return r;
}

Linear lab(const gl::Rgb8& rgb, const Matrix& sees) {
    Linear linear{};
    for (std::size_t i = 0; i < 3; ++i) linear[i] = gl::to_linear(rgb[i]);
    linear = multiply(sees, linear);
    for (double& c : linear) c = std::clamp(c, 0.0, 1.0);
    constexpr Matrix to_xyz{{{0.4124, 0.3576, 0.1805}, {0.2126, 0.7152, 0.0722}, {0.0193, 0.1192, 0.9505}}};
    Linear xyz = multiply(to_xyz, linear);
    constexpr Linear white{0.95047, 1, 1.08883};
    for (std::size_t i = 0; i < 3; ++i) {
        const double t = xyz[i] / white[i];
        xyz[i] = t > 0.008856 ? std::cbrt(t) : 7.787 * t + 16.0 / 116;
    }
    return {116 * xyz[1] - 16, 500 * (xyz[0] - xyz[1]), 200 * (xyz[1] - xyz[2])};
}

double difference(const gl::Rgb8& a, const gl::Rgb8& b, const Matrix& sees) {
    const Linear p = lab(a, sees), q = lab(b, sees);
    return std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
}

constexpr double at_a_glance = 15; // seven steps that can just be seen

} // namespace

TEST_CASE("neighbouring levels, and levels half a tile's apart, differ at a glance for every kind of colour vision") {
    for (const auto& eye : eyes)
        for (int tile_log2 = 5; tile_log2 <= 12; ++tile_log2)
            for (int a = 0; a <= 2 * tile_log2; ++a)
                for (int b = a + 1; b <= 2 * tile_log2; b += b == a + 1 ? std::max(tile_log2 - 1, 1) : 1) {
                    CAPTURE(eye.name, tile_log2, a, b);
                    CHECK(difference(gl::level_rgb(a, tile_log2), gl::level_rgb(b, tile_log2), eye.sees) > at_a_glance);
                }
}

TEST_CASE(
    "for every kind of colour vision an error's colour tells its share, a broken promise, and where none is known") {
    for (const auto& eye : eyes)
        for (int i = 2; i <= 20; ++i) {
            CAPTURE(eye.name, i);
            const gl::Rgb8 here = gl::error_rgb(i / 20.0);
            CHECK(difference(here, gl::error_rgb(2), eye.sees) > at_a_glance);
            CHECK(difference(here, gl::error_stops[5], eye.sees) > at_a_glance);
            for (int k = i + 6; k <= 20; ++k) // three tenths more
                CHECK(difference(here, gl::error_rgb(k / 20.0), eye.sees) > at_a_glance);
        }
}
