#include "baker/outlets/height_mesh.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <mutex>

// Without the parser of formats the npm package is 45 KB smaller, and without numbers that are not whole 9 KB more.
#include <fmt/compile.h>

#include "baker/errors/unsaturated.h"
#include "baker/outlets/bisect.h"
#include "baker/store/parallel.h"
#include "fjell/io/failure.h"
#include "shared/compiler.h"

namespace fjell::baker {

using io::Failure;

namespace {

// ---- bits of a grid's places, row by row

class Bits {
public:
    Bits(std::int64_t columns, std::int64_t rows)
        : words_(static_cast<std::size_t>((columns + 63) / 64)), rows_(static_cast<std::size_t>(rows)),
          bits_(words_ * rows_) {}
    [[nodiscard]] std::size_t words() const { return words_; } // of a row
    [[nodiscard]] std::uint64_t* row(std::int64_t y) { return bits_.data() + static_cast<std::size_t>(y) * words_; }
    [[nodiscard]] const std::uint64_t* row(std::int64_t y) const {
        return bits_.data() + static_cast<std::size_t>(y) * words_;
    }
    [[nodiscard]] bool at(std::int32_t x, std::int32_t y) const { return row(y)[x / 64] >> (x % 64) & 1; }
    // From several threads.
    void set(std::int32_t x, std::int32_t y) {
        const std::uint64_t bit = std::uint64_t{1} << (x % 64);
        std::uint64_t& word = row(y)[x / 64];
        if ((load_relaxed(word) & bit) == 0) set_bits_relaxed(word, bit);
    }

private:
    std::size_t words_, rows_;
    std::vector<std::uint64_t> bits_;
};

// ---- what the array holds

struct Extent {
    double least_m = HUGE_VAL, most_m = -HUGE_VAL;
    std::uint64_t voids = 0, infinite = 0;
    std::int64_t void_row = 0, void_column = 0, infinite_row = 0, infinite_column = 0; // the first one
    void add(const Extent& other) {                                                    // other: of later rows
        if (voids == 0) void_row = other.void_row, void_column = other.void_column;
        if (infinite == 0) infinite_row = other.infinite_row, infinite_column = other.infinite_column;
        voids += other.voids, infinite += other.infinite;
        least_m = std::min(least_m, other.least_m), most_m = std::max(most_m, other.most_m);
    }
};

Extent extent_of_row(const std::vector<double>& row, std::int64_t y) {
    Extent e;
    for (std::size_t x = 0; x < row.size(); ++x) {
        const double h = row[x];
        if (std::isfinite(h) && std::abs(h) <= std::numeric_limits<float>::max()) {
            e.least_m = std::min(e.least_m, h), e.most_m = std::max(e.most_m, h);
        } else if (std::isnan(h)) {
            if (e.voids++ == 0) e.void_row = y, e.void_column = static_cast<std::int64_t>(x);
        } else if (e.infinite++ == 0) {
            e.infinite_row = y, e.infinite_column = static_cast<std::int64_t>(x);
        }
    }
    return e;
}

Extent extent_of(const HeightArray& heights, int threads) {
    constexpr std::int64_t rows_at_once = 64;
    std::vector<Extent> parts(static_cast<std::size_t>((heights.rows - 1) / rows_at_once + 1));
    parallel_for(static_cast<std::int64_t>(parts.size()), threads, [&](std::int64_t part) {
        std::vector<double> row(static_cast<std::size_t>(heights.columns));
        const std::int64_t end = std::min(heights.rows, (part + 1) * rows_at_once);
        for (std::int64_t y = part * rows_at_once; y < end; ++y) {
            heights.read(y, 0, heights.columns, row.data());
            parts[static_cast<std::size_t>(part)].add(extent_of_row(row, y));
        }
    });
    Extent all;
    for (const Extent& part : parts) all.add(part);
    return all;
}

// A step that is a power of two, so that whole numbers and binary fractions are quantised without loss; small enough
// that half of it matters to nobody, and large enough that errors under the largest triangles are exact in 32 bits.
HeightScale height_scale_of(const Extent& e, const Tree& tree) {
    const double range = std::max(e.most_m - e.least_m, 0x1p-100), most_steps = std::ldexp(1.0, 30 - tree.tile_log2);
    const double steps = std::min(most_steps, double{max_height_steps}) - 2;
    const double quantum = std::exp2(std::ceil(std::log2(range / steps)));
    const double base = std::floor(e.least_m / quantum) * quantum;
    float low = static_cast<float>(base);
    if (static_cast<double>(low) > base) low = std::nextafter(low, -HUGE_VALF);
    return {low, static_cast<float>(quantum)};
}

// Small tiles where the bound changes from tile to tile.
int tile_log2_of(const HeightArray& heights, const HeightMeshOptions& options) {
    constexpr int area_tile_log2 = 6;
    const int usual =
        auto_tile_log2(static_cast<std::int32_t>(heights.columns), static_cast<std::int32_t>(heights.rows));
    return options.area ? std::min(usual, area_tile_log2) : usual;
}

// ---- a tile

class Mesher {
public:
    Mesher(const HeightArray& heights, const HeightMeshOptions& options, const Extent& extent)
        : array_(heights), options_(options), threads_(resolve_threads(options.threads)),
          tree_(Tree::covering(static_cast<std::int32_t>(heights.columns), static_cast<std::int32_t>(heights.rows),
                               tile_log2_of(heights, options))),
          scale_(height_scale_of(extent, tree_)), active_(tree_.grid_columns(), tree_.grid_rows()),
          used_(heights.columns, heights.rows), moved_{moved_by_float(heights.columns, options.spacing_m[0]),
                                                       moved_by_float(heights.rows, options.spacing_m[1])} {}

