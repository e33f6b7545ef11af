// Shards of a plan for a pack set: what the set has no use for is not baked, and the set is that of a split of one
// bake's pack all the same.
#include <catch2/catch.hpp>

#include <filesystem>
#include <string>

#include <sys/stat.h>

#include "baker/shard/shard_ground.h"
#include "fjell/io/pack_file.h"
#include "support/rounds.h"
#include "support/shard_scene.h"

using namespace fjell;
using namespace fjell::test;
namespace fs = std::filesystem;

namespace {

using Files = std::map<std::string, std::vector<std::byte>>;

struct Island {
    std::int32_t x, y, columns, rows;
};

// Ground in rectangles, with holes of their own; the rest is sea.
baker::Dem sea_with(Random& random, std::int32_t columns, std::int32_t rows, const std::vector<Island>& islands) {
    baker::Dem dem;
    dem.columns = columns, dem.rows = rows;
    dem.heights_m.assign(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), 0);
    dem.voids.assign(dem.heights_m.size(), 1);
    for (const Island& island : islands) {
        baker::Dem ground = random_dem(random, island.columns, island.rows, Shape::fractal);
        if (island.columns > 60 && island.rows > 60) add_random_holes(random, ground, 2);
        for (std::int32_t y = 0; y < island.rows; ++y)
            for (std::int32_t x = 0; x < island.columns; ++x) {
                const std::size_t at = dem.index(island.x + x, island.y + y);
                dem.heights_m[at] = ground.at(x, y);
                dem.voids[at] = ground.is_void(x, y) ? 1 : 0;
            }
    }
    return dem;
}

std::vector<Island> some_islands(Random& random, std::int32_t columns, std::int32_t rows) {
    std::vector<Island> islands;
    for (int n = pick(random, 1, 3); n > 0; --n) {
        const std::int32_t w = pick(random, 20, columns / 5), h = pick(random, 20, rows / 5);
        islands.push_back({pick(random, 0, columns - w), pick(random, 0, rows - h), w, h});
    }
    return islands;
}

Files split_of(const Job& job, const baker::SetGrid& grid) {
    (void)baker::split_pack(job.folder / "whole.fjell", job.folder / "split", grid);
    return files_in(job.folder / "split");
}

Files merged_of(const Job& job, const baker::ShardPlan& plan, const baker::SetGrid& grid) {
    const std::string folder = plan.folder + "-set";
    (void)baker::merge_shards_to_set(plan, job.source, job.options, grid, folder);
    return files_in(folder);
}

// Files of a step's shard, but for its record.
int files_of(const baker::ShardPlan& plan, const baker::ShardStep& step, int shard) {
    int files = 0;
    for (const auto& entry : fs::directory_iterator(plan.folder + "/" + step.name())) {
        const std::string name = entry.path().filename().string();
        files += name.starts_with(std::to_string(shard) + ".") && !name.ends_with(".json");
    }
    return files;
}

// Bytes that a folder takes on the disk.
std::uint64_t disk_bytes(const std::string& folder) {
    std::uint64_t bytes = 0;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
        struct stat info {};
        if (entry.is_regular_file() && stat(entry.path().c_str(), &info) == 0)
            bytes += static_cast<std::uint64_t>(info.st_blocks) * 512;
    }
    return bytes;
}

} // namespace

TEST_CASE("a plan for a set makes the set of a split of one bake, byte for byte, however many its shards are") {
    Random random(61);
    baker::BakeOptions options;
    options.tile_log2 = 6;
    const Job job(sea_with(random, 1700, 1500, {{40, 1100, 260, 300}, {1200, 130, 150, 90}, {1216, 320, 1, 1}}),
                  options);
    const baker::SetGrid grid{9, 8};
    const Files split = split_of(job, grid);
    REQUIRE(split.size() < 20);
    for (const int shards : first_of(2, {3, 7, 1, 2, 16})) {
        INFO(shards << " shards");
        const baker::ShardPlan plan = job.plan(shards, "plan" + std::to_string(shards), grid);
        run_all(job, plan, random, shards == 3);
        CHECK((merged_of(job, plan, grid) == split));
        CHECK(fs::is_empty(plan.folder + "/scratch"));
    }
}

