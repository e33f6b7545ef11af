// What the editor's own code costs a frame - panels, commands, camera, measures, histogram - with each panel and
// dialog open, with what lies over the picture and the overview, and with everything; without the terrain's update, the
// driver and the swap. The whole program, headless, in the light that software draws fastest.
//
// Names: editor/mountains/what; of what follows "runs", each with those before it. Counters: p50 and p99 in
// microseconds of 400 frames while the camera flies; the time is the median.
#include <benchmark/benchmark.h>

#include <filesystem>
#include <string>
#include <vector>

#include "baker/bake/bake.h"
#include "editor/app.h"
#include "support/dem.h"
#include "support/editor_sights.h"

namespace {

using namespace fjell;

std::string pack_path() {
    const std::string folder = FJELL_BENCH_DIR;
    std::filesystem::create_directories(folder);
    const std::string path = folder + "/editor-" + std::to_string(pack_layout_hash) + ".fjell";
    if (std::filesystem::exists(path)) return path;
    baker::BakeOptions options;
    options.tile_log2 = 6;
    (void)baker::bake(baker::synthesise(FJELL_SOURCE_DIR "/content/terrain/mountains-small.json"), options, path);
    return path;
}

using Commands = std::vector<std::string>;

Commands together(std::initializer_list<Commands> parts) {
    Commands all;
    for (const Commands& part : parts) all.insert(all.end(), part.begin(), part.end());
    return all;
}

void fly(benchmark::State& bench, const Commands& sight) {
    // What the editor keeps goes beside the packs, not to whoever measures.
    for (const char* name : {"XDG_CONFIG_HOME", "XDG_STATE_HOME", "XDG_CACHE_HOME"}) setenv(name, FJELL_BENCH_DIR, 1);
    for (auto _ : bench) {
        editor::Options options;
        options.headless = true;
        options.pack = pack_path();
        options.path = FJELL_SOURCE_DIR "/content/paths/flythrough.json";
        options.commands =
            together({{"set light.air simple", "set light.detail false", "set light.dither false", "wait"},
                      sight,
                      {"play-path on", "frames 400"}});
        editor::App app(options);
        (void)app.run();
        const editor::Quantiles q = app.state().measures.ring(editor::Series::editor_us).quantiles();
        bench.counters["p50_us"] = static_cast<double>(q.p50);
        bench.counters["p99_us"] = static_cast<double>(q.p99);
        bench.SetIterationTime(static_cast<double>(q.p50) * 1e-6);
    }
}

void add(const std::string& name, const Commands& sight) {
    benchmark::RegisterBenchmark(("editor/mountains/" + name).c_str(), [sight](benchmark::State& s) { fly(s, sight); })
        ->UseManualTime()
        ->Iterations(1)
        ->Unit(benchmark::kMicrosecond);
}

} // namespace

int main(int argc, char** argv) {
    for (const test::Sight& sight : test::panels_and_dialogs())
        if (!sight.name.ends_with(":unsaved") && !sight.name.ends_with(":recover")) // which only show what others left
            add(sight.name, sight.commands);
    Commands before = together({test::flown_runs(FJELL_BENCH_DIR), test::compared_picture});
    for (const test::Sight& sight : test::overlays_in_turn()) {
        before = together({before, sight.commands});
        add(sight.name, before);
    }
    benchmark::Initialize(&argc, argv);
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
}
