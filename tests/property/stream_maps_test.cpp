// Mips that are streamed: what a renderer that carries out the commands has in its arrays.
#include <catch2/catch.hpp>

#include <array>
#include <cmath>
#include <optional>

#include "fjell/texture.h"
#include "shared/terrain_data.h"
#include "support/splat_rules.h"
#include "support/stream_scene.h"

using namespace fjell;
using namespace fjell::test;

namespace {

constexpr MapKind kinds[map_kinds] = {MapKind::colour, MapKind::normal, MapKind::horizon, MapKind::splat};
constexpr ChunkKind chunk_kinds[map_kinds] = {ChunkKind::colour, ChunkKind::normal, ChunkKind::horizon,
                                              ChunkKind::splat};

// A renderer's arrays, as far as who lies where: [kind][size][layer][mip] is a tile's mip of the pack, or nothing.
struct Arrays {
    struct Mip {
        std::uint32_t tile, item;
        friend bool operator==(const Mip&, const Mip&) = default;
    };
    const Pack& pack;
    std::array<MapLayers, map_kinds> slots;
    std::map<std::array<std::uint32_t, 4>, Mip> there;
    std::uint64_t uploads = 0, downgrades = 0, tails = 0;

    // Empty, or what is wrong with the command.
    std::string carry_out(const MapCommand& c) {
        const auto kind = static_cast<std::uint32_t>(c.map);
        const MapLayers& s = slots[kind];
        if (c.layer >= s.layers[c.side_log2]) return "a layer that does not exist";
        const std::uint32_t first = s.top_log2 - c.side_log2; // the pack's mip that is this array's mip 0
        for (std::uint32_t mip = 0; mip < mip_count(c.side_log2); ++mip) there.erase({kind, c.side_log2, c.layer, mip});
        if (c.from_log2 != 0)
            for (std::uint32_t item = s.top_log2 - std::min(c.side_log2, c.from_log2); item < mip_count(s.top_log2);
                 ++item) {
                const auto from = there.find({kind, c.from_log2, c.from_layer, item - (s.top_log2 - c.from_log2)});
                if (from == there.end() || !(from->second == Mip{c.tile, item})) return "copies what is not there";
                there[{kind, c.side_log2, c.layer, item - first}] = {c.tile, item};
            }
        std::span<const std::byte> blocks = c.blocks;
        for (std::uint32_t mip = 0; mip < c.upload_mips; ++mip) {
            const ChunkId id{chunk_kinds[kind], c.tile, first + mip};
            std::vector<std::byte> wanted(chunk_raw_bytes(pack.header, id));
            if (!read_chunk(pack, id, wanted).ok()) return "the pack cannot be read";
            if (blocks.size() < wanted.size() || !std::equal(wanted.begin(), wanted.end(), blocks.begin()))
                return "uploads other blocks than the pack's";
            blocks = blocks.subspan(wanted.size());
            there[{kind, c.side_log2, c.layer, mip}] = {c.tile, first + mip};
        }
        if (!blocks.empty()) return "more blocks than mips";
        uploads += c.upload_mips != 0;
        downgrades += c.side_log2 < c.from_log2;
        tails += c.from_log2 == 0;
        return {};
    }

