// Everything is measured in whole numbers: heights are lattice steps, and over a side of 2s cells a plane through three
// of them is a multiple of 1 / 2s at every sample. Heights in one tile span less than 2^16 steps, so differences times
// 2s <= 2^12 fit 32 bits, whatever multiples of 2^32 the terms before lost.
#include "baker/own.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "pack/clones.h"

namespace fjell::baker {

namespace {

using Steps = std::uint32_t; // modulo 2^32

// The largest |2s row[k] - (first + slope k)|. The compiler vectorises this: it is where the bake spends its time.
[[gnu::always_inline]] inline std::int32_t worst_of_row(const std::int32_t* row, std::int32_t count, Steps first,
                                                        Steps slope, int shift, std::int32_t worst) {
    for (std::int32_t k = 0; k < count; ++k) {
        const auto off = static_cast<std::int32_t>((static_cast<Steps>(row[k]) << shift) -
                                                   (first + slope * static_cast<Steps>(k)));
        const std::int32_t size = std::abs(off);
        worst = size > worst ? size : worst;
    }
    return worst;
}

struct Walk {
    const std::int32_t* v; // the vertex
    std::ptrdiff_t stride;
    std::int32_t s;
    int shift; // of 2s
    [[nodiscard]] Steps h(std::int32_t dx, std::int32_t dy) const { return static_cast<Steps>(v[dy * stride + dx]); }
};

// The triangle above (direction -1) or below a side along x: rows shrink from the hypotenuse to the apex.
[[gnu::always_inline]] inline std::int32_t side_x_half(const Walk& w, std::int32_t direction, std::int32_t worst) {
    const auto s = static_cast<Steps>(w.s);
    const Steps west = w.h(-w.s, 0), east = w.h(w.s, 0), apex = w.h(0, direction * w.s);
    const Steps slope = east - west, rise = 2 * apex - west - east;
    for (std::int32_t k = 0; k < w.s; ++k) {
        const std::int32_t half = w.s - k;
        worst = worst_of_row(w.v + direction * k * w.stride - half, 2 * half + 1,
                             (west + east) * s + rise * static_cast<Steps>(k) - slope * static_cast<Steps>(half), slope,
                             w.shift, worst);
    }
    return worst;
}

// The triangle west (direction -1) or east of a side along y.
[[gnu::always_inline]] inline std::int32_t side_y_half(const Walk& w, std::int32_t direction, std::int32_t worst) {
    const auto s = static_cast<Steps>(w.s);
    const Steps north = w.h(0, -w.s), south = w.h(0, w.s), apex = w.h(direction * w.s, 0);
    const Steps along = south - north, slope = direction < 0 ? north + south - 2 * apex : 2 * apex - north - south;
    for (std::int32_t r = -w.s + 1; r < w.s; ++r) {
        const std::int32_t width = w.s - std::abs(r), from = direction < 0 ? -width : 0;
        worst = worst_of_row(w.v + r * w.stride + from, width + 1,
                             (north + south) * s + along * static_cast<Steps>(r) + slope * static_cast<Steps>(from),
                             slope, w.shift, worst);
    }
    return worst;
}

// The square of side 2s, cut from north-west to south-east (falling) or from south-west to north-east.
[[gnu::always_inline]] inline std::int32_t centre_square(const Walk& w, bool falling, std::int32_t worst) {
    const Steps nw = w.h(-w.s, -w.s), ne = w.h(w.s, -w.s), sw = w.h(-w.s, w.s), se = w.h(w.s, w.s);
    const std::int32_t side = 2 * w.s;
    for (std::int32_t r = 0; r <= side; ++r) {
        const std::int32_t* const row = w.v + (r - w.s) * w.stride - w.s;
        const std::int32_t cut = falling ? r : side - r; // the last of the western triangle, the first of the eastern
        const auto t = static_cast<Steps>(r), c = static_cast<Steps>(cut);
        const Steps west_slope = falling ? se - sw : ne - nw, east_slope = falling ? ne - nw : se - sw;
        const Steps west = (nw << w.shift) + (sw - nw) * t;
        const Steps on_cut = west + west_slope * c;
        worst = worst_of_row(row, cut + 1, west, west_slope, w.shift, worst);
        worst = worst_of_row(row + cut, side - cut + 1, on_cut, east_slope, w.shift, worst);
    }
    return worst;
}

// ---- triangles with holes, or squeezed at the rim ------------------------------------------------------------------

struct TriangleSum {
    double worst_steps = 0;
    bool ground = false, hole = false;
};

std::int64_t floor_div(std::int64_t a, std::int64_t b) { // b > 0
    return a >= 0 ? a / b : -((-a + b - 1) / b);
}

// The samples of row y inside the triangle, its edges included: from, to.
std::pair<std::int32_t, std::int32_t> row_of(const Coord (&corners)[3], std::int32_t y) {
    std::int64_t from = INT32_MIN, to = INT32_MAX;
    for (int k = 0; k < 3; ++k) { // corners turn one way, so that inside is on the same side of all edges
        const Coord p = corners[k], q = corners[(k + 1) % 3];
        const std::int64_t dx = q.x - p.x, dy = q.y - p.y;
        // dx (y - p.y) - dy (x - p.x) >= 0
        const std::int64_t c = dx * (y - p.y);
        if (dy > 0)
            to = std::min(to, p.x + floor_div(c, dy));
        else if (dy < 0)
            from = std::max(from, p.x - floor_div(c, -dy));
        else if (c < 0)
            return {0, -1};
    }
    return {static_cast<std::int32_t>(from), static_cast<std::int32_t>(to)};
}

// What lies under a triangle whose corners stand anywhere; none where it has no area: that is never drawn.
TriangleSum walk_triangle(const Ground& ground, Coord a, Coord b, Coord c) {
    TriangleSum sum;
    std::int64_t area = std::int64_t{b.x - a.x} * (c.y - a.y) - std::int64_t{b.y - a.y} * (c.x - a.x);
    if (area == 0) return sum;
    if (area < 0) std::swap(b, c), area = -area;
    const Coord corners[3] = {a, b, c};
    const double ha = ground.h(a), hb = ground.h(b) - ha, hc = ground.h(c) - ha;
    const double gx = (hb * (c.y - a.y) - hc * (b.y - a.y)) / static_cast<double>(area);
    const double gy = (hc * (b.x - a.x) - hb * (c.x - a.x)) / static_cast<double>(area);
    const auto [y0, y1] = std::minmax({a.y, b.y, c.y});
    for (std::int32_t y = y0; y <= y1; ++y) {
        const auto [x0, x1] = row_of(corners, y);
        const double at_row = ha + gy * (y - a.y);
        for (std::int32_t x = x0; x <= x1; ++x) {
            if (ground.is_void({x, y})) {
                sum.hole = true;
                continue;
            }
            sum.ground = true;
            sum.worst_steps = std::max(sum.worst_steps, std::abs(ground.h({x, y}) - (at_row + gx * (x - a.x))));
        }
    }
    // Squeezed triangles divide by odd numbers: what is left of that is no error.
    if (sum.worst_steps < 0x1p-20) sum.worst_steps = 0;
    return sum;
}

double longest_edge_m(const OwnInput& in, Coord a, Coord b, Coord c) {
    const auto edge = [&](Coord p, Coord q) {
        const double dx = std::abs(p.x - q.x) * in.spacing_m[0], dy = std::abs(p.y - q.y) * in.spacing_m[1];
        const double dh = static_cast<double>(in.ground.h(p) - in.ground.h(q)) * in.scales.lattice.quantum_m;
        return std::sqrt(dx * dx + dy * dy + dh * dh) + 2 * in.scales.ground_pad_m + in.scales.height_pad_m;
    };
    return std::max({edge(a, b), edge(b, c), edge(c, a)}) * (1 + 0x1p-20);
}

} // namespace

bool straddles_rim(const Tree& tree, Coord v) {
    const std::int32_t s = 1 << Tree::step_log2(v);
    return (v.x + s >= tree.columns() && tree.cut_x != 0) || (v.y + s >= tree.rows() && tree.cut_y != 0);
}

std::uint8_t own_error(const OwnInput& in, Coord v) {
    const Tree& tree = in.ground.tree;
    const Diamond d = diamond(tree, v);
    const double quantum = in.scales.lattice.quantum_m;
    // At the finest step, and for estimate 2, twice the surface's jump when the vertex comes in: that is what a reader
    // works out. Beside the rim triangles are squeezed, and measured whatever the estimate.
    const bool jump = !straddles_rim(tree, v) && (Tree::step_log2(v) == 0 || in.estimate == Estimate::midpoint);
    double error_m = jump ? 0.5 * quantum * std::abs(2.0 * in.ground.h(v) - in.ground.h(d.ends[0]) - in.ground.h(d.ends[1]))
                          : 0;
    bool ground = false;
    for (const Coord apex : d.apexes) {
        if (apex.x < in.region.first.x || apex.y < in.region.first.y || apex.x > in.region.last.x ||
            apex.y > in.region.last.y)
            continue;
        const Coord a = tree.sample(apex), b = tree.sample(d.ends[0]), c = tree.sample(d.ends[1]);
        const TriangleSum sum = walk_triangle(in.ground, a, b, c);
        ground = ground || sum.ground;
        if (!jump) error_m = std::max(error_m, sum.worst_steps * quantum);
        // A hole's rim is drawn to within the triangle's size.
        if (sum.ground && sum.hole) error_m = std::max({error_m, sum.worst_steps * quantum, longest_edge_m(in, a, b, c)});
    }
    return ground ? in.scales.errors.code_up(error_m) : std::uint8_t{0};
}

namespace {

class OwnErrors {
public:
    OwnErrors(const OwnInput& input, Patch<std::uint8_t>& out)
        : in(input), tree(input.ground.tree), half_quantum(0.5 * static_cast<double>(input.scales.lattice.quantum_m)),
          to(out) {}

