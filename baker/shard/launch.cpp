#include "baker/shard/launch.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <thread>

#include <sys/wait.h>

#include "baker/bake/context.h"
#include "baker/shard/merge.h"
#include "baker/store/parallel.h"

namespace fjell::baker {

namespace {

std::string shell_quoted(const std::string& word) {
    std::string text = "'";
    for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return text + "'";
}

std::string how(const LaunchOptions& o) {
    return fmt::format(" --threads {} --memory {}", o.threads, o.memory_mb);
}

// shards: a number, two with a dash between, or what a shell makes either of.
std::string shard_command(const ShardPlan& plan, const LaunchOptions& o, const ShardStep& step,
                          const std::string& shards) {
    return fmt::format("{} shard {} {}/{} --step {} --quiet{}", shell_quoted(o.program), shell_quoted(plan.folder),
                       shards, plan.shards, step.name(), how(o));
}

std::string merge_command(const ShardPlan& plan, const LaunchOptions& o) {
    const std::string packs = o.packs ? fmt::format(" --packs {}x{}", o.packs->packs_x, o.packs->packs_y) : "";
    return fmt::format("{} merge {} -o {}{}{}{}", shell_quoted(o.program), shell_quoted(plan.folder),
                       shell_quoted(o.out_path), packs, o.quiet ? " --quiet" : "", how(o));
}

// JOB is the shell's name for the job before.
std::string sbatch(const LaunchOptions& o, const std::string& name, const std::string& more,
                   const std::string& command) {
    const std::string cores = o.threads > 0 ? fmt::format(" --cpus-per-task={}", o.threads) : "";
    return fmt::format("JOB=$(sbatch --parsable --job-name=fjell-{}{} ${{JOB:+--dependency=afterok:$JOB}} "
                       "--kill-on-invalid-dep=yes{} --wrap={})",
                       name, cores, more, shell_quoted(command));
}

std::vector<std::string> of_slurm(const ShardPlan& plan, const LaunchOptions& o) {
    std::vector<std::string> commands{"set -e", "JOB="}; // one that the environment has is not ours to wait for
    const std::string log = shell_quoted(plan.folder + "/log");
    commands.push_back("mkdir -p " + log);
    for (const ShardStep& step : shard_steps(plan.rounds))
        commands.push_back(sbatch(
            o, step.name(), fmt::format(" --requeue --array=1-{} --output={}/{}-%a.txt", plan.shards, log, step.name()),
            shard_command(plan, o, step, "$SLURM_ARRAY_TASK_ID")));
    commands.push_back(
        sbatch(o, "merge", fmt::format(" --requeue --output={}/merge.txt", log), merge_command(plan, o)));
    commands.push_back("echo \"submitted; the merge is job $JOB\"");
    return commands;
}

// A process takes its share of the shards one after another: each start of the program costs as much as a shard's share
// of a small terrain.
std::vector<std::string> of_mpi(const ShardPlan& plan, const LaunchOptions& o) {
    std::vector<std::string> commands{"set -e"};
    const int processes = std::min(o.at_once, plan.shards);
    const std::string share =
        fmt::format("$((OMPI_COMM_WORLD_RANK * {0} / {1} + 1))-$(((OMPI_COMM_WORLD_RANK + 1) * {0} / {1}))",
                    plan.shards, processes);
    for (const ShardStep& step : shard_steps(plan.rounds))
        commands.push_back(fmt::format("mpirun $FJELL_MPI_OPTIONS -n {} sh -c {}", processes,
                                       shell_quoted("exec " + shard_command(plan, o, step, share))));
    commands.push_back(merge_command(plan, o));
    return commands;
}

int run_shell(const std::string& script) {
    const int status = std::system(script.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : 130;
}

// Of `processes`, the one with this number takes these shards.
ShardRange share_of(const ShardPlan& plan, int processes, std::int64_t number) {
    const auto until = [&](std::int64_t i) { return static_cast<int>(i * plan.shards / processes); };
    return {until(number) + 1, until(number + 1)};
}

std::string named(const ShardRange& share) {
    return share.first == share.last ? std::to_string(share.first) : fmt::format("{}-{}", share.first, share.last);
}

void launch_local(const ShardPlan& plan, const LaunchOptions& o) {
    const int processes = std::min(o.at_once, plan.shards);
    for (const ShardStep& step : shard_steps(plan.rounds))
        parallel_for(processes, processes, [&](std::int64_t i) {
            const ShardRange share = share_of(plan, processes, i);
            const auto missing = [&] {
                int shard = share.first;
                while (shard <= share.last && find_record(plan, step, shard)) ++shard;
                return shard;
            };
            if (missing() > share.last) return;
            if (run_shell(shard_command(plan, o, step, named(share))) == 0) return;
            throw Failure(1, fmt::format("{}: shard {}/{} failed in {}; completed steps stay: repeat the same command "
                                         "to go on",
                                         plan.folder, std::min(missing(), share.last), plan.shards, step.name()));
        });
    if (const int code = run_shell(merge_command(plan, o)); code != 0)
        throw Failure(code, fmt::format("{}: the merge failed; the same command goes on", plan.folder));
}

} // namespace

ShardCost cost_of(const ShardPlan& plan, const Recipe& recipe) {
    const BakeOptions options = bake_options(recipe);
    const Tree tree = Tree::covering(plan.columns, plan.rows, plan.tile_log2);
    const Regions regions(tree, BakeOptions{}.region_cells);
    const double samples = static_cast<double>(plan.columns) * plan.rows;
    double largest = 0, edge = 0;
    for (const Window& part : plan.parts) {
        if (part.area() == 0) continue;
        const Window w = regions.samples_of(part);
        largest = std::max(largest, static_cast<double>(w.area()));
        edge = std::max(edge, 2.0 * (w.columns + w.rows));
    }
    // Bytes a sample: heights 4 (twice with voids), unsaturated errors 1/4, places and centres of all rounds
    // 12/4 (1 + 1/4 + ...), texels of mips, and chunks, of which work_bytes knows the most.
    constexpr double shard_rate = 8e6, merge_rate = 8e6; // samples a second and core; docs/notes/sharding.md
    const auto normals =
        static_cast<std::uint32_t>(std::min(plan.tile_log2, static_cast<int>(options.max_texture_log2)));
    const auto coarser = [&](int spacing) {
        return normals -
               std::min(normals, static_cast<std::uint32_t>(std::bit_width(static_cast<unsigned>(spacing)) - 1));
    };
    const bool horizons = options.horizon_spacing != 0, splat = !options.layers_path.empty();
    const auto all =
        static_cast<double>(work_bytes(tree, options.order,
                                       {normals - 1, normals, horizons ? coarser(options.horizon_spacing) : 0,
                                        splat ? coarser(options.splat_spacing) : 0}));
    // Horizons and splat maps at every second sample; docs/notes/horizons.md and materials.md. At every n-th it is
    // less, but not by n^2.
    constexpr double map_rate = 4e6;
    ShardCost cost;
    cost.seconds = largest / shard_rate;
    if (horizons) cost.seconds += largest / (map_rate * options.horizon_spacing / 2);
    if (splat) cost.seconds += largest / (map_rate * options.splat_spacing / 2);
    cost.merge_seconds = samples / std::ldexp(1.0, 2 * plan.rounds) / merge_rate + samples * 1.5 / 400e6;
    cost.disk_bytes = all + samples * 4;
    cost.largest_shard_bytes = cost.disk_bytes * largest / samples;
    cost.frame_bytes = edge * (4.0 * 46 + step_frame * 12);
    return cost;
}

std::vector<std::string> launch_commands(const ShardPlan& plan, const LaunchOptions& o) {
    if (o.with == Launcher::slurm) return of_slurm(plan, o);
    if (o.with == Launcher::mpi) return of_mpi(plan, o);
    std::vector<std::string> commands;
    const int processes = std::min(o.at_once, plan.shards);
    for (const ShardStep& step : shard_steps(plan.rounds))
        for (int i = 0; i < processes; ++i)
            commands.push_back(shard_command(plan, o, step, named(share_of(plan, processes, i))));
    commands.push_back(merge_command(plan, o));
    return commands;
}

void launch(const ShardPlan& plan, const LaunchOptions& o) {
    check_packs(plan, o.packs);
    const char* const needs = o.with == Launcher::slurm ? "sbatch" : o.with == Launcher::mpi ? "mpirun" : nullptr;
    if (needs == nullptr) return launch_local(plan, o);
    if (run_shell(fmt::format("command -v {} > /dev/null", needs)) != 0)
        throw Failure(3, fmt::format("{} is not installed here; install it, or choose another --with", needs));
    std::string script;
    for (const std::string& command : launch_commands(plan, o)) script += command + "\n";
    if (run_shell(script) != 0)
        throw Failure(1, fmt::format("{}: {} failed; completed steps stay: repeat the same command to go on",
                                     plan.folder, needs));
}

} // namespace fjell::baker
