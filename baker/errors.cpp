// World-space errors and bounding radii, leaves to root (thesis 5.3.2, its last paragraph; DESIGN invariants 2 and 3).
//
// The terrain is one vertex tree: children across tile borders need no special case. Planes are visited from the finest
// step to the coarsest, sides before centres, so every child is final when its parents read it. Inside a plane vertices
// are independent: rows go to threads.
#include "baker/bake.h"

#include <algorithm>
#include <cmath>

#include "baker/parallel.h"

namespace fjell::baker {

namespace {

// The parent's sphere is larger by this factor than containment asks for: more than the roundings of a distance in
// float, so that spheres that touch nest in float arithmetic too.
constexpr double sphere_margin = 1 + 0x1p-16;

// What one vertex' diamond says: the worst difference under it, and how much of it is a hole.
struct DiamondSum {
    double worst_steps = 0;
    std::uint64_t samples = 0, voids = 0; // counted only where the terrain has holes
};

class ErrorStage {
public:
    ErrorStage(const ErrorInput& input, VertexErrors& out)
        : in(input), tree(input.tree), columns(input.tree.columns()), rows(input.tree.rows()), errors(out),
          steps(input.steps.begin(), input.steps.end()) {
        // Positions are rounded to float: 2^-24 relative, on each axis; heights to half a quantum.
        const double extent = std::max({tree.columns() * in.dem.spacing_m[0], tree.rows() * in.dem.spacing_m[1], 1e4});
        position_pad = extent * 0x1p-22 + 0.5 * in.lattice.quantum_m;
        if (!in.dem.voids.empty()) prepare_voids();
        own_m.assign(out.error.size(), 0);
    }

    void run(const Progress& progress) {
        const auto total = static_cast<std::uint64_t>(errors.error.size());
        for (int z = 0; z < tree.tile_log2; ++z) {
            for (const Plane& p : planes_of(z)) measure(p);
            if (progress) progress("errors", total - (total >> (2 * (z + 1))), total);
        }
        choose_scale();
        for (int z = 0; z < tree.tile_log2; ++z) {
            const std::vector<Plane> planes = planes_of(z);
            for (const Plane& p : planes) encode_errors(p);
            encode_radii(planes.data(), 2, 2 * (tree.tile_log2 - 1 - z) + 1);
            encode_radii(planes.data() + 2, 1, 2 * (tree.tile_log2 - 1 - z));
        }
        for (const std::uint8_t e : errors.error)
            errors.max_error_m = std::max(errors.max_error_m, errors.scale.metres[e]);
    }

private:
    // One plane of a step of the whole terrain.
    struct Plane {
        std::int32_t nx, ny;
        int z;
        Coord first;
        [[nodiscard]] Coord at(std::int32_t i, std::int32_t j) const {
            return {first.x + (i << (z + 1)), first.y + (j << (z + 1))};
        }
    };

    // Children come before their parents: sides, then centres.
    [[nodiscard]] std::vector<Plane> planes_of(int z) const {
        const std::int32_t nx = (tree.lattice_columns() - 1) >> (z + 1), ny = (tree.lattice_rows() - 1) >> (z + 1);
        const std::int32_t s = 1 << z;
        return {{nx, ny + 1, z, {s, 0}}, {nx + 1, ny, z, {0, s}}, {nx, ny, z, {s, s}}};
    }

    template <typename Visit>
    void for_each(const Plane& p, const Visit& visit) const {
        parallel_for(p.ny, in.threads, [&](std::int64_t j) {
            for (std::int32_t i = 0; i < p.nx; ++i) visit(i, static_cast<std::int32_t>(j));
        });
    }

    void prepare_voids() {
        solid.resize(steps.size());
        voids_before.assign((static_cast<std::size_t>(columns) + 1) * static_cast<std::size_t>(rows), 0);
        for (std::int32_t y = 0; y < rows; ++y)
            for (std::int32_t x = 0; x < columns; ++x) {
                const std::size_t i = index({x, y}), to = i + static_cast<std::size_t>(y);
                voids_before[to + 1] = voids_before[to] + in.dem.voids[i];
                solid[i] = in.dem.voids[i] ? 0.0f : 1.0f;
            }
    }

