// Stages that bring the heights in: read, fill, measure.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include "baker/bake/reader_pool.h"
#include "baker/bake/stages.h"
#include "baker/heights/fill.h"
#include "baker/store/parallel.h"

namespace fjell::baker {

namespace {

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
    const Coord last = tree.sample(region.last);
    const Window w{region.first.x, region.first.y, last.x - region.first.x + 1, last.y - region.first.y + 1};
    const StoreView<float> samples(heights.heights, w);
    HeightStatistics all;
    context.regions.for_each_tile(region, [&](std::uint32_t, Coord corner) {
        const Coord end = tree.sample({corner.x + tree.side(), corner.y + tree.side()});
        all.add(measure_tile(samples.row(corner.y - w.y) + (corner.x - w.x), end.x - corner.x + 1, end.y - corner.y + 1,
                             samples.stride()));
    });
    if (!heights.holes.exists()) return all;
    // Borders count where the region to the south or east does, and on the terrain's rim.
    const Window own{w.x, w.y, w.columns - (last.x + 1 < tree.columns()), w.rows - (last.y + 1 < tree.rows())};
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

} // namespace fjell::baker
