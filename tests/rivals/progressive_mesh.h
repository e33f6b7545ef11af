// A view-dependent progressive mesh (Hoppe, "View-dependent refinement of progressive meshes", 1997, and "Smooth
// view-dependent level-of-detail control and its application to terrain rendering", 1998): the collapses of an
// irregular simplification (simplify.h), undone where the view wants them, in any order that their neighbourhoods
// allow.
//
// As in the papers: a vertex hierarchy; a split may be made when its vertex is there and the four triangles around it
// are (1997, 4.1), which forces other splits; the front goes on from the frame before; only triangles that are drawn
// have corners and neighbours, all else is a record of a split (1998, 3). A split's error is how wrong its collapse
// was, vertically, at every sample under it (1998, 5); like its sphere it covers the splits below it in the hierarchy.
// Otherwise: a vertex splits in the order in which others have collapsed into it, so half-edges need no second name for
// a vertex that stays; the error on screen is taken at the nearest point of the sphere, as ours is, and not at the
// vertex; it works towards a threshold, not a number of triangles; vertices do not morph.
//
// What neither paper says, and does not hold: splits are measured in the mesh of the simplification, and drawn in
// another. So triangles may fold over, and a sample may be farther from them than any split that was left out says.
// Complexity: O(front) a frame, and O(1) a split but for those that it forces.
#pragma once

#include <array>
#include <vector>

#include "rivals/rival.h"
#include "rivals/simplify.h"

namespace fjell::rivals {

class ProgressiveMesh final : public Rival {
public:
    explicit ProgressiveMesh(const Ground& ground); // keeps a reference
    [[nodiscard]] Refined refine(const View& view, double error_px, std::uint32_t operations) override;
    void faces(std::vector<Face>& out) const override;
    [[nodiscard]] std::size_t bytes() const override;
    [[nodiscard]] Traits traits() const override { return {true, true, true, false}; }

    // Of samples: those that the mesh cannot do without, and all.
    [[nodiscard]] std::size_t base_vertices() const { return base_; }
    [[nodiscard]] std::size_t splits() const { return splits_.size(); }

private:
    struct Place { // of a vertex: those of the base mesh, then one a split
        std::uint16_t column, row;
        float height_m;
    };
    struct Split {
        std::uint32_t of;                    // the vertex that it splits
        std::array<std::uint32_t, 4> around; // triangles, as Collapse has them
        float error_m, radius_m;             // of it and all below it in the hierarchy
        std::uint32_t before, after;         // other splits of the same vertex
    };
    struct Eye;
    void number(const Simplified& all);
    void cover_below();
    [[nodiscard]] std::uint32_t maker_of(std::uint32_t face) const {
        return face == no_index || face < base_faces_ ? no_index : (face - base_faces_) / 2;
    }
    [[nodiscard]] bool made(std::uint32_t split) const { return split == no_index || where_[split] != no_index; }
    [[nodiscard]] bool wanted(const Eye& eye, std::uint32_t split) const;
    std::uint32_t force(std::uint32_t split, std::uint32_t most); // operations
    void split(std::uint32_t s);
    void unsplit(std::uint32_t s);
    [[nodiscard]] bool may_unsplit(std::uint32_t s) const;
    std::uint32_t unsplit_from(const Eye& eye, std::uint32_t s, std::uint32_t most);
    std::uint32_t add_face(std::uint32_t face, const LinkedFace& f);
    void remove_face(std::uint32_t face);
    void turn_around(std::uint32_t slot, bool onward, std::uint32_t last, std::uint32_t was, std::uint32_t is);
    [[nodiscard]] std::uint32_t slot_of(std::uint32_t face) const { return face == no_index ? face : slots_[face]; }

    const Ground& ground_;
    std::uint32_t base_ = 0, base_faces_ = 0;
    // The hierarchy.
    std::vector<Place> places_;
    std::vector<Split> splits_;
    std::vector<std::uint32_t> first_; // split of a vertex
    // The front.
    std::vector<std::uint32_t> next_;    // split of a vertex
    std::vector<std::uint32_t> where_;   // of a split in made_
    std::vector<std::uint16_t> leaning_; // made splits that have one of its triangles around them
    std::vector<std::uint32_t> made_;    // splits
    std::vector<std::uint32_t> slots_;   // of a triangle in drawn_
    std::vector<LinkedFace> drawn_;      // neighbours are slots; what a renderer would upload
    std::vector<std::uint32_t> free_, stack_;
};

} // namespace fjell::rivals
