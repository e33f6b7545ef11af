// Streams that are asked for too much: too few slots for what is near, clients that answer what nobody asked, packs
// whose directory lies, settings that change with every frame.
#include <catch2/catch.hpp>

#include <cstring>
#include <limits>

#include <xxhash.h>

#include "stream/requests.h"
#include "support/stream_scene.h"

using namespace fjell;
using namespace fjell::test;

namespace {

// Pages of several levels in many tiles.
host::LoadedPack wide_terrain(Random& random, int samples = 700, int tile_log2 = 7) {
    return bake_and_load(random_dem(random, samples, samples, Shape::fractal), small_bake(tile_log2));
}

View near_ground(Random& random, const Terrain& t) {
    const double x = uniform(random, 0, t.x_m(t.tree.columns() - 1)), z = uniform(random, 0, t.z_m(t.tree.rows() - 1));
    const double cell = t.spacing_x_m;
    return make_view({x, t.ground_m(x, z) + 3 * cell, z}, {uniform(random, -1, 1), -0.3, uniform(random, -1, 1)},
                     {0, 1, 0}, 0.8, 1280, 720, cell / 10, 1e4 * cell);
}

// Frames until twenty in a row in which nothing came, went or was asked for; `most` when there were none.
int frames_to_rest(Streamed& on, ScriptedClient& client, const View& view, const CutSettings& cut,
                   StreamSettings& settings, int most) {
    std::uint64_t read = 0;
    for (int frame = 0, quiet = 0; frame < most; ++frame) {
        settings.now_s += 1.0 / 60;
        client.act();
        const StreamReport r = on.update({&view, 1}, cut, settings);
        client.follow();
        (void)on.cut.update({&view, 1}, cut);
        quiet = page_arrivals(on.stream).empty() && r.pages_read == read && r.requested == 0 ? quiet + 1 : 0;
        read = r.pages_read;
        if (quiet == 20) return frame;
    }
    return most;
}

} // namespace

TEST_CASE("with too few slots a resting eye's pages come to rest: none is let go of for one that gives it back its slot") {
    Random random(921);
    for (int round = 0; round < 4; ++round) {
        const auto pack = wide_terrain(random);
        const auto tiles = static_cast<int>(pack.terrain.tile_count());
        const auto slots = static_cast<std::uint32_t>(pick(random, tiles + 3, tiles * 5 / 2));
        StreamBudget budget;
        budget.page_requests = static_cast<std::uint32_t>(pick(random, 1, 32));
        Streamed on(pack.pack, slots, budget);
        ScriptedClient client(random, on, {.most_delay = pick(random, 0, 3)});
        CutSettings cut;
        cut.error_px = 0.5;
        StreamSettings settings;
        for (int leg = 0; leg < 12; ++leg) {
            const View view = near_ground(random, pack.terrain);
            CAPTURE(round, leg, slots, budget.page_requests);
            // Every page of the terrain could come and go several times.
            const int most = 8 * static_cast<int>(pack.terrain.page_count());
            REQUIRE(frames_to_rest(on, client, view, cut, settings, most) < most);
            REQUIRE(check_stream(on) == "");
        }
    }
}
