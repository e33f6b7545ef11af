// Voids of a shard filled: the means that its own heights have, level by level (heights/fill.h), and from its own and
// its neighbours' the same membrane that a bake of the whole finds. Where a terrain has no voids none of it is done.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "baker/bake/stages.h"
#include "baker/heights/fill.h"
#include "baker/shard/plan_folder.h"
#include "baker/shard/shard_ground.h"

namespace fjell::baker {

// Levels of means that shards make; the coarsest is small, and every shard solves it for itself.
inline constexpr int most_mean_levels = 8;

class ShardFill {
public:
    struct Of {
        const ShardPlan& plan;
        const BakeContext& context;
        const ShardGround& ground;
        int shard;
    };
    // frame: how many samples around its own a shard fills.
    ShardFill(const Of& of, std::int32_t frame, ScratchFolder& scratch);

    [[nodiscard]] Window filled_window() const { return needs_.front(); }
    // All of it, or what regions that are baked need. They do not overlap.
    [[nodiscard]] const std::vector<Window>& filled_windows() const { return pieces_.front(); }
    // What a frame of raw heights must be wide.
    [[nodiscard]] static constexpr std::int32_t raw_frame(std::int32_t frame) { return frame + fill_halo; }

    // Step `means`: stores, their frames, and the coarsest level as a parcel. raw: this shard's own heights.
    void leave_means(const Store<float>& raw);
    // raw: with raw_frame() around it. out: fills filled_windows(). Returns the bytes of other shards that were read.
    std::uint64_t fill(const Store<float>& raw, const FillStep& step, Store<float>& out) const;

private:
    [[nodiscard]] Window held_of(int shard, std::size_t level) const;
    [[nodiscard]] Window halved(const Window& samples, std::size_t level) const;
    [[nodiscard]] std::vector<Window> regions_with_ground() const;
    void find_pieces(std::int32_t frame);
    [[nodiscard]] Store<float> make_level(const std::string& path, std::size_t level, const Window& held) const;
    [[nodiscard]] Store<float> find_means(std::size_t level) const;
    [[nodiscard]] Store<float> gather_coarsest() const;

    const ShardPlan& plan_;
    const BakeContext& context_;
    const ShardGround& ground_;
    const int shard_;
    const std::int32_t mean_frame_; // of the coarser levels
    ScratchFolder& scratch_;
    std::vector<Window> levels_;              // the whole of each: level 0 are the samples
    std::vector<Window> needs_;               // of each: what is filled here
    std::vector<std::vector<Window>> pieces_; // of each, in it
};

} // namespace fjell::baker
