// Ground that is edited while other threads hand in stamps and ask for heights: nothing is torn, nobody waits, and
// every answer is within its error of ground that there was.
#include <catch2/catch.hpp>

#include <atomic>
#include <cmath>
#include <thread>
#include <vector>

#include "fjell/edit.h"
#include "fjell/query.h"
#include "support/cut_scene.h"
#include "support/rounds.h"

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
