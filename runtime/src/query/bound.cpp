// The bound of a mesh as it stands: every triangle of the cut against the error of the vertex that would split it next,
// whatever the method has had the items, the slots or the pages for.
//
// That error bounds what the triangle hides, and the vertex' sphere holds all of it, so error * lambda / (distance -
// radius) is a bound in pixels. It is loose where the sphere comes near the eye: there the samples under the triangle
// are measured. A first pass finds what the error is at least, so that the second one measures few.
#include <algorithm>
#include <cmath>
#include <limits>

#include "cut/state.h"
#include "fjell/measure.h"
#include "recursive/state.h"
#include "shared/terrain_data.h"

namespace fjell {

namespace {

constexpr double unlimited = std::numeric_limits<double>::infinity();
constexpr double rounding = 1 + 0x1p-20; // of the floats that errors and radii are

struct Corner {
    SampleIndex at; // also beyond the terrain's rim
    double drawn_m, full_m;
    bool hole;
};

// Whether a vertex is active, and the height that it is drawn at.
struct CutVertices {
    const Pages& pages;
    const Mesh& mesh;
    const MorphFrame& frame;
    [[nodiscard]] bool find(SampleIndex at, SampleIndex /*tile*/, std::uint32_t& slot) const {
        const std::uint32_t vertex = find_vertex(pages, site_at(at));
        if (vertex == no_index || !is_active(pages, vertex)) return false;
        slot = pages.vertex_slot[vertex];
        return true;
    }
    [[nodiscard]] double drawn_m(std::uint32_t slot, double /*full_m*/) const {
        if (mesh.morph == nullptr) return static_cast<double>(mesh.vertices[slot].height_m);
        return static_cast<double>(morphed_height_m(pages.grid.handle, mesh.vertices[slot], mesh.morph[slot], frame));
    }
};

struct RecursiveVertices {
    const RecursiveState& s;
    [[nodiscard]] bool find(SampleIndex at, SampleIndex tile, std::uint32_t& /*slot*/) const {
        const TerrainData& t = *s.terrain;
        const std::int32_t side = t.tree.side();
        const PagePlace place = t.pages.place(static_cast<std::uint32_t>(at.column - tile.column * side),
                                              static_cast<std::uint32_t>(at.row - tile.row * side));
        const std::uint32_t number = t.tile_at(tile.column, tile.row);
        const std::uint32_t page = t.page_table[std::size_t{number} * t.pages_per_tile + place.page].slot;
        return page != no_index && is_selected(s, page * t.page_capacity + place.index);
    }
    [[nodiscard]] double drawn_m(std::uint32_t /*slot*/, double full_m) const { return full_m; }
};

std::int64_t cross2(SampleIndex a, SampleIndex b, SampleIndex p) {
    return std::int64_t{b.column - a.column} * (p.row - a.row) - std::int64_t{b.row - a.row} * (p.column - a.column);
}

template <typename Vertices>
class Bound {
public:
    Bound(const TerrainData& terrain, const Vertices& vertices, const View& view, bool corner_safe, double at_least_px)
        : t_(terrain), vertices_(vertices), view_(view), frustum_(make_frustum(view)), lambda_(focal_length_px(view)),
          corner_safe_(corner_safe), trusted_(terrain.header.estimate == ErrorEstimate::max), px_(at_least_px) {
        const double low = terrain.range.low_m, high = terrain.range.high_m;
        rounding_m_ = 0x1p-23 * (std::max(std::abs(low), std::abs(high)) + high - low);
        half_quantum_m_ = static_cast<double>(terrain.header.quantum_m) / 2;
        factor_ = corner_factor(view);
        const double tx = std::max(std::abs(view.left), std::abs(view.right)),
                     ty = std::max(std::abs(view.bottom), std::abs(view.top));
        tilt_ = std::abs(view.forward.y) * std::sqrt(1 + tx * tx + ty * ty) / lambda_;
    }

