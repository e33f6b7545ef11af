// Colours of the debug modes, the same for the shader, legends and tests. sRGB.
#pragma once

#include <array>
#include <cstdint>

#include "fjell/export.h"

FJELL_API_BEGIN
namespace fjell::gl {

// A tile of side 2^l cells has triangles of levels 0 (its two base triangles) to 2 l (half a cell).
inline constexpr int max_triangle_levels = 25;

using Rgb8 = std::array<std::uint8_t, 3>;

// level: how often a base triangle was halved, 0..2 * tile_log2; it is the tree level of the vertex that would halve
// the triangle once more. Coarse levels are violet and blue, fine ones orange and red; even levels are bright, odd ones
// dark, so neighbouring levels never look alike. This and error_rgb() can be read with any kind of colour vision.
[[nodiscard]] Rgb8 level_rgb(int level, int tile_log2);

// log2 of a step of geometry, 0 to tile_log2: the colour of the triangles that its centres split, fine steps red.
[[nodiscard]] Rgb8 step_rgb(int step_log2, int tile_log2);

// A mip of a map with that many, counted from the pack's mip 0, which is red; the smallest is violet. Between two mips
// colours blend.
[[nodiscard]] Rgb8 mip_rgb(int mip, int mips);

// A tile by its column and row: one of four hues, no two alike where tiles meet at a border or a corner, and of three
// brightnesses, so that rows and columns can be counted.
[[nodiscard]] Rgb8 tile_rgb(std::uint32_t column, std::uint32_t row);

// An error on screen by its share of what is red: dark blue up to a tenth, then over light blue and yellow to red at 1;
// white above 1, a promise that is broken. Between those colours they blend in linear light.
[[nodiscard]] Rgb8 error_rgb(double share);
// At shares 0.1, 0.4, 0.7 and 1, above 1, and where there is nothing to compare with: holes, and places that are drawn
// finer than the heights that are compared with.
inline constexpr Rgb8 error_stops[6] = {{34, 46, 140}, {70, 160, 225},  {244, 214, 50},
                                        {220, 24, 16}, {255, 255, 255}, {120, 120, 120}};

// Slopes (DrawOptions::slope) from these degrees on, in these colours, of which six parts of ten cover the ground's.
inline constexpr int slope_bands_deg[4] = {15, 25, 35, 45};
inline constexpr Rgb8 slope_rgb[4] = {{251, 217, 101}, {244, 124, 25}, {160, 39, 89}, {39, 9, 79}};

[[nodiscard]] double to_linear(std::uint8_t srgb); // 0 to 1

// Borders on the surface (DrawOptions): of tiles, and of pages of the finest step.
inline constexpr Rgb8 tile_border_rgb{255, 250, 240}, page_border_rgb{90, 220, 255};

} // namespace fjell::gl
FJELL_API_END
