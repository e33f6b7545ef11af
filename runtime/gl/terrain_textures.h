// Textures that two modes read: the full-resolution heights, and which step of geometry is loaded. Internal to
// runtime/gl. Thread: the context's.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "fjell/gl/renderer.h"
#include "fjell/terrain.h"
#include "gl/objects.h"

namespace fjell::gl {

// The full-resolution heights: what Mode::error compares the drawn surface with. One float a sample, in an array
// texture whose layers are parts of the grid when it is wider than a texture may be; exactly one layer otherwise. Holes
// are stored as a height that none has, because GLSL need not know NaN.
class Heights {
public:
    // Copies. texture_side: as RendererOptions'. When it throws, what was there before is kept.
    void set(const HeightGrid& grid, const Terrain& terrain, std::uint32_t texture_side);
    [[nodiscard]] bool present() const { return texture_.get() != 0; }
    [[nodiscard]] unsigned texture() const { return texture_.get(); }

    std::int32_t columns = 0, rows = 0, step_log2 = 0;
    std::int32_t wide = 0, high = 0; // texels of a layer that are used; layers go row by row

private:
    Texture texture_;
};

// log2 of the finest step of which this place and all coarser pages over it are loaded; tile_log2: the corners alone.
// square_x, square_y: in squares of residency_square_log2() samples, tile-local.
[[nodiscard]] std::uint32_t resident_step_log2(const Terrain& terrain, std::uint32_t tile, std::uint32_t square_x,
                                               std::uint32_t square_y);
[[nodiscard]] std::uint32_t residency_square_log2(const PackHeader& header);

// What the mode of that name draws. Created at its first use and rewritten when pages were loaded or unloaded since, so
// other modes pay nothing. One texel for a square of 64 x 64 samples (a page of the finest step), or for a tile that is
// smaller: 4 KB for 4,097 x 4,097 samples. The context's thread must be the one that loads pages.
class Residency {
public:
    // Brings the texture up to date.
    void follow(const Terrain& terrain);
    [[nodiscard]] unsigned texture() const { return texture_.get(); }
    [[nodiscard]] std::uint64_t updates() const { return updates_; }

private:
    Texture texture_;
    std::vector<std::uint8_t> steps_;
    std::uint64_t changes_ = 0, updates_ = 0;
};

} // namespace fjell::gl
