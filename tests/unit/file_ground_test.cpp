// Heights for camera paths from a pack that stays in its file.
#include <catch2/catch.hpp>

#include "session/file_ground.h"
#include "shared/terrain_data.h"
#include "support/program.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::test;

TEST_CASE("the ground of a pack in its file is that of the pack loaded whole, to the last bit") {
    Random random(61);
    for (int round = 0; round < 12; ++round) {
        const int log2 = pick(random, 1, 8);
        baker::Dem dem = random_dem(random, pick(random, 2, 400), pick(random, 2, 400), Shape::fractal);
        if (round % 3 == 0) add_random_holes(random, dem, log2);
        baker::BakeOptions options = small_bake(log2);
        options.order = static_cast<PageOrder>(round % 3);
        const TemporaryFolder folder;
        (void)baker::bake(dem, options, folder / "pack.fjell");
        const auto whole = io::load_pack(folder / "pack.fjell", io::LoadTerrain::yes);
        const io::PackFile file(folder / "pack.fjell");
        session::FileGround ground(file);
        const double width = whole.terrain.x_m(dem.columns - 1), depth = whole.terrain.z_m(dem.rows - 1);
        std::size_t wrong = 0;
        for (int n = 0; n < 2000; ++n) {
            const double x = uniform(random, -0.1, 1.1) * width, z = uniform(random, -0.1, 1.1) * depth;
            wrong += ground.ground_m(x, z) != data_of(whole.terrain).ground_m(x, z);
        }
        for (const SampleIndex corner :
             {SampleIndex{0, 0}, {dem.columns - 1, 0}, {0, dem.rows - 1}, {dem.columns - 1, dem.rows - 1}})
            wrong += ground.ground_m(whole.terrain.x_m(corner.column), whole.terrain.z_m(corner.row)) !=
                     data_of(whole.terrain).ground_m(whole.terrain.x_m(corner.column), whole.terrain.z_m(corner.row));
        CAPTURE(round, log2, dem.columns, dem.rows);
        REQUIRE(wrong == 0);
    }
}

TEST_CASE("where pages are damaged, the ground is a coarser sample's") {
    Random random(62);
    const TemporaryFolder folder;
    (void)baker::bake(random_dem(random, 300, 200, Shape::fractal), small_bake(7), folder / "pack.fjell");
    const auto whole = io::load_pack(folder / "pack.fjell", io::LoadTerrain::yes);
    std::string bytes = slurp(folder / "pack.fjell");
    const Terrain& t = whole.terrain;
    for (std::uint32_t tile = 0; tile < t.tile_count(); ++tile)
        for (std::uint32_t page = tile % 3; page < t.pages_per_tile(); ++page) { // of some tiles all pages
            const ChunkEntry e = whole.pack.entry(chunk_index(t.header(), {ChunkKind::geometry, tile, page}));
            bytes[e.offset + e.stored_bytes / 2] ^= 1;
        }
    spit(folder / "bad.fjell", bytes);
    const io::PackFile file(folder / "bad.fjell");
    session::FileGround ground(file);
    for (int n = 0; n < 3000; ++n) {
        const double x = uniform(random, 0, 1) * t.x_m(299), z = uniform(random, 0, 1) * t.z_m(199);
        const double height = ground.ground_m(x, z);
        REQUIRE(height >= static_cast<double>(t.header().min_m));
        REQUIRE(height <= static_cast<double>(t.header().max_m));
    }
    // At a tile's corner it is the corner's, which does not lie in pages.
    CHECK(ground.ground_m(128 * t.header().spacing_m[0], 128 * t.header().spacing_m[1]) ==
          static_cast<double>(data_of(t).height_m({128, 128})));
}
