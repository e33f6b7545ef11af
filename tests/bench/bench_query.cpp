// What a height, a ray and a collider patch cost, beside the plain way to a height: TerrainData::ground_m(), which
// reads the four samples around a place and needs all their pages. And what publication costs whoever loads pages.
//
// Names: query/scene/what. Scene: the mountains of content/terrain (4097 x 4097, 60 m), tiles of 512 cells.
#include <benchmark/benchmark.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "baker/bake/bake.h"
#include "fjell/io/load.h"
#include "fjell/query.h"
#include "shared/terrain_data.h"
#include "support/dem.h"
#include "support/times.h"

namespace {

using namespace fjell;
using test::worked_us;

const std::string recipe = FJELL_SOURCE_DIR "/content/terrain/mountains.json";

// Baked once a build folder, as bench_recursive does, and shared with it.
std::string pack_path() {
    const std::string folder = FJELL_BENCH_DIR;
    std::filesystem::create_directories(folder);
    const std::string path = folder + "/mountains-512-planar-" + std::to_string(pack_layout_hash) + ".fjell";
    if (std::filesystem::exists(path) &&
        std::filesystem::last_write_time(path) > std::filesystem::last_write_time(recipe))
        return path;
    baker::BakeOptions options;
    options.tile_log2 = 9;
    options.max_texture_log2 = 4;
    (void)baker::bake(baker::synthesise(recipe), options, path);
    return path;
}

const io::LoadedPack& scene() {
    static const io::LoadedPack pack = io::load_pack(pack_path(), io::LoadTerrain::yes);
    return pack;
}

struct Place {
    double x, z;
};
// All over the terrain, or one third of a cell after the other, as something that walks does.
std::vector<Place> places(bool coherent) {
    const Terrain& t = scene().terrain;
    const double cell = t.header().spacing_m[0], width = cell * (data_of(t).tree.columns() - 1);
    std::mt19937 random(1);
    std::uniform_real_distribution<double> any(0.05 * width, 0.95 * width);
    std::vector<Place> out(1 << 14);
    Place at{any(random), any(random)};
    for (Place& p : out) {
        p = coherent ? at : Place{any(random), any(random)};
        at = {at.x + 0.2 * cell, at.z + 0.26 * cell};
        if (at.x > 0.95 * width || at.z > 0.95 * width) at = {any(random), any(random)};
    }
    return out;
}

void height(benchmark::State& state, bool coherent, float accurate_m) {
    const Terrain& t = scene().terrain;
    const std::vector<Place> at = places(coherent);
    std::size_t i = 0;
    for (auto _ : state) {
        benchmark::DoNotOptimize(ground_height(t, at[i].x, at[i].z, accurate_m).height_m);
        i = (i + 1) % at.size();
    }
}
void plain_height(benchmark::State& state, bool coherent) {
    const Terrain& t = scene().terrain;
    const std::vector<Place> at = places(coherent);
    std::size_t i = 0;
    for (auto _ : state) {
        benchmark::DoNotOptimize(data_of(t).ground_m(at[i].x, at[i].z));
        i = (i + 1) % at.size();
    }
}

// As many threads as a server has, while another one takes pages of step 1 out and in again, some thousand a second. A
// thread's rate is by its own CPU time: machines have fewer cores.
void heights_while_streaming(benchmark::State& state, bool coherent) {
    constexpr int threads = 8;
    constexpr std::uint32_t finest = 64; // the last pages of a tile
    const io::LoadedPack& pack = scene();
    const Terrain& t = pack.terrain;
    const std::vector<Place> at = places(coherent);
    double heights_per_s = 0, loads = 0;
    for (auto _ : state) {
        std::atomic<bool> stop{false};
        std::vector<double> rates(threads);
        std::vector<std::thread> all;
        for (int thread = 0; thread < threads; ++thread)
            all.emplace_back([&, thread] {
                const double start_us = worked_us();
                std::size_t count = 0, i = at.size() / threads * static_cast<std::size_t>(thread);
                while (!stop.load(std::memory_order_relaxed))
                    for (int some = 0; some < 256; ++some, ++count, i = (i + 1) % at.size())
                        benchmark::DoNotOptimize(ground_height(t, at[i].x, at[i].z).height_m);
                rates[static_cast<std::size_t>(thread)] = static_cast<double>(count) * 1e6 / (worked_us() - start_us);
            });
        std::mt19937 random(4);
        std::uniform_int_distribution<std::uint32_t> tile(0, data_of(t).tile_count() - 1), page(1, finest);
        const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(2);
        while (std::chrono::steady_clock::now() < end) {
            const std::uint32_t from = tile(random), number = t.pages_per_tile() - page(random);
            (void)unload_page(t, from, number);
            loads += load_page(pack.pack, t, from, number).ok();
            if (static_cast<int>(loads) % 8 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(2));
        }
        stop = true;
        for (std::thread& thread : all) thread.join();
        heights_per_s = std::accumulate(rates.begin(), rates.end(), 0.0) / threads;
    }
    state.counters["heights/s_a_thread"] = heights_per_s;
    state.counters["pages_loaded"] = loads;
}

// From above the ground: straight down; along it, a little downwards; level, over most of it to the horizon.
void ray(benchmark::State& state, double above_m, double slope) {
    const Terrain& t = scene().terrain;
    const std::vector<Place> at = places(false);
    std::vector<Vec3> from, along;
    std::mt19937 random(2);
    std::uniform_real_distribution<double> angle(0, 6.283);
    for (const Place& p : at) {
        from.push_back({p.x, data_of(t).ground_m(p.x, p.z) + above_m, p.z});
        const double a = angle(random);
        along.push_back(std::isinf(slope) ? Vec3{0, -1, 0} : Vec3{std::cos(a), slope, std::sin(a)});
    }
    std::size_t i = 0;
    double hits = 0, way_m = 0;
    for (auto _ : state) {
        const GroundHit hit = cast_ray(t, from[i], along[i], 1e9);
        hits += hit.hit;
        way_m += hit.distance_m;
        i = (i + 1) % from.size();
    }
    state.counters["hits"] = hits / static_cast<double>(state.iterations());
    state.counters["km"] = way_m / 1000 / std::max(hits, 1.0);
}

void patch(benchmark::State& state, std::uint32_t side, int step) {
    const Terrain& t = scene().terrain;
    std::vector<float> heights(side * side);
    std::mt19937 random(3);
    std::uniform_int_distribution<int> any(0, data_of(t).tree.columns() - static_cast<int>(side << step));
    for (auto _ : state) benchmark::DoNotOptimize(ground_patch(t, {any(random), any(random)}, step, side, heights));
}

// The pages of one tile in and out again: what the frame's thread pays.
void insert(benchmark::State& state) {
    const Pack& pack = scene().pack;
    const std::size_t bytes = terrain_bytes(pack.header, {});
    const io::AlignedMemory memory = io::allocate(bytes);
    Terrain t;
    if (!create_terrain(pack, {}, {memory.get(), bytes}, t).ok()) return state.SkipWithError("terrain");
    std::vector<std::vector<std::byte>> pages;
    for (std::uint32_t page = 0; page < t.pages_per_tile(); ++page) {
        const ChunkId id{ChunkKind::geometry, 9, page};
        pages.emplace_back(pack.entry(chunk_index(pack.header, id)).raw_bytes);
        if (!read_chunk(pack, id, pages.back()).ok()) return state.SkipWithError("page");
    }
    for (auto _ : state) {
        for (std::uint32_t page = 0; page < t.pages_per_tile(); ++page)
            if (!insert_page(t, 9, page, pages[page]).ok()) return state.SkipWithError("insert");
        for (std::uint32_t page = 0; page < t.pages_per_tile(); ++page) (void)unload_page(t, 9, page);
    }
    state.counters["us_per_page"] =
        benchmark::Counter(static_cast<double>(t.pages_per_tile()) * 1e-6,
                           benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

template <class F>
void declare(const std::string& what, benchmark::TimeUnit unit, F f) {
    benchmark::RegisterBenchmark(("query/mountains-4097/" + what).c_str(), f)->Unit(unit)->MinTime(0.2);
}

} // namespace

int main(int argc, char** argv) {
    using benchmark::State;
    for (const bool coherent : {false, true}) {
        const std::string how = coherent ? "coherent" : "random";
        declare("height-plain/" + how, benchmark::kNanosecond, [=](State& s) { plain_height(s, coherent); });
        declare("height/" + how, benchmark::kNanosecond, [=](State& s) { height(s, coherent, 0); });
        declare("height-to-10m/" + how, benchmark::kNanosecond, [=](State& s) { height(s, coherent, 10); });
    }
    for (const bool coherent : {false, true})
        benchmark::RegisterBenchmark(
            ("query/mountains-4097/height-8-threads-streaming/" + std::string(coherent ? "coherent" : "random"))
                .c_str(),
            [=](State& s) { heights_while_streaming(s, coherent); })
            ->Iterations(1)
            ->UseRealTime();
    declare("ray/down", benchmark::kNanosecond, [](State& s) { ray(s, 1000, -INFINITY); });
    declare("ray/grazing", benchmark::kNanosecond, [](State& s) { ray(s, 50, -0.02); });
    declare("ray/horizon", benchmark::kNanosecond, [](State& s) { ray(s, 300, 0); });
    for (const std::uint32_t side : {33u, 65u})
        declare("patch/" + std::to_string(side), benchmark::kMicrosecond, [=](State& s) { patch(s, side, 0); });
    declare("patch-step-4/33", benchmark::kMicrosecond, [](State& s) { patch(s, 33, 2); });
    declare("insert/tile", benchmark::kMicrosecond, insert);
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    return 0;
}
