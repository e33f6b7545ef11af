// Shards merged straight into a pack set: the bytes of a split of one bake's pack, whoever is interrupted.
#include <catch2/catch.hpp>

#include <filesystem>
#include <set>
#include <string>

#include "fjell/io/pack_file.h"
#include "io/set_file.h"
#include "support/rounds.h"
#include "support/shard_scene.h"

using namespace fjell;
using namespace fjell::test;
namespace fs = std::filesystem;

namespace {

using Files = std::map<std::string, std::vector<std::byte>>;

Files split_of(const Job& job, const baker::SetGrid& grid, const std::string& name) {
    (void)baker::split_pack(job.folder / "whole.fjell", job.folder / name, grid);
    return files_in(job.folder / name);
}

Files merged_of(const Job& job, const baker::ShardPlan& plan, const baker::SetGrid& grid, const std::string& name) {
    (void)baker::merge_shards_to_set(plan, job.source, job.options, grid, job.folder / name);
    return files_in(job.folder / name);
}

// Without ground in its north-western corner, which is the first pack's.
baker::Dem with_a_sea(Random& random, std::int32_t columns, std::int32_t rows, std::int32_t sea) {
    baker::Dem dem = terrain(random, columns, rows, true);
    for (std::int32_t y = 0; y < sea; ++y)
        for (std::int32_t x = 0; x < sea; ++x) dem.voids[dem.index(x, y)] = 1;
    return dem;
}

// A merge that is interrupted at a call of its progress.
bool merge_until(const Job& job, const baker::ShardPlan& plan, const baker::SetGrid& grid, const std::string& name,
                 int call) {
    baker::BakeOptions options = job.options;
    options.progress = [&call](const char*, std::uint64_t, std::uint64_t) {
        if (call-- == 0) throw io::Failure(130, "interrupted");
    };
    try {
        (void)baker::merge_shards_to_set(plan, job.source, options, grid, job.folder / name);
    } catch (const io::Failure& failure) {
        CHECK(failure.exit_code == 130);
        return false;
    }
    return true;
}

} // namespace

TEST_CASE("shards merged into a set make what a split of one bake's pack makes, byte for byte, however many they are") {
    Random random(41);
    baker::BakeOptions options;
    options.tile_log2 = 6;
    const Job job(with_a_sea(random, 800, 560, 290), options);
    const baker::SetGrid grid{3, 2};
    const Files split = split_of(job, grid, "split");
    CHECK(split.count("0-0.fjell") == 0); // of sea alone
    CHECK(split.size() == 6);             // the others, and the index
    for (const int shards : {1, 2, 3, 7, 16}) {
        INFO(shards << " shards");
        const std::string name = std::to_string(shards);
        const baker::ShardPlan plan = job.plan(shards, "plan" + name);
        run_all(job, plan, random, false);
        CHECK((merged_of(job, plan, grid, "set" + name) == split));
    }
}

TEST_CASE("any grid of packs over any terrain is merged as it is split, and verify finds nothing wrong with it") {
    Random random(42);
    for (int round = 0; round < rounds(2, 12); ++round) {
        baker::BakeOptions options;
        options.tile_log2 = pick(random, 6, 8);
        options.order = round % 2 ? PageOrder::hierarchical_z : PageOrder::planar;
        const std::int32_t columns = pick(random, 300, 700), rows = pick(random, 300, 700);
        const Job job(terrain(random, columns, rows, round % 2 == 0), options);
        const baker::ShardPlan plan = job.plan(pick(random, 1, 9), "plan");
        run_all(job, plan, random, true);
        const std::int32_t side = 1 << options.tile_log2;
        const auto parts = [&](std::int32_t samples) {
            return static_cast<std::uint32_t>(pick(random, 1, (samples - 2) / side + 1));
        };
        const baker::SetGrid grid{parts(columns), parts(rows)};
        CHECK((merged_of(job, plan, grid, "set") == split_of(job, grid, "split")));
        CHECK(baker::verify(io::PackFile(job.folder / "set"), &job.source).ok());
    }
}

TEST_CASE("a terrain of islands, more than 65,537 samples wide, is merged into a set that has packs of islands alone") {
    if (!full_rounds()) {
        WARN("skipped: six million samples (FJELL_TEST_ROUNDS=full merges them; huge_set_test opens larger sets)");
        return;
    }
    Random random(45);
    constexpr std::int32_t columns = 66'050, rows = 90, pack = 1'016; // samples of each of 65, or 1,080
    const std::set<std::int32_t> islands{0, 17, 18, 40, 64};
    baker::Dem dem;
    dem.columns = columns, dem.rows = rows;
    dem.heights_m.assign(std::size_t{columns} * rows, 0);
    dem.voids.assign(dem.heights_m.size(), 1);
    for (const std::int32_t at : islands) {
        const std::int32_t x0 = at * pack + 100;
        const baker::Dem island = random_dem(random, 300, 60, Shape::fractal);
        for (std::int32_t y = 0; y < island.rows; ++y)
            for (std::int32_t x = 0; x < island.columns; ++x) {
                dem.heights_m[dem.index(x0 + x, 10 + y)] = island.at(x, y);
                dem.voids[dem.index(x0 + x, 10 + y)] = 0;
            }
    }
    baker::BakeOptions options;
    options.tile_log2 = 6;
    const Job job(std::move(dem), options);
    const baker::ShardPlan plan = job.plan(5, "plan");
    run_all(job, plan, random, false);
    const baker::SetGrid grid{65, 1};
    const baker::MergedSet merged = baker::merge_shards_to_set(plan, job.source, job.options, grid, job.folder / "set");
    CHECK(merged.set.packs == islands.size());
    CHECK(merged.set.left_out == 65 - islands.size());
    CHECK((files_in(job.folder / "set") == split_of(job, grid, "split")));
    const io::PackFile set(job.folder / "set");
    CHECK(set.pack().header.columns == columns);
    CHECK(set.pack().header.tiles_held < 2 * 17 * islands.size());
    CHECK(baker::verify(set, &job.source).ok());
}

