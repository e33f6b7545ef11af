// Patterns that repeat: noise, cells and waves over the unit square, whose right edge goes on at the left one.
//
// Values are functions of the place and the seed: + - * / and sqrt on floats and integer hashes, so the same
// everywhere. u and v: any number, 1 a period. Thread: any. Failure: none; counts must be at least 1.
#pragma once

#include <cstdint>

namespace fjell::baker {

// Of a point of a lattice; also of what synth scatters over the terrain.
[[nodiscard]] inline std::uint32_t salted_bits(std::uint32_t x, std::uint32_t y, std::uint32_t salt) {
    std::uint32_t h = x * 0x9e3779b1u ^ y * 0x85ebca77u ^ salt;
    h = (h ^ h >> 15) * 0x2c1b3c6du;
    h = (h ^ h >> 12) * 0x297a2d39u;
    return h ^ h >> 15;
}
[[nodiscard]] inline std::uint32_t mix_bits(std::uint32_t x, std::uint32_t y, std::uint32_t seed) {
    return salted_bits(x, y, seed * 0xc2b2ae3du);
}
// 0 to 1.
[[nodiscard]] inline float unit_of(std::uint32_t bits) {
    return static_cast<float>(bits >> 8) * (1.0f / 16777216.0f);
}
// v less its whole part, 0 to 1.
[[nodiscard]] float fraction(float v);
[[nodiscard]] float smooth_step(float from, float to, float v);

enum class NoiseForm : std::uint8_t { soft, ridged, billow };

struct NoiseShape {
    NoiseForm form = NoiseForm::soft;
    int cells[2] = {4, 4}; // of the coarsest octave, each way
    int octaves = 5;
    float gain = 0.5f; // of an octave against the one before, which is half as fine
    std::uint32_t seed = 0;
};
// Gradient noise (K. Perlin, Improving Noise, 2002), octave by octave: 0 to 1, 0.5 in the middle of soft noise.
[[nodiscard]] float noise_at(const NoiseShape& shape, float u, float v);

// The two nearest of one jittered point a cell (S. Worley, A Cellular Texture Basis Function, 1996), in cells.
struct NearPoints {
    float first = 0, second = 0; // distances
    float value = 0;             // 0 to 1, of the nearest
};
[[nodiscard]] NearPoints near_points(const int (&cells)[2], float jitter, std::uint32_t seed, float u, float v);

} // namespace fjell::baker
