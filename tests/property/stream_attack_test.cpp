// Streams that are asked for too much: too few slots for what is near, clients that answer what was not requested,
// packs whose directory lies, settings that change with every frame.
#include <catch2/catch.hpp>

#include <cstring>
#include <limits>

#include <xxhash.h>

#include "shared/terrain_data.h"
#include "stream/requests.h"
#include "support/rounds.h"
#include "support/stream_scene.h"

using namespace fjell;
using namespace fjell::test;

namespace {

// Pages of several levels in many tiles.
io::LoadedPack wide_terrain(Random& random, int samples = 700, int tile_log2 = 7) {
    return bake_and_load(random_dem(random, samples, samples, Shape::fractal), small_bake(tile_log2));
}

View near_ground(Random& random, const Terrain& t) {
    const double x = uniform(random, 0, t.x_m(data_of(t).tree.columns() - 1)),
                 z = uniform(random, 0, t.z_m(data_of(t).tree.rows() - 1));
    const double cell = t.spacing_x_m();
    return make_view({x, data_of(t).ground_m(x, z) + 3 * cell, z},
                     {uniform(random, -1, 1), -0.3, uniform(random, -1, 1)}, {0, 1, 0}, 0.8, 1280, 720, cell / 10,
                     1e4 * cell);
}

// Frames until twenty in a row in which nothing came, went or was requested; `most` when there were none.
int frames_to_rest(Streamed& on, ScriptedClient& client, const View& view, const CutSettings& cut,
                   StreamSettings& settings, int most) {
    std::uint64_t read = 0;
    for (int frame = 0, quiet = 0; frame < most; ++frame) {
        settings.now_s += 1.0 / 60;
        client.act();
        const StreamReport r = on.update({&view, 1}, cut, settings);
        client.follow();
        (void)on.cut.update({&view, 1}, cut);
        quiet = stream_page_arrivals(on.stream).empty() && r.pages_read == read && r.in_flight == 0 ? quiet + 1 : 0;
        read = r.pages_read;
        if (quiet == 20) return frame;
    }
    return most;
}

} // namespace

