// Shards against one bake: the same bytes, whatever their number and order, and whoever dies.
#include <catch2/catch.hpp>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include <sys/resource.h>

#include "support/rounds.h"
#include "support/shard_scene.h"

using namespace fjell;
using namespace fjell::test;
namespace fs = std::filesystem;

TEST_CASE("every cut covers each region once, and its largest shard is hardly larger than it must be") {
    Random random(3);
    for (int round = 0; round < 300; ++round) {
        const std::int32_t across = pick(random, 1, 60), down = pick(random, 1, 60);
        const int shards = pick(random, 1, 120);
        const auto parts = baker::cut_into_shards(across, down, shards);
        REQUIRE(parts.size() == static_cast<std::size_t>(shards));
        std::vector<int> covered(static_cast<std::size_t>(across) * static_cast<std::size_t>(down));
        std::size_t largest = 0;
        for (const baker::Window& p : parts) {
            largest = std::max(largest, p.area());
            for (std::int32_t y = p.y; y < p.y + p.rows; ++y)
                for (std::int32_t x = p.x; x < p.x + p.columns; ++x)
                    ++covered.at(static_cast<std::size_t>(y * across + x));
        }
        REQUIRE(std::all_of(covered.begin(), covered.end(), [](int n) { return n == 1; }));
        const double share = static_cast<double>(covered.size()) / shards;
        if (share >= 30) CHECK(static_cast<double>(largest) <= 1.35 * share);
    }
}

TEST_CASE("shards make the pack of one bake, byte for byte, however many they are, in any order, killed and repeated") {
    Random random(21);
    baker::BakeOptions options;
    options.tile_log2 = 6;
    options.order = PageOrder::hierarchical_z;
    const Job job(terrain(random, 900, 620, false), options);
    for (const int shards : {1, 2, 3, 7, 16}) {
        INFO(shards << " shards");
        const baker::ShardPlan plan = job.plan(shards, "plan" + std::to_string(shards));
        run_all(job, plan, random, shards == 3);
        CHECK((job.merged(plan) == job.whole));
        CHECK(fs::is_empty(plan.folder + "/scratch"));
    }
}

TEST_CASE("holes and filled voids, several rounds of steps and mips, are the same in shards") {
    Random random(22);
    for (int round = 0; round < rounds(1, 12); ++round) {
        baker::BakeOptions options;
        options.tile_log2 = round == 0 ? 7 : pick(random, 6, 9);
        options.estimate = round % 2 ? ErrorEstimate::midpoint : ErrorEstimate::max;
        options.max_texture_log2 = static_cast<std::uint32_t>(pick(random, 4, 10));
        const Job job(terrain(random, pick(random, 520, 800), pick(random, 300, 700), round % 4 != 3), options);
        const baker::ShardPlan plan = job.plan(pick(random, 2, 9), "plan");
        run_all(job, plan, random, true);
        CHECK((job.merged(plan) == job.whole));
    }
}

TEST_CASE("a merge of more files of chunks than it may open makes the pack of one bake") {
    Random random(24);
    baker::BakeOptions options;
    options.tile_log2 = 7;
    const Job job(terrain(random, 1250, 1200, false), options);
    const baker::ShardPlan plan = job.plan(25, "plan"); // two files each
    run_all(job, plan, random, false);
    const auto open_files =
        static_cast<rlim_t>(std::distance(fs::directory_iterator("/proc/self/fd"), fs::directory_iterator()));
    rlimit limit{};
    REQUIRE(getrlimit(RLIMIT_NOFILE, &limit) == 0);
    const rlim_t before = limit.rlim_cur;
    limit.rlim_cur = open_files + 44;
    REQUIRE(setrlimit(RLIMIT_NOFILE, &limit) == 0);
    std::vector<std::byte> merged;
    const std::string failure = failure_of([&] { merged = job.merged(plan); });
    limit.rlim_cur = before;
    REQUIRE(setrlimit(RLIMIT_NOFILE, &limit) == 0);
    CHECK(failure == "");
    CHECK((merged == job.whole));
}

TEST_CASE(
    "what is missing, cut off, damaged or of another plan is said with the command to run, and is all that runs") {
    Random random(23);
    baker::BakeOptions options;
    options.tile_log2 = 6;
    const Job job(terrain(random, 520, 300, false), options);
    const baker::ShardPlan plan = job.plan(4, "plan"), other = job.plan(3, "other");
    const auto merge = [&] { (void)job.merged(plan); };
    CHECK_THAT(failure_of(merge), Catch::Contains("run fjell-bake shard " + plan.folder + " 1/4 --step read"));
    run_all(job, plan, random, false);
    const baker::ShardStep step{baker::ShardStep::Kind::errors, 0};

    const std::string chunks = plan.file(step, 2, "chunks");
    fs::resize_file(chunks, fs::file_size(chunks) - 1);
    CHECK_THAT(failure_of(merge), Catch::Contains("run fjell-bake shard " + plan.folder + " 2/4 --step step1"));
    baker::run_shard_step(plan, job.source, job.options, 2, step);
    for (const char* name : {"chunks", "index", "places", "facts", "south"}) {
        INFO(name);
        const std::string path = plan.file(step, 3, name);
        {
            std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
            file.seekg(static_cast<std::streamoff>(fs::file_size(path) / 2));
            const int byte = file.peek();
            file.seekp(static_cast<std::streamoff>(fs::file_size(path) / 2));
            file.put(static_cast<char>(byte ^ 0x40));
        }
        CHECK_THAT(failure_of(merge), Catch::Contains(path + ": is damaged; run fjell-bake shard") &&
                                          Catch::Contains("3/4 --step step1 --again"));
        baker::run_shard_step(plan, job.source, job.options, 3, step, true);
    }
    // A record that cannot be read is none.
    const std::string record = plan.file(step, 4, "json"), text = slurp(record);
    const std::size_t digest = text.find("digest") + 20;
    for (const std::string& damaged :
         {std::string("no JSON"), std::string("[]"), text.substr(0, digest) + "x" + text.substr(digest + 1)}) {
        INFO(damaged);
        spit(record, damaged);
        CHECK_THAT(failure_of(merge), Catch::Contains("run fjell-bake shard " + plan.folder + " 4/4 --step step1"));
        baker::run_shard_step(plan, job.source, job.options, 4, step);
    }
    CHECK((job.merged(plan) == job.whole));

    const baker::ShardStep read{baker::ShardStep::Kind::read};
    baker::run_shard_step(other, job.source, job.options, 1, read);
    fs::copy_file(other.file(read, 1, "json"), plan.file(read, 1, "json"), fs::copy_options::overwrite_existing);
    CHECK_THAT(failure_of(merge), Catch::Contains("is of another plan"));
    CHECK_THAT(failure_of([&] { (void)job.plan(5, "plan"); }), Catch::Contains("holds another plan"));
    CHECK_THAT(failure_of([&] { (void)baker::load_plan(job.folder / "gone"); }),
               Catch::Contains("is not mounted here"));
}
