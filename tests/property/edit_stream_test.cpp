// Moving ground in a host's hands: what a stamp waits for is loaded, though no view wants it; and a host takes stamps
// back.
#include <catch2/catch.hpp>

#include <algorithm>

#include "fjell/edit.h"
#include "fjell/query.h"
#include "support/rounds.h"
#include "support/stream_scene.h"

using namespace fjell;
using namespace fjell::test;

TEST_CASE("a stamp that waits until all is measured around it does not wait for ever", "[edit]") {
    Random random(20261205);
    int waited = 0, applied = 0, refused = 0, partial = 0;
    for (int round = 0; round < rounds(8, 60); ++round) {
        const io::LoadedPack pack =
            bake_and_load(random_dem(random, pick(random, 260, 520), pick(random, 260, 520), Shape::fractal),
                          small_bake(pick(random, 7, 8)));
        const double wx = pack.terrain.extent_x_m(), wz = pack.terrain.extent_z_m(), cell = pack.terrain.spacing_x_m();
        Streamed on(pack.pack, 0);
        ScriptedClient client(random, on, {.most_delay = 2});
        const std::size_t bytes = edits_bytes(on.paged.terrain.header());
        const io::AlignedMemory memory = io::allocate(bytes);
        Edits edits;
        REQUIRE(create_edits(on.paged.terrain, {}, {memory.get(), bytes}, edits).ok());
        // Far away, and content with next to nothing.
        const View view = make_view({wx / 2, 40 * wx, wz / 2}, {0.01, -1, 0.01}, {0, 0, 1}, 1, 640, 480, 1, 100 * wx);
        CutSettings cut;
        cut.max_error_px = 1000;
        StreamSettings settings;
        EditReport report;
        const auto step = [&] {
            settings.now_s += 1.0 / 60;
            client.act();
            REQUIRE(update_edits(edits, {&view, 1}, {}, report).ok());
            (void)on.update({&view, 1}, cut, settings);
            client.follow();
            (void)on.cut.update({&view, 1}, cut);
        };
        for (int frame = 0; frame < 60; ++frame) step();
        const std::uint32_t missing = data_of(on.paged.terrain).pages_missing;
        std::vector<StampId> ids;
        // A gentle one leaves errors to be measured. Steeper ones beside it ask for codes that there may not be.
        for (int i = 0; i < 4; ++i) {
            Stamp stamp;
            stamp.x_m = (0.45 + 0.03 * i) * wx, stamp.z_m = 0.5 * wz;
            stamp.radius_m = static_cast<float>(4 * cell),
            stamp.falloff_m = static_cast<float>(i % 2 == 0 ? 3 * cell : 0);
            const double range = static_cast<double>(pack.terrain.header().max_m - pack.terrain.header().min_m);
            stamp.amount_m = static_cast<float>(range * (i == 0 ? 0.05 : uniform(random, 0.1, 1.2)));
            ids.push_back(0);
            REQUIRE(push_stamp(edits, stamp, ids.back()).ok());
        }
        int frames = 0;
        bool waits = true;
        for (; waits && frames < 3000; ++frames) {
            step();
            waits = false;
            for (const StampId id : ids) waits = waits || stamp_state(edits, id).state == StampState::waiting;
            waited += report.held != 0;
        }
        CAPTURE(round, frames, report.held, report.unmeasured, report.loose, missing);
        CHECK_FALSE(waits);
        for (const StampId id : ids) {
            const StampResult result = stamp_state(edits, id);
            applied += result.state == StampState::applied, refused += result.state == StampState::refused;
        }
        partial += data_of(on.paged.terrain).pages_missing > 0; // not all was loaded for it
    }
    CHECK(partial * 10 > rounds(8, 60) * 9); // of a small terrain all may be needed
    CHECK(waited > 0);
    CHECK(applied > 4);
    CHECK(refused > 0);
}

TEST_CASE("a patch of before, pushed as heights, takes a stamp back bit for bit", "[edit]") {
    Random random(20261207);
    baker::Dem dem = random_dem(random, 200, 180, Shape::fractal);
    dem.spacing_m[0] = dem.spacing_m[1] = 4;
    const auto [low, high] = std::minmax_element(dem.heights_m.begin(), dem.heights_m.end());
    dem.native_quantum_m = (static_cast<double>(*high) - static_cast<double>(*low)) / 4096; // floats tell its steps
    const io::LoadedPack pack = bake_and_load(std::move(dem), small_bake(6));
    const Terrain& terrain = pack.terrain;
    const std::size_t bytes = edits_bytes(terrain.header());
    const io::AlignedMemory memory = io::allocate(bytes);
    Edits edits;
    REQUIRE(create_edits(terrain, {}, {memory.get(), bytes}, edits).ok());
    const auto state = [&] {
        std::vector<std::uint32_t> all;
        for (std::int32_t row = 0; row < 180; ++row)
            for (std::int32_t column = 0; column < 200; ++column) {
                const TerrainData::Vertex v = data_of(terrain).vertex({column, row});
                all.insert(all.end(), {static_cast<std::uint32_t>(v.steps), v.error_code,
                                       static_cast<std::uint32_t>(v.radius_m * 1024)});
            }
        return all;
    };
    const auto applied = [&](const Stamp& stamp) {
        StampId id = 0;
        EditReport report;
        REQUIRE(push_stamp(edits, stamp, id).ok());
        REQUIRE(update_edits(edits, {}, {}, report).ok());
        return stamp_state(edits, id).state == StampState::applied;
    };
    const double cell = terrain.spacing_x_m(),
                 range = static_cast<double>(terrain.header().max_m - terrain.header().min_m);
    constexpr std::int32_t side = 64;
    std::vector<std::vector<std::uint32_t>> states{state()};
    std::vector<std::vector<float>> patches;
    std::vector<SampleIndex> places;
    for (int i = 0; i < 8; ++i) {
        const SampleIndex first{pick(random, 0, 200 - side), pick(random, 0, 180 - side)};
        std::vector<float> before(side * side);
        (void)ground_patch(terrain, first, 0, side, before);
        Stamp stamp;
        stamp.x_m = (first.column + side / 2) * cell, stamp.z_m = (first.row + side / 2) * cell;
        stamp.radius_m = static_cast<float>(12 * cell), stamp.falloff_m = static_cast<float>(10 * cell);
        stamp.amount_m = static_cast<float>(range * uniform(random, -0.05, 0.05));
        if (!applied(stamp)) continue;
        states.push_back(state());
        patches.push_back(before), places.push_back(first);
    }
    REQUIRE(patches.size() > 3);
    while (!patches.empty()) {
        Stamp back;
        back.shape = StampShape::heights;
        back.first = places.back(), back.columns = back.rows = side, back.heights_m = patches.back().data();
        REQUIRE(applied(back));
        states.pop_back(), patches.pop_back(), places.pop_back();
        CHECK((state() == states.back()));
    }
    EditReport report;
    REQUIRE(update_edits(edits, {}, {}, report).ok());
    CHECK(report.blocks == 0);
}
