// A second opinion on a pack. Shares the tree's arithmetic with the baker and nothing else: true errors are found by
// bisecting explicit triangles, the way the mesh itself is made.
#include "baker/verify.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <vector>

#include <fmt/format.h>

#include "baker/parallel.h"

namespace fjell::baker {

namespace {

// Doubles carry the comparison; heights of 10^4 m leave it this uncertain.
constexpr double rounding_m = 1e-6;
// The baker's margin is 2^-16; this asks for half of it, so that its own rounding does not matter.
constexpr double sphere_margin = 1 + 0x1p-17;

class Verifier {
public:
    Verifier(const Terrain& the_terrain, const Dem* against)
        : terrain(the_terrain), tree(the_terrain.tree), columns(the_terrain.tree.lattice_columns()) {
        const auto count = static_cast<std::size_t>(columns) * static_cast<std::size_t>(tree.lattice_rows());
        vertices.resize(count);
        for (std::uint32_t tile = 0; tile < terrain.tile_count(); ++tile) gather(tile);
        gather_corners();
        original.resize(count);
        for (std::int32_t y = 0; y < tree.rows(); ++y)
            for (std::int32_t x = 0; x < tree.columns(); ++x) {
                // Under a hole stands whatever continues the ground: there is nothing to compare with.
                original[at({x, y})] = against && !against->is_void(x, y) ? against->at(x, y) : height({x, y});
                if (against && against->is_void(x, y) != hole({x, y}))
                    note(report.height_mismatches, fmt::format("sample ({}, {}) is a hole in one of the two", x, y));
            }
        // base + steps * quantum in float: one rounding of the product, one of the sum.
        const double largest = std::max(std::abs(terrain.header.min_m), std::abs(terrain.header.max_m));
        allowed_m = 0.5 * static_cast<double>(terrain.lattice.quantum_m) + rounding_m +
                    0x1p-23 * (largest + terrain.header.max_m - terrain.header.min_m);
        // Estimate 2 promises nothing about samples; with holes their rims are still looked at.
        report.true_error_checked = terrain.header.estimate == Estimate::max;
    }

    VerifyReport run() {
        report.vertices = vertices.size();
        parallel_for(tree.lattice_rows(), resolve_threads(0),
                     [&](std::int64_t y) { check_row(static_cast<std::int32_t>(y)); });
        const std::int64_t tiles = terrain.tile_count();
        if (report.true_error_checked || terrain.has_voids())
            parallel_for(tiles, resolve_threads(0),
                         [&](std::int64_t tile) { check_tile(static_cast<std::int32_t>(tile)); });
        return report;
    }

private:
    struct Stored {
        std::int32_t steps = 0;
        std::uint8_t error = 0, radius = 0;
        bool seen = false;
        friend bool operator==(const Stored&, const Stored&) = default;
    };

    // Copies one tile's pages to the global grid; a border vertex that is there already must have the same bits.
    void gather(std::uint32_t tile) {
        const auto tiles_x = static_cast<std::uint32_t>(tree.tiles_x);
        const Coord corner{static_cast<std::int32_t>(tile % tiles_x) * tree.side(),
                           static_cast<std::int32_t>(tile / tiles_x) * tree.side()};
        for (std::uint32_t page = 0; page < terrain.pages_per_tile; ++page) {
            const PageEntry entry = terrain.page_table[std::size_t{tile} * terrain.pages_per_tile + page];
            const VertexRecord* from = terrain.records + std::size_t{entry.slot} * terrain.page_capacity;
            for (std::uint32_t i = 0; i < terrain.pages.page_vertices(page); ++i) {
                const Coord c = corner + terrain.pages.coord({page, i});
                const Stored stored{entry.base + from[i].height, from[i].error, from[i].radius, true};
                Stored& to = vertices[at(c)];
                if (to.seen && !(to == stored))
                    note(report.border_mismatches, fmt::format("sample ({}, {}) differs between two pages", c.x, c.y));
                to = stored;
            }
        }
    }

    void gather_corners() {
        for (std::int32_t y = 0; y < tree.lattice_rows(); y += tree.side())
            for (std::int32_t x = 0; x < tree.lattice_columns(); x += tree.side()) {
                const Terrain::Vertex corner = terrain.vertex({x, y});
                if (corner.steps != vertices[at({x, y})].steps || corner.hole != hole({x, y}))
                    note(report.border_mismatches, fmt::format("corner ({}, {}) differs from its page's", x, y));
            }
    }

