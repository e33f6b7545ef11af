// Is a live cut what it promises to be?
#pragma once

#include <span>
#include <string>
#include <vector>

#include "cut/state.h"
#include "fjell/cut.h"
#include "fjell/io/load.h"
#include "support/mesh_check.h"
#include "support/terrain_fixture.h"
#include "validate.h"

namespace fjell::test {

// A live cut with its group.
struct Cut {
    Cut(const Terrain& terrain, const CutBudget& budget);
    CutReport update(std::span<const View> views, const CutSettings& settings);
    CutReport rebuild(std::span<const View> views, const CutSettings& settings);
    // All tiles, seen or not. Points into this.
    [[nodiscard]] MeshView mesh();
    [[nodiscard]] CutState& state() { return data_of(cut); }
    io::AlignedMemory memory;
    LiveCut cut;
    std::vector<TileRange> ranges;
};
[[nodiscard]] CutBudget ample_cut(const Terrain& terrain, std::uint32_t views = 1);

// Empty when there is none.
[[nodiscard]] std::string in_words(const Violation& found);

// Empty when validate_terrain() and validate_cut() find nothing (validate.h), otherwise what they do.
[[nodiscard]] std::string check_cut(Cut& cut);

// Empty when the mesh is crack-free with holes and all: check_mesh() of what is drawn together with what is hidden, and
// nothing that has a corner in a hole is drawn, nor anything hidden that has none. full: the same terrain, all loaded.
[[nodiscard]] std::string check_surface(Cut& cut, const Terrain& full);

// A set of vertices, row by row of the height scale (Tree::grid_columns()). Corners of tiles count as in.
using VertexSet = std::vector<bool>;
[[nodiscard]] VertexSet active_set(Cut& cut);

// The target of invariant 7, level by level, straight from its definition: wanted by any view, its page loaded, its
// parents in it. full: the same terrain, all loaded; paged: the one whose pages count. error_px: of views without a
// threshold of their own.
[[nodiscard]] VertexSet target_set(const Terrain& full, const Terrain& paged, std::span<const View> views,
                                   double error_px, bool corner_safe = false);
// Views with a threshold of their own: that over the divisor.
[[nodiscard]] std::vector<View> thresholds_over(double divisor, std::span<const View> views);
// Empty when they are equal, otherwise how many vertices `is` has too many and how many it lacks.
[[nodiscard]] std::string difference(const VertexSet& is, const VertexSet& should_be);
[[nodiscard]] bool contains(const VertexSet& larger, const VertexSet& smaller);

} // namespace fjell::test
