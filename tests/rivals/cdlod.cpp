#include "rivals/cdlod.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fjell::rivals {

namespace {

constexpr double morph_share = 0.66; // of a range, from the end of the one before: where morphing begins

constexpr double square_thresholds = 16;

// Squared distance from a place to a box.
double squared_distance(const Vec3& p, const Vec3& low, const Vec3& high) {
    const auto beside = [](double v, double a, double b) { return std::max({a - v, 0.0, v - b}); };
    const double x = beside(p.x, low.x, high.x), y = beside(p.y, low.y, high.y), z = beside(p.z, low.z, high.z);
    return x * x + y * y + z * z;
}

} // namespace

struct Cdlod::Pass {
    Vec3 eye_m;
    Frustum frustum;
    [[nodiscard]] bool sees(const Vec3& low, const Vec3& high) const {
        for (int i = 0; i < 6; ++i) {
            const Vec3& n = frustum.normal[i];
            const Vec3 farthest{n.x > 0 ? high.x : low.x, n.y > 0 ? high.y : low.y, n.z > 0 ? high.z : low.z};
            if (dot(n, farthest - eye_m) < frustum.offset[i]) return false;
        }
        return true;
    }
};

Cdlod::Cdlod(const Ground& ground, Ranges ranges, std::int32_t patch_cells)
    : ground_(ground), ranges_(ranges), patch_cells_(std::min(patch_cells, ground.side)) {
    for (std::int32_t cells = patch_cells_; cells <= ground.side; cells *= 2) {
        Level& level = levels_.emplace_back();
        level.cells = cells;
        level.per_side = ground.side / cells;
        measure_level(level, cells / patch_cells_);
    }
}

// Boxes of its nodes, and how wrong it is: in each square both halves against all samples.
void Cdlod::measure_level(Level& level, std::int32_t step) const {
    const Ground& g = ground_;
    const auto height = [&](std::int32_t x, std::int32_t y) { return g.height_m[g.index({x, y})]; };
    for (std::int32_t ny = 0; ny < level.per_side; ++ny)
        for (std::int32_t nx = 0; nx < level.per_side; ++nx) {
            Node node{std::numeric_limits<float>::max(), std::numeric_limits<float>::lowest()};
            for (std::int32_t y = ny * level.cells; y <= (ny + 1) * level.cells; ++y)
                for (std::int32_t x = nx * level.cells; x <= (nx + 1) * level.cells; ++x) {
                    node.low_m = std::min(node.low_m, height(x, y));
                    node.high_m = std::max(node.high_m, height(x, y));
                }
            level.nodes.push_back(node);
            const float dx = g.x_m(level.cells), dy = node.high_m - node.low_m, dz = g.z_m(level.cells);
            level.diagonal_m = std::max(level.diagonal_m, std::sqrt(dx * dx + dy * dy + dz * dz));
        }
    if (step == 1) return;
    const auto s = static_cast<float>(step);
    for (std::int32_t y0 = 0; y0 < g.side; y0 += step)
        for (std::int32_t x0 = 0; x0 < g.side; x0 += step) {
            const float nw = height(x0, y0), ne = height(x0 + step, y0), sw = height(x0, y0 + step),
                        se = height(x0 + step, y0 + step);
            for (std::int32_t y = 0; y <= step; ++y)
                for (std::int32_t x = 0; x <= step; ++x) {
                    const float u = static_cast<float>(x) / s, v = static_cast<float>(y) / s;
                    const float drawn =
                        u >= v ? nw + (ne - nw) * u + (se - ne) * v : nw + (sw - nw) * v + (se - sw) * u;
                    level.error_m = std::max(level.error_m, std::abs(drawn - height(x0 + x, y0 + y)));
                }
        }
}

// Level l is drawn at least as far as the next one is too wrong, less a square of that one: so far may a sample be
// nearer than its vertices.
void Cdlod::set_ranges(double q) {
    q_ = q;
    double before_m = 0;
    for (std::size_t l = 0; l < levels_.size(); ++l) {
        Level& level = levels_[l];
        if (l + 1 == levels_.size()) { // nothing coarser to morph to
            level.range_m = level.morph_from_m = level.morph_to_m = std::numeric_limits<double>::infinity();
            break;
        }
        const Level& next = levels_[l + 1];
        const std::int32_t step = next.cells / patch_cells_;
        const double square_m =
            std::hypot(static_cast<double>(ground_.x_m(step)), static_cast<double>(ground_.z_m(step)));
        const double from_m = std::max(static_cast<double>(next.error_m) * q + square_m, before_m);
        level.range_m = before_m + (from_m - before_m) / morph_share;
        if (ranges_ == Ranges::doubling) level.range_m = std::max(square_m * q / square_thresholds, before_m);
        if (ranges_ != Ranges::bound && l > 0)
            level.range_m =
                std::max(level.range_m, before_m + 1.01 * static_cast<double>(levels_[l - 1].diagonal_m) / morph_share);
        level.morph_from_m = before_m + (level.range_m - before_m) * morph_share;
        level.morph_to_m = level.range_m - 0.01 * (level.range_m - level.morph_from_m);
        before_m = level.range_m;
    }
}