    void tile(std::uint32_t number) {
        tile_ = t_.tile_xy(number);
        const std::int32_t n = t_.tree.side(), x = tile_.column * n, y = tile_.row * n;
        const Corner nw = tile_corner({x, y}), ne = tile_corner({x + n, y}), sw = tile_corner({x, y + n}),
                     se = tile_corner({x + n, y + n});
        triangle(ne, nw, se);
        triangle(sw, se, nw);
    }
    void begin_to_measure() { measuring_ = true; }
    [[nodiscard]] double px() const { return px_; }

private:
    [[nodiscard]] Corner tile_corner(SampleIndex at) const {
        const TerrainData::Vertex v = t_.vertex(at);
        return {at, static_cast<double>(v.height_m), static_cast<double>(v.height_m), v.hole};
    }

    [[nodiscard]] Vec3 position(SampleIndex at, double height_m) const {
        const SampleIndex c = t_.tree.sample(at);
        return {c.column * t_.header.spacing_m[0], height_m, c.row * t_.header.spacing_m[1]};
    }

    void triangle(const Corner& apex, const Corner& left, const Corner& right) {
        const SampleIndex sum = left.at + right.at;
        std::uint32_t slot = 0;
        const bool finest = ((sum.column | sum.row) & 1) != 0;
        if (const SampleIndex middle{sum.column / 2, sum.row / 2}; !finest && vertices_.find(middle, tile_, slot)) {
            const TerrainData::Vertex v = t_.vertex(middle);
            const auto full_m = static_cast<double>(v.height_m);
            const Corner m{middle, vertices_.drawn_m(slot, full_m), full_m, v.hole};
            triangle(m, apex, left);
            triangle(m, right, apex);
            return;
        }
        leaf(apex, left, right, finest);
    }

    // What hides under a triangle: at most error_m above and below it, inside the sphere.
    struct Hidden {
        double error_m = 0, radius_m = unlimited;
        Vec3 centre{};
    };
    [[nodiscard]] Hidden hidden_by(SampleIndex at, double shrink) const {
        const TerrainData::Vertex v = t_.vertex(at);
        return {static_cast<double>(v.error_m) * shrink * rounding, static_cast<double>(v.radius_m) * rounding,
                position(at, static_cast<double>(v.height_m))};
    }
    // Of the vertex in the middle, or, where its page is missing, of its parent.
    [[nodiscard]] Hidden hidden_under(const Corner& apex, SampleIndex middle, bool finest) const {
        if (finest) return {};
        if (t_.vertex(middle).loaded) return hidden_by(middle, 1);
        if (!t_.tree.is_corner(apex.at)) return hidden_by(apex.at, 1 / (1 + static_cast<double>(t_.header.nesting)));
        return {static_cast<double>(t_.range.error_m), unlimited, {}};
    }

    void leaf(const Corner& a, const Corner& b, const Corner& c, bool finest) {
        if (cross2(t_.tree.sample(a.at), t_.tree.sample(b.at), t_.tree.sample(c.at)) == 0) return; // not drawn
        const bool drawn = !a.hole && !b.hole && !c.hole;
        if (finest && !drawn) return; // at full resolution a rim is where it belongs
        const SampleIndex sum = b.at + c.at, middle{sum.column / 2, sum.row / 2};
        const Hidden hidden = hidden_under(a, middle, finest);
        double moved_m = 0; // by morphing
        for (const Corner* corner : {&a, &b, &c})
            moved_m = std::max(moved_m, std::abs(corner->drawn_m - corner->full_m));
        if (!measuring_) {
            if (drawn && !finest) at_middle(b, c, middle);
            return;
        }
        const double most_px = trusted_ || finest ? pixels(hidden, moved_m, a, b, c) : unlimited;
        if (most_px <= px_) return;
        px_ = std::max(px_, std::min(most_px, measured_px(hidden.error_m + moved_m, drawn, a, b, c)));
    }

