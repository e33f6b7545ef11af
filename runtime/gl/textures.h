// The pack's colour and normal maps as array textures, one layer a tile, all mips resident.
//
// Internal to runtime/gl. Cost: half a byte a colour texel and 1 a normal texel on the GPU, times 4/3 for the mips.
// Failure: one line that names the chunk or the limit.
#pragma once

#include <cstdint>
#include <string>

#include "fjell/pack.h"
#include "gl/objects.h"

namespace fjell::gl {

struct TerrainTextures {
    Texture colour, normal;  // 0: the pack has none
    std::uint64_t bytes = 0; // on the GPU, about
};

// anisotropy: samples along the steep direction, >= 1; clamped to what the driver offers.
[[nodiscard]] std::string load_textures(const Pack& pack, float anisotropy, TerrainTextures& textures);

// uv of sample i of a tile = i * scale + offset: the first and last texel centre lie on the tile's border.
struct SampleToTexel {
    float scale = 0, offset = 0;
};
[[nodiscard]] SampleToTexel sample_to_texel(std::uint32_t texture_log2, std::uint32_t tile_log2);

} // namespace fjell::gl
