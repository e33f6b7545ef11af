// Shards against one bake: the same bytes, whatever their number and order, and whoever dies.
#include <catch2/catch.hpp>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

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

TEST_CASE("two processes at one step of one shard at the same time both complete it, many times") {
    const TemporaryFolder dir;
    baker::ShardPlan plan;
    plan.folder = dir / "plan";
    plan.id = 7;
    plan.shards = 2;
    const baker::ShardStep step{baker::ShardStep::Kind::means};
    const std::vector<std::byte> bytes(100, std::byte{5});
    const auto attempt = [&] {
        baker::ScratchFolder scratch(plan, step, 1);
        scratch.write_parcel("frame", bytes);
        scratch.publish({});
    };
    fs::create_directory(plan.folder);
    std::ofstream(plan.folder + "/plan.json"); // of which a turn is taken
    attempt();                                 // so that all folders are there
    const int times = rounds(2000, 20000);
    const pid_t other = fork();
    const auto repeat = [&] {
        try {
            for (int i = 0; i < times; ++i) attempt();
        } catch (const std::exception& failure) {
            return std::string(failure.what());
        }
        return std::string();
    };
    if (other == 0) _exit(repeat().empty() ? 0 : 1); // NOLINT: of the test's process it has nothing to undo
    CHECK(repeat() == "");
    int status = -1;
    REQUIRE(waitpid(other, &status, 0) == other);
    CHECK(status == 0);
    CHECK(baker::read_parcel(plan, step, 1, "frame") == bytes);
    CHECK(fs::is_empty(plan.folder + "/scratch"));
}

TEST_CASE("a damaged file of a shard is named with the command that makes it anew, and a launch does so") {
    Random random(27);
    baker::BakeOptions options;
    options.tile_log2 = 6;
    const Job job(terrain(random, 500, 300, false), options);
    const baker::ShardPlan plan = job.plan(2, "plan");
    run_all(job, plan, random, false);
    for (const baker::ShardStep& step : baker::shard_steps(plan.rounds))
        for (const auto& [name, file] : baker::require_record(plan, step, 2).files) {
            const std::string path = plan.file(step, 2, name);
            if (file.bytes == 0) continue;
            std::fstream f(path, std::ios::in | std::ios::out | std::ios::binary);
            f.seekg(static_cast<std::streamoff>(file.bytes / 2));
            const int byte = f.peek();
            const auto put = [&](int value) {
                f.seekp(static_cast<std::streamoff>(file.bytes / 2));
                f.put(static_cast<char>(value)).flush();
            };
            put(byte ^ 16);
            const std::string line = failure_of([&] { (void)job.merged(plan); });
            CAPTURE(step.name(), name, line);
            if (line.empty()) { // the merge does not read it
                put(byte);
                continue;
            }
            CHECK(line == path + ": is damaged; run " + plan.command(step, 2) + " --again");
            CHECK_FALSE(baker::find_record(plan, step, 2)); // as a launch asks
            CHECK(baker::run_shard_step(plan, job.source, options, 2, step) == baker::StepDone::now);
            CHECK((job.merged(plan) == job.whole));
        }
}
