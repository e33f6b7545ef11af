#include "baker/cli/shards.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "baker/bake/inputs.h"
#include "baker/cli/summary.h"
#include "baker/georeference/open_source.h"
#include "baker/shard/launch.h"
#include "baker/shard/merge.h"
#include "baker/shard/plan_folder.h"
#include "baker/shard/shard_ground.h"
#include "baker/shard/shard_step.h"
#include "io/file.h"

namespace fjell::baker {

namespace {

// From K/N, or from K-L/N.
ShardRange shard_range(const std::string& text, const ShardPlan& plan) {
    const auto number = [](std::string_view digits) {
        int value = 0;
        const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
        return error == std::errc{} && end == digits.data() + digits.size() ? value : 0;
    };
    const std::string_view all = text;
    const std::size_t slash = std::min(all.find('/'), all.size());
    const std::string_view shards = all.substr(0, slash);
    const std::size_t dash = std::min(shards.find('-'), shards.size());
    const int n = slash < all.size() ? number(all.substr(slash + 1)) : 0;
    const ShardRange range{number(shards.substr(0, dash)),
                           number(dash < shards.size() ? shards.substr(dash + 1) : shards)};
    if (n != plan.shards || range.first < 1 || range.last < range.first || range.last > n)
        throw Failure(2, fmt::format("shard {}: {} has {} shards; give one from 1/{} to {}/{}, or several like 1-{}/{}",
                                     text, plan.folder, plan.shards, plan.shards, plan.shards, plan.shards, plan.shards,
                                     plan.shards));
    return range;
}

ShardStep step_named(const std::string& name, const ShardPlan& plan) {
    std::string names;
    for (const ShardStep& step : shard_steps(plan.rounds)) {
        if (step.name() == name) return step;
        names += (names.empty() ? "" : ", ") + step.name();
    }
    throw Failure(2, fmt::format("--step {}: this plan has {}", name, names));
}

int print_status(const ShardPlan& plan) {
    const auto steps = shard_steps(plan.rounds);
    bool all = true;
    for (const ShardStep& step : steps) {
        int complete = 0, first_missing = 0;
        double cpu = 0, longest = 0;
        for (int shard = 1; shard <= plan.shards; ++shard) {
            const auto record = find_record(plan, step, shard);
            if (record) ++complete, cpu += record->cpu_seconds, longest = std::max(longest, record->seconds);
            if (!record && first_missing == 0) first_missing = shard;
        }
        fmt::print("{:<8} {} of {} shards", step.name(), complete, plan.shards);
        if (complete) fmt::print(", {:.1f} CPU seconds, the longest took {:.1f} s", cpu, longest);
        if (first_missing && all) fmt::print("; next: {}", plan.command(step, first_missing));
        fmt::print("\n");
        all = all && first_missing == 0;
    }
    if (all) fmt::print("all steps are complete; next: fjell-bake merge {} -o OUT.fjell\n", plan.folder);
    return 0;
}

BakeOptions options_of(const Arguments& a, const Recipe& recipe, ProgressBar& bar) {
    BakeOptions options = bake_options(recipe);
    options.threads = a.threads;
    options.memory_bytes = std::uint64_t{a.memory_mb} << 20;
    options.progress = std::ref(bar);
    limit_gdal_cache(options.memory_bytes / 16);
    return options;
}

// What a merge writes; a set's folder with all that is in it.
std::vector<std::string> outputs_of(const Arguments& a) {
    std::vector<std::string> outputs =
        a.packs ? std::vector<std::string>{*a.given.output + "/"} : places_written(*a.given.output);
    outputs.push_back(a.json_path);
    return outputs;
}

void check_output(const Arguments& a) {
    if (!a.packs && a.given.output->ends_with('/'))
        throw Failure(2,
                      fmt::format("{}: is a folder's name; add --packs AxB for a pack set, or name a file for a pack",
                                  *a.given.output));
}

std::vector<std::string> inputs_of_merge(const ShardPlan& plan, const Recipe& recipe) {
    std::vector<std::string> inputs = files_read(recipe);
    inputs.push_back(plan.folder + "/plan.json");
    return inputs;
}

} // namespace

int run_plan(const Arguments& a) {
    if (a.status) {
        if (a.given.inputs.size() != 1) throw Failure(2, "--status: name the plan's folder, and nothing else");
        return print_status(load_plan(a.given.inputs.front()));
    }
    Recipe recipe = complete(a.given, a.recipe_path);
    recipe.output.reset();
    if (recipe.inputs.empty()) throw Failure(2, "no height field given; see fjell-bake plan --help");
    if (a.plan_folder.empty()) throw Failure(2, "no folder for the plan given; add -o DIR");
    if (a.shards == 0) throw Failure(2, "give the number of shards with --shards N");
    const BakeOptions options = bake_options(recipe);
    const bool bakes_voids = a.packs && needs_all_heights(options);
    ShardPlan plan = make_shard_plan(*open_inputs(recipe), options, a.shards, a.packs);
    plan.inputs = inputs_of(recipe);
    write_plan(plan, recipe, a.plan_folder);
    std::string steps;
    for (const ShardStep& step : shard_steps(plan.rounds)) steps += " " + step.name();
    if (a.quiet) return 0;
    fmt::print("{}: {} shards of {} x {} samples in tiles of {} cells\n", a.plan_folder, plan.shards, plan.columns,
               plan.rows, 1 << plan.tile_log2);
    fmt::print(
        "next, all of it: fjell-bake launch {0} -o OUT.fjell\n"
        "or by hand: fjell-bake shard {0} K/{1} --step STEP, for each step of{2} and in it for every K from 1 to "
        "{1}; then fjell-bake merge {0} -o OUT.fjell\n",
        a.plan_folder, plan.shards, steps);
    if (bakes_voids)
        fmt::print("voids are baked like ground, because horizons and wetness look at all heights; leave both out to "
                   "save that\n");
    return 0;
}

int run_shard(const Arguments& a) {
    const ShardPlan plan = load_plan(a.plan_folder);
    const ShardRange range = shard_range(a.shard, plan);
    check_program(plan);
    std::vector<std::pair<int, ShardStep>> work;
    for (int shard = range.first; shard <= range.last; ++shard) {
        std::vector<ShardStep> steps = shard_steps(plan.rounds);
        if (!a.shard_step.empty()) {
            steps = {step_named(a.shard_step, plan)};
        } else if (!a.again) {
            std::erase_if(steps, [&](const ShardStep& step) { return find_record(plan, step, shard).has_value(); });
        }
        if (!steps.empty())
            work.emplace_back(shard, steps.front());
        else if (!a.quiet)
            fmt::print("shard {}/{}: all steps are complete\n", shard, plan.shards);
    }
    if (work.empty()) return 0;
    const Recipe recipe = plan_recipe(plan.folder);
    check_inputs(plan, recipe);
    const auto source = open_inputs(recipe);
    for (const auto& [shard, step] : work) {
        ProgressBar bar(a.quiet);
        const BakeOptions options = options_of(a, recipe, bar);
        const StepDone done = run_shard_step(plan, *source, options, shard, step, a.again);
        if (!a.quiet)
            fmt::print("shard {}/{}: {} {}\n", shard, plan.shards, step.name(),
                       done == StepDone::before ? "was complete; nothing to do" : "is complete");
    }
    return 0;
}

int run_launch(const Arguments& a) {
    check_output(a);
    const ShardPlan plan = load_plan(a.plan_folder);
    check_program(plan);
    const Recipe recipe = plan_recipe(plan.folder);
    const LaunchOptions options{a.launcher == "slurm" ? Launcher::slurm
                                : a.launcher == "mpi" ? Launcher::mpi
                                                      : Launcher::local,
                                a.at_once,
                                a.threads,
                                static_cast<int>(a.memory_mb),
                                std::filesystem::read_symlink("/proc/self/exe").string(),
                                *a.given.output,
                                a.packs,
                                a.quiet};
    if (a.dry_run) {
        const ShardCost cost = cost_of(plan, recipe);
        for (const std::string& command : launch_commands(plan, options)) fmt::print("{}\n", command);
        fmt::print("# the largest shard: about {:.0f} CPU seconds, {:.0f} MB of the shared folder at most, {} MB of "
                   "memory, {:.2g} MB for its neighbours; the merge: about {:.0f} s; the folder: {:.0f} MB at most\n",
                   cost.seconds, cost.largest_shard_bytes / 1e6, a.memory_mb, cost.frame_bytes / 1e6,
                   cost.merge_seconds, cost.disk_bytes / 1e6);
        return 0;
    }
    io::refuse_overwriting(outputs_of(a), inputs_of_merge(plan, recipe));
    launch(plan, options);
    return 0;
}

int run_merge(const Arguments& a) {
    check_output(a);
    const ShardPlan plan = load_plan(a.plan_folder);
    check_program(plan);
    const std::string& output = *a.given.output;
    const Recipe recipe = plan_recipe(plan.folder);
    check_inputs(plan, recipe);
    io::refuse_overwriting(outputs_of(a), inputs_of_merge(plan, recipe));
    JsonOutput summary(a.json_path);
    ProgressBar bar(a.quiet);
    const BakeOptions options = options_of(a, recipe, bar);
    const auto source = open_inputs(recipe);
    const bool prints = !a.quiet && a.json_path != "-";
    if (!a.packs) {
        const BakeSummary s = merge_shards(plan, *source, options, output);
        summary.write(summary_json(s));
        if (prints) print_summary(s, output);
        return 0;
    }
    const MergedSet merged = merge_shards_to_set(plan, *source, options, *a.packs, output);
    nlohmann::json j = summary_json(merged.bake);
    j["packs"] = merged.set.packs;
    j["packs_left_out"] = merged.set.left_out;
    summary.write(j);
    if (prints) print_summary(merged.bake, output), print_set(merged.set, output);
    return 0;
}

} // namespace fjell::baker
