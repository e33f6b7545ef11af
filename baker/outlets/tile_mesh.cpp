#include "baker/outlets/tile_mesh.h"

#include <algorithm>
#include <cmath>

#include "baker/outlets/bisect.h"

namespace fjell::baker {

namespace {

constexpr Tree tile_tree{tile_grid_log2, 1, 1};
// Of the tolerance: what float coordinates of ground, and decoding in float, may add to an error.
constexpr double float_share = 2e-4;
constexpr double least_facing = 0.01; // steeper triangles are as good as upright: only the linear reading counts

std::uint32_t key_of(SampleIndex at) {
    return static_cast<std::uint32_t>(at.row) << 16 | static_cast<std::uint32_t>(at.column);
}

GlobePlace operator-(const GlobePlace& a, const GlobePlace& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
double dot(const GlobePlace& a, const GlobePlace& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
GlobePlace cross(const GlobePlace& a, const GlobePlace& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

class Refinement {
public:
    Refinement(const GroundSurface& surface, const SampleFinder& finder, const DegreeBox& box, const TileRules& rules)
        : surface_(surface), finder_(finder), rules_(rules), middle_(on_globe(box.middle(), 0)) {
        mesh_.box = box;
        constexpr double share = 1.0 / 8;
        surface.collect(box, rules.tolerance_m * share, ground_);
        mesh_.ground = ground_.size();
        std::vector<std::uint32_t> all(ground_.size());
        for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = i;
        const SampleIndex sw{0, 0}, se{tile_grid, 0}, nw{0, tile_grid}, ne{tile_grid, tile_grid};
        add(sw, ne, nw, beyond(all, sw, ne, nw));
        add(ne, sw, se, beyond(all, sw, ne, se));
    }

    TileMesh run(const BorderVertices& wanted) {
        const std::int32_t step = tile_grid >> rules_.coarsest_log2;
        for (std::int32_t y = 0; y <= tile_grid; y += step)
            for (std::int32_t x = 0; x <= tile_grid; x += step)
                if (!tile_tree.is_corner({x, y})) activate({x, y});
        for (std::size_t side = 0; side < 4; ++side)
            for (const std::int32_t along : wanted[side]) {
                const std::int32_t across = side == TileSide::west || side == TileSide::south ? 0 : tile_grid;
                activate(side == TileSide::west || side == TileSide::east ? SampleIndex{across, along}
                                                                          : SampleIndex{along, across});
            }
        while (!splits_.empty()) {
            const SampleIndex next = splits_.back();
            splits_.pop_back();
            activate(next);
        }
        finish();
        return std::move(mesh_);
    }

private:
    struct Corner {
        double u, v, height_m;
        GlobePlace place; // from the tile's middle
        GlobePlace foot;  // the same at height 0, from the globe's middle
    };
    struct Triangle { // a to b: its hypotenuse; counter-clockwise
        SampleIndex a, b, c;
        std::vector<std::uint32_t> ground;
        double error_m = 0;
        bool split = false;
    };

    const Corner& corner(SampleIndex at) {
        const auto [found, fresh] = corners_.try_emplace(key_of(at));
        if (!fresh) return found->second;
        const LonLat place = mesh_.place({at, 0});
        const double height_m =
            std::round(surface_.height_m(finder_, place) / rules_.height_step_m) * rules_.height_step_m;
        return found->second = {static_cast<double>(quantized(at.column)) / quantized_most,
                                static_cast<double>(quantized(at.row)) / quantized_most, height_m,
                                on_globe(place, height_m) - middle_, on_globe(place, 0)};
    }

    static SampleIndex middle(const Triangle& t) { return {(t.a.column + t.b.column) / 2, (t.a.row + t.b.row) / 2}; }

    void add(SampleIndex a, SampleIndex b, SampleIndex c, std::vector<std::uint32_t> ground) {
        Triangle t{a, b, c, std::move(ground)};
        t.error_m = error_m(t);
        const bool can_split = ((a.column + b.column) & 1) == 0 && ((a.row + b.row) & 1) == 0;
        if (can_split) {
            const SampleIndex m = middle(t);
            if (t.error_m > rules_.tolerance_m * (1 - 2 * float_share)) splits_.push_back(m);
            auto& both = over_.try_emplace(key_of(m), std::array<std::int64_t, 2>{-1, -1}).first->second;
            both[both[0] < 0 ? 0 : 1] = static_cast<std::int64_t>(triangles_.size());
        }
        triangles_.push_back(std::move(t));
    }

    void activate(SampleIndex v) {
        if (active_.contains(key_of(v))) return;
        for (const SampleIndex apex : diamond(tile_tree, v).apexes)
            if (tile_tree.contains(apex) && !tile_tree.is_corner(apex)) activate(apex);
        active_.insert(key_of(v));
        for (const std::int64_t i : over_.at(key_of(v)))
            if (i >= 0) split(static_cast<std::size_t>(i), v);
    }

    // How far the straight line between two corners lies beside the line that is straight in degrees, at most.
    std::array<double, 2> beside(const Corner& p, const Corner& q) const {
        const LonLat straight =
            lon_lat_of({(p.foot[0] + q.foot[0]) / 2, (p.foot[1] + q.foot[1]) / 2, (p.foot[2] + q.foot[2]) / 2});
        const DegreeBox& b = mesh_.box;
        const double u = (near_longitude(straight.longitude, b.middle().longitude) - b.west) / (b.east - b.west),
                     v = (straight.latitude - b.south) / (b.north - b.south);
        constexpr double more = 1.5;
        return {more * std::abs(u - (p.u + q.u) / 2), more * std::abs(v - (p.v + q.v) / 2)};
    }

    // What of the ground is on that side of the line from p to q, or on it.
    std::vector<std::uint32_t> beyond(const std::vector<std::uint32_t>& ground, SampleIndex from, SampleIndex to,
                                      SampleIndex there) {
        const Corner p = corner(from), q = corner(to), r = corner(there);
        const double x = q.u - p.u, y = q.v - p.v;
        const double side = x * (r.v - p.v) - y * (r.u - p.u) > 0 ? 1 : -1;
        const auto [off_u, off_v] = beside(p, q);
        constexpr double rounding = 1.0 / quantized_most; // a hypotenuse's middle lies on it, but for this
        std::vector<std::uint32_t> kept;
        kept.reserve(ground.size());
        for (const std::uint32_t i : ground) {
            const GroundPiece& g = ground_[i];
            const double s = side * (x * (static_cast<double>(g.v) - p.v) - y * (static_cast<double>(g.u) - p.u));
            const double reach = std::abs(x) * (static_cast<double>(g.dv) + off_v + rounding) +
                                 std::abs(y) * (static_cast<double>(g.du) + off_u + rounding);
            if (s >= -reach) kept.push_back(i);
        }
        return kept;
    }

    // The shorter a line, the less it bends: what was on the hypotenuse is looked at again.
    void split(std::size_t which, SampleIndex m) {
        const Triangle t = std::move(triangles_[which]);
        triangles_[which].split = true;
        add(t.c, t.a, m, beyond(beyond(t.ground, t.c, m, t.a), t.a, m, t.c));
        add(t.b, t.c, m, beyond(beyond(t.ground, t.c, m, t.b), m, t.b, t.c));
    }

    double error_m(const Triangle& t) {
        if (t.ground.empty()) return 0;
        const Corner a = corner(t.a), b = corner(t.b), c = corner(t.c);
        // Linear in degrees.
        const double bu = b.u - a.u, bv = b.v - a.v, cu = c.u - a.u, cv = c.v - a.v, area = bu * cv - bv * cu;
        const double bh = b.height_m - a.height_m, ch = c.height_m - a.height_m;
        const double by_u = (bh * cv - ch * bv) / area, by_v = (ch * bu - bh * cu) / area;
        // Flat in space: a plane through three places, seen along the ground's up. At a pole corners are one place.
        const GlobePlace ab = b.place - a.place, ac = c.place - a.place, normal = cross(ab, ac);
        const double longest = std::sqrt(std::max({dot(ab, ab), dot(ac, ac), dot(ac - ab, ac - ab)}));
        const double through = dot(normal, a.place), doubled = std::sqrt(dot(normal, normal));
        const bool flat = doubled > 1e-9 * longest * longest;
        // All that lies between its corners is between their heights, but for the globe's curve under it.
        const double lowest = std::min({a.height_m, b.height_m, c.height_m}) - longest * longest / (4 * globe_radius_m),
                     highest = std::max({a.height_m, b.height_m, c.height_m});
        double worst = 0;
        for (const std::uint32_t i : t.ground) {
            const GroundPiece& g = ground_[i];
            const double low = static_cast<double>(g.low), high = static_cast<double>(g.high);
            const bool block = g.du > 0 || g.dv > 0;
            const double within = block ? std::abs(by_u) * static_cast<double>(g.du) +
                                              std::abs(by_v) * static_cast<double>(g.dv) +
                                              half_m(g) * longest / globe_radius_m
                                        : 0;
            const double linear =
                a.height_m + by_u * (static_cast<double>(g.u) - a.u) + by_v * (static_cast<double>(g.v) - a.v);
            double error = std::max(high - linear, linear - low) + within;
            const GlobePlace up{static_cast<double>(g.up[0]), static_cast<double>(g.up[1]),
                                static_cast<double>(g.up[2])};
            const GlobePlace at{static_cast<double>(g.place[0]), static_cast<double>(g.place[1]),
                                static_cast<double>(g.place[2])};
            const double facing = dot(normal, up);
            if (flat && facing > least_facing * doubled) {
                const double height = (through - dot(normal, at)) / facing;
                error = std::max({error, high - height + within, height - low + within});
            }
            // A block may be larger than the triangle, whose plane does not matter beyond its corners.
            if (block) error = std::min(error, std::max(high - lowest, highest - low));
            worst = std::max(worst, error);
        }
        return worst;
    }
    // Half of a block's size in metres, generously.
    double half_m(const GroundPiece& g) const {
        constexpr double degree_m = 111.7e3;
        return degree_m * (static_cast<double>(g.du) * (mesh_.box.east - mesh_.box.west) +
                           static_cast<double>(g.dv) * (mesh_.box.north - mesh_.box.south));
    }

    void finish() {
        for (const std::uint32_t key : active_) {
            const auto x = static_cast<std::uint16_t>(key & 0xffff), y = static_cast<std::uint16_t>(key >> 16);
            if (x == 0) mesh_.borders[TileSide::west].push_back(y);
            if (x == tile_grid) mesh_.borders[TileSide::east].push_back(y);
            if (y == 0) mesh_.borders[TileSide::south].push_back(x);
            if (y == tile_grid) mesh_.borders[TileSide::north].push_back(x);
        }
        for (auto& border : mesh_.borders) std::sort(border.begin(), border.end());
        double worst = 0;
        for (const Triangle& t : triangles_)
            if (!t.split) worst = std::max(worst, t.error_m);
        mesh_.error_m = worst + rules_.tolerance_m * float_share;
        for (std::size_t i = 0; i < 2; ++i) {
            const Triangle& root = triangles_[i];
            bisect_triangle(
                root.c, root.a, root.b, [&](SampleIndex at) { return active_.contains(key_of(at)); },
                [&](SampleIndex apex, SampleIndex from, SampleIndex to) {
                    draw({from, to, apex});
                });
        }
    }
    void draw(const std::array<SampleIndex, 3>& at) {
        std::array<std::uint32_t, 3> t{};
        for (std::size_t i = 0; i < 3; ++i) {
            const auto [found, fresh] =
                numbers_.try_emplace(key_of(at[i]), static_cast<std::uint32_t>(mesh_.vertices.size()));
            if (fresh) mesh_.vertices.push_back({at[i], corner(at[i]).height_m});
            t[i] = found->second;
        }
        mesh_.triangles.push_back(t);
    }

    const GroundSurface& surface_;
    const SampleFinder& finder_;
    const TileRules& rules_;
    const GlobePlace middle_;
    TileMesh mesh_;
    std::vector<GroundPiece> ground_;
    std::deque<Triangle> triangles_;
    std::unordered_map<std::uint32_t, std::array<std::int64_t, 2>> over_; // by the middles of their hypotenuses
    std::unordered_map<std::uint32_t, Corner> corners_;
    std::unordered_map<std::uint32_t, std::uint32_t> numbers_;
    std::unordered_set<std::uint32_t> active_;
    std::vector<SampleIndex> splits_;
};

} // namespace

TileMesh make_tile_mesh(const GroundSurface& surface, const SampleFinder& finder, const DegreeBox& box,
                        const TileRules& rules, const BorderVertices& wanted) {
    return Refinement(surface, finder, box, rules).run(wanted);
}

} // namespace fjell::baker
