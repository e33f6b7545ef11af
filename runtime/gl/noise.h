// Fine noise as a tile that repeats: what near ground and water are roughened with.
//
// Only frequencies from 8 periods a side up, so that no blob gives the repetition away and mips fade to nothing.
// Internal to runtime/gl.
#pragma once

#include <cstdint>
#include <vector>

namespace fjell::gl {

inline constexpr int noise_side = 256, noise_mips = 7; // down to 4 texels: the mean

// RGBA8, all mips one after the other: slope along u and v (128 + 127 * 0.5 * slope, height in texels over 8), height,
// and a height with ridges. Always the same.
[[nodiscard]] std::vector<std::uint8_t> make_noise();

} // namespace fjell::gl
