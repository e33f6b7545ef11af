// World-space errors and bounding radii, leaves to root (thesis 5.3.2, its last paragraph; DESIGN invariants 2 and 3).
//
// The terrain is one vertex tree: children across tile borders need no special case. Planes are visited from the finest
// step to the coarsest, sides before centres, so every child is final when its parents read it. Inside a plane vertices
// are independent: rows go to threads.
#include "baker/bake.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "baker/parallel.h"

namespace fjell::baker {

namespace {

// The parent's sphere is larger by this factor than containment asks for: more than the roundings of a distance in
// float, so that spheres that touch nest in float arithmetic too.
constexpr double sphere_margin = 1 + 0x1p-16;

class ErrorStage {
public:
    ErrorStage(const ErrorInput& input, VertexErrors& out)
        : in(input), tree(input.tree), columns(input.dem.columns), rows(input.dem.rows), errors(out),
          surface(input.steps.size()) {
        const std::size_t count = input.steps.size();
        double off = 0;
        for (std::size_t i = 0; i < count; ++i) {
            surface[i] = in.lattice.height_m(in.steps[i]);
            off = std::max(off, std::abs(static_cast<double>(surface[i]) - in.dem.heights_m[i]));
        }
        // A lossless lattice differs from the source by float rounding only. Measuring against the surface alone then
        // keeps flat ground at exactly zero; the difference is far below the half quantum every bound allows for.
        // Otherwise both count: the original, which is what is promised, and the quantised sample, which is what anyone
        // who has only the pack can check.
        lossless = off <= in.lattice.quantum_m * 0x1p-10;
        // Positions are rounded to float: 2^-24 relative, on each axis; heights to half a quantum.
        const double extent = std::max({tree.columns() * in.dem.spacing_m[0], tree.rows() * in.dem.spacing_m[1], 1e4});
        position_pad = extent * 0x1p-22 + 0.5 * in.lattice.quantum_m;
    }

    void run(const Progress& progress) {
        const auto total = static_cast<std::uint64_t>(errors.error.size());
        for (int z = 0; z < tree.tile_log2; ++z) {
            const std::int32_t nx = (tree.lattice_columns() - 1) >> (z + 1), ny = (tree.lattice_rows() - 1) >> (z + 1);
            const std::int32_t s = 1 << z;
            plane(nx, ny + 1, z, {s, 0});
            plane(nx + 1, ny, z, {0, s});
            plane(nx, ny, z, {s, s});
            if (progress) progress("errors", total - (total >> (2 * (z + 1))), total);
        }
        for (const std::uint16_t e : errors.error) errors.max_error_m = std::max(errors.max_error_m, from_bfloat16(e));
    }

private:
    void plane(std::int32_t count_x, std::int32_t count_y, int z, Coord first) {
        parallel_for(count_y, in.threads, [&](std::int64_t j) {
            for (std::int32_t i = 0; i < count_x; ++i)
                vertex({first.x + (i << (z + 1)), first.y + (static_cast<std::int32_t>(j) << (z + 1))});
        });
    }

    void vertex(Coord v) {
        double error = straddles_rim(v)               ? rim_error(v)
                       : in.estimate == Estimate::max ? diamond_error(v)
                                                      : midpoint_error(v);
        double radius = 0;
        const Children kids = children(v);
        for (int k = 0; k < kids.count; ++k) {
            const Coord c = kids.at[k];
            if (!tree.contains(c)) continue;
            const std::size_t at = place(c);
            error = std::max(error, (1 + in.nesting) * from_bfloat16(errors.error[at]));
            radius = std::max(radius, distance(v, c) + from_bfloat16(errors.radius[at]));
        }
        if (kids.count == 0) radius = leaf_radius(v);
        errors.error[place(v)] = to_bfloat16_up(error);
        errors.radius[place(v)] = to_bfloat16_up(radius * sphere_margin);
    }

    // A leaf's sphere holds the corners of its triangles.
    double leaf_radius(Coord v) const {
        double radius = 0;
        const Diamond d = diamond(tree, v);
        for (const Coord corner : {d.ends[0], d.ends[1], d.apexes[0], d.apexes[1]})
            if (tree.contains(corner)) radius = std::max(radius, distance(v, corner));
        return radius + position_pad;
    }

