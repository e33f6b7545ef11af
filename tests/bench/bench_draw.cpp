// Frames a second by triangles and resolution: textured, lit, hazed, from a flight whose mesh changes and is uploaded.
//
// Names: draw/threshold at 720 rows/picture; the counter triangles_drawn says how many that is. On a machine without a
// GPU this is Mesa's software renderer, and its cost in pixels, not ours.
#include <benchmark/benchmark.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include <epoxy/gl.h>

#include "baker/bake/bake.h"
#include "baker/synth/synth.h"
#include "fjell/cut.h"
#include "fjell/gl/context.h"
#include "fjell/gl/renderer.h"
#include "fjell/gl/target.h"
#include "fjell/io/load.h"
#include "pack/terrain_data.h"

namespace {

using namespace fjell;

[[noreturn]] void stop(const std::string& why) {
    std::fprintf(stderr, "bench_draw: %s\n", why.c_str());
    std::exit(3);
}
void require(const std::string& error) {
    if (!error.empty()) stop(error);
}

const io::LoadedPack& scene() {
    static const io::LoadedPack pack = [] {
        const std::string path = std::string(FJELL_BENCH_DIR) + "/draw-" + std::to_string(pack_layout_hash) + ".fjell";
        std::filesystem::create_directories(FJELL_BENCH_DIR);
        if (!std::filesystem::exists(path)) {
            baker::BakeOptions options;
            options.tile_log2 = 9;
            options.max_texture_log2 = 9;
            (void)baker::bake(*baker::open_synth(FJELL_SOURCE_DIR "/content/terrain/mountains.json"), options, path);
        }
        return io::load_pack(path, io::LoadTerrain::yes);
    }();
    return pack;
}

void draw(benchmark::State& state, double error_px, std::uint32_t width, std::uint32_t height) {
    const io::LoadedPack& pack = scene();
    std::string error;
    const auto context = gl::Headless::create({}, error);
    require(error);
    const auto target = gl::Target::create({width, height, 1}, error);
    require(error);
    const CutBudget budget{1u << 21, 1u << 22, 1024, 1};
    const std::size_t bytes = cut_bytes(pack.terrain, budget);
    const io::AlignedMemory memory = io::allocate(bytes);
    LiveCut cut;
    if (!create_cut(pack.terrain, budget, {memory.get(), bytes}, cut).ok()) stop("the cut's budget is too small");
    gl::RendererOptions options{budget.vertices, 3 * budget.triangles};
    options.ranges = budget.triangles / budget.segment_triangles;
    options.morph = true;
    const auto renderer = gl::Renderer::create(pack.terrain, pack.pack, options, error);
    require(error);
    CutSettings settings;
    settings.error_px = error_px;
    CutReport report;
    const double extent = pack.terrain.x_m(data_of(pack.terrain).tree.columns() - 1);
    Vec3 eye{0.5 * extent, 3500, 0.5 * extent};
    const auto view = [&] {
        return make_view(eye, {0.8, -0.2, -0.6}, {0, 1, 0}, 0.7853981633974483, width, height, 3, 3 * extent);
    };
    View now = view();
    (void)rebuild_cut(cut, {&now, 1}, settings, report);
    double drawn = 0, uploaded = 0;
    require(renderer->draw(cut_mesh(cut), cut_take_changes(cut), now, {}, *target)); // uploads all
    glFinish();
    for (auto _ : state) {
        eye = eye + Vec3{0.8, 0, -0.6} * 15.0; // a quarter of a cell
        now = view();
        (void)update_cut(cut, {&now, 1}, settings, report);
        require(renderer->draw(cut_mesh(cut), cut_take_changes(cut), now, {}, *target));
        glFinish();
        drawn += report.triangles_drawn;
        uploaded += static_cast<double>(renderer->stats().bytes_uploaded);
    }
    const auto frames = static_cast<double>(state.iterations());
    state.counters["fps"] = benchmark::Counter(frames, benchmark::Counter::kIsRate);
    state.counters["triangles_drawn"] = drawn / frames;
    state.counters["uploaded_bytes"] = uploaded / frames;
    state.SetLabel(reinterpret_cast<const char*>(glGetString(GL_RENDERER)));
}

const int registered = [] {
    const std::pair<const char*, double> meshes[] = {{"12px", 12}, {"5px", 5}, {"2px", 2}, {"1px", 1}};
    const std::pair<std::uint32_t, std::uint32_t> pictures[] = {{640, 360}, {1280, 720}, {1920, 1080}};
    for (const auto& [name, error_px] : meshes)
        for (const auto& [width, height] : pictures)
            benchmark::RegisterBenchmark(
                (std::string("draw/") + name + "/" + std::to_string(width) + "x" + std::to_string(height)).c_str(),
                [=](benchmark::State& s) {
                    draw(s, error_px * height / 720, width, height); // about as many triangles
                })
                ->Iterations(20)
                ->UseRealTime()
                ->Unit(benchmark::kMillisecond);
    return 0;
}();

} // namespace

BENCHMARK_MAIN();
