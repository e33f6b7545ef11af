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

Window moved(const Window& w, std::int32_t x, std::int32_t y) {
    return {w.x + x, w.y + y, w.columns, w.rows};
}

LevelWindow window_of(const HorizonInput& in, const HorizonLevels& levels, int level, const Window& at) {
    LevelWindow window{at, std::vector<float>(at.area(), no_ground_m)};
    const Window& all = levels.extents(level);
    const std::int32_t x = std::max(at.x, 0), y = std::max(at.y, 0);
    const Window there{x, y, std::min(at.x + at.columns, all.columns) - x, std::min(at.y + at.rows, all.rows) - y};
    if (there.columns <= 0 || there.rows <= 0) return window;
    const std::ptrdiff_t wide = at.columns;
    float* const to = window.heights_m.data() + (there.y - at.y) * wide + (there.x - at.x);
    if (level == 0)
        in.heights.heights.read(there, to, wide);
    else
        in.read_level(level, there, to, wide);
    return window;
}

} // namespace

HorizonLevels levels_of(const BakeContext& context) {
    return {context.tree.columns(), context.tree.rows(), context.source.spacing_m};
}

Store<float> open_levels(const BakeContext& context) {
    const Window all = levels_of(context).array();
    return context.open<float>("levels", std::max(all.columns, 1), std::max(all.rows, 1));
}

void make_level(const BakeContext& context, int level, const Window& window, const LevelReader& read,
                const LevelWriter& write) {
    constexpr std::int32_t side = 512; // vertices at a time
    const HorizonLevels all = levels_of(context);
    const Window& finer = all.extents(level - 1);
    const std::int32_t across = (window.columns - 1) / side + 1, down = (window.rows - 1) / side + 1;
    parallel_for(std::int64_t{across} * down, context.threads, [&](std::int64_t i) {
        const std::int32_t x = static_cast<std::int32_t>(i % across) * side,
                           y = static_cast<std::int32_t>(i / across) * side;
        const Window at{window.x + x, window.y + y, std::min(side, window.columns - x),
                        std::min(side, window.rows - y)};
        const Window from = halved_from(finer, at);
        Buffer<float> had(from.area()), made(at.area());
        read(level - 1, from, had.data(), from.columns);
        halve_level(had.data(), from, finer, at, made.data());
        write(at, made.data());
    });
}

LevelReader levels_in(const BakeContext& context, const Store<float>& levels) {
    return [all = levels_of(context), &levels](int level, const Window& w, float* to, std::ptrdiff_t stride) {
        const Window place = all.place(level);
        levels.read(moved(w, place.x, place.y), to, stride);
    };
}

void make_levels(const BakeContext& context, const HeightStores& heights, Store<float>& levels) {
    const HorizonLevels all = levels_of(context);
    const LevelReader coarser = levels_in(context, levels);
    for (int level = 1; level < all.count(); ++level) {
        const Window place = all.place(level);
        make_level(
            context, level, all.extents(level),
            [&](int finer, const Window& w, float* to, std::ptrdiff_t stride) {
                if (finer == 0) return heights.heights.read(w, to, stride);
                coarser(finer, w, to, stride);
            },
            [&](const Window& at, const float* made) { levels.write(moved(at, place.x, place.y), made, at.columns); });
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
