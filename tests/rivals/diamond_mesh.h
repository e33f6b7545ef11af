// A triangulation by right isosceles triangles that is changed one vertex at a time, as ROAM's splits and merges do.
//
// A triangle is named by the vertex at its right angle and one of four directions, so nothing points at anything: each
// vertex has four slots of the list of triangles. Activating a vertex replaces the diamond's two triangles by four (one
// by two on the rim); the mesh is whole after each change. Places are samples of a square of `side` cells, a power of
// two. Memory: 17 bytes a sample and 16 a triangle. Complexity: O(1) a change. Failure: none; activate() wants parents
// that are active, deactivate() children that are not.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "rivals/rival.h"
#include "shared/tree.h"

namespace fjell::rivals {

class DiamondMesh {
public:
    explicit DiamondMesh(std::int32_t side); // two triangles

    [[nodiscard]] const Tree& tree() const { return tree_; }
    [[nodiscard]] std::uint32_t index(SampleIndex c) const {
        return static_cast<std::uint32_t>(c.row * stride_ + c.column);
    }
    [[nodiscard]] bool active(SampleIndex c) const { return active_[index(c)] != 0; }
    // Both parents are active, or one where there is no more.
    [[nodiscard]] bool ready(SampleIndex v) const;
    [[nodiscard]] bool has_active_child(SampleIndex v) const;
    void prefetch(SampleIndex v) const { __builtin_prefetch(&slots_[4 * std::size_t{index(v)}]); }
    void activate(SampleIndex v);
    void deactivate(SampleIndex v);

    [[nodiscard]] std::uint32_t triangles() const { return static_cast<std::uint32_t>(owners_.size()); }
    [[nodiscard]] std::span<const std::uint32_t> indices() const { return indices_; } // of samples, three a triangle
    [[nodiscard]] std::size_t bytes() const;

private:
    void add(SampleIndex apex, unsigned direction);
    void remove(SampleIndex apex, unsigned direction);
    // False: the triangle would lie outside.
    bool ends_of(SampleIndex apex, unsigned direction, SampleIndex ends[2]) const;

    Tree tree_;
    std::int32_t stride_;
    std::vector<std::uint8_t> active_;  // corners too
    std::vector<std::uint32_t> slots_;  // by name, 4 * vertex + direction
    std::vector<std::uint32_t> owners_; // names, by slot
    std::vector<std::uint32_t> indices_;
};

// What faces() of a method with such indices says.
void faces_of(const Ground& ground, std::span<const std::uint32_t> indices, std::vector<Face>& out);

} // namespace fjell::rivals
