// The yardstick: what the recursive method costs a selected vertex. Everything later is measured against it in the same
// run, so it has to be an honest one: the same compiler flags, the same records, and its own nanoseconds printed.
//
// Names: stage/scene/parameter. Scene: the mountains of content/terrain (4097 x 4097, 60 m), in tiles of 257 to 4097
// samples a side and in the three orders.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "baker/bake/bake.h"
#include "fjell/io/load.h"
#include "fjell/recursive.h"
#include "shared/terrain_data.h"
#include "support/dem.h"

namespace {

using namespace fjell;

const std::string recipe = FJELL_SOURCE_DIR "/content/terrain/mountains.json";

constexpr const char* order_names[] = {"planar", "hz", "linear"};

// Baked once a build folder: the pack's name says everything it depends on but the code; `./dev clean` forgets it.
std::string pack_path(int tile_log2, PageOrder order) {
    const std::string folder = FJELL_BENCH_DIR;
    std::filesystem::create_directories(folder);
    const std::string path = folder + "/mountains-" + std::to_string(1 << tile_log2) + "-" +
                             order_names[static_cast<int>(order)] + "-" + std::to_string(pack_layout_hash) + ".fjell";
    if (std::filesystem::exists(path) &&
        std::filesystem::last_write_time(path) > std::filesystem::last_write_time(recipe))
        return path;
    baker::BakeOptions options;
    options.tile_log2 = tile_log2;
    options.order = order;
    options.max_texture_log2 = 4;
    static const baker::Dem dem = baker::synthesise(recipe);
    (void)baker::bake(dem, options, path);
    return path;
}

struct Scene {
    io::LoadedPack pack;
    std::vector<View> views;
};

// A flight 400 m above ground, straight over the middle, 64 frames one cell apart; 1280 x 960 as in the thesis.
const Scene& scene(int tile_log2, PageOrder order) {
    static std::map<std::pair<int, PageOrder>, Scene> scenes;
    Scene& s = scenes[{tile_log2, order}];
    if (!s.views.empty()) return s;
    s.pack = io::load_pack(pack_path(tile_log2, order), io::LoadTerrain::yes);
    const Terrain& t = s.pack.terrain;
    const double cell = t.header().spacing_m[0], width = cell * (data_of(t).tree.columns() - 1),
                 depth = cell * (data_of(t).tree.rows() - 1);
    const Vec3 step{cell * 0.8, 0, -cell * 0.6};
    Vec3 eye{width * 0.4, 0, depth * 0.6};
    for (int frame = 0; frame < 64; ++frame, eye = eye + step) {
        eye.y = data_of(t).ground_m(eye.x, eye.z) + 400;
        s.views.push_back(
            make_view(eye, step + Vec3{0, -0.15 * cell, 0}, {0, 1, 0}, 0.7853981633974483, 1280, 960, 10, 2 * width));
    }
    return s;
}

struct Case {
    int tile_log2 = 9;
    PageOrder order = PageOrder::planar;
    double error_px = 1;
    bool cull = true;
    Topology topology = Topology::triangles;
    Metric metric = Metric::isotropic;
};

void recursive(benchmark::State& state, const Case& c) {
    const Scene& s = scene(c.tile_log2, c.order);
    const RecursiveBudget budget{1u << 22, 1u << 25};
    const std::size_t bytes = recursive_bytes(s.pack.terrain, budget);
    const io::AlignedMemory memory = io::allocate(bytes);
    RecursiveMethod method;
    if (!create_recursive(s.pack.terrain, budget, {memory.get(), bytes}, method).ok())
        return state.SkipWithError("budget");
    RefineSettings settings;
    settings.max_error_px = c.error_px;
    settings.cull = c.cull;
    settings.topology = c.topology;
    settings.metric = c.metric;
    FrameReport report;
    double vertices = 0, triangles = 0, frames = 0;
    std::size_t at = 0;
    // Once over the whole flight, so that buffers are warm, as after the first second of any flight.
    for (const View& view : s.views) (void)update_recursive(method, view, settings, report);
    for (auto _ : state) {
        (void)update_recursive(method, s.views[at], settings, report);
        at = (at + 1) % s.views.size();
        vertices += report.vertices;
        triangles += report.triangles;
        ++frames;
        if (!report.converged) return state.SkipWithError("a budget did not suffice");
    }
    state.counters["vertices"] = vertices / frames;
    state.counters["triangles"] = triangles / frames;
    state.counters["ns_per_vertex"] =
        benchmark::Counter(vertices * 1e-9, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
    state.counters["ns_per_triangle"] =
        benchmark::Counter(triangles * 1e-9, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
    state.counters["MB"] = static_cast<double>(bytes + terrain_bytes(s.pack.pack.header)) / 1e6;
}

// recursive/mountains-4097/tile-513/planar/1px/list
void declare(const Case& c, const std::string& what) {
    const std::string px = c.error_px < 1 ? "0.5" : std::to_string(static_cast<int>(c.error_px));
    const std::string name = "recursive/mountains-4097/tile-" + std::to_string((1 << c.tile_log2) + 1) + "/" +
                             order_names[static_cast<int>(c.order)] + "/" + px + "px/" + what;
    benchmark::RegisterBenchmark(name.c_str(), [=](benchmark::State& state) { recursive(state, c); })
        ->Unit(benchmark::kMillisecond)
        ->MinTime(0.5);
}

} // namespace

int main(int argc, char** argv) {
    for (const double px : {0.5, 1.0, 2.0, 4.0}) {
        declare({.error_px = px}, "list");
        declare({.error_px = px, .topology = Topology::strip}, "strip");
    }
    declare({.cull = false}, "list-all-around");
    declare({.metric = Metric::depth}, "list-depth");
    // The thesis' question (6.4): does the order matter?
    for (const double px : {1.0, 4.0})
        for (const int log2 : {8, 10, 12})
            for (const PageOrder order : {PageOrder::planar, PageOrder::hierarchical_z, PageOrder::linear})
                declare({.tile_log2 = log2, .order = order, .error_px = px}, "list");
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    return 0;
}