    // Does the diamond reach beyond the last column or row?
    [[nodiscard]] bool straddles_rim(Coord v) const {
        const std::int32_t s = 1 << Tree::step_log2(v);
        return (v.x + s >= columns && tree.cut_x != 0) || (v.y + s >= rows && tree.cut_y != 0);
    }

    // Both estimates, at the rim: the diamond's triangles with their corners where they stand, any samples under them.
    double rim_error(Coord v) const {
        const Diamond d = diamond(tree, v);
        double worst = 0;
        for (const Coord apex : d.apexes)
            if (tree.contains(apex))
                worst =
                    std::max(worst, triangle_error(tree.sample(apex), tree.sample(d.ends[0]), tree.sample(d.ends[1])));
        return worst;
    }

    double triangle_error(Coord a, Coord b, Coord c) const {
        const auto turn = [](Coord p, Coord q, Coord r) { // twice the area, signed
            return std::int64_t{q.x - p.x} * (r.y - p.y) - std::int64_t{q.y - p.y} * (r.x - p.x);
        };
        const std::int64_t area = turn(a, b, c), sign = area < 0 ? -1 : 1;
        if (area == 0) return 0; // never drawn
        const auto [x0, x1] = std::minmax({a.x, b.x, c.x});
        const auto [y0, y1] = std::minmax({a.y, b.y, c.y});
        double worst = 0;
        for (std::int32_t y = y0; y <= y1; ++y)
            for (std::int32_t x = x0; x <= x1; ++x) {
                const Coord p{x, y};
                const std::int64_t wa = turn(b, c, p) * sign, wb = turn(c, a, p) * sign, wc = turn(a, b, p) * sign;
                if (wa < 0 || wb < 0 || wc < 0) continue;
                const double on =
                    (static_cast<double>(wa) * h(a) + static_cast<double>(wb) * h(b) + static_cast<double>(wc) * h(c)) /
                    static_cast<double>(area * sign);
                worst = std::max(worst, row_error(p, 1, on, 0));
            }
        return worst;
    }

    // Estimate 2: the surface's jump when the vertex comes in.
    double midpoint_error(Coord v) const {
        const Diamond d = diamond(tree, v);
        const double middle = (h(d.ends[0]) + h(d.ends[1])) / 2;
        return std::max(std::abs(middle - h(v)), lossless ? 0 : std::abs(middle - in.dem.heights_m[index(v)]));
    }

    // Estimate 1: the diamond's two triangles against every sample under them.
    double diamond_error(Coord v) const {
        const std::int32_t s = 1 << Tree::step_log2(v);
        switch (Tree::kind(v)) {
        case PlaneKind::side_x: return side_x_error(v, s);
        case PlaneKind::side_y: return side_y_error(v, s);
        case PlaneKind::centre: break;
        }
        return centre_error(v, s);
    }

    // Rows shrink from the hypotenuse, which lies along the middle row, to the two apexes.
    double side_x_error(Coord v, std::int32_t s) const {
        const double west = h({v.x - s, v.y}), east = h({v.x + s, v.y}), middle = (west + east) / 2;
        const double slope = (east - west) / (2.0 * s);
        double worst = 0;
        for (const std::int32_t direction : {-1, 1}) {
            const Coord apex{v.x, v.y + direction * s};
            if (!tree.contains(apex)) continue;
            const double rise = (h(apex) - middle) / s;
            for (std::int32_t k = 0; k < s; ++k) {
                const std::int32_t half = s - k;
                worst = std::max(worst, row_error({v.x - half, v.y + direction * k}, 2 * half + 1,
                                                  middle + rise * k - slope * half, slope));
            }
        }
        return worst;
    }

    double side_y_error(Coord v, std::int32_t s) const {
        const double north = h({v.x, v.y - s}), south = h({v.x, v.y + s}), middle = (north + south) / 2;
        const double along = (south - north) / (2.0 * s);
        const bool has_west = v.x - s >= 0, has_east = v.x + s < columns;
        const double west_slope = has_west ? (middle - h({v.x - s, v.y})) / s : 0;
        const double east_slope = has_east ? (h({v.x + s, v.y}) - middle) / s : 0;
        double worst = 0;
        for (std::int32_t r = -s + 1; r < s; ++r) {
            const std::int32_t width = s - std::abs(r);
            const double centre = middle + along * r;
            if (has_west)
                worst = std::max(worst,
                                 row_error({v.x - width, v.y + r}, width + 1, centre - west_slope * width, west_slope));
            if (has_east) worst = std::max(worst, row_error({v.x, v.y + r}, width + 1, centre, east_slope));
        }
        return worst;
    }

