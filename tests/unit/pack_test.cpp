// The pack as a file: what goes in comes out, and nothing that is not a pack gets in.
#include <catch2/catch.hpp>

#include <cstring>
#include <fstream>

#include <xxhash.h>

#include "baker/heights/region.h"
#include "baker/heights/scales.h"
#include "fjell/io/failure.h"
#include "fjell/terrain.h"
#include "io/file.h"
#include "shared/terrain_data.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::test;

namespace {

std::vector<std::byte> small_pack() {
    Random random(21);
    baker::Dem dem = random_dem(random, 25, 17, Shape::fractal);
    dem.crs_wkt = "LOCAL_CS[\"test\"]";
    return bake_and_load(std::move(dem), small_bake(3)).file;
}

// Opens and reads everything, as a reader would; returns the first error.
Status read_all(std::span<const std::byte> bytes) {
    Pack pack;
    if (Status s = open_pack(bytes, pack); !s.ok()) return s;
    std::vector<std::byte> raw;
    for (std::uint64_t i = 0; i < pack.header.directory_count; ++i) {
        const ChunkEntry e = pack.entry(i);
        raw.resize(e.raw_bytes);
        if (Status s = read_chunk(pack, chunk_id(pack.header, i), raw); !s.ok()) return s;
    }
    const std::size_t size = terrain_bytes(pack.header);
    const io::AlignedMemory memory = io::allocate(size);
    Terrain terrain;
    return load_terrain(pack, {memory.get(), size}, terrain);
}

// Changes a header and makes its hash right again: only the cross-checks are left to notice.
template <typename Change>
Status with_header(std::vector<std::byte> bytes, const Change& change) {
    PackHeader h;
    std::memcpy(&h, bytes.data(), sizeof h);
    change(h);
    h.header_hash = XXH3_64bits(&h, offsetof(PackHeader, header_hash));
    std::memcpy(bytes.data(), &h, sizeof h);
    return read_all(bytes);
}

std::vector<std::int32_t> steps_of(const baker::Dem& dem, const io::LoadedPack& pack) {
    std::vector<std::int32_t> steps(dem.heights_m.size());
    baker::quantise(dem.heights_m.data(), steps.size(), data_of(pack.terrain).height_scale, steps.data());
    return steps;
}

} // namespace

TEST_CASE("a pack that was read back holds every sample, map and the CRS") {
    Random random(22);
    baker::Dem dem = random_dem(random, 33, 25, Shape::fractal);
    dem.crs_wkt = "LOCAL_CS[\"test\"]";
    dem.crs_origin[0] = 432000.25;
    const auto pack = bake_and_load(dem, small_bake(3));
    REQUIRE(pack.crs == dem.crs_wkt);
    REQUIRE(pack.terrain.header().crs_origin[0] == 432000.25);
    const auto steps = steps_of(dem, pack);
    for (std::int32_t y = 0; y < 25; ++y)
        for (std::int32_t x = 0; x < 33; ++x)
            REQUIRE(data_of(pack.terrain).vertex({x, y}).steps == steps[static_cast<std::size_t>(y * 33 + x)]);
    REQUIRE(read_all(pack.file).ok());
    REQUIRE(io::check_all_chunks(pack.pack, pack.path) == pack.pack.header.directory_count);
}

TEST_CASE("a height field of any extents is kept whole, in the fewest tiles that cover it") {
    Random random(23);
    for (const auto& [columns, rows, tiles_x, tiles_y] :
         {std::tuple{2, 2, 1, 1}, {9, 9, 1, 1}, {10, 9, 2, 1}, {39, 20, 5, 3}, {2, 100, 1, 13}}) {
        const baker::Dem dem = random_dem(random, columns, rows, Shape::noise);
        const auto pack = bake_and_load(dem, small_bake(3));
        REQUIRE(data_of(pack.terrain).tree.columns() == columns);
        REQUIRE(data_of(pack.terrain).tree.rows() == rows);
        REQUIRE(data_of(pack.terrain).tree.tiles_x == tiles_x);
        REQUIRE(data_of(pack.terrain).tree.tiles_y == tiles_y);
        const auto steps = steps_of(dem, pack);
        for (std::int32_t y = 0; y < rows; ++y)
            for (std::int32_t x = 0; x < columns; ++x)
                REQUIRE(data_of(pack.terrain).vertex({x, y}).steps == steps[static_cast<std::size_t>(y * columns + x)]);
    }
}