    [[nodiscard]] std::string check(Stream stream) const {
        for (std::uint32_t kind = 0; kind < map_kinds; ++kind) {
            const MapLayers& s = slots[kind];
            const auto tiles = stream_tile_maps(stream, static_cast<MapKind>(kind));
            for (std::uint32_t tile = 0; tile < tiles.size(); ++tile) {
                const TileMap& map = tiles[tile];
                if (map.side_log2 == 0) continue;
                const auto first = static_cast<float>(s.top_log2 - map.side_log2);
                if (map.min_lod < first || map.min_lod > static_cast<float>(s.top_log2))
                    return "shows a mip that is not there";
                for (std::uint32_t mip = 0; mip < mip_count(map.side_log2); ++mip) {
                    const auto at = there.find({kind, map.side_log2, map.layer, mip});
                    if (at == there.end() || !(at->second == Mip{tile, s.top_log2 - map.side_log2 + mip}))
                        return "a tile is drawn from another one's mips";
                }
            }
        }
        return {};
    }
};

io::LoadedPack mapped_terrain(Random& random) {
    const int samples = pick(random, 80, 300);
    baker::BakeOptions options = small_bake(pick(random, 5, 6));
    options.max_texture_log2 = static_cast<std::uint32_t>(pick(random, 4, 8));
    options.horizon_spacing = 2 * pick(random, 0, 2);
    const RulesFile rules;
    if (pick(random, 0, 2) != 0) options.layers_path = rules.path();
    options.splat_spacing = 1 << pick(random, 0, 2);
    return bake_and_load(random_dem(random, samples, pick(random, 80, 300), Shape::fractal), options);
}

// The size that the nearest point of any tile's box asks for, straight from the definition.
std::uint32_t wanted_log2(const Streamed& on, const MapLayers& slots, std::uint32_t tile, const View& view,
                          double texel_px) {
    const Terrain& t = on.paged.terrain;
    const Watch& box = data_of(on.stream).tile_box[tile];
    const auto beyond = [](double at, double low, double high) { return std::max({low - at, at - high, 0.0}); };
    const Vec3 apart{beyond(view.eye_m.x, box.x0, box.x1), beyond(view.eye_m.y, box.y0, box.y1),
                     beyond(view.eye_m.z, box.z0, box.z1)};
    const double px_m = focal_length_px(view) / std::max(length(apart), 1e-3);
    const double tile_m = static_cast<double>(std::max(t.spacing_x_m(), t.spacing_z_m())) * data_of(t).tree.side();
    for (std::uint32_t log2 = slots.tail_log2; log2 < slots.top_log2; ++log2)
        if (tile_m / ((1u << log2) - 1) * px_m <= texel_px) return log2;
    return slots.top_log2;
}

} // namespace