    [[nodiscard]] HeightMesh run() {
        parallel_for(tiles(), threads_, [&](std::int64_t i) { measure(region_of(i), allowed_m(region_of(i))); });
        close_upwards();
        std::vector<Part> parts = emit_all(), base;
        if (options_.base) {
            coarsen_to_base();
            base = emit_all();
        }
        return assemble(parts, base);
    }

private:
    // Of a tile, before vertices have numbers: corners as place in the tile, row * (side + 1) + column.
    struct Part {
        std::vector<std::array<std::uint32_t, 3>> triangles;
        std::size_t first = 0; // of all triangles
        double true_error_m = 0;
    };

    [[nodiscard]] std::int64_t tiles() const { return std::int64_t{tree_.tiles_x} * tree_.tiles_y; }
    // Coordinates are floats: how far one lies from its place, in samples.
    [[nodiscard]] static double moved_by_float(std::int64_t samples, double spacing_m) {
        double most = 0;
        for (std::int64_t i = 0; i < samples; ++i) {
            const double at = static_cast<double>(i) * spacing_m;
            most = std::max(most, std::abs(static_cast<double>(static_cast<float>(at)) - at));
        }
        constexpr double tilted = 1.001; // the gradient is that of the moved corners
        return most / spacing_m * tilted;
    }
    [[nodiscard]] Region region_of(std::int64_t i) const {
        const std::int32_t side = tree_.side();
        const SampleIndex first{static_cast<std::int32_t>(i % tree_.tiles_x) * side,
                                static_cast<std::int32_t>(i / tree_.tiles_x) * side};
        return {first, {first.column + side, first.row + side}};
    }

    // The array's numbers at the places of a region; those beyond the rim are the rim's.
    void read(const Region& r, Patch<double>& to) const {
        to = {r.first.column, r.first.row, r.last.column - r.first.column + 1, r.last.row - r.first.row + 1};
        for (std::int32_t y = to.y; y < to.y + to.rows; ++y) {
            double* const row = to.at(to.x, y);
            const std::int32_t there = std::min(to.columns, tree_.columns() - to.x);
            array_.read(std::min(y, tree_.rows() - 1), to.x, there, row);
            std::fill(row + there, row + to.columns, row[there - 1]);
        }
    }

    // What a tile may be off.
    [[nodiscard]] double allowed_m(const Region& r) const {
        if (!options_.area) return options_.max_error_m;
        const MeshArea& a = *options_.area;
        const auto beyond = [](double at, double from, double to) { return std::max({from - at, at - to, 0.0}); };
        const double dx = options_.spacing_m[0], dz = options_.spacing_m[1];
        const double far_m = std::hypot(beyond(a.x_m, r.first.column * dx, r.last.column * dx),
                                        beyond(a.z_m, r.first.row * dz, r.last.row * dz));
        return options_.max_error_m + a.growth * std::max(0.0, far_m - a.radius_m);
    }

