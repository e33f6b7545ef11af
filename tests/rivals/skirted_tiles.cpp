#include "rivals/skirted_tiles.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fjell/view.h"

namespace fjell::rivals {

SkirtedTiles::SkirtedTiles(const Ground& ground, std::int32_t tile_cells)
    : ground_(ground), cells_(std::min(tile_cells, ground.side)), per_side_(ground.side / cells_) {
    float most_m = 0;
    for (const float e : ground.error_m)
        if (e < std::numeric_limits<float>::infinity()) most_m = std::max(most_m, e);
    tolerances_m_.push_back(0);
    for (float m = most_m / 1024; m < 2 * most_m; m *= 2) tolerances_m_.push_back(m);
    tiles_.resize(static_cast<std::size_t>(per_side_) * static_cast<std::size_t>(per_side_));
    for (std::size_t i = 0; i < tiles_.size(); ++i) {
        const auto tx = static_cast<std::int32_t>(i) % per_side_, ty = static_cast<std::int32_t>(i) / per_side_;
        float low = std::numeric_limits<float>::max(), high = std::numeric_limits<float>::lowest();
        for (std::int32_t y = ty * cells_; y <= (ty + 1) * cells_; ++y)
            for (std::int32_t x = tx * cells_; x <= (tx + 1) * cells_; ++x) {
                low = std::min(low, ground.height_m[ground.index({x, y})]);
                high = std::max(high, ground.height_m[ground.index({x, y})]);
            }
        const auto corner = [&](std::int32_t x, std::int32_t y, float h) {
            return Vec3{static_cast<double>(ground.x_m(x * cells_)), static_cast<double>(h),
                        static_cast<double>(ground.z_m(y * cells_))};
        };
        tiles_[i].low = corner(tx, ty, low);
        tiles_[i].high = corner(tx + 1, ty + 1, high);
        tiles_[i].levels.resize(tolerances_m_.size());
    }
    for (std::size_t level = 0; level < tolerances_m_.size(); ++level) {
        bisect(level, {ground.side, 0}, {0, 0}, {ground.side, ground.side});
        bisect(level, {0, ground.side}, {ground.side, ground.side}, {0, 0});
    }
}

SampleIndex SkirtedTiles::coord(std::uint32_t sample) const {
    const auto stride = static_cast<std::uint32_t>(ground_.side + 1);
    return {static_cast<std::int32_t>(sample % stride), static_cast<std::int32_t>(sample / stride)};
}

// 0 to 3: the edge lies on the border of the tile at `corner` in the west, east, north, south; -1: inside.
int SkirtedTiles::side_of(SampleIndex corner, SampleIndex a, SampleIndex b) const {
    if (a.column == b.column && (a.column == corner.column || a.column == corner.column + cells_))
        return a.column == corner.column ? 0 : 1;
    if (a.row == b.row && (a.row == corner.row || a.row == corner.row + cells_)) return a.row == corner.row ? 2 : 3;
    return -1;
}

// Down to tiles, and in them as far as the level's tolerance asks for.
void SkirtedTiles::bisect(std::size_t level, SampleIndex apex, SampleIndex left, SampleIndex right) {
    const std::int32_t wide = std::max(std::abs(left.column - right.column), std::abs(left.row - right.row));
    const SampleIndex middle{(left.column + right.column) / 2, (left.row + right.row) / 2};
    if (wide > cells_ || (wide > 1 && ground_.error_m[ground_.index(middle)] > tolerances_m_[level])) {
        bisect(level, middle, apex, left);
        bisect(level, middle, right, apex);
        return;
    }
    const std::int32_t x = std::min({apex.column, left.column, right.column}) / cells_,
                       y = std::min({apex.row, left.row, right.row}) / cells_;
    Indices& indices = tiles_[static_cast<std::size_t>(y * per_side_ + x)].levels[level];
    const SampleIndex corner{x * cells_, y * cells_};
    const bool borders =
        side_of(corner, apex, left) >= 0 || side_of(corner, left, right) >= 0 || side_of(corner, right, apex) >= 0;
    auto& list = borders ? indices.border : indices.inner;
    for (const SampleIndex c : {apex, left, right}) list.push_back(ground_.index(c));
}

// A border triangle, cut at the vertices that a finer neighbour has on its edges.
void SkirtedTiles::skirt(Tile& tile, SampleIndex corner, const Triangle& t) {
    const SampleIndex at[3] = {t.a, t.b, t.c};
    for (std::size_t k = 0; k < 3; ++k) {
        const SampleIndex a = at[k], b = at[(k + 1) % 3], opposite = at[(k + 2) % 3];
        const int side = side_of(corner, a, b);
        if (side < 0 || std::max(std::abs(a.column - b.column), std::abs(a.row - b.row)) < 2) continue;
        const SampleIndex middle{(a.column + b.column) / 2, (a.row + b.row) / 2};
        const int finer = std::min(tile.around[side], tile.level);
        if (!(ground_.error_m[ground_.index(middle)] > tolerances_m_[static_cast<std::size_t>(finer)])) continue;
        skirt(tile, corner, {opposite, a, middle});
        skirt(tile, corner, {opposite, middle, b});
        return;
    }
    for (const SampleIndex c : at) tile.skirts.push_back(ground_.index(c));
}

// Makes the tile's skirts anew if what they depend on has changed.
void SkirtedTiles::join(Tile& tile, std::int32_t tx, std::int32_t ty) {
    static constexpr SampleIndex ways[4] = {{-1, 0}, {1, 0}, {0, -1}, {0, 1}};
    int around[4];
    for (int i = 0; i < 4; ++i) {
        const std::int32_t x = tx + ways[i].column, y = ty + ways[i].row;
        const bool there = x >= 0 && y >= 0 && x < per_side_ && y < per_side_;
        const Tile* const next = there ? &tiles_[static_cast<std::size_t>(y * per_side_ + x)] : nullptr;
        around[i] = next && next->drawn ? std::min(next->level, tile.level) : tile.level;
    }
    if (!tile.skirts.empty() && std::equal(around, around + 4, tile.around)) return;
    std::copy(around, around + 4, tile.around);
    tile.skirts.clear();
    const auto& border = tile.levels[static_cast<std::size_t>(tile.level)].border;
    for (std::size_t i = 0; i < border.size(); i += 3)
        skirt(tile, {tx * cells_, ty * cells_}, {coord(border[i]), coord(border[i + 1]), coord(border[i + 2])});
}

Refined SkirtedTiles::refine(const View& view, double error_px, std::uint32_t) {
    const Frustum frustum = make_frustum(view);
    const double scale = error_px / focal_length_px(view);
    for (Tile& tile : tiles_) {
        const auto beside = [](double v, double a, double b) { return std::max({a - v, 0.0, v - b}); };
        const Vec3 &eye = view.eye_m, &low = tile.low, &high = tile.high;
        const double distance =
            length({beside(eye.x, low.x, high.x), beside(eye.y, low.y, high.y), beside(eye.z, low.z, high.z)});
        tile.drawn = true;
        for (int i = 0; i < 6 && tile.drawn; ++i) {
            const Vec3& n = frustum.normal[i];
            const Vec3 farthest{n.x > 0 ? high.x : low.x, n.y > 0 ? high.y : low.y, n.z > 0 ? high.z : low.z};
            tile.drawn = dot(n, farthest - eye) >= frustum.offset[i];
        }
        int level = static_cast<int>(tolerances_m_.size()) - 1;
        while (level > 0 && static_cast<double>(tolerances_m_[static_cast<std::size_t>(level)]) > distance * scale)
            --level;
        if (level != tile.level) tile.skirts.clear();
        tile.level = level;
    }
    triangles_ = 0;
    for (std::size_t i = 0; i < tiles_.size(); ++i) {
        Tile& tile = tiles_[i];
        if (!tile.drawn) continue;
        join(tile, static_cast<std::int32_t>(i) % per_side_, static_cast<std::int32_t>(i) / per_side_);
        const std::size_t inner = tile.levels[static_cast<std::size_t>(tile.level)].inner.size();
        triangles_ += static_cast<std::uint32_t>((inner + tile.skirts.size()) / 3);
    }
    return {triangles_, false};
}

void SkirtedTiles::faces(std::vector<Face>& out) const {
    out.clear();
    for (const Tile& tile : tiles_) {
        if (!tile.drawn) continue;
        for (const auto* list : {&tile.levels[static_cast<std::size_t>(tile.level)].inner, &tile.skirts})
            for (std::size_t i = 0; i < list->size(); i += 3) {
                Face f;
                for (std::size_t k = 0; k < 3; ++k) {
                    const SampleIndex c = coord((*list)[i + k]);
                    f[k] = {static_cast<float>(c.column), static_cast<float>(c.row), ground_.height_m[(*list)[i + k]]};
                }
                out.push_back(f);
            }
    }
}

std::size_t SkirtedTiles::skirt_triangles() const {
    std::size_t count = 0;
    for (const Tile& tile : tiles_)
        if (tile.drawn) count += tile.skirts.size() / 3;
    return count;
}

std::size_t SkirtedTiles::bytes() const {
    std::size_t indices = 0;
    for (const Tile& tile : tiles_) {
        indices += tile.skirts.capacity();
        for (const Indices& i : tile.levels) indices += i.inner.capacity() + i.border.capacity();
    }
    // Heights, and errors for the vertices on borders.
    return 8 * ground_.height_m.size() + 4 * indices + tiles_.size() * sizeof(Tile);
}

} // namespace fjell::rivals
