// What it costs to edit the ground: a crater of 64 x 64 samples until its bound holds, until its errors are measured
// again, until normal maps are made anew, and until a live cut shows it; a road; a lock; a hole; and beside them a bake
// of the same terrain, and what the same rectangle takes in a height field of Bullet's (bullet_us, where Bullet is
// installed).
//
// Names: edit/scene/what. Scenes: a part of the mountains of content/terrain with 1,025 x 1,025 samples, and all of it
// (4,097 x 4,097, 60 m), in tiles of 512 cells: what an edit costs must not grow with the terrain.
#include <benchmark/benchmark.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "fjell/cut.h"
#include "fjell/edit.h"
#include "fjell/ground_maps.h"
#include "fjell/io/load.h"
#include "fjell/query.h"
#include "support/dem.h"

#ifdef FJELL_BULLET
#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#endif

namespace {

using namespace fjell;
using Clock = std::chrono::steady_clock;

const baker::Dem& mountains() {
    static const baker::Dem dem = baker::synthesise(FJELL_SOURCE_DIR "/content/terrain/mountains.json");
    return dem;
}
baker::Dem part(std::int32_t samples) {
    baker::Dem dem = mountains();
    std::vector<float> heights_m;
    for (std::int32_t y = 0; y < samples; ++y)
        for (std::int32_t x = 0; x < samples; ++x) heights_m.push_back(dem.at(1200 + x, 1200 + y));
    dem.columns = dem.rows = samples;
    dem.heights_m = std::move(heights_m);
    return dem;
}

// The mountains again and again, each time the other way round, so that they meet; in the middle as they are.
baker::Dem mirrored(std::int32_t samples) {
    const baker::Dem& of = mountains();
    const std::int32_t cells = of.columns - 1;
    const auto at = [&](std::int32_t i) {
        const std::int32_t turn = (i + cells / 2) % (2 * cells);
        return turn <= cells ? turn : 2 * cells - turn;
    };
    baker::Dem dem = of;
    dem.columns = dem.rows = samples;
    dem.heights_m.resize(static_cast<std::size_t>(samples) * static_cast<std::size_t>(samples));
    for (std::int32_t y = 0; y < samples; ++y)
        for (std::int32_t x = 0; x < samples; ++x) dem.heights_m[dem.index(x, y)] = of.at(at(x), at(y));
    return dem;
}

struct Scene {
    io::LoadedPack pack;
    io::AlignedMemory edit_memory, cut_memory;
    Edits edits;
    LiveCut cut;
    View view;
    double bake_ms = 0;
};

void must(Status s) {
    if (!s.ok()) throw std::runtime_error(std::string(s.field) + ": " + message(s.code));
}

// metre: samples are a metre apart, and heights as much smaller.
Scene make(std::int32_t samples, bool holes = false, bool metre = false) {
    const std::string path = std::string(FJELL_BENCH_DIR) + "/edit-" + std::to_string(samples) +
                             (holes ? "-room" : "") + (metre ? "-metre" : "") + ".fjell";
    std::filesystem::create_directories(FJELL_BENCH_DIR);
    baker::BakeOptions options;
    options.tile_log2 = 9;
    options.max_texture_log2 = 9;
    options.room_for_holes = holes;
    baker::Dem dem = samples < 4097 ? part(samples) : samples == 4097 ? mountains() : mirrored(samples);
    if (metre) {
        for (float& height_m : dem.heights_m) height_m /= static_cast<float>(dem.spacing_m[0]);
        dem.spacing_m[0] = dem.spacing_m[1] = 1;
        dem.native_quantum_m = 0;
    }
    const auto started = Clock::now();
    (void)baker::bake(std::move(dem), options, path);
    Scene s{io::load_pack(path, io::LoadTerrain::yes), {}, {}, {}, {}, {}, 0};
    s.bake_ms = std::chrono::duration<double, std::milli>(Clock::now() - started).count();
    const EditBudget budget{.blocks = 16384, .stamps = 256, .areas = 256, .holes = holes};
    const std::size_t bytes = edits_bytes(s.pack.pack.header, budget);
    s.edit_memory = io::allocate(bytes);
    must(create_edits(s.pack.terrain, budget, {s.edit_memory.get(), bytes}, s.edits));
    const CutBudget cut{.vertices = 1'500'000, .triangles = 3'000'000};
    s.cut_memory = io::allocate(cut_bytes(s.pack.terrain, cut));
    must(create_cut(s.pack.terrain, cut, {s.cut_memory.get(), cut_bytes(s.pack.terrain, cut)}, s.cut));
    const double middle = static_cast<double>(s.pack.terrain.extent_x_m()) / 2;
    s.view = make_view({middle, static_cast<double>(s.pack.terrain.header().max_m) + 500, middle}, {0.3, -0.5, 1},
                       {0, 1, 0}, 1, 1920, 1080, 10, 1e6);
    CutReport report;
    must(update_cut(s.cut, {&s.view, 1}, {.max_error_px = 1}, report));
    return s;
}
Scene& scene(std::int32_t samples) {
    static std::map<std::int32_t, Scene> scenes; // made when they are asked for: the largest takes a minute and 3 GB
    const auto found = scenes.find(samples);
    return found != scenes.end() ? found->second : scenes.emplace(samples, make(samples)).first->second;
}

// The 65 x 65 samples around a crater, as physics takes them.
constexpr std::uint32_t patch_side = 65;

// A height field of 1,025 x 1,025 samples around the middle. Its heights are the host's: an update is to write them,
// and to make its tables for rays anew, which Bullet makes of the whole field.
class BulletField {
public:
    static constexpr int side = 1025;
    explicit BulletField(const Terrain& terrain)
        : first_{(static_cast<std::int32_t>(terrain.columns()) - side) / 2,
                 (static_cast<std::int32_t>(terrain.rows()) - side) / 2} {
        (void)ground_patch(terrain, first_, 0, side, heights_m_);
#ifdef FJELL_BULLET
        shape_.buildAccelerator();
#endif
    }
    // In microseconds; 0 without Bullet.
    double update(SampleIndex at, const std::vector<float>& patch_m) {
#ifdef FJELL_BULLET
        const auto started = Clock::now();
        for (std::uint32_t row = 0; row < patch_side; ++row)
            std::copy_n(patch_m.begin() + row * patch_side, patch_side,
                        heights_m_.begin() + (at.row - first_.row + static_cast<std::int32_t>(row)) * side +
                            (at.column - first_.column));
        shape_.buildAccelerator();
        return std::chrono::duration<double, std::micro>(Clock::now() - started).count();
#else
        (void)at, (void)patch_m;
        return 0;
#endif
    }

private:
    SampleIndex first_;
    std::vector<float> heights_m_ = std::vector<float>(std::size_t{side} * side); // the shape keeps their address
#ifdef FJELL_BULLET
    btHeightfieldTerrainShape shape_{side, side, heights_m_.data(), -1e4f, 1e4f, 1, false};
#endif
};

double median(std::vector<double>& v) {
    std::nth_element(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2), v.end());
    return v[v.size() / 2];
}

