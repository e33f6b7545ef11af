// Rays: front to back through the tiles under the ray's line, and in each down the hierarchy of triangles.
//
// The ray is one parameter, s in metres along it. A tile is given a part of [0, most]; every split cuts a node's part
// in two or leaves it whole. So the parts of the leaves follow each other without gap or overlap whatever rounds, and
// nothing is clipped against triangles. A node is left out when the ray is, on both ends of its part, further from the
// unsplit plane than the error of the vertex that would split it: the difference is linear in s, and no descendant is
// further from that plane. The error bound is the bounding volume.
//
// Between leaves is remembered on which side of the ground the ray was. When the next leaf begins on the other one, it
// has passed between two triangles: by rounding, or where pages are missing and triangles do not meet. That is a hit
// too. Holes forget the side.
#include "fjell/query.h"
#include "query/steady.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <type_traits>

#include "query/ground.h"

namespace fjell {

using namespace query;

namespace {

// In cells and height scale steps.
struct Line {
    double x, y, h, dx, dy, dh;
    [[nodiscard]] Point over(double s) const { return {x + dx * s, y + dy * s}; }
    [[nodiscard]] double height(double s) const { return h + dh * s; }
    // Where it meets the line from a through b, if it does.
    [[nodiscard]] double meets(SampleIndex a, SampleIndex b, double s0) const {
        const double at = turn(a, b, over(s0));
        const double slope = static_cast<double>(b.column - a.column) * dy - static_cast<double>(b.row - a.row) * dx;
        return slope == 0 ? s0 : s0 - at / slope;
    }
};

struct Part {
    double from, to;
    [[nodiscard]] double middle() const { return 0.5 * (from + to); }
};

struct Node {
    enum class Kind : std::uint8_t { triangle, square, flat } kind = Kind::triangle;
    Part part{};
    double error_m = 0; // of a flat one
    union {
        Triangle triangle;
        Square square;
    };
    Node() {} // a stack of them is not cleared for every ray
    Node(const Triangle& what, Part where) : part(where), triangle(what) {}
    Node(const Square& what, Part where) : kind(Kind::square), part(where), square(what) {}
};
static_assert(std::is_trivially_copyable_v<Node>);

class RayWalk {
public:
    RayWalk(const TerrainData& terrain, const Line& ray, float accurate_m)
        : t(terrain), line(ray), accurate(accurate_code(terrain, accurate_m)),
          quantum_m(terrain.height_scale.quantum_m) {}

    // True: hit, see below.
    bool tile(std::int32_t tx, std::int32_t ty, Part part) {
        Reader reader(t, tx, ty);
        count = 0;
        const Square root = root_square(t, reader);
        if (cut_by_rim(t, root.nw, root.side))
            push_square(root, part);
        else
            push_halves(root, part);
        while (count != 0) {
            const Node node = stack[--count];
            switch (node.kind) {
            case Node::Kind::triangle:
                if (triangle(reader, node.triangle, node.part)) return true;
                break;
            case Node::Kind::square:
                if (square(reader, node.square, node.part)) return true;
                break;
            case Node::Kind::flat:
                if (meet(node.triangle, node.part, node.error_m, false)) return true;
                break;
            }
        }
        return false;
    }

    double hit_s = 0, hit_error_m = 0;
    bool hit_finest = false;
    Plane hit_plane;

private:
    // A triangle gives way to two; a square to at most six: three quarters, each whole or in halves. Levels: two for a
    // step of triangles, one for one of squares.
    static constexpr int stack_size = 2 + 2 * max_tile_log2 + 5 * max_tile_log2;
    Node stack[stack_size];
    int count = 0;
    const TerrainData& t;
    const Line line;
    const std::int32_t accurate; // code
    const double quantum_m;
    int side = 0; // of the ground: 1 above, -1 below, 0 not known
    double side_error_m = 0;

    void push(const Triangle& half, Part part) { stack[count++] = Node(half, part); }
    void push_flat(const Triangle& half, double error, Part part) {
        push(half, part);
        stack[count - 1].kind = Node::Kind::flat;
        stack[count - 1].error_m = error;
    }
    void push_square(const Square& s, Part part) { stack[count++] = Node(s, part); }
    // Parts of two halves on either side of the line from a through b; f(half, part), the far one first.
    template <class HalfOf, class F>
    void in_halves(SampleIndex a, SampleIndex b, Part part, HalfOf half_of, F f) {
        const double s = line.meets(a, b, part.from);
        if (!(s > part.from && s < part.to)) {
            f(half_of(line.over(part.middle())), part);
            return;
        }
        // The longer part tells them apart; of a short one rounding alone could say where it is.
        const Part near{part.from, s}, far{s, part.to};
        const bool by_near = near.to - near.from > far.to - far.from;
        const int half = half_of(line.over(by_near ? near.middle() : far.middle()));
        f(by_near ? 1 - half : half, far);
        f(by_near ? half : 1 - half, near);
    }
    void push_halves(const Square& s, Part part) {
        const Triangle half = s.half(0);
        in_halves(
            half.ends[0].at, half.ends[1].at, part, [&](Point p) { return s.half_of(p); },
            [&](int k, Part of) { push(s.half(k), of); });
    }

