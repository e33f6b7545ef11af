// Blocks and vertices (Lindstrom and others, "Real-Time, Continuous Level of Detail Rendering of Height Fields", 1996):
// a vertex is in the mesh while its delta segment, the vertical way that it would fall onto the edge it splits, is
// longer on screen than the threshold; then those it depends on are too.
//
// As in the paper: the projection of a vertical segment (equation 3 there: shorter from above), an interval of deltas a
// block that decides most vertices without projecting them, blocks that are dropped whole, and the dependencies of the
// vertex tree. Otherwise: the mesh is found anew every frame, from the coarsest blocks down, and a block is what one
// step has in 8 x 8 squares, where the paper keeps blocks from frame to frame; triangles are emitted as a list by
// bisection. Blocks that no view sees are left out.
//
// The paper has the threshold bound the error of the picture. A delta is what one vertex moves, though: where many are
// left out, one over the other, their ways add up, and nothing adds them (docs/experiments.md has the case).
// Complexity: O(vertices of blocks that may hold one + triangles).
#pragma once

#include <vector>

#include "rivals/diamond_mesh.h"
#include "rivals/rival.h"
#include "rivals/step_blocks.h"

namespace fjell::rivals {

class BlocksAndVertices final : public Rival {
public:
    explicit BlocksAndVertices(const Ground& ground); // keeps a reference
    [[nodiscard]] Refined refine(const View& view, double error_px, std::uint32_t operations) override;
    void faces(std::vector<Face>& out) const override { faces_of(ground_, {indices_.data(), count_}, out); }
    [[nodiscard]] std::size_t bytes() const override;
    [[nodiscard]] Traits traits() const override { return {false, false, true, true}; }
    [[nodiscard]] std::size_t projected() const { return projected_; } // vertices, in the last frame

private:
    struct Block {
        float low_m, high_m, delta_m; // of it and of those below: heights, the longest delta
    };
    struct Pass;
    void visit(const Pass& pass, std::size_t level, std::int32_t bx, std::int32_t by);
    void enable(SampleIndex v);
    void emit(std::uint32_t apex, std::uint32_t left, std::uint32_t right, int levels);

    const Ground& ground_;
    Tree tree_;
    StepBlocks layout_;
    std::vector<Block> blocks_;               // as in layout_
    std::vector<float> deltas_m_, heights_m_; // by place of layout_
    std::vector<std::uint16_t> enabled_;      // by sample: in which frame
    std::uint16_t frame_ = 0;
    std::vector<std::uint32_t> indices_; // as many as any frame has had
    std::size_t count_ = 0;              // of this one
    std::size_t projected_ = 0;
};

} // namespace fjell::rivals
