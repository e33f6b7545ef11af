// An explicit multi-triangulation (Puppo 1996; De Floriani, Magillo and Puppo 1997; thesis 3.3): a directed acyclic
// graph of refinements, each of which replaces a set of triangles by a finer one, with an arc from each refinement to
// those that need a triangle it makes. All triangles and arcs are stored, and the algorithm knows nothing else.
//
// The one here comes from bisecting two triangles again and again and grouping those that share a hypotenuse, without
// the arithmetic of the vertex tree: its refinements turn out to be the tree's vertices, its arcs their parents, its
// closed selections our valid cuts (tests/rivals/rivals_test.cpp). What the tree computes, this stores.
// A refinement's error on screen is that of its vertex, from the pack; it culls by the same spheres, and forces the
// refinements that another needs. Found anew every frame. Complexity: O(selected refinements).
#pragma once

#include <array>
#include <vector>

#include "rivals/rival.h"

namespace fjell::rivals {

class MultiTriangulation final : public Rival {
public:
    struct Refinement {
        std::uint32_t vertex = 0;               // the sample that it adds
        std::array<std::uint32_t, 2> removes{}; // triangles; none: there is one
        std::array<std::uint32_t, 4> adds{};
        std::array<std::uint32_t, 2> needs{};     // refinements that add what it removes; none: of the base mesh
        std::array<std::uint32_t, 4> needed_by{}; // by triangle that it adds
    };
    static constexpr std::uint32_t none = 0xffffffff;

    MultiTriangulation(const Ground& ground, bool cull); // keeps a reference
    [[nodiscard]] Refined refine(const View& view, double error_px, std::uint32_t operations) override;
    void faces(std::vector<Face>& out) const override;
    [[nodiscard]] std::size_t bytes() const override;
    [[nodiscard]] Traits traits() const override { return {false, false, true, true}; }
    [[nodiscard]] const std::vector<Refinement>& refinements() const { return refinements_; }

private:
    void build();
    void select(std::uint32_t refinement);

    const Ground& ground_;
    std::vector<GroundVertex> vertices_; // by sample
    bool cull_;
    std::vector<std::array<std::uint32_t, 3>> triangles_; // samples: apex, left, right
    std::vector<std::uint32_t> removed_by_;               // by triangle: a refinement
    std::vector<Refinement> refinements_;                 // coarse before fine
    std::vector<std::uint32_t> selected_;                 // by refinement: in which frame
    std::vector<std::uint32_t> queue_, indices_;
    std::uint32_t frame_ = 0;
};

} // namespace fjell::rivals