    bool triangle(Reader& reader, const Triangle& node, Part part) {
        if (node.leaf()) return meet(node, part, 0, true);
        const SampleIndex m = node.middle();
        const Sample sample = reader.read(m);
        if (!sample.loaded) return meet(node, part, error_m(t, node.bound), node.bound == 0);
        if (suffices(sample.error, accurate, node.hole()))
            return meet(node, part, error_m(t, sample.error), sample.error == 0);
        const Plane plane = plane_of(node.apex, node.ends[0], node.ends[1]);
        const double g0 = line.height(part.from) - plane.height(line.over(part.from)),
                     g1 = line.height(part.to) - plane.height(line.over(part.to));
        const double error_steps = error_m(t, sample.error) / quantum_m;
        if (passes(std::min(g0, g1) - error_steps, std::max(g0, g1) + error_steps, node.hole())) return false;
        const Corner middle{m, sample.steps, sample.hole};
        const std::int32_t bound = below(t, sample.error);
        in_halves(
            node.apex.at, m, part, [&](Point p) { return node.half_of(p); },
            [&](int k, Part of) { push(node.half(middle, k, bound), of); });
        return false;
    }

    // The ray is at least `above` over the ground of a node, and at most `below`. Which side it is on beside a hole is
    // not known: no ground, no bound.
    bool passes(double above, double below, bool hole) {
        const int now = above > 0 ? 1 : below < 0 ? -1 : 0;
        if (now == 0 || (side != 0 && side != now)) return false;
        side = hole ? 0 : now;
        side_error_m = 0;
        return true;
    }

    bool square(Reader& reader, const Square& s, Part part) {
        const Sample sample = reader.read(s.centre());
        if (!sample.loaded) {
            const double morph_from_m = error_m(t, s.bound) + spread_m(t, s);
            const Triangle half = s.half(0);
            in_halves(
                half.ends[0].at, half.ends[1].at, part, [&](Point p) { return s.half_of(p); },
                [&](int k, Part of) { push_flat(s.half(k), morph_from_m, of); });
            return false;
        }
        // Planes bend when the square is split, but no sample leaves the range of its corners by more than the error.
        double low = s.corners[0].steps, high = low;
        bool hole = false;
        for (const Corner& c : s.corners) {
            low = std::min(low, static_cast<double>(c.steps)), high = std::max(high, static_cast<double>(c.steps));
            hole = hole || c.hole;
        }
        const double h0 = line.height(part.from), h1 = line.height(part.to);
        const double error_steps = error_m(t, sample.error) / quantum_m;
        if (passes(std::min(h0, h1) - high - error_steps, std::max(h0, h1) - low + error_steps, hole)) return false;
        quarters(reader, s, corner_of(t, s.centre(), sample), sample.error, part);
        return false;
    }

    void quarters(Reader& reader, const Square& s, const Corner& centre, std::int32_t code, Part part) {
        double cuts[4] = {part.from, part.from, part.to, part.to};
        const auto within = [&](double at) { return at > part.from && at < part.to ? at : part.from; };
        const double x = within(line.meets(centre.at, centre.at + SampleIndex{0, 1}, part.from)),
                     y = within(line.meets(centre.at, centre.at + SampleIndex{1, 0}, part.from));
        cuts[1] = std::min(x, y), cuts[2] = std::max(x, y);
        for (int i = 2; i >= 0; --i) { // the far ones first
            const Part of{cuts[i], cuts[i + 1]};
            if (!(of.from < of.to) && !(i == 2 && part.from == part.to)) continue; // a vertical ray has one point
            const Point p = line.over(of.middle());
            const int k = quarter_at(t, centre.at, p);
            const Quarter q = quarter_of(t, reader, s, centre, code, k);
            if (q.kind == Quarter::Kind::square) {
                push_square(q.square, of);
                continue;
            }
            in_halves(
                q.diagonal[0], q.diagonal[1], of, [&](Point at) { return q.half_of(at); },
                [&](int h, Part half_part) {
                    if (q.flat[h])
                        push_flat(q.half[h], q.error_m[h], half_part);
                    else
                        push(q.half[h], half_part);
                });
        }
    }