TEST_CASE("mips come and go so that every tile is drawn from its own, within the layers there are, and none jumps") {
    Random random(401);
    std::uint64_t uploads = 0, downgrades = 0, limited = 0, failures = 0, satisfied = 0, horizons = 0, controls = 0;
    for (int round = 0; round < 24; ++round) {
        const auto pack = mapped_terrain(random);
        REQUIRE(pack.pack.header.normal_log2 != 0);
        StreamBudget budget;
        budget.map_requests = static_cast<std::uint32_t>(pick(random, 1, 20));
        budget.tail_log2 = static_cast<std::uint32_t>(pick(random, 2, 5));
        budget.horizons = round % 3 != 2;
        budget.splat = round % 4 != 1;
        horizons += budget.horizons && pack.pack.header.horizon_log2 != 0;
        controls += budget.splat && pack.pack.header.splat_log2 != 0;
        budget.map_bytes = std::uint64_t{1} << 40;
        std::uint64_t tails = 0, all = 0;
        for (const MapKind kind : kinds) {
            MapLayers slots = map_layers(pack.pack.header, budget, kind);
            all += map_layer_bytes(slots, kind);
            for (std::uint32_t log2 = slots.tail_log2 + 1; log2 <= max_texture_log2; ++log2) slots.layers[log2] = 0;
            tails += map_layer_bytes(slots, kind);
        }
        // Between hardly more than the tails and all; a tenth more because shares are rounded down.
        const bool plenty = pick(random, 0, 2) == 0;
        budget.map_bytes =
            plenty ? all * 2
                   : tails * 11 / 10 + static_cast<std::uint64_t>(uniform(random, 0, 0.5) * static_cast<double>(all));
        Streamed on(pack.pack, 0, budget);
        const bool fails = round % 4 == 3;
        ScriptedClient client(random, on, {.fails = fails ? 0.05 : 0, .garbage = fails ? 0.05 : 0, .most_delay = 8});
        Arrays arrays{pack.pack,
                      {stream_map_layers(on.stream, MapKind::colour), stream_map_layers(on.stream, MapKind::normal),
                       stream_map_layers(on.stream, MapKind::horizon), stream_map_layers(on.stream, MapKind::splat)},
                      {}};
        StreamSettings settings;
        settings.fade_s = pick(random, 0, 2) ? 0.1 : 0;
        settings.texel_px = std::pow(10.0, uniform(random, -0.5, 0.8));
        settings.map_bytes = static_cast<std::uint32_t>(pick(random, 0, 100000));
        CutSettings cut;
        cut.max_error_px = 50;
        View view = random_view(random, pack.terrain);
        std::array<std::vector<TileMap>, map_kinds> before;
        StreamReport report;
        const auto step = [&] {
            settings.now_s += 1.0 / 60;
            client.act();
            report = on.update({&view, 1}, cut, settings);
            client.follow();
            (void)on.cut.update({&view, 1}, cut);
            failures += stream_failures(on.stream).size();
            for (const MapCommand& c : stream_map_commands(on.stream)) REQUIRE(arrays.carry_out(c) == "");
            REQUIRE(arrays.check(on.stream) == "");
            REQUIRE(report.map_bytes_used <= report.map_bytes_capacity);
            REQUIRE(report.map_bytes_capacity <= budget.map_bytes);
            if (report.mips_uploaded > 1) REQUIRE(report.map_upload_bytes <= settings.map_bytes);
            for (std::uint32_t kind = 0; kind < map_kinds; ++kind) {
                const auto now = stream_tile_maps(on.stream, static_cast<MapKind>(kind));
                const float most = settings.fade_s > 0 ? static_cast<float>(1.0 / 60 / settings.fade_s) * 1.001f : 1e9f;
                for (std::size_t i = 0; i < before[kind].size(); ++i)
                    if (before[kind][i].side_log2 != 0)
                        REQUIRE(std::abs(now[i].min_lod - before[kind][i].min_lod) <= most);
                before[kind].assign(now.begin(), now.end());
            }
        };
        for (int leg = 0; leg < 4; ++leg) {
            for (int frame = 0; frame < 60; ++frame) {
                view = moved(random, view, 20.0 * pack.terrain.spacing_x_m());
                step();
            }
            // One request at a time takes as long as all mips of all tiles and kinds, each on its way for up to 8
            // frames.
            const std::uint32_t patience =
                plenty && !fails ? 9 * max_texture_log2 * map_kinds * pack.terrain.tile_count() : 600;
            for (std::uint32_t frame = 0; frame < patience && !report.maps_converged; ++frame) step();
            CAPTURE(round, leg, plenty, settings.texel_px, report.missing_mips, report.in_flight, report.exhausted);
            limited += (report.exhausted & stream_map_bytes) != 0;
            if (plenty && !fails) REQUIRE(report.maps_converged);
            if (report.maps_converged)
                for (std::uint32_t kind = 0; kind < map_kinds; ++kind)
                    for (std::uint32_t tile = 0; arrays.slots[kind].top_log2 != 0 && tile < pack.terrain.tile_count();
                         ++tile) {
                        const TileMap& map = stream_tile_maps(on.stream, static_cast<MapKind>(kind))[tile];
                        const MapLayers& slots = arrays.slots[kind];
                        REQUIRE(map.side_log2 >= wanted_log2(on, slots, tile, view, settings.texel_px));
                        REQUIRE(map.min_lod == static_cast<float>(slots.top_log2 - map.side_log2));
                        ++satisfied;
                    }
            view = random_view(random, pack.terrain);
        }
        uploads += arrays.uploads;
        downgrades += arrays.downgrades;
    }
    CAPTURE(uploads, downgrades, limited, failures, satisfied);
    REQUIRE(uploads > 1000);
    REQUIRE(downgrades > 30);
    REQUIRE(limited > 5);
    REQUIRE(failures > 20);
    REQUIRE(satisfied > 200);
    REQUIRE(horizons > 6);
    REQUIRE(controls > 6);
}

TEST_CASE("no mip is read twice unless its layer was given up in between") {
    Random random(402);
    const auto pack = mapped_terrain(random);
    StreamBudget budget;
    budget.map_bytes = std::uint64_t{1} << 40;
    budget.horizons = true;
    budget.splat = true;
    Streamed on(pack.pack, 0, budget);
    std::set<std::array<std::uint32_t, 3>> read;
    StreamSettings settings;
    settings.texel_px = 0.1;
    CutSettings cut;
    cut.max_error_px = 50;
    for (int frame = 0; frame < 400; ++frame) {
        const View view = random_view(random, pack.terrain);
        StreamRequest r;
        for (int n = 0; n < 8 && stream_next_request(on.stream, r); ++n) {
            if (r.id.kind != ChunkKind::geometry)
                for (std::uint32_t mip = 0; mip < r.chunks; ++mip)
                    REQUIRE(read.insert({static_cast<std::uint32_t>(r.id.kind), r.id.tile, r.id.item + mip}).second);
            REQUIRE(stream_provide(on.stream, r.ticket, pack.pack.bytes.subspan(r.offset, r.bytes)).ok());
        }
        (void)on.update({&view, 1}, cut, settings);
        (void)on.cut.update({&view, 1}, cut);
    }
    REQUIRE(read.size() > 40);
}

