// The strongest recursive yardstick: Lindstrom and Pascucci's refinement over interleaved quad trees with ghost
// vertices ("Visualization of Large Terrains Made Easy", 2001; "Terrain Simplification Simplified", 2002; thesis 4.1),
// fed with a pack's own errors and radii and made as fast as we can. It has no tiles, pages, holes or budgets: 20 bytes
// a vertex, one strip of indices a frame, and the frustum is not asked again below a sphere that lies inside it.
//
// What it selects is what RecursiveMethod selects, and the triangles are the same where every tile is split.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "fjell/terrain.h"
#include "fjell/view.h"

namespace fjell::bench {

struct LeanVertex {
    float x_m, y_m, z_m;
    float error_m, radius_m; // infinite where the vertex is always in the mesh, as tile corners are
};
static_assert(sizeof(LeanVertex) == 20);

class LeanRecursion {
public:
    // Copies what it needs. terrain: whole, without holes, a square of 2^n + 1 samples a side, and of whole tiles.
    // strip: indices that a frame may take.
    LeanRecursion(const Terrain& terrain, std::size_t strip);

    struct Frame {
        std::uint32_t triangles = 0; // that have an area
        bool whole = true;           // false: the strip was too short, and is not usable
    };
    [[nodiscard]] Frame refine(const View& view, double error_px, bool cull);

    [[nodiscard]] std::span<const std::uint32_t> strip() const { return {strip_.data() + 1, strip_count_}; }
    [[nodiscard]] const LeanVertex& vertex(std::uint32_t index) const { return vertices_[index]; }
    [[nodiscard]] std::size_t bytes() const { return vertices_.size() * sizeof(LeanVertex); }

private:
    std::vector<LeanVertex> vertices_; // a third of them ghosts
    std::vector<std::uint32_t> strip_; // one in front, which the first vertex is compared with
    std::size_t strip_count_ = 0;
    int levels_;
};

} // namespace fjell::bench
