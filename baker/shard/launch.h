// Engines that run a plan's shards: this machine, Slurm, OpenMPI. All of them start the same commands (`fjell-bake
// shard`), step by step; the engine's own means see that a step begins when the one before is complete.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "baker/pack/write_set.h"
#include "baker/shard/plan_folder.h"

namespace fjell::baker {

enum class Launcher { local, slurm, mpi };

// Shards from 1 on, both included.
struct ShardRange {
    int first, last;
};

struct LaunchOptions {
    Launcher with = Launcher::local;
    int at_once = 1;     // local: shards that run side by side; mpi: processes
    int threads = 0;     // of each shard
    int memory_mb = 512; // of each shard
    std::string program; // of the machines; how they find fjell-bake
    std::string out_path;
    std::optional<SetGrid> packs; // out_path: the folder of a set of them
    bool quiet = false;           // otherwise the merge tells of the pack, as a bake does
};

// What a plan costs, from the sizes of its stores and the rates of docs/notes/sharding.md, which are those of one core.
struct ShardCost {
    double seconds = 0; // of all steps of the largest shard, one thread
    double merge_seconds = 0;
    double disk_bytes = 0;          // of the plan's folder, at most
    double largest_shard_bytes = 0; // of that
    double frame_bytes = 0;         // that the largest shard writes for its neighbours
};
[[nodiscard]] ShardCost cost_of(const ShardPlan& plan, const Recipe& recipe);

// Local: each step's commands, one a shard. Slurm: one sbatch a step, an array of shards that waits for the step
// before. MPI: one mpirun a step. The last one merges. For a shell.
[[nodiscard]] std::vector<std::string> launch_commands(const ShardPlan& plan, const LaunchOptions& options);

// Runs them all, and waits unless the engine has a queue. A step of a shard that is complete costs nothing again.
// Throws Failure 3 where an engine is missing, 2 for more packs than tiles, and 1 where a shard failed: the same call
// goes on.
void launch(const ShardPlan& plan, const LaunchOptions& options);

} // namespace fjell::baker
