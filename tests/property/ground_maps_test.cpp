// Normal maps of moving ground (fjell/ground_maps.h): after the patches they are those of a pack that was baked from
// the new heights.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "fjell/edit.h"
#include "fjell/ground_maps.h"
#include "fjell/io/load.h"
#include "fjell/pages.h"
#include "fjell/texture.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::test;

namespace {

baker::Dem hills(const Terrain* heights = nullptr) {
    baker::Dem dem;
    dem.columns = 193, dem.rows = 161;
    dem.spacing_m[0] = dem.spacing_m[1] = 4;
    for (std::int32_t y = 0; y < dem.rows; ++y)
        for (std::int32_t x = 0; x < dem.columns; ++x)
            dem.heights_m.push_back(heights != nullptr
                                        ? data_of(*heights).height_m({x, y})
                                        : static_cast<float>(300 + 40 * std::sin(x * 0.05) * std::cos(y * 0.07) +
                                                             0.5 * std::sin(x * 0.9 + y * 0.4)));
    return dem;
}
io::LoadedPack baked(baker::Dem dem) {
    baker::BakeOptions options = small_bake(6);
    options.max_texture_log2 = 7;
    return bake_and_load(std::move(dem), options);
}

// The maps of all tiles as a GPU would hold them: blocks of each mip, by tile.
using Mips = std::vector<std::vector<std::byte>>;
Mips mips_of(const Pack& pack, std::uint32_t tile) {
    Mips mips(mip_count(pack.header.normal_log2));
    for (std::uint32_t mip = 0; mip < mips.size(); ++mip) {
        mips[mip].resize(chunk_raw_bytes(pack.header, {ChunkKind::normal, tile, mip}));
        REQUIRE(read_chunk(pack, {ChunkKind::normal, tile, mip}, mips[mip]).ok());
    }
    return mips;
}
std::vector<std::uint8_t> codes(const std::vector<std::byte>& blocks, std::uint32_t side) {
    std::vector<std::uint8_t> texels(std::size_t{side} * side * 2);
    REQUIRE(decode_normal(blocks, side, texels).ok());
    return texels;
}

struct Place {
    io::LoadedPack pack = baked(hills());
    const Terrain& terrain = pack.terrain;
    io::AlignedMemory edit_memory, map_memory;
    Edits edits;
    GroundMaps maps;
    std::vector<TileMap> shown; // the whole pack, unless a test says otherwise
    std::vector<Mips> gpu;      // of each tile, of the pack's size
    std::uint32_t updates = 0, texels = 0;

    explicit Place(const GroundMapsBudget& budget = {}) {
        const std::uint32_t tiles = terrain.tile_count();
        for (std::uint32_t tile = 0; tile < tiles; ++tile) gpu.push_back(mips_of(pack.pack, tile));
        shown.assign(tiles, {});
        for (std::uint32_t tile = 0; tile < tiles; ++tile)
            shown[tile] = {tile, static_cast<std::uint8_t>(pack.pack.header.normal_log2), 0};
        const std::size_t bytes = edits_bytes(pack.pack.header),
                          map_bytes = ground_maps_bytes(pack.pack.header, budget);
        edit_memory = io::allocate(bytes), map_memory = io::allocate(map_bytes);
        REQUIRE(create_edits(terrain, {}, {edit_memory.get(), bytes}, edits).ok());
        REQUIRE(create_ground_maps(terrain, budget, {map_memory.get(), map_bytes}, maps).ok());
    }
    void stamp(StampShape shape, double column, double row, float radius_m, float amount_m = 0) {
        Stamp s;
        s.shape = shape;
        s.x_m = terrain.x_m(0) + column * 4, s.z_m = row * 4;
        s.radius_m = radius_m, s.falloff_m = radius_m / 2, s.amount_m = amount_m;
        StampId id = 0;
        REQUIRE(push_stamp(edits, s, id).ok());
        EditReport report;
        REQUIRE(update_edits(edits, {}, {}, report).ok());
        REQUIRE(stamp_state(edits, id).state == StampState::applied);
    }
    // What a host does with patches, until none waits.
    GroundMapsReport follow(std::uint32_t most = GroundMapsBudget{}.texels) {
        GroundMapsReport report;
        do {
            REQUIRE(update_ground_maps(maps, shown, report).ok());
            REQUIRE(report.texels <= most);
            REQUIRE(ground_map_patches(maps).size() == report.patches);
            ++updates, texels += report.texels;
            for (const MapPatch& p : ground_map_patches(maps)) put(p);
        } while (report.waiting != 0);
        return report;
    }
    // A map command of the stream's was carried out.
    void written(std::uint32_t tile) {
        MapCommand command{};
        command.map = MapKind::normal, command.tile = tile;
        command.side_log2 = shown[tile].side_log2, command.layer = shown[tile].layer;
        REQUIRE(note_map_commands(maps, {&command, 1}).ok());
    }
    void put(const MapPatch& p) {
        REQUIRE((p.map == MapKind::normal && p.tile < gpu.size() && p.layer == shown[p.tile].layer));
        REQUIRE(p.side_log2 == shown[p.tile].side_log2);
        const std::uint32_t side = 1u << (p.side_log2 - p.mip), blocks = side / 4;
        REQUIRE((p.x % 4 == 0 && p.y % 4 == 0 && p.columns % 4 == 0 && p.rows % 4 == 0));
        REQUIRE((p.x + p.columns <= side && p.y + p.rows <= side));
        REQUIRE(p.blocks.size() == p.columns * p.rows);
        const std::byte* from = p.blocks.data();
        auto& to = gpu[p.tile][pack.pack.header.normal_log2 - p.side_log2 + p.mip];
        for (std::uint32_t y = p.y / 4; y < (p.y + p.rows) / 4; ++y, from += p.columns * 4)
            std::copy_n(from, p.columns * 4, to.begin() + (y * blocks + p.x / 4) * 16);
    }
};

// How far codes of the mips are from those of a pack that was baked from the new ground, where those of the old
// ground's are more than 3 off.
struct Off {
    double mean = 0, before = 0;
    int count = 0;
};
Off off(const std::vector<Mips>& maps, const std::vector<Mips>& old, const Pack& expected) {
    Off off;
    for (std::uint32_t tile = 0; tile < maps.size(); ++tile) {
        const Mips right = mips_of(expected, tile);
        for (std::uint32_t mip = 0; mip < right.size(); ++mip) {
            const std::uint32_t side = 1u << (expected.header.normal_log2 - mip);
            if (64.0 / side > 16) continue; // some texels
            const auto a = codes(maps[tile][mip], side), b = codes(right[mip], side), c = codes(old[tile][mip], side);
            for (std::size_t i = 0; i < a.size(); ++i) {
                if (std::abs(b[i] - c[i]) < 4) continue; // the old ground's is as good
                ++off.count;
                off.mean += std::abs(a[i] - b[i]), off.before += std::abs(b[i] - c[i]);
            }
        }
    }
    off.mean /= std::max(off.count, 1), off.before /= std::max(off.count, 1);
    return off;
}

} // namespace

