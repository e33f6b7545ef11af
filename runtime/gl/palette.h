// Colours for tree levels, the same for the shader, legends and tests.
#pragma once

#include <array>
#include <cstdint>

namespace fjell::gl {

// A tile of side 2^l cells has triangles of levels 0 (its two base triangles) to 2 l (half a cell).
inline constexpr int max_triangle_levels = 25;

using Rgb8 = std::array<std::uint8_t, 3>;

// level: how often a base triangle was halved, 0..2 * tile_log2; it is the tree level of the vertex that would halve
// the triangle once more. Coarse levels are violet and blue, fine ones orange and red; even levels are bright, odd ones
// dark, so neighbouring levels never look alike. sRGB.
[[nodiscard]] Rgb8 level_rgb(int level, int tile_log2);

} // namespace fjell::gl