void crater(benchmark::State& state, std::int32_t samples) {
    Scene& s = scene(samples);
    const double cell = s.pack.terrain.spacing_x_m(), middle = static_cast<double>(s.pack.terrain.extent_x_m()) / 2;
    std::mt19937 random(1);
    std::uniform_real_distribution<double> any(-100, 100);
    std::vector<double> apply, measure, follow, quiet, patch, bullet, normals;
    std::uint64_t items = 0;
    BulletField field(s.pack.terrain);
    std::vector<float> patch_m(std::size_t{patch_side} * patch_side);
    // As if all tiles showed their normal maps, with a texel a sample.
    std::vector<TileMap> shown(s.pack.terrain.tile_count());
    for (std::uint32_t tile = 0; tile < shown.size(); ++tile) shown[tile] = {tile, 9, 0};
    const GroundMapsBudget map_budget{.texels = 1u << 20};
    const std::size_t map_bytes = ground_maps_bytes(s.pack.pack.header, map_budget);
    const io::AlignedMemory map_memory = io::allocate(map_bytes);
    GroundMaps maps;
    must(create_ground_maps(s.pack.terrain, map_budget, {map_memory.get(), map_bytes}, maps));
    GroundMapsReport made;
    do must(update_ground_maps(maps, shown, made));
    while (made.waiting != 0);
    for (auto _ : state) {
        Stamp stamp;
        stamp.shape = StampShape::crater;
        stamp.x_m = middle + any(random) * cell, stamp.z_m = middle + any(random) * cell;
        stamp.radius_m = static_cast<float>(24 * cell), stamp.falloff_m = static_cast<float>(8 * cell);
        stamp.amount_m = static_cast<float>(6 * cell);
        StampId id = 0;
        must(push_stamp(s.edits, stamp, id));
        EditReport report;
        EditSettings first;
        first.max_work = 1; // looked at and applied
        must(update_edits(s.edits, {&s.view, 1}, first, report));
        apply.push_back(report.apply_us);
        must(update_ground_maps(maps, shown, made));
        normals.push_back(made.update_us);
        const SampleIndex corner{static_cast<std::int32_t>(stamp.x_m / cell) - 32,
                                 static_cast<std::int32_t>(stamp.z_m / cell) - 32};
        const auto asked = Clock::now();
        (void)ground_patch(s.pack.terrain, corner, 0, patch_side, patch_m);
        patch.push_back(std::chrono::duration<double, std::micro>(Clock::now() - asked).count());
        bullet.push_back(field.update(corner, patch_m));
        CutReport cut;
        must(update_cut(s.cut, {&s.view, 1}, {.max_error_px = 1}, cut));
        follow.push_back(cut.prepare_us + cut.refine_us + cut.output_us);
        must(update_edits(s.edits, {&s.view, 1}, {}, report));
        measure.push_back(report.measure_us);
        items += report.work;
        must(update_cut(s.cut, {&s.view, 1}, {.max_error_px = 1}, cut));
        must(update_cut(s.cut, {&s.view, 1}, {.max_error_px = 1}, cut));
        quiet.push_back(cut.prepare_us + cut.refine_us + cut.output_us);
    }
    state.counters["apply_us"] = median(apply);
    state.counters["shown_us"] = median(follow);
    state.counters["measure_us"] = median(measure);
    state.counters["normals_us"] = median(normals);
    state.counters["patch_us"] = median(patch);
    state.counters["bullet_us"] = median(bullet);
    state.counters["quiet_us"] = median(quiet);
    state.counters["items"] = static_cast<double>(items) / static_cast<double>(state.iterations());
    state.counters["bake_ms"] = s.bake_ms;
}

