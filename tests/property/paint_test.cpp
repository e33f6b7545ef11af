// Paint on moving ground (StampShape::paint): maps under it are those of a bake with the same stamps, whoever loads
// them and when, and where it is taken away they are the pack's bit for bit.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>

#include "baker/read/edited_source.h"
#include "fjell/edit.h"
#include "fjell/ground_maps.h"
#include "fjell/texture.h"
#include "support/gpu_maps.h"
#include "support/rounds.h"
#include "support/splat_rules.h"
#include "support/stream_scene.h"

using namespace fjell;
using namespace fjell::test;

namespace {

constexpr MapKind painted_kinds[] = {MapKind::colour, MapKind::splat};
ChunkKind chunks_of(MapKind map) {
    return map == MapKind::colour ? ChunkKind::colour : ChunkKind::splat;
}
std::uint32_t log2_of(const PackHeader& h, MapKind map) {
    return map == MapKind::colour ? h.colour_log2 : h.splat_log2;
}

baker::Dem slopes(std::int32_t columns = 193, std::int32_t rows = 161) {
    baker::Dem dem;
    dem.columns = columns, dem.rows = rows;
    dem.spacing_m[0] = dem.spacing_m[1] = 4;
    for (std::int32_t y = 0; y < rows; ++y)
        for (std::int32_t x = 0; x < columns; ++x)
            dem.heights_m.push_back(static_cast<float>(300 + 90 * std::sin(x * 0.05) * std::cos(y * 0.07)));
    return dem;
}
baker::BakeOptions options_for(int tile_log2, std::uint32_t texture_log2, const RulesFile* rules) {
    baker::BakeOptions options = small_bake(tile_log2);
    options.max_texture_log2 = texture_log2;
    if (rules != nullptr) options.layers_path = rules->path();
    return options;
}
Blocks pack_mip(const Pack& pack, MapKind map, std::uint32_t tile, std::uint32_t side_log2) {
    const ChunkId id{chunks_of(map), tile, log2_of(pack.header, map) - side_log2};
    Blocks blocks(chunk_raw_bytes(pack.header, id));
    REQUIRE(read_chunk(pack, id, blocks).ok());
    return blocks;
}

io::KeptStamp disc(double x_m, double z_m, float radius_m, StampShape shape = StampShape::paint) {
    io::KeptStamp kept;
    Stamp& s = kept.plain;
    s.shape = shape;
    s.x_m = x_m, s.z_m = z_m, s.radius_m = radius_m, s.falloff_m = radius_m / 3;
    s.rgb[0] = 40, s.rgb[1] = 25, s.rgb[2] = 20;
    s.material = 4;
    return kept;
}
io::KeptStamp road() {
    io::KeptStamp kept = disc(0, 0, 14);
    kept.points = {{80, 90, 0}, {300, 200, 0}, {420, 500, 0}, {640, 560, 0}};
    kept.plain.rgb[0] = kept.plain.rgb[1] = kept.plain.rgb[2] = 70;
    kept.plain.material = 1, kept.plain.strength = 0.8f;
    return kept;
}
io::KeptStamp any_paint(Random& random, const Terrain& terrain) {
    const double wx = terrain.extent_x_m(), wz = terrain.extent_z_m(), cell = terrain.spacing_x_m();
    io::KeptStamp kept = disc(uniform(random, -0.1, 1.1) * wx, uniform(random, -0.1, 1.1) * wz,
                              static_cast<float>(cell * std::pow(10.0, uniform(random, 0, 1.4))),
                              pick(random, 0, 3) == 0 ? StampShape::unpaint : StampShape::paint);
    Stamp& s = kept.plain;
    for (std::uint8_t& c : s.rgb) c = static_cast<std::uint8_t>(pick(random, 0, 255));
    s.material = pick(random, 0, 2) == 0 ? no_material : static_cast<std::uint8_t>(pick(random, 0, 4));
    s.strength = pick(random, 0, 1) ? 1 : static_cast<float>(uniform(random, 0, 1));
    if (pick(random, 0, 3) == 0)
        for (int i = pick(random, 2, 4); i > 0; --i)
            kept.points.push_back({uniform(random, 0, 1) * wx, uniform(random, 0, 1) * wz, 0});
    return kept;
}

struct Painter {
    io::AlignedMemory memory;
    Edits edits;
    EditReport report;
    Painter(const Terrain& terrain, const EditBudget& budget = {}) {
        const std::size_t bytes = edits_bytes(terrain.header(), budget);
        memory = io::allocate(bytes);
        REQUIRE(create_edits(terrain, budget, {memory.get(), bytes}, edits).ok());
    }
    StampResult stamp(const io::KeptStamp& kept) {
        StampId id = 0;
        REQUIRE(push_stamp(edits, kept.stamp(), id).ok());
        REQUIRE(update_edits(edits, {}, {}, report).ok());
        return stamp_state(edits, id);
    }
};

Blocks painted(const Terrain& terrain, const Pack& pack, MapKind map, std::uint32_t tile, std::uint32_t side_log2) {
    Blocks blocks = pack_mip(pack, map, tile, side_log2);
    bool changed = false;
    const Blocks before = blocks;
    REQUIRE(paint_map(terrain, map, tile, side_log2, blocks, changed).ok());
    REQUIRE((changed || blocks == before));
    return blocks;
}
// visit(map, tile, log2 of a mip's side)
template <typename Visit>
void for_each_mip(const PackHeader& h, const Visit& visit) {
    for (const MapKind map : painted_kinds)
        for (std::uint32_t tile = 0; tile < tiles_of(h); ++tile)
            for (std::uint32_t log2 = 2; log2 <= log2_of(h, map); ++log2) visit(map, tile, log2);
}

// Codes of colours, or shares by number.
std::vector<int> texels_of(MapKind map, const Blocks& blocks, std::uint32_t side) {
    std::vector<int> codes;
    if (map == MapKind::colour) {
        std::vector<std::uint8_t> rgb(std::size_t{side} * side * 3);
        REQUIRE(decode_colour(blocks, side, rgb).ok());
        return {rgb.begin(), rgb.end()};
    }
    codes.resize(std::size_t{side} * side * max_splat_names);
    for (std::size_t i = 0; i < std::size_t{side} * side; ++i)
        for (std::size_t k = 0; k < splat_layers; ++k)
            codes[i * max_splat_names + std::to_integer<std::size_t>(blocks[i * 8 + 2 * k + 1])] +=
                std::to_integer<int>(blocks[i * 8 + 2 * k]);
    return codes;
}

} // namespace

