// The ground as queries see it: right isosceles triangles, split from a tile's corners downwards as far as pages are
// there (thesis 2.5.1).
//
// A triangle is split at the middle of its hypotenuse, by the vertex of the diamond it is half of; that vertex' error_m
// bounds how far any sample under the unsplit triangle is from it. Ground between samples is linear on triangles that
// nest in all coarser ones, so the same holds everywhere on it. Splits look at this tile's pages and at this triangle
// only: neither at parents nor across. With all pages there that is the one full-resolution surface; where some are
// missing two triangles may not meet, by no more than their errors.
//
// Squares that the terrain's rim cuts are the exception. Their vertices stand at the rim, so diagonals bend when they
// are split, and a triangle's halves are not parts of it. Only the squares themselves nest. There one goes down from
// square to square, all four corners known, until a square lies wholly inside; and because a fine triangle may lie
// under two coarse ones, the bound between samples grows by what the two differ by within a cell (spread()).
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <utility>

#include "fjell/view.h"
#include "query/reader.h"
#include "query/way.h"
#include "shared/terrain_data.h"

namespace fjell::query {

// A corner of a triangle, where it stands: samples, and the height in height scale steps.
struct Corner {
    SampleIndex at;
    std::int32_t steps = 0;
    bool hole = false;
};

// Errors go as codes of the pack's scale, so that nothing rounds and nothing is looked up on the way.
inline constexpr std::int32_t any_error = -1; // not known: the largest of the terrain
[[nodiscard]] inline double error_m(const TerrainData& t, std::int32_t code) {
    return static_cast<double>(code == any_error ? load_relaxed(t.range.error_m) : t.errors.metres[code]);
}
// The most that a child's error can be, by nesting.
[[nodiscard]] inline std::int32_t below(const TerrainData& t, std::int32_t code) {
    return std::max(code - static_cast<std::int32_t>(t.errors.nesting_steps), 0);
}

// A plane over the ground, in height scale steps a cell.
struct Plane {
    SampleIndex at;
    double steps = 0, x = 0, y = 0;
    bool exists = false; // the triangle has an area
    [[nodiscard]] double height(Point p) const { return steps + x * (p.x - at.column) + y * (p.y - at.row); }
};
[[nodiscard]] inline Plane plane_of(const Corner& a, const Corner& b, const Corner& c) {
    const double bx = b.at.column - a.at.column, by = b.at.row - a.at.row, cx = c.at.column - a.at.column,
                 cy = c.at.row - a.at.row;
    const double hb = static_cast<double>(b.steps) - a.steps, hc = static_cast<double>(c.steps) - a.steps;
    const double area = bx * cy - by * cx;
    if (area == 0) return {a.at, static_cast<double>(a.steps), 0, 0, false};
    return {a.at, static_cast<double>(a.steps), (hb * cy - hc * by) / area, (hc * bx - hb * cx) / area, true};
}

// Which side of the line from a through b: 0 on it.
[[nodiscard]] inline double turn(SampleIndex a, SampleIndex b, Point p) {
    return static_cast<double>(b.column - a.column) * (p.y - a.row) -
           static_cast<double>(b.row - a.row) * (p.x - a.column);
}
[[nodiscard]] inline double turn(SampleIndex a, SampleIndex b, SampleIndex p) {
    return turn(a, b, Point{static_cast<double>(p.column), static_cast<double>(p.row)});
}

// --- triangles

struct Triangle {
    Corner apex, ends[2];           // the right angle; the hypotenuse
    std::int32_t bound = any_error; // of the vertex that splits it, should it not be there: the largest code
    [[nodiscard]] bool hole() const { return apex.hole || ends[0].hole || ends[1].hole; }
    // Half of a cell: of the full resolution.
    [[nodiscard]] bool leaf() const { return ((ends[0].at.column ^ ends[1].at.column) & 1) != 0; }
    [[nodiscard]] SampleIndex middle() const {
        return {(ends[0].at.column + ends[1].at.column) / 2, (ends[0].at.row + ends[1].at.row) / 2};
    }
    // The half that has ends[k].
    [[nodiscard]] Triangle half(const Corner& middle_, int k, std::int32_t bound_) const {
        return {middle_, {apex, ends[k]}, bound_};
    }
    // Which half p is in; on their border the first.
    [[nodiscard]] int half_of(Point p) const {
        const SampleIndex m = middle();
        return turn(apex.at, m, p) * turn(apex.at, m, ends[0].at) >= 0 ? 0 : 1;
    }
};

// --- squares that the rim cuts

// How much gradients differ: the most by which two of the planes differ at a place within a cell of where they meet.
struct Spread {
    double low_x = INFINITY, high_x = -INFINITY, low_y = INFINITY, high_y = -INFINITY;
    void add(const Plane& p) {
        if (!p.exists) return;
        low_x = std::min(low_x, p.x), high_x = std::max(high_x, p.x);
        low_y = std::min(low_y, p.y), high_y = std::max(high_y, p.y);
    }
    [[nodiscard]] double steps() const { return low_x > high_x ? 0 : high_x - low_x + high_y - low_y; }
};

// corners: [0] north-west, [1] north-east, [2] south-west, [3] south-east, where they stand; nw and side: on the
// height_scale.
struct Square {
    SampleIndex nw;
    std::int32_t side = 0;
    bool falling = true; // its diagonal runs from north-west to south-east
    Corner corners[4];
    std::int32_t bound = any_error; // of its centre, should it not be there

