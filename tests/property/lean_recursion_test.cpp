// The yardstick is only one when it does what it is compared with: the same triangles, in one strip.
#include <catch2/catch.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "bench/lean_recursion.h"
#include "support/cut_scene.h"
#include "support/rounds.h"
#include "view/wanted.h"

using namespace fjell;
using namespace fjell::test;

namespace {

// As triangles_of() does: every triangle with an area, with its winding, the smallest sample first; sorted.
std::vector<Triangle> triangles_of(const bench::LeanRecursion& lean, const Terrain& terrain) {
    const auto strip = lean.strip();
    const auto coord = [&](std::size_t i) {
        const bench::LeanVertex& v = lean.vertex(strip[i]);
        return SampleIndex{static_cast<std::int32_t>(std::lround(v.x_m / terrain.header().spacing_m[0])),
                           static_cast<std::int32_t>(std::lround(v.z_m / terrain.header().spacing_m[1]))};
    };
    std::vector<Triangle> triangles;
    for (std::size_t i = 2; i < strip.size(); ++i) {
        if (strip[i] == strip[i - 1] || strip[i] == strip[i - 2] || strip[i - 1] == strip[i - 2]) continue;
        Triangle t{coord(i - 2), coord(i - 1), coord(i)};
        if (i % 2) std::swap(t[0], t[1]);
        std::rotate(t.begin(),
                    std::min_element(t.begin(), t.end(),
                                     [](SampleIndex a, SampleIndex b) {
                                         return std::pair(a.row, a.column) < std::pair(b.row, b.column);
                                     }),
                    t.end());
        triangles.push_back(t);
    }
    return triangles;
}

bool every_tile_is_split(const Terrain& terrain, const View& view, double error_px) {
    const TerrainData& data = data_of(terrain);
    const Reach reach = make_reach(view, error_px);
    const std::int32_t side = data.tree.side();
    for (std::int32_t y = side / 2; y < data.tree.rows(); y += side)
        for (std::int32_t x = side / 2; x < data.tree.columns(); x += side) {
            const TerrainData::Vertex v = data.vertex({x, y});
            if (!wanted(reach, terrain.x_m(x), v.height_m, terrain.z_m(y), v.error_m, v.radius_m)) return false;
        }
    return true;
}

} // namespace

TEST_CASE("the lean recursion draws the recursive method's triangles in one strip") {
    Random random(501);
    int compared = 0;
    for (int round = 0; round < rounds(12, 100); ++round) {
        const int log2 = pick(random, 5, 8), tile_log2 = pick(random, 3, log2);
        const std::int32_t samples = (1 << log2) + 1;
        const auto pack = bake_and_load(random_dem(random, samples, samples, Shape::fractal), small_bake(tile_log2));
        const Terrain& terrain = pack.terrain;
        bench::LeanRecursion lean(terrain, std::size_t{1} << 20);
        for (int i = 0; i < 4; ++i) {
            const View view = random_view(random, terrain);
            const double error_px = random_threshold(random);
            const auto frame = lean.refine(view, error_px, false);
            REQUIRE(frame.whole);
            const auto triangles = triangles_of(lean, terrain);
            CHECK(triangles.size() == frame.triangles);
            if (!every_tile_is_split(terrain, view, error_px)) continue;
            ++compared;
            CAPTURE(round, i, log2, tile_log2, error_px);
            auto expected = recursive_triangles(terrain, view, error_px), sorted = triangles;
            const auto before = [](const Triangle& a, const Triangle& b) {
                const auto key = [](const Triangle& t) {
                    return std::array{t[0].row, t[0].column, t[1].row, t[1].column, t[2].row, t[2].column};
                };
                return key(a) < key(b);
            };
            std::sort(expected.begin(), expected.end(), before);
            std::sort(sorted.begin(), sorted.end(), before);
            REQUIRE((sorted == expected));
            // Culled: fewer, and all that is left is inside the same strip's rules.
            const auto culled = lean.refine(view, error_px, true);
            CHECK(culled.triangles <= frame.triangles);
            CHECK(triangles_of(lean, terrain).size() == culled.triangles);
        }
    }
    CHECK(compared > rounds(5, 50));
}
