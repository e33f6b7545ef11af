#include "rivals/error_spheres.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "view/wanted.h"

namespace fjell::rivals {

ErrorSpheres::ErrorSpheres(const Ground& ground)
    : ground_(ground), mesh_(ground.side), layout_(ground.side), spheres_m_(layout_.places.size()),
      active_(layout_.places.size()), on_(2 * layout_.levels.size()), off_(2 * layout_.levels.size()) {
    for (const StepBlocks::Level& l : layout_.levels)
        for (std::size_t i = l.first;
             i < l.first + static_cast<std::size_t>(l.per_side) * static_cast<std::size_t>(l.per_side); ++i) {
            const StepBlocks::Block& b = layout_.blocks[i];
            const SampleIndex middle{b.x + l.cells / 2, b.y + l.cells / 2};
            clusters_.push_back(
                {ground_.x_m(middle.column), ground_.height_m[ground_.index(middle)], ground_.z_m(middle.row)});
        }
    for (const std::uint32_t place : layout_.places) {
        const SampleIndex v = StepBlocks::place(place);
        x_m_.push_back(ground_.x_m(v.column));
        y_m_.push_back(ground_.height_m[ground_.index(v)]);
        z_m_.push_back(ground_.z_m(v.row));
    }
}

// The finest clusters first.
void ErrorSpheres::grow_spheres(float q) {
    q_ = q;
    for (std::size_t level = layout_.levels.size(); level-- > 0;) {
        const StepBlocks::Level& l = layout_.levels[level];
        for (std::int32_t cy = 0; cy < l.per_side; ++cy)
            for (std::int32_t cx = 0; cx < l.per_side; ++cx) grow_cluster(level, cx, cy);
    }
}

void ErrorSpheres::grow_cluster(std::size_t level, std::int32_t cx, std::int32_t cy) {
    const std::size_t number = layout_.block(level, cx, cy);
    const StepBlocks::Block& block = layout_.blocks[number];
    Cluster& c = clusters_[number];
    c.outer_m = 0;
    c.inner_m = std::numeric_limits<float>::max();
    c.below = true;
    c.all = false;
    const auto away = [&](float x, float y, float z) {
        return std::sqrt((x - c.x_m) * (x - c.x_m) + (y - c.y_m) * (y - c.y_m) + (z - c.z_m) * (z - c.z_m));
    };
    for (std::uint32_t i = block.first; i < block.first + block.count; ++i) {
        const std::uint32_t sample = ground_.index(StepBlocks::place(layout_.places[i]));
        spheres_m_[i] = (ground_.radius_m[sample] + ground_.error_m[sample] * q_) * reach_grow;
        const float d = away(x_m_[i], y_m_[i], z_m_[i]);
        c.outer_m = std::max(c.outer_m, (d + spheres_m_[i]) * (1 + 0x1p-18f));
        c.inner_m = std::min(c.inner_m, spheres_m_[i] - d - (d + spheres_m_[i]) * 0x1p-18f);
    }
    layout_.below(level, cx, cy, [&](std::int32_t x, std::int32_t y) {
        const Cluster& f = clusters_[layout_.block(level + 1, x, y)];
        c.outer_m = std::max(c.outer_m, (away(f.x_m, f.y_m, f.z_m) + f.outer_m) * (1 + 0x1p-18f));
    });
}

// Notes which of its vertices change.
void ErrorSpheres::test(std::size_t cluster, const Vec3& eye_m, float pad, bool none, bool all, std::size_t level) {
    const auto ex = static_cast<float>(eye_m.x), ey = static_cast<float>(eye_m.y), ez = static_cast<float>(eye_m.z);
    const std::uint32_t keep = none ? 0 : 1, force = all ? 1 : 0;
    Cluster& c = clusters_[cluster];
    const StepBlocks::Block& block = layout_.blocks[cluster];
    std::uint32_t active = 0;
    tested_ += block.count;
    constexpr std::uint32_t at_once = 16;
    std::uint32_t inside[at_once];
    for (std::uint32_t first = block.first, end = first + block.count; first < end; first += at_once) {
        const std::uint32_t count = std::min(at_once, end - first);
        const float *const x = &x_m_[first], *const y = &y_m_[first], *const z = &z_m_[first],
                           *const sphere = &spheres_m_[first];
        const std::uint32_t* const is = &active_[first];
        std::uint32_t changed = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const float dx = x[i] - ex, dy = y[i] - ey, dz = z[i] - ez, reach = sphere[i] + pad;
            const std::uint32_t in = dx * dx + dy * dy + dz * dz < reach * reach ? 1 : 0;
            inside[i] = (in & keep) | force;
            changed |= inside[i] ^ is[i];
            active += is[i];
        }
        if (changed == 0) continue;
        for (std::uint32_t i = 0; i < count; ++i) {
            if (inside[i] == active_[first + i]) continue;
            const bool centre = Tree::kind(StepBlocks::place(layout_.places[first + i])) == VertexKind::centre;
            (inside[i] != 0 ? on_ : off_)[2 * level + (centre ? 0 : 1)].push_back(first + i);
        }
    }
    c.all = active == block.count;
    c.below = c.below || active > 0;
}

