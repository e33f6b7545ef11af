// A vertex in 16 bytes instead of the 28 of MeshVertex and MorphVertex. What does not fit is rounded so that the vertex
// is drawn nearer to its full height than the cut thinks, never farther from it: the error of the cut's report holds.
//
// Thread: any. Allocates nothing, and never fails: what is too large becomes the largest there is.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include <fjell/fjell.h>

namespace vulkan {

struct CompactVertex {
    std::uint16_t column, row;   // the low 16 bits: the shader knows the tile, and so the rest
    float height_m;              // as it is
    std::uint16_t rise;          // a half: from the full height to the flat one, metres; rounded towards 0
    std::uint16_t activated;     // in 64ths of a second on the cut's clock, rounded up; long_active
    std::uint16_t error, radius; // unsigned_half(), metres
};
static_assert(sizeof(CompactVertex) == 16, "CompactVertex is uploaded: change terrain.glsl with it");

inline constexpr std::uint16_t long_active = 0xffff;
inline constexpr float activated_steps_s = 64;     // 65,536 of them are a turn of the cut's clock
inline constexpr float activated_late_s = 0x1p-5f; // a step, and the one that long_active takes
static_assert(fjell::morph_clock_s * activated_steps_s == 65536);
static_assert(fjell::max_tile_log2 < 16, "16 bits tell the columns of a tile apart");

// 5 bits of exponent and 11 of mantissa, rounded up: by a 2048th at most, from 2^-10 to 2^22; less becomes 2^-10.
[[nodiscard]] inline std::uint16_t unsigned_half(float positive) {
    constexpr float least = 0x1p-10f;
    constexpr std::uint32_t least_bits = std::bit_cast<std::uint32_t>(least);
    const std::uint32_t above = std::bit_cast<std::uint32_t>(std::max(positive, least)) - least_bits;
#ifdef PLANT_ROUNDED_DOWN
    return std::uint16_t(std::min(above >> 12, 0xffffu));
#endif
    return std::uint16_t(std::min((above + 0xfff) >> 12, 0xffffu));
}
[[nodiscard]] inline float from_unsigned_half(std::uint16_t half) {
    return std::bit_cast<float>((std::uint32_t{half} << 12) + std::bit_cast<std::uint32_t>(0x1p-10f));
}

// An IEEE half, rounded towards 0: by a 1024th at most; what is smaller than 2^-14 becomes 0. Of a double, which holds
// the difference of two heights: a float might have rounded it up.
[[nodiscard]] inline std::uint16_t half_towards_zero(double value) {
    constexpr std::uint64_t most = 0x7bff, least_bits = std::bit_cast<std::uint64_t>(0x1p-15);
    const std::uint64_t sign = value < 0 ? 0x8000 : 0;
    if (!(std::abs(value) >= 0x1p-14)) return std::uint16_t(sign);
    return std::uint16_t(sign | std::min((std::bit_cast<std::uint64_t>(std::abs(value)) - least_bits) >> 42, most));
}
[[nodiscard]] inline float from_half(std::uint16_t half) {
    const std::uint32_t size = half & 0x7fffu;
    const float value = size == 0 ? 0 : std::bit_cast<float>((size << 13) + std::bit_cast<std::uint32_t>(0x1p-15f));
    return half & 0x8000 ? -value : value;
}

[[nodiscard]] inline CompactVertex compact(const fjell::MeshVertex& vertex, const fjell::MorphVertex& morph) {
    std::uint16_t activated = long_active;
    if (morph.activated_s != fjell::long_active_s) {
        activated = std::uint16_t(std::uint32_t(std::ceil(morph.activated_s * activated_steps_s)));
        if (activated == long_active) activated = 0; // a step later
    }
    return {std::uint16_t(vertex.column),
            std::uint16_t(vertex.row),
            vertex.height_m,
            half_towards_zero(double(morph.flat_m) - double(vertex.height_m)),
            activated,
            unsigned_half(morph.error_m),
            unsigned_half(morph.radius_m)};
}

// So much of the threshold, at most, is a vertex that morphs by distance off on screen. Derivation: rounding moves
// start = radius + error * q_start out by start / 2048 at most, which is start / 2048 / (error * (q_start - q_full)) of
// the way. The height moves by error over the whole way. A metre at distance d is q_full / d thresholds, and d is at
// least radius + error * q_full, which is at least start * q_full / q_start. The product: q_start / (q_start - q_full)
// / 2048. Beside it, a 1024th for the flat height. (An error of less than 2^-10 m may be off by all of it.)
[[nodiscard]] inline double compact_share(const fjell::MorphView& view) {
    return 0x1p-11 * double(view.q_start) / double(view.q_start - view.q_full) + 0x1p-10;
}

} // namespace vulkan