    // Activates what has an error of its own.
    void measure(const Region& r, double allowed) {
        Patch<double> numbers;
        read(r, numbers);
        QuantisedHeights ground;
        ground.tree = tree_;
        const double slack_m = quantise_tile(numbers, ground);
        const double limit_m = allowed - slack_m;
        if (limit_m < 0) { // closer than this scale tells: everything
            for (std::int32_t y = r.first.row; y <= r.last.row; ++y)
                for (std::int32_t x = r.first.column; x <= r.last.column; ++x)
                    if (!tree_.is_corner({x, y})) active_.set(x, y);
            return;
        }
        Scales scales;
        scales.height_scale = scale_;
        float floor_m = static_cast<float>(limit_m); // code 1: good enough
        if (static_cast<double>(floor_m) > limit_m) floor_m = std::nextafter(floor_m, 0.0f);
        scales.errors = ErrorScale::make(floor_m, 2, 1);
        const LeafErrors leaf; // of estimate mid-point only
        // A triangle over a hole's rim has the size of its edges for an error: with cells that large none is good
        // enough.
        constexpr double endless_m = 1e30;
        const UnsaturatedInput input{ground, r, scales, leaf, ErrorEstimate::max, {endless_m, endless_m}};
        Patch<std::uint8_t> codes;
        (void)unsaturated_errors(input, codes);
        for (std::int32_t y = 0; y < codes.rows; ++y) {
            const std::uint8_t* const row = codes.at(codes.x, codes.y + y);
            for (std::int32_t x = 0; x < codes.columns; ++x)
                if (row[x] > 1) active_.set(2 * (codes.x + x), 2 * (codes.y + y));
        }
        measure_finest(input, static_cast<double>(floor_m));
    }

    // How much a triangle's error may differ from that of the quantised heights: twice what quantising moved a height
    // by, and what rounding to float did.
    [[nodiscard]] double quantise_tile(const Patch<double>& numbers, QuantisedHeights& ground) const {
        ground.steps = {numbers.x, numbers.y, numbers.columns, numbers.rows};
        std::vector<float> row(static_cast<std::size_t>(numbers.columns));
        double moved_m = 0, rounded_m = 0;
        for (std::int32_t y = numbers.y; y < numbers.y + numbers.rows; ++y) {
            const double* const from = numbers.at(numbers.x, y);
            std::int32_t* const to = ground.steps.at(numbers.x, y);
            bool whole = true;
            for (std::size_t x = 0; x < row.size(); ++x) {
                row[x] = static_cast<float>(from[x]);
                whole = whole && !std::isnan(from[x]);
            }
            if (!whole) mark_voids(numbers, y, row, ground);
            quantise(row.data(), row.size(), scale_, to);
            for (std::size_t x = 0; x < row.size(); ++x) {
                const double h = static_cast<double>(row[x]);
                const double at = static_cast<double>(scale_.base_m) + to[x] * static_cast<double>(scale_.quantum_m);
                moved_m = std::max(moved_m, std::abs(h - at));
                if (!std::isnan(from[x])) rounded_m = std::max(rounded_m, std::abs(from[x] - h));
            }
        }
        return 2 * moved_m + rounded_m + tilted_m(numbers);
    }

    // What triangles over these numbers may be off because float coordinates of their corners are. Along a row or a
    // column no edge is steeper than the steepest step between samples; across its hypotenuse a triangle is no steeper
    // than both together.
    [[nodiscard]] double tilted_m(const Patch<double>& numbers) const {
        if (moved_[0] == 0 && moved_[1] == 0) return 0;
        double east = 0, south = 0; // of a NaN and a number std::fmax takes the number
        for (std::int32_t y = numbers.y; y < numbers.y + numbers.rows; ++y) {
            const double* const row = numbers.at(numbers.x, y);
            for (std::int32_t x = 0; x + 1 < numbers.columns; ++x)
                east = std::fmax(east, std::abs(row[x + 1] - row[x]));
            if (y + 1 == numbers.y + numbers.rows) break;
            for (std::int32_t x = 0; x < numbers.columns; ++x)
                south = std::fmax(south, std::abs(row[x + numbers.columns] - row[x]));
        }
        return (east + south) * (moved_[0] + moved_[1]);
    }