TEST_CASE("a merge into a set that is interrupted leaves no set, or the old one whole, and the next one is as any") {
    Random random(43);
    baker::BakeOptions options;
    options.tile_log2 = 6;
    const Job job(terrain(random, 520, 400, true), options);
    const baker::ShardPlan plan = job.plan(3, "plan");
    run_all(job, plan, random, false);
    const baker::SetGrid grid{2, 2}, other{4, 1};
    const Files split = split_of(job, grid, "split"), old = split_of(job, other, "old");
    int call = 0;
    for (bool complete = false; !complete; call += rounds(13, 3)) {
        complete = merge_until(job, plan, grid, "new", call);
        if (!complete) CHECK(files_in(job.folder / "new").empty());
        if (!merge_until(job, plan, grid, "old", call)) CHECK((files_in(job.folder / "old") == old));
    }
    CHECK(call > 7);
    CHECK((files_in(job.folder / "new") == split));
    CHECK((files_in(job.folder / "old") == split)); // packs of the old set are gone
}

TEST_CASE("packs of an older, finer set go with it, whoever was killed before, and files of others stay") {
    Random random(46);
    baker::BakeOptions options;
    options.tile_log2 = 6;
    const Job job(terrain(random, 520, 400, true), options);
    const Files coarse = split_of(job, {2, 1}, "coarse");
    const auto folder_of = [&](const char* name) {
        (void)split_of(job, {4, 3}, name);
        spit(job.folder / name + "/notes.txt", "mine");
        spit(job.folder / name + "/9-9.fjell", "mine too"); // named as packs are, but in no index
        return job.folder / name;
    };
    Files expected = coarse;
    expected["notes.txt"] = io::read_file(folder_of("first") + "/notes.txt");
    expected["9-9.fjell"] = io::read_file(job.folder / "first/9-9.fjell");
    CHECK((split_of(job, {2, 1}, "first") == expected));

    // What publish() leaves when it is killed at each of its steps: the list before the old index goes; no index, with
    // some packs of the new set; the new index beside packs of the old one.
    const std::string folder = folder_of("killed"), index = folder + "/set.json", list = folder + "/set.old";
    io::SetFile old = io::parse_set_file(io::read_text(index), index);
    std::erase_if(old.packs, [](const io::SetFilePack& pack) { return pack.file == "0-0.fjell"; });
    for (io::SetFilePack& pack : old.packs) pack.tile_x = pack.tile_y = 0;
    const std::string text = io::set_file_text(old);
    spit(list, text);
    CHECK(io::PackFile(folder).packs() == 12);
    fs::remove(index);
    CHECK((split_of(job, {2, 1}, "killed") == expected));
    for (const io::SetFilePack& pack : old.packs)
        if (!fs::exists(folder + "/" + pack.file)) spit(folder + "/" + pack.file, "old");
    spit(list, text);
    CHECK(io::PackFile(folder).packs() == 2);
    CHECK((split_of(job, {2, 1}, "killed") == expected));
    spit(list, "{"); // no list: it names nothing
    CHECK((split_of(job, {2, 1}, "killed") == expected));
}

TEST_CASE(
    "what lies between: without its index a folder of packs is no set, with a pack of another one it is refused") {
    Random random(44);
    baker::BakeOptions options;
    options.tile_log2 = 6;
    const Job job(terrain(random, 400, 300, false), options);
    const baker::ShardPlan plan = job.plan(2, "plan");
    run_all(job, plan, random, false);
    const std::string set = job.folder / "set";
    const Files whole = merged_of(job, plan, {2, 2}, "set");
    const auto refusal = [&] { return failure_of([&] { (void)io::PackFile(set); }); };
    // Where write_set() may be killed: its index is gone, and some packs are new.
    fs::remove(set + "/set.json");
    CHECK_THAT(refusal(), Catch::Contains(set + ": is a folder without a set.json"));
    CHECK((merged_of(job, plan, {2, 2}, "set") == whole));
    fs::resize_file(set + "/1-0.fjell", fs::file_size(set + "/1-0.fjell") - 1);
    CHECK_THAT(refusal(), Catch::Contains("1-0.fjell"));
    CHECK((merged_of(job, plan, {2, 2}, "set") == whole));
    CHECK_THAT(failure_of([&] {
                   (void)merged_of(job, plan, {8, 1}, "many");
               }),
               Catch::Contains("has 7 x 5 tiles, which cannot be split into 8 x 1 packs"));
    CHECK_FALSE(fs::exists(job.folder / "many"));
    const std::string holes = plan.file({baker::ShardStep::Kind::errors, 0}, 2, "chunks");
    fs::resize_file(holes, fs::file_size(holes) - 1);
    CHECK_THAT(failure_of([&] { (void)merged_of(job, plan, {2, 2}, "set"); }), Catch::Contains("2/2 --step step1"));
    CHECK((files_in(set) == whole));
}
