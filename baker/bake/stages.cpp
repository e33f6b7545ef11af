#include "baker/bake/stages.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <xxhash.h>

#include "baker/errors/lock_errors.h"
#include "baker/errors/unsaturated.h"
#include "baker/heights/fill.h"
#include "baker/maps/horizon.h"
#include "baker/maps/image.h"
#include "baker/maps/splat.h"
#include "baker/maps/wetness.h"
#include "baker/pack/assemble.h"
#include "baker/pack/encode_page.h"
#include "baker/pack/notes.h"
#include "baker/store/parallel.h"
#include "fjell/version.h"
#include "io/file.h"
#include "shared/order.h"

namespace fjell::baker {

// Stages that bring the heights in: read, fill, measure.

namespace {

// Readers of a source that wait for a thread: opening one costs as much as reading a window.
// Source: HeightSource or ImageSource; null: all readers are null. Any thread may take and give.
template <typename Source, typename Reader>
class ReaderPool {
public:
    explicit ReaderPool(const Source* source) : source_(source) {}
    [[nodiscard]] std::unique_ptr<Reader> take() {
        if (!source_) return nullptr;
        const std::lock_guard hold(lock_);
        if (free_.empty()) return source_->reader();
        std::unique_ptr<Reader> reader = std::move(free_.back());
        free_.pop_back();
        return reader;
    }
    void give(std::unique_ptr<Reader> reader) {
        const std::lock_guard hold(lock_);
        if (reader) free_.push_back(std::move(reader));
    }

private:
    const Source* source_;
    std::mutex lock_;
    std::vector<std::unique_ptr<Reader>> free_;
};

void write_ground(const Window& w, const float* read, const HasGround& has_ground, Store<float>& heights) {
    constexpr std::int32_t side = 256;
    for (std::int32_t y = w.y; y < w.y + w.rows; y += side)
        for (std::int32_t x = w.x; x < w.x + w.columns; x += side) {
            const Window piece = common(w, {x, y, side, side});
            const float* const from = read + std::ptrdiff_t{y - w.y} * w.columns + (x - w.x);
            if (has_ground(piece, from, w.columns)) heights.write(piece, from, w.columns);
        }
}

} // namespace

ReadStatistics read_windows(const BakeContext& context, Store<float>& heights, const HasGround& has_ground) {
    constexpr std::size_t window_samples = std::size_t{1} << 20;
    std::vector<Window> windows = context.source.windows(window_samples);
    const Window own = context.sample_window();
    for (Window& w : windows) w = common(w, own);
    std::erase_if(windows, [](const Window& w) { return w.area() == 0; });
    std::size_t largest = 0;
    for (const Window& w : windows) largest = std::max(largest, w.area());
    ReadStatistics all;
    std::mutex adding;
    ReaderPool<HeightSource, HeightReader> readers(&context.source);
    const int workers =
        std::min(context.source.readers(context.threads), context.workers_for(largest * 2 * sizeof(float)));
    context.run_units({"read", windows.size(), workers, context.samples() / static_cast<double>(windows.size())},
                      [&](std::uint64_t i) {
                          const Window& w = windows[i];
                          std::unique_ptr<HeightReader> reader = readers.take();
                          ReadStatistics part;
                          if (heights.is_unwritten_void() && !reader->covers(w)) {
                              part.voids.add({w.area(), w.x, w.y});
                          } else {
                              Buffer<float> read(w.area());
                              reader->read(w, read.data(), part);
                              if (heights.is_unwritten_void())
                                  write_ground(w, read.data(), has_ground, heights);
                              else
                                  heights.write(w, read.data(), w.columns);
                          }
                          readers.give(std::move(reader));
                          const std::lock_guard hold(adding);
                          all.add(part);
                      });
    return all;
}

ReadResult read_result(const BakeContext& context, const ReadStatistics& all) {
    return {context.source.properties(all), all.voids.count + all.implausible.count > 0};
}

void mark_voids(const BakeContext& context, const Store<float>& raw, const Window& of, Store<std::uint8_t>& marks) {
    constexpr std::int32_t band = 64;
    parallel_for((of.rows - 1) / band + 1, context.threads, [&](std::int64_t i) {
        const auto y = static_cast<std::int32_t>(i) * band;
        const Window w{of.x, of.y + y, of.columns, std::min(band, of.rows - y)};
        std::vector<float> heights(w.area());
        std::vector<std::uint8_t> voids(w.area());
        raw.read(w, heights.data(), w.columns);
        std::transform(heights.begin(), heights.end(), voids.begin(),
                       [](float h) { return static_cast<std::uint8_t>(std::isnan(h)); });
        marks.write(w, voids.data(), w.columns);
    });
}

void fill_heights(const BakeContext& context, const Store<float>& raw, const SourceProperties& properties,
                  const FilledStores& out) {
    if (context.options.progress) context.options.progress("fill", 0, 1);
    if (out.marks.exists()) mark_voids(context, raw, context.sample_window(), out.marks);
    fill_voids({raw,
                {properties.native_quantum_m, properties.anchor_m},
                context.workers_for(fill_piece_bytes),
                [&](const std::string& name, std::int64_t columns, std::int64_t rows) {
                    return context.open<float>(name, columns, rows);
                }},
               out.heights);
}

namespace {

HeightStatistics measure_region(const BakeContext& context, const HeightStores& heights, const Region& region) {
    const Tree& tree = context.tree;
    const SampleIndex last = tree.sample(region.last);
    const Window w{region.first.column, region.first.row, last.column - region.first.column + 1,
                   last.row - region.first.row + 1};
    const StoreView<float> samples(heights.heights, w);
    HeightStatistics all;
    context.regions.for_each_tile(region, [&](std::uint32_t, SampleIndex corner) {
        const SampleIndex end = tree.sample({corner.column + tree.side(), corner.row + tree.side()});
        all.add(measure_tile(samples.row(corner.row - w.y) + (corner.column - w.x), end.column - corner.column + 1,
                             end.row - corner.row + 1, samples.stride()));
    });
    if (!heights.holes.exists()) return all;
    // Borders count where the region to the south or east does, and on the terrain's rim.
    const Window own{w.x, w.y, w.columns - (last.column + 1 < tree.columns()), w.rows - (last.row + 1 < tree.rows())};
    std::vector<std::uint8_t> voids(own.area());
    heights.holes.read(own, voids.data(), own.columns);
    all.voids = static_cast<std::uint64_t>(std::count(voids.begin(), voids.end(), std::uint8_t{1}));
    return all;
}

} // namespace

HeightStatistics measure_heights(const BakeContext& context, const HeightStores& heights) {
    std::vector<HeightStatistics> parts(context.region_count());
    const double side = context.regions.cells() + 1.0;
    context.run_units({"measure", parts.size(), context.workers_for(static_cast<std::uint64_t>(side * side * 5)),
                       context.samples() / static_cast<double>(parts.size())},
                      [&](std::uint64_t i) {
                          parts[i] = measure_region(context, heights, context.regions.at(context.region_at(i)));
                      });
    HeightStatistics all;
    for (const HeightStatistics& part : parts) all.add(part);
    return all;
}

// Stages that make materials: near mips tile by tile from the heights, then mip by mip from the texels of the one
// before.

namespace {

ChunkKind chunk_of(MapKind kind) {
    constexpr ChunkKind chunks[map_kind_count] = {ChunkKind::colour, ChunkKind::normal, ChunkKind::horizon,
                                                  ChunkKind::splat};
    return chunks[static_cast<std::size_t>(kind)];
}

// The window of a store whose elements are channels of texels.
Window in_channels(const Window& w, MapKind kind) {
    const auto n = static_cast<std::int32_t>(channels(kind));
    return {w.x * n, w.y, w.columns * n, w.rows};
}

} // namespace

void store_texels(TexelStore& store, const Window& at, MapKind kind, const Texels& texels) {
    const Window w = in_channels(at, kind);
    store.write(w, texels.data(), w.columns);
}

TexelStore open_texels(const BakeContext& context, const MapPlan& maps, MapKind kind, std::uint32_t mip) {
    const Window grid = maps.grid(kind, mip);
    constexpr const char* names[map_kind_count] = {"colour", "normal", "horizon", "splat"};
    return context.open<std::uint16_t>(names[static_cast<std::size_t>(kind)] + std::to_string(mip),
                                       std::int64_t{grid.columns} * static_cast<std::int64_t>(channels(kind)),
                                       grid.rows);
}

namespace {

// Of heights around a tile, of squares of them, and of the surface.
double smooth_bytes(const MapPlan& maps) {
    const double around = maps.tree.side() + 240.0;
    return maps.smooth.smooths() ? around * around * 12 : 0;
}

} // namespace

void make_near_maps(const BakeContext& context, const BakePlan& plan, const HeightStores& heights,
                    const NearMapsOutput& out) {
    const double places = context.tree.side() + 32.0, texels = static_cast<double>(1u << plan.maps.colour_log2);
    // Heights, and texels of both maps on their way from floats to blocks.
    const auto tile_bytes =
        static_cast<std::uint64_t>(places * places * 20 + texels * texels * 24 + smooth_bytes(plan.maps)) +
        (std::uint64_t{2} << 20);
    ReaderPool<ImageSource, ImageReader> readers(context.image.get());
    context.run_units(
        {"maps", context.tile_count(), context.workers_for(tile_bytes),
         context.samples() / static_cast<double>(context.tile_count())},
        [&](std::uint64_t u) {
            const std::uint32_t tile = context.tile_at(u);
            const Window w = heights_for_maps(plan.maps, tile);
            std::optional<StoreView<float>> heights_m(std::in_place, heights.heights, w);
            std::unique_ptr<ImageReader> reader = readers.take();
            const NearMaps near = near_maps(plan.maps, tile, {heights_m->row(0), heights_m->stride(), w}, reader.get());
            readers.give(std::move(reader));
            heights_m.reset();
            ChunkBatch batch;
            for (const MapKind kind : {MapKind::colour, MapKind::normal}) {
                const std::vector<MipTexels>& mips = kind == MapKind::colour ? near.colour : near.normal;
                for (std::uint32_t mip = 0; mip < mips.size(); ++mip)
                    batch.add({chunk_of(kind), tile, mip}, mips[mip].blocks, context.options.compression);
                TexelStore& last = kind == MapKind::colour ? out.colour : out.normal;
                if (last.exists())
                    store_texels(last, plan.maps.texels(kind, near_mips - 1, tile), kind, mips.back().texels);
            }
            out.spool.append(std::move(batch));
        });
}

void make_far_mip(const BakeContext& context, const BakePlan& plan, const FarMipInput& in, const FarMipOutput& out) {
    // Tiles are small by now: many at once, as many as a row has.
    const auto across = static_cast<std::uint64_t>(context.tile_window().columns);
    const std::uint64_t tiles = context.tile_count(), rows = (tiles + across - 1) / across;
    context.run_units({"mips", rows, context.threads, static_cast<double>(across)}, [&](std::uint64_t row) {
        ChunkBatch batch;
        for (std::uint64_t u = row * across; u < std::min(tiles, (row + 1) * across); ++u) {
            const std::uint32_t tile = context.tile_at(u);
            const Window stored = in_channels(finer_texels(plan.maps, in.kind, in.mip, tile), in.kind);
            Texels finer(stored.area());
            in.finer.read(stored, finer.data(), stored.columns);
            const MipTexels made = far_mip(plan.maps, in.kind, in.mip, tile, finer);
            batch.add({chunk_of(in.kind), tile, in.mip}, made.blocks, context.options.compression);
            if (out.texels.exists())
                store_texels(out.texels, plan.maps.texels(in.kind, in.mip, tile), in.kind, made.texels);
        }
        out.spool.append(std::move(batch));
    });
}

// Stages that make horizon maps: levels of ever fewer heights, then near mips tile by tile from a window of each.

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

// The stage that makes splat maps: wetness of a coarse grid, where rules ask for it, then near mips tile by tile.

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
    explicit ReaderSets(const SplatImages& images) : images_(images) {}
    [[nodiscard]] SplatReaders take() {
        const std::lock_guard hold(lock_);
        SplatReaders readers;
        if (free_.empty()) {
            for (const auto& image : images_) readers.push_back(image->reader());
            return readers;
        }
        readers = std::move(free_.back());
        free_.pop_back();
        return readers;
    }
    void give(SplatReaders readers) {
        const std::lock_guard hold(lock_);
        free_.push_back(std::move(readers));
    }

private:
    const SplatImages& images_;
    std::mutex lock_;
    std::vector<SplatReaders> free_;
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

SplatGround splat_ground(const BakeContext& context, const BakePlan& plan, const Wetness* wetness) {
    SplatGround ground{
        context.tree.columns(), context.tree.rows(), {1, 1}, plan.maps.stride_log2(MapKind::splat), wetness,
        plan.maps.smooth};
    std::copy_n(context.source.spacing_m, 2, ground.spacing_m);
    return ground;
}

void make_near_splat(const BakeContext& context, const BakePlan& plan, const HeightStores& heights,
                     const Wetness* wetness, const SplatOutput& out) {
    const SplatGround ground = splat_ground(context, plan, wetness);
    // Shares of points, of each raster too, texels of them and of their mips; heights; strips of pixels.
    const double points = std::ldexp(context.tree.side(), -ground.stride_log2) + 40,
                 samples = context.tree.side() + 120.0;
    const auto rasters = static_cast<double>(context.splat.rasters.size());
    const auto tile_bytes = static_cast<std::uint64_t>(points * points * max_splat_names * (10 + 4 * rasters) +
                                                       samples * samples * 4 + smooth_bytes(plan.maps)) +
                            (std::uint64_t{6} << 20);
    ReaderSets sets(context.splat_images);
    const auto make_tile = [&](std::uint64_t u) {
        const std::uint32_t tile = context.tile_at(u);
        const Window at = points_for_map(plan.maps, MapKind::splat, tile);
        const Window seen = heights_for_splat(ground, at);
        Buffer<float> heights_m(seen.area());
        heights.heights.read(seen, heights_m.data(), seen.columns);
        SplatReaders readers = sets.take();
        const TexelPlanes shares =
            splat_shares(context.splat, ground, at, {heights_m.data(), context.splat_images, readers});
        sets.give(std::move(readers));
        heights_m = {};
        const std::vector<MipTexels> mips = near_mips_from(plan.maps, MapKind::splat, tile, shares);
        ChunkBatch batch;
        for (std::uint32_t mip = 0; mip < mips.size(); ++mip)
            batch.add({ChunkKind::splat, tile, mip}, mips[mip].blocks, context.options.compression);
        if (out.texels.exists())
            store_texels(out.texels, plan.maps.texels(MapKind::splat, near_mips - 1, tile), MapKind::splat,
                         mips.back().texels);
        out.spool.append(std::move(batch));
    };
    context.run_units({"splat maps", context.tile_count(), context.workers_for(tile_bytes),
                       context.samples() / static_cast<double>(context.tile_count())},
                      make_tile);
}

// Stages that make errors, radii and pages: the finest step with the heights at hand, then step by step to the roots.

namespace {

// A region's part of a step.
struct StepExtents {
    SampleIndex square; // the first one
    std::int32_t nx, ny;
};
StepExtents extents_of(const Region& region, int z) {
    return {{region.first.column >> (z + 1), region.first.row >> (z + 1)},
            (region.last.column - region.first.column) >> (z + 1),
            (region.last.row - region.first.row) >> (z + 1)};
}

// What a region takes at its largest: its patch, split into planes, with codes, and the finer centres.
std::uint64_t region_bytes(const BakeContext& context, int z) {
    const double places = (context.regions.cells() >> z) + 16.0;
    const double finest = context.locks.empty() ? 16 : 16 + 3.0 * sizeof(LockCodes);
    return static_cast<std::uint64_t>(places * places * (z == 0 ? finest : 40)) + (std::uint64_t{1} << 20);
}

UnitLoop loop_over_regions(const BakeContext& context, const char* name, int z) {
    const std::uint64_t count = context.region_count();
    return {name, count, context.workers_for(region_bytes(context, z)),
            context.samples() / static_cast<double>(count) / (1 << (2 * z))};
}

std::uint8_t largest(const VertexPlane<std::uint8_t>& plane, std::int32_t columns, std::int32_t rows) {
    std::uint8_t most = 0;
    for (std::int32_t j = 0; j < rows; ++j)
        for (std::int32_t i = 0; i < columns; ++i) most = std::max(most, plane.row(j)[i]);
    return most;
}

// Vertices of the finest step at the rim and beside holes, one by one. Returns the step's largest error on the ground.
std::uint8_t correct_leaves(const BakeContext& context, const BakePlan& plan, const QuantisedHeights& heights,
                            const StepInput& step) {
    const Tree& tree = context.tree;
    const Region all = {{0, 0}, {tree.grid_columns() - 1, tree.grid_rows() - 1}};
    const UnsaturatedInput input{heights,
                                 all,
                                 plan.scales,
                                 plan.leaf,
                                 context.options.estimate,
                                 {context.source.spacing_m[0], context.source.spacing_m[1]}};
    const bool rim = straddles_rim(tree, {2 * (step.square.column + step.nx) + 1, 1}) ||
                     straddles_rim(tree, {1, 2 * (step.square.row + step.ny) + 1});
    if (!rim && !heights.has_voids())
        return std::max({largest(step.error.side_x, step.nx, step.ny + 1),
                         largest(step.error.side_y, step.nx + 1, step.ny),
                         largest(step.error.centre, step.nx, step.ny)});
    std::uint8_t worst = 0;
    const auto correct = [&](VertexPlane<std::uint8_t>& plane, std::int32_t columns, std::int32_t rows,
                             SampleIndex offset) {
        for (std::int32_t j = 0; j < rows; ++j)
            for (std::int32_t i = 0; i < columns; ++i) {
                const SampleIndex v{2 * (step.square.column + i) + offset.column,
                                    2 * (step.square.row + j) + offset.row};
                bool irregular = straddles_rim(tree, v);
                for (std::int32_t y = v.row - 1; !irregular && heights.has_voids() && y <= v.row + 1; ++y)
                    for (std::int32_t x = v.column - 1; x <= v.column + 1; ++x)
                        irregular = irregular || heights.is_void({x, y});
                UnsaturatedError e{plane.row(j)[i], plane.row(j)[i]};
                if (irregular) e = unsaturated_error(input, v);
                plane.row(j)[i] = e.code;
                worst = std::max(worst, e.on_ground);
            }
    };
    correct(step.error.side_x, step.nx, step.ny + 1, {1, 0});
    correct(step.error.side_y, step.nx + 1, step.ny, {0, 1});
    correct(step.error.centre, step.nx, step.ny, {1, 1});
    return worst;
}

// The pages that hold nothing but this step; none in linear order and of steps that are smaller than a page.
void append_pages(const BakeContext& context, const BakePlan& plan, const StepResult& result, ChunkSink& spool) {
    const StepInput& in = result.step;
    const std::int32_t n = context.tree.side() >> (in.z + 1); // squares of a tile
    if (context.options.order == PageOrder::linear || n < static_cast<std::int32_t>(page_squares)) return;
    ChunkBatch batch;
    context.regions.for_each_tile(result.region, [&](std::uint32_t tile, SampleIndex corner) {
        const std::int32_t i0 = (corner.column >> (in.z + 1)) - in.square.column,
                           j0 = (corner.row >> (in.z + 1)) - in.square.row;
        const auto pages = static_cast<std::uint32_t>(n) / page_squares;
        for (std::uint32_t py = 0; py < pages; ++py)
            for (std::uint32_t px = 0; px < pages; ++px) {
                const StepPageInput input{in.steps,
                                          in.error,
                                          result.holes,
                                          result.radii,
                                          i0 + static_cast<std::int32_t>(px * page_squares),
                                          j0 + static_cast<std::int32_t>(py * page_squares),
                                          in.z == 0 ? &plan.leaf : nullptr,
                                          plan.scales.errors,
                                          plan.header,
                                          in.z};
                const EncodedPage page = encode_step_page(input);
                batch.add_page({ChunkKind::geometry, tile, context.pages.page_at(in.z, px, py)}, page);
            }
    });
    spool.append(std::move(batch));
}

struct StepOutput {
    StepStores& step;
    MixedStores& mixed;
    ChunkSink& spool;
};

// From unsaturated errors to what a step leaves. Returns how many vertices locks keep in every mesh.
std::uint64_t finish_step(const BakeContext& context, const BakePlan& plan, const Region& region, const StepInput& step,
                          const VertexPlanes<std::uint8_t>* holes, const StepOutput& out) {
    saturate_errors(step);
    Radii radii;
    nest_radii(step, radii);
    const StepResult result{region, step, radii, holes};
    append_pages(context, plan, result, out.spool);
    if (out.step.exist()) store_step(result, out.step);
    if (step.z >= context.mixed_log2) store_mixed(result, context.mixed_log2, out.mixed);
    return context.locks.in_metres() ? always_drawn(step) : 0;
}

} // namespace

FinestStepResult make_finest_step(const BakeContext& context, const BakePlan& plan, const HeightStores& heights,
                                  const FinestStepOutput& out) {
    const double spacing_m[2] = {context.source.spacing_m[0], context.source.spacing_m[1]};
    std::vector<std::uint8_t> worst(context.region_count());
    std::atomic<std::uint64_t> always = 0;
    std::atomic<bool> on_scale = true;
    context.run_units(loop_over_regions(context, "errors", 0), [&](std::uint64_t u) {
        const std::int64_t index = context.region_at(u);
        const Region region = context.regions.at(index);
        const auto [square, nx, ny] = extents_of(region, 0);
        std::optional<QuantisedHeights> ground = load_heights(context, plan.height_scale, heights, region);
        VertexPlanes<std::int32_t> steps(nx, ny);
        if (!ground->on_scale) on_scale = false;
        split_planes(ground->steps, steps);
        VertexPlanes<std::uint8_t> error(nx, ny), holes;
        const StepInput step{plan.scales, context.tree, {spacing_m[0], spacing_m[1]}, 0, square, nx, ny, steps, error};
        leaf_errors(step, plan.leaf);
        worst[u] = correct_leaves(context, plan, *ground, step);
        Patch<std::uint8_t> errors;
        const bool coarser = out.unsaturated.inside.exists();
        if (coarser) {
            const std::uint8_t of_coarser = unsaturated_errors(
                {*ground, region, plan.scales, plan.leaf, context.options.estimate, {spacing_m[0], spacing_m[1]}},
                errors);
            worst[u] = std::max(worst[u], of_coarser);
        }
        if (!context.locks.empty())
            raise_locked({context.locks, plan.scales, context.tree, region}, error, coarser ? &errors : nullptr);
        if (coarser) store_unsaturated(context, index, errors, out.unsaturated);
        errors = {};
        const bool has_holes = ground->has_voids();
        if (has_holes) {
            holes = VertexPlanes<std::uint8_t>(nx, ny);
            split_planes(ground->voids, holes);
        }
        ground.reset(); // the largest of what a region takes
        always +=
            finish_step(context, plan, region, step, has_holes ? &holes : nullptr, {out.step, out.mixed, out.spool});
    });
    return {plan.scales.errors.metres[*std::max_element(worst.begin(), worst.end())], always, on_scale};
}

void measure_unsaturated(const BakeContext& context, const BakePlan& plan, const HeightStores& heights,
                         UnsaturatedStores& out) {
    context.run_units(loop_over_regions(context, "errors", 0), [&](std::uint64_t u) {
        const std::int64_t index = context.region_at(u);
        const Region region = context.regions.at(index);
        const QuantisedHeights ground = load_heights(context, plan.height_scale, heights, region);
        Patch<std::uint8_t> errors;
        (void)unsaturated_errors({ground,
                                  region,
                                  plan.scales,
                                  plan.leaf,
                                  context.options.estimate,
                                  {context.source.spacing_m[0], context.source.spacing_m[1]}},
                                 errors);
        store_unsaturated(context, index, errors, out);
    });
}

std::uint64_t make_coarser_step(const BakeContext& context, const BakePlan& plan, const CoarserStepInput& in,
                                const CoarserStepOutput& out) {
    std::atomic<std::uint64_t> always = 0;
    context.run_units(loop_over_regions(context, "steps", in.z), [&](std::uint64_t u) {
        const std::int64_t index = context.region_at(u);
        const Region region = context.regions.at(index);
        const auto [square, nx, ny] = extents_of(region, in.z);
        VertexPlanes<std::int32_t> steps(nx, ny);
        VertexPlanes<std::uint8_t> error(nx, ny), holes;
        if (in.holes) holes = VertexPlanes<std::uint8_t>(nx, ny);
        load_unsaturated(context, in.unsaturated, index, in.z, error);
        FinerCentres finer(nx, ny);
        const FinerInput from_finer{steps, in.holes ? &holes : nullptr, finer};
        if (in.finer.codes.exists())
            load_finest(context, in.finer, *in.heights, region, plan.scales, from_finer);
        else
            load_finer(in.finer, region, in.z, context.tree.tile_log2, plan.scales, from_finer);
        const StepInput step{plan.scales, context.tree, {context.source.spacing_m[0], context.source.spacing_m[1]},
                             in.z,        square,       nx,
                             ny,          steps,        error,
                             &finer};
        always +=
            finish_step(context, plan, region, step, in.holes ? &holes : nullptr, {out.step, out.mixed, out.spool});
    });
    return always;
}

namespace {

void append_corners(const BakeContext& context, const BakePlan& plan, const MixedStores& mixed, ChunkSink& spool) {
    const auto columns = static_cast<std::int32_t>(mixed.heights.columns());
    std::vector<std::uint32_t> corners, row(static_cast<std::size_t>(columns));
    const std::int32_t step = context.tree.side() >> context.mixed_log2;
    for (std::int32_t y = 0; y < mixed.heights.rows(); y += step) {
        mixed.heights.read({0, y, columns, 1}, row.data(), columns);
        for (std::size_t x = 0; x < row.size(); x += static_cast<std::size_t>(step))
            corners.push_back((row[x] & ~hole_flag) | (row[x] & hole_flag ? corner_void_bit : 0));
    }
    ChunkBatch batch;
    batch.add({ChunkKind::corners, 0, 0}, std::as_bytes(std::span(corners)), context.options.compression);
    const std::string layers = context.splat.stored_names();
    if (!layers.empty())
        batch.add({ChunkKind::layers, 0, 0}, std::as_bytes(std::span(layers)), context.options.compression);
    if (plan.header.crs_bytes)
        batch.add({ChunkKind::crs, 0, 0}, std::as_bytes(std::span(context.source.crs_wkt)),
                  context.options.compression);
    spool.append(std::move(batch));
}

} // namespace

float make_mixed_pages(const BakeContext& context, const BakePlan& plan, const MixedStores& mixed, ChunkSink& spool) {
    const Tree& tree = context.tree;
    const int z = context.mixed_log2;
    const std::uint32_t pages = context.options.order == PageOrder::linear ? context.pages.pages_per_tile() : 1;
    const std::int32_t places = (tree.side() >> z) + 1; // of a tile, a side
    const std::uint64_t place_count = static_cast<std::uint64_t>(places) * static_cast<std::uint64_t>(places);
    std::vector<std::uint8_t> worst(context.tile_count(), 0);
    context.run_units(
        {"root pages", context.tile_count(), context.workers_for(place_count * 8), static_cast<double>(place_count)},
        [&](std::uint64_t u) {
            const std::uint32_t tile = context.tile_at(u);
            const auto t = static_cast<std::int32_t>(tile);
            const Window w{t % tree.tiles_x * (places - 1), t / tree.tiles_x * (places - 1), places, places};
            std::vector<std::uint16_t> records(w.area());
            std::vector<std::uint32_t> steps(w.area());
            mixed.records.read(w, records.data(), places);
            mixed.heights.read(w, steps.data(), places);
            const auto vertex = [&](SampleIndex c) {
                const std::size_t at = static_cast<std::size_t>(c.row >> z) * static_cast<std::size_t>(places) +
                                       static_cast<std::size_t>(c.column >> z);
                const bool corner = ((c.column | c.row) & (tree.side() - 1)) == 0;
                const auto error = static_cast<std::uint8_t>(corner ? 0 : records[at] & 0xff);
                const auto hole = static_cast<std::uint8_t>(steps[at] & hole_flag ? void_bit : 0);
                const auto radius = static_cast<std::uint8_t>(corner ? 0 : records[at] >> 8 & ~void_bit);
                return MixedPageVertex{static_cast<std::int32_t>(steps[at] & ~hole_flag), error,
                                       static_cast<std::uint8_t>(radius | hole)};
            };
            for (const std::uint16_t r : records) worst[u] = std::max(worst[u], static_cast<std::uint8_t>(r & 0xff));
            ChunkBatch batch;
            for (std::uint32_t page = 0; page < pages; ++page) {
                const EncodedPage encoded = encode_mixed_page(plan.header, page, vertex);
                batch.add_page({ChunkKind::geometry, tile, page}, encoded);
            }
            spool.append(std::move(batch));
        });
    append_corners(context, plan, mixed, spool);
    return plan.scales.errors.metres[*std::max_element(worst.begin(), worst.end())];
}

// The last stage: the pack's chunks, in the order in which a reader wants them.

std::string notes_of(const BakeContext& context, const BakeSummary& summary) {
    PackNotes notes{context.options.reading, context.source.facts,   summary.images,
                    summary.locks,           summary.ground_error_m, {}};
    // With holes the bounds are also of what fills them, which not every way to bake the same pack has made.
    if (summary.voids == 0)
        notes.baked = BakedWith{options_hash(context), summary.heights, summary.on_scale, summary.smooth,
                                context.source.paint() != nullptr};
    return notes_text(notes);
}

std::uint64_t options_hash(const BakeContext& context) {
    const std::string all = fmt::format("fjell {}\n{}", FJELL_VERSION_STRING, context.options_identity());
    return XXH3_64bits(all.data(), all.size());
}

void count_bytes(const PackHeader& header, const std::vector<ChunkEntry>& entries, BakeSummary& summary) {
    const std::uint64_t tiles = std::uint64_t{header.tiles_x} * header.tiles_y;
    const std::uint64_t maps = 1 + tiles * pages_of(header).pages_per_tile(); // the corners before them
    for (std::uint64_t i = 0; i < entries.size(); ++i) {
        const ChunkKind kind = chunk_id(header, i).kind;
        if (kind == ChunkKind::crs || kind == ChunkKind::layers) continue;
        (i < maps ? summary.geometry_bytes : summary.texture_bytes) += entries[i].stored_bytes;
        if (kind == ChunkKind::horizon) summary.horizon_bytes += entries[i].stored_bytes;
        if (kind == ChunkKind::splat) summary.splat_bytes += entries[i].stored_bytes;
    }
    summary.directory_bytes = maps * sizeof(ChunkEntry) + sizeof(PackHeader);
}

void write_pack(const BakeContext& context, const PackHeader& header, const ChunkSource& chunks, BakeSummary& summary) {
    const std::vector<ChunkId> sequence = chunk_sequence(header);
    io::AtomicFile out(context.out_path, context.temporary());
    const Progress& progress = context.options.progress;
    (void)assemble_pack(header, chunks, sequence, notes_of(context, summary), out, [&](std::uint64_t n) {
        if (progress) progress("write", n, sequence.size());
    });
    summary.file_bytes = out.size();
    count_bytes(header, chunks.entries(), summary);
    out.commit();
}

} // namespace fjell::baker
