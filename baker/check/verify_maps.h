// Do a pack's maps keep their promises? Decodes every mip of every tile.
#pragma once

#include <cstdint>
#include <string>

#include "fjell/io/pack_file.h"
#include "fjell/pack.h"

namespace fjell::baker {

struct MapsReport {
    std::uint64_t texels = 0, border_texels = 0;
    std::uint64_t border_violations = 0; // neighbours' decoded border texels differ by more than their blocks may
    std::uint64_t mip_violations = 0;    // a texel is no tent over the finer mip, whatever compression did to either
    std::uint64_t weight_violations = 0; // a splat texel whose weights or materials cannot be
    std::uint64_t length_violations = 0; // a normal longer than 1, compression allowed for
    // Of the differences at borders, in codes.
    double colour_border_mean = 0, normal_border_mean = 0, horizon_border_mean = 0;
    std::uint32_t colour_border_most = 0, normal_border_most = 0, horizon_border_most = 0;
    std::string first; // the first violation, in words

    [[nodiscard]] bool ok() const {
        return border_violations + mip_violations + length_violations + weight_violations == 0;
    }
};

// How far from what was compressed a channel's texel may be, in codes, in a block that decodes to a range that wide.
// Normal and horizon: the ends are exact, and six values between them at equal distances; rounded. Colour: the ends
// have 5 or 6 bits (half a step is 4), a third of the way between them lies half-way to the next (1/6), and what the
// block's line through colour space leaves out is at most as wide as the line, or the other axis would have been the
// principal one.
[[nodiscard]] constexpr std::uint32_t normal_tolerance(std::uint32_t range) {
    return range / 14 + 1;
}
[[nodiscard]] constexpr std::uint32_t colour_tolerance(std::uint32_t range) {
    return range + 6;
}

// O(texels); memory: the borders of a row of tiles. Throws Failure for a chunk that cannot be read.
[[nodiscard]] MapsReport check_maps(const Pack& pack); // with its bytes
[[nodiscard]] MapsReport check_maps(const io::PackFile& file);

} // namespace fjell::baker
