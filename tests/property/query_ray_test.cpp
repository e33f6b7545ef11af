// Rays against every triangle of the full resolution, and against heights along their way.
#include <catch2/catch.hpp>

#include <limits>
#include <vector>

#include "fjell/query.h"
#include "shared/terrain_data.h"
#include "support/ground_truth.h"
#include "support/rounds.h"

using namespace fjell;
using namespace fjell::test;

namespace {

struct Ray {
    Vec3 origin, direction;
    double most;
};

// From anywhere, inside, above, below or beside the terrain; along edges, straight down, level, steep, of any length.
Ray random_ray(Random& random, const Terrain& t) {
    const double sx = t.header().spacing_m[0], sz = t.header().spacing_m[1];
    const double wx = (data_of(t).tree.columns() - 1) * sx, wz = (data_of(t).tree.rows() - 1) * sz,
                 extent = std::max(wx, wz);
    const double range = std::max(static_cast<double>(t.header().max_m - t.header().min_m), 0.01 * extent);
    Ray ray;
    ray.origin = {uniform(random, -0.5, 1.5) * wx, t.header().min_m + uniform(random, -1, 2) * range,
                  uniform(random, -0.5, 1.5) * wz};
    const Vec3 target{uniform(random, 0, 1) * wx, t.header().min_m + uniform(random, 0, 1) * range,
                      uniform(random, 0, 1) * wz};
    ray.direction = target - ray.origin;
    switch (pick(random, 0, 7)) {
    case 0: // straight down or up
        ray.origin = {target.x, ray.origin.y, target.z};
        ray.direction = {0, pick(random, 0, 1) ? 1.0 : -1.0, 0};
        break;
    case 1: // along a row of samples
        ray.origin.z = pick(random, 0, data_of(t).tree.rows() - 1) * sz;
        ray.direction.z = 0;
        break;
    case 2: // along a diagonal through samples
        ray.origin.x = pick(random, 0, data_of(t).tree.columns() - 1) * sx;
        ray.origin.z = pick(random, 0, data_of(t).tree.rows() - 1) * sz;
        ray.direction.x = pick(random, 0, 1) ? sx : -sx;
        ray.direction.z = pick(random, 0, 1) ? sz : -sz;
        ray.direction.y = uniform(random, -1, 1) * range / std::max(data_of(t).tree.columns(), data_of(t).tree.rows());
        break;
    case 3: ray.direction.y *= 0.01; break; // grazing
    default: break;
    }
    if (pick(random, 0, 3) == 0) // from far away
        ray.origin = ray.origin + ray.direction * (-1000 / std::max(length(ray.direction) / extent, 1e-6));
    ray.direction = ray.direction * std::pow(10.0, uniform(random, -8, 8));
    ray.most = pick(random, 0, 3) == 0 ? uniform(random, 0, 2) * extent : std::numeric_limits<double>::infinity();
    return ray;
}

struct Hits {
    double sure = std::numeric_limits<double>::infinity();     // well inside a triangle: nobody may pass it
    double possible = std::numeric_limits<double>::infinity(); // the first that rounding may see
};

// All triangles, one by one, in cells and metres. loss: how far a place on the ray may be off, in metres of height.
Hits brute_force(const Terrain& t, const Ray& ray, double slack_cells, double loss_m) {
    Hits hits;
    const Vec3 d =
        normalised(ray.direction *
                   (1 / std::max({std::abs(ray.direction.x), std::abs(ray.direction.y), std::abs(ray.direction.z)})));
    const double ox = ray.origin.x / t.header().spacing_m[0], oy = ray.origin.z / t.header().spacing_m[1],
                 dx = d.x / t.header().spacing_m[0], dy = d.z / t.header().spacing_m[1];
    for (std::int32_t j = 0; j + 1 < data_of(t).tree.rows(); ++j)
        for (std::int32_t i = 0; i + 1 < data_of(t).tree.columns(); ++i)
            for (const auto& c : halves_of_cell(i, j)) {
                const TruePlane plane = test::plane_of(t, c);
                if (plane.hole) continue;
                const double g = ray.origin.y - at(plane, ox, oy), slope = d.y - plane.x * dx - plane.y * dy;
                // Where the ray is over the triangle.
                double from = 0, to = ray.most;
                double area = (c[1].column - c[0].column) * double(c[2].row - c[0].row) -
                              (c[1].row - c[0].row) * double(c[2].column - c[0].column);
                bool inside = true, near = true;
                double near_from = 0, near_to = ray.most;
                for (std::size_t k = 0; k < 3; ++k) {
                    const SampleIndex a = c[k], b = c[(k + 1) % 3];
                    const double sign = area > 0 ? 1 : -1;
                    const double e0 = sign * ((b.column - a.column) * (oy - a.row) - (b.row - a.row) * (ox - a.column)),
                                 e1 = sign * ((b.column - a.column) * dy - (b.row - a.row) * dx);
                    const auto clip = [&](double least, double& lo, double& hi, bool& ok) { // e0 + e1 s >= least
                        if (e1 == 0)
                            ok = ok && e0 >= least;
                        else if (e1 > 0)
                            lo = std::max(lo, (least - e0) / e1);
                        else
                            hi = std::min(hi, (least - e0) / e1);
                    };
                    clip(slack_cells, from, to, inside);
                    clip(-slack_cells, near_from, near_to, near);
                }
                if (inside && from <= to) {
                    const double s = -g / slope;
                    if (slope != 0 && s >= from && s <= to && g + slope * from != 0) hits.sure = std::min(hits.sure, s);
                }
                if (near && near_from <= near_to) {
                    const double g0 = g + slope * near_from, g1 = g + slope * near_to;
                    if (std::min(g0, g1) <= loss_m && std::max(g0, g1) >= -loss_m) {
                        // The first place that is within loss of the plane.
                        double s = near_from;
                        if (std::abs(g0) > loss_m) s = near_from + (std::abs(g0) - loss_m) / std::abs(slope);
                        hits.possible = std::min(hits.possible, s);
                    }
                }
            }
    return hits;
}

// Cells from the origin to the far end of the terrain: what places lose grows with it.
double reach_cells(const Terrain& t, const Ray& ray) {
    return std::abs(ray.origin.x / t.header().spacing_m[0]) + std::abs(ray.origin.z / t.header().spacing_m[1]) +
           std::abs(ray.origin.y) / std::min(t.header().spacing_m[0], t.header().spacing_m[1]) +
           data_of(t).tree.columns() + data_of(t).tree.rows();
}

} // namespace