    // A hole's height counts for nothing; any that is finite will do.
    void mark_voids(const Patch<double>& numbers, std::int32_t y, std::vector<float>& row,
                    QuantisedHeights& ground) const {
        if (!ground.has_voids()) {
            ground.voids = {numbers.x, numbers.y, numbers.columns, numbers.rows};
            std::fill(ground.voids.values.begin(), ground.voids.values.end(), std::uint8_t{0});
        }
        for (std::size_t x = 0; x < row.size(); ++x)
            if (std::isnan(row[x])) {
                *ground.voids.at(numbers.x + static_cast<std::int32_t>(x), y) = 1;
                row[x] = scale_.base_m;
            }
    }

    // Step 1, of which unsaturated_errors() knows nothing: half the jump when the vertex comes in.
    void measure_finest(const UnsaturatedInput& in, double limit_m) {
        const Region& r = in.region;
        const double jumps = std::floor(2 * limit_m / static_cast<double>(scale_.quantum_m));
        const std::int32_t most = jumps < 0x1p30 ? static_cast<std::int32_t>(jumps) : 1 << 30;
        const Patch<std::int32_t>& steps = in.ground.steps;
        const bool root = tree_.tile_log2 == 1;
        for (std::int32_t y = r.first.row; y <= r.last.row; ++y)
            for (std::int32_t x = r.first.column + ((y & 1) == 0 ? 1 : 0); x <= r.last.column;
                 x += (y & 1) == 0 ? 2 : 1) {
                if (in.ground.has_voids() || straddles_rim(tree_, {x, y})) {
                    if (unsaturated_error(in, {x, y}).code > 1) active_.set(x, y);
                    continue;
                }
                const std::int32_t* const h = steps.at(x, y);
                std::ptrdiff_t end = 1;
                if ((y & 1) != 0 && (x & 1) == 0) end = steps.columns;
                if ((y & 1) != 0 && (x & 1) != 0) {
                    const bool rising = !root && ((((x - 1) >> 1) + ((y - 1) >> 1)) & 1) != 0;
                    end = rising ? steps.columns - 1 : steps.columns + 1;
                }
                if (std::abs(2 * h[0] - h[-end] - h[end]) > most) active_.set(x, y);
            }
    }

    // ---- a vertex is there when one of its children is: 64 places at a time

    // Of row y those of `places` bits that are set `shift` to the west or east of a place.
    [[nodiscard]] static std::uint64_t beside(const std::uint64_t* row, std::size_t words, std::size_t word,
                                              std::int32_t shift) {
        const std::size_t whole = static_cast<std::size_t>(shift) / 64;
        const int part = shift % 64;
        const auto at = [&](std::ptrdiff_t w) {
            return w >= 0 && w < static_cast<std::ptrdiff_t>(words) ? row[w] : std::uint64_t{0};
        };
        const auto w = static_cast<std::ptrdiff_t>(word), far = static_cast<std::ptrdiff_t>(whole);
        if (part == 0) return at(w - far) | at(w + far);
        return at(w - far) << part | at(w - far - 1) >> (64 - part) | at(w + far) >> part |
               at(w + far + 1) << (64 - part);
    }
    // Places x = first + k * period of a word.
    [[nodiscard]] static std::uint64_t places(std::size_t word, std::int32_t first, std::int32_t period) {
        std::uint64_t bits = 0;
        const auto from = static_cast<std::int64_t>(word) * 64;
        std::int64_t x = (first - from) % period;
        if (x < 0) x += period;
        for (; x < 64; x += period) bits |= std::uint64_t{1} << x;
        return bits;
    }
    // Sets those of a row's places x = first + k * period that have a bit beside them in `a` or `b`, or in `straight`
    // at their own x.
    void climb(std::int32_t y, std::int32_t first, std::int32_t period, std::int32_t shift,
               const std::array<std::int32_t, 2>& rows, bool straight) {
        const std::size_t words = active_.words();
        std::uint64_t* const to = active_.row(y);
        for (std::size_t w = 0; w < words; ++w) {
            const std::uint64_t wanted = places(w, first, period);
            if (wanted == 0) continue;
            std::uint64_t below = straight ? beside(to, words, w, shift) : 0;
            for (const std::int32_t row : rows) {
                if (row < 0 || row >= tree_.grid_rows()) continue;
                below |= straight ? active_.row(row)[w] : beside(active_.row(row), words, w, shift);
            }
            to[w] |= below & wanted;
        }
    }
    void close_upwards() {
        for (int z = 0; z < tree_.tile_log2; ++z) {
            const std::int32_t s = 1 << z, h = s / 2, rows = tree_.grid_rows();
            for (std::int32_t y = 0; z > 0 && y < rows; y += s) { // sides: the centres of the finer step around them
                const bool along_x = (y & s) == 0;
                climb(y, along_x ? s : 0, 2 * s, h, {y - h, y + h}, false);
            }
            io::check_interrupt();
            for (std::int32_t y = s; y < rows; y += 2 * s) climb(y, s, 2 * s, s, {y - s, y + s}, true);
        }
        // Corners of tiles are in no tree, and always there.
        for (std::int32_t y = 0; y < tree_.grid_rows(); y += tree_.side())
            for (std::int32_t x = 0; x < tree_.grid_columns(); x += tree_.side()) active_.set(x, y);
    }

