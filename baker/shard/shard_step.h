// One step of one shard: what the frames of its neighbours say is laid around its own stores, stages of a bake
// (bake/stages.h) run over its regions, and what they leave is put into the plan's folder.
#pragma once

#include "baker/bake/bake.h"
#include "baker/bake/checkpoint.h"
#include "baker/shard/plan_folder.h"

namespace fjell::baker {

// Does nothing where the step is complete, unless `again`. options: those of the plan's recipe, and threads, memory and
// progress. Throws Failure: 1 with the command to run where something is missing.
enum class StepDone : bool { before, now };
StepDone run_shard_step(const ShardPlan& plan, const HeightSource& source, const BakeOptions& options, int shard,
                        const ShardStep& step, bool again = false);

// What the steps that are complete have found out of the whole terrain. `measured`: with the heights' statistics.
[[nodiscard]] CheckpointState found_by_shards(const ShardPlan& plan, const BakeContext& context, bool measured);

// Texels of a mip that shards leave to the next step, or to the merge: none where there is no further mip, or it is
// made from the step before.
[[nodiscard]] bool leaves_texels(const MapPlan& maps, MapKind kind, std::uint32_t mip);
// The mip that a round makes texels of: the last near one in the first, then one each.
[[nodiscard]] constexpr std::uint32_t mip_of_round(int z) {
    return near_mips - 1 + static_cast<std::uint32_t>(z);
}
[[nodiscard]] std::string texel_name(MapKind kind, std::uint32_t mip);

} // namespace fjell::baker
