// A pack that stays in its file: what it gives is what the whole pack has, and what is not a pack is refused by name.
#include <catch2/catch.hpp>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include <sys/stat.h>

#include "fjell/io/failure.h"
#include "fjell/io/pack_file.h"
#include "fjell/terrain.h"
#include "io/file.h"
#include "shared/terrain_data.h"
#include "support/program.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::test;

namespace {

struct Place {
    Place() {
        Random random(41);
        baker::Dem dem = random_dem(random, 100, 70, Shape::fractal);
        dem.crs_wkt = "LOCAL_CS[\"test\"]";
        (void)baker::bake(dem, small_bake(6), pack);
        bytes = slurp(pack);
    }
    TemporaryFolder folder;
    const std::string pack = folder / "pack.fjell";
    std::string bytes;
};

// Empty when it opens.
std::string refusal(const std::string& path, int exit_code = 1) {
    try {
        const io::PackFile file(path);
    } catch (const io::Failure& f) {
        CHECK(f.exit_code == exit_code);
        CHECK(std::string(f.what()).find('\n') == std::string::npos);
        return f.what();
    }
    return {};
}

} // namespace

TEST_CASE("a pack in its file has the index, the corners, the CRS and every chunk of the whole one") {
    const Place place;
    const io::PackFile file(place.pack);
    const auto whole = io::load_pack(place.pack, io::LoadTerrain::yes);
    CHECK(file.crs() == "LOCAL_CS[\"test\"]");
    CHECK(file.pack().bytes.empty());
    REQUIRE(std::memcmp(&file.pack().header, &whole.pack.header, sizeof(PackHeader)) == 0);
    std::vector<std::byte> stored, raw, expected;
    for (std::uint64_t i = 0; i < whole.pack.header.directory_count; ++i) {
        const ChunkEntry e = file.pack().entry(i);
        stored.resize(e.stored_bytes);
        REQUIRE(file.read(e.offset, stored) == 0);
        raw.resize(e.raw_bytes);
        expected.resize(e.raw_bytes);
        REQUIRE(decode_chunk(e, stored, raw).ok());
        REQUIRE(read_chunk(whole.pack, chunk_id(whole.pack.header, i), expected).ok());
        REQUIRE(raw == expected);
    }
    const TerrainBudget some{3};
    const std::size_t bytes = terrain_bytes(file.pack().header, some);
    const io::AlignedMemory memory = io::allocate(bytes);
    Terrain terrain;
    REQUIRE(create_terrain(file.pack(), file.corners(), some, {memory.get(), bytes}, terrain).ok());
    const std::size_t corners = std::size_t{terrain.header().tiles_x + 1} * (terrain.header().tiles_y + 1);
    CHECK(std::memcmp(data_of(terrain).corners, data_of(whole.terrain).corners,
                      corners * sizeof *data_of(terrain).corners) == 0);
}

TEST_CASE("every truncation of a pack is refused before anything is streamed from it") {
    const Place place;
    REQUIRE(refusal(place.pack).empty());
    const std::string cut = place.folder / "cut.fjell";
    for (std::size_t size = 0; size < place.bytes.size(); size += size < 600 ? 1 : 97) {
        spit(cut, place.bytes.substr(0, size));
        const std::string said = refusal(cut);
        CAPTURE(size, said);
        REQUIRE(said.starts_with(cut + ": "));
    }
    spit(cut, place.bytes + "x");
    CHECK(!refusal(cut).empty());
}

TEST_CASE("a damaged header, directory or CRS is refused when the pack is opened, a damaged page when it is read") {
    const Place place;
    const io::PackFile whole(place.pack);
    const PackHeader& h = whole.pack().header;
    const std::string changed = place.folder / "changed.fjell";
    const auto with_flip = [&](std::size_t at) {
        std::string bytes = place.bytes;
        bytes[at] = static_cast<char>(bytes[at] ^ 4);
        spit(changed, bytes);
        return refusal(changed);
    };
    for (std::size_t at = 0; at < sizeof(PackHeader); at += 5) CHECK(!with_flip(at).empty());
    for (std::size_t at = h.directory_offset; at < h.file_bytes; at += 7) CHECK(!with_flip(at).empty());
    CHECK(with_flip(whole.pack().entry(chunk_index(h, {ChunkKind::crs, 0, 0})).offset + 3).find("CRS") !=
          std::string::npos);
    const ChunkEntry page = whole.pack().entry(chunk_index(h, {ChunkKind::geometry, 0, 1}));
    REQUIRE(with_flip(page.offset + 9).empty());
    const io::PackFile file(changed);
    std::vector<std::byte> stored(page.stored_bytes), raw(page.raw_bytes);
    REQUIRE(file.read(page.offset, stored) == 0);
    CHECK(decode_chunk(page, stored, raw).code == StatusCode::corrupt);
}

TEST_CASE("a file that is gone is read on, one that has shrunk answers with an error") {
    const Place place;
    const io::PackFile file(place.pack);
    std::vector<std::byte> bytes(place.bytes.size());
    std::filesystem::resize_file(place.pack, 1000);
    CHECK(file.read(0, std::span(bytes).first(1000)) == 0);
    CHECK(std::memcmp(bytes.data(), place.bytes.data(), 1000) == 0);
    CHECK(file.read(0, std::span(bytes).first(1001)) == EIO);
    CHECK(file.read(1u << 30, std::span(bytes).first(1)) == EIO);
    file.drop_cache();
    std::filesystem::remove(place.pack);
    CHECK(file.read(0, std::span(bytes).first(1000)) == 0);
}

TEST_CASE("what is no file is refused, and a pipe does not hang") {
    const TemporaryFolder folder;
    CHECK(refusal(folder / "nothing").find("give an existing file") != std::string::npos);
    CHECK(refusal(folder.path.string()).find("is a folder without a set.json") != std::string::npos);
    REQUIRE(mkfifo((folder / "pipe").c_str(), 0600) == 0);
    CHECK(refusal(folder / "pipe").find("not a file") != std::string::npos);
    CHECK(refusal("/dev/null").find("not a file") != std::string::npos);
}
