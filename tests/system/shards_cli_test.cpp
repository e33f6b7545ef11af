// Shards by the program, and by the engines that start it. Slurm and OpenMPI run in full rounds only.
#include <catch2/catch.hpp>

#include <filesystem>
#include <string>

#include "shards_scene.h"
#include "support/rounds.h"

using namespace fjell::test;

TEST_CASE("a plan launched on this machine makes the pack of one bake, and a shard that fails is run again alone") {
    const TemporaryFolder folder;
    prepare_shards(folder, 2);
    fails(folder, bake + "merge plan -o out.fjell", 1, "run fjell-bake shard plan 1/2 --step read");
    fails(folder, bake + "shard plan 1/2 --step step1", 1, "run fjell-bake shard plan 1/2 --step read");
    fails(folder, bake + "shard plan 3/2", 2, "give one from 1/2 to 2/2");
    fails(folder, bake + "shard plan 1/2 --step errors", 2, "this plan has read, means, measure, step1");
    fails(folder, bake + "shard gone 1/2", 1, "is not mounted here");
    fails(folder, "ulimit -f 100; " + bake + "shard plan 1/2 --threads 1", 3, "plan/scratch");
    CHECK(run_in(folder.path, bake + "plan plan --status").out.find("next: fjell-bake shard plan 1/2 --step read") !=
          std::string::npos);
    fails(folder, bake + "shard plan 2-1/2", 2, "several like 1-2/2");
    fails(folder, bake + "shard plan 1-3/2", 2, "several like 1-2/2");
    const Run several = run_in(folder.path, bake + "shard plan 1-2/2 --step read --threads 1");
    CHECK(several.code == 0);
    CHECK(several.out == "shard 1/2: read is complete\nshard 2/2: read is complete\n");
    // A requeued node may still be at work. Of 180 attempts one or two took another's new folder for a dead one's.
    const std::string attempt = bake + "shard plan 1/2 --step read --again --threads 1 --quiet & ";
    const Run attempts =
        run_in(folder.path, "for n in $(seq " + std::to_string(rounds(2, 60)) + "); do " + attempt + "a=$!; " +
                                attempt + "b=$!; " + attempt + "wait $a && wait $b && wait $! || exit 1; done");
    CAPTURE(attempts.err);
    CHECK(attempts.code == 0);
    CHECK(
        run_in(folder.path, bake + "launch plan -o out.fjell --dry-run --at-once 1").out.find(" 1-2/2 --step step1") !=
        std::string::npos);
    const Run launched = run_in(folder.path, bake + "launch plan -o out.fjell --threads 1");
    REQUIRE(launched.code == 0);
    CHECK(launched.out.starts_with("out.fjell: 600 x 420 samples")); // as a bake tells of its pack
    CHECK(same_pack(folder, "out.fjell"));
    CHECK(run_in(folder.path, bake + "plan plan --status").out.find("all steps are complete") != std::string::npos);
    spit(folder / "land.json", R"({"columns": 600, "rows": 421})");
    fails(folder, bake + "merge plan -o out.fjell", 1, "the terrain has 600 x 421 samples, and 600 x 420 were planned");
    spit(folder / "land.json", R"({"columns": 600, "rows": 4200})");
    fails(folder, bake + "merge plan -o out.fjell", 1, "land.json is not what was planned");
}

TEST_CASE("a plan for a set says that it bakes voids like ground where horizons or wetness look at all heights") {
    const TemporaryFolder folder;
    spit(folder / "land.json", R"({"columns": 600, "rows": 420})");
    spit(folder / "dry.json", R"({"rules": [{"layer": "grass"}]})");
    spit(folder / "wet.json", R"({"rules": [{"layer": "grass"}, {"layer": "mud", "wetness": [6, null]}]})");
    int plans = 0;
    const auto says = [&](const std::string& options) {
        const std::string name = "plan" + std::to_string(plans++);
        const Run r = run_in(folder.path, bake + "plan land.json -o " + name + " --tile 64 --shards 2 " + options);
        CAPTURE(options, r.err);
        REQUIRE(r.code == 0);
        return r.out.find("voids are baked like ground, because horizons and wetness look at all heights") !=
               std::string::npos;
    };
    CHECK(says("--packs 3x2 --horizons half"));
    CHECK(says("--packs 3x2 --layers wet.json"));
    CHECK_FALSE(says("--packs 3x2 --layers dry.json"));
    CHECK_FALSE(says("--packs 3x2"));
    CHECK_FALSE(says("--horizons half"));
}

TEST_CASE("a plan on the job arrays of a real Slurm of two nodes, one shard killed, makes the pack of one bake") {
    if (!full_rounds()) return;
    const TemporaryFolder folder;
    prepare_shards(folder, 7);
    // The kill: of whatever shard runs first. Slurm lets what depends on it go, and the same launch goes on.
    spit(folder / "job.sh", "launch() { " + bake +
                                "launch plan -o out.fjell --with slurm --threads 1 > /dev/null || exit 1\n"
                                "while [ -n \"$(squeue -h)\" ]; do sleep 0.2; done; }\n"
                                "(until scancel --signal=KILL --name=fjell-step1 2> /dev/null && "
                                "[ -n \"$(squeue -h -n fjell-step1 -t R)\" ]; do sleep 0.05; done) & killer=$!\n"
                                "launch; kill $killer 2> /dev/null; launch; [ -s out.fjell ]\n");
    const Run r = run_in(folder.path, "bash " FJELL_SOURCE_DIR "/tests/system/cluster.sh far bash job.sh");
    if (r.code == 77) {
        WARN("no Slurm of our own here: " << r.err);
        return;
    }
    CAPTURE(r.out, r.err);
    REQUIRE(r.code == 0);
    CHECK(same_pack(folder, "out.fjell"));
}

TEST_CASE(
    "a node of a real Slurm is lost in the middle of an array: its shard runs elsewhere, to the pack of one bake") {
    if (!full_rounds()) return;
    const TemporaryFolder folder;
    prepare_shards(folder, 3, "--horizons quarter");
    const std::string scripts = FJELL_SOURCE_DIR "/tests/system/";
    const Run r =
        run_in(folder.path, "bash " + scripts + "cluster.sh far bash " + scripts + "lose_node.sh far out.fjell " +
                                bake + "launch plan -o out.fjell --with slurm --threads 1");
    if (r.code == 77) {
        WARN("no Slurm of our own here: " << r.err);
        return;
    }
    CAPTURE(r.out, r.err);
    REQUIRE(r.code == 0);
    CHECK(r.out.starts_with("queued again: "));
    CHECK(r.out.ends_with("down*\n")); // until the end
    CHECK(same_pack(folder, "out.fjell"));
}

TEST_CASE("a plan under mpirun, a step's files lost in between, makes the pack of one bake") {
    if (!full_rounds()) return;
    const TemporaryFolder folder;
    prepare_shards(folder, 5);
    if (run_in(folder.path, "command -v mpirun").code != 0) {
        WARN("no mpirun here");
        return;
    }
    const std::string launch = "FJELL_MPI_OPTIONS='--allow-run-as-root --oversubscribe' " + bake +
                               "launch plan -o out.fjell --with mpi --at-once 3 --threads 1";
    REQUIRE(run_in(folder.path, launch).code == 0);
    CHECK(same_pack(folder, "out.fjell"));
    std::filesystem::remove(folder / "out.fjell");
    std::filesystem::remove(folder / "plan/step1/4.places");
    REQUIRE(run_in(folder.path, launch).code == 0);
    CHECK(same_pack(folder, "out.fjell"));
}
