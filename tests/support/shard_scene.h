// A terrain that is baked in one go and in shards.
#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "baker/pack/write_set.h"
#include "baker/shard/merge.h"
#include "baker/shard/shard_step.h"
#include "io/file.h"
#include "support/dem.h"
#include "support/program.h"
#include "support/terrain_fixture.h"

namespace fjell::test {

// Files of a folder, by their names; of a set all of it.
inline std::map<std::string, std::vector<std::byte>> files_in(const std::string& folder) {
    std::map<std::string, std::vector<std::byte>> files;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        files[entry.path().filename().string()] =
            entry.is_regular_file() ? io::read_file(entry.path().string()) : std::vector<std::byte>();
    return files;
}

struct Job {
    baker::DemSource source;
    baker::BakeOptions options;
    TemporaryFolder folder;
    std::vector<std::byte> whole; // what one bake makes

    Job(baker::Dem dem, const baker::BakeOptions& bake_options) : source(std::move(dem)), options(bake_options) {
        options.threads = 1;
        baker::bake(source, options, folder / "whole.fjell");
        whole = io::read_file(folder / "whole.fjell");
    }
    [[nodiscard]] baker::ShardPlan plan(int shards, const std::string& name,
                                        const std::optional<baker::SetGrid>& packs = {}) const {
        baker::ShardPlan made = baker::make_shard_plan(source, options, shards, packs);
        baker::write_plan(made, {}, folder / name);
        return made;
    }
    [[nodiscard]] std::vector<std::byte> merged(const baker::ShardPlan& made) const {
        baker::merge_shards(made, source, options, folder / "merged.fjell");
        return io::read_file(folder / "merged.fjell");
    }
};

// Interrupts a step once, some calls of its progress from now.
struct Killer {
    int calls = 0;
    void arm(baker::BakeOptions& options, Random& random) {
        calls = pick(random, 1, 3);
        options.progress = [this](const char*, std::uint64_t, std::uint64_t) {
            if (--calls == 0) throw io::Failure(130, "interrupted");
        };
    }
};

// All steps, shards in any order; some are interrupted and run again, some run twice.
inline void run_all(const Job& job, const baker::ShardPlan& plan, Random& random, bool kill) {
    std::vector<int> order;
    for (int shard = 1; shard <= plan.shards; ++shard) order.push_back(shard);
    for (const baker::ShardStep& step : baker::shard_steps(plan.rounds)) {
        std::shuffle(order.begin(), order.end(), random);
        for (const int shard : order) {
            baker::BakeOptions options = job.options;
            if (kill && pick(random, 0, 2) == 0) {
                Killer killer;
                killer.arm(options, random);
                try {
                    baker::run_shard_step(plan, job.source, options, shard, step);
                } catch (const io::Failure&) {
                    CHECK_FALSE(baker::find_record(plan, step, shard).has_value());
                }
                options.progress = {};
            }
            baker::run_shard_step(plan, job.source, options, shard, step);
            if (kill && pick(random, 0, 9) == 0) baker::run_shard_step(plan, job.source, options, shard, step, true);
        }
    }
}

inline std::string failure_of(const std::function<void()>& call) {
    try {
        call();
    } catch (const io::Failure& failure) {
        return failure.what();
    }
    return "";
}

inline baker::Dem terrain(Random& random, std::int32_t columns, std::int32_t rows, bool holes) {
    baker::Dem dem = random_dem(random, columns, rows, Shape::fractal);
    if (holes) add_random_holes(random, dem, 6);
    return dem;
}

} // namespace fjell::test