TEST_CASE("errors of the finest step are left out of the pack, but at the rim and beside holes") {
    Random random(28);
    baker::Dem dem = random_dem(random, 257, 257, Shape::noise);
    for (float& h : dem.heights_m) h = std::round(h);
    dem.native_quantum_m = 1;
    dem.voids.assign(dem.heights_m.size(), 0);
    dem.voids[dem.index(21, 231)] = 1;
    for (const PageOrder order : {PageOrder::planar, PageOrder::hierarchical_z}) {
        baker::BakeOptions options = small_bake(8);
        options.order = order;
        const auto pack = bake_and_load(dem, options);
        const PageLayout pages = pages_of(pack.pack.header);
        int derived = 0;
        for (std::uint32_t page = 0; page < pages.pages_per_tile(); ++page) {
            const ChunkId id{ChunkKind::geometry, 0, page};
            std::vector<std::byte> raw(pack.pack.entry(chunk_index(pack.pack.header, id)).raw_bytes);
            REQUIRE(read_chunk(pack.pack, id, raw).ok());
            PageHead head;
            std::memcpy(&head, raw.data(), sizeof head);
            const bool finest = pages.page_step_log2(page) == 0,
                       holed = finest && pages.page_position(page) == SampleIndex{0, 3};
            CHECK(((head.flags & page_errors) == 0) == (finest && !holed));
            CHECK(((head.flags & page_voids) != 0) == holed);
            derived += (head.flags & page_errors) == 0;
        }
        CHECK(derived == 15);
    }
}

TEST_CASE("automatic tiles: 512 cells, more for more than 1,024 tiles, fewer when one covers the terrain") {
    CHECK(baker::auto_tile_log2(2, 2) == 1);
    CHECK(baker::auto_tile_log2(3, 3) == 1);
    CHECK(baker::auto_tile_log2(4, 2) == 2);
    CHECK(baker::auto_tile_log2(512, 512) == 9);
    CHECK(baker::auto_tile_log2(4320, 2161) == 9);
    CHECK(baker::auto_tile_log2(16385, 16385) == 9);
    CHECK(baker::auto_tile_log2(16386, 16385) == 10);
    CHECK(baker::auto_tile_log2(65537, 65537) == 11);
}

TEST_CASE("whatever bake accepts, open_pack opens, and what it does not accept leaves nothing") {
    Random random(27);
    int accepted = 0, refused = 0;
    for (int round = 0; round < 300; ++round) {
        baker::Dem dem = random_dem(random, pick(random, 2, 20), pick(random, 2, 20), Shape::noise);
        const double scale = std::pow(10.0, uniform(random, -12, 9)),
                     offset = uniform(random, -1, 1) * std::pow(10.0, uniform(random, 0, 8));
        for (float& h : dem.heights_m) h = static_cast<float>(h * scale + offset);
        dem.spacing_m[0] = std::pow(10.0, uniform(random, -5, 9));
        dem.spacing_m[1] = std::pow(10.0, uniform(random, -5, 9));
        dem.native_quantum_m = pick(random, 0, 1) ? scale : 0;
        const TemporaryFolder folder;
        try {
            (void)baker::bake(dem, small_bake(pick(random, 1, 4)), folder / "pack.fjell");
        } catch (const io::Failure& f) {
            ++refused;
            REQUIRE(f.exit_code == 1);
            REQUIRE(std::filesystem::is_empty(folder.path));
            continue;
        }
        ++accepted;
        REQUIRE_NOTHROW(io::load_pack(folder / "pack.fjell", io::LoadTerrain::yes));
    }
    REQUIRE(accepted > 20);
    REQUIRE(refused > 20);
}

