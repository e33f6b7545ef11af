// A disk or a network that changes a pack: every bit of it is under a hash, so nothing slips through.
#include <cstring>
#include <random>
#include <vector>

#include <catch2/catch.hpp>

#include "shared/terrain_data.h"
#include "support/rounds.h"
#include "support/terrain_fixture.h"

namespace {

using namespace fjell;
using namespace fjell::test;
using Bytes = std::vector<std::byte>;

// One tile of 64 x 64 cells with a hole: a root page and a step page whose errors are derived wherever there is no
// hole.
io::LoadedPack small_pack() {
    Random random(5);
    baker::Dem dem = random_dem(random, 65, 65, Shape::fractal);
    dem.voids.assign(dem.heights_m.size(), 0);
    for (std::int32_t y = 20; y < 31; ++y)
        for (std::int32_t x = 33; x < 50; ++x) dem.voids[dem.index(x, y)] = 1;
    dem.crs_wkt = "LOCAL_CS[\"flipped\"]";
    return bake_and_load(std::move(dem), small_bake(6));
}

std::vector<Bytes> decode_chunks(const Pack& pack) {
    std::vector<Bytes> chunks;
    for (std::uint64_t i = 0; i < pack.header.directory_count; ++i) {
        Bytes& raw = chunks.emplace_back(pack.entry(i).raw_bytes);
        REQUIRE(read_chunk(pack, chunk_id(pack.header, i), raw).ok());
    }
    return chunks;
}

bool same_records(const Terrain& a, const Terrain& b) {
    const auto corners = static_cast<std::size_t>((data_of(a).tree.tiles_x + 1) * (data_of(a).tree.tiles_y + 1));
    if (std::memcmp(data_of(a).corners, data_of(b).corners, corners * sizeof *data_of(a).corners) != 0) return false;
    for (std::uint32_t page = 0; page < a.page_count(); ++page) {
        const PageEntry p = data_of(a).page_table[page], q = data_of(b).page_table[page];
        if (p.base != q.base) return false;
        if (std::memcmp(data_of(a).records + std::size_t{p.slot} * data_of(a).page_capacity,
                        data_of(b).records + std::size_t{q.slot} * data_of(b).page_capacity,
                        data_of(a).pages.page_vertices(page % a.pages_per_tile()) * sizeof(VertexRecord)) != 0)
            return false;
    }
    return true;
}

enum class Outcome { refused, read_right, read_wrong };

// A reader that was given changed bytes, and what it should have decoded.
class Reader {
public:
    explicit Reader(const io::LoadedPack& pack)
        : original_(pack), chunks_(decode_chunks(pack.pack)), memory_bytes_(terrain_bytes(pack.pack.header)),
          memory_(io::allocate(memory_bytes_)) {}

    // Of the terrain: refused, or the same records.
    Outcome terrain(const Pack& pack) {
        Terrain terrain;
        if (terrain_bytes(pack.header) > memory_bytes_) return Outcome::read_wrong; // another header was accepted
        if (!load_terrain(pack, {memory_.get(), memory_bytes_}, terrain).ok()) return Outcome::refused;
        return same_records(terrain, original_.terrain) ? Outcome::read_right : Outcome::read_wrong;
    }
    // Of all chunks, also those that make no terrain: one is refused, or all are the same.
    Outcome chunks(const Pack& pack) {
        bool refused = false;
        for (std::uint64_t i = 0; i < pack.header.directory_count; ++i) {
            raw_.resize(pack.entry(i).raw_bytes);
            if (!read_chunk(pack, chunk_id(pack.header, i), raw_).ok())
                refused = true;
            else if (raw_ != chunks_[i])
                return Outcome::read_wrong;
        }
        return refused ? Outcome::refused : Outcome::read_right;
    }

private:
    const io::LoadedPack& original_;
    const std::vector<Bytes> chunks_;
    const std::size_t memory_bytes_;
    io::AlignedMemory memory_;
    Bytes raw_;
};

} // namespace

TEST_CASE("random flips of a small pack are refused or read right") {
    const io::LoadedPack original = small_pack();
    REQUIRE(original.terrain.has_voids());
    Reader reader(original);
    Bytes file = original.file;
    Random random(17);
    const int bits = static_cast<int>(file.size() * 8);
    const auto flips = rounds<std::size_t>(20'000, 100'000);
    std::size_t opened = 0, loaded = 0;
    for (std::size_t flip = 0; flip < flips; ++flip) {
        int at[3];
        const int count = pick(random, 1, 3);
        const auto turn = [&] {
            for (int i = 0; i < count; ++i)
                file[static_cast<std::size_t>(at[i] / 8)] ^= static_cast<std::byte>(1 << (at[i] % 8));
        };
        for (int i = 0; i < count; ++i) at[i] = pick(random, 0, bits - 1);
        turn();
        Pack pack;
        if (open_pack(file, pack).ok()) {
            ++opened;
            const Outcome terrain = reader.terrain(pack), chunks = reader.chunks(pack);
            loaded += terrain == Outcome::read_right;
            // Two flips of one bit are none; otherwise something is refused, if only a texture that nobody draws.
            const bool changed = file != original.file;
            if (terrain == Outcome::read_wrong || chunks != (changed ? Outcome::refused : Outcome::read_right)) {
                CAPTURE(flip, count, at[0], at[1], at[2]);
                FAIL("a changed pack was read as if it were whole");
            }
        }
        turn();
    }
    CHECK(file == original.file);
    CHECK(opened > flips / 10);   // chunks are most of the file, and opening does not touch them
    CHECK(loaded > flips / 1000); // their hashes are looked at one by one
}

TEST_CASE("Every truncation of a small pack is refused") {
    const io::LoadedPack original = small_pack();
    for (std::size_t size = 0; size < original.file.size(); ++size) {
        const Bytes cut(original.file.begin(), original.file.begin() + static_cast<std::ptrdiff_t>(size));
        Pack pack;
        const Status s = open_pack(cut, pack);
        CAPTURE(size);
        if (s.code != (size < sizeof pack_magic ? StatusCode::not_a_pack : StatusCode::truncated))
            FAIL(message(s.code));
        if (pack.directory) FAIL("a pack that was refused was handed out");
    }
}