TEST_CASE("maps under paint are those of a bake with the same stamps", "[edit][paint]") {
    const RulesFile rules;
    for (const int tile_log2 : first_of(2, {6, 7, 5, 8})) {
        const baker::BakeOptions options = options_for(tile_log2, 8, &rules);
        const io::LoadedPack pack = bake_and_load(slopes(), options);
        const PackHeader& h = pack.pack.header;
        REQUIRE((h.colour_log2 >= 4 && h.splat_log2 >= 4));
        Painter place(pack.terrain);
        std::vector<io::TimedStamp> stamps;
        for (const io::KeptStamp& kept :
             {disc(330, 260, 60), road(), disc(500, 300, 30), disc(500, 300, 12, StampShape::unpaint)}) {
            REQUIRE(place.stamp(kept).state == StampState::applied);
            stamps.push_back({0, kept});
        }
        CHECK(place.report.samples == 0);
        const TemporaryFolder folder;
        const auto source = baker::edited_source(std::make_unique<baker::DemSource>(slopes()), stamps, "stamps");
        (void)baker::bake(*source, options, folder / "painted.fjell");
        const io::LoadedPack expected = io::load_pack(folder / "painted.fjell", io::LoadTerrain::no);
        double off[2] = {}, before[2] = {};
        int count[2] = {}, most[2] = {};
        for_each_mip(h, [&](MapKind map, std::uint32_t tile, std::uint32_t log2) {
            const std::uint32_t side = 1u << log2;
            const auto a = texels_of(map, painted(pack.terrain, pack.pack, map, tile, log2), side),
                       b = texels_of(map, pack_mip(expected.pack, map, tile, log2), side),
                       c = texels_of(map, pack_mip(pack.pack, map, tile, log2), side);
            const int k = map == MapKind::splat;
            for (std::size_t i = 0; i < a.size(); ++i) {
                if (std::abs(b[i] - c[i]) < 12) {
                    CHECK(std::abs(a[i] - b[i]) <= 64); // no paint where a bake has none
                    continue;
                }
                ++count[k], off[k] += std::abs(a[i] - b[i]), before[k] += std::abs(b[i] - c[i]);
                most[k] = std::max(most[k], std::abs(a[i] - b[i]));
            }
        });
        for (const int k : {0, 1}) {
            CAPTURE(tile_log2, k, count[k], off[k] / count[k], before[k] / count[k], most[k]);
            CHECK(count[k] > 200);
            CHECK(off[k] / count[k] < 4);     // codes of 255: what comes of two block compressions
            CHECK(before[k] / count[k] > 30); // that is what paint has changed
            CHECK(most[k] <= 64);
        }
    }
}