// beyond: the outer sphere of a cluster above, so of this one too.
void ErrorSpheres::visit(const Vec3& eye_m, float pad, std::size_t level, std::int32_t cx, std::int32_t cy,
                         bool beyond) {
    const std::size_t number = layout_.block(level, cx, cy);
    Cluster& c = clusters_[number];
    const float dx = c.x_m - static_cast<float>(eye_m.x), dy = c.y_m - static_cast<float>(eye_m.y),
                dz = c.z_m - static_cast<float>(eye_m.z);
    const float distance = std::sqrt(dx * dx + dy * dy + dz * dz) * (1 - 0x1p-18f) - 2 * pad;
    beyond = beyond || distance > c.outer_m;
    if (beyond && !c.below) return;
    c.below = false;
    const bool all = !beyond && distance * (1 + 0x1p-16f) + 4 * pad < c.inner_m;
    if (all && c.all)
        c.below = true;
    else
        test(number, eye_m, pad, beyond, all, level);
    layout_.below(level, cx, cy, [&](std::int32_t x, std::int32_t y) {
        visit(eye_m, pad, level + 1, x, y, beyond);
        c.below = c.below || clusters_[layout_.block(level + 1, x, y)].below;
    });
    if (!beyond) c.below = true; // what is activated now is seen in the next frame
}

// Children leave before their parents, and come after them. False: operations ran out.
bool ErrorSpheres::apply(std::uint32_t& left) {
    for (std::size_t level = off_.size(); level-- > 0;)
        for (const std::uint32_t i : off_[level]) {
            if (left == 0) return false;
            --left;
            mesh_.deactivate(StepBlocks::place(layout_.places[i]));
            active_[i] = 0;
        }
    for (const auto& list : on_)
        for (const std::uint32_t i : list) {
            if (left == 0) return false;
            --left;
            mesh_.activate(StepBlocks::place(layout_.places[i]));
            active_[i] = 1;
        }
    return true;
}

Refined ErrorSpheres::refine(const View& view, double error_px, std::uint32_t operations) {
    const Reach reach = make_reach(view, error_px);
    if (reach.q != q_) grow_spheres(reach.q);
    for (auto* lists : {&on_, &off_})
        for (auto& list : *lists) list.clear();
    tested_ = 0;
    visit(view.eye_m, reach.pad, 0, 0, 0, false);
    std::uint32_t left = operations;
    const bool whole = apply(left);
    return {mesh_.triangles(), !whole};
}

std::size_t ErrorSpheres::bytes() const {
    std::size_t lists = 0;
    for (const auto* all : {&on_, &off_})
        for (const auto& list : *all) lists += list.capacity() * sizeof(std::uint32_t);
    // The samples' heights are in here: no other part of the ground is read once the spheres are grown.
    return mesh_.bytes() + clusters_.size() * sizeof(Cluster) + layout_.places.size() * 24 + lists;
}

} // namespace fjell::rivals
