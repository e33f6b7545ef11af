// The host's job system: whatever threads it has, and in whatever order they work, the cut is the same bit for bit.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cstring>
#include <numeric>
#include <thread>
#include <type_traits>
#include <vector>

#include "shared/terrain_data.h"
#include "support/cut_scene.h"
#include "support/rounds.h"

using namespace fjell;
using namespace fjell::test;

namespace {

// One thread, in any order.
struct Shuffled {
    Random random{7};
    std::uint32_t calls = 0, jobs = 0;
    static void run(void* user, std::uint32_t count, void (*job)(void*, std::uint32_t), void* data) {
        auto& self = *static_cast<Shuffled*>(user);
        std::vector<std::uint32_t> order(count);
        std::iota(order.begin(), order.end(), 0u);
        std::shuffle(order.begin(), order.end(), self.random);
        for (const std::uint32_t index : order) job(data, index);
        ++self.calls;
        self.jobs += count;
    }
};

// As many threads as there are jobs.
void run_threads(void*, std::uint32_t count, void (*job)(void*, std::uint32_t), void* data) {
    std::vector<std::thread> threads;
    for (std::uint32_t index = 1; index < count; ++index) threads.emplace_back(job, data, index);
    job(data, 0);
    for (std::thread& thread : threads) thread.join();
}

template <typename T>
bool same_bytes(std::span<T> a, std::type_identity_t<std::span<T>> b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
}

// A cut after an update.
struct Updated {
    Updated(Cut& of, const CutReport& said)
        : cut(of), report(said), mesh(cut_mesh(of.cut)), changes(cut_take_changes(of.cut)) {}
    Cut& cut;
    CutReport report;
    CutMesh mesh;
    CutChanges changes;
};

std::string difference(const Updated& a, const Updated& b) {
    const CutReport &r = a.report, &q = b.report;
    if (r.vertices != q.vertices || r.triangles != q.triangles || r.triangles_drawn != q.triangles_drawn)
        return "the counts differ";
    if (r.visits != q.visits || r.work != q.work || r.evaluations != q.evaluations) return "the work differs";
    if (r.exhausted != q.exhausted || r.converged != q.converged || r.waiting != q.waiting ||
        r.error_bound_px != q.error_bound_px || r.vertices_changed != q.vertices_changed ||
        r.triangles_changed != q.triangles_changed)
        return "what is said differs";
    const std::size_t used = a.cut.state().mesh.fresh_vertex;
    if (used != b.cut.state().mesh.fresh_vertex) return "other slots are used";
    if (!same_bytes(a.mesh.mesh.vertices.first(used), b.mesh.mesh.vertices.first(used))) return "vertices differ";
    if (!same_bytes(a.mesh.morph.first(used), b.mesh.morph.first(used))) return "how vertices morph differs";
    if (!same_bytes(a.mesh.mesh.tiles, b.mesh.mesh.tiles)) return "draw ranges differ";
    for (const TileRange& range : a.mesh.mesh.tiles)
        if (!same_bytes(a.mesh.mesh.indices.subspan(range.first_index, range.index_count),
                        b.mesh.mesh.indices.subspan(range.first_index, range.index_count)))
            return "indices differ";
    if (!same_bytes(a.changes.vertex_bits, b.changes.vertex_bits) ||
        !same_bytes(a.changes.triangle_bits, b.changes.triangle_bits))
        return "what has changed differs";
    return {};
}

} // namespace

TEST_CASE("a cut is the same bit for bit with any number of workers, in whatever order their jobs are done") {
    Random random(211);
    Shuffled shuffled;
    int jumps = 0;
    for (int round = 0; round < rounds(10, 80); ++round) {
        const auto pack = round % 3 == 0 ? rich_terrain(random, 200, 5)
                                         : random_terrain(random, round % 5 == 4 ? 400 : 160, round % 5 == 4 ? 7 : 5);
        const Terrain& terrain = pack.terrain;
        CutBudget budget = ample_cut(terrain);
        if (round % 4 == 1) budget.vertices = std::max(budget.vertices / 8, terrain.tile_count() * 4 + 100);
        Cut alone(terrain, budget);
        budget.workers = static_cast<std::uint32_t>(pick(random, 2, 4));
        Cut mixed(terrain, budget), threaded(terrain, budget);
        CutSettings settings;
        settings.max_error_px = random_threshold(random) / 4;
        settings.morph = round % 2 == 1 ? Morph::error : Morph::none;
        settings.offscreen_factor = round % 5 == 2 ? 8 : 1;
        View view = random_view(random, terrain);
        for (int frame = 0; frame < 24; ++frame) {
            const bool rebuild = frame % 11 == 10;
            view = frame % 8 == 0 ? random_view(random, terrain) : moved(random, view, random_step_m(random, terrain));
            settings.visits =
                pick(random, 0, 3) == 0 ? unlimited_work : static_cast<std::uint32_t>(pick(random, 1, 90));
            settings.max_work =
                pick(random, 0, 1) == 0 ? unlimited_work : static_cast<std::uint32_t>(pick(random, 1, 4'000));
            settings.now_s += 1.0 / 60;
            const auto step = [&](Cut& cut, JobSystem jobs) {
                settings.jobs = jobs;
                return rebuild ? cut.rebuild({&view, 1}, settings) : cut.update({&view, 1}, settings);
            };
            const Updated should_be(alone, step(alone, {})),
                in_any_order(mixed, step(mixed, {&Shuffled::run, &shuffled})),
                on_threads(threaded, step(threaded, {&run_threads, nullptr}));
            CAPTURE(round, frame, settings.max_error_px, settings.visits, rebuild, budget.workers, budget.vertices);
            jumps += mixed.state().bulk.phase != BulkPhase::idle;
            REQUIRE(check_cut(mixed) == "");
            REQUIRE(difference(in_any_order, should_be) == "");
            REQUIRE(difference(on_threads, should_be) == "");
        }
    }
    CHECK(jumps > rounds(20, 150));
    CHECK(shuffled.jobs > rounds<std::uint32_t>(1000, 10'000));
}
