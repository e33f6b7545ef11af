// Horizon maps over ground that has moved: a new hill hides the sky, a pit lies deep, and what is restored has the
// pack's horizons bit for bit.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

#include "fjell/edit.h"
#include "support/gpu_maps.h"
#include "support/rounds.h"
#include "support/stream_scene.h"

using namespace fjell;
using namespace fjell::test;

namespace {

constexpr auto horizon_kind = static_cast<std::uint32_t>(MapKind::horizon);

baker::Dem rolling() {
    baker::Dem dem;
    dem.columns = 260, dem.rows = 200;
    dem.spacing_m[0] = 4, dem.spacing_m[1] = 5;
    for (std::int32_t y = 0; y < dem.rows; ++y)
        for (std::int32_t x = 0; x < dem.columns; ++x)
            dem.heights_m.push_back(static_cast<float>(300 + 30 * std::sin(x * 0.05) * std::cos(y * 0.07)));
    return dem;
}
baker::BakeOptions with_horizons() {
    baker::BakeOptions options = small_bake(6);
    options.max_texture_log2 = 6;
    options.horizon_spacing = 2;
    return options;
}
Blocks pack_mip(const Pack& pack, std::uint32_t tile, std::uint32_t side_log2) {
    const ChunkId id{ChunkKind::horizon, tile, pack.header.horizon_log2 - side_log2};
    Blocks blocks(chunk_raw_bytes(pack.header, id));
    REQUIRE(read_chunk(pack, id, blocks).ok());
    return blocks;
}
std::vector<std::uint8_t> codes_of(const Blocks& blocks, std::uint32_t side_log2) {
    const std::uint32_t side = 1u << side_log2;
    std::vector<std::uint8_t> codes(std::size_t{side} * side * horizon_planes);
    REQUIRE(decode_horizon(blocks, side, codes).ok());
    return codes;
}

// A terrain that is streamed and edited, and what a host shows of its maps.
struct Shown {
    explicit Shown(Random& random, const Pack& pack, const StreamBudget& budget)
        : on(pack, 0, budget), client(random, on, {.most_delay = 4}) {
        const std::size_t bytes = edits_bytes(pack.header);
        edit_memory = io::allocate(bytes);
        REQUIRE(create_edits(on.paged.terrain, {}, {edit_memory.get(), bytes}, edits).ok());
        const std::size_t map_bytes = ground_maps_bytes(pack.header);
        map_memory = io::allocate(map_bytes);
        REQUIRE(create_ground_maps(on.paged.terrain, {}, {map_memory.get(), map_bytes}, maps).ok());
    }
    void step(const View& view) {
        settings.now_s += 1.0 / 60;
        client.act();
        EditReport edited;
        REQUIRE(update_edits(edits, {&view, 1}, {}, edited).ok());
        report = on.update({&view, 1}, {}, settings);
        client.follow();
        (void)on.cut.update({&view, 1}, {});
        for (const MapCommand& c : stream_map_commands(on.stream)) gpu.carry_out(c);
        REQUIRE(note_map_commands(maps, stream_map_commands(on.stream)).ok());
        GroundMapsReport made;
        REQUIRE(update_ground_maps(maps, stream_tile_maps(on.stream, MapKind::normal), made).ok());
        for (const MapPatch& p : ground_map_patches(maps)) {
            if (p.map == MapKind::horizon) ++patches;
            gpu.put(p);
        }
        REQUIRE(check_stream(on).empty());
        rests = edited.waiting == 0 && report.maps_converged && client.idle();
    }
    void settle(const View& view) {
        int frames = 0;
        do step(view);
        while ((!rests || frames < 20) && ++frames < 4000);
        REQUIRE(rests);
    }
    void stamp(const Stamp& stamp) {
        StampId id = 0;
        REQUIRE(push_stamp(edits, stamp, id).ok());
    }
    [[nodiscard]] const Blocks& mip(std::uint32_t tile, std::uint32_t number) const {
        const TileMap& map = stream_tile_maps(on.stream, MapKind::horizon)[tile];
        return gpu.at.at({horizon_kind, map.side_log2, map.layer, number});
    }
    [[nodiscard]] std::uint32_t side_log2(std::uint32_t tile) const {
        return stream_tile_maps(on.stream, MapKind::horizon)[tile].side_log2;
    }

    Streamed on;
    ScriptedClient client;
    io::AlignedMemory edit_memory, map_memory;
    Edits edits;
    GroundMaps maps;
    Gpu gpu;
    StreamSettings settings;
    StreamReport report;
    std::uint64_t patches = 0;
    bool rests = false;
};

// Codes where a fresh bake of the ground has others than the pack, and where it has none.
struct Differences {
    double before = 0, after = 0; // over those that rise by more than 25: how far off the pack's are, and what is shown
    double raised = 0;            // elsewhere: what is shown over what a fresh bake has
    std::size_t rise = 0, other = 0;
    int lowered = 0; // under the pack's, at most
};

void compare(const Shown& shown, const Pack& pack, const Pack& fresh, std::size_t first, std::size_t last,
             Differences& d) {
    for (std::uint32_t tile = 0; tile < tiles_of(pack.header); ++tile) {
        if (shown.side_log2(tile) != pack.header.horizon_log2) continue;
        const auto was = codes_of(pack_mip(pack, tile, pack.header.horizon_log2), pack.header.horizon_log2),
                   is = codes_of(shown.mip(tile, 0), pack.header.horizon_log2),
                   asked = codes_of(pack_mip(fresh, tile, pack.header.horizon_log2), pack.header.horizon_log2);
        for (std::size_t i = 0; i < is.size(); ++i) {
            if (i % horizon_planes < first || i % horizon_planes > last) continue;
            d.lowered = std::max(d.lowered, was[i] - is[i]);
            if (asked[i] > was[i] + 25)
                ++d.rise, d.before += asked[i] - was[i], d.after += std::abs(asked[i] - is[i]);
            else
                ++d.other, d.raised += std::max(is[i] - std::max(was[i], asked[i]), 0);
        }
    }
}

} // namespace