    // A first estimate: the error in the middle of the edge that is not split.
    void at_middle(const Corner& b, const Corner& c, SampleIndex middle) {
        const TerrainData::Vertex v = t_.vertex(middle);
        if (!v.loaded || v.hole || middle != t_.tree.sample(middle) || b.at != t_.tree.sample(b.at) ||
            c.at != t_.tree.sample(c.at))
            return;
        px_ = std::max(px_, sample_px(middle, static_cast<double>(v.height_m), (b.drawn_m + c.drawn_m) / 2));
    }

    // Without looking at a sample.
    [[nodiscard]] double pixels(const Hidden& hidden, double moved_m, const Corner& a, const Corner& b,
                                const Corner& c) const {
        const double error_m = hidden.error_m + moved_m;
        if (error_m == 0) return 0;
        double nearest_m = box_distance(hidden.error_m, a, b, c);
        bool seen = corner_safe_;
        if (hidden.radius_m < unlimited) {
            const Vec3 from_eye = hidden.centre - view_.eye_m;
            nearest_m = std::max(nearest_m, length(from_eye) - hidden.radius_m - half_quantum_m_);
            for (int plane = 2; plane < 6 && seen; ++plane)
                seen = dot(frustum_.normal[plane], from_eye) >= -hidden.radius_m;
        }
        if (!(nearest_m > 0)) return unlimited;
        const double angular_px = error_m * lambda_ / nearest_m;
        if (!seen) return angular_px;
        // Error in perspective: corner_factor() for a small one; a large one may bring the surface nearer than the
        // sample, by tilt_ of the way to the camera's plane.
        const double nearer = 1 - angular_px * tilt_;
        return nearer > 0 ? std::max(angular_px, angular_px * factor_ / nearer) : unlimited;
    }

    // From the eye to the box around the triangle and what it hides.
    [[nodiscard]] double box_distance(double error_m, const Corner& a, const Corner& b, const Corner& c) const {
        Vec3 low = position(a.at, a.full_m), high = low;
        for (const Corner* corner : {&b, &c}) {
            const Vec3 p = position(corner->at, corner->full_m);
            low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
            high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
        }
        const double up = error_m + half_quantum_m_;
        const auto outside = [](double p, double least, double most) { return std::max({least - p, p - most, 0.0}); };
        const Vec3 eye = view_.eye_m;
        return length(
            {outside(eye.x, low.x, high.x), outside(eye.y, low.y - up, high.y + up), outside(eye.z, low.z, high.z)});
    }

    // Every sample under the triangle. error_m: of what cannot be measured, because the ground is not drawn there, or
    // is drawn where a hole is.
    [[nodiscard]] double measured_px(double error_m, bool drawn, const Corner& a, const Corner& b,
                                     const Corner& c) const {
        const SampleIndex pa = t_.tree.sample(a.at), pb = t_.tree.sample(b.at), pc = t_.tree.sample(c.at);
        const std::int64_t area = cross2(pa, pb, pc), sign = area > 0 ? 1 : -1;
        const auto [x0, x1] = std::minmax({pa.column, pb.column, pc.column});
        const auto [y0, y1] = std::minmax({pa.row, pb.row, pc.row});
        double most_px = 0, rim_px = 0;
        bool ground = false, hole = false;
        for (std::int32_t y = y0; y <= y1; ++y)
            for (std::int32_t x = x0; x <= x1; ++x) {
                const SampleIndex at{x, y};
                const std::int64_t wa = cross2(pb, pc, at) * sign, wb = cross2(pc, pa, at) * sign,
                                   wc = cross2(pa, pb, at) * sign;
                if (wa < 0 || wb < 0 || wc < 0) continue;
                const TerrainData::Vertex v = t_.vertex(at);
                if (!v.loaded) return unlimited;
                (v.hole ? hole : ground) = true;
                const auto height_m = static_cast<double>(v.height_m);
                rim_px = std::max(
                    {rim_px, sample_px(at, height_m, height_m + error_m), sample_px(at, height_m, height_m - error_m)});
                if (v.hole || !drawn) continue;
                const double surface_m = (static_cast<double>(wa) * a.drawn_m + static_cast<double>(wb) * b.drawn_m +
                                          static_cast<double>(wc) * c.drawn_m) /
                                         static_cast<double>(area * sign);
                most_px = std::max(most_px, sample_px(at, height_m, surface_m));
            }
        return ground && hole ? std::max(most_px, rim_px) : most_px;
    }

