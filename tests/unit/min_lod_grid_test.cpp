// The least mips that tiles are drawn with: what the renderer interpolates.
#include <algorithm>
#include <random>
#include <vector>

#include <catch2/catch.hpp>

#include "fjell/stream.h"

using namespace fjell;

namespace {

struct Tiles {
    std::uint32_t wide, high;
    std::vector<TileMap> maps;

    Tiles(std::uint32_t w, std::uint32_t h, unsigned seed) : wide(w), high(h), maps(std::size_t{w} * h) {
        std::mt19937 random(seed);
        for (TileMap& map : maps) map.min_lod = static_cast<float>(random() % 1024) / 128;
    }
    // As the shader does. x, y: 0 to 1 over the tile.
    [[nodiscard]] float at(std::uint32_t tile, float x, float y) const {
        float mip[9];
        (void)min_lod_grid(maps, wide, tile, mip);
        const int i = std::min(static_cast<int>(2 * x), 1), j = std::min(static_cast<int>(2 * y), 1);
        const float u = 2 * x - static_cast<float>(i), v = 2 * y - static_cast<float>(j);
        const float* const m = mip + 3 * j + i;
        const float north = m[0] + (m[1] - m[0]) * u, south = m[3] + (m[4] - m[3]) * u;
        return north + (south - north) * v;
    }
};

} // namespace

TEST_CASE("the least mip is continuous across every border and never below the tile's own") {
    for (const auto& [wide, high] : {std::pair{5u, 4u}, {1u, 6u}, {7u, 1u}, {1u, 1u}, {2u, 2u}}) {
        const Tiles tiles(wide, high, wide * 16 + high);
        for (std::uint32_t tile = 0; tile < wide * high; ++tile) {
            const std::uint32_t column = tile % wide, row = tile / wide;
            for (int step = 0; step <= 64; ++step) {
                const float t = static_cast<float>(step) / 64;
                // Both sides interpolate the same two numbers with the same weight, and 0 and 1 are exact: equal.
                if (column + 1 < wide) CHECK(tiles.at(tile, 1, t) == tiles.at(tile + 1, 0, t));
                if (row + 1 < high) CHECK(tiles.at(tile, t, 1) == tiles.at(tile + wide, t, 0));
                for (int other = 0; other <= 64; ++other)
                    // Each of the three blends rounds by an ulp of at most 8.
                    if (tiles.at(tile, t, static_cast<float>(other) / 64) < tiles.maps[tile].min_lod - 3e-6f)
                        FAIL("tile " << tile << " at " << step << ", " << other);
            }
        }
    }
}

TEST_CASE("the least mip at a place is the largest of the tiles that share it, and of no other") {
    const Tiles tiles(3, 3, 9);
    float mip[9];
    (void)min_lod_grid(tiles.maps, 3, 4, mip);
    const auto min_lod = [&](std::initializer_list<std::size_t> of) {
        float most = 0;
        for (const std::size_t tile : of) most = std::max(most, tiles.maps[tile].min_lod);
        return most;
    };
    const float expected[9] = {min_lod({0, 1, 3, 4}), min_lod({1, 4}), min_lod({1, 2, 4, 5}),
                               min_lod({3, 4}),       min_lod({4}),    min_lod({4, 5}),
                               min_lod({3, 4, 6, 7}), min_lod({4, 7}), min_lod({4, 5, 7, 8})};
    for (int i = 0; i < 9; ++i) CHECK(mip[i] == expected[i]);
    (void)min_lod_grid(tiles.maps, 3, 0, mip); // the terrain's corner: nothing beyond the rim
    CHECK(mip[0] == min_lod({0}));
    CHECK(mip[2] == min_lod({0, 1}));
    CHECK(mip[8] == min_lod({0, 1, 3, 4}));
}

TEST_CASE("tiles that all have the same min_lod are drawn with it everywhere") {
    Tiles tiles(4, 3, 1);
    for (TileMap& map : tiles.maps) map.min_lod = 2.625f;
    for (std::uint32_t tile = 0; tile < 12; ++tile)
        for (const float x : {0.0f, 0.3f, 0.5f, 0.9f, 1.0f}) CHECK(tiles.at(tile, x, 1 - x) == 2.625f);
}