    // Each vertex' own error, before its children's count.
    void measure(const Plane& p) {
        for_each(p, [&](std::int32_t i, std::int32_t j) {
            const Coord v = p.at(i, j);
            const double own = own_error_m(v);
            auto up = static_cast<float>(own);
            if (static_cast<double>(up) < own) up = std::nextafter(up, HUGE_VALF);
            own_m[place(v)] = up;
        });
    }

    [[nodiscard]] double own_error_m(Coord v) const {
        const bool at_rim = straddles_rim(v);
        const double quantum = in.lattice.quantum_m;
        if (!at_rim && voids_before.empty() && (Tree::step_log2(v) == 0 || in.estimate == Estimate::midpoint))
            return jump_steps(v) * 0.5 * quantum;
        const DiamondSum sum = at_rim ? rim_error(v) : diamond_error(v);
        // A hole's rim is drawn to within the diamond's size.
        if (sum.voids == sum.samples && sum.voids != 0) return 0;
        if (sum.voids != 0) return std::max(sum.worst_steps * quantum, diameter_m(v));
        if (!at_rim && (Tree::step_log2(v) == 0 || in.estimate == Estimate::midpoint))
            return jump_steps(v) * 0.5 * quantum;
        // Squeezed triangles divide by odd numbers: what is left of that is no error.
        return sum.worst_steps < 0x1p-20 ? 0 : sum.worst_steps * quantum;
    }

    // Estimate 2, and at the finest step estimate 1 too: twice the surface's jump when the vertex comes in. The runtime
    // works the finest step out from the heights (LeafErrors); what a centre's sides say comes from its children.
    [[nodiscard]] double jump_steps(Coord v) const {
        const Diamond d = diamond(tree, v);
        return std::abs(2.0 * h(v) - h(d.ends[0]) - h(d.ends[1]));
    }

    // The longest edge of the diamond's triangles, where they stand.
    [[nodiscard]] double diameter_m(Coord v) const {
        const Diamond d = diamond(tree, v);
        double longest = distance(d.ends[0], d.ends[1]);
        for (const Coord apex : d.apexes)
            if (tree.contains(apex))
                longest = std::max({longest, distance(apex, d.ends[0]), distance(apex, d.ends[1])});
        return longest;
    }

    // The finest scale on which the root still has a code, if every level's worst is handed up from there.
    void choose_scale() {
        const double least = 1 + in.nesting;
        // Steps of 5% or a little more; not so many that a whole tree of them uses up the codes.
        const double wish = std::ceil(std::log(least) / std::log(1.05) - 1e-6);
        errors.nesting_steps = static_cast<std::uint32_t>(std::clamp(wish, 1.0, 64.0 / tree.tile_log2));
        errors.ratio = static_cast<float>(std::max(std::pow(least, 1.0 / errors.nesting_steps), 1.05) * (1 + 0x1p-20));
        std::vector<float> worst(2 * static_cast<std::size_t>(tree.tile_log2));
        for (int z = 0; z < tree.tile_log2; ++z)
            for (const Plane& p : planes_of(z)) {
                float& w = worst[static_cast<std::size_t>(tree.level(p.first))];
                for (std::int32_t j = 0; j < p.ny; ++j)
                    for (std::int32_t i = 0; i < p.nx; ++i) w = std::max(w, own_m[place(p.at(i, j))]);
            }
        errors.floor_m = std::max(0.5f * in.lattice.quantum_m, 1e-8f);
        for (bool fits = false; !fits; errors.floor_m *= fits ? 1 : 1.5f) {
            errors.scale = ErrorScale::make(errors.floor_m, errors.ratio, errors.nesting_steps);
            fits = true;
            for (std::size_t level = 0; level < worst.size(); ++level)
                fits = fits && static_cast<double>(errors.scale.metres[255]) >= worst[level] &&
                       errors.scale.code_up(worst[level]) + errors.nesting_steps * level <= 255;
        }
    }