TEST_CASE("paint that is taken away leaves the pack's texels bit for bit, and its blocks", "[edit][paint]") {
    const RulesFile rules;
    Random random(20261128);
    const io::LoadedPack pack = bake_and_load(slopes(), options_for(6, 6, &rules));
    Painter place(pack.terrain);
    for (int round = 0; round < rounds(4, 40); ++round) {
        std::uint64_t cursor = 0;
        for (int i = 0; i < 12; ++i) REQUIRE(place.stamp(any_paint(random, pack.terrain)).state == StampState::applied);
        REQUIRE(place.report.paint > 0);
        bool lost = false;
        GroundRect rects[8];
        CHECK(take_paint_changes(pack.terrain, cursor, rects, lost) > 0);
        bool any = false;
        for_each_mip(pack.pack.header, [&](MapKind map, std::uint32_t tile, std::uint32_t log2) {
            any = any || painted(pack.terrain, pack.pack, map, tile, log2) != pack_mip(pack.pack, map, tile, log2);
        });
        CHECK(any);
        io::KeptStamp all = disc(400, 300, 3000, StampShape::unpaint);
        REQUIRE(place.stamp(all).state == StampState::applied);
        CHECK(place.report.paint == 0);
        for_each_mip(pack.pack.header, [&](MapKind map, std::uint32_t tile, std::uint32_t log2) {
            REQUIRE(painted(pack.terrain, pack.pack, map, tile, log2) == pack_mip(pack.pack, map, tile, log2));
        });
    }
}

TEST_CASE("a copy of paint stays as it was", "[edit][paint]") {
    const io::LoadedPack pack = bake_and_load(slopes(), options_for(6, 6, nullptr));
    const std::uint32_t top = pack.pack.header.colour_log2;
    Painter place(pack.terrain);
    Paint copy;
    CHECK(paint_bytes(pack.terrain) == 0);
    CHECK(copy_paint(pack.terrain, {}, copy).code == StatusCode::not_supported);
    REQUIRE(place.stamp(disc(300, 200, 40)).state == StampState::applied);
    const std::size_t bytes = paint_bytes(pack.terrain);
    const io::AlignedMemory memory = io::allocate(bytes);
    CHECK(copy_paint(pack.terrain, {memory.get(), bytes - 1}, copy).code == StatusCode::memory_too_small);
    REQUIRE(copy_paint(pack.terrain, {memory.get(), bytes}, copy).ok());
    const Blocks before = painted(pack.terrain, pack.pack, MapKind::colour, 0, top);
    REQUIRE(place.stamp(disc(300, 200, 90, StampShape::unpaint)).state == StampState::applied);
    Blocks blocks = pack_mip(pack.pack, MapKind::colour, 0, top);
    CHECK(painted(pack.terrain, pack.pack, MapKind::colour, 0, top) == blocks);
    bool changed = false;
    REQUIRE(paint_map(copy, MapKind::colour, 0, top, blocks, changed).ok());
    CHECK((changed && blocks == before));
    CHECK(paint_map(copy, MapKind::normal, 0, top, blocks, changed).code == StatusCode::out_of_range);
    CHECK(paint_map(copy, MapKind::colour, 99, top, blocks, changed).code == StatusCode::out_of_range);
    CHECK(paint_map(copy, MapKind::colour, 0, top + 1, blocks, changed).code == StatusCode::out_of_range);
    CHECK(paint_map(copy, MapKind::colour, 0, top - 1, blocks, changed).code == StatusCode::out_of_range);
    CHECK(paint_map(Paint{}, MapKind::colour, 0, top, blocks, changed).code == StatusCode::invalid_handle);
    CHECK(paint_map(Terrain{}, MapKind::colour, 0, top, blocks, changed).code == StatusCode::invalid_handle);
}