TEST_CASE("with all pages a ray meets the triangle that it meets first of all") {
    Random random(611);
    std::size_t met = 0, missed = 0;
    for (int round = 0; round < rounds(60, 250); ++round) {
        const auto pack = random_ground(random, true);
        const Terrain& t = pack.terrain;
        for (int k = 0; k < 12; ++k) {
            const Ray ray = random_ray(random, t);
            const GroundHit hit = cast_ray(t, ray.origin, ray.direction, ray.most);
            // Places lose some 2^-48 of the way, heights that times the slope of the ground and of the ray.
            const double cells = reach_cells(t, ray), slack = 0x1p-46 * cells;
            const double range = t.header().height_steps * static_cast<double>(data_of(t).height_scale.quantum_m);
            const double loss = rounding_m(t, cells) + slack * (range + std::abs(ray.origin.y)) * 4;
            const Hits hits = brute_force(t, ray, slack, loss);
            CAPTURE(round, k, hits.sure, hits.possible, hit.distance_m, data_of(t).tree.columns(),
                    data_of(t).tree.rows(), data_of(t).tree.tile_log2, ray.origin.x, ray.origin.y, ray.origin.z,
                    ray.direction.x, ray.direction.y, ray.direction.z, ray.most, t.header().spacing_m[0]);
            const double off = slack * std::max(t.header().spacing_m[0], t.header().spacing_m[1]) * 4;
            if (!hit.hit) {
                REQUIRE(hits.sure > 1e300);
                ++missed;
                continue;
            }
            ++met;
            REQUIRE(hit.finest);
            REQUIRE(hit.distance_m <= ray.most);
            REQUIRE(hit.distance_m <= hits.sure + off);
            REQUIRE(hit.distance_m >= hits.possible - off);
            const Vec3 along = ray.origin + normalised(ray.direction * (1 / length(ray.direction))) * hit.distance_m;
            REQUIRE(length(along - hit.position_m) <= off);
            REQUIRE(static_cast<double>(hit.error_m) ==
                    Approx(0.5 * static_cast<double>(data_of(t).height_scale.quantum_m)).epsilon(0x1p-22));
        }
    }
    REQUIRE(met > rounds<std::size_t>(100, 500));
    REQUIRE(missed > rounds<std::size_t>(60, 300));
}

