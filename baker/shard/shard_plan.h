// How a terrain is cut into shards that are baked apart, and what each of them holds of every store.
//
// A shard is a rectangle of regions (heights/region.h), in which whole tiles lie. All shards together cover the terrain
// once. A shard runs the stages of a bake over its own regions; what it needs from beside them are frames of a few
// rows and columns that its neighbours have left (seam.h). After `rounds` steps of the vertex tree what is left is
// small enough for one machine: `merge` does the rest (docs/notes/sharding.md). Thread: pure functions.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "baker/bake/context.h"
#include "baker/errors/step.h"
#include "baker/maps/horizon.h"
#include "baker/maps/maps.h"
#include "baker/store/window.h"

namespace fjell::baker {

inline constexpr int max_shards = 4096;
// Steps of the vertex tree that shards make. What a merge begins with is 1 / 4^rounds of the terrain's samples.
inline constexpr int most_rounds = 4;

// Rectangles of a grid of across x down regions, one a shard; without area where there are more shards than regions.
// The largest is as small as it can be when rows of shards have whole rows of regions; of cuts that are as good within
// 2%, the one with the widest shards, because files are read row by row.
[[nodiscard]] std::vector<Window> cut_into_shards(std::int32_t across, std::int32_t down, int shards);

// What shards run one by one, all of them before the next. errors: one for each round, named after the step's length.
struct ShardStep {
    enum class Kind { read, means, measure, errors } kind = Kind::read;
    int z = 0; // of errors
    [[nodiscard]] std::string name() const;
    friend bool operator==(const ShardStep&, const ShardStep&) = default;
};
// In the order in which they run.
[[nodiscard]] std::vector<ShardStep> shard_steps(int rounds);

// What a part of the terrain holds of stores. Of places of step 2^z (bake/region_stores.h), each in one part; of the
// centres of step 2^z; of unsaturated errors along southern and eastern borders, and of texels: with the borders that a
// neighbour has too.
struct PartWindows {
    Tree tree;
    Regions regions;
    Window part;

    [[nodiscard]] Window samples() const { return regions.samples_of(part); }
    [[nodiscard]] Window places(int z) const;
    [[nodiscard]] Window centres(int z) const;
    [[nodiscard]] Window south(int z) const;
    [[nodiscard]] Window east(int z) const;
    [[nodiscard]] Window level(const HorizonLevels& levels, int l) const; // of vertices, each in one part
    [[nodiscard]] Window texels(const MapPlan& maps, MapKind kind, std::uint32_t mip) const;
};

// Levels of the heights (maps/horizon.h) that shards make, each its own vertices: up to one that is small, which every
// shard reads whole.
[[nodiscard]] int levels_of_shards(const HorizonLevels& levels, std::size_t whole_vertices);
// How wide a frame of heights a part needs for its maps and errors. O(tiles).
[[nodiscard]] std::int32_t height_frame(const MapPlan& maps, std::size_t whole_vertices);
// What of filled heights, and of marks of holes, a part makes and keeps: its own samples and a frame around them.
[[nodiscard]] inline Window with_frame(const PartWindows& windows, std::int32_t frame) {
    const Window own = windows.samples();
    return common({own.x - frame, own.y - frame, own.columns + 2 * frame, own.rows + 2 * frame},
                  {0, 0, windows.tree.columns(), windows.tree.rows()});
}
// Of places and centres: what errors/step.h reads beside a region.
inline constexpr std::int32_t step_frame = 2 * reach + 2;
inline constexpr std::int32_t texel_frame = 8;

} // namespace fjell::baker
