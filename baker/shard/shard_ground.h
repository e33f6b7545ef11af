// Where a plan for a set has ground, and what follows from it: packs without any are left out of the set, and of their
// tiles only a ring beside the others is baked, which errors, radii and mips of those reach into. The rest is left out:
// no shard fills, measures or stores it (docs/notes/sharding.md).
#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "baker/bake/context.h"
#include "baker/shard/plan_folder.h"

namespace fjell::baker {

// Notes, while a shard reads, which tiles have ground, borders included. From any thread.
class GroundSeen {
public:
    explicit GroundSeen(const Tree& tree)
        : tree_(tree), tiles_(static_cast<std::size_t>(tree.tiles_x) * static_cast<std::size_t>(tree.tiles_y)) {}
    // heights: of a window, NaN where there is none, `stride` floats from row to row. Returns whether it has any.
    bool note(const Window& window, const float* heights, std::ptrdiff_t stride);
    [[nodiscard]] std::vector<std::uint32_t> tiles() const;

private:
    const Tree tree_;
    std::vector<std::atomic<std::uint8_t>> tiles_;
};

// Whether the whole's heights reach into everything, so that none may be left out: horizons and wetness.
[[nodiscard]] inline bool needs_all_heights(const BakeContext& context) {
    return context.horizon_log2 != 0 || context.splat.wants_wetness();
}
// The same of a bake that is only planned. Reads its rules. Throws Failure 1: those are wrong.
[[nodiscard]] bool needs_all_heights(const BakeOptions& options);

class ShardGround {
public:
    // Until it is found nothing is left out.
    ShardGround(const ShardPlan& plan, const BakeContext& context)
        : plan_(plan), regions_(context.regions), tree_(context.tree) {}
    // From what all shards have read. Still nothing is left out of a plan for one pack, nor where voids are filled.
    void find(bool holes);

    [[nodiscard]] bool leaves_out() const { return !baked_.empty(); }
    [[nodiscard]] bool bakes(std::int64_t region) const {
        return !leaves_out() || baked_[static_cast<std::size_t>(region)] != 0;
    }
    // A shard that has read nothing but voids; one of whose regions none is baked.
    [[nodiscard]] bool is_void(int shard) const {
        return leaves_out() && !has_ground_[static_cast<std::size_t>(shard) - 1];
    }
    [[nodiscard]] bool idles(int shard) const {
        return plan_.empty(shard) || (leaves_out() && !works_[static_cast<std::size_t>(shard) - 1]);
    }
    // Whether a rectangle of tiles has any.
    [[nodiscard]] bool in_tiles(const Window& tiles) const;
    // The same of all tiles of a pack, whose samples these are, borders included.
    [[nodiscard]] bool in_samples(const Window& samples) const;
    // Samples of all regions that are left out, each counted once: all void.
    [[nodiscard]] std::uint64_t samples_left_out() const;

private:
    void find_baked();

    const ShardPlan& plan_;
    const Regions regions_;
    const Tree tree_;
    std::vector<std::uint8_t> tiles_, baked_; // by tile: has ground; by region
    std::vector<bool> has_ground_, works_;    // by shard
};

} // namespace fjell::baker
