// A second opinion on a pack. Shares the tree's arithmetic with the baker and nothing else: true errors are found by
// bisecting explicit triangles, the way the mesh itself is made.
#include "baker/check/verify.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "baker/read/tile_pages.h"
#include "baker/store/parallel.h"
#include "shared/terrain_data.h"

namespace fjell::baker {

// In metres and doubles where the baker counts codes: what a reader makes of the bound is what must hold.

namespace {

// A page's own extremes, the closed borders included.
struct PageExtremes {
    std::int64_t least = max_height_steps, most = 0;
    double error_m = 0, radius_m = 0;
};

PageExtremes extremes_of(const Terrain& terrain, std::uint32_t tile, std::uint32_t page) {
    const PageEntry entry = data_of(terrain).page_table[std::size_t{tile} * terrain.pages_per_tile() + page];
    const VertexRecord* const records =
        data_of(terrain).records + std::size_t{entry.slot} * data_of(terrain).page_capacity;
    PageExtremes e;
    for (std::uint32_t i = 0; i < data_of(terrain).pages.page_vertices(page); ++i) {
        const std::int64_t steps = std::int64_t{entry.base} + records[i].height;
        e.least = std::min(e.least, steps);
        e.most = std::max(e.most, steps);
        e.error_m = std::max(e.error_m, static_cast<double>(data_of(terrain).errors.metres[records[i].error]));
        const SampleIndex c = data_of(terrain).pages.coord({page, i});
        if (data_of(terrain).tree.is_corner(c)) continue; // neither wanted nor unwanted: it is always there
        const float unit_m = terrain.header().level_radius_m[data_of(terrain).tree.level(c)];
        const double radius_m = unit_m * data_of(terrain).radii.factor[records[i].radius & (radius_codes - 1)];
        e.radius_m = std::max(e.radius_m, radius_m);
    }
    return e;
}

} // namespace

std::string wrong_bound(const Pack& pack, const Terrain& terrain, std::uint32_t tile, std::uint32_t page) {
    const PackHeader& h = pack.header;
    const PageBound b = pack.entry(chunk_index(h, {ChunkKind::geometry, tile, page})).bound;
    const PageExtremes e = extremes_of(terrain, tile, page);
    const std::int64_t unit = std::int64_t{1} << bound_shift(h);
    const std::int64_t low = b.low * unit, high = (b.high + std::int64_t{1}) * unit - 1;
    const auto wrong = [&](const char* what, double said, double is) {
        return fmt::format("page {} of tile {}: the directory bounds its {} by {}, and it is {}", page, tile, what,
                           said, is);
    };
    if (low > e.least || low + unit <= e.least)
        return wrong("lowest height step", static_cast<double>(low), static_cast<double>(e.least));
    if (high < e.most || high - unit >= e.most)
        return wrong("highest height step", static_cast<double>(high), static_cast<double>(e.most));
    const double error_m = data_of(terrain).errors.metres[b.error];
    if (error_m != e.error_m) return wrong("largest error in metres", error_m, e.error_m);
    const float unit_m = h.level_radius_m[bound_level(data_of(terrain).pages, page)];
    const double radius_m = unit_m * data_of(terrain).radii.factor[b.radius];
    if (radius_m < e.radius_m ||
        (b.radius > 0 && static_cast<double>(unit_m * data_of(terrain).radii.factor[b.radius - 1]) >= e.radius_m))
        return wrong("largest radius in metres", radius_m, e.radius_m);
    return "";
}

namespace {

// Doubles carry the comparison; heights of 10^4 m leave it this uncertain.
constexpr double rounding_m = 1e-6;
// The baker's margin is 2^-16; this asks for half of it, so that its own rounding does not matter.
constexpr double sphere_margin = 1 + 0x1p-17;

// A vertex as its tile's pages have it.
struct StoredVertex {
    std::int32_t steps = 0;
    std::uint8_t error = 0, radius = 0;
    bool seen = false;
    friend bool operator==(const StoredVertex&, const StoredVertex&) = default;
};

// The original heights around a tile: rows of `stride` floats, the first of sample (x, y); NaN where there is none.
struct Original {
    const float* heights_m = nullptr; // null: the pack's own
    std::int32_t x = 0, y = 0;
    std::ptrdiff_t stride = 0;
    bool holes = false; // NaN is a hole; otherwise ground that was filled in
};

// The vertices of a tile's border, to be compared with its neighbours'.
struct Borders {
    std::vector<StoredVertex> north, south, west, east;
};

// One tile, its border included. Of what neighbours share, the western and the northern tile leave it to the other;
// a border vertex has children in both, and each tile checks its own.
class TileCheck {
public:
    // bounds: the pack whose directory has them, or null.
    TileCheck(const Terrain& the_terrain, std::uint32_t the_tile, const Original& from, const Pack* bounds)
        : terrain(the_terrain), tree(data_of(the_terrain).tree), original(from), pack(bounds), tile(the_tile),
          side(tree.side()), nw{the_terrain.tile_place(the_tile).column * side,
                                the_terrain.tile_place(the_tile).row * side} {
        vertices.resize(static_cast<std::size_t>(side + 1) * static_cast<std::size_t>(side + 1));
        // base + steps * quantum in float: one rounding of the product, one of the sum.
        const double largest = std::max(std::abs(terrain.header().min_m), std::abs(terrain.header().max_m));
        allowed_m = 0.5 * static_cast<double>(data_of(terrain).height_scale.quantum_m) + rounding_m +
                    0x1p-23 * (largest + terrain.header().max_m - terrain.header().min_m);
        // Estimate 2 promises nothing about samples; with holes their rims are still looked at.
        report.true_error_checked = terrain.header().estimate == ErrorEstimate::max;
    }

