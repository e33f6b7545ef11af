#include "baker/errors/unsaturated.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "baker/errors/triangle_scan.h"

namespace fjell::baker {

namespace {

// ---- triangles with holes, or squeezed at the rim

struct TriangleScan {
    double worst_steps = 0;
    bool ground = false, hole = false;
};

std::int64_t floor_div(std::int64_t a, std::int64_t b) { // b > 0
    return a >= 0 ? a / b : -((-a + b - 1) / b);
}

// The samples of row y inside the triangle, its edges included: from, to.
std::pair<std::int32_t, std::int32_t> row_of(const SampleIndex (&corners)[3], std::int32_t y) {
    std::int64_t from = INT32_MIN, to = INT32_MAX;
    for (int k = 0; k < 3; ++k) { // corners turn one way, so that inside is on the same side of all edges
        const SampleIndex p = corners[k], q = corners[(k + 1) % 3];
        const std::int64_t dx = q.column - p.column, dy = q.row - p.row;
        // dx (y - p.y) - dy (x - p.x) >= 0
        const std::int64_t c = dx * (y - p.row);
        if (dy > 0)
            to = std::min(to, p.column + floor_div(c, dy));
        else if (dy < 0)
            from = std::max(from, p.column - floor_div(c, -dy));
        else if (c < 0)
            return {0, -1};
    }
    return {static_cast<std::int32_t>(from), static_cast<std::int32_t>(to)};
}

// What lies under a triangle whose corners stand anywhere; none where it has no area: that is never drawn.
TriangleScan scan_triangle(const QuantisedHeights& ground, SampleIndex a, SampleIndex b, SampleIndex c) {
    TriangleScan sum;
    std::int64_t area =
        std::int64_t{b.column - a.column} * (c.row - a.row) - std::int64_t{b.row - a.row} * (c.column - a.column);
    if (area == 0) return sum;
    if (area < 0) std::swap(b, c), area = -area;
    const SampleIndex corners[3] = {a, b, c};
    const double ha = ground.h(a), hb = ground.h(b) - ha, hc = ground.h(c) - ha;
    const double gx = (hb * (c.row - a.row) - hc * (b.row - a.row)) / static_cast<double>(area);
    const double gy = (hc * (b.column - a.column) - hb * (c.column - a.column)) / static_cast<double>(area);
    const auto [y0, y1] = std::minmax({a.row, b.row, c.row});
    for (std::int32_t y = y0; y <= y1; ++y) {
        const auto [x0, x1] = row_of(corners, y);
        const double at_row = ha + gy * (y - a.row);
        for (std::int32_t x = x0; x <= x1; ++x) {
            if (ground.is_void({x, y})) {
                sum.hole = true;
                continue;
            }
            sum.ground = true;
            sum.worst_steps = std::max(sum.worst_steps, std::abs(ground.h({x, y}) - (at_row + gx * (x - a.column))));
        }
    }
    // Squeezed triangles divide by odd numbers: what is left of that is no error.
    if (sum.worst_steps < 0x1p-20) sum.worst_steps = 0;
    return sum;
}

double longest_edge_m(const UnsaturatedInput& in, SampleIndex a, SampleIndex b, SampleIndex c) {
    const auto edge = [&](SampleIndex p, SampleIndex q) {
        const double dx = std::abs(p.column - q.column) * in.spacing_m[0],
                     dy = std::abs(p.row - q.row) * in.spacing_m[1];
        const double dh = static_cast<double>(in.ground.h(p) - in.ground.h(q)) * in.scales.height_scale.quantum_m;
        return std::sqrt(dx * dx + dy * dy + dh * dh) + 2 * in.scales.ground_pad_m + in.scales.height_pad_m;
    };
    return std::max({edge(a, b), edge(b, c), edge(c, a)}) * (1 + 0x1p-20);
}

} // namespace

bool straddles_rim(const Tree& tree, SampleIndex v) {
    const std::int32_t s = 1 << Tree::step_log2(v);
    return (v.column + s >= tree.columns() && tree.cut_x != 0) || (v.row + s >= tree.rows() && tree.cut_y != 0);
}

UnsaturatedError unsaturated_error(const UnsaturatedInput& in, SampleIndex v) {
    const Tree& tree = in.ground.tree;
    const Diamond d = diamond(tree, v);
    const double quantum = in.scales.height_scale.quantum_m;
    // At the finest step, and for estimate 2, twice the surface's jump when the vertex is activated: that is what a
    // reader works out. Beside the rim triangles are squeezed, and measured whatever the estimate.
    const bool jump = !straddles_rim(tree, v) && (Tree::step_log2(v) == 0 || in.estimate == ErrorEstimate::midpoint);
    double error_m =
        jump ? 0.5 * quantum * std::abs(2.0 * in.ground.h(v) - in.ground.h(d.ends[0]) - in.ground.h(d.ends[1])) : 0;
    const bool hole_below = in.ground.is_void(d.ends[0]) || in.ground.is_void(d.ends[1]);
    double on_ground_m = hole_below || in.ground.is_void(v) ? 0 : error_m;
    bool ground = false;
    for (const SampleIndex apex : d.apexes) {
        if (apex.column < in.region.first.column || apex.row < in.region.first.row ||
            apex.column > in.region.last.column || apex.row > in.region.last.row)
            continue;
        const SampleIndex a = tree.sample(apex), b = tree.sample(d.ends[0]), c = tree.sample(d.ends[1]);
        const TriangleScan sum = scan_triangle(in.ground, a, b, c);
        ground = ground || sum.ground;
        if (!jump) error_m = std::max(error_m, sum.worst_steps * quantum);
        if (!jump && !hole_below && !in.ground.is_void(apex))
            on_ground_m = std::max(on_ground_m, sum.worst_steps * quantum);
        // A hole's rim is drawn to within the triangle's size.
        if (sum.ground && sum.hole)
            error_m = std::max({error_m, sum.worst_steps * quantum, longest_edge_m(in, a, b, c)});
    }
    if (!ground) return {};
    return {in.scales.errors.code_up(error_m), in.scales.errors.code_up(on_ground_m)};
}

namespace {

// Codes of small errors that are multiples of a unit, looked up instead of searched for.
class CodeTable {
public:
    void make(const ErrorScale& scale, double unit_m) {
        std::uint32_t code = 0;
        for (std::size_t k = 0; k < codes_.size(); ++k) {
            while (code < 255 && static_cast<double>(scale.metres[code]) < static_cast<double>(k) * unit_m) ++code;
            codes_[k] = static_cast<std::uint8_t>(code);
        }
        made_ = true;
    }
    void clear() { made_ = false; }
    [[nodiscard]] bool holds(std::int32_t k) const { return made_ && k < static_cast<std::int32_t>(codes_.size()); }
    [[nodiscard]] std::uint8_t at(std::int32_t k) const { return codes_[static_cast<std::size_t>(k)]; }
    static constexpr std::size_t size = 1024;

private:
    bool made_ = false;
    std::array<std::uint8_t, size> codes_;
};

class UnsaturatedErrors {
public:
    UnsaturatedErrors(const UnsaturatedInput& input, Patch<std::uint8_t>& out)
        : in(input), tree(input.ground.tree),
          half_quantum(0.5 * static_cast<double>(input.scales.height_scale.quantum_m)), to(out),
          worst(static_cast<std::size_t>(out.columns) + scan_slack) {}

