// The live cut against recursion: the same terrain, views, threshold and run. lean_ is the strongest recursion that we
// can write (bench/lean_recursion.h), rec_ our recursive method; both cull, because that is how they are fast, and
// their nanoseconds a vertex are printed so that nobody has to doubt them. No case repeats a view, and none rebuilds
// between frames but where it says so.
//
// Names: cut/scene/what. Scenes: the mountains of content/terrain (4097 x 4097, 60 m) and, when the folder of real data
// is there, the Grand Canyon. Every case is one flight; its counters are percentiles over frames.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numeric>
#include <string>
#include <vector>

#include "bench/cut_scenes.h"
#include "fjell/recursive.h"
#include "session/worker_pool.h"

namespace {

using namespace fjell;
using namespace fjell::bench;
constexpr double turn = 17.0 / 60 / 57.29578; // a frame, at 17 degrees a second

struct Flight {
    std::vector<double> us;
    double vertices = 0, triangles = 0, drawn = 0, changes = 0, evaluations = 0, uploaded = 0, converged = 0;
};
double mean(const std::vector<double>& v) {
    return std::accumulate(v.begin(), v.end(), 0.0) / static_cast<double>(v.size());
}

Flight fly_recursive(const Terrain& terrain, const std::vector<View>& views, double error_px) {
    const RecursiveBudget budget{1u << 21, 1u << 24};
    const std::size_t bytes = recursive_bytes(terrain, budget);
    const io::AlignedMemory memory = io::allocate(bytes);
    RecursiveMethod method;
    if (!create_recursive(terrain, budget, {memory.get(), bytes}, method).ok()) std::abort();
    RefineSettings settings;
    settings.max_error_px = error_px;
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

Flight fly_lean(LeanRecursion& lean, const std::vector<View>& views, double error_px) {
    Flight f;
    for (int i = 0; i < 8; ++i) (void)lean.refine(views[0], error_px, true);
    for (const View& view : views) {
        const auto start = Clock::now();
        const auto frame = lean.refine(view, error_px, true);
        f.us.push_back(us_since(start));
        if (!frame.whole) std::abort();
        f.triangles += frame.triangles;
    }
    f.triangles /= static_cast<double>(views.size());
    f.vertices = f.triangles / 2; // but for the rim
    return f;
}

Flight fly_cut(const Terrain& terrain, const std::vector<View>& views, const CutSettings& settings) {
    const CutInMemory in_memory(terrain, cut_budget);
    const LiveCut cut = in_memory.cut;
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
        f.uploaded +=
            report.vertices_changed * (sizeof(MeshVertex) + sizeof(MorphVertex)) + report.triangles_changed * 12.0;
        f.converged += report.converged;
        (void)cut_take_changes(cut);
    }
    const auto n = static_cast<double>(views.size());
    for (double* sum : {&f.vertices, &f.triangles, &f.drawn, &f.changes, &f.evaluations, &f.uploaded, &f.converged})
        *sum /= n;
    return f;
}

// As many samples a side around the middle of the mountains; beyond their rim they go on as in a mirror.
baker::Dem middle_of_mountains(std::int32_t side) {
    const baker::Dem all = baker::synthesise(FJELL_SOURCE_DIR "/content/terrain/mountains.json");
    baker::Dem part = all;
    part.columns = part.rows = side;
    part.heights_m.clear();
    part.heights_m.reserve(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
    const std::int32_t last = all.columns - 1, first = (last - (side - 1)) / 2;
    const auto mirrored = [&](std::int32_t at) {
        const std::int32_t round = ((first + at) % (2 * last) + 2 * last) % (2 * last);
        return round <= last ? round : 2 * last - round;
    };
    for (std::int32_t y = 0; y < side; ++y)
        for (std::int32_t x = 0; x < side; ++x) part.heights_m.push_back(all.at(mirrored(x), mirrored(y)));
    return part;
}

// The middle tenth of the mountains, a hundredth of the samples.
const Scene& small_mountains() {
    static const Scene scene{io::load_pack(bake_scene(
                                               "mountains-411", [] { return middle_of_mountains(411); }, 10),
                                           io::LoadTerrain::yes),
                             0.8};
    return scene;
}

// The folder of real height fields, as for the tests.
std::string canyon_file() {
    const char* const folder = std::getenv("FJELL_DATA");
    return std::string(folder ? folder : FJELL_SOURCE_DIR "/../shared/data") + "/dem/grand_canyon_60m_4097x2049_u8.png";
}
const Scene& canyon() {
    static const Scene scene = [] {
        const auto make = [] {
            baker::ReadOptions options;
            options.spacing_m = 60;
            options.zscale = 14.4;
            return baker::read_dem(canyon_file(), options);
        };
        return Scene{io::load_pack(bake_scene("canyon", make, 10), io::LoadTerrain::yes), 0.5};
    }();
    return scene;
}

// offscreen_: the same with what no view sees 8 times coarser. Both with the hysteresis of the profiles, and ahead of
// them, as plain_, without.
void compare(benchmark::State& state, const Scene& scene, double cells, double turns) {
    const Terrain& t = scene.pack.terrain;
    const std::vector<View> views = flight_views(t, cells, 600, turns);
    CutSettings settings;
    settings.max_error_px = scene.error_px;
    CutSettings plain_settings = settings;
    settings.hysteresis = 0.04;
    CutSettings offscreen_settings = settings;
    offscreen_settings.offscreen_factor = 8;
    Flight lean, recursive, plain, cut, offscreen;
    for (auto _ : state) {
        if (scene.lean) lean = fly_lean(*scene.lean, views, scene.error_px);
        recursive = fly_recursive(t, views, scene.error_px);
        plain = fly_cut(t, views, plain_settings);
        cut = fly_cut(t, views, settings);
        offscreen = fly_cut(t, views, offscreen_settings);
    }
    auto& c = state.counters;
    const double p50 = rank(cut.us, 0.5), p99 = rank(cut.us, 0.99);
    if (scene.lean) {
        c["lean_vertices"] = lean.vertices;
        c["lean_ns_per_vertex"] = rank(lean.us, 0.5) * 1000 / lean.vertices;
        c["lean_p50_us"] = rank(lean.us, 0.5);
        c["lean_ratio_p50"] = rank(lean.us, 0.5) / p50;
        c["lean_ratio_p99"] = rank(lean.us, 0.99) / p99;
        c["lean_over_offscreen_p50"] = rank(lean.us, 0.5) / rank(offscreen.us, 0.5);
        c["lean_over_offscreen_p99"] = rank(lean.us, 0.99) / rank(offscreen.us, 0.99);
        c["lean_over_offscreen_mean"] = mean(lean.us) / mean(offscreen.us);
        c["rec_over_lean"] = rank(recursive.us, 0.5) / recursive.vertices * lean.vertices / rank(lean.us, 0.5);
    }
    c["rec_vertices"] = recursive.vertices;
    c["rec_ns_per_vertex"] = rank(recursive.us, 0.5) * 1000 / recursive.vertices;
    c["rec_p50_us"] = rank(recursive.us, 0.5);
    c["rec_p99_us"] = rank(recursive.us, 0.99);
    c["plain_p50_us"] = rank(plain.us, 0.5);
    c["plain_p99_us"] = rank(plain.us, 0.99);
    c["plain_active"] = plain.vertices;
    c["plain_evaluations"] = plain.evaluations;
    c["p50_us"] = p50;
    c["p99_us"] = p99;
    c["p9999_us"] = rank(cut.us, 0.9999);
    c["max_us"] = rank(cut.us, 1);
    c["rec_ratio_p50"] = rank(recursive.us, 0.5) / p50;
    c["rec_ratio_p99"] = rank(recursive.us, 0.99) / p99;
    c["mean_us"] = mean(cut.us);
    c["offscreen_p50_us"] = rank(offscreen.us, 0.5);
    c["offscreen_p99_us"] = rank(offscreen.us, 0.99);
    c["offscreen_mean_us"] = mean(offscreen.us);
    c["offscreen_max_us"] = rank(offscreen.us, 1);
    c["offscreen_active"] = offscreen.vertices;
    c["offscreen_changes"] = offscreen.changes;
    c["offscreen_converged"] = offscreen.converged;
    c["active"] = cut.vertices;
    c["ns_per_active"] = p50 * 1000 / cut.vertices;
    c["changes"] = cut.changes;
    c["ns_per_change"] = cut.changes > 0 ? p50 * 1000 / cut.changes : 0;
    c["evaluations"] = cut.evaluations;
    c["rec_triangles"] = recursive.triangles;
    c["triangles"] = cut.triangles;
    c["drawn_triangles"] = cut.drawn;
    c["uploaded_share"] =
        cut.uploaded / (cut.vertices * (sizeof(MeshVertex) + sizeof(MorphVertex)) + cut.triangles * 12);
    c["converged"] = cut.converged;
}

// From nothing, with the view moving: every rebuild is of another place, so that neither caches nor branches know it.
void from_nothing(benchmark::State& state, double error_px) {
    constexpr CutBudget large_budget{1u << 22, 1u << 23, 1024, 1};
    const Scene& scene = mountains();
    const Terrain& t = scene.pack.terrain;
    std::vector<View> views = flight_views(t, 3, 200); // a place every 24 cells
    for (std::size_t i = 0; i * 8 < views.size(); ++i) views[i] = views[i * 8];
    views.resize((views.size() + 7) / 8);
    session::WorkerPool pool(2);
    std::vector<double> ns[2], lean_ns, lean_culled_ns; // of one worker and of two
    io::AlignedMemory memory[2];
    LiveCut cuts[2];
    CutSettings settings[2];
    for (std::uint32_t two = 0; two < 2; ++two) {
        CutBudget budget = error_px < 0.5 ? large_budget : cut_budget;
        budget.workers = two + 1;
        const std::size_t bytes = cut_bytes(t, budget);
        memory[two] = io::allocate(bytes);
        if (!create_cut(t, budget, {memory[two].get(), bytes}, cuts[two]).ok()) std::abort();
        settings[two].max_error_px = error_px;
        if (two != 0) settings[two].jobs = pool.jobs();
    }
    double triangles = 0;
    for (auto _ : state)
        for (const View& view : views) {
            for (std::uint32_t two = 0; two < 2; ++two) { // and a lean one after each, so that each finds cold caches
                CutReport report;
                const auto start = Clock::now();
                (void)rebuild_cut(cuts[two], {&view, 1}, settings[two], report);
                ns[two].push_back(us_since(start) * 1000 / report.triangles);
                triangles += report.triangles;
                if (!report.converged) return state.SkipWithError("a budget did not suffice");
                const auto lean_start = Clock::now();
                const auto frame = scene.lean->refine(view, error_px, two != 0);
                (two != 0 ? lean_culled_ns : lean_ns).push_back(us_since(lean_start) * 1000 / frame.triangles);
                if (!frame.whole) return state.SkipWithError("the strip did not suffice");
            }
        }
    state.counters["triangles"] = triangles / static_cast<double>(2 * ns[0].size());
    state.counters["ns_per_triangle"] = rank(ns[0], 0.5);
    state.counters["two_workers_ns_per_triangle"] = rank(ns[1], 0.5);
    state.counters["lean_ns_per_triangle"] = rank(lean_ns, 0.5);
    state.counters["lean_culled_ns_per_triangle"] = rank(lean_culled_ns, 0.5);
    state.counters["ratio"] = rank(lean_ns, 0.5) / rank(ns[0], 0.5);
    state.counters["two_workers_ratio"] = rank(lean_ns, 0.5) / rank(ns[1], 0.5);
}

// As many vertices from nothing, around the same eye, on 1,025, 4,097 and 16,385 squared: with the threshold at which
// each has 10,000. Tiles of 1,024, so that the largest has 256.
void from_nothing_sizes(benchmark::State& state) {
    constexpr double wanted = 10'000;
    const CutBudget budget{1u << 16, 1u << 18, 512, 1};
    double us[3] = {};
    for (auto _ : state)
        for (std::size_t n = 0; n < 3; ++n) {
            const std::int32_t side = (1024 << 2 * n) + 1;
            const std::string name = std::to_string(side);
            const io::LoadedPack pack =
                io::load_pack(bake_scene(
                                  "middle-" + name, [&] { return middle_of_mountains(side); }, 10),
                              io::LoadTerrain::yes);
            const std::vector<View> views = flight_views(pack.terrain, 3, 130);
            const std::size_t bytes = cut_bytes(pack.terrain, budget);
            const io::AlignedMemory memory = io::allocate(bytes);
            LiveCut cut;
            if (!create_cut(pack.terrain, budget, {memory.get(), bytes}, cut).ok()) std::abort();
            CutReport report;
            CutSettings settings;
            double low = std::log(0.1), high = std::log(1e3); // fewer vertices with a higher threshold
            for (int i = 0; i < 24; ++i) {
                settings.max_error_px = std::exp((low + high) / 2);
                (void)rebuild_cut(cut, {&views[views.size() / 2], 1}, settings, report);
                (report.vertices > wanted || !report.converged ? low : high) = std::log(settings.max_error_px);
            }
            std::vector<double> each;
            double vertices = 0;
            for (std::size_t i = 0; i < views.size(); i += 8) {
                const auto start = Clock::now();
                (void)rebuild_cut(cut, {&views[i], 1}, settings, report);
                each.push_back(us_since(start) * wanted / report.vertices);
                if (!report.converged) return state.SkipWithError("a budget did not suffice");
                vertices += report.vertices;
            }
            us[n] = rank(each, 0.5);
            state.counters["px_" + name] = settings.max_error_px;
            state.counters["vertices_" + name] = vertices / static_cast<double>(each.size());
            state.counters["us_" + name] = us[n];
        }
    state.counters["ratio_4097"] = us[1] / us[0];
    state.counters["ratio_16385"] = us[2] / us[0];
    state.counters["ratio_16385_to_4097"] = us[2] / us[1];
}

// A hundred times the samples around the same eye.
void compare_sizes(benchmark::State& state) {
    const Terrain &large = mountains().pack.terrain, &small = small_mountains().pack.terrain;
    CutSettings settings;
    settings.max_error_px = 8; // what there is to refine lies near
    std::vector<View> near_views = flight_views(small, 0.25, 600), views = near_views;
    for (View& view : views) view.eye_m = view.eye_m + Vec3{large.x_m(1843), 0, large.z_m(1843)};
    Flight of_small, of_large;
    for (auto _ : state) {
        of_small = fly_cut(small, near_views, settings);
        of_large = fly_cut(large, views, settings);
    }
    auto& c = state.counters;
    c["small_active"] = of_small.vertices;
    c["large_active"] = of_large.vertices;
    c["small_p50_us"] = rank(of_small.us, 0.5);
    c["large_p50_us"] = rank(of_large.us, 0.5);
    c["ratio_p50"] = rank(of_large.us, 0.5) / rank(of_small.us, 0.5);
    c["small_changes"] = of_small.changes;
    c["large_changes"] = of_large.changes;
}

} // namespace

int main(int argc, char** argv) {
    const auto declare_flight = [&](const std::string& what, double cells, double turns) {
        declare("mountains-4097/" + what, [=](benchmark::State& s) { compare(s, mountains(), cells, turns); });
        if (std::filesystem::exists(canyon_file()))
            declare("canyon/" + what, [=](benchmark::State& s) { compare(s, canyon(), cells, turns); });
    };
    declare_flight("turning", 0, turn);
    for (const double cells : {0.06, 0.25, 1.0, 3.0, 10.0})
        declare_flight(std::to_string(cells).substr(0, 4) + "-cells", cells, 0);
    declare_flight("1.00-cells-turning", 1, turn);
    declare("from-nothing/4px", [](benchmark::State& s) { from_nothing(s, 4); });
    declare("from-nothing/1px", [](benchmark::State& s) { from_nothing(s, 1); });
    declare("from-nothing/0.5px", [](benchmark::State& s) { from_nothing(s, 0.5); });
    declare("from-nothing/0.25px", [](benchmark::State& s) { from_nothing(s, 0.25); });
    declare("from-nothing/sizes", from_nothing_sizes);
    declare("sizes", compare_sizes);
    declare_frames_that_time_ends();
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    return 0;
}
