// Maps as the pack stores them, and functions that decode them. Colour maps are BC1, normal maps BC5, horizon maps
// planes of BC4: blocks of 4 x 4 texels, row by row. Splat maps are not compressed.
//
// BC1 takes 8 bytes a block: two colours of 5-6-5 bits, then 2 bits a texel that choose one of the two or a third
// between them. BC5 takes 16 bytes: twice two values of a byte and 3 bits a texel that choose one of the two or a
// seventh between them. The first half is the east component of the unit normal, the second half the south component. A
// component v is stored as 128 + 127 v, so 128 is exactly 0. Both formats are little-endian, with the north-western
// texel in the lowest bits (OpenGL: EXT_texture_compression_s3tc, ARB_texture_compression_rgtc).
//
// A horizon map is 16 planes of one component each. They lie side by side, 4 x 4, in one picture that is four times as
// wide and high as a plane. Its BC4 blocks are stored row by row, ready for one texture. Plane p is in column p % 4 and
// row p / 4. Planes 0 to 14 say how high the ground rises at azimuth 24 p degrees, clockwise from north: 255 times the
// sine of its elevation, or 0 if nothing rises above the horizontal. Plane 15 is the share of the sky's light that
// arrives, times 255, compared with the same slope in open ground. Beyond a plane's outermost texel centres a texture
// filter would reach into the next plane. So sample between them, in one whole mip at a time, and blend two mips
// yourself, as runtime/gl does.
//
// A splat map says which materials are at a texel, and how much of each shows. A texel has 8 bytes: four times a weight
// and the number of a name in the pack's chunk of layers. Texels are stored row by row. The largest weight comes first;
// unused entries have weight 0 and number 0. Weights add up to 255 where materials cover the ground. They add up to
// less where the colour map shows through. Read as RGBA16UI, a component is number * 256 + weight. Numbers cannot be
// filtered: fetch four texels and mix their weights. 4 x 4 texels take 128 bytes, so sizes are counted in blocks as for
// the other maps.
//
// side: texels a side, a power of two from 4 to 4,096. The functions are pure, thread-safe and O(texels), and allocate
// nothing. Any bytes decode to something. Failure: out_of_range for another side, or for spans of the wrong size; then
// nothing is written.
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
inline constexpr std::size_t horizon_block_bytes = 8 * horizon_planes; // 4 x 4 texels of all planes
inline constexpr std::uint32_t splat_layers = 4, max_splat_names = 16;
inline constexpr std::size_t splat_texel_bytes = 2 * splat_layers, splat_block_bytes = 16 * splat_texel_bytes;
// Blocks of a mip with this many texels a side.
[[nodiscard]] constexpr std::size_t blocks_of(std::uint32_t side) {
    return std::size_t{side / 4} * (side / 4);
}

// blocks: blocks_of(side) * colour_block_bytes. rgb: side * side * 3 bytes, sRGB.
Status decode_colour(std::span<const std::byte> blocks, std::uint32_t side, std::span<std::uint8_t> rgb);
// blocks: blocks_of(side) * normal_block_bytes. xz: side * side * 2 bytes, each 128 + 127 v; 0 counts as 1.
Status decode_normal(std::span<const std::byte> blocks, std::uint32_t side, std::span<std::uint8_t> xz);
// blocks: blocks_of(side) * horizon_block_bytes. codes: side * side * horizon_planes bytes, a texel's planes together.
Status decode_horizon(std::span<const std::byte> blocks, std::uint32_t side, std::span<std::uint8_t> codes);
// The component that a code stands for, -1 to 1.
[[nodiscard]] constexpr float normal_component(std::uint8_t code) {
    return static_cast<float>(code < 1 ? -127 : static_cast<int>(code) - 128) / 127.0f;
}

} // namespace fjell
FJELL_API_END
