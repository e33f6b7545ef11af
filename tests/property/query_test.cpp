// Heights, rays and patches against the full-resolution ground, found cell by cell; with all pages and with some.
#include <catch2/catch.hpp>

#include <limits>
#include <memory>
#include <vector>

#include "fjell/query.h"
#include "shared/terrain_data.h"
#include "support/ground_truth.h"
#include "support/rounds.h"

using namespace fjell;
using namespace fjell::test;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity(),
                 no_number = std::numeric_limits<double>::quiet_NaN();

struct Place {
    double column, row;
};
// Inside a cell, on its edges and corners, on tiles' borders and the rim.
Place random_place(Random& random, const Terrain& t) {
    const std::int32_t columns = data_of(t).tree.columns(), rows = data_of(t).tree.rows(),
                       side = data_of(t).tree.side();
    const auto one = [&](std::int32_t count) -> double {
        switch (pick(random, 0, 5)) {
        case 0: return pick(random, 0, count - 1);
        case 1: return std::min(pick(random, 0, count / side) * side, count - 1);
        case 2: return count - 1;
        default: return uniform(random, 0, count - 1);
        }
    };
    return {one(columns), one(rows)};
}

double half_quantum(const Terrain& t) {
    return 0.5 * static_cast<double>(data_of(t).height_scale.quantum_m);
}

} // namespace

TEST_CASE("with all pages a height is that of the full-resolution triangle under it, to within half a quantum") {
    Random random(601);
    std::size_t holes = 0, ground = 0;
    for (int round = 0; round < rounds(30, 120); ++round) {
        const auto pack = random_ground(random, true);
        const Terrain& t = pack.terrain;
        for (int k = 0; k < 200; ++k) {
            const Place p = random_place(random, t);
            const double x = p.column * t.header().spacing_m[0], z = p.row * t.header().spacing_m[1];
            const GroundHeight got = ground_height(t, x, z);
            const TruePlane plane = true_plane(t, p.column, p.row);
            CAPTURE(round, k, p.column, p.row, data_of(t).tree.columns(), data_of(t).tree.rows(),
                    data_of(t).tree.tile_log2, plane.hole);
            const bool edge = std::floor(p.column) == p.column || std::floor(p.row) == p.row; // of several triangles
            if (!edge) REQUIRE(got.hole == plane.hole);
            (got.hole ? holes : ground)++;
            if (got.hole || plane.hole) continue;
            REQUIRE(std::abs(got.height_m - at(plane, p.column, p.row)) <= rounding_m(t));
            REQUIRE(got.finest);
            REQUIRE(static_cast<double>(got.error_m) == Approx(half_quantum(t)).epsilon(0x1p-22));
            REQUIRE(std::abs(length(got.normal) - 1) < 1e-12);
            if (edge) continue;
            const Vec3 normal = normalised({-plane.x / t.header().spacing_m[0], 1, -plane.y / t.header().spacing_m[1]});
            // An angle: heights' rounding over a cell.
            REQUIRE(length(got.normal - normal) <=
                    4 * rounding_m(t) / std::min(t.header().spacing_m[0], t.header().spacing_m[1]) + 0x1p-40);
        }
    }
    REQUIRE(holes > rounds<std::size_t>(100, 500));
    REQUIRE(ground > rounds<std::size_t>(1000, 5000));
}

