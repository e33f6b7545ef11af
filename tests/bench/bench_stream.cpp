// Streaming: what a frame spends on it, and what the disk has to give.
//
// Names: stream/scene/what. frame/C: a flight of C cells a frame at 60 frames a second over the mountains of
// content/terrain with a ninth of their pages' slots; the client answers within a frame, so it is our work that is
// measured, not the disk's.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "baker/bake.h"
#include "baker/synth.h"
#include "fjell/cut.h"
#include "fjell/stream.h"
#include "host/load.h"

namespace {

using namespace fjell;
using Clock = std::chrono::steady_clock;

double us_since(Clock::time_point start) {
    return std::chrono::duration<double, std::micro>(Clock::now() - start).count();
}
double rank(std::vector<double> v, double share) {
    std::sort(v.begin(), v.end());
    const auto n = static_cast<std::size_t>(std::ceil(share * static_cast<double>(v.size())));
    return v[std::clamp<std::size_t>(n, 1, v.size()) - 1];
}
void require(const Status& status) {
    if (status.ok()) return;
    std::fprintf(stderr, "%s: %s\n", status.field, message(status.code));
    std::abort();
}

std::string mountains(Order order) {
    const std::string folder = FJELL_BENCH_DIR;
    std::filesystem::create_directories(folder);
    const std::string path = folder + "/stream-" + std::to_string(static_cast<int>(order)) + "-" +
                             std::to_string(pack_layout_hash) + ".fjell";
    if (std::filesystem::exists(path)) return path;
    baker::BakeOptions options;
    options.tile_log2 = 9;
    options.order = order;
    options.max_texture_log2 = 9;
    (void)baker::bake(*baker::open_synth(FJELL_SOURCE_DIR "/content/terrain/mountains.json"), options, path);
    return path;
}

// All that an engine holds, over a pack that is read from memory.
struct Engine {
    host::LoadedPack pack;
    Terrain terrain;
    host::AlignedBlock terrain_block, cut_block, stream_block;
    std::size_t terrain_size = 0, cut_size = 0, stream_size = 0;
    LiveCut cut;
    Stream stream;

    Engine(const std::string& path, std::uint32_t slots, const StreamBudget& budget)
        : pack(host::load_pack(path, host::LoadTerrain::no)) {
        terrain_size = terrain_bytes(pack.pack.header, {slots});
        terrain_block = host::make_block(terrain_size);
        require(create_terrain(pack.pack, {slots}, {terrain_block.get(), terrain_size}, terrain));
        const CutBudget cut_budget{1u << 20, 1u << 21, 512, 1};
        cut_size = cut_bytes(terrain, cut_budget);
        cut_block = host::make_block(cut_size);
        require(create_cut(terrain, cut_budget, {cut_block.get(), cut_size}, cut));
        stream_size = stream_bytes(pack.pack, terrain, budget);
        stream_block = host::make_block(stream_size);
        require(create_stream(pack.pack, terrain, cut, budget, {stream_block.get(), stream_size}, stream));
    }
    void serve(std::uint32_t most) {
        StreamRequest r;
        for (std::uint32_t n = 0; n < most && next_request(stream, r); ++n)
            (void)provide(stream, r.ticket, pack.pack.bytes.subspan(r.offset, r.bytes));
    }
};

View view_at(const Terrain& t, double x, double z, double height) {
    const double width = t.x_m(t.tree.columns() - 1);
    return make_view({x * width, height, z * width}, {0.8, -0.2, -0.6}, {0, 1, 0}, 0.7853981633974483, 1280, 960, 10,
                     3 * width);
}

void frame(benchmark::State& state, double cells, bool rests = false) {
    Engine e(mountains(Order::planar), 610, {});
    CutSettings settings;
    settings.error_px = 4;
    StreamSettings stream_settings;
    StreamReport stream;
    CutReport report;
    const double cell = e.terrain.header.spacing_m[0];
    View view = view_at(e.terrain, 0.2, 0.7, 3500);
    for (int i = 0; i < 2000; ++i) { // to rest
        stream_settings.now_s += 1.0 / 60;
        require(update_stream(e.stream, {&view, 1}, settings, stream_settings, stream));
        require(update_cut(e.cut, {&view, 1}, settings, report));
        e.serve(64);
    }
    std::vector<double> stream_us, cut_us, prepare_us;
    double pages = 0, converged = 0, removed = 0;
    for (auto _ : state) {
        const int frames = 1500;
        for (int i = 0; i < frames; ++i) {
            if (!rests) view.eye_m = view.eye_m + Vec3{0.8, 0, -0.6} * (cells * cell);
            stream_settings.now_s += 1.0 / 60;
            auto start = Clock::now();
            require(update_stream(e.stream, {&view, 1}, settings, stream_settings, stream));
            stream_us.push_back(us_since(start));
            start = Clock::now();
            require(update_cut(e.cut, {&view, 1}, settings, report));
            cut_us.push_back(us_since(start));
            prepare_us.push_back(report.prepare_us);
            pages += stream.pages_taken;
            converged += stream.converged;
            for (const PageArrival& a : page_arrivals(e.stream)) removed += a.event == PageEvent::removed;
            e.serve(64);
        }
        state.counters["converged"] = converged / frames;
        state.counters["pages_a_frame"] = pages / frames;
        state.counters["removed_a_frame"] = removed / frames;
        state.counters["slots_used"] = stream.page_slots.used;
        state.counters["missing_px"] = stream.missing_px;
    }
    state.counters["stream_us_p50"] = rank(stream_us, 0.5);
    state.counters["stream_us_p99"] = rank(stream_us, 0.99);
    state.counters["stream_us_max"] = rank(stream_us, 1);
    state.counters["cut_us_p50"] = rank(cut_us, 0.5);
    state.counters["cut_us_p99"] = rank(cut_us, 0.99);
    state.counters["prepare_us_p99"] = rank(prepare_us, 0.99);
}

} // namespace

BENCHMARK_CAPTURE(frame, rest, 0, true)
    ->Name("stream/mountains/frame/rest")
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(frame, walk, 0.25)->Name("stream/mountains/frame/0.25")->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(frame, drive, 1)->Name("stream/mountains/frame/1")->Iterations(1)->Unit(benchmark::kMillisecond);

BENCHMARK_MAIN();