TEST_CASE("normal maps follow the ground: they are those of a pack baked from it, in each mip, across tiles") {
    Place place;
    const std::vector<Mips> old = place.gpu;
    place.stamp(StampShape::crater, 64, 66, 60, 25); // over the corner of four tiles
    place.stamp(StampShape::raise, 150, 30, 20, 10);
    const GroundMapsReport done = place.follow();
    CHECK(done.coarse == 0);
    const io::LoadedPack expected = baked(hills(&place.terrain));
    const Off now = off(place.gpu, old, expected.pack);
    CAPTURE(now.mean, now.before, now.count);
    CHECK(now.count > 2000);
    CHECK(now.before > 10);
    CHECK(now.mean < now.before / 20);
    CHECK(place.texels < 4 * 40 * 40 * 4); // and no more of them than that takes

    SECTION("nothing is made while nothing changes") {
        GroundMapsReport report;
        REQUIRE(update_ground_maps(place.maps, place.shown, report).ok());
        CHECK((report.patches == 0 && report.texels == 0 && report.waiting == 0));
    }
    SECTION("undone, the maps are the pack's, but for what their codes round") {
        place.stamp(StampShape::restore, 100, 60, 600);
        place.follow();
        const Off back = off(place.gpu, place.gpu, place.pack.pack);
        CHECK(back.count < now.count / 10); // of some 390,000 codes
        place.written(0);
        place.texels = 0;
        place.follow();
        CHECK(place.texels == 0);
    }
}

TEST_CASE("whatever the budget, the same texels are made, so many at a time") {
    Place wide, narrow({.changes = 1, .texels = 4096});
    for (Place* place : {&wide, &narrow}) {
        place->stamp(StampShape::crater, 64, 66, 60, 25);
        place->stamp(StampShape::raise, 100, 100, 30, 10);
        place->stamp(StampShape::raise, 20, 20, 30, -10);
    }
    wide.follow();
    narrow.follow(4096);
    CHECK(narrow.updates > wide.updates + 2);
    // Beyond one change whole tiles are made anew: where nothing was edited the texels may round otherwise.
    const io::LoadedPack expected = baked(hills(&wide.terrain));
    std::vector<Mips> old;
    for (std::uint32_t tile = 0; tile < wide.gpu.size(); ++tile) old.push_back(mips_of(wide.pack.pack, tile));
    const Off a = off(wide.gpu, old, expected.pack), b = off(narrow.gpu, old, expected.pack);
    CHECK(b.mean < 1.05 * a.mean);
    Place queued({.texels = 4096});
    queued.stamp(StampShape::crater, 64, 66, 60, 25);
    queued.stamp(StampShape::raise, 100, 100, 30, 10);
    queued.stamp(StampShape::raise, 20, 20, 30, -10);
    queued.follow(4096);
    CHECK((queued.gpu == wide.gpu)); // bit for bit
}