TEST_CASE("whatever pages are missing, the full-resolution ground is within the error of every answer") {
    Random random(602);
    std::size_t coarse = 0, exact = 0;
    double nearest = 0; // the tightest bound met
    for (int round = 0; round < rounds(60, 250); ++round) {
        const auto pack = random_ground(random, true);
        PagedTerrain paged(pack.pack, {});
        load_some_pages(random, pack.pack, paged.terrain);
        const Terrain& t = paged.terrain;
        for (int k = 0; k < 200; ++k) {
            const Place p = random_place(random, t);
            const double x = p.column * t.header().spacing_m[0], z = p.row * t.header().spacing_m[1];
            const float accurate_m = k % 2 ? 0.0f : static_cast<float>(t.header().max_error_m * std::pow(2.0, -k % 12));
            const GroundHeight got = ground_height(t, x, z, accurate_m);
            const TruePlane plane = true_plane(pack.terrain, p.column, p.row);
            if (plane.hole || got.hole) continue;
            const double error = std::abs(got.height_m - at(plane, p.column, p.row));
            const double bound = static_cast<double>(got.error_m) - half_quantum(t);
            CAPTURE(round, k, p.column, p.row, data_of(t).tree.columns(), data_of(t).tree.rows(),
                    data_of(t).tree.tile_log2, accurate_m);
            REQUIRE(error <= bound + rounding_m(t) + 0x1p-23 * static_cast<double>(got.error_m));
            if (got.finest) REQUIRE(error <= rounding_m(t));
            (got.finest ? exact : coarse)++;
            if (bound > 0) nearest = std::max(nearest, error / bound);
        }
    }
    REQUIRE(coarse > rounds<std::size_t>(2'000, 10'000));
    REQUIRE(exact > rounds<std::size_t>(1'000, 5'000));
    REQUIRE(nearest > 0.9); // the bounds are met, not only kept
}

TEST_CASE("with all pages an answer is as accurate as it was asked to be") {
    Random random(603);
    std::size_t coarse = 0;
    for (int round = 0; round < 100; ++round) {
        const auto pack = random_ground(random, true);
        const Terrain& t = pack.terrain;
        for (int k = 0; k < 100; ++k) {
            const Place p = random_place(random, t);
            const double x = p.column * t.header().spacing_m[0], z = p.row * t.header().spacing_m[1];
            const float accurate_m =
                static_cast<float>(half_quantum(t) + uniform(random, 0, 1) * t.header().max_error_m);
            const GroundHeight got = ground_height(t, x, z, accurate_m);
            REQUIRE((got.finest || got.error_m <= accurate_m));
            coarse += !got.finest;
        }
    }
    REQUIRE(coarse > 1000);
}

// Orders by levels work out the whole way down beforehand, linear order goes from triangle to triangle.
TEST_CASE("all orders give the same answers, bit for bit, also on the lines between triangles") {
    Random random(606);
    std::size_t finest = 0, coarse = 0;
    for (int round = 0; round < rounds(12, 100); ++round) {
        const int log2 = pick(random, 1, 7), most = 3 << log2;
        baker::Dem dem = random_dem(random, pick(random, 2, most), pick(random, 2, most),
                                    static_cast<Shape>(pick(random, 0, static_cast<int>(Shape::count) - 1)));
        if (round % 2) add_random_holes(random, dem, log2);
        baker::BakeOptions options = small_bake(log2);
        std::vector<io::LoadedPack> packs;
        for (const PageOrder order : {PageOrder::planar, PageOrder::hierarchical_z, PageOrder::linear}) {
            options.order = order;
            packs.push_back(bake_and_load(dem, options));
        }
        const Terrain& t = packs[0].terrain;
        for (int k = 0; k < 300; ++k) {
            Place p = random_place(random, t);
            if (k % 4 == 1) p.row = std::floor(p.row) + (p.column - std::floor(p.column)); // x - y is a whole number
            if (k % 4 == 2) p.row = std::ceil(p.row) - (p.column - std::floor(p.column));  // x + y
            const double x = p.column * t.header().spacing_m[0], z = p.row * t.header().spacing_m[1];
            const auto accurate_m = static_cast<float>(k % 3 ? 0 : uniform(random, 0, 1) * t.header().max_error_m);
            const GroundHeight planar = ground_height(t, x, z, accurate_m);
            CAPTURE(round, k, p.column, p.row, log2, accurate_m);
            for (std::size_t other : {1u, 2u}) {
                const GroundHeight same = ground_height(packs[other].terrain, x, z, accurate_m);
                REQUIRE(same.height_m == planar.height_m);
                REQUIRE(same.normal.x == planar.normal.x);
                REQUIRE(same.normal.y == planar.normal.y);
                REQUIRE(same.normal.z == planar.normal.z);
                REQUIRE(same.error_m == planar.error_m);
                REQUIRE(same.hole == planar.hole);
                REQUIRE(same.finest == planar.finest);
                REQUIRE(same.inside == planar.inside);
            }
            (planar.finest ? finest : coarse)++;
        }
    }
    CHECK(finest > 500);
    CHECK(coarse > 200);
}