    void encode_errors(const Plane& p) {
        for_each(p, [&](std::int32_t i, std::int32_t j) {
            const Coord v = p.at(i, j);
            std::uint32_t code = errors.scale.code_up(own_m[place(v)]);
            const Children kids = children(v);
            for (int k = 0; k < kids.count; ++k)
                if (tree.contains(kids.at[k]))
                    code = std::max(code, errors.scale.above(errors.error[place(kids.at[k])]));
            errors.error[place(v)] = static_cast<std::uint8_t>(code);
        });
    }

    // The radii of one level's planes. In steps that are cut into pages, all of 4 x 4 squares have the largest of them:
    // a radius is small beside the distance that it is added to, and 208 bytes do for a page.
    void encode_radii(const Plane* planes, std::size_t count, int level) {
        const int shift = tree.tile_log2 - 1 - planes[0].z >= page_squares_log2 ? radius_block_log2 : 0;
        std::vector<std::vector<double>> largest(count);
        double least = HUGE_VAL, most = 0;
        for (std::size_t k = 0; k < count; ++k) {
            const Plane& p = planes[k];
            const std::int32_t bx = ((p.nx - 1) >> shift) + 1, by = ((p.ny - 1) >> shift) + 1;
            largest[k].assign(static_cast<std::size_t>(bx) * static_cast<std::size_t>(by), 0);
            parallel_for(by, in.threads, [&](std::int64_t block_row) {
                double* const to = largest[k].data() + block_row * bx;
                const auto j0 = static_cast<std::int32_t>(block_row) << shift;
                for (std::int32_t j = j0; j < std::min(j0 + (1 << shift), p.ny); ++j)
                    for (std::int32_t i = 0; i < p.nx; ++i)
                        to[i >> shift] = std::max(to[i >> shift], exact_radius(p.at(i, j)));
            });
            for (const double r : largest[k]) least = std::min(least, r), most = std::max(most, r);
        }
        const float widest = errors.radii.factor[radius_codes - 1];
        float unit = std::nextafter(static_cast<float>(std::max(least, most / widest * (1 + 0x1p-20))), HUGE_VALF);
        errors.level_radius_m[level] = unit;
        for (std::size_t k = 0; k < count; ++k) {
            const Plane& p = planes[k];
            const std::int32_t blocks_x = ((p.nx - 1) >> shift) + 1;
            const auto bx = static_cast<std::size_t>(blocks_x);
            std::vector<std::uint8_t> codes;
            for (const double r : largest[k]) codes.push_back(errors.radii.code_up(unit, r));
            for_each(p, [&](std::int32_t i, std::int32_t j) {
                errors.radius[place(p.at(i, j))] =
                    codes[static_cast<std::size_t>(j >> shift) * bx + static_cast<std::size_t>(i >> shift)];
            });
        }
    }