    [[nodiscard]] SampleIndex centre() const { return {nw.column + side / 2, nw.row + side / 2}; }
    // Its halves: the one with the south-west or, rising, the north-west corner first.
    [[nodiscard]] Triangle half(int k) const {
        if (falling) return {corners[k == 0 ? 2 : 1], {corners[0], corners[3]}, bound};
        return {corners[k == 0 ? 0 : 3], {corners[1], corners[2]}, bound};
    }
    [[nodiscard]] int half_of(Point p) const {
        const Triangle first = half(0);
        return turn(first.ends[0].at, first.ends[1].at, p) * turn(first.ends[0].at, first.ends[1].at, first.apex.at) >=
                       0
                   ? 0
                   : 1;
    }
};

[[nodiscard]] inline bool cut_by_rim(const TerrainData& t, SampleIndex nw, std::int32_t side) {
    return nw.column + side >= t.tree.columns() || nw.row + side >= t.tree.rows();
}
// The quarter that has p: never one without an area, beyond a centre that stands at the rim.
[[nodiscard]] inline int quarter_at(const TerrainData& t, SampleIndex centre, Point p) {
    return (p.x > centre.column && centre.column < t.tree.columns() - 1 ? 1 : 0) +
           (p.y > centre.row && centre.row < t.tree.rows() - 1 ? 2 : 0);
}
[[nodiscard]] inline Corner corner_of(const TerrainData& t, SampleIndex v, const Sample& sample) {
    return {t.tree.sample(v), sample.steps, sample.hole};
}

// The tile's own square, as it is without any page.
[[nodiscard]] inline Square root_square(const TerrainData& t, Reader& reader) {
    Square s;
    s.nw = reader.origin();
    s.side = t.tree.side();
    for (int k = 0; k < 4; ++k) {
        const SampleIndex v{s.nw.column + (k & 1) * s.side, s.nw.row + (k >> 1) * s.side};
        s.corners[k] = corner_of(t, v, reader.read(v));
    }
    return s;
}

// What a quarter of a square (north-west 0, north-east 1, south-west 2, south-east 3) becomes once the square's centre
// is active.
struct Quarter {
    enum class Kind { square, halves } kind = Kind::halves;
    Square square; // of kind square
    // Otherwise both halves: the one beside the square's northern or southern side, and the one beside its western or
    // eastern one. `flat`: not split further here, because a page is missing; then the plane is of all four corners'
    // triangle, and error_m holds.
    Triangle half[2];
    bool flat[2] = {false, false};
    double error_m[2] = {0, 0};
    SampleIndex diagonal[2]; // between the halves

