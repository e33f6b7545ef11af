#include "rivals/blocks_and_vertices.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fjell::rivals {

// A frame. A vertical segment of length delta is delta * lambda * h / (h^2 + v^2) pixels long, h away horizontally and
// v vertically: longer than the threshold when delta > `scale` * (h^2 + v^2) / h.
struct BlocksAndVertices::Pass {
    float x_m, y_m, z_m;
    float scale; // threshold / lambda
    Vec3 eye_m;
    Frustum frustum;
};

namespace {

struct Interval {
    float low, high;
};

// How near and how far a place is from an interval.
Interval distances(float at, float low, float high) {
    return {std::max({low - at, 0.0f, at - high}), std::max(at - low, high - at)};
}

// The least and the largest (h^2 + v^2) / h over a block: h + v^2 / h is least at h = v, and convex.
Interval shortest_deltas(const Interval& h, const Interval& v) {
    const auto f = [](float horizontal, float vertical) {
        return horizontal > 0 ? horizontal + vertical * vertical / horizontal : std::numeric_limits<float>::infinity();
    };
    const float nearest = std::clamp(v.low, h.low, h.high);
    const float low = nearest > 0 ? f(nearest, v.low) : 0;
    return {low * (1 - 0x1p-18f), std::max(f(h.low, v.high), f(h.high, v.high)) * (1 + 0x1p-18f)};
}

} // namespace

BlocksAndVertices::BlocksAndVertices(const Ground& ground)
    : ground_(ground), tree_(Tree::covering(ground.side + 1, ground.side + 1,
                                            std::countr_zero(static_cast<std::uint32_t>(ground.side)))),
      layout_(ground.side), blocks_(layout_.blocks.size()), enabled_(ground.height_m.size()) {
    const auto height = [&](SampleIndex c) { return ground.height_m[ground.index(c)]; };
    for (const std::uint32_t place : layout_.places) {
        const SampleIndex v = StepBlocks::place(place);
        const Diamond d = diamond(tree_, v);
        heights_m_.push_back(height(v));
        deltas_m_.push_back(std::abs(height(v) - (height(d.ends[0]) + height(d.ends[1])) / 2));
    }
    for (std::size_t level = layout_.levels.size(); level-- > 0;) {
        const StepBlocks::Level& l = layout_.levels[level];
        for (std::int32_t by = 0; by < l.per_side; ++by)
            for (std::int32_t bx = 0; bx < l.per_side; ++bx) {
                const StepBlocks::Block& at = layout_.blocks[layout_.block(level, bx, by)];
                Block b{std::numeric_limits<float>::max(), std::numeric_limits<float>::lowest(), 0};
                for (std::uint32_t i = at.first; i < at.first + at.count; ++i) {
                    b.low_m = std::min(b.low_m, heights_m_[i]);
                    b.high_m = std::max(b.high_m, heights_m_[i]);
                    b.delta_m = std::max(b.delta_m, deltas_m_[i]);
                }
                layout_.below(level, bx, by, [&](std::int32_t x, std::int32_t y) {
                    const Block& f = blocks_[layout_.block(level + 1, x, y)];
                    b = {std::min(b.low_m, f.low_m), std::max(b.high_m, f.high_m), std::max(b.delta_m, f.delta_m)};
                });
                blocks_[layout_.block(level, bx, by)] = b;
            }
    }
}

// And those that it depends on.
void BlocksAndVertices::enable(SampleIndex v) {
    std::uint16_t& stamp = enabled_[ground_.index(v)];
    if (stamp == frame_) return;
    stamp = frame_;
    for (const SampleIndex apex : diamond(tree_, v).apexes)
        if (tree_.contains(apex) && !tree_.is_corner(apex)) enable(apex);
}

