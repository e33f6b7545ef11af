// Frames a second by triangles and resolution: textured, lit, hazed, from a flight whose mesh changes and is uploaded.
//
// Names: draw/threshold at 720 rows/picture; the counter triangles_drawn says how many that is. light/feature, at 12 px
// and 1280 x 720: what a feature of light costs a pixel, to be read against light/bare of the same run; near: 100 m
// over the ground, where detail shows. light/all-N-samples: all of them but materials. layers/off and layers/on: 40 m
// over the ground, without and with the materials and rules of content; layers/all: with shadows and water too. Ratios
// want
// --benchmark_enable_random_interleaving=true and repetitions: neighbours then hit all alike. sky/tables: what a sun
// that moves costs the CPU. On a machine without a GPU this is Mesa's software renderer, and its cost in pixels, not
// ours.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include <epoxy/gl.h>

#include "baker/bake/bake.h"
#include "baker/materials/encode.h"
#include "baker/synth/synth.h"
#include "fjell/cut.h"
#include "fjell/gl/context.h"
#include "fjell/gl/renderer.h"
#include "fjell/gl/target.h"
#include "fjell/io/load.h"
#include "fjell/io/materials.h"
#include "gl/lighting.h"
#include "io/file.h"
#include "session/layers_file.h"
#include "shared/terrain_data.h"