TEST_CASE("whatever has ground, any grid of packs is the same from a plan for it as from one bake") {
    Random random(62);
    for (int round = 0; round < rounds(1, 15); ++round) {
        baker::BakeOptions options;
        options.tile_log2 = pick(random, 6, 8);
        options.estimate = round % 2 ? ErrorEstimate::midpoint : ErrorEstimate::max;
        options.order = round % 3 ? PageOrder::planar : PageOrder::hierarchical_z;
        options.max_texture_log2 = static_cast<std::uint32_t>(pick(random, 4, 10));
        if (round % 5 == 2) options.horizon_spacing = 2; // nothing is left out
        const std::int32_t columns = pick(random, 900, 1500), rows = pick(random, 600, 1300);
        const Job job(sea_with(random, columns, rows, some_islands(random, columns, rows)), options);
        const std::int32_t side = 1 << options.tile_log2;
        const baker::SetGrid grid{static_cast<std::uint32_t>(pick(random, 1, (columns - 2) / side + 1)),
                                  static_cast<std::uint32_t>(pick(random, 1, (rows - 2) / side + 1))};
        INFO("round " << round << ", " << columns << " x " << rows << " in tiles of " << side << ", " << grid.packs_x
                      << " x " << grid.packs_y << " packs");
        const baker::ShardPlan plan = job.plan(pick(random, 1, 12), "plan", grid);
        run_all(job, plan, random, true);
        CHECK((merged_of(job, plan, grid) == split_of(job, grid)));
        CHECK(baker::verify(io::PackFile(plan.folder + "-set"), &job.source).ok());
    }
}

TEST_CASE(
    "shards of nothing but sea leave no files after reading, and the folder takes less than the heights alone would") {
    Random random(63);
    baker::BakeOptions options;
    options.tile_log2 = 6;
    const baker::SetGrid grid{11, 11};
    const std::int32_t side = 11 * 3 * 64;
    const Job job(sea_with(random, side, side, {{300, 300, 200, 200}}), options);
    const baker::ShardPlan plan = job.plan(16, "plan", grid);
    run_all(job, plan, random, false);
    int idle = 0;
    for (int shard = 1; shard <= plan.shards; ++shard) {
        if (files_of(plan, {baker::ShardStep::Kind::errors, 0}, shard) != 0) continue;
        ++idle;
        for (const baker::ShardStep& step : baker::shard_steps(plan.rounds))
            CHECK(files_of(plan, step, shard) == (step.kind == baker::ShardStep::Kind::read ? 3 : 0));
    }
    CHECK(idle >= 12);
    CHECK(disk_bytes(plan.folder) < static_cast<std::uint64_t>(side) * side * sizeof(float));
    const baker::MergedSet merged = baker::merge_shards_to_set(plan, job.source, job.options, grid, job.folder / "set");
    CHECK(merged.set.packs <= 9);
    CHECK(merged.set.packs + merged.set.left_out == 121);
}

TEST_CASE(
    "a plan for a set is merged into that one alone, and a plan that is damaged or for too many packs is refused") {
    Random random(64);
    baker::BakeOptions options;
    options.tile_log2 = 6;
    const Job job(sea_with(random, 600, 500, {{40, 60, 100, 100}}), options);
    const baker::ShardPlan plan = job.plan(2, "plan", baker::SetGrid{3, 2});
    CHECK(baker::load_plan(plan.folder).packs == baker::SetGrid{3, 2});
    run_all(job, plan, random, false);
    const std::string says = "was planned for a set of 3x2 packs";
    CHECK_THAT(failure_of([&] { (void)job.merged(plan); }), Catch::Contains(says));
    CHECK_THAT(failure_of([&] {
                   (void)merged_of(job, plan, {2, 3});
               }),
               Catch::Contains(says) && Catch::Contains("give --packs 3x2"));
    CHECK(merged_of(job, plan, {3, 2}).size() == 2);
    CHECK_THAT(failure_of([&] {
                   (void)job.plan(2, "many", baker::SetGrid{11, 1});
               }),
               Catch::Contains("has 10 x 8 tiles"));
    CHECK_FALSE(fs::exists(job.folder / "many"));
}
