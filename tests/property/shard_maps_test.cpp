// Horizons and splat maps in shards, which look far beyond one: the bytes of one bake.
#include <catch2/catch.hpp>

#include <string>

#include "baker/shard/shard_maps.h"
#include "support/rounds.h"
#include "support/shard_scene.h"
#include "support/splat_rules.h"

using namespace fjell;
using namespace fjell::test;

namespace {

void require_same(const Job& job, int shards, Random& random, bool kill) {
    INFO(shards << " shards");
    const baker::ShardPlan plan = job.plan(shards, "plan" + std::to_string(shards));
    run_all(job, plan, random, kill);
    REQUIRE((job.merged(plan) == job.whole));
}

} // namespace

TEST_CASE("horizons and splat maps of shards are those of one bake, byte for byte, however many there are") {
    Random random(51);
    const RulesFile rules;
    baker::BakeOptions options;
    options.tile_log2 = 6;
    options.horizon_spacing = 4;
    options.layers_path = rules.path();
    options.splat_spacing = 4;
    const Job job(terrain(random, 900, 620, false), options);
    for (const int shards : first_of(1, {3, 7, 1, 2, 16})) require_same(job, shards, random, shards == 3);
}

TEST_CASE("horizons and splat maps of any spacing over holes and filled voids are the same in shards") {
    Random random(52);
    const RulesFile rules;
    for (int round = 0; round < rounds(1, 6); ++round) {
        baker::BakeOptions options;
        options.tile_log2 = pick(random, 6, 8);
        options.max_texture_log2 = static_cast<std::uint32_t>(pick(random, 5, 10));
        if (round % 3 != 1) options.horizon_spacing = pick(random, 0, 1) ? 2 : 4;
        if (round % 3 != 2) options.layers_path = rules.path();
        options.splat_spacing = 1 << pick(random, 0, 2);
        const Job job(terrain(random, pick(random, 520, 800), pick(random, 300, 700), round % 2 == 0), options);
        require_same(job, pick(random, 2, 9), random, true);
    }
}

TEST_CASE("a terrain that is narrow or small has levels for horizons in shards too") {
    Random random(53);
    for (const auto& [columns, rows] : first_of(2, {std::pair(1500, 20), std::pair(66, 1100), std::pair(258, 258)})) {
        INFO(columns << " x " << rows);
        baker::BakeOptions options;
        options.tile_log2 = 6;
        options.horizon_spacing = 4;
        require_same(Job(terrain(random, columns, rows, columns == 66), options), 4, random, false);
    }
}

TEST_CASE("whichever level for horizons shards read whole, down to the eighth, the bytes are those of one bake") {
    Random random(54);
    baker::BakeOptions options;
    options.tile_log2 = 6;
    options.horizon_spacing = 4;
    Job job(terrain(random, 4200, 130, true), options);
    const baker::HorizonLevels levels(4200, 130, job.source.spacing_m);
    for (const int last : first_of(1, {8, 6})) {
        job.options.whole_level_vertices = levels.extents(last).area();
        CHECK(baker::levels_of_shards(levels, job.options.whole_level_vertices) == last);
        INFO("the level " << last);
        const baker::ShardPlan plan = job.plan(6, "plan" + std::to_string(last));
        run_all(job, plan, random, last == 8);
        REQUIRE((job.merged(plan) == job.whole));
    }
}

TEST_CASE("wetness of a terrain whose cells are wider than a shard's least region is that of one bake") {
    // More than 1,024 cells of 256 samples along a side; a region is 256 cells wide.
    const std::int32_t columns = 262'145, rows = 6;
    Random random(55);
    baker::Dem dem;
    dem.columns = columns, dem.rows = rows;
    for (std::int32_t i = 0; i < columns * rows; ++i)
        dem.heights_m.push_back(static_cast<float>(pick(random, 0, 40)) + static_cast<float>(i % columns % 5000));
    const RulesFile rules(
        R"({"rules": [{"layer": "grass"}, {"layer": "mud", "wetness": [6, null], "wetness_soft": 2}]})");
    baker::BakeOptions options;
    options.tile_log2 = 6;
    options.max_texture_log2 = 2;
    options.layers_path = rules.path();
    options.splat_spacing = 4;
    const Job job(std::move(dem), options);
    require_same(job, 3, random, false);
}
