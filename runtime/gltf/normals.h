// What textures of a tile are made of beside its maps: the normal texture, which turns the mesh' interpolated normals
// into the baked ones, and the ground at each texel.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gltf/geometry.h"

namespace fjell::gltf {

// baked: BC5 decoded, baked_px texels a side (fjell/texture.h). geometry: after set_texture_size(..., texture_px).
// Returns texture_px * texture_px RGB texels: the baked normal in the frame that glTF interpolates from the vertices'
// normals and tangents; what changes nothing where triangles are smaller than texels, or where there are none. Both
// maps have their outer texel centres on the tile's border. O(texels * triangles that touch each).
[[nodiscard]] std::vector<std::uint8_t> normal_texture(const TileGeometry& geometry, std::uint32_t texture_px,
                                                       std::span<const std::uint8_t> baked, std::uint32_t baked_px);

// Of the mesh at each texel, 0 where there is none; the slope is the baked normal's where baked_px is not 0.
struct TexelGround {
    std::vector<float> height_m, slope_deg;
};
[[nodiscard]] TexelGround ground_of_texels(const TileGeometry& geometry, std::uint32_t texture_px,
                                           std::span<const std::uint8_t> baked, std::uint32_t baked_px);

} // namespace fjell::gltf
