// Recipes of materials: what a layer of ground looks like from above, as JSON (content/materials, content/README.md).
//
// A recipe is a list of steps that raise and colour a square canvas, one over the other; or three images. Units: metres
// for the tile's side and its relief, shares of the side for what is drawn on it, sRGB 0..255 for colours. Failure:
// io::Failure with exit code 1, one line that names the file, the step and the key.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "baker/materials/pattern.h"

namespace fjell::baker {

enum class Draw : std::uint8_t {
    noise,   // octaves of gradient noise
    cells,   // rounded lumps around scattered points
    plates,  // one level for each of them
    cracks,  // 0 along their borders
    ripples, // waves that noise bends
    stones,  // single stones, rounded or with faces
    strokes  // single blades, needles, twigs and leaves
};

struct MaterialStep {
    Draw draw = Draw::noise;
    NoiseShape noise{}; // its cells serve cells, plates, cracks and ripples too
    float height = 0;   // metres from the lowest to the highest of what is drawn; may be negative
    float warp = 0;     // how far noise displaces it, in shares of the side
    int warp_cells = 4;
    float low = 0, high = 1;        // values below and above are cut off, and what is between is stretched
    float width = 0.1f;             // cracks: in cells; strokes: in shares of the side
    float jitter = 1;               // of the points of cells, plates and cracks
    int count = 0;                  // stones, strokes
    float size[2] = {0.02f, 0.06f}; // stones: radius; strokes: length. Most are small
    float angular = 0;              // stones: 0 pebbles to 1 splinters
    float sink = 0.3f;              // stones: how much of one lies in the ground
    float bend = 0.3f;              // strokes: how much they curve
    float leaf = 0;                 // strokes: 0 a blade, widest at its foot, to 1 a leaf, widest in its middle
    float clump = 0;                // stones, strokes: 0 anywhere to 1 only where noise of `cells` is high
    float opacity = 0;              // of the colours
    std::vector<float> rgb;         // three for a colour, linear light; by the value, or one at random for each element
};

struct MaterialRecipe {
    std::string name;
    float size_m = 2;  // of the tile's side
    float coarse = 12; // a second time, so many times larger: against repetition, and from afar
    float coarse_share = 0.5f;
    float flatten = 0.6f; // how much of what varies over more than a sixth of the tile is taken out
    float cavity = 0.6f;  // how much darker hollows are
    float bump = 1;       // of normals: what stands as steep as a blade of grass would only be black
    std::uint32_t seed = 1;
    std::vector<float> base; // colour under all steps
    std::vector<MaterialStep> steps;
    std::string albedo, normal, height; // images in place of steps: beside the recipe
    float relief_m = 0;                 // of the images
};

// file: its name gives the material's.
[[nodiscard]] MaterialRecipe parse_material(const std::string& text, const std::string& file);
// All recipes (*.json) of a folder, by name; names of images are then paths. A file: that one.
[[nodiscard]] std::vector<MaterialRecipe> read_materials(const std::string& path);

} // namespace fjell::baker