    [[nodiscard]] int half_of(Point p) const {
        // half[0] has the corner's row; what lies beside it decides.
        return turn(diagonal[0], diagonal[1], p) * turn(diagonal[0], diagonal[1], side_of_first) >= 0 ? 0 : 1;
    }
    SampleIndex side_of_first;
};

[[nodiscard]] inline double spread_m(const TerrainData& t, const Square& s, const Corner& centre) {
    Spread spread;
    for (const auto& [a, b] : {std::pair{0, 1}, {1, 3}, {3, 2}, {2, 0}})
        spread.add(plane_of(centre, s.corners[a], s.corners[b]));
    return spread.steps() * static_cast<double>(t.height_scale.quantum_m);
}
[[nodiscard]] inline double spread_m(const TerrainData& t, const Square& s) {
    Spread spread;
    for (const int k : {0, 1}) {
        const Triangle half = s.half(k);
        spread.add(plane_of(half.apex, half.ends[0], half.ends[1]));
    }
    return spread.steps() * static_cast<double>(t.height_scale.quantum_m);
}

// One quarter of a square whose centre is `centre`, a vertex with error code `code`.
[[nodiscard]] inline Quarter quarter_of(const TerrainData& t, Reader& reader, const Square& s, const Corner& centre,
                                        std::int32_t code, int k) {
    const std::int32_t half = s.side / 2;
    const SampleIndex at = s.centre(), nw{s.nw.column + (k & 1) * half, s.nw.row + (k >> 1) * half};
    const SampleIndex beside_row{at.column, s.nw.row + (k >> 1) * s.side},
        beside_column{s.nw.column + (k & 1) * s.side, at.row};
    const Sample samples[2] = {reader.read(beside_row), reader.read(beside_column)};
    const Corner sides[2] = {corner_of(t, beside_row, samples[0]), corner_of(t, beside_column, samples[1])};
    const Corner& own = s.corners[k];
    Quarter q;
    q.diagonal[0] = own.at;
    q.diagonal[1] = centre.at;
    q.side_of_first = sides[0].at;
    if (cut_by_rim(t, nw, half) && samples[0].loaded && samples[1].loaded) {
        q.kind = Quarter::Kind::square;
        q.square.nw = nw;
        q.square.side = half;
        q.square.falling = k == 0 || k == 3;
        q.square.corners[k] = own;
        q.square.corners[3 - k] = centre;
        q.square.corners[k ^ 1] = sides[0];
        q.square.corners[k ^ 2] = sides[1];
        q.square.bound = below(t, std::min(samples[0].error, samples[1].error));
        return q;
    }
    const double morph_from_m = error_m(t, below(t, code)) + spread_m(t, s, centre);
    for (int i = 0; i < 2; ++i) {
        q.flat[i] = cut_by_rim(t, nw, half) || !samples[i].loaded;
        if (q.flat[i]) { // all of the triangle over that side of the square
            q.half[i] = {centre, {own, s.corners[i == 0 ? k ^ 1 : k ^ 2]}, any_error};
            q.error_m[i] = morph_from_m;
        } else {
            q.half[i] = {sides[i], {own, centre}, below(t, samples[i].error)};
        }
    }
    return q;
}

// --- what answers say

// The bound as answers report it: with half a quantum for the original, rounded up.
[[nodiscard]] inline float reported_m(const TerrainData& t, double error_m) {
    const double whole = error_m + 0.5 * static_cast<double>(t.height_scale.quantum_m);
    const auto rounded = static_cast<float>(whole);
    return static_cast<double>(rounded) < whole ? std::nextafter(rounded, INFINITY) : rounded;
}
// The largest code whose error is good enough; any_error: none is.
[[nodiscard]] inline std::int32_t accurate_code(const TerrainData& t, float accurate_m) {
    const double most_m = static_cast<double>(accurate_m) - 0.5 * static_cast<double>(t.height_scale.quantum_m);
    if (!(most_m >= 0)) return any_error;
    std::int32_t enough = 0; // how many codes are
    for (std::int32_t step = 128; step != 0; step /= 2)
        if (error_m(t, enough + step - 1) <= most_m) enough += step;
    return enough - 1;
}
// A triangle whose vertex has that code need not be split: it is exact, or good enough.
[[nodiscard]] inline bool suffices(std::int32_t code, std::int32_t accurate, bool hole) {
    return code <= accurate || (code == 0 && !hole);
}
[[nodiscard]] inline Vec3 normal_of(const TerrainData& t, const Plane& plane) {
    const double quantum = t.height_scale.quantum_m;
    return normalised({-plane.x * quantum / t.header.spacing_m[0], 1, -plane.y * quantum / t.header.spacing_m[1]});
}

// The finest triangle that is loaded under a point.
struct Found {
    Plane plane;
    double error_m = 0;
    bool hole = false, finest = false;
};

// --- the way down to a point

[[nodiscard]] inline Found follow(const TerrainData& t, Reader& reader, const Triangle& from, const Way& way,
                                  std::int32_t accurate) {
    struct Height {
        std::int32_t steps;
        bool hole;
    };
    Height height[Way::given + 2 * max_tile_log2];
    height[0] = {from.apex.steps, from.apex.hole};
    for (const std::uint32_t k : {0u, 1u}) height[1 + k] = {from.ends[k].steps, from.ends[k].hole};
    std::uint32_t a = 0, b = 1, c = 2; // the triangle: places on the way
    const auto hole = [&] { return height[a].hole || height[b].hole || height[c].hole; };
    const auto found = [&](std::int32_t code) {
        const auto corner = [&](std::uint32_t k) {
            return Corner{{static_cast<std::int32_t>(way.spot[k].x) + reader.origin().column,
                           static_cast<std::int32_t>(way.spot[k].y) + reader.origin().row},
                          height[k].steps,
                          height[k].hole};
        };
        return Found{plane_of(corner(a), corner(b), corner(c)), error_m(t, code), hole(), code == 0};
    };
    std::int32_t bound = from.bound;
    for (std::uint32_t k = Way::given; k < way.end; ++k) {
        VertexRecord record;
        if (!reader.read(way.at[k], record)) return found(bound);
        if (record.error <= accurate || (record.error == 0 && !hole())) return found(record.error);
        bound = below(t, record.error);
        height[k] = {reader.base() + record.height, is_void(record)};
        b = choose(way.half[k], b, c);
        c = a;
        a = k;
    }
    return found(0);
}

// The same in linear order, where every vertex has to be looked up by itself.
[[nodiscard]] inline Found find_below_linear(const TerrainData& t, Reader& reader, Triangle at, Point p,
                                             std::int32_t accurate) {
    const auto found = [&](std::int32_t code) {
        return Found{plane_of(at.apex, at.ends[0], at.ends[1]), error_m(t, code), at.hole(), code == 0};
    };
    while (!at.leaf()) {
        const SampleIndex m = at.middle();
        const Sample sample = reader.read(m);
        if (!sample.loaded) return found(at.bound);
        if (suffices(sample.error, accurate, at.hole())) return found(sample.error);
        at = {{m, sample.steps, sample.hole}, {at.ends[at.half_of(p)], at.apex}, below(t, sample.error)};
    }
    return found(0);
}

[[nodiscard]] inline Found find_below(const TerrainData& t, Reader& reader, const Triangle& from, Point p,
                                      std::int32_t accurate) {
    if (t.pages.order == PageOrder::linear) return find_below_linear(t, reader, from, p, accurate);
    const SampleIndex origin = reader.origin();
    const auto in_tile = [&](const Corner& c) {
        return Spot{static_cast<std::uint32_t>(c.at.column - origin.column),
                    static_cast<std::uint32_t>(c.at.row - origin.row)};
    };
    Way way;
    way.spot[0] = in_tile(from.apex);
    for (const int k : {0, 1}) way.spot[1 + k] = in_tile(from.ends[k]);
    if (t.pages.order == PageOrder::planar)
        find_way<PageOrder::planar>(t.pages, reader, p, way);
    else
        find_way<PageOrder::hierarchical_z>(t.pages, reader, p, way);
    return follow(t, reader, from, way, accurate);
}

// p: in the tile, within the terrain. O(levels).
[[nodiscard]] inline Found find_ground(const TerrainData& t, Reader& reader, Point p, std::int32_t accurate) {
    Square s = root_square(t, reader);
    if (!cut_by_rim(t, s.nw, s.side)) return find_below(t, reader, s.half(s.half_of(p)), p, accurate);
    for (;;) { // never satisfied in a square that is cut: its halves do not nest
        const Sample sample = reader.read(s.centre());
        if (!sample.loaded) {
            const Triangle half = s.half(s.half_of(p));
            return {plane_of(half.apex, half.ends[0], half.ends[1]), error_m(t, s.bound) + spread_m(t, s), half.hole(),
                    false};
        }
        const Corner centre = corner_of(t, s.centre(), sample);
        const int k = quarter_at(t, centre.at, p);
        const Quarter q = quarter_of(t, reader, s, centre, sample.error, k);
        if (q.kind == Quarter::Kind::square) {
            s = q.square;
            continue;
        }
        const int i = q.half_of(p);
        const Triangle& half = q.half[i];
        if (q.flat[i]) return {plane_of(half.apex, half.ends[0], half.ends[1]), q.error_m[i], half.hole(), false};
        return find_below(t, reader, half, p, accurate);
    }
}

// The tile over a point of the terrain.
[[nodiscard]] inline SampleIndex tile_of(const TerrainData& t, Point p) {
    const std::int32_t side = t.tree.side();
    const SampleIndex tile{std::min(static_cast<std::int32_t>(p.x) / side, t.tree.tiles_x - 1),
                           std::min(static_cast<std::int32_t>(p.y) / side, t.tree.tiles_y - 1)};
    if (!t.is_sparse()) return tile;
    // Between samples no other tile has it: one that is beside a border's line is not on it.
    const auto on_sample = [](double at) { return std::floor(at) < at ? -1 : static_cast<std::int32_t>(at); };
    return t.tile_with({on_sample(p.x), on_sample(p.y)}, tile);
}

[[nodiscard]] inline double height_m(const TerrainData& t, double steps) {
    return static_cast<double>(t.height_scale.base_m) + steps * static_cast<double>(t.height_scale.quantum_m);
}

} // namespace fjell::query