    // The square of side 2s, cut by one diagonal or the other; in row y + r the cut stands at column x + cut.
    double centre_error(Coord v, std::int32_t s) const {
        const double nw = h({v.x - s, v.y - s}), ne = h({v.x + s, v.y - s}), sw = h({v.x - s, v.y + s}),
                     se = h({v.x + s, v.y + s});
        const double span = 2.0 * s;
        const bool falling = diamond(tree, v).ends[0] == Coord{v.x - s, v.y - s}; // from north-west to south-east
        double worst = 0;
        for (std::int32_t r = -s; r <= s; ++r) {
            const std::int32_t cut = falling ? r : -r;
            // Heights on the square's west and east side in this row, and on the cut.
            const double t = (r + s) / span;
            const double west = nw + (sw - nw) * t, east = ne + (se - ne) * t;
            const double on_cut = falling ? nw + (se - nw) * t : ne + (sw - ne) * t;
            const std::int32_t left = cut + s, right = s - cut;
            if (left > 0)
                worst = std::max(worst, row_error({v.x - s, v.y + r}, left + 1, west, (on_cut - west) / left));
            if (right > 0)
                worst = std::max(worst, row_error({v.x + cut, v.y + r}, right + 1, on_cut, (east - on_cut) / right));
        }
        return worst;
    }

    // Largest |sample - (first + slope k)| over `count` samples of a row.
    double row_error(Coord from, std::int32_t count, double first, double slope) const {
        const double worst = row_error(surface.data() + index(from), count, first, slope);
        return lossless ? worst
                        : std::max(worst, row_error(in.dem.heights_m.data() + index(from), count, first, slope));
    }

    // The compiler vectorises this one (see CMakeLists.txt): it is where the bake spends its time.
    static double row_error(const float* row, std::int32_t count, double first, double slope) {
        double worst = 0;
        for (std::int32_t k = 0; k < count; ++k) {
            const double off = std::abs(static_cast<double>(row[k]) - (first + slope * k));
            worst = off > worst ? off : worst;
        }
        return worst;
    }

    // Of a vertex among all of them, and of a sample of the terrain.
    [[nodiscard]] std::size_t place(Coord c) const {
        return static_cast<std::size_t>(c.y) * static_cast<std::size_t>(tree.lattice_columns()) +
               static_cast<std::size_t>(c.x);
    }
    [[nodiscard]] std::size_t index(Coord c) const {
        return static_cast<std::size_t>(c.y) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(c.x);
    }
    [[nodiscard]] double h(Coord c) const { return surface[index(c)]; }
    // Between vertices as the runtime places them: float products, then exact differences.
    [[nodiscard]] double distance(Coord v, Coord w) const {
        const Coord a = tree.sample(v), b = tree.sample(w);
        const auto sx = static_cast<float>(in.dem.spacing_m[0]), sz = static_cast<float>(in.dem.spacing_m[1]);
        const double dx = static_cast<double>(static_cast<float>(a.x) * sx) - static_cast<float>(b.x) * sx;
        const double dz = static_cast<double>(static_cast<float>(a.y) * sz) - static_cast<float>(b.y) * sz;
        const double dy = h(a) - h(b);
        return std::sqrt(dx * dx + dy * dy + dz * dz);
    }

    const ErrorInput& in;
    const Tree tree;
    const std::int32_t columns, rows; // samples
    VertexErrors& errors;
    std::vector<float> surface; // quantised heights
    bool lossless = false;
    double position_pad = 0;
};

} // namespace

VertexErrors compute_errors(const ErrorInput& input, const Progress& progress) {
    VertexErrors out;
    const auto vertices =
        static_cast<std::size_t>(input.tree.lattice_columns()) * static_cast<std::size_t>(input.tree.lattice_rows());
    out.error.assign(vertices, 0);
    out.radius.assign(vertices, 0);
    ErrorStage(input, out).run(progress);
    return out;
}

} // namespace fjell::baker
