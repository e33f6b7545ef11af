// All heights of a pack, read from its file: those of the terrain, to the last bit, in every step.
#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>

#include "fjell/io/failure.h"
#include "fjell/io/heights.h"
#include "shared/terrain_data.h"
#include "support/program.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::test;

namespace {

std::size_t differences(const Terrain& whole, const io::FullHeights& grid) {
    std::size_t wrong = 0;
    for (std::int32_t y = 0; y < grid.rows; ++y)
        for (std::int32_t x = 0; x < grid.columns; ++x) {
            const SampleIndex at{x << grid.step_log2, y << grid.step_log2};
            const float is = grid.heights_m[static_cast<std::size_t>(y * grid.columns + x)];
            if (data_of(whole).is_hole(data_of(whole).tree.sample(at)))
                wrong += !std::isnan(is);
            else
                wrong += is != data_of(whole).height_m(data_of(whole).tree.sample(at));
        }
    return wrong;
}

} // namespace

TEST_CASE("the heights read from a pack are those of its terrain, whatever its order, holes and extents") {
    Random random(71);
    int with_holes = 0;
    for (int round = 0; round < 30; ++round) {
        const int log2 = pick(random, 1, 8);
        const bool large = round % 4 == 0;
        baker::Dem dem =
            random_dem(random, pick(random, 2, large ? 500 : 150), pick(random, 2, large ? 400 : 120), Shape::fractal);
        if (round % 5 < 2) add_random_holes(random, dem, log2);
        baker::BakeOptions options = small_bake(log2);
        options.order = static_cast<PageOrder>(round % 3);
        const TemporaryFolder folder;
        (void)baker::bake(dem, options, folder / "pack.fjell");
        const auto whole = io::load_pack(folder / "pack.fjell", io::LoadTerrain::yes);
        const io::PackFile file(folder / "pack.fjell");
        with_holes += whole.terrain.has_voids();
        const auto samples = static_cast<std::uint64_t>(dem.columns) * static_cast<std::uint64_t>(dem.rows);
        CAPTURE(round, log2, dem.columns, dem.rows);

        const auto all = io::read_heights(file, samples);
        REQUIRE(all);
        CHECK(all->step_log2 == 0);
        CHECK(all->columns == dem.columns);
        CHECK(all->rows == dem.rows);
        CHECK(differences(whole.terrain, *all) == 0);

        // With room for less: the least step that fits, and its last samples at the rim.
        const auto most =
            static_cast<std::uint64_t>(std::max(static_cast<double>(samples) * uniform(random, 0.01, 0.9),
                                                static_cast<double>((data_of(whole.terrain).tree.tiles_x + 1) *
                                                                    (data_of(whole.terrain).tree.tiles_y + 1))));
        const auto some = io::read_heights(whole.pack, whole.path, most);
        REQUIRE(some);
        REQUIRE(some->heights_m.size() ==
                static_cast<std::size_t>(some->columns) * static_cast<std::size_t>(some->rows));
        CHECK(some->heights_m.size() <= most);
        CHECK(differences(whole.terrain, *some) == 0);
        const std::int32_t step = 1 << some->step_log2;
        CHECK((some->columns - 1) * step >= dem.columns - 1);
        CHECK((some->columns - 2) * step < dem.columns - 1);
        CHECK((some->rows - 1) * step >= dem.rows - 1);
        CHECK((some->rows - 2) * step < dem.rows - 1);
        if (some->step_log2 > 0) {
            const auto finer = [&](std::int32_t n) { return (n - 1 + step / 2 - 1) / (step / 2) + 1; };
            CHECK(static_cast<std::uint64_t>(finer(dem.columns)) * static_cast<std::uint64_t>(finer(dem.rows)) > most);
        }
    }
    CHECK(with_holes > 5);
}

TEST_CASE("reading heights stops when it is told to, and says what is wrong with a file") {
    Random random(72);
    const TemporaryFolder folder;
    (void)baker::bake(random_dem(random, 300, 200, Shape::fractal), small_bake(7), folder / "pack.fjell");
    const io::PackFile file(folder / "pack.fjell");
    double last = 0;
    int calls = 0;
    CHECK(io::read_heights(file, 60'000, [&](double share) {
        CHECK(share > last);
        last = share;
        ++calls;
        return true;
    }));
    CHECK(last == 1);
    CHECK(calls == 6); // tiles
    CHECK_FALSE(io::read_heights(file, 60'000, [&](double) { return ++calls < 9; }));
    CHECK(calls == 9);
    CHECK_THROWS_WITH(io::read_heights(file, 3), Catch::Contains("give room for more"));

    const auto whole = io::load_pack(folder / "pack.fjell", io::LoadTerrain::no);
    std::string bytes = slurp(folder / "pack.fjell");
    const ChunkEntry e = whole.pack.entry(chunk_index(whole.pack.header, {ChunkKind::geometry, 4, 2}));
    bytes[e.offset + e.stored_bytes / 2] ^= 1;
    spit(folder / "bad.fjell", bytes);
    const io::PackFile bad(folder / "bad.fjell");
    CHECK_THROWS_WITH(io::read_heights(bad, 60'000), Catch::Contains("page 2 of tile 4: the pack is damaged"));
    CHECK(io::read_heights(bad, 30));                      // coarse pages are not
    spit(folder / "bad.fjell", bytes.substr(0, e.offset)); // the file shrinks while it is open
    CHECK_THROWS_AS(io::read_heights(bad, 60'000), io::Failure);
}
