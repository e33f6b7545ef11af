// Ground that is edited while other threads hand in stamps and ask for heights: nothing is torn, nobody waits, and
// every answer is within its error of ground that there was.
#include <catch2/catch.hpp>

#include <atomic>
#include <cmath>
#include <thread>
#include <vector>

#include "fjell/edit.h"
#include "fjell/ground_maps.h"
#include "fjell/query.h"
#include "support/cut_scene.h"
#include "support/rounds.h"
#include "support/stream_scene.h"

using namespace fjell;
using namespace fjell::test;

TEST_CASE("stamps and queries come from any thread", "[edit][threads]") {
    Random random(20261201);
    baker::Dem dem = random_dem(random, 129, 129, Shape::flat);
    dem.spacing_m[0] = dem.spacing_m[1] = 1;
    for (float& h : dem.heights_m) h = 100;
    dem.heights_m[0] = 0, dem.heights_m[1] = 300; // the range of the scales
    dem.native_quantum_m = 0.25;
    const auto pack = bake_and_load(std::move(dem), small_bake(5));
    const std::size_t bytes = edits_bytes(pack.terrain.header(), {});
    const auto memory = io::allocate(bytes);
    Edits edits;
    REQUIRE(create_edits(pack.terrain, {}, {memory.get(), bytes}, edits).ok());
    Cut cut(pack.terrain, ample_cut(pack.terrain));
    const double low_m = 100, high_m = 110;
    std::atomic<bool> stop{false};
    std::atomic<int> pushed{0}, asked{0}, wrong{0};
    std::vector<std::thread> threads;
    for (unsigned n = 0; n < 2; ++n)
        threads.emplace_back([&, n] {
            for (int k = 0; !stop; ++k) {
                Stamp stamp;
                stamp.shape = StampShape::level;
                stamp.x_m = 60 + 10 * n, stamp.z_m = 64, stamp.radius_m = 12, stamp.falloff_m = 8;
                stamp.height_m = static_cast<float>(k % 2 == 0 ? high_m : low_m);
                StampId id = 0;
                pushed += push_stamp(edits, stamp, id).ok();
                (void)stamp_state(edits, id);
                std::this_thread::yield();
            }
        });
    for (unsigned n = 0; n < 2; ++n)
        threads.emplace_back([&, n] {
            Random own(n);
            while (!stop) {
                const double x = uniform(own, 30, 98), z = uniform(own, 30, 98);
                const GroundHeight height = ground_height(pack.terrain, x, z);
                const double error = static_cast<double>(height.error_m) + 1e-3;
                wrong += height.height_m < low_m - error || height.height_m > high_m + error;
                const GroundHit hit = cast_ray(pack.terrain, {x, 500, z}, {0, -1, 0}, 1000);
                wrong += hit.hit && (hit.position_m.y < low_m - 1e-3 - static_cast<double>(hit.error_m) ||
                                     hit.position_m.y > high_m + 1e-3 + static_cast<double>(hit.error_m));
                ++asked;
            }
        });
    const View view = make_view({64, 160, 64}, {0.3, -1, 0.2}, {0, 1, 0}, 1, 800, 600, 0.1, 1000);
    int samples = 0;
    // On one core the other threads may not have begun when the last of few frames is over.
    for (int frame = 0; frame < rounds(40, 120) || samples == 0 || asked < 100 || pushed < 4; ++frame) {
        EditReport report;
        EditSettings settings;
        settings.max_work = 6; // every stamp is one or two
        REQUIRE(update_edits(edits, {&view, 1}, settings, report).ok());
        samples += static_cast<int>(report.samples);
        (void)cut.update({&view, 1}, {.max_error_px = 1});
        std::this_thread::yield();
    }
    stop = true;
    for (std::thread& thread : threads) thread.join();
    CHECK(wrong == 0);
    CHECK(destroy_edits(edits).ok());
}

