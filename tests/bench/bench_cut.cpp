// The live cut against recursion: the same terrain, views, threshold and run. lean_ is the strongest recursion that we
// can write (rivals/lean_recursion.h), rec_ our recursive method; both cull, because that is how they are fast, and
// their nanoseconds a vertex are printed so that nobody has to doubt them. No case repeats a view, and none rebuilds
// between frames but where it says so.
//
// Names: cut/scene/what. Scenes: the mountains of content/terrain (4097 x 4097, 60 m) and, when the folder of real data
// is there, the Grand Canyon. Every case is one flight; its counters are percentiles over frames.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <memory>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "baker/bake/bake.h"
#include "fjell/cut.h"
#include "fjell/io/load.h"
#include "fjell/measure.h"
#include "fjell/recursive.h"
#include "flight/worker_pool.h"
#include "pack/terrain_data.h"
#include "rivals/lean_recursion.h"
#include "support/dem.h"

namespace {

using namespace fjell;
using Clock = std::chrono::steady_clock;

double us_since(Clock::time_point start) {
    return std::chrono::duration<double, std::micro>(Clock::now() - start).count();
}

struct Scene {
    io::LoadedPack pack;
    double error_px = 1;                                   // where the recursive method selects about 100,000 vertices
    std::shared_ptr<rivals::LeanRecursion> lean = nullptr; // for squares
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

constexpr double turn = 17.0 / 60 / 57.29578; // a frame, at 17 degrees a second

// Over the middle, 400 m above ground, `cells` a frame, straight on or turning. cells 0: turning on the spot.
std::vector<View> flight(const Terrain& t, double cells, std::size_t frames, double turns = 0) {
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

struct Flight {
    std::vector<double> us;
    double vertices = 0, triangles = 0, drawn = 0, changes = 0, evaluations = 0, uploaded = 0, converged = 0;
};
double rank(std::vector<double> v, double share) {
    std::sort(v.begin(), v.end());
    const auto n = static_cast<std::size_t>(std::ceil(share * static_cast<double>(v.size())));
    return v[std::clamp<std::size_t>(n, 1, v.size()) - 1];
}

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

// Of the lean recursion nothing is bounded: its strip holds whatever comes.
rivals::LeanRecursion make_lean(const Terrain& terrain) {
    return {terrain, std::size_t{1} << 24};
}

Flight fly_lean(rivals::LeanRecursion& lean, const std::vector<View>& views, double error_px) {
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

const CutBudget cut_budget{1u << 21, 1u << 22, 1024, 1};

Flight fly_cut(const Terrain& terrain, const std::vector<View>& views, const CutSettings& settings) {
    const std::size_t bytes = cut_bytes(terrain, cut_budget);
    const io::AlignedMemory memory = io::allocate(bytes);
    LiveCut cut;
    if (!create_cut(terrain, cut_budget, {memory.get(), bytes}, cut).ok()) std::abort();
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

const Scene& mountains() {
    static const Scene scene = [] {
        const auto make = [] { return baker::synthesise(FJELL_SOURCE_DIR "/content/terrain/mountains.json"); };
        Scene s{io::load_pack(bake_scene("mountains", make, 10), io::LoadTerrain::yes), 0.8};
        s.lean = std::make_shared<rivals::LeanRecursion>(make_lean(s.pack.terrain));
        return s;
    }();
    return scene;
}

// The middle tenth of the mountains, a hundredth of the samples.
const Scene& small_mountains() {
    static const Scene scene = [] {
        const auto make = [] {
            const baker::Dem all = baker::synthesise(FJELL_SOURCE_DIR "/content/terrain/mountains.json");
            baker::Dem part = all;
            part.columns = part.rows = 411;
            part.heights_m.clear();
            for (std::int32_t y = 0; y < part.rows; ++y)
                for (std::int32_t x = 0; x < part.columns; ++x) part.heights_m.push_back(all.at(1843 + x, 1843 + y));
            return part;
        };
        return Scene{io::load_pack(bake_scene("mountains-411", make, 10), io::LoadTerrain::yes), 0.8};
    }();
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

// offscreen_: the same with what no view sees 8 times coarser.
void compare(benchmark::State& state, const Scene& scene, double cells, double turns) {
    const Terrain& t = scene.pack.terrain;
    const std::vector<View> views = flight(t, cells, 600, turns);
    CutSettings settings;
    settings.error_px = scene.error_px;
    CutSettings offscreen_settings = settings;
    offscreen_settings.offscreen_factor = 8;
    Flight lean, recursive, cut, offscreen;
    for (auto _ : state) {
        if (scene.lean) lean = fly_lean(*scene.lean, views, scene.error_px);
        recursive = fly_recursive(t, views, scene.error_px);
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
    const Scene& scene = mountains();
    const Terrain& t = scene.pack.terrain;
    std::vector<View> views = flight(t, 3, 200); // a place every 24 cells
    for (std::size_t i = 0; i * 8 < views.size(); ++i) views[i] = views[i * 8];
    views.resize((views.size() + 7) / 8);
    flight::WorkerPool pool(2);
    std::vector<double> ns[2], lean_ns, lean_culled_ns; // of one worker and of two
    io::AlignedMemory memory[2];
    LiveCut cuts[2];
    CutSettings settings[2];
    for (std::uint32_t two = 0; two < 2; ++two) {
        CutBudget budget = cut_budget;
        budget.workers = two + 1;
        const std::size_t bytes = cut_bytes(t, budget);
        memory[two] = io::allocate(bytes);
        if (!create_cut(t, budget, {memory[two].get(), bytes}, cuts[two]).ok()) std::abort();
        settings[two].error_px = error_px;
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

// A hundred times the samples around the same eye.
void compare_sizes(benchmark::State& state) {
    const Terrain &large = mountains().pack.terrain, &small = small_mountains().pack.terrain;
    CutSettings settings;
    settings.error_px = 8; // what there is to refine lies near
    std::vector<View> near_views = flight(small, 0.25, 600), views = near_views;
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

// The time that the thread has worked, in microseconds: what neighbours take of the core does not count.
double thread_us() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) * 1e6 + static_cast<double>(now.tv_nsec) * 1e-3;
}

void report_ranks(benchmark::State& state, std::vector<double>& us, const std::string& of) {
    state.counters[of + "p50_us"] = rank(us, 0.5);
    state.counters[of + "p99_us"] = rank(us, 0.99);
    state.counters[of + "p9999_us"] = rank(us, 0.9999);
    state.counters[of + "max_us"] = rank(us, 1);
}

// A random place every 500 frames, turning, 300 us a frame: does a frame ever take longer than a loop that does nothing
// for as long? By the thread's own time, in turns.
void teleport_budget(benchmark::State& state, double offscreen_factor) {
    const Terrain& t = mountains().pack.terrain;
    const std::size_t bytes = cut_bytes(t, cut_budget);
    const io::AlignedMemory memory = io::allocate(bytes);
    LiveCut cut;
    if (!create_cut(t, cut_budget, {memory.get(), bytes}, cut).ok()) std::abort();
    CutSettings settings;
    settings.error_px = 2;
    settings.budget_us = 300;
    settings.offscreen_factor = offscreen_factor;
    std::vector<double> us, spin_us;
    double converged = 0;
    std::uint32_t seed = 1;
    const auto random = [&] { return (seed = seed * 1664525 + 1013904223) / 4294967296.0; };
    std::vector<View> views = flight(t, 0.25, 1);
    for (auto _ : state)
        for (int frame = 0; frame < 100'000; ++frame) {
            View& view = views[0];
            if (frame % 500 == 0) {
                view.eye_m = {random() * t.x_m(4096), 0, random() * t.z_m(4096)};
                view.eye_m.y = data_of(t).ground_m(view.eye_m.x, view.eye_m.z) + 400;
            }
            view.eye_m = view.eye_m + Vec3{12, 0, -9};
            const double angle = frame * 0.005;
            view.forward = {std::sin(angle), 0, std::cos(angle)}, view.up = {0, 1, 0};
            CutReport report;
            double start = thread_us();
            if (!update_cut(cut, views, settings, report).ok()) std::abort();
            us.push_back(thread_us() - start);
            converged += report.converged;
            start = thread_us();
            for (const Clock::time_point begin = Clock::now(); us_since(begin) < settings.budget_us;) {
            }
            spin_us.push_back(thread_us() - start);
        }
    report_ranks(state, us, "");
    report_ranks(state, spin_us, "spin_");
    state.counters["p9999_over_spin"] = rank(us, 0.9999) / rank(spin_us, 0.9999);
    state.counters["converged"] = converged / 100'000;
}

// A cell a frame in less time than that takes: what does the mesh claim to keep, and what does it cost to say so?
void lag(benchmark::State& state, double budget_us) {
    const Scene& scene = mountains();
    const Terrain& t = scene.pack.terrain;
    const std::size_t bytes = cut_bytes(t, cut_budget);
    const io::AlignedMemory memory = io::allocate(bytes);
    LiveCut cut;
    if (!create_cut(t, cut_budget, {memory.get(), bytes}, cut).ok()) std::abort();
    CutSettings settings;
    settings.error_px = scene.error_px;
    std::vector<double> claimed_px, output_us;
    double unbounded = 0;
    for (auto _ : state) {
        const std::vector<View> views = flight(t, 1, 600);
        CutReport report;
        (void)rebuild_cut(cut, {&views[0], 1}, settings, report);
        settings.budget_us = budget_us;
        for (const View& view : views) {
            (void)update_cut(cut, {&view, 1}, settings, report);
            claimed_px.push_back(report.error_px_effective);
            output_us.push_back(report.output_us);
            unbounded += report.error_px_effective >= unbounded_px;
        }
    }
    state.counters["claimed_p50_px"] = rank(claimed_px, 0.5);
    state.counters["claimed_p90_px"] = rank(claimed_px, 0.9);
    state.counters["unbounded_share"] = unbounded / static_cast<double>(claimed_px.size());
    state.counters["output_p50_us"] = rank(output_us, 0.5);
}

// Of the vertices that a view will show in the end, the share that a mesh has.
class Visible {
public:
    Visible(const Terrain& terrain, const View& view, double error_px)
        : columns_(static_cast<std::size_t>(data_of(terrain).tree.columns())),
          flags_(columns_ * static_cast<std::size_t>(data_of(terrain).tree.rows())) {
        const std::size_t bytes = cut_bytes(terrain, cut_budget);
        const io::AlignedMemory memory = io::allocate(bytes);
        LiveCut cut;
        if (!create_cut(terrain, cut_budget, {memory.get(), bytes}, cut).ok()) std::abort();
        CutSettings settings;
        settings.error_px = error_px;
        CutReport report;
        (void)rebuild_cut(cut, {&view, 1}, settings, report);
        const Frustum frustum = make_frustum(view);
        for_each_vertex(cut_mesh(cut).mesh, [&](const MeshVertex& v) {
            const Vec3 p = Vec3{terrain.x_m(v.column), v.height_m, terrain.z_m(v.row)} - view.eye_m;
            bool inside = true;
            for (int i = 0; i < 6; ++i) inside = inside && dot(frustum.normal[i], p) >= frustum.offset[i];
            std::uint8_t& flag = flags_[at(v)];
            count_ += inside && flag == 0;
            flag = inside;
        });
    }
    [[nodiscard]] double share(const MeshView& mesh) const {
        std::vector<std::uint8_t> left = flags_;
        std::size_t found = 0;
        for_each_vertex(mesh, [&](const MeshVertex& v) { found += std::exchange(left[at(v)], std::uint8_t{0}); });
        return static_cast<double>(found) / static_cast<double>(count_);
    }
    [[nodiscard]] std::size_t count() const { return count_; }

private:
    template <typename Visit>
    static void for_each_vertex(const MeshView& mesh, const Visit& visit) {
        for (const TileRange& range : mesh.tiles)
            for (std::uint32_t i = range.first_index; i < range.first_index + range.index_count; ++i)
                visit(mesh.vertices[mesh.indices[i]]);
    }
    [[nodiscard]] std::size_t at(const MeshVertex& v) const {
        return static_cast<std::size_t>(v.row) * columns_ + static_cast<std::size_t>(v.column);
    }
    std::size_t columns_, count_ = 0;
    std::vector<std::uint8_t> flags_;
};

// Teleports in succession with 2 ms a frame, each from the mesh that the last one left: how much of what the view will
// show stands after five frames, and after how many does 99% of it?
void teleport_recovery(benchmark::State& state) {
    const Scene& scene = mountains();
    const Terrain& t = scene.pack.terrain;
    const std::size_t bytes = cut_bytes(t, cut_budget);
    const io::AlignedMemory memory = io::allocate(bytes);
    LiveCut cut;
    if (!create_cut(t, cut_budget, {memory.get(), bytes}, cut).ok()) std::abort();
    CutSettings settings;
    settings.error_px = scene.error_px;
    std::vector<double> frames_to_99;
    double after_five = 0;
    constexpr int teleports = 8;
    for (auto _ : state)
        for (int n = 0; n < teleports; ++n) {
            View view = flight(t, 0.25, 1)[0];
            view.eye_m.x = t.x_m(1024 + 2048 * (n % 2)), view.eye_m.z = t.z_m(700 + 380 * n);
            view.eye_m.y = data_of(t).ground_m(view.eye_m.x, view.eye_m.z) + 400;
            const Visible whole(t, view, settings.error_px);
            state.counters["visible_vertices"] = static_cast<double>(whole.count());
            settings.budget_us = 2000;
            CutReport report;
            int frame = 1;
            for (; frame <= 200; ++frame) {
                (void)update_cut(cut, {&view, 1}, settings, report);
                const double share = whole.share(cut_mesh(cut).mesh);
                if (frame == 5) after_five += share / teleports;
                if (share >= 0.99) break;
            }
            frames_to_99.push_back(frame);
            if (frame < 5) after_five += 1.0 / teleports;
        }
    state.counters["frames_to_99"] = rank(frames_to_99, 0.5);
    state.counters["share_after_5"] = after_five;
    state.counters["frames_to_99_worst"] = rank(frames_to_99, 1);
}

} // namespace

int main(int argc, char** argv) {
    const auto declare = [](const std::string& name, auto run) {
        benchmark::RegisterBenchmark(("cut/" + name).c_str(), run)->Unit(benchmark::kMillisecond)->Iterations(1);
    };
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
    declare("sizes", compare_sizes);
    declare("lag-1500us", [](benchmark::State& s) { lag(s, 1500); });
    declare("lag-500us", [](benchmark::State& s) { lag(s, 500); });
    declare("teleport-300us/all-around", [](benchmark::State& s) { teleport_budget(s, 1); });
    declare("teleport-300us/offscreen-8", [](benchmark::State& s) { teleport_budget(s, 8); });
    declare("teleport-2ms", teleport_recovery);
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    return 0;
}
