// Queries of other threads while pages come and go: every answer keeps its own bound. Means most under the tsan preset.
#include <catch2/catch.hpp>

#include <atomic>
#include <thread>
#include <vector>

#include "fjell/query.h"
#include "shared/terrain_data.h"
#include "support/ground_truth.h"
#include "support/rounds.h"

using namespace fjell;
using namespace fjell::test;

namespace {

#if defined(FJELL_SANITIZED)
std::uint64_t changes_wanted() {
    return 3'000;
}
#else
std::uint64_t changes_wanted() {
    return rounds<std::uint64_t>(20'000, 100'000);
}
#endif

struct Count {
    std::uint64_t answers = 0, exact = 0, coarse = 0, wrong = 0, hits = 0;

    bool enough() const { return answers > 100 && exact > 0 && coarse > 0 && hits > 100; }
};

// One answer of each kind; what is wrong is counted, because Catch2 belongs to the first thread.
void ask(Random& random, const Terrain& full, const Terrain& paged, Count& count) {
    const PackHeader& h = full.header();
    const double column = uniform(random, 0, data_of(full).tree.columns() - 1),
                 row = uniform(random, 0, data_of(full).tree.rows() - 1);
    const double x = column * h.spacing_m[0], z = row * h.spacing_m[1];
    const double slack = rounding_m(full) + 0x1p-22 * static_cast<double>(h.max_error_m);
    const TruePlane truth = true_plane(full, column, row);
    const GroundHeight height = ground_height(paged, x, z);
    if (!truth.hole && !height.hole)
        count.wrong +=
            !(std::abs(height.height_m - at(truth, column, row)) <= static_cast<double>(height.error_m) + slack);
    (height.finest ? count.exact : count.coarse)++;

    const Vec3 origin{x, static_cast<double>(h.max_m) + 10, z};
    const Vec3 target{uniform(random, 0, data_of(full).tree.columns() - 1) * h.spacing_m[0],
                      static_cast<double>(h.min_m), uniform(random, 0, data_of(full).tree.rows() - 1) * h.spacing_m[1]};
    const GroundHit hit = cast_ray(paged, origin, target - origin, 1e9);
    if (hit.hit) {
        const double u = hit.position_m.x / h.spacing_m[0], v = hit.position_m.z / h.spacing_m[1];
        const TruePlane under = true_plane(full, u, v);
        // The place is rounded, and with it the height, by the steepest slope there may be.
        const double loss = slack + 0x1p-40 * h.height_steps *
                                        static_cast<double>(data_of(full).height_scale.quantum_m) *
                                        (data_of(full).tree.columns() + data_of(full).tree.rows());
        if (!under.hole)
            count.wrong += !(std::abs(hit.position_m.y - at(under, u, v)) <= static_cast<double>(hit.error_m) + loss);
        ++count.hits;
    }

    constexpr std::uint32_t side = 9;
    float heights[side * side];
    bool holes[side * side];
    const SampleIndex first{static_cast<std::int32_t>(column) - 4, static_cast<std::int32_t>(row) - 4};
    const GroundPatch patch = ground_patch(paged, first, 0, side, heights, holes);
    for (std::uint32_t i = 0; i < side * side; ++i) {
        const SampleIndex c{std::clamp(first.column + static_cast<int>(i % side), 0, data_of(full).tree.columns() - 1),
                            std::clamp(first.row + static_cast<int>(i / side), 0, data_of(full).tree.rows() - 1)};
        const TerrainData::Vertex v = data_of(full).vertex(c);
        const double float_m = 0x1p-22 * (std::abs(h.min_m) + std::abs(h.max_m));
        if (!v.hole && !holes[i])
            count.wrong += !(std::abs(heights[i] - v.height_m) <= patch.error_m + slack + float_m);
    }
    ++count.answers;
}

// Takes pages in and out at random, many more than there are slots, until a reader has `seen` enough of it: how fast
// readers are beside this thread differs from machine to machine.
std::uint64_t stir(Random& random, const Pack& pack, Terrain& terrain, const std::atomic<bool>& seen) {
    std::uint64_t refused = 0;
    const std::uint32_t pages = terrain.page_count();
    const auto tile_of = [&](std::uint32_t n) { return n / terrain.pages_per_tile(); };
    const auto page_of = [&](std::uint32_t n) { return n % terrain.pages_per_tile(); };
    const std::uint64_t least = changes_wanted();
    while (data_of(terrain).changes < least || (!seen && data_of(terrain).changes < 1000 * least)) {
        const auto n = static_cast<std::uint32_t>(pick(random, 0, static_cast<int>(pages) - 1));
        const Status s = load_page(pack, terrain, tile_of(n), page_of(n));
        refused += !s.ok();
        // The slot that was given back last is the next to be filled: a reader's page is replaced at once.
        if (s.code != StatusCode::out_of_slots && pick(random, 0, 2) != 0) continue;
        const std::uint32_t held =
            data_of(terrain).slot_page[pick(random, 0, static_cast<int>(data_of(terrain).slot_count) - 1)];
        if (held != no_index) (void)unload_page(terrain, tile_of(held), page_of(held));
    }
    return refused;
}

} // namespace

TEST_CASE("while one thread loads and unloads pages, every answer of others keeps its bound") {
    Random random(621);
    for (const PageOrder order : {PageOrder::planar, PageOrder::hierarchical_z, PageOrder::linear}) {
        baker::Dem dem = random_dem(random, 500, 400, Shape::noise); // no vertex is like its neighbours
        dem.spacing_m[0] = dem.spacing_m[1] = 10;
        // Levels far from each other, so that a height with another page's base is far off.
        for (std::int32_t y = 0; y < dem.rows; ++y)
            for (std::int32_t x = 0; x < dem.columns; ++x)
                dem.heights_m[dem.index(x, y)] += static_cast<float>(((x / 64) * 7 + (y / 64) * 3) % 5 * 400);
        baker::BakeOptions options = small_bake(8);
        options.order = order;
        const auto pack = bake_and_load(std::move(dem), options);
        const std::uint32_t slots = pack.terrain.page_count() / 4;
        PagedTerrain paged(pack.pack, {slots});
        std::atomic<bool> done{false}, seen{false};
        constexpr int readers = 3;
        std::vector<Count> counts(readers);
        std::vector<std::thread> threads;
        for (int i = 0; i < readers; ++i)
            threads.emplace_back([&, i] {
                Random own(static_cast<unsigned>(700 + i));
                Count& count = counts[static_cast<std::size_t>(i)];
                while (!done.load(std::memory_order_relaxed)) {
                    ask(own, pack.terrain, paged.terrain, count);
                    if (count.enough()) seen.store(true, std::memory_order_relaxed);
                }
            });
        const std::uint64_t refused = stir(random, pack.pack, paged.terrain, seen);
        done = true;
        for (std::thread& thread : threads) thread.join();
        Count all;
        for (const Count& c : counts) {
            all.answers += c.answers, all.exact += c.exact, all.coarse += c.coarse, all.wrong += c.wrong;
            all.hits += c.hits;
        }
        INFO(all.answers << " answers, " << all.exact << " exact, " << refused << " loads refused");
        CHECK(all.wrong == 0);
        CHECK(all.answers > 100);
        CHECK(all.exact > 0);
        CHECK(all.coarse > 0);
        CHECK(all.hits > 100);
    }
}
