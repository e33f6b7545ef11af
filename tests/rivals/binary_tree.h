// A concurrent binary tree on the CPU (Dupuy, "Concurrent Binary Trees (with application to longest edge bisection)",
// HPG 2020): the mesh is a string of bits, one at the beginning of each leaf triangle of the bisection, and a tree of
// sums over it that finds the n-th leaf.
//
// As in the paper: every frame every leaf decides by itself, from its name alone, in one pass that splits and one that
// merges; splits go on to the neighbours across the longest edge until the mesh conforms; then the sums are made anew
// and every leaf is decoded into a triangle. A leaf moves by one level a frame at most, so a mesh is behind its view
// when that moves far: nothing in the method says how far. Otherwise: one core walks the leaves in order, with the
// vertices of the triangles above at hand, instead of many finding theirs through the sums. A leaf's error on screen is
// that of the vertex which splits it, from the pack, as everywhere here. It culls, as the paper does: what no view sees
// is merged.
//
// Memory: a bit and a half a finest triangle, besides the heights and errors. Complexity: O(leaves + bits / 64).
#pragma once

#include <vector>

#include "rivals/diamond_mesh.h"
#include "rivals/rival.h"

namespace fjell::rivals {

class BinaryTree final : public Rival {
public:
    BinaryTree(const Ground& ground, bool cull); // keeps a reference
    // Passes are whole: operations are not counted.
    [[nodiscard]] Refined refine(const View& view, double error_px, std::uint32_t operations) override;
    void faces(std::vector<Face>& out) const override { faces_of(ground_, indices_, out); }
    [[nodiscard]] std::size_t bytes() const override;
    [[nodiscard]] Traits traits() const override { return {false, true, cull_, false}; }
    [[nodiscard]] std::uint32_t changes() const { return changes_; } // of the last frame; 0: the mesh is at rest
    [[nodiscard]] std::uint32_t leaves() const { return sums_[1]; }
    // The name of the n-th leaf, by the sums, as a thread of a GPU finds its own.
    [[nodiscard]] std::uint32_t leaf(std::uint32_t n) const;

private:
    struct Triangle {
        SampleIndex apex, left, right; // left, right: of the hypotenuse
    };
    template <typename Visit>
    void walk(const Visit& visit);
    void split(std::uint32_t name);
    void set(std::uint32_t at) {
        bits_[at / 64] |= std::uint64_t{1} << (at % 64);
        words_[at / 4096] |= std::uint64_t{1} << (at / 64 % 64);
    }
    void clear(std::uint32_t at) {
        bits_[at / 64] &= ~(std::uint64_t{1} << (at % 64));
        if (bits_[at / 64] == 0) words_[at / 4096] &= ~(std::uint64_t{1} << (at / 64 % 64));
    }
    [[nodiscard]] bool bit(std::uint32_t at) const { return bits_[at / 64] >> (at % 64) & 1; }
    [[nodiscard]] std::uint32_t first_bit(std::uint32_t name) const;
    [[nodiscard]] std::uint32_t next_leaf(std::uint32_t at) const;
    void sum_up();

    const Ground& ground_;
    std::vector<GroundVertex> vertices_; // by sample
    bool cull_;
    int depth_; // of the finest triangles; that of the square is 0
    std::vector<std::uint64_t> bits_;
    std::vector<std::uint64_t> words_; // a bit for each word of bits_ that has any: long runs of none are skipped
    std::vector<std::uint32_t> sums_;  // a heap; its last level is over words of bits_
    std::vector<std::uint32_t> indices_;
    std::uint32_t changes_ = 0;
};

} // namespace fjell::rivals