    // ---- the plate under a mesh: its rim and its holes, and else as few vertices as there can be

    // An edge is there when its ends are vertices and its middle is not. All of the mesh's vertices at the rim and
    // beyond it stay, and no tolerance changes what lies beside holes: so both have the same edges around them.
    void coarsen_to_base() {
        Bits mesh(tree_.grid_columns(), tree_.grid_rows());
        std::swap(mesh, active_);
        constexpr double anything_m = 1e20;
        parallel_for(tiles(), threads_, [&](std::int64_t i) { measure(region_of(i), anything_m); });
        for (std::int32_t y = 0; y < tree_.grid_rows(); ++y) {
            const bool whole_row = y == 0 || y >= tree_.rows() - 1;
            for (std::int32_t x = 0; x < tree_.grid_columns(); ++x) {
                if (!whole_row && x == 1) x = tree_.columns() - 1;
                if (mesh.at(x, y)) active_.set(x, y);
            }
        }
        close_upwards();
    }

    // ---- triangles

    [[nodiscard]] std::vector<Part> emit_all() {
        std::vector<Part> parts(static_cast<std::size_t>(tiles()));
        parallel_for(tiles(), threads_,
                     [&](std::int64_t i) { emit(region_of(i), parts[static_cast<std::size_t>(i)]); });
        return parts;
    }

    // Appends a triangle: apex, then the ends of its hypotenuse, counter-clockwise.
    void draw(const std::array<SampleIndex, 3>& places, const Patch<double>& numbers, Part& part) {
        const SampleIndex corners[3] = {tree_.sample(places[0]), tree_.sample(places[1]), tree_.sample(places[2])};
        const SampleIndex p = corners[0], q = corners[1], r = corners[2];
        const std::int64_t area =
            std::int64_t{q.column - p.column} * (r.row - p.row) - std::int64_t{q.row - p.row} * (r.column - p.column);
        if (area == 0) return; // beyond the rim
        double error_m = 0;
        if (!measure_triangle(corners, numbers, error_m)) return;
        part.true_error_m = std::max(part.true_error_m, error_m);
        std::array<std::uint32_t, 3> triangle;
        for (std::size_t k = 0; k < 3; ++k) {
            used_.set(corners[k].column, corners[k].row);
            triangle[k] = static_cast<std::uint32_t>((corners[k].row - numbers.y) * (tree_.side() + 1) +
                                                     corners[k].column - numbers.x);
        }
        part.triangles.push_back(triangle);
    }