    void check_row(std::int32_t y) {
        const double nesting = 1 + static_cast<double>(terrain.header.nesting);
        for (std::int32_t x = 0; x < columns; ++x) {
            const Coord v{x, y};
            const Coord sample = tree.sample(v);
            if (std::abs(original[at(sample)] - height(v)) > allowed_m)
                note(report.height_mismatches, fmt::format("sample ({}, {}): height {} m is stored as {} m", x, y,
                                                           original[at(sample)], height(v)));
            if (tree.is_corner(v)) continue;
            const Children kids = children(v);
            for (int k = 0; k < kids.count; ++k)
                if (tree.contains(kids.at[k])) check_child(v, kids.at[k], nesting);
            if (kids.count == 0) check_leaf(v);
        }
    }

    void check_child(Coord v, Coord c, double nesting) {
        if (!(error(v) >= nesting * error(c)))
            note(report.nesting_violations, fmt::format("vertex ({}, {}): error {} m, child ({}, {}): {} m", v.x, v.y,
                                                        error(v), c.x, c.y, error(c)));
        if (!(radius(v) >= (distance(v, c) + radius(c)) * sphere_margin))
            note(report.sphere_violations,
                 fmt::format("vertex ({}, {}): its sphere does not hold that of ({}, {})", v.x, v.y, c.x, c.y));
    }

    void check_leaf(Coord v) {
        const Diamond d = diamond(tree, v);
        for (const Coord corner : {d.ends[0], d.ends[1], d.apexes[0], d.apexes[1]})
            if (tree.contains(corner) && !(radius(v) > distance(v, corner)))
                note(report.sphere_violations, fmt::format("leaf ({}, {}): its sphere misses a corner", v.x, v.y));
    }

    void check_tile(std::int32_t tile) {
        const std::int32_t side = tree.side();
        const Coord nw{tile % tree.tiles_x * side, tile / tree.tiles_x * side};
        const Coord ne{nw.x + side, nw.y}, sw{nw.x, nw.y + side}, se{nw.x + side, nw.y + side};
        Excess worst;
        std::uint64_t compared = 0;
        bisect(ne, nw, se, worst, compared);
        bisect(sw, se, nw, worst, compared);
        const std::lock_guard hold(lock);
        report.samples_compared += compared;
        report.true_error_violations += worst.count;
        if (worst.excess_m <= report.worst_excess_m) return;
        report.worst_excess_m = worst.excess_m;
        if (report.first.empty())
            report.first =
                fmt::format("sample ({}, {}) is {} m further from the surface than the error of vertex ({}, {}) says",
                            worst.sample.x, worst.sample.y, worst.excess_m, worst.vertex.x, worst.vertex.y);
    }

    struct Excess {
        std::uint64_t count = 0;
        double excess_m = 0;
        Coord sample, vertex;
    };

    // A triangle that can still be split stands for every sample under it with the error of its splitting vertex.
    void bisect(Coord apex, Coord left, Coord right, Excess& worst, std::uint64_t& compared) {
        if (((left.x + right.x) | (left.y + right.y)) & 1) return; // a triangle of the full resolution
        const Coord middle{(left.x + right.x) / 2, (left.y + right.y) / 2};
        compare(tree.sample(apex), tree.sample(left), tree.sample(right), middle, worst, compared);
        bisect(middle, apex, left, worst, compared);
        bisect(middle, right, apex, worst, compared);
    }

    void compare(Coord a, Coord b, Coord c, Coord middle, Excess& worst, std::uint64_t& compared) {
        check_rim(a, b, c, middle);
        if (!report.true_error_checked || hole(a) || hole(b) || hole(c)) return;
        const double bound = error(middle) + allowed_m;
        // Height as h(a) + gx dx + gy dy, solved from the three corners.
        const double bx = b.x - a.x, by = b.y - a.y, cx = c.x - a.x, cy = c.y - a.y;
        const double hb = height(b) - height(a), hc = height(c) - height(a), area = bx * cy - by * cx;
        if (area == 0) return; // beyond the rim
        const double gx = (hb * cy - hc * by) / area, gy = (hc * bx - hb * cx) / area;
        const auto [y0, y1] = std::minmax({a.y, b.y, c.y});
        for (std::int32_t y = y0; y <= y1; ++y) {
            const auto [x0, x1] = row_of(a, b, c, y);
            const double at_row = height(a) + gy * (y - a.y);
            for (std::int32_t x = x0; x <= x1; ++x) {
                const double off = std::abs(original[at({x, y})] - (at_row + gx * (x - a.x)));
                if (off <= bound || hole({x, y})) continue;
                ++worst.count;
                if (off - bound > worst.excess_m) worst = {worst.count, off - bound, {x, y}, middle};
            }
            compared += static_cast<std::uint64_t>(std::max(x1 - x0 + 1, 0));
        }
    }