void BlocksAndVertices::visit(const Pass& pass, std::size_t level, std::int32_t bx, std::int32_t by) {
    const std::size_t number = layout_.block(level, bx, by);
    const StepBlocks::Block& at = layout_.blocks[number];
    const Block& block = blocks_[number];
    const std::int32_t cells = layout_.levels[level].cells;
    const float x0 = ground_.x_m(at.x), x1 = ground_.x_m(at.x + cells), z0 = ground_.z_m(at.y),
                z1 = ground_.z_m(at.y + cells);
    const Interval x = distances(pass.x_m, x0, x1), z = distances(pass.z_m, z0, z1),
                   v = distances(pass.y_m, block.low_m, block.high_m);
    const Interval shortest =
        shortest_deltas({std::sqrt(x.low * x.low + z.low * z.low), std::sqrt(x.high * x.high + z.high * z.high)}, v);
    if (block.delta_m <= pass.scale * shortest.low) return; // nothing in it or below
    for (int i = 0; i < 6; ++i) {
        const Vec3& n = pass.frustum.normal[i];
        const Vec3 farthest{static_cast<double>(n.x > 0 ? x1 : x0),
                            static_cast<double>(n.y > 0 ? block.high_m : block.low_m),
                            static_cast<double>(n.z > 0 ? z1 : z0)};
        if (dot(n, farthest - pass.eye_m) < pass.frustum.offset[i]) return;
    }
    const float never = pass.scale * shortest.low, always = pass.scale * shortest.high;
    for (std::uint32_t i = at.first; i < at.first + at.count; ++i) {
        const float delta = deltas_m_[i];
        if (delta <= never) continue;
        const SampleIndex c = StepBlocks::place(layout_.places[i]);
        if (delta <= always) {
            ++projected_;
            const float dx = ground_.x_m(c.column) - pass.x_m, dy = heights_m_[i] - pass.y_m,
                        dz = ground_.z_m(c.row) - pass.z_m;
            const float h2 = dx * dx + dz * dz, r2 = h2 + dy * dy;
            if (delta * delta * h2 <= pass.scale * pass.scale * r2 * r2) continue;
        }
        enable(c);
    }
    layout_.below(level, bx, by,
                  [&](std::int32_t x_below, std::int32_t y_below) { visit(pass, level + 1, x_below, y_below); });
}

// levels: bisections that are left below this triangle.
void BlocksAndVertices::emit(std::uint32_t apex, std::uint32_t left, std::uint32_t right, int levels) {
    if (levels > 0) {
        const std::uint32_t middle = (left + right) / 2; // rows follow each other: exact
        if (enabled_[middle] == frame_) {
            emit(middle, apex, left, levels - 1);
            emit(middle, right, apex, levels - 1);
            return;
        }
    }
    if (count_ + 3 > indices_.size()) indices_.resize(2 * indices_.size() + 48);
    std::uint32_t* const out = indices_.data() + count_;
    out[0] = apex, out[1] = left, out[2] = right;
    count_ += 3;
}

Refined BlocksAndVertices::refine(const View& view, double error_px, std::uint32_t) {
    if (++frame_ == 0) {
        std::fill(enabled_.begin(), enabled_.end(), std::uint16_t{0});
        frame_ = 1;
    }
    const Pass pass{static_cast<float>(view.eye_m.x),
                    static_cast<float>(view.eye_m.y),
                    static_cast<float>(view.eye_m.z),
                    static_cast<float>(error_px / focal_length_px(view)),
                    view.eye_m,
                    make_frustum(view)};
    projected_ = 0;
    visit(pass, 0, 0, 0);
    count_ = 0;
    const std::int32_t n = ground_.side;
    const int levels = 2 * std::countr_zero(static_cast<std::uint32_t>(n));
    emit(ground_.index({n, 0}), ground_.index({0, 0}), ground_.index({n, n}), levels);
    emit(ground_.index({0, n}), ground_.index({n, n}), ground_.index({0, 0}), levels);
    return {static_cast<std::uint32_t>(count_ / 3), false};
}

std::size_t BlocksAndVertices::bytes() const {
    return blocks_.size() * (sizeof(Block) + sizeof(StepBlocks::Block)) + layout_.places.size() * 12 +
           2 * enabled_.size() + 4 * indices_.capacity() + 4 * ground_.height_m.size();
}

} // namespace fjell::rivals
