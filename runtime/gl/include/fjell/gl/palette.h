// Colours of the debug modes, the same for the shader, legends and tests. sRGB.
#pragma once

#include <array>
#include <cstdint>

#include "fjell/export.h"

FJELL_API_BEGIN
namespace fjell::gl {

// A tile of 2^l cells a side has triangles of levels 0 (its two base triangles) to 2 l (half a cell).
inline constexpr int max_triangle_levels = 25;

using Rgb8 = std::array<std::uint8_t, 3>;

// The colour of a triangle's level. level: how often a base triangle was halved, 0 to 2 * tile_log2. That is the tree
// level of the vertex that would halve the triangle once more. Coarse levels are violet and blue, fine levels orange
// and red. Even levels are bright and odd levels dark, so neighbouring levels differ clearly. These colours and those
// of error_rgb() can be told apart with any kind of colour vision.
[[nodiscard]] Rgb8 level_rgb(int level, int tile_log2);

// The colour of a step of geometry; fine steps are red. It is the colour of the triangles that the step's centres
// split. step_log2: 0 to tile_log2.
[[nodiscard]] Rgb8 step_rgb(int step_log2, int tile_log2);

// The colour of a mip. mips: how many the map has. mip: counted from the pack's mip 0, which is red; the smallest is
// violet. Between two mips the colours blend.
[[nodiscard]] Rgb8 mip_rgb(int mip, int mips);

// The colour of a tile by its column and row. It is one of four hues, of which no two are alike where tiles meet. It
// has one of three brightnesses, so that rows and columns can be counted.
[[nodiscard]] Rgb8 tile_rgb(std::uint32_t column, std::uint32_t row);

// The colour of an error on screen. share: the error divided by the threshold. Dark blue up to a tenth, then over light
// blue and yellow to red at 1. Above 1, where a promise is broken, it is white. The colours blend in linear light.
[[nodiscard]] Rgb8 error_rgb(double share);
// The colours at shares 0.1, 0.4, 0.7 and 1, above 1, and where there is nothing to compare with. That is in holes, and
// where the drawn mesh is finer than the heights that it is compared with.
inline constexpr Rgb8 error_stops[6] = {{34, 46, 140}, {70, 160, 225},  {244, 214, 50},
                                        {220, 24, 16}, {255, 255, 255}, {120, 120, 120}};

// The colours of slopes (DrawOptions::slope) from these degrees on, up to a fifth darker where they face south-east.
inline constexpr int slope_bands_deg[4] = {15, 25, 35, 45};
inline constexpr Rgb8 slope_rgb[4] = {{251, 217, 101}, {244, 124, 25}, {160, 39, 89}, {39, 9, 79}};

[[nodiscard]] double to_linear(std::uint8_t srgb); // 0 to 1

// Borders on the surface (DrawOptions): of tiles, and of pages of the finest step.
inline constexpr Rgb8 tile_border_rgb{255, 250, 240}, page_border_rgb{90, 220, 255};

} // namespace fjell::gl
FJELL_API_END
