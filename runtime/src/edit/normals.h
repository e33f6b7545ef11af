// Texels of normal maps, made from the ground as it is now.
#pragma once

#include <cstddef>
#include <cstdint>

#include "fjell/edit.h"
#include "shared/terrain_data.h"

namespace fjell::edit {

inline constexpr std::int32_t widest_texel = 32;                   // in samples: wider texels stay the pack's
inline constexpr std::int32_t normal_reach = 2 * widest_texel + 2; // samples that a texel may look at
inline constexpr std::int32_t piece_texels = 64;                   // a side that is made at once, at most

// Of a mip, in whole blocks.
struct TexelRect {
    std::int32_t x = 0, y = 0, columns = 0, rows = 0;
    [[nodiscard]] bool empty() const { return columns <= 0 || rows <= 0; }
    [[nodiscard]] std::uint32_t texels() const { return static_cast<std::uint32_t>(columns * rows); }
};
// Texels of a tile's mip, of 2^mip_log2 texels a side, whose normals look at samples of the rectangle. Empty: none
// does, or the texels are too wide.
[[nodiscard]] TexelRect texels_over(const TerrainData& t, std::uint32_t tile, std::uint32_t mip_log2,
                                    const GroundRect& rect);

// How many texels a side a piece of that mip has at most: its ground must have room in the scratch.
[[nodiscard]] std::int32_t most_texels(const TerrainData& t, std::uint32_t mip_log2);

inline constexpr std::int32_t normal_taps = 20; // places that a texel takes, along one axis
// A piece's ground, and its normals summed along rows.
struct NormalScratch {
    static constexpr std::int32_t side = 160;
    float heights_m[side * side];
    float across[2][side][piece_texels];
};
// The blocks (BC5) of a piece, at most most_texels() a side. False: pages are missing, and coarser ground was taken.
[[nodiscard]] bool make_normals(const Terrain& terrain, const TerrainData& t, std::uint32_t tile,
                                std::uint32_t mip_log2, const TexelRect& piece, NormalScratch& scratch,
                                std::byte* blocks);

} // namespace fjell::edit