    std::uint8_t worst_on_ground = 0; // where there are voids: then every vertex goes the slow way

    // Even rows of a step hold sides along x; odd ones sides along y, and centres between them.
    void run(int z) {
        const Region& r = in.region;
        const std::int32_t s = 1 << z, n = (r.last.column - r.first.column) / (2 * s);
        small = z <= 2 && in.estimate == ErrorEstimate::max && !in.ground.has_voids();
        if (small)
            phases = DeinterleavedSamples::of(in.ground.steps.at(r.first.column, r.first.row), in.ground.steps.columns,
                                              n, r.last.row - r.first.row + 1, 2 * s);
        table.clear();
        if (std::int64_t{n} * n >= static_cast<std::int64_t>(CodeTable::size))
            table.make(in.scales.errors, half_quantum / s);
        for (std::int32_t y = r.first.row; y <= r.last.row; y += s)
            if (((y >> z) & 1) == 0) {
                row(VertexKind::side_x, {r.first.column + s, y}, z, n);
            } else {
                row(VertexKind::side_y, {r.first.column, y}, z, n + 1);
                row(VertexKind::centre, {r.first.column + s, y}, z, n);
            }
    }

private:
    void row(VertexKind kind, SampleIndex first, int z, std::int32_t count) {
        const std::int32_t s = 1 << z;
        std::uint8_t* const codes = to.at(first.column / 2, first.row / 2);
        std::int32_t plain = in.ground.has_voids() ? 0 : count; // vertices before the first one that stands at the rim
        while (plain > 0 && straddles_rim(tree, {first.column + 2 * s * (plain - 1), first.row})) --plain;
        for (std::int32_t i = plain; i < count; ++i) {
            const UnsaturatedError e = unsaturated_error(in, {first.column + 2 * s * i, first.row});
            codes[i * s] = e.code;
            worst_on_ground = std::max(worst_on_ground, e.on_ground);
        }
        if (plain == 0) return;
        const std::int32_t* const v = in.ground.steps.at(first.column, first.row);
        const std::ptrdiff_t stride = in.ground.steps.columns;
        const bool root = z == tree.tile_log2 - 1;
        const bool falling = root || ((((first.column - s) >> (z + 1)) + ((first.row - s) >> (z + 1))) & 1) == 0;
        if (in.estimate == ErrorEstimate::midpoint) {
            for (std::int32_t i = 0; i < plain; ++i) {
                const std::int32_t* const h = v + std::ptrdiff_t{2} * s * i;
                const std::ptrdiff_t down = s * stride;
                const std::ptrdiff_t end = kind == VertexKind::side_x      ? s
                                           : kind == VertexKind::side_y    ? down
                                           : falling != (!root && (i & 1)) ? down + s
                                                                           : down - s;
                codes[i * s] = in.leaf.code(static_cast<std::uint32_t>(std::abs(2 * h[0] - h[-end] - h[end])));
            }
            return;
        }
        const bool rows = kind == VertexKind::side_x;
        VertexRow line{v, stride, s, plain, kind};
        line.before = !rows || first.row > in.region.first.row;
        line.after = !rows || first.row < in.region.last.row;
        line.falling = falling, line.alternate = !root;
        if (small && plain == count) {
            SmallRow side{phases, first.row - in.region.first.row, count, kind};
            side.before = line.before, side.after = line.after;
            side.falling = line.falling, side.alternate = line.alternate;
            scan_small_row(side, worst.data());
        } else if (kind == VertexKind::side_y) { // those on the region's borders are measured inside only
            if (plain > 1) scan(line, 1, plain - (plain == count ? 2 : 1));
            line.before = false;
            scan(line, 0, 1);
            if (plain == count) line.before = true, line.after = false, scan(line, count - 1, 1);
        } else {
            scan(line, 0, plain);
        }
        const double unit_m = half_quantum / s;
        for (std::int32_t i = 0; i < plain; ++i) {
            const std::int32_t k = worst[static_cast<std::size_t>(i)];
            codes[i * s] = table.holds(k) ? table.at(k) : in.scales.errors.code_up(k * unit_m);
        }
    }