    [[nodiscard]] double exact_radius(Coord v) const {
        const Children kids = children(v);
        if (kids.count == 0) return leaf_radius(v) * sphere_margin;
        double radius = 0;
        for (int k = 0; k < kids.count; ++k) {
            const Coord c = kids.at[k];
            if (!tree.contains(c)) continue;
            const float child = errors.level_radius_m[tree.level(c)] * errors.radii.factor[errors.radius[place(c)]];
            radius = std::max(radius, distance(v, c) + static_cast<double>(child));
        }
        return radius * sphere_margin;
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
    DiamondSum rim_error(Coord v) const {
        const Diamond d = diamond(tree, v);
        DiamondSum sum;
        for (const Coord apex : d.apexes)
            if (tree.contains(apex))
                triangle_error(sum, tree.sample(apex), tree.sample(d.ends[0]), tree.sample(d.ends[1]));
        return sum;
    }

    void triangle_error(DiamondSum& sum, Coord a, Coord b, Coord c) const {
        const auto turn = [](Coord p, Coord q, Coord r) { // twice the area, signed
            return std::int64_t{q.x - p.x} * (r.y - p.y) - std::int64_t{q.y - p.y} * (r.x - p.x);
        };
        const std::int64_t area = turn(a, b, c), sign = area < 0 ? -1 : 1;
        if (area == 0) return; // never drawn
        const auto [x0, x1] = std::minmax({a.x, b.x, c.x});
        const auto [y0, y1] = std::minmax({a.y, b.y, c.y});
        for (std::int32_t y = y0; y <= y1; ++y)
            for (std::int32_t x = x0; x <= x1; ++x) {
                const Coord p{x, y};
                const std::int64_t wa = turn(b, c, p) * sign, wb = turn(c, a, p) * sign, wc = turn(a, b, p) * sign;
                if (wa < 0 || wb < 0 || wc < 0) continue;
                const double on =
                    (static_cast<double>(wa) * h(a) + static_cast<double>(wb) * h(b) + static_cast<double>(wc) * h(c)) /
                    static_cast<double>(area * sign);
                row_error(sum, p, 1, on, 0);
            }
    }

    // Estimate 1: the diamond's two triangles against every sample under them.
    DiamondSum diamond_error(Coord v) const {
        const std::int32_t s = 1 << Tree::step_log2(v);
        DiamondSum sum;
        switch (Tree::kind(v)) {
        case PlaneKind::side_x: side_x_error(sum, v, s); break;
        case PlaneKind::side_y: side_y_error(sum, v, s); break;
        case PlaneKind::centre: centre_error(sum, v, s); break;
        }
        return sum;
    }

    // Rows shrink from the hypotenuse, which lies along the middle row, to the two apexes.
    void side_x_error(DiamondSum& sum, Coord v, std::int32_t s) const {
        const double west = h({v.x - s, v.y}), east = h({v.x + s, v.y}), middle = (west + east) / 2;
        const double slope = (east - west) / (2.0 * s);
        for (const std::int32_t direction : {-1, 1}) {
            const Coord apex{v.x, v.y + direction * s};
            if (!tree.contains(apex)) continue;
            count_void(sum, apex);
            const double rise = (h(apex) - middle) / s;
            for (std::int32_t k = 0; k < s; ++k) {
                const std::int32_t half = s - k;
                row_error(sum, {v.x - half, v.y + direction * k}, 2 * half + 1, middle + rise * k - slope * half,
                          slope);
            }
        }
    }

    void side_y_error(DiamondSum& sum, Coord v, std::int32_t s) const {
        const double north = h({v.x, v.y - s}), south = h({v.x, v.y + s}), middle = (north + south) / 2;
        const double along = (south - north) / (2.0 * s);
        const bool has_west = v.x - s >= 0, has_east = v.x + s < columns;
        const double west_slope = has_west ? (middle - h({v.x - s, v.y})) / s : 0;
        const double east_slope = has_east ? (h({v.x + s, v.y}) - middle) / s : 0;
        for (const Coord end : {Coord{v.x, v.y - s}, Coord{v.x, v.y + s}}) count_void(sum, end);
        for (std::int32_t r = -s + 1; r < s; ++r) {
            const std::int32_t width = s - std::abs(r);
            const double centre = middle + along * r;
            if (has_west) row_error(sum, {v.x - width, v.y + r}, width + 1, centre - west_slope * width, west_slope);
            if (has_east) row_error(sum, {v.x, v.y + r}, width + 1, centre, east_slope);
        }
    }

    // The square of side 2s, cut by one diagonal or the other; in row y + r the cut stands at column x + cut.
    void centre_error(DiamondSum& sum, Coord v, std::int32_t s) const {
        const double nw = h({v.x - s, v.y - s}), ne = h({v.x + s, v.y - s}), sw = h({v.x - s, v.y + s}),
                     se = h({v.x + s, v.y + s});
        const double span = 2.0 * s;
        const bool falling = diamond(tree, v).ends[0] == Coord{v.x - s, v.y - s}; // from north-west to south-east
        for (std::int32_t r = -s; r <= s; ++r) {
            const std::int32_t cut = falling ? r : -r;
            // Heights on the square's west and east side in this row, and on the cut.
            const double t = (r + s) / span;
            const double west = nw + (sw - nw) * t, east = ne + (se - ne) * t;
            const double on_cut = falling ? nw + (se - nw) * t : ne + (sw - ne) * t;
            const std::int32_t left = cut + s, right = s - cut;
            if (left > 0) row_error(sum, {v.x - s, v.y + r}, left + 1, west, (on_cut - west) / left);
            if (right > 0) row_error(sum, {v.x + cut, v.y + r}, right + 1, on_cut, (east - on_cut) / right);
        }
    }

    // Takes `count` samples of a row against first + slope k, in lattice steps. Holes are no samples.
    void row_error(DiamondSum& sum, Coord from, std::int32_t count, double first, double slope) const {
        const float* const row = steps.data() + index(from);
        if (voids_before.empty()) {
            sum.worst_steps = std::max(sum.worst_steps, row_error(row, count, first, slope));
            return;
        }
        sum.worst_steps = std::max(sum.worst_steps, row_error(row, solid.data() + index(from), count, first, slope));
        const std::size_t at = index(from) + static_cast<std::size_t>(from.y);
        sum.samples += static_cast<std::uint64_t>(count);
        sum.voids += voids_before[at + static_cast<std::size_t>(count)] - voids_before[at];
    }

    // For corners of triangles that no row visits: they lie on the surface, but may be holes.
    void count_void(DiamondSum& sum, Coord c) const {
        if (voids_before.empty()) return;
        ++sum.samples;
        sum.voids += in.dem.voids[index(c)];
    }

    // The compiler vectorises these two (see CMakeLists.txt): they are where the bake spends its time.
    static double row_error(const float* row, std::int32_t count, double first, double slope) {
        double worst = 0;
        for (std::int32_t k = 0; k < count; ++k) {
            const double off = std::abs(static_cast<double>(row[k]) - (first + slope * k));
            worst = off > worst ? off : worst;
        }
        return worst;
    }

    static double row_error(const float* row, const float* solid, std::int32_t count, double first, double slope) {
        double worst = 0;
        for (std::int32_t k = 0; k < count; ++k) {
            const double off =
                std::abs(static_cast<double>(row[k]) - (first + slope * k)) * static_cast<double>(solid[k]);
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
    [[nodiscard]] double h(Coord c) const { return steps[index(c)]; }
    // Between vertices as the runtime places them: float products, then exact differences.
    [[nodiscard]] double distance(Coord v, Coord w) const {
        const Coord a = tree.sample(v), b = tree.sample(w);
        const auto sx = static_cast<float>(in.dem.spacing_m[0]), sz = static_cast<float>(in.dem.spacing_m[1]);
        const double dx = static_cast<double>(static_cast<float>(a.x) * sx) - static_cast<float>(b.x) * sx;
        const double dz = static_cast<double>(static_cast<float>(a.y) * sz) - static_cast<float>(b.y) * sz;
        const double dy = static_cast<double>(in.lattice.height_m(in.steps[index(a)])) -
                          static_cast<double>(in.lattice.height_m(in.steps[index(b)]));
        return std::sqrt(dx * dx + dy * dy + dz * dz);
    }

    const ErrorInput& in;
    const Tree tree;
    const std::int32_t columns, rows; // samples
    VertexErrors& errors;
    std::vector<float> steps;                // heights in lattice steps, exact
    std::vector<float> solid;                // 0 in a hole, 1 elsewhere; this and voids_before empty without holes
    std::vector<std::uint32_t> voids_before; // of each row, how many lie before a column
    std::vector<float> own_m;                // of each vertex
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