    VerifyReport run(Borders& borders) {
        gather();
        check_corners();
        for (std::int32_t y = nw.row; y <= nw.row + side; ++y)
            for (std::int32_t x = nw.column; x <= nw.column + side; ++x) check_vertex({x, y});
        if (report.true_error_checked || terrain.has_voids()) check_triangles();
        for (std::int32_t i = 0; i <= side; ++i) {
            borders.north.push_back(vertices[at({nw.column + i, nw.row})]);
            borders.south.push_back(vertices[at({nw.column + i, nw.row + side})]);
            borders.west.push_back(vertices[at({nw.column, nw.row + i})]);
            borders.east.push_back(vertices[at({nw.column + side, nw.row + i})]);
        }
        return report;
    }

private:
    // A vertex of several pages must have the same bits in each.
    void gather() {
        for (std::uint32_t page = 0; page < terrain.pages_per_tile(); ++page) {
            const PageEntry entry = data_of(terrain).page_table[std::size_t{tile} * terrain.pages_per_tile() + page];
            if (const std::string wrong = pack ? wrong_bound(*pack, terrain, tile, page) : ""; !wrong.empty())
                note(report.bound_violations, wrong);
            const VertexRecord* from =
                data_of(terrain).records + std::size_t{entry.slot} * data_of(terrain).page_capacity;
            for (std::uint32_t i = 0; i < data_of(terrain).pages.page_vertices(page); ++i) {
                const SampleIndex c = nw + data_of(terrain).pages.coord({page, i});
                const StoredVertex stored{entry.base + from[i].height, from[i].error, from[i].radius, true};
                StoredVertex& to = vertices[at(c)];
                if (to.seen && !(to == stored))
                    note(report.border_mismatches,
                         fmt::format("sample ({}, {}) differs between two pages", c.column, c.row));
                to = stored;
            }
        }
    }

    void check_corners() {
        for (const std::int32_t y : {nw.row, nw.row + side})
            for (const std::int32_t x : {nw.column, nw.column + side}) {
                const TerrainData::Vertex corner = data_of(terrain).vertex({x, y});
                if (corner.steps != vertices[at({x, y})].steps || corner.hole != hole({x, y}))
                    note(report.border_mismatches, fmt::format("corner ({}, {}) differs from its page's", x, y));
            }
    }