TEST_CASE("horizons follow ground that rises and pits that are dug, and come back with what is restored", "[edit]") {
    Random random(46);
    Differences horizons;
    double sky_before = 0, sky_after = 0;
    for (int round = 0; round < rounds(2, 20); ++round) {
        const io::LoadedPack pack = bake_and_load(rolling(), with_horizons());
        const PackHeader& h = pack.pack.header;
        REQUIRE(h.horizon_log2 != 0);
        StreamBudget budget;
        budget.horizons = true;
        budget.map_requests = static_cast<std::uint32_t>(pick(random, 2, 12));
        budget.tail_log2 = static_cast<std::uint32_t>(pick(random, 2, 4));
        budget.map_bytes = std::uint64_t{1} << 30;
        Shown shown(random, pack.pack, budget);
        View view = random_view(random, pack.terrain);
        view.eye_m = {500, 700, 500};
        view.near_m = 1;
        if (round % 2) shown.settle(view); // otherwise maps come after the stamps
        std::vector<Stamp> stamps;
        for (int i = 0; i < 3; ++i) {
            Stamp s;
            s.shape = StampShape::raise;
            s.x_m = uniform(random, 100, 900), s.z_m = uniform(random, 100, 900);
            s.radius_m = static_cast<float>(uniform(random, 15, 40)), s.falloff_m = s.radius_m;
            s.amount_m = static_cast<float>(uniform(random, 15, 30)) * (i % 2 ? -1.0f : 1.0f);
            stamps.push_back(s);
            shown.stamp(s);
            for (int frames = pick(random, 0, 4); frames > 0; --frames) shown.step(view);
        }
        shown.settle(view);
        if (round % 2) CHECK(shown.patches > 0);
        // The same stamps over ground that is loaded whole.
        const std::size_t bytes = edits_bytes(h);
        const io::AlignedMemory memory = io::allocate(bytes);
        Edits edits;
        REQUIRE(create_edits(pack.terrain, {}, {memory.get(), bytes}, edits).ok());
        for (const Stamp& s : stamps) {
            StampId id = 0;
            EditReport report;
            REQUIRE(push_stamp(edits, s, id).ok());
            REQUIRE(update_edits(edits, {}, {}, report).ok());
            REQUIRE(stamp_state(edits, id).state == StampState::applied);
        }
        baker::Dem moved = rolling();
        for (std::int32_t y = 0; y < moved.rows; ++y)
            for (std::int32_t x = 0; x < moved.columns; ++x)
                moved.heights_m[moved.index(x, y)] = static_cast<float>(data_of(pack.terrain).height_m({x, y}));
        const io::LoadedPack fresh = bake_and_load(std::move(moved), with_horizons());
        compare(shown, pack.pack, fresh.pack, 0, horizon_directions - 1, horizons);
        for (std::uint32_t tile = 0; tile < tiles_of(h); ++tile) { // the sky
            const auto was = codes_of(pack_mip(pack.pack, tile, h.horizon_log2), h.horizon_log2),
                       is = codes_of(shown.mip(tile, 0), h.horizon_log2),
                       asked = codes_of(pack_mip(fresh.pack, tile, h.horizon_log2), h.horizon_log2);
            for (std::size_t i = horizon_directions; i < is.size(); i += horizon_planes)
                if (asked[i] + 25 < was[i]) sky_before += was[i] - asked[i], sky_after += std::abs(is[i] - asked[i]);
        }
        Stamp all;
        all.shape = StampShape::restore;
        all.x_m = all.z_m = 500, all.radius_m = 5000;
        shown.stamp(all);
        shown.settle(view);
        for (std::uint32_t tile = 0; tile < tiles_of(h); ++tile)
            for (std::uint32_t mip = 0; mip < mip_count(shown.side_log2(tile)); ++mip)
                REQUIRE(shown.mip(tile, mip) == pack_mip(pack.pack, tile, shown.side_log2(tile) - mip));
    }
    CAPTURE(horizons.rise, horizons.other, horizons.before, horizons.after, horizons.raised, horizons.lowered);
    CAPTURE(sky_before, sky_after);
    CHECK(horizons.rise > 1000);
    CHECK(horizons.after < 0.15 * horizons.before);
    CHECK(horizons.lowered < 30); // what block compression rounds
    CHECK(horizons.raised < 0.3 * static_cast<double>(horizons.other));
    CHECK(sky_after < 0.5 * sky_before);
}