TEST_CASE("every truncation of a pack is refused") {
    const auto whole = small_pack();
    REQUIRE(read_all(whole).ok());
    for (std::size_t size = 0; size < whole.size(); ++size) {
        const Status s = read_all(std::span(whole).first(size));
        CAPTURE(size, s.field);
        REQUIRE((s.code == StatusCode::truncated || (size < 8 && s.code == StatusCode::not_a_pack)));
    }
    auto longer = whole;
    longer.push_back(std::byte{0});
    REQUIRE(read_all(longer).code == StatusCode::corrupt);
}

TEST_CASE("every single flipped bit is refused") {
    const auto whole = small_pack();
    auto bytes = whole;
    for (std::size_t i = 0; i < bytes.size(); ++i)
        for (int bit = 0; bit < 8; bit += i < 512 ? 1 : 5) {
            bytes[i] = whole[i] ^ std::byte{static_cast<unsigned char>(1u << bit)};
            CAPTURE(i, bit);
            REQUIRE_FALSE(read_all(bytes).ok());
            bytes[i] = whole[i];
        }
}

TEST_CASE("a header whose hash is right is still not believed") {
    const auto whole = small_pack();
    REQUIRE(with_header(whole, [](PackHeader&) {}).ok());
    const auto code = [&](auto change) { return with_header(whole, change).code; };
    CHECK(code([](PackHeader& h) { h.version = 99; }) == StatusCode::wrong_version);
    CHECK(code([](PackHeader& h) { h.version = pack_version - 1; }) == StatusCode::wrong_version);
    CHECK(code([](PackHeader& h) { h.layout_hash ^= 1; }) == StatusCode::wrong_layout);
    CHECK(code([](PackHeader& h) { h.tile_log2 = 31; }) == StatusCode::out_of_range);
    CHECK(code([](PackHeader& h) { h.tile_log2 = 0; }) == StatusCode::out_of_range);
    CHECK(code([](PackHeader& h) { h.tiles_x = 0xffffffff; }) == StatusCode::out_of_range);
    CHECK(code([](PackHeader& h) { h.columns = 7; }) == StatusCode::out_of_range);
    CHECK(code([](PackHeader& h) { h.columns = 1; }) == StatusCode::out_of_range);
    CHECK(code([](PackHeader& h) { h.rows = 0xffffffff; }) == StatusCode::out_of_range);
    CHECK(code([](PackHeader& h) { h.tiles_x = 2, h.columns = 17; }) == StatusCode::corrupt);
    CHECK(code([](PackHeader& h) { h.spacing_m[0] = 0; }) == StatusCode::out_of_range);
    CHECK(code([](PackHeader& h) { h.spacing_m[1] = std::numeric_limits<double>::quiet_NaN(); }) ==
          StatusCode::out_of_range);
    CHECK(code([](PackHeader& h) { h.quantum_m = -1; }) == StatusCode::out_of_range);
    CHECK(code([](PackHeader& h) { h.nesting = 0; }) == StatusCode::out_of_range);
    CHECK(code([](PackHeader& h) { h.colour_log2 = 32; }) == StatusCode::out_of_range);
    CHECK(code([](PackHeader& h) { h.normal_log2 = 3; }) == StatusCode::corrupt);
    CHECK(code([](PackHeader& h) { h.horizon_log2 = 1; }) == StatusCode::out_of_range);
    CHECK(code([](PackHeader& h) { h.horizon_log2 = 3; }) == StatusCode::corrupt);
    CHECK(code([](PackHeader& h) { h.features = pack_has_horizons; }) == StatusCode::corrupt);
    CHECK(code([](PackHeader& h) { h.splat_log2 = 3; }) == StatusCode::out_of_range); // without names
    CHECK(code([](PackHeader& h) { h.layer_bytes = 5; }) == StatusCode::out_of_range);
    CHECK(code([](PackHeader& h) { h.splat_log2 = 3, h.layer_bytes = 5; }) == StatusCode::corrupt);
    CHECK(code([](PackHeader& h) { h.features = 8; }) == StatusCode::wrong_version);
    CHECK(code([](PackHeader& h) { h.directory_offset = ~0ull; }) == StatusCode::corrupt);
    CHECK(code([](PackHeader& h) { h.directory_count = 1ull << 61; }) == StatusCode::corrupt);
    CHECK(code([](PackHeader& h) { h.file_bytes = ~0ull; }) == StatusCode::truncated);
    CHECK(code([](PackHeader& h) { h.crs_bytes = 0xffffffff; }) == StatusCode::out_of_range);
    CHECK(code([](PackHeader& h) { h.order = static_cast<PageOrder>(3); }) == StatusCode::out_of_range);
    CHECK(code([](PackHeader& h) { h.error_floor_m = 0; }) == StatusCode::out_of_range);
    CHECK(code([](PackHeader& h) { h.error_ratio = 1; }) == StatusCode::out_of_range);
    CHECK(code([](PackHeader& h) { h.error_nesting_steps = 0; }) == StatusCode::out_of_range);
    CHECK(code([](PackHeader& h) { h.level_radius_m[5] = 0; }) == StatusCode::out_of_range);
    CHECK(code([](PackHeader& h) { h.height_steps = 1u << 25; }) == StatusCode::out_of_range);
    CHECK(code([](PackHeader& h) { h.notes_bytes = ~0ull; }) == StatusCode::out_of_range);
    CHECK(code([](PackHeader& h) { h.notes_offset = ~0ull; }) == StatusCode::corrupt);
    CHECK(code([](PackHeader& h) { h.notes_offset = 511; }) == StatusCode::corrupt);
    CHECK(code([](PackHeader& h) { h.notes_bytes += 1; }) == StatusCode::corrupt); // into the directory
    CHECK(code([](PackHeader& h) { h.notes_hash ^= 1; }) == StatusCode::corrupt);
    CHECK(code([](PackHeader& h) { h.notes_offset = h.notes_bytes = h.notes_hash = 0; }) ==
          StatusCode::ok); // it needs none
}

