// Which step of geometry is loaded over each place, as a small texture: what the mode of that name draws.
//
// Created at its first use and rewritten when pages were loaded or unloaded since, so other modes pay nothing. One
// texel for a square of 64 x 64 samples (a page of the finest step), or for a tile that is smaller: 4 KB for 4,097 x
// 4,097 samples. Internal to runtime/gl. Thread: the context's, which must be the one that loads pages.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "fjell/terrain.h"
#include "gl/objects.h"

namespace fjell::gl {

// log2 of the finest step of which this place and all coarser pages over it are loaded; tile_log2: the corners alone.
// square_x, square_y: in squares of residency_square_log2() samples, tile-local.
[[nodiscard]] std::uint32_t resident_step_log2(const Terrain& terrain, std::uint32_t tile, std::uint32_t square_x,
                                               std::uint32_t square_y);
[[nodiscard]] std::uint32_t residency_square_log2(const PackHeader& header);

class Residency {
public:
    // Brings the texture up to date. Empty, or one line.
    [[nodiscard]] std::string follow(const Terrain& terrain);
    [[nodiscard]] unsigned texture() const { return texture_.get(); }
    [[nodiscard]] std::uint64_t updates() const { return updates_; }

private:
    Texture texture_;
    std::vector<std::uint8_t> steps_;
    std::uint64_t changes_ = 0, updates_ = 0;
};

} // namespace fjell::gl
