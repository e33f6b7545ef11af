// CDLOD (Strugar, "Continuous Distance-Dependent Level of Detail for Rendering Heightmaps", 2010): what engines ship. A
// quadtree of square patches of one grid; each level of detail has a range around the eye, and in the outer third of
// it the vertex shader moves every odd vertex onto its even neighbour, so that patches of two levels meet on the same
// vertices.
//
// As in the paper: selection by the boxes of nodes against spheres, parts of nodes, culling by node, heights sampled
// between samples where a vertex slides. What the paper leaves to the user is how long ranges are. Here each is so long
// that what it claims keeps to the threshold: where a level is drawn or morphed to, its largest error, anywhere,
// projected from there, is at most that. A level's error is one number for the whole terrain; that is the method. With
// Ranges::whole they are lengthened until the morphs of two neighbouring levels cannot overlap, without which there are
// cracks; the paper asks the user to see to it.
//
// With Ranges::doubling no error is asked for: squares of the next level may be 16 thresholds wide on screen. That is
// how the method is set up where nobody measures errors; it bounds none.
//
// The CPU selects patches; all else is work of the GPU, and in no time here. Complexity: O(patches).
#pragma once

#include <vector>

#include "rivals/rival.h"

namespace fjell::rivals {

class Cdlod final : public Rival {
public:
    enum class Ranges : std::uint8_t {
        whole,   // by the threshold, and so long that there are no cracks
        bound,   // by the threshold alone
        doubling // twice the one before, by the size of squares on screen; and no cracks
    };
    explicit Cdlod(const Ground& ground, Ranges ranges = Ranges::whole, std::int32_t patch_cells = 32);
    [[nodiscard]] Refined refine(const View& view, double error_px, std::uint32_t operations) override;
    void faces(std::vector<Face>& out) const override;
    [[nodiscard]] std::size_t bytes() const override;
    [[nodiscard]] Traits traits() const override { return {false, false, true, ranges_ != Ranges::doubling}; }

    // What a GPU draws of the last refine(): a grid of `squares` x `squares` squares, each `step` cells wide, whose odd
    // vertices slide between these two distances from the eye. Infinite: they do not.
    struct Drawn {
        std::int32_t column, row, step, squares;
        float morph_from_m, morph_to_m;
    };
    void drawn(std::vector<Drawn>& out) const; // replaces what is in `out`

private:
    struct Node {
        float low_m, high_m;
    };
    struct Level {
        std::int32_t cells = 0, per_side = 0; // of its nodes
        std::vector<Node> nodes;
        float error_m = 0;    // of the whole terrain drawn at this level
        float diagonal_m = 0; // of its largest node
        double range_m = 0, morph_from_m = 0, morph_to_m = 0;
    };
    struct Patch {
        std::int32_t x, y, cells, level; // cells: its side
    };
    struct Pass;
    void measure_level(Level& level, std::int32_t step) const;
    void set_ranges(double q);
    bool select(const Pass& pass, std::size_t level, std::int32_t x, std::int32_t y);
    [[nodiscard]] Corner corner(const Patch& p, std::int32_t i, std::int32_t k) const;
    [[nodiscard]] double height_between(double column, double row) const;

    const Ground& ground_;
    Ranges ranges_;
    std::int32_t patch_cells_;
    std::vector<Level> levels_; // the finest first
    std::vector<Patch> patches_;
    Vec3 eye_m_;
    double q_ = -1;
    std::uint32_t triangles_ = 0;
};

} // namespace fjell::rivals