namespace {

using namespace fjell;

[[noreturn]] void stop(const std::string& why) {
    std::fprintf(stderr, "bench_draw: %s\n", why.c_str());
    std::exit(3);
}
const io::LoadedPack& scene() {
    static const io::LoadedPack pack = [] {
        const std::string path =
            std::string(FJELL_BENCH_DIR) + "/draw-horizons-" + std::to_string(pack_layout_hash) + ".fjell";
        std::filesystem::create_directories(FJELL_BENCH_DIR);
        if (!std::filesystem::exists(path)) {
            baker::BakeOptions options;
            options.tile_log2 = 9;
            options.max_texture_log2 = 9;
            options.horizon_spacing = 2;
            (void)baker::bake(*baker::open_synth(FJELL_SOURCE_DIR "/content/terrain/mountains.json"), options, path);
        }
        return io::load_pack(path, io::LoadTerrain::yes);
    }();
    return pack;
}

// The materials and rules of content, a quarter as fine as usual: what a read costs depends little on it.
const std::pair<io::Materials, std::vector<gl::LayerRule>>& ground_layers() {
    static const std::pair<io::Materials, std::vector<gl::LayerRule>> layers = [] {
        std::vector<baker::MaterialTexels> texels;
        for (const baker::MaterialRecipe& recipe : baker::read_materials(FJELL_SOURCE_DIR "/content/materials"))
            texels.push_back(baker::make_material(recipe, 128));
        static const std::vector<std::byte> file = io::materials_file(baker::encode_materials(texels).materials);
        io::Materials materials = io::open_materials(file, "materials");
        const std::string rules = FJELL_SOURCE_DIR "/content/materials/rules/alpine.json";
        std::vector<gl::LayerRule> parsed = session::parse_layer_rules(io::read_text(rules), rules, materials);
        return std::pair(std::move(materials), std::move(parsed));
    }();
    return layers;
}

struct Picture {
    double error_px = 12;
    std::uint32_t width = 1280, height = 720, samples = 1;
    double above_m = 3500;
    gl::DrawOptions options{};
};

void draw(benchmark::State& state, const Picture& picture) {
    const auto [error_px, width, height, samples, above_m, drawing] = picture;
    const io::LoadedPack& pack = scene();
    const auto context = gl::Headless::create();
    const auto target = gl::Target::create({width, height, samples});
    const CutBudget budget{1u << 21, 1u << 22, 1024, 1};
    const std::size_t bytes = cut_bytes(pack.terrain, budget);
    const io::AlignedMemory memory = io::allocate(bytes);
    LiveCut cut;
    if (!create_cut(pack.terrain, budget, {memory.get(), bytes}, cut).ok()) stop("the cut's budget is too small");
    gl::RendererOptions options{budget.vertices, 3 * budget.triangles};
    options.ranges = budget.triangles / budget.segment_triangles;
    options.morph = true;
    options.light = drawing.light;
    const auto renderer = gl::Renderer::create(pack.terrain, pack.pack, options);
    if (drawing.layers.on) renderer->set_layers(ground_layers().first, ground_layers().second);
    CutSettings settings;
    settings.max_error_px = error_px;
    CutReport report;
    const double extent = pack.terrain.x_m(data_of(pack.terrain).tree.columns() - 1);
    Vec3 eye{0.5 * extent, above_m, 0.5 * extent};
    const auto view = [&, width = width, height = height] {
        return make_view(eye, {0.8, -0.2, -0.6}, {0, 1, 0}, 0.7853981633974483, width, height, 3, 3 * extent);
    };
    View now = view();
    (void)rebuild_cut(cut, {&now, 1}, settings, report);
    double drawn = 0, uploaded = 0;
    renderer->draw(cut_mesh(cut), cut_take_changes(cut), now, drawing, *target); // uploads all
    glFinish();
    for (auto _ : state) {
        eye = eye + Vec3{0.8, 0, -0.6} * 15.0; // a quarter of a cell
        now = view();
        (void)update_cut(cut, {&now, 1}, settings, report);
        renderer->draw(cut_mesh(cut), cut_take_changes(cut), now, drawing, *target);
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

void add(const std::string& name, const Picture& picture) {
    benchmark::RegisterBenchmark(name.c_str(), [=](benchmark::State& s) { draw(s, picture); })
        ->Iterations(20)
        ->UseRealTime()
        ->MeasureProcessCPUTime() // of all threads: neighbours on the machine count less
        ->Unit(benchmark::kMillisecond);
}

gl::DrawOptions lit(gl::Air air, bool detail, bool dither, bool filmic, bool water, bool shadows = false) {
    gl::DrawOptions options;
    options.light.air = air;
    options.light.detail = detail;
    options.light.dither = dither;
    options.light.tone_curve = filmic ? gl::ToneCurve::filmic : gl::ToneCurve::none;
    options.light.water = water;
    options.light.shadows = shadows;
    options.light.water_level_m = 900;
    return options;
}

void sky_tables(benchmark::State& state) {
    gl::Sky sky;
    double height = 0.1;
    for (auto _ : state) {
        height = height < 0.9 ? height + 0.01 : 0.1;
        gl::make_sky({std::sqrt(1 - height * height), height, 0}, 160, sky);
        benchmark::DoNotOptimize(sky.radiance.data());
    }
}

const int registered = [] {
    const std::pair<const char*, double> meshes[] = {{"12px", 12}, {"5px", 5}, {"2px", 2}, {"1px", 1}};
    const std::pair<std::uint32_t, std::uint32_t> pictures[] = {{640, 360}, {1280, 720}, {1920, 1080}, {3840, 2160}};
    for (const auto& [name, error_px] : meshes)
        for (const auto& [width, height] : pictures) // about as many triangles in each
            add(std::string("draw/") + name + "/" + std::to_string(width) + "x" + std::to_string(height),
                {.error_px = error_px * height / 720, .width = width, .height = height});
    constexpr auto simple = gl::Air::simple, physical = gl::Air::physical;
    const std::pair<const char*, gl::DrawOptions> features[] = {
        {"bare", {.lit = false}},
        {"simple-linear", lit(simple, false, false, false, false)},
        {"simple", lit(simple, false, false, true, false)},
        {"simple-dither", lit(simple, false, true, true, false)},
        {"simple-shadows", lit(simple, false, true, true, false, true)},
        {"physical", lit(physical, false, true, true, false)},
        {"physical-water", lit(physical, false, true, true, true)},
        {"physical-shadows", lit(physical, false, true, true, false, true)},
        {"physical-detail", lit(physical, true, true, true, false)},
        {"physical-detail-shadows", lit(physical, true, true, true, false, true)},
        {"all", lit(physical, true, true, true, true, true)},
    };
    for (const auto& [name, options] : features) {
        add(std::string("light/") + name, {.options = options});
        add(std::string("light-near/") + name, {.above_m = 2400, .options = options});
    }
    gl::DrawOptions all = lit(physical, true, true, true, true, true), layered = lit(physical, true, true, true, false);
    for (const std::uint32_t samples : {2u, 4u})
        add("light/all-" + std::to_string(samples) + "-samples", {.samples = samples, .options = all});
    add("layers/off", {.above_m = 1640, .options = layered});
    layered.layers.on = all.layers.on = true;
    add("layers/on", {.above_m = 1640, .options = layered});
    add("layers/all", {.above_m = 1640, .options = all});
    benchmark::RegisterBenchmark("sky/tables", sky_tables)->Unit(benchmark::kMillisecond);
    return 0;
}();

} // namespace

BENCHMARK_MAIN();