TEST_CASE("whatever pages are missing, a ray's hit is within its error of the ground, and no ground is passed") {
    Random random(612);
    std::size_t met = 0, coarse = 0, marched = 0;
    for (int round = 0; round < rounds(100, 500); ++round) {
        const auto pack = random_ground(random, true);
        PagedTerrain paged(pack.pack, {});
        load_some_pages(random, pack.pack, paged.terrain);
        const Terrain& t = paged.terrain;
        for (int k = 0; k < 20; ++k) {
            const Ray ray = random_ray(random, t);
            const float accurate_m = k % 4 ? 0.0f : t.header().max_error_m * 0.1f;
            const GroundHit hit = cast_ray(t, ray.origin, ray.direction, ray.most, accurate_m);
            const double cells = reach_cells(t, ray);
            const double range = t.header().height_steps * static_cast<double>(data_of(t).height_scale.quantum_m);
            const double loss = rounding_m(t, cells) + 0x1p-44 * cells * (range + std::abs(ray.origin.y));
            CAPTURE(round, k, hit.distance_m, data_of(t).tree.columns(), data_of(t).tree.rows(),
                    data_of(t).tree.tile_log2, accurate_m);
            if (hit.hit) {
                ++met;
                coarse += !hit.finest;
                const double column = hit.position_m.x / t.header().spacing_m[0],
                             row = hit.position_m.z / t.header().spacing_m[1];
                const TruePlane plane = true_plane(pack.terrain, column, row);
                if (!plane.hole)
                    REQUIRE(std::abs(hit.position_m.y - at(plane, column, row)) <=
                            static_cast<double>(hit.error_m) + loss);
            }
            // Up to there, or to its end, the ray stays on one side of what ground_height() says.
            if (t.has_voids()) continue;
            const Vec3 d = normalised(ray.direction * (1 / length(ray.direction)));
            const double end = hit.hit ? hit.distance_m : std::min(ray.most, 2000.0 * cells * t.header().spacing_m[0]);
            const double wx = (data_of(t).tree.columns() - 1) * t.header().spacing_m[0],
                         wz = (data_of(t).tree.rows() - 1) * t.header().spacing_m[1];
            int side = 0;
            for (int n = 0; n < 60; ++n) {
                const Vec3 p = ray.origin + d * (end * uniform(random, 0, 1));
                if (p.x < 0 || p.z < 0 || p.x > wx || p.z > wz) continue;
                const double over = p.y - ground_height(t, p.x, p.z, accurate_m).height_m;
                if (std::abs(over) <= loss) continue;
                const int now = over > 0 ? 1 : -1;
                if (side == 0) side = now;
                REQUIRE(side == now);
                ++marched;
            }
        }
    }
    REQUIRE(met > rounds<std::size_t>(200, 1000));
    REQUIRE(coarse > rounds<std::size_t>(60, 300));
    REQUIRE(marched > rounds<std::size_t>(600, 3000));
}

TEST_CASE("a ray that is none meets nothing, and one from the ground meets it at once") {
    Random random(613);
    const double infinity = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
    const auto pack = bake_and_load(random_dem(random, 70, 50, Shape::fractal), small_bake(5));
    const Terrain& t = pack.terrain;
    const double x = 20.25 * t.header().spacing_m[0], z = 30.5 * t.header().spacing_m[1];
    const Vec3 above{x, t.header().max_m + 10.0, z}, down{0, -1, 0};
    REQUIRE(cast_ray(t, above, down, infinity).hit);
    REQUIRE(cast_ray(t, above, down * 1e-300, infinity).hit);
    REQUIRE(cast_ray(t, above, down * 1e300, 1e300).hit);
    REQUIRE(cast_ray(t, above, down, infinity).position_m.y == Approx(ground_height(t, x, z).height_m));
    REQUIRE(!cast_ray(t, above, {0, 0, 0}, infinity).hit);
    REQUIRE(!cast_ray(t, above, {0, nan, 0}, infinity).hit);
    REQUIRE(!cast_ray(t, above, {0, -infinity, 0}, infinity).hit);
    REQUIRE(!cast_ray(t, {nan, 0, 0}, down, infinity).hit);
    REQUIRE(!cast_ray(t, {infinity, 0, 0}, down, infinity).hit);
    REQUIRE(!cast_ray(t, above, down, nan).hit);
    REQUIRE(!cast_ray(t, above, down, -1).hit);
    REQUIRE(!cast_ray(t, above, down, 9).hit); // too short
    REQUIRE(!cast_ray(t, above, {0, 1, 0}, infinity).hit);
    REQUIRE(!cast_ray(t, {1e300, 1e300, 1e300}, {-1, -1, -1.1}, infinity).hit);
    // From below it is met as well.
    REQUIRE(cast_ray(t, {x, t.header().min_m - 10.0, z}, {0, 1, 0}, infinity).position_m.y ==
            Approx(ground_height(t, x, z).height_m));
    const SampleIndex sample{20, 30};
    const Vec3 on{t.header().spacing_m[0] * sample.column, data_of(t).height_m(sample),
                  t.header().spacing_m[1] * sample.row};
    REQUIRE(cast_ray(t, on, {0.3, -1, 0.2}, infinity).distance_m <= 0x1p-20 * std::abs(on.y));
}
