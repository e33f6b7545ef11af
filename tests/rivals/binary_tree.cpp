#include "rivals/binary_tree.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "view/wanted.h"

namespace fjell::rivals {

namespace {

// The triangles of the same depth across the legs and across the hypotenuse; 0: none.
struct Neighbours {
    std::uint32_t left = 0, right = 0, edge = 0;
};

constexpr std::uint32_t child(std::uint32_t name, std::uint32_t which) {
    return name == 0 ? 0 : 2 * name + which;
}

// From the square's halves, 2 and 3, down.
Neighbours neighbours(std::uint32_t name) {
    const int depth = static_cast<int>(std::bit_width(name)) - 1;
    std::uint32_t at = name >> (depth - 1);
    Neighbours n{0, 0, at ^ 1};
    for (int i = depth - 2; i >= 0; --i) {
        const std::uint32_t bit = name >> i & 1;
        if (bit == 0)
            n = {child(at, 1), child(n.edge, 1), child(n.left, 1)};
        else
            n = {child(n.edge, 0), child(at, 0), child(n.right, 0)};
        at = 2 * at + bit;
    }
    return n;
}

} // namespace

BinaryTree::BinaryTree(const Ground& ground, bool cull)
    : ground_(ground), vertices_(vertices_of(ground)), cull_(cull),
      depth_(1 + 2 * std::countr_zero(static_cast<std::uint32_t>(ground.side))) {
    const std::size_t words = std::max<std::size_t>(1, (std::size_t{1} << depth_) / 64);
    bits_.resize(words);
    words_.resize(words / 64 + 1);
    sums_.resize(2 * words);
    set(0);
    set(std::uint32_t{1} << (depth_ - 1));
    sum_up();
}

std::uint32_t BinaryTree::first_bit(std::uint32_t name) const {
    const int depth = static_cast<int>(std::bit_width(name)) - 1;
    return (name << (depth_ - depth)) - (std::uint32_t{1} << depth_);
}

// The first bit after `at`, or the end.
std::uint32_t BinaryTree::next_leaf(std::uint32_t at) const {
    const std::uint32_t end = std::uint32_t{1} << depth_;
    std::size_t word = (at + 1) / 64;
    if (word >= bits_.size()) return end;
    std::uint64_t left = bits_[word] & ~std::uint64_t{0} << ((at + 1) % 64);
    if (left == 0) {
        std::size_t group = ++word / 64;
        if (word >= bits_.size()) return end;
        std::uint64_t some = words_[group] & ~std::uint64_t{0} << (word % 64);
        while (some == 0) {
            if (++group == words_.size()) return end;
            some = words_[group];
        }
        word = 64 * group + static_cast<std::size_t>(std::countr_zero(some));
        left = bits_[word];
    }
    return static_cast<std::uint32_t>(64 * word) + static_cast<std::uint32_t>(std::countr_zero(left));
}

void BinaryTree::sum_up() {
    const std::size_t words = bits_.size();
    for (std::size_t i = 0; i < words; ++i) // most are empty, and counting bits takes a call
        sums_[words + i] = bits_[i] == 0 ? 0 : static_cast<std::uint32_t>(std::popcount(bits_[i]));
    for (std::size_t i = words - 1; i >= 1; --i) sums_[i] = sums_[2 * i] + sums_[2 * i + 1];
}

std::uint32_t BinaryTree::leaf(std::uint32_t n) const {
    std::uint32_t name = 1;
    while (name < bits_.size()) {
        if (sums_[name] == 1) return name;
        name *= 2;
        if (n >= sums_[name]) n -= sums_[name++];
    }
    const auto word = static_cast<std::uint32_t>(name - bits_.size());
    std::uint64_t left = bits_[word];
    for (; n > 0; --n) left &= left - 1;
    const std::uint32_t at = 64 * word + static_cast<std::uint32_t>(std::countr_zero(left));
    const int above = static_cast<int>(std::bit_width(next_leaf(at) - at)) - 1; // levels between it and the finest
    return (at + (std::uint32_t{1} << depth_)) >> above;
}

// Calls visit(name, depth, triangle) for every leaf in order. Leaves that are split further on are met as they are
// then.
template <typename Visit>
void BinaryTree::walk(const Visit& visit) {
    const std::int32_t side = ground_.side;
    Triangle path[34];
    int known = 0; // depth down to which the path is that of the leaf before
    std::uint32_t before = 0;
    for (std::uint32_t at = 0; at < std::uint32_t{1} << depth_;) {
        const std::uint32_t end = next_leaf(at);
        const int depth = depth_ - (static_cast<int>(std::bit_width(end - at)) - 1);
        known = std::min(known, depth_ - static_cast<int>(std::bit_width(before ^ at)));
        const std::uint32_t name = (at + (std::uint32_t{1} << depth_)) >> (depth_ - depth);
        while (known < depth) {
            const bool second = name >> (depth - ++known) & 1;
            if (known == 1) {
                path[1] =
                    second ? Triangle{{0, side}, {side, side}, {0, 0}} : Triangle{{side, 0}, {0, 0}, {side, side}};
                continue;
            }
            const Triangle& t = path[known - 1];
            const SampleIndex middle{(t.left.column + t.right.column) / 2, (t.left.row + t.right.row) / 2};
            path[known] = second ? Triangle{middle, t.right, t.apex} : Triangle{middle, t.apex, t.left};
        }
        known = depth;
        before = at;
        visit(name, depth, path + depth);
        at = end;
    }
}

// And whatever must be split for the mesh to conform. Nothing when it is split already.
void BinaryTree::split(std::uint32_t name) {
    const auto is_split = [&](std::uint32_t n) { return bit(first_bit(2 * n + 1)); };
    if (is_split(name)) return;
    const std::uint32_t across = neighbours(name).edge;
    if (across != 0 && !is_split(across)) {
        if (across / 2 > 1) split(across / 2);
        set(first_bit(2 * across + 1));
        ++changes_;
    }
    set(first_bit(2 * name + 1));
    ++changes_;
}

Refined BinaryTree::refine(const View& view, double error_px, std::uint32_t) {
    const Reach reach = make_reach(view, error_px);
    const Frustum frustum = make_frustum(view);
    const auto needed = [&](SampleIndex v) {
        const GroundVertex& at = vertices_[ground_.index(v)];
        const float x = ground_.x_m(v.column), y = at.height_m, z = ground_.z_m(v.row);
        if (!wanted(reach, x, y, z, at.error_m, at.radius_m)) return false;
        if (!cull_) return true;
        const Vec3 from_eye = Vec3{static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)} - view.eye_m;
        const double radius_m = static_cast<double>(at.radius_m);
        for (int k = 0; k < 6; ++k)
            if (dot(frustum.normal[k], from_eye) < frustum.offset[k] - radius_m) return false;
        return true;
    };
    const auto middle = [](const Triangle& t) {
        return SampleIndex{(t.left.column + t.right.column) / 2, (t.left.row + t.right.row) / 2};
    };
    changes_ = 0;
    walk([&](std::uint32_t name, int depth, const Triangle* t) {
        if (depth < depth_ && needed(middle(*t))) split(name);
    });
    const auto halves_are_leaves = [&](std::uint32_t n) {
        const std::uint32_t first = first_bit(n), half = first_bit(2 * n + 1);
        return bit(half) && next_leaf(first) == half && next_leaf(half) == 2 * half - first;
    };
    walk([&](std::uint32_t name, int depth, const Triangle* t) {
        if (depth == 1 || name % 2 == 1) return; // the first of two halves decides
        const std::uint32_t parent = name / 2;
        if (!halves_are_leaves(parent) || needed(middle(t[-1]))) return;
        const std::uint32_t across = neighbours(parent).edge;
        if (across != 0 && (across < parent || !halves_are_leaves(across))) return; // once a diamond
        for (const std::uint32_t n : {parent, across})
            if (n != 0) {
                clear(first_bit(2 * n + 1));
                ++changes_;
            }
    });
    sum_up();
    indices_.resize(3 * std::size_t{leaves()});
    std::uint32_t* out = indices_.data();
    walk([&](std::uint32_t, int, const Triangle* t) {
        for (const SampleIndex c : {t->apex, t->left, t->right}) *out++ = ground_.index(c);
    });
    return {leaves(), false};
}

std::size_t BinaryTree::bytes() const {
    return sizeof(GroundVertex) * vertices_.size() + 8 * (bits_.size() + words_.size()) +
           4 * (sums_.size() + indices_.capacity());
}

} // namespace fjell::rivals
