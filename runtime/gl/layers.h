// Detail layers on the GPU: the textures of their materials, and the table of their rules.
//
// Internal to runtime/gl. Made by Renderer::set_layers(). Memory: 2 bytes a texel of each material, times 4/3; 6 where
// the driver has no GPU or no S3TC, as blocks are dear to decode there.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "fjell/gl/layers.h"
#include "fjell/io/materials.h"
#include "gl/objects.h"

namespace fjell::gl {

inline constexpr unsigned material_unit = 18, material_normal_unit = 19; // behind the noise
inline constexpr unsigned layers_binding = 1;                            // of the block `Layers`

// Metres after which every material's texture is back at its beginning: places are counted from multiples of it, so
// floats keep tenths of a millimetre wherever the eye is.
inline constexpr double layer_period_m = 1024;

// As shaders read a rule; mirrors shaders_layers.cpp.
struct RuleBlock {
    float height[4], slope[4], noise[4]; // where it begins, 1 / over what, where it ends, 1 / over what
    float how[4];                        // material, opacity; displaced by metres and degrees a unit of noise
    float noises[4];                     // shares of patches and spots
};
struct LayersBlock {
    float turn[io::max_materials][4]; // a fine and a coarse texture's periods, east and south
    float mean[io::max_materials][4]; // linear rgb; share of the coarse texture
    RuleBlock rule[max_layer_rules];
    std::int32_t count[4];                   // of rules; the splat maps' name that is water
    std::int32_t of_name[io::max_materials]; // the material of each of the splat maps' names; -1: water
};
static_assert(sizeof(LayersBlock) == (2 * io::max_materials + 5 * max_layer_rules + 1) * 16 + 4 * io::max_materials,
              "LayersBlock is uploaded: change the block `Layers` in shaders_layers.cpp with it");

// Periods in layer_period_m of a material's fine and coarse texture, east and south. number: of the material.
[[nodiscard]] std::array<float, 4> turns_of(const io::MaterialRecord& record, std::size_t number);

// A mip of one material as texels: RGBA, sRGB and the height; or two components of the normal.
[[nodiscard]] std::vector<std::uint8_t> decode_material(bool colour, const std::byte* blocks, std::uint32_t side);

struct LayersInput {
    const io::Materials& materials;
    std::span<const LayerRule> rules;
    std::span<const std::string> names; // of splat maps
};

// Empty, or why these cannot be drawn: of_name[i] is the material of names[i], -1 for water.
void check_layers(const LayersInput& in, std::int32_t (&of_name)[io::max_materials]);

struct Layers {
    Texture colour, normal;
    Buffer table;
    std::uint64_t bytes = 0; // of the textures
    std::size_t rules = 0, names = 0;
    bool lakes = false; // whether one of the names is water

    [[nodiscard]] bool present() const { return table.get() != 0; }
    // most_bytes: finest mips are left out until the textures fit.
    void set(const LayersInput& in, std::uint64_t most_bytes, float anisotropy, bool software);
    void bind() const;
};

} // namespace fjell::gl