TEST_CASE("layers cost no more than the budget, and one that cannot hold the smallest mips is refused") {
    Random random(403);
    for (int round = 0; round < 500; ++round) {
        PackHeader h{};
        h.tiles_x = static_cast<std::uint32_t>(pick(random, 1, 60));
        h.tiles_y = static_cast<std::uint32_t>(pick(random, 1, 60));
        h.colour_log2 = pick(random, 0, 3) ? static_cast<std::uint32_t>(pick(random, 2, 12)) : 0;
        h.normal_log2 = pick(random, 0, 3) ? static_cast<std::uint32_t>(pick(random, 2, 12)) : 0;
        h.horizon_log2 = pick(random, 0, 1) ? static_cast<std::uint32_t>(pick(random, 2, 12)) : 0;
        StreamBudget budget;
        h.splat_log2 = pick(random, 0, 1) ? static_cast<std::uint32_t>(pick(random, 2, 12)) : 0;
        budget.horizons = pick(random, 0, 3) != 0;
        budget.splat = pick(random, 0, 3) != 0;
        budget.tail_log2 = static_cast<std::uint32_t>(pick(random, 2, 7));
        budget.map_bytes = static_cast<std::uint64_t>(std::pow(10.0, uniform(random, 5, 11)));
        std::uint64_t bytes = 0, tails = 0;
        for (const MapKind kind : kinds) {
            MapLayers slots = map_layers(h, budget, kind);
            bytes += map_layer_bytes(slots, kind);
            if (kind == MapKind::splat) REQUIRE(slots.top_log2 == (budget.splat ? h.splat_log2 : 0));
            if (kind == MapKind::horizon) REQUIRE(slots.top_log2 == (budget.horizons ? h.horizon_log2 : 0));
            if (slots.top_log2 == 0) {
                REQUIRE(map_layer_bytes(slots, kind) == 0);
                continue;
            }
            REQUIRE(slots.layers[slots.tail_log2] == h.tiles_x * h.tiles_y);
            for (std::uint32_t log2 = slots.tail_log2 + 1; log2 <= max_texture_log2; ++log2) {
                REQUIRE(slots.layers[log2] <= h.tiles_x * h.tiles_y);
                if (log2 > slots.top_log2) REQUIRE(slots.layers[log2] == 0);
                slots.layers[log2] = 0;
            }
            tails += map_layer_bytes(slots, kind);
        }
        CAPTURE(h.tiles_x, h.tiles_y, h.colour_log2, h.normal_log2, budget.map_bytes, tails);
        REQUIRE(bytes <= std::max(budget.map_bytes, tails)); // the tails alone are too much: create_stream refuses
    }
    const auto pack = mapped_terrain(random);
    PagedTerrain paged(pack.pack, {});
    StreamBudget budget;
    budget.map_bytes = 100;
    Stream stream;
    REQUIRE(stream_bytes(pack.pack, paged.terrain, budget) == 0);
    const Status status = create_stream(pack.pack, paged.terrain, {}, budget, {}, stream);
    REQUIRE(status.code == StatusCode::budget_too_small);
    REQUIRE(std::string(status.field).find("StreamBudget::map_bytes") == 0);
    for (const std::uint32_t decoders : {0u, 17u}) {
        const StreamBudget odd{.decoders = decoders};
        const Status refused = create_stream(pack.pack, paged.terrain, {}, odd, {}, stream);
        REQUIRE(refused.code == StatusCode::out_of_range);
        REQUIRE(std::string(refused.field) == "StreamBudget::decoders (1 to 16)");
    }
}
