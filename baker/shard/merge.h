// From what all shards have left to a pack, or to a pack set: the steps of the vertex tree and the mips that are left,
// root pages, corners, and all chunks in the order of a pack. The pack is that of bake(), byte for byte; the set is
// that of split_pack() of it.
#pragma once

#include <optional>
#include <string>

#include "baker/bake/bake.h"
#include "baker/pack/write_set.h"
#include "baker/shard/plan_folder.h"

namespace fjell::baker {

// options: as for run_shard_step. Throws Failure: 1 with the command to run where a shard has not completed a step.
// Nothing in the plan's folder changes.
BakeSummary merge_shards(const ShardPlan& plan, const HeightSource& source, const BakeOptions& options,
                         const std::string& out_path);

// Throws Failure 2 when the plan has fewer tiles than packs, or is for a set of others. grid: none: one pack.
void check_packs(const ShardPlan& plan, const std::optional<SetGrid>& grid);
// A set without a pack of all: folder holds it. The summary counts the bytes of all packs. Throws Failure as above, and
// as write_set() does.
struct MergedSet {
    BakeSummary bake;
    SetSummary set;
};
MergedSet merge_shards_to_set(const ShardPlan& plan, const HeightSource& source, const BakeOptions& options,
                              const SetGrid& grid, const std::string& folder);

} // namespace fjell::baker
