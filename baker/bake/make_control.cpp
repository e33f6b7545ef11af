// The stage that makes control maps: wetness of a coarse grid, where rules ask for it, then near mips tile by tile.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <mutex>
#include <utility>
#include <vector>

#include "baker/bake/stages.h"
#include "baker/maps/control.h"
#include "baker/maps/wetness.h"
#include "baker/store/parallel.h"

namespace fjell::baker {

namespace {

WetnessGrid grid_of(const BakeContext& context) {
    return wetness_grid(context.tree.columns(), context.tree.rows(), context.source.spacing_m);
}

// Of squares that a cell consists of: as large as it, or as large as the least region, which is one shard's.
int square_log2(const WetnessGrid& grid) {
    return std::min(grid.factor_log2, 8);
}

// Readers of all rasters, opened once a thread.
class ReaderSets {
public:
    explicit ReaderSets(const ControlImages& images) : images_(images) {}
    [[nodiscard]] ControlReaders take() {
        const std::lock_guard hold(lock_);
        ControlReaders readers;
        if (free_.empty()) {
            for (const auto& image : images_) readers.push_back(image->reader());
            return readers;
        }
        readers = std::move(free_.back());
        free_.pop_back();
        return readers;
    }
    void give(ControlReaders readers) {
        const std::lock_guard hold(lock_);
        free_.push_back(std::move(readers));
    }

private:
    const ControlImages& images_;
    std::mutex lock_;
    std::vector<ControlReaders> free_;
};

} // namespace

// Row of squares by row of squares: no more than a strip of samples is there at a time.
SquareSums sum_squares(const BakeContext& context, const Store<float>& heights) {
    const int log2 = square_log2(grid_of(context));
    const std::int32_t side = 1 << log2;
    const Window own = context.sample_window(); // begins where a square does
    SquareSums all{{own.x >> log2, own.y >> log2, ((own.columns - 1) >> log2) + 1, ((own.rows - 1) >> log2) + 1}, {}};
    all.sums.assign(all.at.area(), 0);
    parallel_for(all.at.rows, context.threads, [&](std::int64_t row) {
        const auto y = static_cast<std::int32_t>(row) * side;
        std::vector<float> line(static_cast<std::size_t>(own.columns));
        double* const sums = all.sums.data() + row * all.at.columns;
        const std::int32_t rows = std::min(side, own.rows - y);
        for (std::int32_t i = 0; i < rows; ++i) {
            heights.read({own.x, own.y + y + i, own.columns, 1}, line.data(), own.columns);
            for (std::size_t x = 0; x < line.size(); ++x) sums[x >> log2] += static_cast<double>(line[x]);
        }
    });
    return all;
}

Wetness make_wetness(const BakeContext& context, const SquareSums& all) {
    const WetnessGrid grid = grid_of(context);
    const int shift = grid.factor_log2 - square_log2(grid);
    std::vector<double> sums(static_cast<std::size_t>(grid.columns) * static_cast<std::size_t>(grid.rows));
    const double* from = all.sums.data();
    for (std::int32_t y = 0; y < all.at.rows; ++y)
        for (std::int32_t x = 0; x < all.at.columns; ++x)
            sums[static_cast<std::size_t>(y >> shift) * static_cast<std::size_t>(grid.columns) +
                 static_cast<std::size_t>(x >> shift)] += *from++;
    std::vector<float> means(sums.size());
    const auto extent = [&](std::int32_t cell, std::int32_t samples) {
        return std::min(1 << grid.factor_log2, samples - (cell << grid.factor_log2));
    };
    for (std::size_t i = 0; i < sums.size(); ++i) {
        const auto x = static_cast<std::int32_t>(i % static_cast<std::size_t>(grid.columns)),
                   y = static_cast<std::int32_t>(i / static_cast<std::size_t>(grid.columns));
        means[i] = static_cast<float>(
            sums[i] / (static_cast<double>(extent(x, context.tree.columns())) * extent(y, context.tree.rows())));
    }
    return {grid, std::move(means)};
}

Wetness found_wetness(const BakeContext& context, std::vector<float> index) {
    return Wetness::found(grid_of(context), std::move(index));
}

void make_near_control(const BakeContext& context, const BakePlan& plan, const HeightStores& heights,
                       const Wetness* wetness, const ControlOutput& out) {
    ControlGround ground{
        context.tree.columns(), context.tree.rows(), {1, 1}, plan.maps.stride_log2(MapKind::control), wetness};
    std::copy_n(context.source.spacing_m, 2, ground.spacing_m);
    // Shares of points, of each raster too, texels of them and of their mips; heights; strips of pixels.
    const double points = std::ldexp(context.tree.side(), -ground.stride_log2) + 40,
                 samples = context.tree.side() + 120.0;
    const auto rasters = static_cast<double>(context.control.rasters.size());
    const auto tile_bytes =
        static_cast<std::uint64_t>(points * points * max_control_names * (10 + 4 * rasters) + samples * samples * 4) +
        (std::uint64_t{6} << 20);
    ReaderSets sets(context.control_images);
    const auto make_tile = [&](std::uint64_t u) {
        const std::uint32_t tile = context.tile_at(u);
        const Window at = points_for_map(plan.maps, MapKind::control, tile);
        const Window seen = heights_for_control(ground, at);
        Buffer<float> heights_m(seen.area());
        heights.heights.read(seen, heights_m.data(), seen.columns);
        ControlReaders readers = sets.take();
        const TexelPlanes shares =
            control_shares(context.control, ground, at, {heights_m.data(), context.control_images, readers});
        sets.give(std::move(readers));
        heights_m = {};
        const std::vector<MipTexels> mips = near_mips_from(plan.maps, MapKind::control, tile, shares);
        ChunkBatch batch;
        for (std::uint32_t mip = 0; mip < mips.size(); ++mip)
            batch.add({ChunkKind::control, tile, mip}, mips[mip].blocks, context.options.compression);
        if (out.texels.exists())
            store_texels(out.texels, plan.maps.texels(MapKind::control, near_mips - 1, tile), MapKind::control,
                         mips.back().texels);
        out.spool.append(std::move(batch));
    };
    context.run_units({"control maps", context.tile_count(), context.workers_for(tile_bytes),
                       context.samples() / static_cast<double>(context.tile_count())},
                      make_tile);
}

} // namespace fjell::baker