void road(benchmark::State& state, std::int32_t samples) {
    Scene& s = scene(samples);
    const double cell = s.pack.terrain.spacing_x_m(), middle = static_cast<double>(s.pack.terrain.extent_x_m()) / 2;
    double apply_us = 0, measure_us = 0;
    int n = 0;
    for (auto _ : state) { // 1,000 x 12 samples, across pages and tiles
        const double from = middle - 500 * cell + (n % 7) * cell,
                     height = static_cast<double>(s.pack.terrain.header().min_m) + 100 + 10 * (n % 5);
        const StampPoint points[3] = {
            {from, from + 40 * cell, static_cast<float>(height)},
            {middle, middle, static_cast<float>(height + 40)},
            {middle + 200 * cell, middle - 600 * cell + 200 * cell, static_cast<float>(height)}};
        Stamp stamp;
        stamp.shape = StampShape::path;
        stamp.points = points, stamp.point_count = 3;
        stamp.radius_m = static_cast<float>(6 * cell), stamp.falloff_m = static_cast<float>(4 * cell);
        StampId id = 0;
        must(push_stamp(s.edits, stamp, id));
        EditReport report;
        must(update_edits(s.edits, {&s.view, 1}, {}, report));
        must(stamp_state(s.edits, id).status);
        apply_us += report.apply_us;
        measure_us += report.measure_us;
        ++n;
    }
    state.counters["apply_us"] = apply_us / n;
    state.counters["measure_us"] = measure_us / n;
}

// A road of a kilometre over samples a metre apart, locked to 5 cm and unlocked; a crater on it in between, which is
// measured with the lock, and one beside it.
void lock(benchmark::State& state, std::int32_t samples) {
    static std::map<std::int32_t, Scene> scenes;
    if (!scenes.contains(samples)) scenes.emplace(samples, make(samples, false, true));
    Scene& s = scenes.at(samples);
    const double cell = s.pack.terrain.spacing_x_m(), middle = static_cast<double>(s.pack.terrain.extent_x_m()) / 2;
    std::vector<double> lock_apply, lock_measure, crater_apply, crater_measure, beside, beside_measure, unlock, shown;
    std::uint32_t before = count_always_drawn(s.edits), drawn = 0;
    for (auto _ : state) {
        const double from = middle - 500 * cell + static_cast<double>(lock_apply.size() % 7) * cell;
        const StampPoint points[2] = {{from, from + 40 * cell, 0}, {from + 1000 * cell, from + 300 * cell, 0}};
        const auto push = [&](const Stamp& stamp, std::vector<double>& applied, std::vector<double>* measured) {
            StampId id = 0;
            must(push_stamp(s.edits, stamp, id));
            EditReport report;
            must(update_edits(s.edits, {&s.view, 1}, {}, report));
            must(stamp_state(s.edits, id).status);
            applied.push_back(report.apply_us);
            if (measured != nullptr) measured->push_back(report.measure_us);
        };
        Stamp stamp;
        stamp.shape = StampShape::lock;
        stamp.points = points, stamp.point_count = 2;
        stamp.radius_m = static_cast<float>(3 * cell), stamp.amount_m = 0.05f;
        push(stamp, lock_apply, &lock_measure);
        drawn = std::max(drawn, count_always_drawn(s.edits) - before);
        CutReport cut;
        must(update_cut(s.cut, {&s.view, 1}, {.max_error_px = 1}, cut));
        shown.push_back(cut.prepare_us + cut.refine_us + cut.output_us);
        Stamp crater;
        crater.shape = StampShape::crater;
        crater.x_m = from + 500 * cell, crater.z_m = from + 170 * cell;
        crater.radius_m = static_cast<float>(24 * cell), crater.falloff_m = static_cast<float>(8 * cell);
        crater.amount_m = static_cast<float>(6 * cell);
        push(crater, crater_apply, &crater_measure);
        crater.z_m += 300 * cell;
        push(crater, beside, &beside_measure);
        stamp.shape = StampShape::unlock;
        push(stamp, unlock, nullptr);
    }
    state.counters["apply_us"] = median(lock_apply);
    state.counters["measure_us"] = median(lock_measure);
    state.counters["unlock_us"] = median(unlock);
    state.counters["crater_us"] = median(crater_apply);
    state.counters["crater_measure_us"] = median(crater_measure);
    state.counters["beside_us"] = median(beside);
    state.counters["beside_measure_us"] = median(beside_measure);
    state.counters["shown_us"] = median(shown);
    state.counters["always_drawn"] = drawn;
}