TEST_CASE("paint that cannot be is refused whole, by its field's name", "[edit][paint]") {
    const io::LoadedPack pack = bake_and_load(slopes(), options_for(6, 6, nullptr));
    const std::uint32_t top = pack.pack.header.colour_log2;
    Painter place(pack.terrain, {.paint = 6});
    REQUIRE(place.stamp(disc(300, 200, 20)).state == StampState::applied);
    const std::uint32_t used = place.report.paint;
    const Blocks before = painted(pack.terrain, pack.pack, MapKind::colour, 0, top);
    const StampResult refused = place.stamp(disc(300, 200, 200));
    CHECK(refused.state == StampState::refused);
    CHECK(refused.status.code == StatusCode::out_of_slots);
    CHECK(std::string(refused.status.field) == "EditBudget::paint");
    CHECK(place.report.exhausted == edit_budget_paint);
    CHECK(place.report.paint == used);
    CHECK(painted(pack.terrain, pack.pack, MapKind::colour, 0, top) == before);
    StampId id = 0;
    const auto field_of = [&](const auto& change) {
        io::KeptStamp bad = disc(300, 200, 20);
        change(bad.plain);
        const Status status = push_stamp(place.edits, bad.plain, id);
        CHECK(status.code == StatusCode::out_of_range);
        return std::string(status.field);
    };
    CHECK(field_of([](Stamp& s) { s.strength = 1.5f; }) == "Stamp::strength");
    CHECK(field_of([](Stamp& s) { s.strength = NAN; }) == "Stamp::strength");
    CHECK(field_of([](Stamp& s) { s.material = 16; }) == "Stamp::material");
    CHECK(field_of([](Stamp& s) { s.point_count = 1; }) == "Stamp::points");
    CHECK(field_of([](Stamp& s) { s.shape = static_cast<StampShape>(14); }) == "Stamp::shape");
    CHECK(edits_bytes(pack.pack.header, {.paint = 1u << 25}) == 0);
    // A pack without maps keeps no paint.
    baker::BakeOptions bare = small_bake(6);
    bare.max_texture_log2 = 0;
    const io::LoadedPack grey = bake_and_load(slopes(), bare);
    if (grey.pack.header.colour_log2 == 0) {
        CHECK(edits_bytes(grey.pack.header, {}) < edits_bytes(pack.pack.header, {}));
        Painter on(grey.terrain);
        const StampResult none = on.stamp(disc(300, 200, 20));
        CHECK((none.state == StampState::refused && none.status.code == StatusCode::not_supported));
    }
}

TEST_CASE("paint comes piece by piece, as the budget of work allows, and ends as it would at once", "[edit][paint]") {
    const io::LoadedPack pack = bake_and_load(slopes(), options_for(6, 6, nullptr));
    const std::uint32_t top = pack.pack.header.colour_log2;
    Blocks whole;
    {
        Painter at_once(pack.terrain);
        REQUIRE(at_once.stamp(road()).state == StampState::applied);
        CHECK(at_once.report.work > 4);
        whole = painted(pack.terrain, pack.pack, MapKind::colour, 1, top);
        REQUIRE(destroy_edits(at_once.edits).ok());
    }
    Painter place(pack.terrain);
    const io::KeptStamp kept = road();
    StampId id = 0;
    REQUIRE(push_stamp(place.edits, kept.stamp(), id).ok());
    int calls = 0;
    for (; calls < 1000 && stamp_state(place.edits, id).state != StampState::applied; ++calls) {
        REQUIRE(update_edits(place.edits, {}, {.max_work = 1}, place.report).ok());
        REQUIRE(place.report.work <= 1);
    }
    CHECK(calls > 4);
    CHECK(painted(pack.terrain, pack.pack, MapKind::colour, 1, top) == whole);
}

