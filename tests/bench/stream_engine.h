// What bench_stream's flights share: engines over a pack in memory and over one in its file, and how time is told.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include "baker/bake/bake.h"
#include "baker/synth/synth.h"
#include "fjell/cut.h"
#include "fjell/io/load.h"
#include "fjell/io/stream_reader.h"
#include "fjell/recursive.h"
#include "fjell/stream.h"
#include "shared/terrain_data.h"
#include "support/times.h"

namespace fjell::bench {

using test::Clock;
using test::rank;
using test::us_since;
using test::worked_us;

inline void require(const Status& status) {
    if (status.ok()) return;
    std::fprintf(stderr, "%s: %s\n", status.field, message(status.code));
    std::abort();
}

inline std::string mountains(PageOrder order) {
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
    io::LoadedPack pack;
    Terrain terrain;
    io::AlignedMemory terrain_memory, cut_memory, stream_memory;
    std::size_t terrain_size = 0, cut_size = 0, stream_size = 0;
    LiveCut cut;
    Stream stream;

    Engine(const std::string& path, std::uint32_t slots, const StreamBudget& budget, bool with_cut = true)
        : pack(io::load_pack(path, io::LoadTerrain::no)) {
        terrain_size = terrain_bytes(pack.pack.header, {slots});
        terrain_memory = io::allocate(terrain_size);
        require(create_terrain(pack.pack, {slots}, {terrain_memory.get(), terrain_size}, terrain));
        const CutBudget cut_budget{1u << 20, 1u << 21, 512, 1};
        cut_size = cut_bytes(terrain, cut_budget);
        cut_memory = io::allocate(cut_size);
        require(create_cut(terrain, cut_budget, {cut_memory.get(), cut_size}, cut));
        stream_size = stream_bytes(pack.pack, terrain, budget);
        stream_memory = io::allocate(stream_size);
        require(create_stream(pack.pack, terrain, with_cut ? cut : LiveCut{}, budget,
                              {stream_memory.get(), stream_size}, stream));
    }
    void serve(std::uint32_t most) {
        StreamRequest r;
        for (std::uint32_t n = 0; n < most && stream_next_request(stream, r); ++n)
            (void)stream_provide(stream, r.ticket, pack.pack.bytes.subspan(r.offset, r.bytes));
    }
};

inline View view_at(const Terrain& t, double x, double z, double height) {
    const double width = t.x_m(data_of(t).tree.columns() - 1);
    return make_view({x * width, height, z * width}, {0.8, -0.2, -0.6}, {0, 1, 0}, 0.7853981633974483, 1280, 960, 10,
                     3 * width);
}

// All that an engine holds, over a pack that stays in its file.
struct FileEngine {
    io::PackFile file;
    Terrain terrain;
    io::AlignedMemory terrain_memory, cut_memory, stream_memory;
    LiveCut cut;
    Stream stream;
    CutSettings refine;
    StreamSettings settings;
    StreamReport streamed;
    CutReport updated;
    double stream_us = 0, cut_us = 0, stream_worked_us = 0, cut_worked_us = 0;

    FileEngine(const std::string& path, std::uint32_t slots, const StreamBudget& budget) : file(path) {
        const PackHeader& h = file.pack().header;
        std::size_t bytes = terrain_bytes(h, {slots});
        terrain_memory = io::allocate(bytes);
        require(create_terrain(file.pack(), file.corners(), {slots}, {terrain_memory.get(), bytes}, terrain));
        const CutBudget cut_budget{1u << 20, 1u << 21, 512, 1};
        bytes = cut_bytes(terrain, cut_budget);
        cut_memory = io::allocate(bytes);
        require(create_cut(terrain, cut_budget, {cut_memory.get(), bytes}, cut));
        bytes = stream_bytes(file.pack(), terrain, budget);
        stream_memory = io::allocate(bytes);
        require(create_stream(file.pack(), terrain, cut, budget, {stream_memory.get(), bytes}, stream));
    }
    void frame(const View& view) {
        settings.now_s += 1.0 / 60;
        double worked = worked_us();
        auto start = Clock::now();
        require(update_stream(stream, {&view, 1}, refine, settings, streamed));
        stream_us = us_since(start);
        stream_worked_us = worked_us() - worked;
        worked = worked_us();
        start = Clock::now();
        require(update_cut(cut, {&view, 1}, refine, updated));
        cut_us = us_since(start);
        cut_worked_us = worked_us() - worked;
    }
    // 60 a second, until the whole of it has converged, maps too if they are asked. Seconds; complete_s: to complete.
    double rest(const View& view, bool maps, double* complete_s = nullptr) {
        const auto start = Clock::now();
        for (int i = 1; i < 60 * 300; ++i) {
            frame(view);
            const double now_s = us_since(start) * 1e-6;
            if (complete_s && *complete_s == 0 && streamed.complete) *complete_s = now_s;
            if (updated.converged && (!maps || streamed.maps_converged)) return now_s;
            std::this_thread::sleep_until(start + i * std::chrono::microseconds(16667));
        }
        return -1;
    }
};

} // namespace fjell::bench