    // A triangle with a corner in a hole is not drawn, and any other covers the holes under it: where that matters,
    // both must be within its own size.
    void check_rim(Coord a, Coord b, Coord c, Coord middle) {
        if (!terrain.has_voids()) return;
        std::uint64_t solid = 0, holes = 0;
        const auto [y0, y1] = std::minmax({a.y, b.y, c.y});
        if ((b.x - a.x) * (c.y - a.y) == (b.y - a.y) * (c.x - a.x)) return; // beyond the rim
        for (std::int32_t y = y0; y <= y1; ++y) {
            const auto [x0, x1] = row_of(a, b, c, y);
            for (std::int32_t x = x0; x <= x1; ++x) ++(hole({x, y}) ? holes : solid);
        }
        if (solid == 0 || holes == 0) return;
        const double size = std::max({distance(a, b), distance(b, c), distance(c, a)});
        if (!(error(middle) >= size * (1 - 0x1p-20)))
            note(report.rim_violations,
                 fmt::format("a triangle of {} m over a hole's rim has the error {} m of vertex ({}, {})", size,
                             error(middle), middle.x, middle.y));
    }

    // The samples of a row inside the triangle. Edges run along an axis or a diagonal and meet rows at whole samples,
    // except beside the rim, where triangles are squeezed: there the row's ends are rounded inwards.
    static std::pair<std::int32_t, std::int32_t> row_of(Coord a, Coord b, Coord c, std::int32_t y) {
        double least = HUGE_VAL, most = -HUGE_VAL;
        const Coord edges[3][2] = {{a, b}, {b, c}, {c, a}};
        for (const auto& [p, q] : edges) {
            if (y < std::min(p.y, q.y) || y > std::max(p.y, q.y)) continue;
            if (p.y == q.y) {
                least = std::min<double>({least, static_cast<double>(p.x), static_cast<double>(q.x)});
                most = std::max<double>({most, static_cast<double>(p.x), static_cast<double>(q.x)});
                continue;
            }
            // An exact product over a small whole number: exact where the quotient is whole.
            const double x = p.x + static_cast<double>(y - p.y) * (q.x - p.x) / (q.y - p.y);
            least = std::min(least, x);
            most = std::max(most, x);
        }
        return {static_cast<std::int32_t>(std::ceil(least)), static_cast<std::int32_t>(std::floor(most))};
    }

    void note(std::uint64_t& counter, const std::string& what) {
        const std::lock_guard hold(lock);
        ++counter;
        if (report.first.empty()) report.first = what;
    }

    [[nodiscard]] std::size_t at(Coord c) const {
        return static_cast<std::size_t>(c.y) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(c.x);
    }
    [[nodiscard]] double height(Coord c) const { return terrain.lattice.height_m(vertices[at(c)].steps); }
    [[nodiscard]] double error(Coord c) const { return terrain.errors.metres[vertices[at(c)].error]; }
    [[nodiscard]] double radius(Coord c) const {
        return terrain.header.level_radius_m[tree.level(c)] *
               terrain.radii.factor[vertices[at(c)].radius & (radius_codes - 1)];
    }
    [[nodiscard]] bool hole(Coord c) const { return (vertices[at(c)].radius & void_bit) != 0; }
    [[nodiscard]] double distance(Coord v, Coord w) const {
        const Coord a = tree.sample(v), b = tree.sample(w);
        const double dx = static_cast<double>(terrain.x_m(a.x)) - terrain.x_m(b.x);
        const double dz = static_cast<double>(terrain.z_m(a.y)) - terrain.z_m(b.y);
        return std::sqrt(dx * dx + dz * dz + (height(a) - height(b)) * (height(a) - height(b)));
    }

    const Terrain& terrain;
    const Tree tree;
    const std::int32_t columns;   // of vertices
    std::vector<Stored> vertices; // all of them, row by row; original is laid out alike
    std::vector<double> original;
    double allowed_m = 0;
    std::mutex lock;
    VerifyReport report;
};

} // namespace

VerifyReport verify(const Terrain& terrain, const Dem* against) {
    if (against && (against->columns != terrain.tree.columns() || against->rows != terrain.tree.rows()))
        throw Failure(1,
                      fmt::format("the height field has {} x {} samples, the pack {} x {}: this is not the one it was "
                                  "baked from",
                                  against->columns, against->rows, terrain.tree.columns(), terrain.tree.rows()));
    return Verifier(terrain, against).run();
}

} // namespace fjell::baker
