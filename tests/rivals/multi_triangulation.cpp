#include "rivals/multi_triangulation.h"

#include <algorithm>

#include "rivals/diamond_mesh.h"
#include "view/wanted.h"

namespace fjell::rivals {

MultiTriangulation::MultiTriangulation(const Ground& ground, bool cull)
    : ground_(ground), vertices_(vertices_of(ground)), cull_(cull) {
    build();
    selected_.resize(refinements_.size());
}

// A generation of triangles after the other: all that share a hypotenuse make a refinement, which makes the next ones.
void MultiTriangulation::build() {
    const std::int32_t n = ground_.side;
    const auto sample = [&](std::int32_t x, std::int32_t y) { return ground_.index({x, y}); };
    triangles_ = {{sample(n, 0), sample(0, 0), sample(n, n)}, {sample(0, n), sample(n, n), sample(0, 0)}};
    std::vector<std::uint32_t> added_by{none, none};
    std::vector<std::uint32_t> at_middle(ground_.height_m.size(), none); // the refinement of a hypotenuse' middle
    std::size_t begin = 0;
    for (int generation = 0; generation < 2 * std::countr_zero(static_cast<unsigned>(n)); ++generation) {
        const std::size_t end = triangles_.size(), first = refinements_.size();
        removed_by_.resize(end, none);
        for (std::size_t t = begin; t < end; ++t) {
            std::uint32_t& known = at_middle[(triangles_[t][1] + triangles_[t][2]) / 2];
            if (known == none) {
                known = static_cast<std::uint32_t>(refinements_.size());
                Refinement& r = refinements_.emplace_back();
                r.vertex = (triangles_[t][1] + triangles_[t][2]) / 2;
                r.removes = r.needs = {none, none};
                r.adds = r.needed_by = {none, none, none, none};
            }
            Refinement& r = refinements_[known];
            const std::size_t which = r.removes[0] == none ? 0 : 1;
            r.removes[which] = static_cast<std::uint32_t>(t);
            r.needs[which] = added_by[t];
            removed_by_[t] = known;
            if (added_by[t] == none) continue;
            Refinement& before = refinements_[added_by[t]];
            for (std::size_t k = 0; k < 4; ++k)
                if (before.adds[k] == t) before.needed_by[k] = known;
        }
        for (std::size_t i = first; i < refinements_.size(); ++i) {
            Refinement& r = refinements_[i];
            std::size_t count = 0;
            for (const std::uint32_t t : r.removes) {
                if (t == none) continue;
                const auto [apex, left, right] = triangles_[t];
                for (const auto& half : {std::array{r.vertex, apex, left}, std::array{r.vertex, right, apex}}) {
                    r.adds[count++] = static_cast<std::uint32_t>(triangles_.size());
                    triangles_.push_back(half);
                    added_by.push_back(static_cast<std::uint32_t>(i));
                }
            }
        }
        begin = end;
    }
    removed_by_.resize(triangles_.size(), none);
}

// And what it needs.
void MultiTriangulation::select(std::uint32_t refinement) {
    if (selected_[refinement] == frame_) return;
    selected_[refinement] = frame_;
    queue_.push_back(refinement);
    for (const std::uint32_t needed : refinements_[refinement].needs)
        if (needed != none) select(needed);
}

Refined MultiTriangulation::refine(const View& view, double error_px, std::uint32_t) {
    const Reach reach = make_reach(view, error_px);
    const Frustum frustum = make_frustum(view);
    const auto stride = static_cast<std::uint32_t>(ground_.side + 1);
    const auto wants = [&](std::uint32_t refinement) {
        const std::uint32_t i = refinements_[refinement].vertex;
        const float x = ground_.x_m(static_cast<std::int32_t>(i % stride)), y = vertices_[i].height_m,
                    z = ground_.z_m(static_cast<std::int32_t>(i / stride));
        if (!wanted(reach, x, y, z, vertices_[i].error_m, vertices_[i].radius_m)) return false;
        if (!cull_) return true;
        const Vec3 from_eye = Vec3{static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)} - view.eye_m;
        for (int k = 0; k < 6; ++k)
            if (dot(frustum.normal[k], from_eye) < frustum.offset[k] - static_cast<double>(vertices_[i].radius_m))
                return false;
        return true;
    };
    ++frame_;
    queue_.clear();
    indices_.clear();
    if (wants(0)) select(0);
    for (std::size_t i = 0; i < queue_.size(); ++i)
        for (const std::uint32_t next : refinements_[queue_[i]].needed_by)
            if (next != none && selected_[next] != frame_ && wants(next)) select(next);
    const auto draw = [&](std::uint32_t triangle) {
        const std::uint32_t by = removed_by_[triangle];
        if (by != none && selected_[by] == frame_) return;
        indices_.insert(indices_.end(), triangles_[triangle].begin(), triangles_[triangle].end());
    };
    draw(0);
    draw(1);
    for (const std::uint32_t refinement : queue_)
        for (const std::uint32_t triangle : refinements_[refinement].adds)
            if (triangle != none) draw(triangle);
    return {static_cast<std::uint32_t>(indices_.size() / 3), false};
}

void MultiTriangulation::faces(std::vector<Face>& out) const {
    faces_of(ground_, indices_, out);
}

std::size_t MultiTriangulation::bytes() const {
    return sizeof(GroundVertex) * vertices_.size() + refinements_.size() * (sizeof(Refinement) + 4) +
           triangles_.size() * 16 + 4 * (queue_.capacity() + indices_.capacity());
}

} // namespace fjell::rivals