    // The largest vertical distance of the numbers under a triangle from it, in double. False: a corner is a hole.
    [[nodiscard]] bool measure_triangle(const SampleIndex (&c)[3], const Patch<double>& numbers,
                                        double& error_m) const {
        double h[3];
        for (int k = 0; k < 3; ++k) {
            const double number = *numbers.at(c[k].column, c[k].row);
            if (std::isnan(number)) return false;
            h[k] = static_cast<double>(static_cast<float>(number));
            error_m = std::max(error_m, std::abs(number - h[k]));
        }
        // In raster coordinates corners that run counter-clockwise on the map have a negative area.
        const double ux = c[1].column - c[0].column, uy = c[1].row - c[0].row, vx = c[2].column - c[0].column,
                     vy = c[2].row - c[0].row, area = ux * vy - uy * vx;
        const double gx = ((h[1] - h[0]) * vy - (h[2] - h[0]) * uy) / area,
                     gy = ((h[2] - h[0]) * ux - (h[1] - h[0]) * vx) / area;
        const auto [top, bottom] = std::minmax({c[0].row, c[1].row, c[2].row});
        for (std::int32_t y = top; y <= bottom; ++y) {
            double from = -HUGE_VAL, to = HUGE_VAL;
            for (int k = 0; k < 3; ++k) { // inside is on the same side of all edges
                const SampleIndex p = c[k], q = c[(k + 1) % 3];
                const double ex = q.column - p.column, ey = q.row - p.row, at = ex * (y - p.row);
                // area < 0: ex (y - p.row) - ey (x - p.column) <= 0
                if (ey > 0)
                    from = std::max(from, p.column + at / ey);
                else if (ey < 0)
                    to = std::min(to, p.column + at / ey);
                else if (at > 0)
                    to = -HUGE_VAL;
            }
            // Ends are whole or at least 1 / side away from being so.
            const auto first = static_cast<std::int32_t>(std::ceil(from - 1e-6)),
                       last = static_cast<std::int32_t>(std::floor(to + 1e-6));
            const double row = h[0] + gy * (y - c[0].row) - gx * c[0].column;
            const double* const number = numbers.at(first, y);
            for (std::int32_t x = first; x <= last; ++x)
                if (const double off = std::abs(number[x - first] - (row + gx * x)); off > error_m) error_m = off;
        }
        error_m += std::abs(gx) * moved_[0] + std::abs(gy) * moved_[1];
        return true;
    }

    void emit(const Region& r, Part& part) {
        Patch<double> numbers;
        read(r, numbers);
        const SampleIndex nw = r.first, se = r.last, ne{se.column, nw.row}, sw{nw.column, se.row};
        const auto is_vertex = [&](SampleIndex at) { return active_.at(at.column, at.row); };
        const auto take = [&](SampleIndex apex, SampleIndex a, SampleIndex b) { draw({apex, a, b}, numbers, part); };
        bisect_triangle(ne, nw, se, is_vertex, take);
        bisect_triangle(sw, se, nw, is_vertex, take);
    }

    // ---- the mesh