TEST_CASE("every error has a message with a remedy and names its field") {
    for (const StatusCode c :
         {StatusCode::truncated, StatusCode::not_a_pack, StatusCode::wrong_version, StatusCode::wrong_layout,
          StatusCode::corrupt, StatusCode::out_of_range, StatusCode::memory_too_small, StatusCode::budget_too_small,
          StatusCode::out_of_slots, StatusCode::coarser_page_first}) {
        const std::string text = message(c);
        CHECK(text.find(';') != std::string::npos);
        CHECK(text.find('\n') == std::string::npos);
    }
    const auto whole = small_pack();
    REQUIRE(std::string(with_header(whole, [](PackHeader& h) { h.tile_log2 = 31; }).field) == "tile_log2");
}

TEST_CASE("memory that is too small or a budget below the coarsest mesh is refused before anything is written") {
    Random random(24);
    const auto pack = bake_and_load(random_dem(random, 33, 33, Shape::noise), small_bake(3));
    Terrain terrain;
    const std::size_t size = terrain_bytes(pack.pack.header);
    const io::AlignedMemory memory = io::allocate(size);
    CHECK(load_terrain(pack.pack, {memory.get(), size - 1}, terrain).code == StatusCode::memory_too_small);
    RecursiveMethod method;
    const RecursiveBudget least{16 * 4, 16 * 9};
    const std::size_t bytes = recursive_bytes(pack.terrain, least);
    const io::AlignedMemory room = io::allocate(bytes);
    CHECK(create_recursive(pack.terrain, {16 * 4 - 1, 1000}, {room.get(), bytes}, method).code ==
          StatusCode::budget_too_small);
    CHECK(create_recursive(pack.terrain, {1000, 16 * 9 - 1}, {room.get(), bytes}, method).code ==
          StatusCode::budget_too_small);
    CHECK(create_recursive(pack.terrain, least, {room.get(), bytes - 1}, method).code == StatusCode::memory_too_small);
    CHECK(create_recursive(pack.terrain, least, {room.get(), bytes}, method).ok());
}