TEST_CASE("streamed maps are painted whenever they come, and again when paint does", "[edit][paint]") {
    const RulesFile rules;
    Random random(44);
    std::uint64_t patches = 0, settled = 0;
    for (int round = 0; round < rounds(4, 30); ++round) {
        const io::LoadedPack pack = bake_and_load(slopes(260, 200), options_for(6, 6, round % 2 ? &rules : nullptr));
        const PackHeader& h = pack.pack.header;
        StreamBudget budget;
        budget.map_requests = static_cast<std::uint32_t>(pick(random, 1, 12));
        budget.tail_log2 = static_cast<std::uint32_t>(pick(random, 2, 4));
        budget.splat = true;
        std::uint64_t all = 0;
        budget.map_bytes = std::uint64_t{1} << 40;
        for (std::uint32_t kind = 0; kind < map_kinds; ++kind)
            all += map_layer_bytes(map_layers(h, budget, static_cast<MapKind>(kind)), static_cast<MapKind>(kind));
        budget.map_bytes = round % 3 == 0 ? all : all * 2 / 3;
        Streamed on(pack.pack, 0, budget);
        const bool fails = round % 4 == 3;
        ScriptedClient client(random, on, {.fails = fails ? 0.02 : 0, .most_delay = 6});
        Painter place(on.paged.terrain);
        const std::size_t bytes = ground_maps_bytes(h);
        const io::AlignedMemory memory = io::allocate(bytes);
        GroundMaps maps;
        REQUIRE(create_ground_maps(on.paged.terrain, {}, {memory.get(), bytes}, maps).ok());
        Gpu gpu;
        StreamSettings settings;
        settings.fade_s = 0.05;
        CutSettings cut;
        cut.max_error_px = 50;
        View view = random_view(random, pack.terrain);
        StreamReport report;
        const auto step = [&] {
            settings.now_s += 1.0 / 60;
            client.act();
            REQUIRE(update_edits(place.edits, {&view, 1}, {}, place.report).ok());
            report = on.update({&view, 1}, cut, settings);
            client.follow();
            (void)on.cut.update({&view, 1}, cut);
            for (const MapCommand& c : stream_map_commands(on.stream)) gpu.carry_out(c);
            REQUIRE(note_map_commands(maps, stream_map_commands(on.stream)).ok());
            GroundMapsReport made;
            REQUIRE(update_ground_maps(maps, stream_tile_maps(on.stream, MapKind::normal), made).ok());
            for (const MapPatch& p : ground_map_patches(maps)) gpu.put(p);
            REQUIRE(check_stream(on).empty());
        };
        for (int act = 0; act < 4; ++act) {
            if (act % 2) view = random_view(random, pack.terrain);
            const bool clears = act == 3;
            std::vector<io::KeptStamp> kept;
            for (int i = 0; i < 6; ++i) kept.push_back(any_paint(random, pack.terrain));
            if (clears) kept.push_back(disc(500, 400, 9000, StampShape::unpaint));
            for (const io::KeptStamp& k : kept) {
                StampId id = 0;
                REQUIRE(push_stamp(place.edits, k.stamp(), id).ok());
                for (int frames = pick(random, 0, 6); frames > 0; --frames) step();
            }
            int frames = 0;
            do step();
            while ((!report.maps_converged || !client.idle() || place.report.waiting != 0) &&
                   ++frames < (fails ? 400 : 4000));
            if (fails) continue; // a mip that cannot be read again shows the paint of before
            // Less than all may never be all that is wanted: what is there must be right, when it is.
            if (!report.maps_converged) continue;
            ++settled;
            for (const MapKind map : painted_kinds) {
                const auto tiles = stream_tile_maps(on.stream, map);
                for (std::uint32_t tile = 0; tile < tiles.size(); ++tile)
                    for (std::uint32_t mip = 0; mip < mip_count(tiles[tile].side_log2); ++mip) {
                        const Blocks& shown =
                            gpu.at.at({static_cast<std::uint32_t>(map), tiles[tile].side_log2, tiles[tile].layer, mip});
                        CAPTURE(round, act, tile, mip, static_cast<int>(map));
                        REQUIRE(shown == painted(on.paged.terrain, pack.pack, map, tile, tiles[tile].side_log2 - mip));
                        if (clears) REQUIRE(shown == pack_mip(pack.pack, map, tile, tiles[tile].side_log2 - mip));
                    }
            }
        }
        patches += gpu.patches;
    }
    CHECK(patches > 50);
    CHECK(settled > 3);
}
