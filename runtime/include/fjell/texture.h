// Maps as the pack stores them: BC1 (colour), BC5 (normals) and planes of BC4 (horizons), 4 x 4 texels a block, row by
// row; and the way back. Splat maps are texels as they are.
//
// BC1, 8 bytes: two colours of 5-6-5 bits, then 2 bits a texel that choose them or a third between. BC5, 16 bytes:
// twice two bytes and 3 bits a texel that choose them or a seventh between; first the east, then the south component of
// the unit normal, as 128 + 127 v, so that 128 is exactly 0. Both little-endian, the texel in the north-west in the
// lowest bits (OpenGL: EXT_texture_compression_s3tc, ARB_texture_compression_rgtc).
//
// A horizon map is 16 planes of one component each, 4 x 4 of them side by side in one picture that is four times as
// wide and high as a plane: BC4 blocks row by row through all of it, ready for one texture. Plane p stands in column
// p % 4 and row p / 4. Planes 0 to 14: how high the ground stands at azimuth 24 p degrees, clockwise from north, as
// 255 times the sine of its elevation; 0 where nothing rises above the level. Plane 15: the share of the sky's light
// that arrives, of what would on the same slope if nothing else stood around it, times 255. At a plane's border a
// filter would reach into the next one: read whole mips, as runtime/gl does.
//
// A splat map says which materials lie at a texel and how much of each shows: 8 bytes, row by row, four times a
// weight and the number of a name in the pack's chunk of layers; the largest weight first, 0 with number 0 where there
// are fewer. Weights add up to 255 where materials cover the ground, to less where some of it stays as its colour map
// is. Read as RGBA16UI a component is its number times 256 and its weight. Numbers cannot be filtered: fetch four
// texels and mix weights. Even 128 bytes for 4 x 4 texels, so sizes are counted as for the others.
//
// side: texels a side, at least 4, a power of two, 4,096 at most. Pure, thread-safe, O(texels), allocates nothing. Any
// bytes decode to something. Failure: out_of_range for another side, or for spans of other sizes; nothing is written.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fjell/export.h"
#include "fjell/status.h"

FJELL_API_BEGIN
namespace fjell {

inline constexpr std::size_t colour_block_bytes = 8, normal_block_bytes = 16;
inline constexpr std::uint32_t horizon_directions = 15, horizon_planes_across = 4;
inline constexpr std::uint32_t horizon_planes = horizon_planes_across * horizon_planes_across;
inline constexpr std::size_t horizon_block_bytes = 8 * horizon_planes; // of 4 x 4 texels, all planes
inline constexpr std::uint32_t splat_layers = 4, max_splat_names = 16;
inline constexpr std::size_t splat_texel_bytes = 2 * splat_layers, splat_block_bytes = 16 * splat_texel_bytes;
// Blocks of a mip with that many texels a side.
[[nodiscard]] constexpr std::size_t blocks_of(std::uint32_t side) {
    return std::size_t{side / 4} * (side / 4);
}

// blocks: blocks_of(side) * colour_block_bytes. rgb: side * side * 3 bytes, sRGB.
Status decode_colour(std::span<const std::byte> blocks, std::uint32_t side, std::span<std::uint8_t> rgb);
// blocks: blocks_of(side) * normal_block_bytes. xz: side * side * 2 bytes, each 128 + 127 v; 0 counts as 1.
Status decode_normal(std::span<const std::byte> blocks, std::uint32_t side, std::span<std::uint8_t> xz);
// blocks: blocks_of(side) * horizon_block_bytes. codes: side * side * horizon_planes bytes, a texel's planes together.
Status decode_horizon(std::span<const std::byte> blocks, std::uint32_t side, std::span<std::uint8_t> codes);
// -1 to 1.
[[nodiscard]] constexpr float normal_component(std::uint8_t code) {
    return static_cast<float>(code < 1 ? -127 : static_cast<int>(code) - 128) / 127.0f;
}

} // namespace fjell
FJELL_API_END