TEST_CASE("a position beyond the rim gets the nearest height on it, and says so") {
    Random random(604);
    for (int round = 0; round < 20; ++round) {
        const auto pack = random_ground(random, false);
        const Terrain& t = pack.terrain;
        const double wx = (data_of(t).tree.columns() - 1) * t.header().spacing_m[0],
                     wz = (data_of(t).tree.rows() - 1) * t.header().spacing_m[1], z = uniform(random, 0, wz);
        for (const double x : {-1e-9 * wx, -wx, -1e300, -infinity}) {
            const GroundHeight got = ground_height(t, x, z);
            REQUIRE(!got.inside);
            REQUIRE(got.height_m == ground_height(t, 0, z).height_m);
        }
        const double x = uniform(random, 0, wx);
        for (const double beyond : {-1e-9 * wz, -wz, 2 * wz, infinity}) REQUIRE(!ground_height(t, x, beyond).inside);
        REQUIRE(ground_height(t, 2 * wx, 2 * wz).height_m ==
                Approx(data_of(t).height_m({data_of(t).tree.columns() - 1, data_of(t).tree.rows() - 1}))
                    .margin(0x1p-22 * std::abs(t.header().max_m)));
        REQUIRE(ground_height(t, 0, 0).inside);
        REQUIRE(!ground_height(t, no_number, z).inside);
        REQUIRE(std::isfinite(ground_height(t, no_number, no_number).height_m));
    }
}

TEST_CASE("a patch holds the heights of its samples, the pack's own where their pages are there") {
    Random random(605);
    for (int round = 0; round < rounds(100, 600); ++round) {
        const auto pack = random_ground(random, true);
        PagedTerrain paged(pack.pack, {});
        const bool all = round % 3 == 0;
        if (!all) load_some_pages(random, pack.pack, paged.terrain);
        const Terrain& t = all ? pack.terrain : paged.terrain;
        const int step = pick(random, 0, round % 5 == 4 ? 7 : 3); // with large ones the rim comes soon
        const auto side = static_cast<std::uint32_t>(pick(random, 2, 40));
        SampleIndex first{pick(random, -20, data_of(t).tree.columns()), pick(random, -20, data_of(t).tree.rows())};
        if (pick(random, 0, 1)) first = {first.column >> step << step, first.row >> step << step};
        std::vector<float> heights(side * side);
        const auto holes = std::make_unique<bool[]>(side * side);
        const GroundPatch patch = ground_patch(t, first, step, side, heights, {holes.get(), side * side});
        if (all) REQUIRE(patch.finest);
        for (std::uint32_t j = 0; j < side; ++j)
            for (std::uint32_t i = 0; i < side; ++i) {
                const SampleIndex c{
                    std::clamp(first.column + (static_cast<int>(i) << step), 0, data_of(t).tree.columns() - 1),
                    std::clamp(first.row + (static_cast<int>(j) << step), 0, data_of(t).tree.rows() - 1)};
                const float got = heights[j * side + i];
                const TerrainData::Vertex truth = data_of(pack.terrain).vertex(c);
                const double rounding =
                    0x1p-22 * (std::abs(t.header().min_m) + std::abs(t.header().max_m)) + rounding_m(t);
                CAPTURE(round, i, j, c.column, c.row, first.column, first.row, step);
                if (patch.finest) {
                    REQUIRE(got == Approx(truth.height_m).margin(rounding));
                    REQUIRE(holes[j * side + i] == (t.has_voids() && truth.hole));
                }
                if (all) REQUIRE(got == truth.height_m);
                if (!truth.hole && !holes[j * side + i])
                    REQUIRE(std::abs(static_cast<double>(got) - truth.height_m) <= patch.error_m + rounding);
            }
        REQUIRE(!ground_patch(t, first, step, side, std::span(heights).first(side)).finest);
    }
}