TEST_CASE(
    "with too few slots a resting eye's pages come to rest: none is let go of for one that gives it back its slot") {
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
        cut.max_error_px = 0.5;
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

TEST_CASE("answers to what was not requested change nothing: wrong tickets, second answers, another request's bytes") {
    Random random(922);
    std::uint64_t refused = 0, crossed = 0;
    for (int round = 0; round < 3; ++round) {
        const auto pack = wide_terrain(random, 400, 6);
        Streamed on(pack.pack, pack.terrain.page_count() / 2 + pack.terrain.tile_count());
        ScriptedClient client(random, on, {.most_delay = 4});
        const auto bytes_of = [&](const StreamRequest& r) { return pack.pack.bytes.subspan(r.offset, r.bytes); };
        std::vector<StreamRequest> old;
        StreamSettings settings;
        CutSettings cut;
        cut.max_error_px = 20;
        std::uint32_t taken_twice = 0;
        for (int frame = 0; frame < 200; ++frame) {
            const View view = near_ground(random, pack.terrain);
            settings.now_s += 1.0 / 60;
            client.act();
            for (int n = 0; n < 10; ++n) { // invented ones; those that are held would be answered rightly
                const auto ticket = static_cast<std::uint32_t>(n == 0 ? 0 : n == 1 ? 0xffffffff : random());
                if (std::any_of(client.held.begin(), client.held.end(),
                                [&](const auto& h) { return h.request.ticket == ticket; }))
                    continue;
                REQUIRE_FALSE(stream_still_wanted(on.stream, ticket));
                REQUIRE(stream_provide(on.stream, ticket, bytes_of({1, {}, 1, 0, 512})).code ==
                        StatusCode::out_of_range);
                (void)stream_fail(on.stream, ticket, n % 2 != 0);
                ++refused;
            }
            for (const StreamRequest& r : old) { // answered before
                REQUIRE(stream_provide(on.stream, r.ticket, bytes_of(r)).code == StatusCode::out_of_range);
                (void)stream_fail(on.stream, r.ticket);
                ++refused;
            }
            old.clear();
            StreamRequest a, b;
            if (stream_next_request(on.stream, a)) {
                if (stream_next_request(on.stream, b)) {
                    // As long as the right one, and another's.
                    std::vector<std::byte> wrong(a.bytes);
                    std::memcpy(wrong.data(), bytes_of(b).data(), std::min(a.bytes, b.bytes));
                    REQUIRE(stream_provide(on.stream, a.ticket, wrong).code == StatusCode::corrupt);
                    ++crossed;
                    REQUIRE(stream_provide(on.stream, a.ticket, bytes_of(a)).code ==
                            StatusCode::out_of_range); // too late
                    REQUIRE(stream_provide(on.stream, b.ticket, bytes_of(b)).ok());
                    old.push_back(b);
                } else {
                    (void)stream_fail(on.stream, a.ticket, true);
                }
                old.push_back(a);
            }
            (void)on.update({&view, 1}, cut, settings);
            client.follow();
            taken_twice += static_cast<std::uint32_t>(client.read_twice);
            const CutReport report = on.cut.update({&view, 1}, cut);
            REQUIRE(check_stream(on) == "");
            if (frame % 20 == 0) REQUIRE(check_frame(on.cut, pack.terrain, report, cut) == "");
            if (frame % 50 == 0) (void)stream_retry_failed(on.stream);
        }
        REQUIRE(taken_twice == 0);
    }
    REQUIRE(refused > 1000);
    REQUIRE(crossed > 50);
}

TEST_CASE(
    "with one request of each kind, one slot a tile and maps' tails alone, a stream is complete and stays whole") {
    Random random(923);
    for (int round = 0; round < 6; ++round) {
        const int log2 = round < 3 ? round + 1 : 6; // tiles of 2, 4 and 8 cells: no page but the coarsest
        baker::Dem dem = random_dem(random, 2 + (8 << log2) / (round < 3 ? 1 : 2),
                                    2 + (6 << log2) / (round < 3 ? 1 : 2), Shape::fractal);
        baker::BakeOptions options = small_bake(log2);
        options.max_texture_log2 = round % 2 ? 6 : 4;
        const auto pack = bake_and_load(std::move(dem), options);
        StreamBudget budget;
        budget.page_requests = budget.map_requests = 1;
        budget.tail_log2 = 2;
        budget.map_bytes = 0;
        for (const MapKind kind : {MapKind::colour, MapKind::normal})
            budget.map_bytes += map_layer_bytes(map_layers(pack.pack.header, budget, kind), kind);
        REQUIRE(budget.map_bytes > 0);
        StreamBudget less = budget;
        --less.map_bytes;
        PagedTerrain paged(pack.pack, {pack.terrain.tile_count()});
        REQUIRE(stream_bytes(pack.pack, paged.terrain, less) == 0);
        Streamed on(pack.pack, pack.terrain.tile_count(), budget, max_cut_views);
        ScriptedClient client(random, on, {.most_delay = 2});
        CutSettings cut;
        StreamSettings settings;
        StreamReport report;
        const int most = 100 + 12 * static_cast<int>(pack.terrain.tile_count()); // a request at a time, three kinds
        for (int frame = 0; frame < most; ++frame) {
            std::vector<View> views(max_cut_views);
            for (View& view : views) view = random_view(random, pack.terrain);
            cut.max_error_px = random_threshold(random);
            settings.now_s += 1.0 / 60;
            client.act();
            report = on.update(views, cut, settings);
            client.follow();
            const CutReport drawn = on.cut.update(views, cut);
            if (frame % 60 == 0) {
                REQUIRE(check_stream(on) == "");
                REQUIRE(check_frame(on.cut, pack.terrain, drawn, cut) == "");
            }
        }
        CAPTURE(round, log2, pack.terrain.tile_count(), report.page_slots.used);
        CHECK(report.complete);
        CHECK(report.map_bytes_used <= budget.map_bytes);
        if (pack.terrain.pages_per_tile() == 1) CHECK(on.paged.terrain.pages_missing() == 0);
    }
}

TEST_CASE("a threshold that changes with every frame starves no page, however few may be looked at in one") {
    Random random(924);
    const auto pack = wide_terrain(random, 700, 8);
    Streamed on(pack.pack, 0);
    ScriptedClient client(random, on, {});
    const View view = view_from_above(pack.terrain, 0.01);
    CutSettings cut;
    StreamSettings settings;
    settings.tests = 1; // with the 63 beside it
    // Every watch is looked at once a round; every round brings at least one more page while one is missing.
    const int around = static_cast<int>(on.state().watch_count) / 64 + 2;
    for (int frame = 0; frame < around * static_cast<int>(pack.terrain.page_count()); ++frame) {
        cut.max_error_px = frame % 2 ? 0.0010 : 0.0011;
        settings.now_s += 1.0 / 60;
        client.act();
        (void)on.update({&view, 1}, cut, settings);
        client.follow();
    }
    std::uint32_t missing = 0; // of those whose like is there: pages beyond the rim nobody wants
    settings.tests = 1u << 20;
    for (int frame = 0; frame < 4; ++frame) missing = on.update({&view, 1}, cut, settings).pages_wanted;
    CHECK(missing == 0);
    CHECK(on.paged.terrain.pages_missing() < 3 * pack.terrain.page_count() / 4);
}

TEST_CASE("clocks that jump and eyes that are nowhere leave a stream as good as new") {
    Random random(925);
    const auto pack = wide_terrain(random, 500, 7);
    Streamed on(pack.pack, 0);
    ScriptedClient client(random, on, {});
    CutSettings cut;
    cut.max_error_px = 5;
    StreamSettings settings;
    const double clocks[] = {0, 1e-320, 2e-320, 3600, 3600, 1e18, 1.7e308, -1e9, 1e-9};
    View view = near_ground(random, pack.terrain);
    for (int frame = 0; frame < 400; ++frame) {
        const double x = view.eye_m.x;
        view = near_ground(random, pack.terrain);
        if (frame % 3 == 0) view.eye_m = Vec3{1, -1, 1} * std::pow(10.0, uniform(random, 0, 6));
        if (frame % 2 == 0) view.eye_m.x = x; // at rest one way, in no time
        settings.now_s = clocks[frame % 9];
        client.act();
        (void)on.update({&view, 1}, cut, settings);
        client.follow();
        REQUIRE(check_stream(on) == "");
        for (std::uint32_t i = 0; i < on.state().eye_count; ++i)
            REQUIRE(std::isfinite(on.state().eyes[i].x + on.state().eyes[i].y + on.state().eyes[i].z));
    }
    // A flight so long that the odometer has gone round many times, then at rest: neither more nor less is there.
    settings.now_s = 0;
    const View rest = near_ground(random, pack.terrain);
    for (int frame = 0; frame < 400; ++frame) {
        view = rest;
        view.eye_m.x += frame % 2 ? 3e5 * pack.terrain.spacing_x_m() : 0.01 * frame;
        settings.now_s += 1.0 / 60;
        client.act();
        (void)on.update({&view, 1}, cut, settings);
        client.follow();
    }
    REQUIRE(frames_to_rest(on, client, rest, cut, settings, 2000) < 2000);
    const StreamReport report = on.update({&rest, 1}, cut, settings);
    CHECK(report.converged);
    CHECK(settle(on.cut, {&rest, 1}, cut, 100).converged);
    CHECK(difference(active_set(on.cut), target_set(pack.terrain, pack.terrain, {&rest, 1}, cut.max_error_px)) == "");
}

TEST_CASE("settings that are no numbers, or beyond their ranges, are refused and change nothing") {
    Random random(926);
    const auto pack = wide_terrain(random, 200, 6);
    Streamed on(pack.pack, 0);
    const View view = near_ground(random, pack.terrain);
    (void)on.update({&view, 1}, {}, {});
    const std::uint64_t frame = on.state().frame;
    const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
    StreamReport report;
    for (const double bad : {nan, inf, -inf, -1.0}) {
        StreamSettings s[4];
        s[0].texel_px = s[1].lookahead_s = s[2].fade_s = bad;
        s[3].now_s = bad == -1.0 ? nan : bad;
        for (const StreamSettings& settings : s)
            CHECK(update_stream(on.stream, {&view, 1}, {}, settings, report).code == StatusCode::out_of_range);
        CutSettings cuts[5]; // what update_cut() refuses, too
        cuts[0].max_error_px = cuts[1].hysteresis = cuts[2].morph_s = bad;
        cuts[3].max_time_us = cuts[4].now_s = bad == -1.0 || bad == inf ? nan : bad;
        for (const CutSettings& cut : cuts)
            CHECK(update_stream(on.stream, {&view, 1}, cut, {}, report).code == StatusCode::out_of_range);
        View odd = view;
        odd.eye_m.y = bad == -1.0 ? nan : bad;
        CHECK_FALSE(update_stream(on.stream, {&odd, 1}, {}, {}, report).ok());
    }
    CutSettings odd_morph;
    odd_morph.morph = static_cast<Morph>(3);
    CHECK(update_stream(on.stream, {&view, 1}, odd_morph, {}, report).code == StatusCode::out_of_range);
    const std::vector<View> many(max_cut_views + 1, view);
    CHECK(update_stream(on.stream, many, {}, {}, report).code == StatusCode::out_of_range);
    CHECK(update_stream(on.stream, {}, {}, {}, report).code == StatusCode::out_of_range);
    CHECK(on.state().frame == frame);
    for (const std::uint32_t requests : {0u, 257u, 0xffffffffu}) {
        PagedTerrain paged(pack.pack, {});
        StreamBudget budget;
        budget.page_requests = requests;
        CHECK(stream_bytes(pack.pack, paged.terrain, budget) == 0);
        budget = {};
        budget.map_requests = requests;
        CHECK(stream_bytes(pack.pack, paged.terrain, budget) == 0);
    }
}

namespace {

// The pack with other directory entries, and hashes that fit them.
struct Forged {
    std::vector<std::byte> file;
    Pack pack;
    template <typename Change>
    Forged(const io::LoadedPack& from, const Change& change) : file(from.file) {
        PackHeader h = from.pack.header;
        for (std::uint64_t chunk = 0; chunk < h.directory_count; ++chunk) {
            ChunkEntry e = from.pack.entry(chunk);
            change(chunk_id(h, chunk), e);
            std::memcpy(file.data() + h.directory_offset + chunk * sizeof e, &e, sizeof e);
        }
        h.directory_hash = XXH3_64bits(file.data() + h.directory_offset, h.directory_count * sizeof(ChunkEntry));
        h.header_hash = XXH3_64bits(&h, offsetof(PackHeader, header_hash));
        std::memcpy(file.data(), &h, sizeof h);
        opened = open_pack(file, pack);
    }
    Status opened;
};

} // namespace

TEST_CASE("bounds that lie, wherever the pages are, make terrain late or coarse but never cracked, and no frame hang") {
    Random random(927);
    int flown = 0;
    for (int round = 0; round < rounds(4, 12); ++round) {
        const auto pack = wide_terrain(random, pick(random, 200, 500), pick(random, 6, 7));
        const int how = round % 4;
        const Forged forged(pack, [&](const ChunkId& id, ChunkEntry& e) {
            if (id.kind != ChunkKind::geometry) return;
            if (how == 0) e.bound.error = e.bound.radius = 0;                                      // nothing is wanted
            if (how == 1) e.bound.error = e.bound.radius = 255, e.bound.low = 0, e.bound.high = 0; // everything is
            if (how == 2)
                e.bound.error = static_cast<std::uint8_t>(random()),
                e.bound.radius = static_cast<std::uint8_t>(random());
            if (how == 3) e.bound.low = e.bound.high = static_cast<std::uint16_t>(pick(random, 0, 65535)); // far off
        });
        if (!forged.opened.ok()) continue; // refused: as good
        ++flown;
        Streamed on(forged.pack, pack.terrain.tile_count() * 2);
        ScriptedClient client(random, on, {.most_delay = 3});
        CutSettings cut;
        cut.max_error_px = 2;
        StreamSettings settings;
        for (int frame = 0; frame < 200; ++frame) {
            const View view = near_ground(random, pack.terrain);
            settings.now_s += 1.0 / 60;
            client.act();
            (void)on.update({&view, 1}, cut, settings);
            client.follow();
            const CutReport report = on.cut.update({&view, 1}, cut);
            CAPTURE(round, how, frame);
            REQUIRE(check_stream(on) == "");
            if (frame % 10 == 0) REQUIRE(check_frame(on.cut, pack.terrain, report, cut) == "");
        }
        const View view = near_ground(random, pack.terrain);
        const int most = 8 * static_cast<int>(pack.terrain.page_count());
        CHECK(frames_to_rest(on, client, view, cut, settings, most) < most);
    }
    CHECK(flown >= rounds(2, 6)); // or nothing was tested
    const auto pack = wide_terrain(random, 200, 6);
    CHECK_FALSE(Forged(pack, [](const ChunkId& id, ChunkEntry& e) {
                    if (id.kind == ChunkKind::geometry) e.bound.low = 9, e.bound.high = 8;
                }).opened.ok());
}

TEST_CASE("mips that do not lie one after the other are a failure told once, and the rest of the terrain comes") {
    Random random(928);
    baker::BakeOptions options = small_bake(6);
    options.max_texture_log2 = 6;
    const auto pack = bake_and_load(random_dem(random, 300, 200, Shape::fractal), options);
    const std::uint32_t top = pack.pack.header.normal_log2;
    const std::uint32_t tail_item = top - 4 + 1; // the second of a tail of 16 texels
    const ChunkEntry elsewhere = pack.pack.entry(chunk_index(pack.pack.header, {ChunkKind::normal, 0, tail_item}));
    const Forged forged(pack, [&](const ChunkId& id, ChunkEntry& e) {
        if (id.kind == ChunkKind::normal && id.tile != 0 && id.item == tail_item) e = elsewhere;
    });
    if (!forged.opened.ok()) {
        WARN("skipped: such a pack is refused when it is opened");
        return;
    }
    StreamBudget budget;
    budget.tail_log2 = 4;
    Streamed on(forged.pack, 0, budget);
    ScriptedClient client(random, on, {});
    std::map<std::pair<ChunkKind, std::uint32_t>, int> told;
    CutSettings cut;
    cut.max_error_px = 0.1;
    StreamSettings settings;
    StreamReport report;
    const View view = view_from_above(pack.terrain, 0.05);
    for (int frame = 0; frame < 600; ++frame) {
        settings.now_s += 1.0 / 60;
        client.act();
        report = on.update({&view, 1}, cut, settings);
        client.follow();
        for (const StreamFailure& f : stream_failures(on.stream)) ++told[{f.id.kind, f.id.tile}];
    }
    CHECK(told.size() == pack.pack.tile_count() - 1);
    for (const auto& [what, times] : told) {
        CHECK(what.first == ChunkKind::normal);
        CHECK(times == 1);
    }
    CHECK(report.converged);
    CHECK_FALSE(report.complete);
    CHECK_FALSE(report.maps_converged);
}

TEST_CASE("of more than a frame takes over, the coarsest of every tile come first: none waits behind finer ones") {
    Random random(929);
    baker::BakeOptions options = small_bake(7);
    options.max_texture_log2 = 7;
    const auto pack = bake_and_load(random_dem(random, 800, 800, Shape::fractal), options);
    StreamBudget budget;
    budget.tail_log2 = 3;
    Streamed on(pack.pack, 0, budget);
    CutSettings cut;
    cut.max_error_px = 0.01;
    StreamSettings settings;
    settings.pages = 1;
    settings.map_bytes = 0; // one mip
    settings.texel_px = 0.1;
    const View view = view_from_above(pack.terrain, 0.01);
    // Of each tile a tail of both maps, one a frame, beside its page; and a frame each to be requested and answered.
    const int most = 2 * static_cast<int>(pack.terrain.tile_count()) + 2;
    StreamReport report;
    int frame = 0;
    for (; frame < 10 * most && !report.complete; ++frame) {
        settings.now_s += 1.0 / 60;
        report = on.update({&view, 1}, cut, settings);
        StreamRequest r;
        while (stream_next_request(on.stream, r))
            REQUIRE(stream_provide(on.stream, r.ticket, pack.pack.bytes.subspan(r.offset, r.bytes)).ok());
    }
    CHECK(report.complete);
    CHECK(frame <= most);
}
