// The key of the guide's game (content/hosts/game): a crater where the camera looks, at its depth, and from the same
// update on for rays too.
#include <catch2/catch.hpp>

#include "fjell/edit.h"
#include "fjell/query.h"
#include "hosts/game/walk.h"
#include "support/ground.h"
#include "support/stream_scene.h"

using namespace fjell;
using namespace fjell::test;

TEST_CASE("the guide's game digs where its camera looks") {
    TemporaryFolder folder;
    Random random(9);
    (void)baker::bake(random_dem(random, 257, 257, Shape::fractal), small_bake(7), folder / "pack.fjell");
    const io::LoadedPack pack = io::load_pack(folder / "pack.fjell", io::LoadTerrain::yes);
    const Terrain& terrain = pack.terrain;
    const std::size_t bytes = edits_bytes(terrain.header());
    const io::AlignedMemory memory = io::allocate(bytes);
    Edits edits;
    REQUIRE(create_edits(terrain, {}, {memory.get(), bytes}, edits).ok());

    const View walker = game::walker(terrain, terrain.extent_x_m() / 2, terrain.extent_z_m() / 2, {0.6, -0.8, 0});
    const std::optional<Stamp> crater = game::crater_ahead(terrain, walker, 1e5);
    REQUIRE(crater);
    const double before_m = game::sight_m(terrain, walker, 1e5);
    const Vec3 hit_m = walker.eye_m + Vec3{before_m * walker.forward.x, 0, before_m * walker.forward.z};
    CHECK(crater->x_m == Approx(hit_m.x));
    CHECK(crater->z_m == Approx(hit_m.z));
    const double height_m = static_cast<double>(ground_height(terrain, crater->x_m, crater->z_m).height_m);

    StampId id = 0;
    REQUIRE(push_stamp(edits, *crater, id).ok());
    EditReport report;
    REQUIRE(update_edits(edits, {&walker, 1}, {.max_time_us = 500}, report).ok());
    INFO(stamp_state(edits, id).status.field);
    REQUIRE(stamp_state(edits, id).state == StampState::applied);
    const double deep_m = height_m - static_cast<double>(ground_height(terrain, crater->x_m, crater->z_m).height_m);
    // The bowl of samples around the middle: a cell's diagonal away it is shallower by less than a fifth.
    CHECK(deep_m > 0.8 * static_cast<double>(crater->amount_m));
    CHECK(deep_m < 1.01 * static_cast<double>(crater->amount_m));
    CHECK(game::sight_m(terrain, walker, 1e5) > before_m);

    const View up = game::walker(terrain, terrain.extent_x_m() / 2, terrain.extent_z_m() / 2, {0, 1, 0.001});
    CHECK_FALSE(game::crater_ahead(terrain, up, 1e5));
    (void)destroy_edits(edits);
}
