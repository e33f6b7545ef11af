// Stages that make horizon maps: levels of ever fewer heights, then near mips tile by tile from a window of each.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "baker/bake/stages.h"
#include "baker/maps/horizon.h"
#include "baker/store/parallel.h"

namespace fjell::baker {

namespace {

HorizonLevels levels_of(const BakeContext& context) {
    return {context.tree.columns(), context.tree.rows(), context.source.spacing_m};
}

Window moved(const Window& w, std::int32_t x, std::int32_t y) {
    return {w.x + x, w.y + y, w.columns, w.rows};
}

// Part of a level into rows of `to`, which is as wide as `wide`.
void read_level(const HorizonInput& in, const HorizonLevels& levels, int level, const Window& w, float* to,
                std::ptrdiff_t wide) {
    if (level == 0) return in.heights.heights.read(w, to, wide);
    const Window place = levels.place(level);
    in.levels.read(moved(w, place.x, place.y), to, wide);
}

LevelWindow window_of(const HorizonInput& in, const HorizonLevels& levels, int level, const Window& at) {
    LevelWindow window{at, std::vector<float>(at.area(), no_ground_m)};
    const Window& all = levels.extents(level);
    const std::int32_t x = std::max(at.x, 0), y = std::max(at.y, 0);
    const Window there{x, y, std::min(at.x + at.columns, all.columns) - x, std::min(at.y + at.rows, all.rows) - y};
    if (there.columns <= 0 || there.rows <= 0) return window;
    const std::ptrdiff_t wide = at.columns;
    read_level(in, levels, level, there, window.heights_m.data() + (there.y - at.y) * wide + (there.x - at.x), wide);
    return window;
}

} // namespace

Store<float> open_levels(const BakeContext& context) {
    const Window all = levels_of(context).array();
    return context.open<float>("levels", std::max(all.columns, 1), std::max(all.rows, 1));
}

void make_levels(const BakeContext& context, const HeightStores& heights, Store<float>& levels) {
    constexpr std::int32_t side = 512; // vertices of a level at a time
    const HorizonLevels all = levels_of(context);
    for (int level = 1; level < all.count(); ++level) {
        const Window &extents = all.extents(level), &finer = all.extents(level - 1), place = all.place(level);
        const std::int32_t across = (extents.columns - 1) / side + 1, down = (extents.rows - 1) / side + 1;
        parallel_for(std::int64_t{across} * down, context.threads, [&](std::int64_t i) {
            const std::int32_t x = static_cast<std::int32_t>(i % across) * side,
                               y = static_cast<std::int32_t>(i / across) * side;
            const Window at{x, y, std::min(side, extents.columns - x), std::min(side, extents.rows - y)};
            const Window from = halved_from(finer, at);
            Buffer<float> read(from.area()), made(at.area());
            read_level({heights, levels}, all, level - 1, from, read.data(), from.columns);
            halve_level(read.data(), from, finer, at, made.data());
            levels.write(moved(at, place.x, place.y), made.data(), at.columns);
        });
    }
}

void make_near_horizons(const BakeContext& context, const BakePlan& plan, const HorizonInput& in,
                        const HorizonOutput& out) {
    const HorizonLevels levels = levels_of(context);
    const int stride_log2 = plan.maps.stride_log2(MapKind::horizon);
    // Planes of points, of texels and of their mips; windows of levels.
    const double points = std::ldexp(context.tree.side(), -stride_log2) + 40, samples = context.tree.side() + 120.0;
    const auto tile_bytes = static_cast<std::uint64_t>(points * points * horizon_planes * 10 + samples * samples * 6) +
                            (std::uint64_t{2} << 20);
    context.run_units({"horizons", context.tile_count(), context.workers_for(tile_bytes),
                       context.samples() / static_cast<double>(context.tile_count())},
                      [&](std::uint64_t u) {
                          const std::uint32_t tile = context.tile_at(u);
                          const Window at = points_for_map(plan.maps, MapKind::horizon, tile);
                          std::vector<LevelWindow> seen;
                          for (int level = 0; level < levels.count(); ++level)
                              seen.push_back(window_of(in, levels, level, seen_of_level(level, stride_log2, at)));
                          const TexelPlanes made = horizons(levels, stride_log2, at, seen);
                          seen = {};
                          const std::vector<MipTexels> mips = near_mips_from(plan.maps, MapKind::horizon, tile, made);
                          ChunkBatch batch;
                          for (std::uint32_t mip = 0; mip < mips.size(); ++mip)
                              batch.add({ChunkKind::horizon, tile, mip}, mips[mip].blocks, context.options.compression);
                          if (out.texels.exists())
                              store_texels(out.texels, plan.maps.texels(MapKind::horizon, near_mips - 1, tile),
                                           MapKind::horizon, mips.back().texels);
                          out.spool.append(std::move(batch));
                      });
}

} // namespace fjell::baker