TEST_CASE("maps that come later show the ground as it is by then") {
    Place place, late;
    for (Place* p : {&place, &late}) p->stamp(StampShape::crater, 64, 66, 60, 25);
    place.follow();

    // None is shown at first; then small ones come, and larger ones with the pack's finest mip.
    const std::vector<TileMap> whole = late.shown;
    for (TileMap& tile : late.shown) tile.side_log2 = 0;
    late.follow();
    CHECK(late.texels == 0);
    for (int smaller = 2; smaller >= 0; --smaller) {
        for (std::uint32_t tile = 0; tile < whole.size(); ++tile) {
            late.shown[tile].side_log2 = static_cast<std::uint8_t>(whole[tile].side_log2 - smaller);
            late.shown[tile].layer = tile + static_cast<std::uint32_t>(smaller);
            late.gpu[tile][static_cast<std::size_t>(smaller)] =
                mips_of(late.pack.pack, tile)[static_cast<std::size_t>(smaller)];
            late.written(tile);
        }
        late.follow();
    }
    const io::LoadedPack expected = baked(hills(&place.terrain));
    std::vector<Mips> old;
    for (std::uint32_t tile = 0; tile < place.gpu.size(); ++tile) old.push_back(mips_of(place.pack.pack, tile));
    CHECK(off(late.gpu, old, expected.pack).mean < 1.05 * off(place.gpu, old, expected.pack).mean);

    // And a GPU's that begins later still.
    const GroundMapsBudget budget;
    const std::size_t bytes = ground_maps_bytes(place.pack.pack.header, budget);
    const io::AlignedMemory memory = io::allocate(bytes);
    place.gpu = old;
    REQUIRE(create_ground_maps(place.terrain, budget, {memory.get(), bytes}, place.maps).ok());
    place.follow();
    CHECK(off(place.gpu, old, expected.pack).mean == off(late.gpu, old, expected.pack).mean);
}

TEST_CASE("texels of coarser ground are made again when its pages come") {
    Place place, missing;
    const std::uint32_t pages = pages_per_tile(missing.pack.pack.header);
    for (Place* p : {&place, &missing}) p->stamp(StampShape::crater, 64, 66, 60, 25);
    place.follow();
    if (pages < 2) FAIL("the pack's tiles have one page only");
    for (std::uint32_t page = 1; page < pages; ++page) REQUIRE(unload_page(missing.terrain, 0, page).ok());
    CHECK(missing.follow().coarse > 0);
    CHECK((missing.gpu != place.gpu));
    for (std::uint32_t page = 1; page < pages; ++page)
        REQUIRE(load_page(missing.pack.pack, missing.terrain, 0, page).ok());
    CHECK(missing.follow().coarse == 0);
    const io::LoadedPack expected = baked(hills(&place.terrain));
    std::vector<Mips> old;
    for (std::uint32_t tile = 0; tile < place.gpu.size(); ++tile) old.push_back(mips_of(place.pack.pack, tile));
    CHECK(off(missing.gpu, old, expected.pack).mean < 1.05 * off(place.gpu, old, expected.pack).mean);
}

TEST_CASE("ground maps refuse what makes no sense, and change nothing") {
    Place place;
    GroundMapsReport report;
    CHECK(ground_maps_bytes(place.pack.pack.header, {.changes = 0}) == 0);
    CHECK(ground_maps_bytes(place.pack.pack.header, {.texels = 4095}) == 0);
    CHECK(ground_maps_bytes({}, {}) == 0);
    CHECK(update_ground_maps(place.maps, std::span(place.shown).first(1), report).code == StatusCode::out_of_range);
    place.stamp(StampShape::crater, 64, 66, 60, 25);
    for (TileMap& tile : place.shown) tile.side_log2 = 12; // larger than the pack's
    place.follow();
    CHECK(place.texels == 0);
    CHECK(update_ground_maps({}, place.shown, report).code == StatusCode::invalid_handle);
    CHECK(note_map_commands({}, {}).code == StatusCode::invalid_handle);
    CHECK(ground_map_patches({}).empty());
    GroundMaps none;
    std::vector<std::byte> little(64);
    CHECK(create_ground_maps(place.terrain, {}, little, none).code == StatusCode::memory_too_small);
    CHECK(create_ground_maps({}, {}, little, none).code == StatusCode::invalid_handle);
    CHECK(destroy_ground_maps(none).code == StatusCode::invalid_handle);
    CHECK(destroy_ground_maps(place.maps).ok());
    CHECK(destroy_ground_maps(place.maps).code == StatusCode::invalid_handle);
}