TEST_CASE("four threads stamp, two ask, one streams and one draws", "[edit][threads]") {
    Random random(20261206);
    baker::Dem dem = random_dem(random, 257, 257, Shape::flat);
    dem.spacing_m[0] = dem.spacing_m[1] = 1;
    for (float& h : dem.heights_m) h = 100;
    dem.heights_m[0] = 0, dem.heights_m[1] = 300;
    dem.native_quantum_m = 0.25;
    baker::BakeOptions options = small_bake(7);
    options.max_texture_log2 = 6;
    options.horizon_spacing = 2;
    const auto pack = bake_and_load(std::move(dem), options);
    StreamBudget budget;
    budget.tail_log2 = 3;
    budget.horizons = true; // whose readers ask for heights
    Streamed on(pack.pack, 0, budget);
    const Terrain& terrain = on.paged.terrain;
    const std::size_t bytes = edits_bytes(terrain.header(), {}), map_bytes = ground_maps_bytes(terrain.header());
    const auto memory = io::allocate(bytes), map_memory = io::allocate(map_bytes);
    Edits edits;
    REQUIRE(create_edits(terrain, {}, {memory.get(), bytes}, edits).ok());
    GroundMaps maps;
    REQUIRE(create_ground_maps(terrain, {}, {map_memory.get(), map_bytes}, maps).ok());
    const double low_m = 100, high_m = 110;
    std::atomic<bool> stop{false};
    std::atomic<int> pushed{0}, painted{0}, asked{0}, wrong{0}, given{0};
    std::vector<std::thread> threads;
    for (unsigned n = 0; n < 4; ++n)
        threads.emplace_back([&, n] {
            for (int k = 0; !stop; ++k) {
                Stamp stamp;
                const bool paints = n >= 2;
                stamp.shape = !paints ? StampShape::level : k % 3 == 0 ? StampShape::unpaint : StampShape::paint;
                stamp.x_m = 100 + 14 * n, stamp.z_m = 120 + (paints ? k % 40 : 0);
                stamp.radius_m = 12, stamp.falloff_m = 8;
                stamp.height_m = static_cast<float>(k % 2 == 0 ? high_m : low_m);
                stamp.rgb[0] = static_cast<std::uint8_t>(k);
                StampId id = 0;
                (paints ? painted : pushed) += push_stamp(edits, stamp, id).ok();
                (void)stamp_state(edits, id);
                std::this_thread::yield();
            }
        });
    for (unsigned n = 0; n < 2; ++n)
        threads.emplace_back([&, n] {
            Random own(n);
            while (!stop) {
                const double x = uniform(own, 60, 190), z = uniform(own, 60, 190);
                const GroundHeight height = ground_height(terrain, x, z);
                const double error = static_cast<double>(height.error_m) + 1e-3;
                wrong += height.height_m < low_m - error || height.height_m > high_m + error;
                ++asked;
            }
        });
    threads.emplace_back([&] {
        while (!stop) {
            StreamRequest r;
            if (!stream_next_request(on.stream, r)) {
                std::this_thread::yield();
                continue;
            }
            given += stream_provide(on.stream, r.ticket, pack.pack.bytes.subspan(r.offset, r.bytes)).ok();
        }
    });
    int samples = 0;
    std::uint64_t patches = 0;
    StreamSettings settings;
    CutSettings cut;
    cut.max_error_px = 1;
    for (int frame = 0; frame < rounds(60, 300) || samples == 0 || asked < 100 || pushed < 4 || painted < 4 ||
                        patches == 0 || given < 20;
         ++frame) {
        const double away = frame % 20 < 10 ? 60 : 400;
        const View view = make_view({120, 100 + away, 120}, {0.3, -1, 0.2}, {0, 1, 0}, 1, 800, 600, 0.1, 2000);
        settings.now_s += 1.0 / 60;
        EditReport report;
        REQUIRE(update_edits(edits, {&view, 1}, {.max_work = 12}, report).ok());
        samples += static_cast<int>(report.samples);
        (void)on.update({&view, 1}, cut, settings);
        (void)on.cut.update({&view, 1}, cut);
        REQUIRE(note_map_commands(maps, stream_map_commands(on.stream)).ok());
        GroundMapsReport made;
        REQUIRE(update_ground_maps(maps, stream_tile_maps(on.stream, MapKind::normal), made).ok());
        for (const MapPatch& p : ground_map_patches(maps)) patches += p.map == MapKind::colour;
        std::this_thread::yield();
    }
    stop = true;
    for (std::thread& thread : threads) thread.join();
    CHECK(wrong == 0);
    CHECK(destroy_edits(edits).ok());
}