    [[nodiscard]] double sample_px(SampleIndex at, double height_m, double surface_m) const {
        const Vec3 sample = position(at, height_m) - view_.eye_m;
        const double error_m = std::max(std::abs(height_m - surface_m) - rounding_m_, 0.0);
        if (error_m == 0) return 0;
        const double distance_m = length(sample) - half_quantum_m_;
        if (!(distance_m > 0)) return unlimited;
        const double angular_px = error_m * lambda_ / distance_m;
        return corner_safe_ ? std::max(angular_px, perspective_px(sample, surface_m > height_m ? error_m : -error_m))
                            : angular_px;
    }

    // How far apart on screen a sample in the picture and the point so far above it are.
    [[nodiscard]] double perspective_px(const Vec3& sample, double above_m) const {
        for (int plane = 2; plane < 6; ++plane)
            if (dot(frustum_.normal[plane], sample) < 0) return 0;
        const Vec3 right = cross(view_.forward, view_.up), drawn = sample + Vec3{0, above_m, 0};
        const double depth_m = dot(view_.forward, sample), drawn_depth_m = dot(view_.forward, drawn);
        if (!(depth_m > 0) || !(drawn_depth_m > 0)) return unlimited;
        return lambda_ * std::hypot(dot(right, sample) / depth_m - dot(right, drawn) / drawn_depth_m,
                                    dot(view_.up, sample) / depth_m - dot(view_.up, drawn) / drawn_depth_m);
    }

    const TerrainData& t_;
    const Vertices& vertices_;
    const View& view_;
    Frustum frustum_;
    double lambda_;
    bool corner_safe_, trusted_; // trusted: errors bound samples, not only the middle
    bool measuring_ = false;
    double px_, rounding_m_, half_quantum_m_, factor_, tilt_;
    SampleIndex tile_{};
};

template <typename Vertices>
double bound_px(const TerrainData& terrain, const Vertices& vertices, std::span<const TileRange> tiles,
                const View& view, bool corner_safe, double at_least_px) {
    Bound<Vertices> bound(terrain, vertices, view, corner_safe, at_least_px);
    const auto pass = [&] {
        for (std::size_t i = 0; i < tiles.size(); ++i) // a tile's ranges follow each other
            if (i == 0 || tiles[i].tile != tiles[i - 1].tile) bound.tile(tiles[i].tile);
    };
    pass();
    bound.begin_to_measure();
    pass();
    return std::min(bound.px(), unbounded_px);
}

} // namespace

double bound_error_px(LiveCut cut, const View& view, bool corner_safe, double at_least_px) {
    const CutState* const s = find_cut(cut);
    if (s == nullptr || !validate(view).ok()) return unbounded_px;
    return bound_px(*s->pages.grid.terrain, CutVertices{s->pages, s->mesh, s->morphing.now},
                    {s->mesh.ranges, s->mesh.range_count}, view, corner_safe, at_least_px);
}

double bound_error_px(RecursiveMethod method, const View& view, bool corner_safe, double at_least_px) {
    const RecursiveState* const s = find_recursive(method);
    if (s == nullptr || !validate(view).ok()) return unbounded_px;
    return bound_px(*s->terrain, RecursiveVertices{*s}, {s->tiles, s->tile_count}, view, corner_safe, at_least_px);
}

} // namespace fjell