    [[nodiscard]] HeightMesh assemble(std::vector<Part>& parts, std::vector<Part>& base) {
        HeightMesh mesh;
        for (std::size_t i = 0; i < parts.size(); ++i) {
            const double error_m = parts[i].true_error_m;
            mesh.true_error_m = std::max(mesh.true_error_m, error_m);
            if (allowed_m(region_of(static_cast<std::int64_t>(i))) <= options_.max_error_m)
                mesh.area_error_m = std::max(mesh.area_error_m, error_m);
        }
        std::uint64_t vertices = 0;
        std::vector<std::uint64_t> before(used_.words() * static_cast<std::size_t>(array_.rows));
        for (std::size_t w = 0; w < before.size(); ++w) {
            before[w] = vertices;
            vertices += static_cast<std::uint64_t>(std::popcount(used_.row(0)[w]));
        }
        if (vertices > 0xffff'ffff)
            throw Failure(3, fmt::format(FMT_COMPILE("max_error: keeps {} vertices, more than 32 bits count; give a "
                                                     "larger one, or a part of the heights"),
                                         vertices));
        mesh.vertices.resize(static_cast<std::size_t>(vertices));
        parallel_for(array_.rows, threads_, [&](std::int64_t y) { write_vertices(y, before, mesh); });
        number(parts, before, mesh.triangles);
        number(base, before, mesh.base);
        return mesh;
    }

    // Places become the vertices' numbers.
    void number(std::vector<Part>& parts, const std::vector<std::uint64_t>& before,
                std::vector<std::array<std::uint32_t, 3>>& to) const {
        std::size_t triangles = 0;
        for (Part& part : parts) {
            part.first = triangles;
            triangles += part.triangles.size();
        }
        to.resize(triangles);
        parallel_for(static_cast<std::int64_t>(parts.size()), threads_, [&](std::int64_t i) {
            Part& part = parts[static_cast<std::size_t>(i)];
            const SampleIndex first = region_of(i).first;
            const auto row = static_cast<std::uint32_t>(tree_.side() + 1);
            for (std::size_t t = 0; t < part.triangles.size(); ++t)
                for (std::size_t k = 0; k < 3; ++k) {
                    const std::uint32_t place = part.triangles[t][k];
                    const std::size_t x = static_cast<std::size_t>(first.column) + place % row;
                    const std::size_t w = (static_cast<std::size_t>(first.row) + place / row) * used_.words() + x / 64;
                    const std::uint64_t west = used_.row(0)[w] & ((std::uint64_t{1} << (x % 64)) - 1);
                    to[part.first + t][k] =
                        static_cast<std::uint32_t>(before[w] + static_cast<std::uint64_t>(std::popcount(west)));
                }
            part = {};
        });
    }

    void write_vertices(std::int64_t y, const std::vector<std::uint64_t>& before, HeightMesh& mesh) const {
        const std::uint64_t* const row = used_.row(y);
        const auto z_m = static_cast<float>(static_cast<double>(y) * options_.spacing_m[1]);
        auto to = static_cast<std::size_t>(before[static_cast<std::size_t>(y) * used_.words()]);
        for (std::size_t w = 0; w < used_.words(); ++w)
            for (std::uint64_t left = row[w]; left != 0; left &= left - 1, ++to) {
                const auto x = static_cast<std::int64_t>(w) * 64 + std::countr_zero(left);
                const auto x_m = static_cast<float>(static_cast<double>(x) * options_.spacing_m[0]);
                float height_m = 0;
                double number = 0;
                array_.read(y, x, 1, &number);
                height_m = static_cast<float>(number);
                mesh.vertices[to] =
                    options_.z_up ? std::array{x_m, 0.0f - z_m, height_m} : std::array{x_m, height_m, z_m};
            }
    }

    const HeightArray& array_;
    const HeightMeshOptions& options_;
    const int threads_;
    const Tree tree_;
    const HeightScale scale_;
    Bits active_; // of the grid's places
    Bits used_;   // samples that are vertices of the mesh
    const double moved_[2];
};

void check(const HeightArray& heights, const HeightMeshOptions& options) {
    if (heights.columns < 2 || heights.rows < 2)
        throw Failure(1, fmt::format(FMT_COMPILE("heights: has {} x {} samples; a mesh needs at least 2 x 2"),
                                     heights.columns, heights.rows));
    if (std::max(heights.columns, heights.rows) > max_columns)
        throw Failure(1, fmt::format(FMT_COMPILE("heights: has {} x {} samples; give a part of at most {} a side"),
                                     heights.columns, heights.rows, max_columns));
    if (!(options.max_error_m >= 0) || std::isinf(options.max_error_m))
        throw Failure(2, "max_error: is below 0 or no number; give metres, 0 or more");
    if (const auto& a = options.area; a && !(a->radius_m >= 0 && a->growth >= 0 && std::isfinite(a->x_m + a->z_m)))
        throw Failure(2, "area: give a place, and a radius and a growth of 0 or more");
    for (const double spacing : options.spacing_m)
        if (!(spacing > 0) || std::isinf(spacing))
            throw Failure(2, "spacing: is 0 or below, or no number; give metres, more than 0");
}

Extent checked_extent(const HeightArray& heights, const HeightMeshOptions& options) {
    check(heights, options);
    const Extent extent = extent_of(heights, resolve_threads(options.threads));
    if (extent.infinite != 0)
        throw Failure(
            1,
            fmt::format(FMT_COMPILE("heights: {} of {} are infinite, or too large for a float, the first at row {}, "
                                    "column {}; make them NaN if they are no ground"),
                        extent.infinite, heights.columns * heights.rows, extent.infinite_row, extent.infinite_column));
    if (!(extent.least_m <= extent.most_m)) throw Failure(1, "heights: all are NaN or masked; there is no ground");
    return extent;
}

} // namespace

bool has_voids(const HeightArray& heights, const HeightMeshOptions& options) {
    return checked_extent(heights, options).voids != 0;
}

HeightMesh mesh_unfilled(const HeightArray& heights, const HeightMeshOptions& options) {
    const Extent extent = checked_extent(heights, options);
    if (extent.voids != 0 && options.nodata == NoData::refuse)
        throw Failure(
            1,
            fmt::format(FMT_COMPILE("heights: {} of {} are NaN or masked, the first at row {}, column {}; let them be "
                                    "holes, or fill them"),
                        extent.voids, heights.columns * heights.rows, extent.void_row, extent.void_column));
    return Mesher(heights, options, extent).run();
}

} // namespace fjell::baker
