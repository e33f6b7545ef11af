#include "host/load.h"

#include <new>

#include <sys/mman.h>

#include <fmt/format.h>

#include "host/failure.h"
#include "host/file.h"

namespace fjell::host {

namespace {

// Large blocks are read all over the place: on 2 MB pages a walk down the vertex tree spares a TLB miss a step.
constexpr std::size_t huge_page_bytes = std::size_t{2} << 20;
constexpr std::align_val_t block_alignment{huge_page_bytes};

void require(const Status& status, const std::string& path) {
    if (!status.ok()) throw Failure(1, fmt::format("{}: {}: {}", path, status.field, message(status.code)));
}

} // namespace

void AlignedDelete::operator()(std::byte* block) const {
    ::operator delete[](block, block_alignment);
}

AlignedBlock make_block(std::size_t bytes) {
    AlignedBlock block(static_cast<std::byte*>(::operator new[](bytes, block_alignment)));
    if (bytes >= huge_page_bytes) (void)madvise(block.get(), bytes, MADV_HUGEPAGE); // a wish; refusal costs speed only
    return block;
}

LoadedPack load_pack(const std::string& path, LoadTerrain what) {
    LoadedPack loaded;
    loaded.path = path;
    loaded.file = read_file(path);
    require(open_pack(loaded.file, loaded.pack), path);
    loaded.crs.resize(loaded.pack.header.crs_bytes);
    if (!loaded.crs.empty())
        require(read_chunk(loaded.pack, {ChunkKind::crs, 0, 0}, std::as_writable_bytes(std::span(loaded.crs))), path);
    if (what == LoadTerrain::no) return loaded;
    const std::size_t bytes = terrain_bytes(loaded.pack.header);
    loaded.block = make_block(bytes);
    require(load_terrain(loaded.pack, {loaded.block.get(), bytes}, loaded.terrain), path);
    return loaded;
}

std::uint64_t check_all_chunks(const LoadedPack& loaded) {
    const std::uint64_t count = loaded.pack.header.directory_count;
    std::vector<std::byte> raw;
    for (std::uint64_t i = 0; i < count; ++i) {
        const ChunkEntry e = loaded.pack.entry(i);
        raw.resize(e.raw_bytes);
        const ChunkId id = chunk_id(loaded.pack.header, i);
        const Status s = read_chunk(loaded.pack, id, raw);
        if (!s.ok())
            throw Failure(1, fmt::format("{}: chunk {} of tile {}: {}", loaded.path, i, id.tile, message(s.code)));
    }
    return count;
}

} // namespace fjell::host