    [[nodiscard]] bool own(SampleIndex v) const {
        const SampleIndex place{nw.column / side,
                                nw.row / side}; // beyond the rim, and in a set, there may be no neighbour
        return (v.column < nw.column + side || terrain.tile_at({place.column + 1, place.row}) == no_tile) &&
               (v.row < nw.row + side || terrain.tile_at({place.column, place.row + 1}) == no_tile);
    }

    void check_vertex(SampleIndex v) {
        if (own(v)) check_height(v);
        if (tree.is_corner(v)) return;
        const double nesting = 1 + static_cast<double>(terrain.header().nesting);
        const Children kids = children(v);
        for (int k = 0; k < kids.count; ++k)
            if (holds(kids.at[k])) check_child(v, kids.at[k], nesting);
        if (kids.count == 0) check_leaf(v);
    }

    void check_height(SampleIndex v) {
        const SampleIndex sample = tree.sample(v);
        if (std::abs(wanted(sample) - height(v)) > allowed_m)
            note(report.height_mismatches, fmt::format("sample ({}, {}): height {} m is stored as {} m", v.column,
                                                       v.row, wanted(sample), height(v)));
        if (!original.heights_m || !(v == sample)) return;
        if ((original.holes && std::isnan(given(v))) != hole(v))
            note(report.height_mismatches, fmt::format("sample ({}, {}) is a hole in one of the two", v.column, v.row));
    }

    void check_child(SampleIndex v, SampleIndex c, double nesting) {
        if (!(error(v) >= nesting * error(c)))
            note(report.nesting_violations, fmt::format("vertex ({}, {}): error {} m, child ({}, {}): {} m", v.column,
                                                        v.row, error(v), c.column, c.row, error(c)));
        if (!(radius(v) >= (distance(v, c) + radius(c)) * sphere_margin))
            note(report.sphere_violations, fmt::format("vertex ({}, {}): its sphere does not hold that of ({}, {})",
                                                       v.column, v.row, c.column, c.row));
    }

    void check_leaf(SampleIndex v) {
        const Diamond d = diamond(tree, v);
        for (const SampleIndex corner : {d.ends[0], d.ends[1], d.apexes[0], d.apexes[1]})
            if (holds(corner) && !(radius(v) > distance(v, corner)))
                note(report.sphere_violations,
                     fmt::format("leaf ({}, {}): its sphere misses a corner", v.column, v.row));
    }

    void check_triangles() {
        const SampleIndex ne{nw.column + side, nw.row}, sw{nw.column, nw.row + side},
            se{nw.column + side, nw.row + side};
        Excess worst;
        bisect(ne, nw, se, worst, report.samples_compared);
        bisect(sw, se, nw, worst, report.samples_compared);
        report.true_error_violations += worst.count;
        report.worst_excess_m = worst.excess_m;
        if (worst.count && report.first.empty())
            report.first = fmt::format(
                "sample ({}, {}) is {} m further from the surface than the error of vertex ({}, {}) says",
                worst.sample.column, worst.sample.row, worst.excess_m, worst.vertex.column, worst.vertex.row);
    }

    struct Excess {
        std::uint64_t count = 0;
        double excess_m = 0;
        SampleIndex sample, vertex;
    };

    // A triangle that can still be split stands for every sample under it with the error of its splitting vertex.
    void bisect(SampleIndex apex, SampleIndex left, SampleIndex right, Excess& worst, std::uint64_t& compared) {
        if (((left.column + right.column) | (left.row + right.row)) & 1) return; // a triangle of the full resolution
        const SampleIndex middle{(left.column + right.column) / 2, (left.row + right.row) / 2};
        compare(tree.sample(apex), tree.sample(left), tree.sample(right), middle, worst, compared);
        bisect(middle, apex, left, worst, compared);
        bisect(middle, right, apex, worst, compared);
    }

