// Draws a material: from its recipe's steps, or from images, to texels that repeat on all sides.
//
// Units: metres and linear light. Ownership: plain values. Thread: any, one canvas each. Complexity: O(texels) a step,
// and O(texels covered) for each stone and stroke. Failure: images throw io::Failure (1), which names the file.
#pragma once

#include <cstddef>
#include <vector>

#include "baker/materials/recipe.h"

namespace fjell::baker {

struct Canvas {
    int side = 0; // texels
    float size_m = 1;
    std::vector<float> height; // side * side, metres
    std::vector<float> rgb;    // three a texel

    [[nodiscard]] std::size_t at(int x, int y) const { // wrapped; not below -side
        return static_cast<std::size_t>((y + side) % side) * static_cast<std::size_t>(side) +
               static_cast<std::size_t>((x + side) % side);
    }
};

// The steps, one over the other.
[[nodiscard]] Canvas draw_material(const MaterialRecipe& recipe, int side);
// Stones and strokes, on what is there.
void draw_stones(const MaterialStep& step, std::uint32_t seed, Canvas& canvas);
void draw_strokes(const MaterialStep& step, std::uint32_t seed, Canvas& canvas);
// A colour of the step's list, between its two nearest; t: 0 to 1.
void colour_of(const MaterialStep& step, float t, float (&rgb)[3]);

// A mean over squares of 2 * radius + 1 texels, twice: nearly round. Wraps around. channels: interleaved.
[[nodiscard]] std::vector<float> blurred(const std::vector<float>& from, int side, int channels, int radius);

} // namespace fjell::baker
