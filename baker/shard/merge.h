// From what all shards have left to a pack: the steps of the vertex tree and the mips that are left, root pages,
// corners, and all chunks in the order of a pack. The pack is that of bake(), byte for byte.
#pragma once

#include <string>

#include "baker/bake/bake.h"
#include "baker/shard/plan_folder.h"

namespace fjell::baker {

// options: as for run_shard_step. Throws Failure: 1 with the command to run where a shard has not completed a step.
// Nothing in the plan's folder changes.
BakeSummary merge_shards(const ShardPlan& plan, const HeightSource& source, const BakeOptions& options,
                         const std::string& out_path);

} // namespace fjell::baker
