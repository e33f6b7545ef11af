// Shards and merges that are killed, starved and robbed, by faults at counted calls (support/fault_interposer.cpp): the
// same command goes on to the same bytes, and what is not complete is taken for nothing.
#include <catch2/catch.hpp>

#include <csignal>
#include <filesystem>
#include <random>

#include "shards_scene.h"
#include "support/rounds.h"
#include "support/splat_rules.h"

using namespace fjell::test;
namespace fs = std::filesystem;

namespace {

// A command whose calls on files of such a path fail.
std::string with_fault(const std::string& calls, const std::string& path, const std::string& what,
                       const std::string& when, const std::string& command) {
    return "ASAN_OPTIONS=$ASAN_OPTIONS:verify_asan_link_order=0 LD_PRELOAD=" FJELL_FAULTS " FJELL_FAULT='" + calls +
           " " + path + " " + what + " " + when + "' " + command;
}

// What a split of the one bake's pack makes.
void split(const TemporaryFolder& folder) {
    REQUIRE(run_in(folder.path, bake + "split whole.fjell -o split --packs 3x2").code == 0);
}

[[nodiscard]] bool same_set(const TemporaryFolder& folder, const std::string& set) {
    return run_in(folder.path, "diff -r split " + set).code == 0;
}

} // namespace

TEST_CASE(
    "workers of a launch are killed again and again, anywhere in any step, and it gets to the bytes of one bake") {
    const RulesFile rules;
    std::mt19937 random(61);
    for (int round = 0; round < rounds(1, 2); ++round) {
        const TemporaryFolder folder;
        prepare_shards(folder, 3 + 3 * round, "--horizons quarter --splat quarter --layers " + rules.path());
        const std::string launch = bake + "launch plan -o out.fjell --threads 1 --at-once 2";
        int kills = 0;
        for (Run r; kills < 100; ++kills) {
            // At most as many calls as a step of one shard makes, some of them in none.
            const int n = std::uniform_int_distribution<int>(1, kills < rounds(8, 20) ? 60 : 2000)(random);
            r = run_in(folder.path, with_fault("all", "/scratch/", "kill", std::to_string(n), launch));
            CAPTURE(round, kills, n, r.err);
            if (r.code == 0) break;
            CHECK(r.err.find("completed steps stay: repeat the same command to go on") != std::string::npos);
            CHECK_FALSE(fs::exists(folder / "out.fjell"));
        }
        CHECK(kills > 5);
        CHECK(kills < 100);
        CHECK(same_pack(folder, "out.fjell"));
        CHECK(fs::is_empty(folder / "plan/scratch"));
    }
}

TEST_CASE("a merge into a set that is killed at any moment is no set, and the same command makes it") {
    const TemporaryFolder folder;
    prepare_shards(folder, 3);
    split(folder);
    REQUIRE(run_in(folder.path, bake + "launch plan -o whole-again.fjell --threads 1").code == 0);
    const std::string merge = bake + "merge plan -o set --packs 3x2 --threads 1 --quiet";
    int kills = 0;
    std::mt19937 random(62);
    const auto kill = [&](const std::string& calls, int n) {
        const Run r = run_in(folder.path, with_fault(calls, "set/", "kill", std::to_string(n), merge));
        CAPTURE(calls, n, r.err);
        if (r.code == 0) return false;
        CHECK(r.code == 128 + SIGKILL);
        ++kills;
        // With an index it is whole, the old one or the new one: opening compares what is there with it.
        if (fs::exists(folder / "set/set.json"))
            CHECK(run_in(folder.path, bake + "info set").code == 0);
        else
            fails(folder, bake + "info set", 1, "set");
        return true;
    };
    for (int n = 1; kill("all", n) && n < 2000;)
        n += std::uniform_int_distribution<int>(rounds(40, 12), rounds(120, 36))(random);
    CHECK(kills > 5);
    CHECK(same_set(folder, "set"));
    // The end, call by call: the index goes, packs move, the index comes. An old set stays until then.
    REQUIRE(run_in(folder.path, bake + "split whole.fjell -o old --packs 2x2 && rm -r set && mv old set").code == 0);
    kills = 0;
    for (int n = 1; kill("rename,unlink", n) && n < 200;) ++n;
    CHECK(kills >= 13); // six packs when they are complete and when they move, and the index
    CHECK(same_set(folder, "set"));
}

TEST_CASE("a disk that is full or gone, and what others have left half, end steps and merges with one line each") {
    const RulesFile rules;
    const TemporaryFolder folder;
    prepare_shards(folder, 2, "--horizons quarter --splat quarter --layers " + rules.path());
    split(folder);
    const std::string step = bake + "shard plan 1-2/2 --threads 1 --quiet --step ";
    REQUIRE(run_in(folder.path, step + "read && " + step + "means").code == 0);
    fails(folder, step + "step1", 1, "run fjell-bake shard plan 1/2 --step measure");
    fails(folder, with_fault("pwrite,write", "/scratch/", "ENOSPC", "9+", step + "measure"), 3, "plan/scratch");
    REQUIRE(run_in(folder.path, step + "measure").code == 0);
    for (const char* name : {"coarse", "level1-frame", "squares"}) {
        INFO(name);
        const std::string path = std::string("plan/measure/2.") + name;
        fs::resize_file(folder / path, fs::file_size(folder / path) - 1);
        fails(folder, bake + "shard plan 1/2 --threads 1 --quiet --step step1", 1, path + ": is damaged; run");
        fs::remove(folder / path);
        fails(folder, bake + "shard plan 1/2 --threads 1 --quiet --step step1", 1,
              "run fjell-bake shard plan 2/2 --step measure");
        REQUIRE(run_in(folder.path, bake + "shard plan 2/2 --threads 1 --quiet --step measure").code == 0);
    }
    const std::string merge = bake + "merge plan -o set --packs 3x2 --threads 1 --quiet";
    REQUIRE(run_in(folder.path, bake + "launch plan -o out.fjell --threads 1 --quiet").code == 0);
    CHECK(same_pack(folder, "out.fjell"));
    REQUIRE(run_in(folder.path, merge).code == 0);
    CHECK(same_set(folder, "set"));
    for (const char* when : first_of(1, {"5+", "1+", "30+"})) {
        INFO(when);
        fails(folder, with_fault("pwrite,write", "set/", "ENOSPC", when, merge), 3, "set/set.work");
        CHECK(same_set(folder, "set"));
        fails(folder, with_fault("pread,read", "/plan/", "EIO", when, merge), 3, "plan/");
        CHECK(same_set(folder, "set"));
    }
    // Of another recipe: what a plan without horizons has left.
    REQUIRE(
        run_in(folder.path, bake + "plan land.json --tile 64 -o other --shards 2 && " + bake +
                                "launch other -o other.fjell --threads 1 --quiet && cp other/measure/1.* plan/measure")
            .code == 0);
    fails(folder, merge, 1, "plan/measure/1.json: is of another plan than plan/plan.json");
    CHECK(same_set(folder, "set"));
    fs::rename(folder / "plan", folder / "away");
    fails(folder, merge, 1, "is not mounted here");
    CHECK(same_set(folder, "set"));
}
