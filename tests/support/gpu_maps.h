// Maps as a host keeps them for a stream, after its commands and patches.
#pragma once

#include <catch2/catch.hpp>

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "fjell/ground_maps.h"
#include "fjell/stream.h"
#include "fjell/texture.h"

namespace fjell::test {

using Blocks = std::vector<std::byte>;

// What a host's GPU holds: blocks of each layer's mips.
struct Gpu {
    static std::size_t bytes_of(MapKind map) { // of 4 x 4 texels
        return map == MapKind::splat     ? splat_block_bytes
               : map == MapKind::normal  ? normal_block_bytes
               : map == MapKind::horizon ? horizon_block_bytes
                                         : colour_block_bytes;
    }
    std::map<std::array<std::uint32_t, 4>, Blocks> at; // kind, size, layer, mip
    std::uint64_t patches = 0;

    void carry_out(const MapCommand& c) {
        const auto kind = static_cast<std::uint32_t>(c.map);
        const std::uint32_t common = std::min<std::uint32_t>(c.side_log2, c.from_log2);
        for (std::uint32_t mip = 0; c.from_log2 != 0 && mip < mip_count(common); ++mip)
            at[{kind, c.side_log2, c.layer, c.side_log2 - common + mip}] =
                at[{kind, c.from_log2, c.from_layer, c.from_log2 - common + mip}];
        std::span<const std::byte> blocks = c.blocks;
        for (std::uint32_t mip = 0; mip < c.upload_mips; ++mip) {
            const std::size_t bytes = blocks_of(1u << (c.side_log2 - mip)) * bytes_of(c.map);
            at[{kind, c.side_log2, c.layer, mip}].assign(blocks.begin(),
                                                         blocks.begin() + static_cast<std::ptrdiff_t>(bytes));
            blocks = blocks.subspan(bytes);
        }
    }
    void put(const MapPatch& p) {
        if (p.map == MapKind::normal) return;
        ++patches;
        Blocks& to = at.at({static_cast<std::uint32_t>(p.map), p.side_log2, p.layer, p.mip});
        const bool splat = p.map == MapKind::splat;
        const std::uint32_t planes = p.map == MapKind::horizon ? horizon_planes_across : 1;
        const std::uint32_t step = splat ? 1 : 4, cell = 8, side = planes * (1u << (p.side_log2 - p.mip)) / step;
        REQUIRE((p.x % 4 == 0 && p.y % 4 == 0 && p.columns % 4 == 0 && p.rows % 4 == 0));
        REQUIRE(p.blocks.size() == std::size_t{p.columns / step} * (p.rows / step) * cell);
        const std::byte* from = p.blocks.data();
        for (std::uint32_t y = p.y / step; y < (p.y + p.rows) / step; ++y, from += p.columns / step * cell)
            std::copy_n(from, p.columns / step * cell, to.begin() + (y * side + p.x / step) * cell);
    }
};

} // namespace fjell::test