    void compare(SampleIndex a, SampleIndex b, SampleIndex c, SampleIndex middle, Excess& worst,
                 std::uint64_t& compared) {
        check_rim(a, b, c, middle);
        if (!report.true_error_checked || hole(a) || hole(b) || hole(c)) return;
        const double bound = error(middle) + allowed_m;
        // Height as h(a) + gx dx + gy dy, solved from the three corners.
        const double bx = b.column - a.column, by = b.row - a.row, cx = c.column - a.column, cy = c.row - a.row;
        const double hb = height(b) - height(a), hc = height(c) - height(a), area = bx * cy - by * cx;
        if (area == 0) return; // beyond the rim
        const double gx = (hb * cy - hc * by) / area, gy = (hc * bx - hb * cx) / area;
        const auto [y0, y1] = std::minmax({a.row, b.row, c.row});
        for (std::int32_t y = y0; y <= y1; ++y) {
            const auto [x0, x1] = row_of(a, b, c, y);
            const double at_row = height(a) + gy * (y - a.row);
            for (std::int32_t x = x0; x <= x1; ++x) {
                const double off = std::abs(wanted({x, y}) - (at_row + gx * (x - a.column)));
                if (off <= bound || hole({x, y})) continue;
                ++worst.count;
                if (off - bound > worst.excess_m) worst = {worst.count, off - bound, {x, y}, middle};
            }
            compared += static_cast<std::uint64_t>(std::max(x1 - x0 + 1, 0));
        }
    }

    // A triangle with a corner in a hole is not drawn, and any other covers the holes under it: where that matters,
    // both must be within its own size.
    void check_rim(SampleIndex a, SampleIndex b, SampleIndex c, SampleIndex middle) {
        if (!terrain.has_voids()) return;
        std::uint64_t solid = 0, holes = 0;
        const auto [y0, y1] = std::minmax({a.row, b.row, c.row});
        if ((b.column - a.column) * (c.row - a.row) == (b.row - a.row) * (c.column - a.column))
            return; // beyond the rim
        for (std::int32_t y = y0; y <= y1; ++y) {
            const auto [x0, x1] = row_of(a, b, c, y);
            for (std::int32_t x = x0; x <= x1; ++x) ++(hole({x, y}) ? holes : solid);
        }
        if (solid == 0 || holes == 0) return;
        const double size = std::max({distance(a, b), distance(b, c), distance(c, a)});
        if (!(error(middle) >= size * (1 - 0x1p-20)))
            note(report.rim_violations,
                 fmt::format("a triangle of {} m over a hole's rim has the error {} m of vertex ({}, {})", size,
                             error(middle), middle.column, middle.row));
    }

    // The samples of a row inside the triangle. Edges run along an axis or a diagonal and meet rows at whole samples,
    // except beside the rim, where triangles are squeezed: there the row's ends are rounded inwards.
    static std::pair<std::int32_t, std::int32_t> row_of(SampleIndex a, SampleIndex b, SampleIndex c, std::int32_t y) {
        double least = HUGE_VAL, most = -HUGE_VAL;
        const SampleIndex edges[3][2] = {{a, b}, {b, c}, {c, a}};
        for (const auto& [p, q] : edges) {
            if (y < std::min(p.row, q.row) || y > std::max(p.row, q.row)) continue;
            if (p.row == q.row) {
                least = std::min<double>({least, static_cast<double>(p.column), static_cast<double>(q.column)});
                most = std::max<double>({most, static_cast<double>(p.column), static_cast<double>(q.column)});
                continue;
            }
            // An exact product over a small whole number: exact where the quotient is whole.
            const double x = p.column + static_cast<double>(y - p.row) * (q.column - p.column) / (q.row - p.row);
            least = std::min(least, x);
            most = std::max(most, x);
        }
        return {static_cast<std::int32_t>(std::ceil(least)), static_cast<std::int32_t>(std::floor(most))};
    }

    void note(std::uint64_t& counter, const std::string& what) {
        ++counter;
        if (report.first.empty()) report.first = what;
    }

