// The live cut against the recursive method: the same terrain, views, threshold and run; the recursive one culls, because
// that is how it is fast, and its nanoseconds a vertex are printed so that nobody has to doubt it.
//
// Names: cut/scene/what. Scenes: the mountains of content/terrain (4097 x 4097, 60 m) and, when the folder of real data is
// there, the Grand Canyon. Every case is one flight; its counters are percentiles over frames.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "baker/bake.h"
#include "baker/read.h"
#include "fjell/cut.h"
#include "fjell/recursive.h"
#include "host/load.h"

namespace {

using namespace fjell;
using Clock = std::chrono::steady_clock;

double us_since(Clock::time_point start) {
    return std::chrono::duration<double, std::micro>(Clock::now() - start).count();
}

struct Scene {
    host::LoadedPack pack;
    double error_px = 1; // where the recursive method selects about 100,000 vertices
};

std::string bake_scene(const std::string& name, const std::function<baker::Dem()>& make, int tile_log2) {
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

// Straight over the middle, 400 m above ground, `cells` a frame. cells 0: turning on the spot, 17 degrees a second.
std::vector<View> flight(const Terrain& t, double cells, std::size_t frames) {
    std::vector<View> views;
    const double cell = t.header.spacing_m[0], width = cell * (t.tree.columns() - 1),
                 depth = t.header.spacing_m[1] * (t.tree.rows() - 1);
    const Vec3 direction{0.8, 0, -0.6};
    const double length_m = std::min(cells * cell * static_cast<double>(frames), 0.4 * std::min(width, depth));
    Vec3 eye{width * 0.5 - direction.x * length_m / 2, 0, depth * 0.5 - direction.z * length_m / 2};
    for (std::size_t frame = 0; frame < frames; ++frame) {
        const double turned = cells == 0 ? static_cast<double>(frame) * 17.0 / 60 / 57.29578 : 0;
        const Vec3 forward{direction.x * std::cos(turned) - direction.z * std::sin(turned), -0.15,
                           direction.x * std::sin(turned) + direction.z * std::cos(turned)};
        // Heights as a camera follows them: over a hundred cells, not every bump.
        double ground = 0;
        for (int i = -4; i <= 4; ++i) ground += t.ground_m(eye.x + direction.x * i * 12 * cell, eye.z + direction.z * i * 12 * cell) / 9;
        eye.y = ground + 400;
        views.push_back(make_view(eye, forward, {0, 1, 0}, 0.7853981633974483, 1280, 960, 10, 2 * (width + depth)));
        eye = eye + direction * (cells * cell);
    }
    return views;
}

struct Flight {
    std::vector<double> us;
    double vertices = 0, triangles = 0, drawn = 0, changes = 0, evaluations = 0, uploaded = 0, converged = 0;
};
double rank(std::vector<double> v, double share) {
    std::sort(v.begin(), v.end());
    const auto n = static_cast<std::size_t>(std::ceil(share * static_cast<double>(v.size())));
    return v[std::clamp<std::size_t>(n, 1, v.size()) - 1];
}

Flight fly_recursive(const Terrain& terrain, const std::vector<View>& views, double error_px) {
    const RecursiveBudget budget{1u << 21, 1u << 24};
    const std::size_t bytes = recursive_bytes(terrain, budget);
    const host::AlignedBlock block = host::make_block(bytes);
    RecursiveMethod method;
    if (!create_recursive(terrain, budget, {block.get(), bytes}, method).ok()) std::abort();
    RefineSettings settings;
    settings.error_px = error_px;
    FrameReport report;
    Flight f;
    for (int i = 0; i < 8; ++i) (void)update_recursive(method, views[0], settings, report);
    for (const View& view : views) {
        const auto start = Clock::now();
        (void)update_recursive(method, view, settings, report);
        f.us.push_back(us_since(start));
        f.vertices += report.vertices;
        f.triangles += report.triangles;
    }
    f.vertices /= static_cast<double>(views.size());
    f.triangles /= static_cast<double>(views.size());
    return f;
}

constexpr CutBudget cut_budget{1u << 21, 1u << 22, 1024, 1};

Flight fly_cut(const Terrain& terrain, const std::vector<View>& views, const CutSettings& settings) {
    const std::size_t bytes = cut_bytes(terrain, cut_budget);
    const host::AlignedBlock block = host::make_block(bytes);
    LiveCut cut;
    if (!create_cut(terrain, cut_budget, {block.get(), bytes}, cut).ok()) std::abort();
    CutReport report;
    Flight f;
    (void)rebuild_cut(cut, {&views[0], 1}, settings, report);
    for (int i = 0; i < 8; ++i) (void)update_cut(cut, {&views[0], 1}, settings, report);
    for (const View& view : views) {
        const auto start = Clock::now();
        (void)update_cut(cut, {&view, 1}, settings, report);
        f.us.push_back(us_since(start));
        f.vertices += report.vertices;
        f.triangles += report.triangles;
        f.drawn += report.triangles_drawn;
        f.changes += report.activations + report.deactivations;
        f.evaluations += report.evaluations;
        f.uploaded += report.vertices_changed * (sizeof(MeshVertex) + sizeof(MorphVertex)) + report.triangles_changed * 12.0;
        f.converged += report.converged;
    }
    const auto n = static_cast<double>(views.size());
    for (double* sum : {&f.vertices, &f.triangles, &f.drawn, &f.changes, &f.evaluations, &f.uploaded, &f.converged}) *sum /= n;
    return f;
}

const Scene& mountains() {
    static const Scene scene = [] {
        const auto make = [] { return baker::synthesise(FJELL_SOURCE_DIR "/content/terrain/mountains.json"); };
        return Scene{host::load_pack(bake_scene("mountains", make, 10), host::LoadTerrain::yes), 0.9};
    }();
    return scene;
}

void compare(benchmark::State& state, const Scene& scene, double cells) {
    const Terrain& t = scene.pack.terrain;
    const std::vector<View> views = flight(t, cells, 600);
    CutSettings settings;
    settings.error_px = scene.error_px;
    Flight recursive, cut;
    for (auto _ : state) {
        recursive = fly_recursive(t, views, scene.error_px);
        cut = fly_cut(t, views, settings);
    }
    auto& c = state.counters;
    c["rec_vertices"] = recursive.vertices;
    c["rec_ns_per_vertex"] = rank(recursive.us, 0.5) * 1000 / recursive.vertices;
    c["rec_p50_us"] = rank(recursive.us, 0.5);
    c["rec_p99_us"] = rank(recursive.us, 0.99);
    c["p50_us"] = rank(cut.us, 0.5);
    c["p99_us"] = rank(cut.us, 0.99);
    c["p9999_us"] = rank(cut.us, 0.9999);
    c["ratio_p50"] = rank(recursive.us, 0.5) / rank(cut.us, 0.5);
    c["ratio_p99"] = rank(recursive.us, 0.99) / rank(cut.us, 0.99);
    c["active"] = cut.vertices;
    c["changes"] = cut.changes;
    c["evaluations"] = cut.evaluations;
    c["rec_triangles"] = recursive.triangles;
    c["drawn_triangles"] = cut.drawn;
    c["uploaded_share"] = cut.uploaded / (cut.vertices * (sizeof(MeshVertex) + sizeof(MorphVertex)) + cut.triangles * 12);
    c["converged"] = cut.converged;
}

} // namespace

int main(int argc, char** argv) {
    for (const double cells : {0.0, 0.06, 0.25, 1.0, 3.0}) {
        std::string name = "cut/mountains-4097/";
        name += cells == 0 ? "turning" : std::to_string(cells).substr(0, 4) + "-cells";
        benchmark::RegisterBenchmark(name.c_str(), [=](benchmark::State& s) { compare(s, mountains(), cells); })
            ->Unit(benchmark::kMillisecond)
            ->Iterations(1);
    }
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    return 0;
}
