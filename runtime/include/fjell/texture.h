// Maps as the pack stores them: BC1 (colour) and BC5 (normals), 4 x 4 texels a block, row by row; and the way back.
//
// BC1, 8 bytes: two colours of 5-6-5 bits, then 2 bits a texel that choose them or a third between. BC5, 16 bytes:
// twice two bytes and 3 bits a texel that choose them or a seventh between; first the east, then the south component of
// the unit normal, as 128 + 127 v, so that 128 is exactly 0. Both little-endian, the texel in the north-west in the
// lowest bits (OpenGL: EXT_texture_compression_s3tc, ARB_texture_compression_rgtc).
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
// Blocks of a mip with that many texels a side.
[[nodiscard]] constexpr std::size_t blocks_of(std::uint32_t side) {
    return std::size_t{side / 4} * (side / 4);
}

// blocks: blocks_of(side) * colour_block_bytes. rgb: side * side * 3 bytes, sRGB.
Status decode_colour(std::span<const std::byte> blocks, std::uint32_t side, std::span<std::uint8_t> rgb);
// blocks: blocks_of(side) * normal_block_bytes. xz: side * side * 2 bytes, each 128 + 127 v; 0 counts as 1.
Status decode_normal(std::span<const std::byte> blocks, std::uint32_t side, std::span<std::uint8_t> xz);
// -1 to 1.
[[nodiscard]] constexpr float normal_component(std::uint8_t code) {
    return static_cast<float>(code < 1 ? -127 : static_cast<int>(code) - 128) / 127.0f;
}

} // namespace fjell
FJELL_API_END
