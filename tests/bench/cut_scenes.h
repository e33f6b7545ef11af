// What bench_cut's cases share: scenes, flights over them, and the budget of a cut that shall not be short of anything.
#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "baker/bake/bake.h"
#include "bench/lean_recursion.h"
#include "fjell/cut.h"
#include "fjell/io/load.h"
#include "shared/terrain_data.h"
#include "support/dem.h"
#include "support/times.h"

namespace fjell::bench {

using test::Clock;
using test::rank;
using test::us_since;

struct Scene {
    io::LoadedPack pack;
    double error_px = 1;                           // where the recursive method selects about 100,000 vertices
    std::shared_ptr<LeanRecursion> lean = nullptr; // for squares
};

inline std::string bake_scene(const std::string& name, const std::function<baker::Dem()>& make, int tile_log2) {
    const std::string folder = FJELL_BENCH_DIR;
    std::filesystem::create_directories(folder);
    const std::string path =
        folder + "/" + name + "-" + std::to_string(1 << tile_log2) + "-" + std::to_string(pack_layout_hash) + ".fjell";
    if (std::filesystem::exists(path)) return path;
    baker::BakeOptions options;
    options.tile_log2 = tile_log2;
    options.max_texture_log2 = 4;
    (void)baker::bake(make(), options, path);
    return path;
}

// Over the middle, 400 m above ground, `cells` a frame, straight on or turning. cells 0: turning on the spot.
inline std::vector<View> flight_views(const Terrain& t, double cells, std::size_t frames, double turns = 0) {
    std::vector<View> views;
    const double cell = t.header().spacing_m[0], width = cell * (data_of(t).tree.columns() - 1),
                 depth = t.header().spacing_m[1] * (data_of(t).tree.rows() - 1);
    Vec3 direction{0.8, 0, -0.6};
    const double length_m = std::min(cells * cell * static_cast<double>(frames), 0.4 * std::min(width, depth));
    if (cells > 0) frames = std::min(frames, static_cast<std::size_t>(length_m / (cells * cell)));
    const double before_m = turns > 0 ? 0 : length_m / 2;
    Vec3 eye{width * 0.5 - direction.x * before_m, 0, depth * 0.5 - direction.z * before_m};
    for (std::size_t frame = 0; frame < frames; ++frame) {
        const Vec3 forward{direction.x, -0.15, direction.z};
        const Vec3 ahead = cells > 0 ? direction : Vec3{0.8, 0, -0.6}; // on the spot, the eye rests
        // Heights as a camera follows them: over a hundred cells, not every bump.
        double ground = 0;
        for (int i = -4; i <= 4; ++i)
            ground += data_of(t).ground_m(eye.x + ahead.x * i * 12 * cell, eye.z + ahead.z * i * 12 * cell) / 9;
        eye.y = ground + 400;
        views.push_back(make_view(eye, forward, {0, 1, 0}, 0.7853981633974483, 1280, 960, 10, 2 * (width + depth)));
        eye = eye + direction * (cells * cell);
        direction = {direction.x * std::cos(turns) - direction.z * std::sin(turns), 0,
                     direction.x * std::sin(turns) + direction.z * std::cos(turns)};
    }
    return views;
}

// Of the lean recursion nothing is bounded: its strip holds whatever comes.
inline LeanRecursion make_lean(const Terrain& terrain) {
    return {terrain, std::size_t{1} << 24};
}

inline const CutBudget cut_budget{1u << 21, 1u << 22, 1024, 1};

// A cut with its memory.
struct CutInMemory {
    CutInMemory(const Terrain& terrain, const CutBudget& budget) : memory(io::allocate(cut_bytes(terrain, budget))) {
        if (!create_cut(terrain, budget, {memory.get(), cut_bytes(terrain, budget)}, cut).ok()) std::abort();
    }
    io::AlignedMemory memory;
    LiveCut cut;
};

inline const Scene& mountains() {
    static const Scene scene = [] {
        const auto make = [] { return baker::synthesise(FJELL_SOURCE_DIR "/content/terrain/mountains.json"); };
        Scene s{io::load_pack(bake_scene("mountains", make, 10), io::LoadTerrain::yes), 0.8};
        s.lean = std::make_shared<LeanRecursion>(make_lean(s.pack.terrain));
        return s;
    }();
    return scene;
}

// One run; its counters say the rest.
template <typename Run>
void declare(const std::string& name, Run run) {
    benchmark::RegisterBenchmark(("cut/" + name).c_str(), run)->Unit(benchmark::kMillisecond)->Iterations(1);
}
// Those of frames that end by their time (bench_cut_time.cpp).
void declare_frames_that_time_ends();

} // namespace fjell::bench
