// Whatever the bytes, reading a pack ends in a terrain or in a Status (DESIGN invariant 10). What was accepted is then
// used: a frame is refined, so that a hostile record cannot do harm either.
//
// Mutations hardly ever guess a 64-bit hash, so the first byte says whether to repair the hashes: then the cross-checks
// behind them, zstd and the records are what is attacked.
#include <cstdint>
#include <cstring>
#include <vector>

#include <xxhash.h>

#include "fjell/measure.h"
#include "fjell/recursive.h"
#include "host/load.h"

namespace {

using namespace fjell;

constexpr std::size_t most_bytes = std::size_t{64} << 20; // what a host would refuse to allocate is not read

void repair(std::vector<std::byte>& bytes) {
    if (bytes.size() < sizeof(PackHeader)) return;
    PackHeader h;
    std::memcpy(&h, bytes.data(), sizeof h);
    std::memcpy(h.magic, pack_magic, sizeof pack_magic);
    h.version = pack_version;
    h.header_bytes = sizeof h;
    h.layout_hash = pack_layout_hash;
    h.file_bytes = bytes.size();
    const std::size_t directory = h.directory_offset, size = bytes.size();
    if (directory >= sizeof h && directory <= size) {
        for (std::size_t at = directory; at + sizeof(ChunkEntry) <= size; at += sizeof(ChunkEntry)) {
            ChunkEntry e;
            std::memcpy(&e, bytes.data() + at, sizeof e);
            if (e.offset <= size && e.stored_bytes <= size - e.offset)
                e.hash = XXH3_64bits(bytes.data() + e.offset, e.stored_bytes);
            std::memcpy(bytes.data() + at, &e, sizeof e);
        }
        h.directory_hash = XXH3_64bits(bytes.data() + directory, size - directory);
    }
    h.header_hash = XXH3_64bits(&h, offsetof(PackHeader, header_hash));
    std::memcpy(bytes.data(), &h, sizeof h);
}

void use(const Pack& pack) {
    std::vector<std::byte> raw;
    for (std::uint64_t i = 0; i < pack.header.directory_count; ++i) {
        const ChunkEntry e = pack.entry(i);
        if (e.raw_bytes > most_bytes) continue;
        raw.resize(e.raw_bytes);
        (void)read_chunk(pack, e.kind, e.tile, e.level, raw);
    }
    const std::size_t bytes = terrain_bytes(pack.header);
    if (bytes > most_bytes) return;
    const host::AlignedBlock block = host::make_block(bytes);
    Terrain terrain;
    if (!load_terrain(pack, {block.get(), bytes}, terrain).ok()) return;
    const RecursiveBudget budget{4096 + 4 * terrain.tile_count(), 16384 + 9 * terrain.tile_count()};
    const std::size_t method_bytes = recursive_bytes(terrain, budget);
    if (method_bytes > most_bytes) return;
    const host::AlignedBlock method_block = host::make_block(method_bytes);
    RecursiveMethod method;
    if (!create_recursive(terrain, budget, {method_block.get(), method_bytes}, method).ok()) return;
    const View view = make_view({10, 500, 10}, {1, -0.5, 1}, {0, 1, 0}, 1, 640, 480, 1, 1e6);
    FrameReport report;
    for (const Topology topology : {Topology::triangles, Topology::strip}) {
        RefineSettings settings;
        settings.topology = topology;
        if (!update_recursive(method, view, settings, report).ok()) __builtin_trap();
        (void)measure_error(terrain, recursive_mesh(method), view);
    }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    const auto* first = reinterpret_cast<const std::byte*>(data);
    std::vector<std::byte> bytes(first + 1, first + size);
    if (data[0] & 1) repair(bytes);
    Pack pack;
    if (open_pack(bytes, pack).ok()) use(pack);
    return 0;
}