    [[nodiscard]] bool holds(SampleIndex c) const {
        return c.column >= nw.column && c.row >= nw.row && c.column <= nw.column + side && c.row <= nw.row + side;
    }
    [[nodiscard]] std::size_t at(SampleIndex c) const {
        return static_cast<std::size_t>(c.row - nw.row) * static_cast<std::size_t>(side + 1) +
               static_cast<std::size_t>(c.column - nw.column);
    }
    [[nodiscard]] float given(SampleIndex sample) const {
        return original.heights_m[(sample.row - original.y) * original.stride + (sample.column - original.x)];
    }
    // What a sample's height should be. Under a hole stands whatever continues the ground: there is nothing to compare
    // with.
    [[nodiscard]] double wanted(SampleIndex sample) const {
        const double known = original.heights_m ? static_cast<double>(given(sample)) : std::nan("");
        return std::isnan(known) ? height(sample) : known;
    }
    [[nodiscard]] double height(SampleIndex c) const {
        return data_of(terrain).height_scale.height_m(vertices[at(c)].steps);
    }
    [[nodiscard]] double error(SampleIndex c) const { return data_of(terrain).errors.metres[vertices[at(c)].error]; }
    [[nodiscard]] double radius(SampleIndex c) const {
        return terrain.header().level_radius_m[tree.level(c)] *
               data_of(terrain).radii.factor[vertices[at(c)].radius & (radius_codes - 1)];
    }
    [[nodiscard]] bool hole(SampleIndex c) const { return (vertices[at(c)].radius & void_bit) != 0; }
    [[nodiscard]] double distance(SampleIndex v, SampleIndex w) const {
        const SampleIndex a = tree.sample(v), b = tree.sample(w);
        const double dx = static_cast<double>(terrain.x_m(a.column)) - terrain.x_m(b.column);
        const double dz = static_cast<double>(terrain.z_m(a.row)) - terrain.z_m(b.row);
        return std::sqrt(dx * dx + dz * dz + (height(a) - height(b)) * (height(a) - height(b)));
    }

    const Terrain& terrain;
    const Tree tree;
    const Original original;
    const Pack* const pack;
    const std::uint32_t tile;
    const std::int32_t side;
    const SampleIndex nw;
    std::vector<StoredVertex> vertices; // the closed tile's, row by row
    double allowed_m = 0;
    VerifyReport report;
};

// Where a tile's pages are loaded while it is looked at.
class Pages {
public:
    Pages(const Terrain& whole, const Pack* bounds) : whole_(&whole), bounds_(bounds) {}
    explicit Pages(const io::PackFile& file) : file_(&file), bounds_(&file.pack()) {}
    [[nodiscard]] const Pack* bounds() const { return bounds_; }
    // Tiles by place, row by row; no_tile where there is none.
    [[nodiscard]] std::vector<std::uint32_t> tiles(const Tree& tree) const {
        std::vector<std::uint32_t> at(static_cast<std::size_t>(tree.tiles_x) * static_cast<std::size_t>(tree.tiles_y),
                                      no_tile);
        for (std::uint32_t tile = 0; whole_ != nullptr && tile < whole_->tile_count(); ++tile) {
            const SampleIndex place = whole_->tile_place(tile);
            at[static_cast<std::size_t>(place.row) * static_cast<std::size_t>(tree.tiles_x) +
               static_cast<std::size_t>(place.column)] = tile;
        }
        for (std::uint32_t tile = 0; file_ != nullptr && tile < file_->pack().tile_count(); ++tile)
            at[file_->pack().tile_place(tile)] = tile;
        return at;
    }

    template <typename Body>
    void with(std::uint32_t tile, const Body& body) {
        if (whole_) return body(*whole_);
        std::unique_ptr<TilePages> pages = take();
        pages->load(tile);
        body(pages->terrain());
        const std::lock_guard hold(lock_);
        free_.push_back(std::move(pages));
    }

private:
    std::unique_ptr<TilePages> take() {
        const std::lock_guard hold(lock_);
        if (free_.empty()) return std::make_unique<TilePages>(*file_);
        std::unique_ptr<TilePages> pages = std::move(free_.back());
        free_.pop_back();
        return pages;
    }

