// What maps of a shard need of all of the terrain: coarse levels of the heights for horizons, and the grid of wetness
// for splat maps. Shards leave their own in the step `measure`, and find everyone's in the first of errors.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "baker/bake/stages.h"
#include "baker/shard/plan_folder.h"

namespace fjell::baker {

class ShardLevels {
public:
    // frame: how many vertices of a level beside its own a shard needs at most (height_frame).
    ShardLevels(const ShardPlan& plan, const BakeContext& context, int shard, std::int32_t frame);

    // heights: this shard's own, filled, and a frame around them.
    void leave(const Store<float>& heights, ScratchFolder& scratch) const;
    // Returns the bytes of other shards that were read.
    std::uint64_t find();
    [[nodiscard]] LevelReader reader() const; // of levels from 1 on; keeps a reference to this

private:
    [[nodiscard]] Window own(int shard, int level) const;

    const ShardPlan& plan_;
    const BakeContext& context_;
    const int shard_;
    const std::int32_t frame_;
    const HorizonLevels levels_;
    const int coarse_;                 // the last level that shards make; from it on all is here
    std::vector<Store<float>> stores_; // of levels from 1 on
};

void leave_squares(const BakeContext& context, const Store<float>& heights, ScratchFolder& scratch);
// Whoever comes first leaves it in the plan's folder for the others: it is the same whoever finds it. Adds the bytes of
// other shards that were read.
[[nodiscard]] Wetness find_wetness(const ShardPlan& plan, const BakeContext& context, std::uint64_t& bytes_read);

} // namespace fjell::baker