    // The ray and the plane of a triangle that is not split.
    bool meet(const Triangle& leaf, Part part, double error, bool finest) {
        if (leaf.hole()) {
            side = 0;
            return false;
        }
        const Plane plane = plane_of(leaf.apex, leaf.ends[0], leaf.ends[1]);
        const double g0 = line.height(part.from) - plane.height(line.over(part.from)),
                     g1 = line.height(part.to) - plane.height(line.over(part.to));
        const bool between = side != 0 && g0 * side < 0;
        const bool through = g0 == 0 || g1 == 0 || (g0 < 0) != (g1 < 0);
        if (!between && !through) {
            side = g1 > 0 ? 1 : -1;
            side_error_m = error;
            return false;
        }
        hit_s = between || g0 == 0 ? part.from : part.from + (part.to - part.from) * (g0 / (g0 - g1));
        hit_error_m = between ? std::max(error, side_error_m) : error;
        hit_finest = finest && hit_error_m == 0;
        hit_plane = plane;
        return true;
    }
};

// The part of [from, to] in which low <= at + slope s <= high.
void clip(double at, double slope, double low, double high, Part& part) {
    if (slope == 0) {
        if (!(at >= low && at <= high)) part.to = -INFINITY;
        return;
    }
    const double a = (low - at) / slope, b = (high - at) / slope;
    part.from = std::max(part.from, std::min(a, b));
    part.to = std::min(part.to, std::max(a, b));
}

// The tiles under the line, one after the other.
bool walk_tiles(const TerrainData& t, const Line& line, Part whole, RayWalk& walk) {
    const double side = t.tree.side();
    const auto tile_at = [&](double at, std::int32_t tiles) {
        return static_cast<std::int32_t>(std::clamp(std::floor(at / side), 0.0, static_cast<double>(tiles - 1)));
    };
    const Point start = line.over(whole.from);
    std::int32_t tx = tile_at(start.x, t.tree.tiles_x), ty = tile_at(start.y, t.tree.tiles_y);
    double from = whole.from;
    for (;;) {
        const auto leaves = [&](double at, double slope, std::int32_t tile) {
            return slope == 0 ? INFINITY : ((slope > 0 ? tile + 1 : tile) * side - at) / slope;
        };
        const double x = leaves(line.x, line.dx, tx), y = leaves(line.y, line.dy, ty);
        const double to = std::max(from, std::min({x, y, whole.to}));
        if (walk.tile(tx, ty, {from, to})) return true;
        if (!(to < whole.to)) return false;
        if (x <= y)
            tx += line.dx > 0 ? 1 : -1;
        else
            ty += line.dy > 0 ? 1 : -1;
        if (tx < 0 || ty < 0 || tx >= t.tree.tiles_x || ty >= t.tree.tiles_y) return false;
        from = to;
    }
}

bool finite(Vec3 v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

GroundHit hit_now(const TerrainData& terrain, Vec3 origin_m, Vec3 direction, double most_m, float accurate_m) {
    const double largest = std::max({std::abs(direction.x), std::abs(direction.y), std::abs(direction.z)});
    if (!finite(origin_m) || !finite(direction) || !(largest > 0) || !(most_m >= 0)) return {};
    // Scaled first: squares of very long or short ones would not be numbers.
    const Vec3 along = normalised({direction.x / largest, direction.y / largest, direction.z / largest});
    const PackHeader& h = terrain.header;
    const double quantum = terrain.height_scale.quantum_m;
    const auto line_from = [&](Vec3 from) {
        return Line{from.x / h.spacing_m[0],
                    from.z / h.spacing_m[1],
                    (from.y - static_cast<double>(terrain.height_scale.base_m)) / quantum,
                    along.x / h.spacing_m[0],
                    along.z / h.spacing_m[1],
                    along.y / quantum};
    };
    const Line far = line_from(origin_m);
    Part part{0, most_m};
    clip(far.x, far.dx, 0, terrain.tree.columns() - 1, part);
    clip(far.y, far.dy, 0, terrain.tree.rows() - 1, part);
    // A step more than there is, against rounding.
    clip(far.h, far.dh, static_cast<double>(load_relaxed(terrain.range.low_steps)) - 1,
         static_cast<double>(load_relaxed(terrain.range.high_steps)) + 1, part);
    if (!(part.from <= part.to) || !std::isfinite(part.to)) return {};
    // From where it comes in: the way there may have been long, and its rounding is made once.
    const Vec3 entry = origin_m + along * part.from;
    const Line line = line_from(entry);
    RayWalk walk(terrain, line, accurate_m);
    if (!walk_tiles(terrain, line, {0, part.to - part.from}, walk)) return {};
    GroundHit hit;
    hit.hit = true;
    hit.finest = walk.hit_finest;
    hit.distance_m = part.from + walk.hit_s;
    hit.position_m = entry + along * walk.hit_s;
    hit.normal = normal_of(terrain, walk.hit_plane);
    hit.error_m = reported_m(terrain, walk.hit_error_m);
    return hit;
}

} // namespace

GroundHit cast_ray(const Terrain& handle, Vec3 origin_m, Vec3 direction, double most_m, float accurate_m) {
    const TerrainData* const data = find(handle);
    if (data == nullptr) return {};
    return steady(*data, [&] { return hit_now(*data, origin_m, direction, most_m, accurate_m); });
}

} // namespace fjell