    const Terrain* whole_ = nullptr;
    const io::PackFile* file_ = nullptr;
    const Pack* bounds_;
    std::mutex lock_;
    std::vector<std::unique_ptr<TilePages>> free_;
};

// Original heights by rows of tiles: whole where they fit or the file can only be decoded from its start, else tile by
// tile, so that neither memory nor decoding grow with the terrain's width.
class SourceHeights {
public:
    SourceHeights(const HeightSource& source, const Tree& tree, bool holes, std::size_t row_bytes)
        : tree_(tree), reader_(source.reader()), holes_(holes) {
        const std::size_t row = static_cast<std::size_t>(tree.side() + 1) * static_cast<std::size_t>(tree.columns());
        whole_rows_ = row * sizeof(float) <= row_bytes || source.readers(2) == 1;
    }

    void start_row(std::int32_t ty) {
        if (!whole_rows_) return;
        row_ = window(0, ty, tree_.columns());
        heights_m_.resize(row_.area());
        reader_->read(row_, heights_m_.data(), statistics_);
    }
    // own: where the tile's heights come to lie when the row is not held.
    Original tile(std::int32_t tx, std::int32_t ty, std::vector<float>& own) {
        if (whole_rows_) return {heights_m_.data(), row_.x, row_.y, row_.columns, holes_};
        const Window w = window(tx * tree_.side(), ty, tree_.side() + 1);
        own.resize(w.area());
        const std::lock_guard hold(lock_);
        reader_->read(w, own.data(), statistics_);
        return {own.data(), w.x, w.y, w.columns, holes_};
    }

private:
    [[nodiscard]] Window window(std::int32_t x, std::int32_t ty, std::int32_t columns) const {
        const std::int32_t y = ty * tree_.side();
        return {x, y, std::min(columns, tree_.columns() - x), std::min(tree_.side() + 1, tree_.rows() - y)};
    }