    [[gnu::always_inline]] void run() {
        const Region& r = in.region;
        for (int z = 1; z < tree.tile_log2; ++z) {
            const std::int32_t s = 1 << z;
            for (std::int32_t y = r.first.y; y <= r.last.y; y += s) {
                const bool side_row = ((y >> z) & 1) == 0;
                // Even rows hold sides along x; odd ones centres, and sides along y between them.
                for (std::int32_t x = r.first.x + (side_row ? s : 0); x <= r.last.x; x += side_row ? 2 * s : s)
                    *to.at(x / 2, y / 2) = code({x, y}, z);
            }
        }
    }

private:
    [[gnu::always_inline]] std::uint8_t code(Coord v, int z) const {
        if (in.ground.has_voids() || straddles_rim(tree, v)) return own_error(in, v);
        const std::int32_t s = 1 << z;
        const Walk w{in.ground.steps.at(v.x, v.y), in.ground.steps.columns, s, z + 1};
        const bool odd_x = (v.x >> z) & 1, odd_y = (v.y >> z) & 1;
        const bool falling = z == tree.tile_log2 - 1 || ((((v.x - s) >> (z + 1)) + ((v.y - s) >> (z + 1))) & 1) == 0;
        if (in.estimate == Estimate::midpoint) {
            const Steps ends = !odd_y   ? w.h(-s, 0) + w.h(s, 0)
                               : !odd_x ? w.h(0, -s) + w.h(0, s)
                               : falling ? w.h(-s, -s) + w.h(s, s)
                                         : w.h(-s, s) + w.h(s, -s);
            return in.leaf.code(static_cast<std::uint32_t>(std::abs(static_cast<std::int32_t>(2 * w.h(0, 0) - ends))));
        }
        std::int32_t worst = 0;
        if (odd_x && odd_y) {
            worst = centre_square(w, falling, 0);
        } else if (odd_x) {
            if (v.y > in.region.first.y) worst = side_x_half(w, -1, worst);
            if (v.y < in.region.last.y) worst = side_x_half(w, 1, worst);
        } else {
            if (v.x > in.region.first.x) worst = side_y_half(w, -1, worst);
            if (v.x < in.region.last.x) worst = side_y_half(w, 1, worst);
        }
        return in.scales.errors.code_up(std::ldexp(static_cast<double>(worst), -z) * half_quantum);
    }

    const OwnInput& in;
    const Tree& tree;
    const double half_quantum;
    Patch<std::uint8_t>& to;
};

FJELL_CLONES void run(OwnErrors& stage) {
    stage.run();
}

} // namespace

void own_errors(const OwnInput& input, Patch<std::uint8_t>& out) {
    const Region& r = input.region;
    out = {r.first.x / 2, r.first.y / 2, (r.last.x - r.first.x) / 2 + 1, (r.last.y - r.first.y) / 2 + 1};
    OwnErrors stage(input, out);
    run(stage);
}

} // namespace fjell::baker