// A shaft of 32 samples across that is cut, shown, and filled again; and a crater as above beside it, on ground that
// may have holes and whose errors count in the steps that this takes.
void shaft(benchmark::State& state) {
    static Scene s = make(1025, true);
    const double cell = s.pack.terrain.spacing_x_m(), middle = static_cast<double>(s.pack.terrain.extent_x_m()) / 2;
    std::mt19937 random(1);
    std::uniform_real_distribution<double> any(-100, 100);
    std::vector<double> apply, measure, follow, fill, fill_measure, apply_crater;
    for (auto _ : state) {
        Stamp stamp;
        stamp.x_m = middle + any(random) * cell, stamp.z_m = middle + any(random) * cell;
        const auto push = [&](StampShape shape, std::vector<double>& applied, std::vector<double>* measured) {
            stamp.shape = shape;
            StampId id = 0;
            must(push_stamp(s.edits, stamp, id));
            EditReport report;
            must(update_edits(s.edits, {&s.view, 1}, {.max_work = 1}, report));
            applied.push_back(report.apply_us);
            must(stamp_state(s.edits, id).status);
            CutReport cut;
            must(update_cut(s.cut, {&s.view, 1}, {.max_error_px = 1}, cut));
            if (shape == StampShape::hole) follow.push_back(cut.prepare_us + cut.refine_us + cut.output_us);
            must(update_edits(s.edits, {&s.view, 1}, {}, report));
            if (measured != nullptr) measured->push_back(report.measure_us);
            must(update_cut(s.cut, {&s.view, 1}, {.max_error_px = 1}, cut));
        };
        stamp.radius_m = static_cast<float>(24 * cell), stamp.falloff_m = static_cast<float>(8 * cell);
        stamp.amount_m = static_cast<float>(6 * cell);
        push(StampShape::crater, apply_crater, nullptr);
        stamp.radius_m = static_cast<float>(16 * cell), stamp.falloff_m = 0;
        push(StampShape::hole, apply, &measure);
        push(StampShape::fill, fill, &fill_measure);
    }
    state.counters["apply_us"] = median(apply);
    state.counters["measure_us"] = median(measure);
    state.counters["shown_us"] = median(follow);
    state.counters["fill_us"] = median(fill);
    state.counters["fill_measure_us"] = median(fill_measure);
    state.counters["crater_us"] = median(apply_crater);
}

} // namespace

int main(int argc, char** argv) {
    for (const std::int32_t samples : {1025, 4097, 16385}) {
        const std::string of = "edit/" + std::to_string(samples) + "/";
        benchmark::RegisterBenchmark((of + "crater").c_str(), crater, samples)->Iterations(60);
        benchmark::RegisterBenchmark((of + "road").c_str(), road, samples)->Iterations(6);
        if (samples < 16385) benchmark::RegisterBenchmark((of + "lock").c_str(), lock, samples)->Iterations(15);
    }
    benchmark::RegisterBenchmark("edit/1025/shaft", shaft)->Iterations(60);
    benchmark::Initialize(&argc, argv);
    benchmark::RunSpecifiedBenchmarks();
}
