#include "rivals/diamond_mesh.h"

#include <bit>

namespace fjell::rivals {

namespace {

// The ends of a hypotenuse in steps from the apex, in the order that faces up: of a centre, whose hypotenuses are the
// sides of its square, and of a side's vertex, where they lean.
constexpr SampleIndex straight_ends[4][2] = {
    {{1, 1}, {1, -1}}, {{-1, 1}, {1, 1}}, {{-1, -1}, {-1, 1}}, {{1, -1}, {-1, -1}}};
constexpr SampleIndex leaning_ends[4][2] = {{{0, 1}, {1, 0}}, {{-1, 0}, {0, 1}}, {{0, -1}, {-1, 0}}, {{1, 0}, {0, -1}}};

constexpr unsigned direction_to(SampleIndex way) {
    if (way.row == 0) return way.column > 0 ? 0 : 2;
    if (way.column == 0) return way.row > 0 ? 1 : 3;
    return way.row > 0 ? (way.column > 0 ? 0 : 1) : (way.column > 0 ? 3 : 2);
}

} // namespace

DiamondMesh::DiamondMesh(std::int32_t side)
    : tree_(Tree::covering(side + 1, side + 1, std::countr_zero(static_cast<std::uint32_t>(side)))), stride_(side + 1) {
    const auto samples = static_cast<std::size_t>(stride_) * static_cast<std::size_t>(stride_);
    active_.resize(samples);
    slots_.resize(4 * samples);
    for (const SampleIndex c : {SampleIndex{0, 0}, SampleIndex{side, 0}, SampleIndex{0, side}, SampleIndex{side, side}})
        active_[index(c)] = 1;
    add({side, 0}, 1);
    add({0, side}, 3);
}

bool DiamondMesh::ends_of(SampleIndex apex, unsigned direction, SampleIndex ends[2]) const {
    const bool corner = tree_.is_corner(apex);
    const std::int32_t step = corner ? tree_.side() : std::int32_t{1} << Tree::step_log2(apex);
    const bool straight = !corner && Tree::kind(apex) == VertexKind::centre;
    const SampleIndex* const ways = straight ? straight_ends[direction] : leaning_ends[direction];
    for (int i = 0; i < 2; ++i) {
        ends[i] = {apex.column + ways[i].column * step, apex.row + ways[i].row * step};
        if (!tree_.contains(ends[i])) return false;
    }
    return true;
}

void DiamondMesh::add(SampleIndex apex, unsigned direction) {
    SampleIndex ends[2];
    if (!ends_of(apex, direction, ends)) return;
    const std::uint32_t name = 4 * index(apex) + direction;
    slots_[name] = triangles();
    owners_.push_back(name);
    for (const SampleIndex c : {apex, ends[0], ends[1]}) indices_.push_back(index(c));
}

// The last triangle moves into its slot.
void DiamondMesh::remove(SampleIndex apex, unsigned direction) {
    SampleIndex ends[2];
    if (!ends_of(apex, direction, ends)) return;
    const std::uint32_t slot = slots_[4 * index(apex) + direction], last = triangles() - 1;
    owners_[slot] = owners_[last];
    slots_[owners_[slot]] = slot;
    for (std::size_t i = 0; i < 3; ++i) indices_[3 * std::size_t{slot} + i] = indices_[3 * std::size_t{last} + i];
    owners_.pop_back();
    indices_.resize(3 * owners_.size());
}

bool DiamondMesh::ready(SampleIndex v) const {
    for (const SampleIndex apex : diamond(tree_, v).apexes)
        if (tree_.contains(apex) && !active(apex)) return false;
    return true;
}

bool DiamondMesh::has_active_child(SampleIndex v) const {
    const Children c = children(v);
    for (int i = 0; i < c.count; ++i)
        if (tree_.contains(c.at[i]) && active(c.at[i])) return true;
    return false;
}

void DiamondMesh::activate(SampleIndex v) {
    for (const SampleIndex apex : diamond(tree_, v).apexes)
        if (tree_.contains(apex)) remove(apex, direction_to(v - apex));
    active_[index(v)] = 1;
    for (unsigned i = 0; i < 4; ++i) add(v, i);
}

void DiamondMesh::deactivate(SampleIndex v) {
    for (unsigned i = 0; i < 4; ++i) remove(v, i);
    active_[index(v)] = 0;
    for (const SampleIndex apex : diamond(tree_, v).apexes)
        if (tree_.contains(apex)) add(apex, direction_to(v - apex));
}

std::size_t DiamondMesh::bytes() const {
    return active_.size() + 4 * (slots_.size() + owners_.size() + indices_.size());
}

void faces_of(const Ground& ground, std::span<const std::uint32_t> indices, std::vector<Face>& out) {
    out.clear();
    const auto stride = static_cast<std::uint32_t>(ground.side + 1);
    for (std::size_t i = 0; i + 3 <= indices.size(); i += 3) {
        Face f;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t v = indices[i + k];
            f[k] = {static_cast<float>(v % stride), static_cast<float>(v / stride), ground.height_m[v]};
        }
        out.push_back(f);
    }
}

} // namespace fjell::rivals
