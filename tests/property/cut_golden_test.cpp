// The golden flight against its constants; other compilers and optimisations are held to them by cut_golden.cmake.
#include <catch2/catch.hpp>

#include "cut_golden.h"
#include "support/cut_scene.h"

#include <cstdlib>

using namespace fjell;
using namespace fjell::test;

namespace {

// When the method itself is changed on purpose these change too: take the new ones from what this test prints, but only
// when cut_golden_compilers passes.
// Of the terrain's records: changes with the baker's errors, radii and heights, and then the others do as well.
constexpr std::uint64_t terrain_hash = 0xa76c839edf1dc46d;
constexpr std::uint64_t triangles_hash = 0x8837f889fad603da;
// Of the counts in the reports: changes also with the order of work.
constexpr std::uint64_t work_hash = 0x6439e82c367bf889;

} // namespace

TEST_CASE("the golden flight comes to the same triangles and the same work as ever", "[golden]") {
    baker::Dem dem;
    dem.columns = golden_columns;
    dem.rows = golden_rows;
    dem.spacing_m[0] = dem.spacing_m[1] = 10;
    dem.heights_m = golden_heights();
    const TemporaryFolder folder;
    // For cut_golden.cmake the pack goes where that looks for it.
    const char* const kept = std::getenv("FJELL_GOLDEN_PACK");
    const std::string path = kept != nullptr ? kept : folder / "golden.fjell";
    (void)baker::bake(std::move(dem), small_bake(golden_tile_log2), path);
    const io::LoadedPack pack = io::load_pack(path, io::LoadTerrain::yes);
    CHECK(golden_terrain_hash(pack.terrain) == terrain_hash);
    const std::size_t bytes = cut_bytes(pack.terrain, golden_budget(pack.terrain));
    for (const bool scalar : {false, true}) {
        const auto memory = io::allocate(bytes);
        const Golden golden = fly_golden(pack.terrain, {memory.get(), bytes}, scalar);
        REQUIRE(golden.ok);
        CAPTURE(scalar);
        CHECK(golden.triangles == triangles_hash);
        CHECK(golden.work == work_hash);
        CHECK(golden.exhausted == (cut_budget_work | cut_budget_vertices)); // the flight has it all
    }
}
