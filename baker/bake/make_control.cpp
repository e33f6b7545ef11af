// The stage that makes control maps: wetness of a coarse grid, where rules ask for it, then near mips tile by tile.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "baker/bake/stages.h"
#include "baker/maps/control.h"
#include "baker/maps/wetness.h"
#include "baker/store/parallel.h"

namespace fjell::baker {

namespace {

// Means of squares of samples, row of cells by row of cells: no more than a strip of samples is there at a time.
std::vector<float> coarse_heights(const BakeContext& context, const HeightStores& heights, const WetnessGrid& grid) {
    const Tree& tree = context.tree;
    const std::int32_t side = 1 << grid.factor_log2;
    std::vector<float> means(static_cast<std::size_t>(grid.columns) * static_cast<std::size_t>(grid.rows));
    parallel_for(grid.rows, context.threads, [&](std::int64_t row) {
        const auto y = static_cast<std::int32_t>(row) * side;
        std::vector<float> line(static_cast<std::size_t>(tree.columns()));
        std::vector<double> sums(static_cast<std::size_t>(grid.columns));
        const std::int32_t rows = std::min(side, tree.rows() - y);
        for (std::int32_t i = 0; i < rows; ++i) {
            heights.heights.read({0, y + i, tree.columns(), 1}, line.data(), tree.columns());
            for (std::size_t x = 0; x < line.size(); ++x) sums[x >> grid.factor_log2] += static_cast<double>(line[x]);
        }
        for (std::int32_t x = 0; x < grid.columns; ++x) {
            const std::int32_t wide = std::min(side, tree.columns() - x * side);
            means[static_cast<std::size_t>(row * grid.columns + x)] =
                static_cast<float>(sums[static_cast<std::size_t>(x)] / (static_cast<double>(wide) * rows));
        }
    });
    return means;
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

void make_near_control(const BakeContext& context, const BakePlan& plan, const HeightStores& heights,
                       const ControlOutput& out) {
    std::optional<Wetness> wetness;
    if (context.control.wants_wetness()) {
        const WetnessGrid grid = wetness_grid(context.tree.columns(), context.tree.rows(), context.source.spacing_m);
        wetness.emplace(grid, coarse_heights(context, heights, grid));
    }
    ControlGround ground{context.tree.columns(),
                         context.tree.rows(),
                         {1, 1},
                         plan.maps.stride_log2(MapKind::control),
                         wetness ? &*wetness : nullptr};
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
