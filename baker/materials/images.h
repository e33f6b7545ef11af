// Materials from images: a set of textures of the user's own.
#pragma once

#include <vector>

#include "baker/materials/canvas.h"

namespace fjell::baker {

// The recipe's albedo (sRGB) and height (the first band, its range is relief_m) as a canvas of that many texels a side;
// larger images are averaged. normal: two a texel, east and south, of a map whose green points up in the image
// (OpenGL's convention); left empty where the recipe names none. Throws io::Failure 1: no such image, or not square and
// a power of two, or smaller than `side`.
[[nodiscard]] Canvas read_images(const MaterialRecipe& recipe, int side, std::vector<float>& normal);

} // namespace fjell::baker