    void scan(VertexRow line, std::int32_t from, std::int32_t count) {
        line.first += std::ptrdiff_t{2} * line.s * from;
        line.count = count;
        if (count > 0) scan_row(line, worst.data() + from);
    }

    const UnsaturatedInput& in;
    const Tree& tree;
    const double half_quantum;
    Patch<std::uint8_t>& to;
    std::vector<std::int32_t> worst;
    CodeTable table;
    bool small = false; // this step's vertices go side by side
    DeinterleavedSamples phases;
};

} // namespace

std::uint8_t unsaturated_errors(const UnsaturatedInput& input, Patch<std::uint8_t>& out) {
    const Region& r = input.region;
    out = {r.first.column / 2, r.first.row / 2, (r.last.column - r.first.column) / 2 + 1,
           (r.last.row - r.first.row) / 2 + 1};
    std::fill(out.values.begin(), out.values.end(), std::uint8_t{0}); // corners of tiles
    UnsaturatedErrors stage(input, out);
    for (int z = 1; z < input.ground.tree.tile_log2; ++z) stage.run(z);
    if (input.ground.has_voids()) return stage.worst_on_ground;
    std::uint8_t worst = 0;
    for (const std::uint8_t code : out.values) worst = std::max(worst, code);
    return worst;
}

} // namespace fjell::baker