    const Tree tree_;
    std::unique_ptr<HeightReader> reader_;
    const bool holes_;
    bool whole_rows_ = true;
    Window row_;
    std::vector<float> heights_m_;
    ReadStatistics statistics_;
    std::mutex lock_;
};

void add(VerifyReport& all, const VerifyReport& tile) {
    all.samples_compared += tile.samples_compared;
    all.nesting_violations += tile.nesting_violations;
    all.sphere_violations += tile.sphere_violations;
    all.border_mismatches += tile.border_mismatches;
    all.true_error_violations += tile.true_error_violations;
    all.height_mismatches += tile.height_mismatches;
    all.rim_violations += tile.rim_violations;
    all.bound_violations += tile.bound_violations;
    all.worst_excess_m = std::max(all.worst_excess_m, tile.worst_excess_m);
    all.true_error_checked = tile.true_error_checked;
    if (all.first.empty()) all.first = tile.first;
}

void compare(VerifyReport& all, const std::vector<StoredVertex>& a, const std::vector<StoredVertex>& b,
             const char* where, std::size_t tile) {
    for (std::size_t i = 0; i < a.size(); ++i) {
        if (a[i] == b[i]) continue;
        ++all.border_mismatches;
        if (all.first.empty())
            all.first = fmt::format("vertex {} of tile {}'s {} border differs from the neighbour's", i, tile, where);
    }
}

// Places where there is a tile, or a border or a corner of one. tiles: by place; no_tile: there is none.
std::uint64_t vertex_count(const Tree& tree, const std::vector<std::uint32_t>& tiles) {
    const auto there = [&](std::int32_t x, std::int32_t y) {
        return x >= 0 && y >= 0 && x < tree.tiles_x && y < tree.tiles_y &&
               tiles[static_cast<std::size_t>(y) * static_cast<std::size_t>(tree.tiles_x) +
                     static_cast<std::size_t>(x)] != no_tile;
    };
    const auto inside = static_cast<std::uint64_t>(tree.side()) - 1; // of a side, without its ends
    std::uint64_t count = 0;
    for (std::int32_t y = 0; y <= tree.tiles_y; ++y)
        for (std::int32_t x = 0; x <= tree.tiles_x; ++x) {
            const bool here = there(x, y), west = there(x - 1, y), north = there(x, y - 1);
            count += here ? inside * inside : 0;
            count += (here || north ? inside : 0) + (here || west ? inside : 0);
            count += here || west || north || there(x - 1, y - 1) ? 1 : 0;
        }
    return count;
}

VerifyReport check_tiles(const Tree& tree, Pages& pages, SourceHeights* heights) {
    VerifyReport all;
    const std::vector<std::uint32_t> tiles = pages.tiles(tree);
    all.vertices = vertex_count(tree, tiles);
    const auto across = static_cast<std::size_t>(tree.tiles_x);
    std::vector<Borders> row, above;
    std::vector<VerifyReport> reports;
    for (std::int32_t ty = 0; ty < tree.tiles_y; ++ty) {
        row.assign(across, {});
        reports.assign(across, {});
        if (heights) heights->start_row(ty);
        parallel_for(tree.tiles_x, resolve_threads(0), [&](std::int64_t x) {
            const auto tx = static_cast<std::int32_t>(x);
            const std::uint32_t tile = tiles[static_cast<std::size_t>(ty) * across + static_cast<std::size_t>(tx)];
            if (tile == no_tile) return;
            std::vector<float> own;
            const Original original = heights ? heights->tile(tx, ty, own) : Original{};
            pages.with(tile, [&](const Terrain& terrain) {
                reports[static_cast<std::size_t>(x)] =
                    TileCheck(terrain, tile, original, pages.bounds()).run(row[static_cast<std::size_t>(x)]);
            });
        });
        for (std::size_t x = 0; x < across; ++x) {
            const std::size_t place = static_cast<std::size_t>(ty) * across + x, tile = tiles[place];
            if (tile == no_tile) continue;
            add(all, reports[x]);
            if (x > 0 && tiles[place - 1] != no_tile) compare(all, row[x - 1].east, row[x].west, "west", tile);
            if (ty > 0 && tiles[place - across] != no_tile) compare(all, above[x].south, row[x].north, "north", tile);
        }
        above = std::move(row);
    }
    return all;
}

void check_size(const Tree& tree, std::int32_t columns, std::int32_t rows) {
    if (columns != tree.columns() || rows != tree.rows())
        throw Failure(1,
                      fmt::format("the height field has {} x {} samples, the pack {} x {}: this is not the one it was "
                                  "baked from",
                                  columns, rows, tree.columns(), tree.rows()));
}

// Reads all of a source once, to learn what its voids mean and whether it has what no one decided about.
SourceProperties properties(const HeightSource& source) {
    constexpr std::size_t at_once = std::size_t{1} << 21; // samples
    const auto reader = source.reader();
    std::vector<float> part;
    ReadStatistics statistics;
    for (const Window& w : source.windows(at_once)) {
        io::check_interrupt();
        part.resize(w.area());
        reader->read(w, part.data(), statistics);
    }
    return source.properties(statistics);
}

} // namespace

VerifyReport verify(const io::PackFile& file, const HeightSource* against, std::size_t row_bytes) {
    const Tree tree = tree_of(file.pack().header);
    Pages pages(file);
    std::optional<SourceHeights> heights;
    if (against) {
        check_size(tree, against->columns, against->rows);
        heights.emplace(*against, tree, properties(*against).holes, row_bytes);
    }
    return check_tiles(tree, pages, heights ? &*heights : nullptr);
}

VerifyReport verify(const Terrain& terrain, const HeightSource* against, const Pack* bounds) {
    Pages pages(terrain, bounds);
    std::optional<SourceHeights> heights;
    if (against) {
        check_size(data_of(terrain).tree, against->columns, against->rows);
        heights.emplace(*against, data_of(terrain).tree, properties(*against).holes,
                        std::numeric_limits<std::size_t>::max());
    }
    return check_tiles(data_of(terrain).tree, pages, heights ? &*heights : nullptr);
}

} // namespace fjell::baker