TEST_CASE("a bake that fails leaves nothing, one that is interrupted its work, and an old pack stays as it was") {
    Random random(25);
    const TemporaryFolder folder;
    const std::string out = folder / "pack.fjell";
    const baker::Dem dem = random_dem(random, 33, 33, Shape::noise);
    int calls = 0, last = 0, code = 0, first_stage = 0; // calls of the stage that reads
    const auto bake_until = [&](int call, int with) {
        calls = 0, last = call, code = with;
        baker::BakeOptions options = small_bake(3);
        options.checkpoint_s = 5; // on the disk, though it would fit the memory
        options.progress = [&](const char* stage, std::uint64_t, std::uint64_t) {
            ++calls;
            if (stage == std::string("read")) first_stage = calls;
            if (calls == last) throw io::Failure(code, "no more");
        };
        return baker::bake(dem, options, out);
    };
    REQUIRE_THROWS_AS(bake_until(2, 3), io::Failure);
    REQUIRE(folder.names().empty());
    (void)bake_until(0, 0);
    const int steps = calls;
    REQUIRE(first_stage > 0);
    REQUIRE(steps > first_stage + 5);
    const auto before = io::read_file(out);
    for (int call = 1; call <= steps; ++call) {
        REQUIRE_THROWS_AS(bake_until(call, 3), io::Failure);
        REQUIRE(folder.names() == std::vector<std::string>{"pack.fjell"});
        // Before the first stage is complete there is nothing to go on from.
        const bool worth = call > first_stage;
        REQUIRE_THROWS_WITH(bake_until(call, 130),
                            Catch::Contains(worth ? "the same command goes on" : "nothing is left"));
        REQUIRE(folder.names() == (worth ? std::vector<std::string>{"pack.fjell", "pack.fjell.work"}
                                         : std::vector<std::string>{"pack.fjell"}));
        REQUIRE(io::read_file(out) == before);
        REQUIRE(bake_until(0, 0).resumed == worth);
        REQUIRE(folder.names() == std::vector<std::string>{"pack.fjell"});
        REQUIRE(io::read_file(out) == before);
    }
    // Another bake's work is of no use.
    REQUIRE_THROWS_AS(bake_until(4, 130), io::Failure);
    REQUIRE(!baker::bake(dem, small_bake(4), out).resumed);
    // Nor is one that is cut otherwise, though it comes to the same.
    REQUIRE_THROWS_AS(bake_until(steps / 2, 130), io::Failure);
    baker::BakeOptions other_regions = small_bake(3);
    other_regions.region_cells = 8;
    REQUIRE(!baker::bake(dem, other_regions, out).resumed);
    REQUIRE(io::read_file(out) == before);
    REQUIRE(folder.names() == std::vector<std::string>{"pack.fjell"});
    // In memory there is nothing to go on from.
    baker::BakeOptions in_memory = small_bake(3);
    in_memory.progress = [](const char*, std::uint64_t, std::uint64_t) { throw io::Failure(130, "no more"); };
    REQUIRE_THROWS_WITH(baker::bake(dem, in_memory, out), Catch::Contains("nothing is left"));
    REQUIRE(folder.names() == std::vector<std::string>{"pack.fjell"});
}

TEST_CASE("an output that cannot be written is refused with the right exit code and a remedy") {
    Random random(26);
    const TemporaryFolder folder;
    const auto exit_code = [&](const std::string& out, const std::string& says) {
        try {
            (void)baker::bake(random_dem(random, 33, 33, Shape::noise), small_bake(3), out);
        } catch (const io::Failure& f) {
            CHECK(std::string(f.what()).find(says) != std::string::npos);
            CHECK(std::string(f.what()).find('\n') == std::string::npos);
            return f.exit_code;
        }
        return 0;
    };
    CHECK(exit_code(folder / "missing/pack.fjell", "does not exist") == 1);
    CHECK(exit_code(folder.path.string(), "is a folder") == 1);
    CHECK(exit_code("/dev/full", "free some space") == 3);
}
