// invariant 5, as far as it goes for the recursive method and queries: they allocate nothing.
#include <catch2/catch.hpp>

#include <bit>
#include <vector>

#include "fjell/fjell_c.h"
#include "fjell/query.h"
#include "support/count_allocations.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::test;

TEST_CASE("a frame allocates nothing, whatever the view, and also when a budget runs out") {
    if (!interposed) {
        WARN("skipped: a sanitizer has malloc to itself");
        return;
    }
    Random random(41);
    const auto pack = bake_and_load(random_dem(random, 200, 120, Shape::fractal), small_bake(5));
    Recursive ample(pack.terrain, ample_budget(pack.terrain)), tight(pack.terrain, {700, 4000});
    std::uint32_t exhausted = 0, triangles = 0;
    for (int frame = 0; frame < 500; ++frame) {
        const View view = random_view(random, pack.terrain);
        RefineSettings settings;
        settings.max_error_px = 0.5 + frame % 7;
        settings.topology = frame % 2 ? Topology::strip : Topology::triangles;
        settings.metric = frame % 3 ? Metric::isotropic : Metric::depth;
        FrameReport report;
        counting = true;
        for (const RecursiveMethod method : {ample.method, tight.method}) {
            (void)update_recursive(method, view, settings, report);
            triangles += recursive_mesh(method).tiles.empty() ? 0 : report.triangles;
        }
        counting = false;
        exhausted |= report.exhausted;
    }
    REQUIRE(allocations == 0);
    REQUIRE(triangles > 0);
    REQUIRE(exhausted != 0);
    // The count itself works: one planted allocation is seen.
    counting = true;
    void* volatile planted = std::malloc(16); // escapes, so that the pair is not removed
    counting = false;
    std::free(planted);
    REQUIRE(allocations == 1);
}

TEST_CASE("a cut that C creates, updates and reads allocates nothing") {
    if (!interposed) {
        WARN("skipped: a sanitizer has malloc to itself");
        return;
    }
    Random random(43);
    const auto pack = bake_and_load(random_dem(random, 200, 120, Shape::fractal), small_bake(5));
    const auto terrain = std::bit_cast<FjellTerrain>(pack.terrain);
    const FjellCutBudget budget = fjell_cut_budget_default();
    const std::size_t bytes = fjell_cut_bytes(terrain, &budget);
    const io::AlignedMemory memory = io::allocate(bytes);
    FjellLiveCut cut{};
    std::size_t written = 0;
    allocations = 0;
    counting = true;
    FjellStatus status = fjell_create_cut(terrain, &budget, memory.get(), bytes, &cut);
    for (int frame = 0; frame < 20 && status.code == FJELL_OK; ++frame) {
        const double x_m = frame * double{fjell_terrain_extent_x_m(terrain)} / 20;
        FjellView view = fjell_view_default();
        (void)fjell_make_view({x_m, fjell_ground_height(terrain, x_m, 0, 0).height_m + 1, 0}, {0, 0, 1}, {0, 1, 0}, 1,
                              640, 480, 0.1, 1e6, &view);
        status = fjell_update_cut(cut, &view, 1, nullptr, nullptr);
        written += fjell_cut_take_changes(cut).vertex_word_count;
        written += fjell_cut_mesh(cut).mesh.tile_count;
    }
    counting = false;
    REQUIRE(status.code == FJELL_OK);
    CHECK(allocations == 0);
    CHECK(written > 20);
}

TEST_CASE("heights, rays and patches allocate nothing, with pages or without") {
    if (!interposed) {
        WARN("skipped: a sanitizer has malloc to itself");
        return;
    }
    Random random(42);
    const auto pack = bake_and_load(random_dem(random, 200, 120, Shape::fractal), small_bake(7));
    const PagedTerrain bare(pack.pack, {});
    allocations = 0;
    double sum = 0;
    std::vector<float> heights(33 * 33);
    for (int round = 0; round < 500; ++round) {
        const Terrain& t = round % 2 ? pack.terrain : bare.terrain;
        const View view = random_view(random, pack.terrain);
        counting = true;
        sum += ground_height(t, view.eye_m.x, view.eye_m.z).height_m;
        sum += cast_ray(t, view.eye_m, view.forward, 1e9).distance_m;
        sum += ground_patch(t, {round % 90, round % 50}, 0, 33, heights).error_m;
        counting = false;
    }
    REQUIRE(allocations == 0);
    REQUIRE(sum != 0);
}
