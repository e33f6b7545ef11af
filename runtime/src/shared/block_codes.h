// Block compression: BC1 for colours, BC5 for normals, BC4 for horizons (fjell/texture.h has the layout and the way
// back).
//
// Written here because libstb's stb_dxt takes 26 and 9 ns a texel where the whole baker may take 20 ns a sample; these
// take the blocks of a row side by side, one a lane (docs/notes/materials.md). Deterministic: additions,
// multiplications and roundings in one order, whatever the lanes.
#pragma once

#include <cstddef>
#include <cstdint>

namespace fjell {

// The nearest whole number of what is not negative. lround() would be a call, where lanes are to be vectors.
template <typename Whole, typename Real>
[[nodiscard]] constexpr Whole nearest(Real value) {
    return static_cast<Whole>(value + Real{1} / 2);
}

// Four rows of texels, planar, to count blocks. rgb: 0..255 (sRGB); rows[y][c]. Error against the block's best line
// through colour space: that of 5-6-5 end points. A block of one colour is off by at most 2 of 255.
struct ColourRows {
    const std::uint8_t* rows[4][3];
};
void encode_bc1(const ColourRows& from, std::size_t blocks, std::byte* to);

// Values 0..255 of the two components. A texel is off by at most 1/14 of its block's range + 1; a constant block is
// exact.
struct NormalRows {
    const std::uint8_t* rows[4][2];
};
void encode_bc5(const NormalRows& from, std::size_t blocks, std::byte* to);

// The same of one component: 8 bytes a block.
void encode_bc4(const std::uint8_t* const (&rows)[4], std::size_t blocks, std::byte* to);

} // namespace fjell
