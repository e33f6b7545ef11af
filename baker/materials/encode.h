// From drawn materials to the file that a renderer reads (fjell/io/materials.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "baker/materials/recipe.h"
#include "fjell/io/materials.h"

namespace fjell::baker {

// A material's texels before compression, side * side each.
struct MaterialTexels {
    std::uint32_t side = 0;
    io::MaterialRecord record;
    std::vector<float> rgb;    // linear light
    std::vector<float> height; // 0 to 1
    std::vector<float> normal; // along u and v, -1 to 1
};

// Draws or reads a material, flattens it, darkens its hollows and finds its normals. side: a power of two. The same
// recipe gives the same texels, bit for bit, unless it names images, which GDAL reads.
[[nodiscard]] MaterialTexels make_material(const MaterialRecipe& recipe, std::uint32_t side);

// Owns what Materials points into.
struct EncodedMaterials {
    io::Materials materials;
    std::vector<std::byte> colour, normal;
};
// All mips of all materials, of one size. O(texels).
[[nodiscard]] EncodedMaterials encode_materials(const std::vector<MaterialTexels>& texels);

// `fjell-bake materials`: recipes (a folder, or one file) to a file; with a folder for pictures, PNGs to look at too.
void bake_materials(const std::string& recipes, std::uint32_t side, int threads, const std::string& output,
                    const std::string& pictures);

} // namespace fjell::baker