// False: out of this level's range; what is coarser has to draw it.
bool Cdlod::select(const Pass& pass, std::size_t l, std::int32_t x, std::int32_t y) {
    const Level& level = levels_[l];
    const Node& node = level.nodes[static_cast<std::size_t>((y / level.cells) * level.per_side + x / level.cells)];
    const auto at = [&](std::int32_t column, float height_m, std::int32_t row) {
        return Vec3{static_cast<double>(ground_.x_m(column)), static_cast<double>(height_m),
                    static_cast<double>(ground_.z_m(row))};
    };
    const Vec3 low = at(x, node.low_m, y), high = at(x + level.cells, node.high_m, y + level.cells);
    const double squared = squared_distance(pass.eye_m, low, high);
    if (squared > level.range_m * level.range_m) return false;
    if (!pass.sees(low, high)) return true;
    const auto add = [&](std::int32_t px, std::int32_t py, std::int32_t cells) {
        patches_.push_back({px, py, cells, static_cast<std::int32_t>(l)});
        const std::int32_t squares = cells / (level.cells / patch_cells_);
        triangles_ += static_cast<std::uint32_t>(2 * squares * squares);
    };
    if (l == 0 || squared > levels_[l - 1].range_m * levels_[l - 1].range_m) {
        add(x, y, level.cells);
        return true;
    }
    const std::int32_t half = level.cells / 2;
    for (const std::int32_t cy : {y, y + half})
        for (const std::int32_t cx : {x, x + half})
            if (!select(pass, l - 1, cx, cy)) add(cx, cy, half);
    return true;
}

Refined Cdlod::refine(const View& view, double error_px, std::uint32_t) {
    const double q = focal_length_px(view) / error_px;
    if (q != q_) set_ranges(q);
    patches_.clear();
    triangles_ = 0;
    eye_m_ = view.eye_m;
    (void)select({view.eye_m, make_frustum(view)}, levels_.size() - 1, 0, 0);
    return {triangles_, false};
}

// Bilinear, as a texture is sampled.
double Cdlod::height_between(double column, double row) const {
    const auto x = std::min(static_cast<std::int32_t>(column), ground_.side - 1),
               y = std::min(static_cast<std::int32_t>(row), ground_.side - 1);
    const double u = column - x, v = row - y;
    const auto height = [&](std::int32_t i, std::int32_t k) {
        return static_cast<double>(ground_.height_m[ground_.index({x + i, y + k})]);
    };
    return (height(0, 0) * (1 - u) + height(1, 0) * u) * (1 - v) + (height(0, 1) * (1 - u) + height(1, 1) * u) * v;
}

// What the vertex shader does with vertex (i, k) of a patch.
Corner Cdlod::corner(const Patch& p, std::int32_t i, std::int32_t k) const {
    const Level& level = levels_[static_cast<std::size_t>(p.level)];
    const std::int32_t step = level.cells / patch_cells_, x = p.x + i * step, y = p.y + k * step;
    const Vec3 place{static_cast<double>(ground_.x_m(x)), static_cast<double>(ground_.height_m[ground_.index({x, y})]),
                     static_cast<double>(ground_.z_m(y))};
    double morphed = 0;
    if (level.morph_to_m < std::numeric_limits<double>::infinity())
        morphed = std::clamp((length(place - eye_m_) - level.morph_from_m) / (level.morph_to_m - level.morph_from_m),
                             0.0, 1.0);
    const double column = x - morphed * step * (i % 2), row = y - morphed * step * (k % 2);
    return {static_cast<float>(column), static_cast<float>(row), static_cast<float>(height_between(column, row))};
}

void Cdlod::faces(std::vector<Face>& out) const {
    out.clear();
    std::vector<Corner> grid;
    for (const Patch& p : patches_) {
        const std::int32_t n = p.cells / (levels_[static_cast<std::size_t>(p.level)].cells / patch_cells_);
        grid.clear();
        for (std::int32_t k = 0; k <= n; ++k)
            for (std::int32_t i = 0; i <= n; ++i) grid.push_back(corner(p, i, k));
        const auto at = [&](std::int32_t i, std::int32_t k) { return grid[static_cast<std::size_t>(k * (n + 1) + i)]; };
        for (std::int32_t k = 0; k < n; ++k)
            for (std::int32_t i = 0; i < n; ++i) {
                out.push_back({at(i, k), at(i, k + 1), at(i + 1, k + 1)});
                out.push_back({at(i, k), at(i + 1, k + 1), at(i + 1, k)});
            }
    }
}

void Cdlod::drawn(std::vector<Drawn>& out) const {
    out.clear();
    for (const Patch& p : patches_) {
        const Level& level = levels_[static_cast<std::size_t>(p.level)];
        const std::int32_t step = level.cells / patch_cells_;
        out.push_back({p.x, p.y, step, p.cells / step, static_cast<float>(level.morph_from_m),
                       static_cast<float>(level.morph_to_m)});
    }
}

std::size_t Cdlod::bytes() const {
    std::size_t nodes = 0;
    for (const Level& l : levels_) nodes += l.nodes.size();
    return nodes * sizeof(Node) + 4 * ground_.height_m.size() + patches_.capacity() * sizeof(Patch);
}

} // namespace fjell::rivals