TEST_CASE(
    "a patch with the diagonals that the header names is the full-resolution surface, whatever its first sample") {
    Random random(607);
    std::size_t holes = 0, ground = 0;
    for (int round = 0; round < rounds(30, 120); ++round) {
        const auto pack = random_ground(random, true);
        const Terrain& t = pack.terrain;
        const int columns = data_of(t).tree.columns(), rows = data_of(t).tree.rows();
        const int side = pick(random, 2, std::min({columns, rows, 20}));
        const SampleIndex first{pick(random, 0, columns - side), pick(random, 0, rows - side)};
        std::vector<float> heights(static_cast<std::size_t>(side * side));
        const auto is_hole = std::make_unique<bool[]>(heights.size());
        const auto count = static_cast<std::uint32_t>(side);
        const double largest = std::max(std::abs(double(t.header().min_m)), std::abs(double(t.header().max_m)));
        REQUIRE(ground_patch(t, first, 0, count, heights, {is_hole.get(), heights.size()}).finest);
        for (int k = 0; k < 100; ++k) {
            const int x = pick(random, 0, side - 2), y = pick(random, 0, side - 2);
            const double u = uniform(random, 0.01, 0.99), v = uniform(random, 0.01, 0.99);
            const bool falling = (first.column + x + first.row + y) % 2 == 0;
            if (std::abs(falling ? u - v : u + v - 1) < 0.01) continue; // of both triangles
            // From the corner at the right angle, towards the two others.
            const bool east = falling ? u > v : u + v > 1, south = falling ? u < v : u + v > 1;
            const auto place = [&](bool e, bool s) { return static_cast<std::size_t>((y + s) * side + x + e); };
            const std::size_t apex = place(east, south), along_x = place(!east, south), along_z = place(east, !south);
            const double height = double(heights[apex]) +
                                  double(heights[along_x] - heights[apex]) * (east ? 1 - u : u) +
                                  double(heights[along_z] - heights[apex]) * (south ? 1 - v : v);
            const GroundHeight got = ground_height(t, (first.column + x + u) * t.header().spacing_m[0],
                                                   (first.row + y + v) * t.header().spacing_m[1]);
            CAPTURE(round, k, first.column + x, first.row + y, u, v, falling);
            const bool hole = is_hole[apex] || is_hole[along_x] || is_hole[along_z];
            REQUIRE(got.hole == hole);
            (hole ? holes : ground)++;
            // Heights of a patch are floats, of which three are combined.
            if (!hole) REQUIRE(std::abs(got.height_m - height) <= rounding_m(t) + 3 * 0x1p-23 * largest);
        }
    }
    CHECK(holes > 10);
    CHECK(ground > 1000);
}

TEST_CASE("beside the rim a bound also holds between samples that show no error") {
    // Heights of a chequered board on even places, halfway between elsewhere. Squares of two cells that the rim cuts to
    // one are exact at every sample, but their diagonal is bent: in the middle it is a quarter of the step off.
    baker::Dem dem;
    dem.columns = dem.rows = 40;
    dem.spacing_m[0] = dem.spacing_m[1] = 10;
    for (int y = 0; y < dem.rows; ++y)
        for (int x = 0; x < dem.columns; ++x)
            dem.heights_m.push_back(x % 2 == 0 && y % 2 == 0 ? static_cast<float>((x / 2 + y / 2) % 2 * 100) : 50.0f);
    const auto pack = bake_and_load(std::move(dem), small_bake(6));
    PagedTerrain paged(pack.pack, {});
    REQUIRE(load_page(pack.pack, paged.terrain, 0, 0).ok()); // all but step 1
    const Terrain& t = paged.terrain;
    double worst = 0;
    for (int j = 1; j < 390; ++j)
        for (const double column : {38.25, 38.5, 38.75}) {
            const double row = j * 0.1;
            const GroundHeight got = ground_height(t, column * 10, row * 10);
            const double error = std::abs(got.height_m - at(true_plane(pack.terrain, column, row), column, row));
            CAPTURE(column, row);
            REQUIRE(error <= static_cast<double>(got.error_m) - half_quantum(t) + rounding_m(t) +
                                 0x1p-23 * static_cast<double>(got.error_m));
            worst = std::max(worst, error);
        }
    REQUIRE(worst > 20);
}
