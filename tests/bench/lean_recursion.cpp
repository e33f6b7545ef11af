#include "bench/lean_recursion.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "shared/terrain_data.h"
#include "view/wanted.h"

namespace fjell::bench {

namespace {

// Both quad trees, that of the centres and the tilted one of the sides, lie in one array: a vertex of either stands
// where the other has a ghost. The corners come first, in the order of a walk around the square.
constexpr std::uint32_t centre = 6, first_side = 7; // the sides' middles follow in the same order

// The two vertices that split the halves of a triangle. middle splits its hypotenuse, parent the one before it.
constexpr std::uint32_t first_half(std::uint32_t parent, std::uint32_t middle) {
    return 4 * parent + ((2 * parent + middle + 2) & 3) - 11;
}
constexpr std::uint32_t second_half(std::uint32_t parent, std::uint32_t middle) {
    return 4 * parent + ((2 * parent + middle + 3) & 3) - 11;
}

constexpr SampleIndex between(SampleIndex a, SampleIndex b) {
    return {(a.column + b.column) / 2, (a.row + b.row) / 2};
}

// Calls set(index, coordinate) for every vertex, inner ones twice.
template <typename Set>
void walk(std::uint32_t parent, std::uint32_t middle, SampleIndex from, SampleIndex to, SampleIndex apex, int levels,
          const Set& set) {
    if (levels == 0) return;
    const SampleIndex at = between(from, to);
    set(middle, at);
    walk(middle, first_half(parent, middle), from, apex, at, levels - 1, set);
    walk(middle, second_half(parent, middle), apex, to, at, levels - 1, set);
}

template <typename Set>
void walk_square(std::int32_t side, int levels, const Set& set) {
    const SampleIndex corners[] = {{0, side}, {side, side}, {side, 0}, {0, 0}},
                      middle = between(corners[0], corners[2]);
    for (std::uint32_t i = 0; i < 4; ++i) set(i, corners[i]);
    set(centre, middle);
    for (std::uint32_t i = 0; i < 4; ++i)
        walk(centre, first_side + i, corners[i], corners[(i + 1) % 4], middle, levels - 1, set);
}

constexpr std::uint32_t all_planes = 0b111111, outside = 0xffffffff;

// One frame. A strip's vertices of even and of odd levels alternate; where two of a kind meet, the one before the last
// comes once more.
class Pass {
public:
    Pass(const LeanVertex* vertices, const View& view, double error_px, std::uint32_t* strip, std::uint32_t* strip_end)
        : vertices_(vertices), reach_(make_reach(view, error_px)), end_(strip), last_(strip_end - 4) {
        const Frustum frustum = make_frustum(view);
        for (int i = 0; i < 6; ++i) {
            const Vec3& n = frustum.normal[i];
            planes_[i] = {static_cast<float>(n.x), static_cast<float>(n.y), static_cast<float>(n.z),
                          static_cast<float>(frustum.offset[i] + dot(n, view.eye_m))};
        }
        end_[0] = end_[1] = 0; // the first corner, twice, as if there had been one of the other kind before
        ++end_;
    }

    template <bool Cull>
    LeanRecursion::Frame run(int levels) {
        for (std::uint32_t i = 0; i < 4; ++i) {
            refine<false, Cull>(centre, first_side + i, levels - 1, Cull ? all_planes : 0);
            append((i + 1) & 3, true);
        }
        return {triangles_, end_ < last_};
    }
    [[nodiscard]] std::uint32_t* end() const { return end_ + 1; }

private:
    struct Plane {
        float x, y, z, offset;
    };

    // The triangle whose apex is `parent`, in the mesh: its halves, if `middle` splits it, on both sides of the apex.
    // levels: how many there are from `middle` on. Odd: of the apex' level.
    template <bool Odd, bool Cull>
    void refine(std::uint32_t parent, std::uint32_t middle, int levels, std::uint32_t planes) {
        if (levels != 0) {
            const LeanVertex& v = vertices_[middle];
            if (Cull) planes = crossed(v, planes);
            if ((!Cull || planes != outside) && wanted(reach_, v.x_m, v.y_m, v.z_m, v.error_m, v.radius_m)) {
                __builtin_prefetch(&vertices_[4 * middle - 11]);
                ++triangles_;
                if (Cull && planes != 0) {
                    refine<!Odd, true>(middle, first_half(parent, middle), levels - 1, planes);
                    append(parent, Odd);
                    return refine<!Odd, true>(middle, second_half(parent, middle), levels - 1, planes);
                }
                refine<!Odd, false>(middle, first_half(parent, middle), levels - 1, 0);
                append(parent, Odd);
                return refine<!Odd, false>(middle, second_half(parent, middle), levels - 1, 0);
            }
        }
        append(parent, Odd);
    }

    // Of the planes given, those that the sphere crosses.
    std::uint32_t crossed(const LeanVertex& v, std::uint32_t planes) const {
        std::uint32_t left = 0;
        for (; planes != 0; planes &= planes - 1) {
            const auto i = static_cast<std::size_t>(std::countr_zero(planes));
            const float d = planes_[i].x * v.x_m + planes_[i].y * v.y_m + planes_[i].z * v.z_m - planes_[i].offset;
            if (d < -v.radius_m) return outside;
            if (d < v.radius_m) left |= 1u << i;
        }
        return left;
    }

    [[gnu::always_inline]] void append(std::uint32_t vertex, bool odd) {
        if (vertex == end_[0] || vertex == end_[-1]) return;
        if (end_ >= last_) return;
        if (odd == odd_)
            end_[1] = end_[-1], ++end_;
        else
            odd_ = odd;
        *++end_ = vertex;
    }

    const LeanVertex* vertices_;
    Reach reach_;
    Plane planes_[6];
    std::uint32_t *end_, *last_; // the newest index; where the strip is full
    std::uint32_t triangles_ = 4;
    bool odd_ = false;
};

} // namespace

LeanRecursion::LeanRecursion(const Terrain& terrain, std::size_t strip) : strip_(strip + 8) {
    const TerrainData& data = data_of(terrain);
    const std::int32_t side = data.tree.grid_columns() - 1;
    levels_ = 2 * std::countr_zero(static_cast<std::uint32_t>(side));
    std::uint32_t last = 0;
    walk_square(side, levels_, [&](std::uint32_t index, SampleIndex) { last = std::max(last, index); });
    vertices_.resize(last + 1);
    walk_square(side, levels_, [&](std::uint32_t index, SampleIndex c) {
        const TerrainData::Vertex v = data.vertex(c);
        const bool always = data.tree.is_corner(c);
        constexpr float infinite = std::numeric_limits<float>::infinity();
        vertices_[index] = {terrain.x_m(c.column), v.height_m, terrain.z_m(c.row), always ? infinite : v.error_m,
                            always ? infinite : v.radius_m};
    });
}

LeanRecursion::Frame LeanRecursion::refine(const View& view, double error_px, bool cull) {
    Pass pass(vertices_.data(), view, error_px, strip_.data(), strip_.data() + strip_.size());
    const Frame frame = cull ? pass.run<true>(levels_) : pass.run<false>(levels_);
    strip_count_ = static_cast<std::size_t>(pass.end() - strip_.data()) - 1;
    return frame;
}

} // namespace fjell::bench
