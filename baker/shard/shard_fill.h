// Voids of a shard filled: the means that its own heights have, level by level (heights/fill.h), and from its own and
// its neighbours' the same membrane that a bake of the whole finds. Where a terrain has no voids none of it is done.
#pragma once

#include <cstdint>

#include "baker/bake/stages.h"
#include "baker/heights/fill.h"
#include "baker/shard/plan_folder.h"

namespace fjell::baker {

// Levels of means that shards make; the coarsest is small, and every shard solves it for itself.
inline constexpr int most_mean_levels = 8;

class ShardFill {
public:
    // frame: how many samples around its own a shard fills.
    ShardFill(const ShardPlan& plan, const BakeContext& context, int shard, std::int32_t frame, ScratchFolder& scratch);

    [[nodiscard]] Window filled_window() const { return needs_.front(); }
    // What a frame of raw heights must be wide.
    [[nodiscard]] static constexpr std::int32_t raw_frame(std::int32_t frame) { return frame + fill_halo; }

    // Step `means`: stores, their frames, and the coarsest level as a parcel. raw: this shard's own heights.
    void leave_means(const Store<float>& raw);
    // raw: with raw_frame() around it. out: fills filled_window(). Returns the bytes of other shards that were read.
    std::uint64_t fill(const Store<float>& raw, const FillStep& step, Store<float>& out) const;

private:
    [[nodiscard]] Window held_of(int shard, std::size_t level) const;
    [[nodiscard]] Store<float> gather_coarsest() const;

    const ShardPlan& plan_;
    const BakeContext& context_;
    const int shard_;
    const std::int32_t mean_frame_; // of the coarser levels
    ScratchFolder& scratch_;
    std::vector<Window> levels_; // the whole of each: level 0 are the samples
    std::vector<Window> needs_;  // of each: what is filled here
};

} // namespace fjell::baker
