#include "fjell/io/load.h"

#include <cerrno>
#include <cstring>
#include <new>

#include "fjell/io/failure.h"
#include "fjell/io/pack_file.h"
#include "io/file.h"
#include "io/system.h"

namespace fjell::io {

namespace {

// Large memory is read all over the place: on 2 MB pages a walk down the vertex tree spares a TLB miss a step.
constexpr std::size_t huge_page_bytes = std::size_t{2} << 20;
constexpr std::align_val_t alignment{huge_page_bytes};

} // namespace

void AlignedDelete::operator()(std::byte* memory) const {
    ::operator delete[](memory, alignment);
}

AlignedMemory allocate(std::size_t bytes) {
    AlignedMemory memory(static_cast<std::byte*>(::operator new[](bytes, alignment)));
    if (bytes >= huge_page_bytes) os::prefer_huge_pages(memory.get(), bytes);
    return memory;
}

LoadedPack load_pack(const PackFile& file, LoadTerrain what) {
    LoadedPack loaded;
    loaded.path = file.path();
    loaded.crs = file.crs();
    loaded.file.resize(file.pack().header.file_bytes);
    if (const int error = file.read(0, loaded.file); error != 0) file.fail(error);
    // Another pack may be there now, and a whole one.
    if (std::memcmp(loaded.file.data(), &file.pack().header, sizeof(PackHeader)) != 0) file.fail(EIO);
    require(open_pack(loaded.file, loaded.pack), loaded.path);
    if (what == LoadTerrain::no) return loaded;
    const std::size_t bytes = terrain_bytes(loaded.pack.header);
    loaded.memory = allocate(bytes);
    require(load_terrain(loaded.pack, {loaded.memory.get(), bytes}, loaded.terrain), loaded.path);
    return loaded;
}

LoadedPack load_pack(const std::string& path, LoadTerrain what) {
    return load_pack(PackFile(path), what);
}

std::uint64_t check_all_chunks(const Pack& pack, const std::string& path) {
    std::vector<std::byte> raw;
    for (std::uint64_t i = 0; i < pack.header.directory_count; ++i) {
        raw.resize(pack.entry(i).raw_bytes);
        const ChunkId id = chunk_id(pack.header, i);
        if (const Status s = read_chunk(pack, id, raw); !s.ok())
            throw Failure(1, path + ": " + chunk_name(id) + ": " + message(s.code));
    }
    return pack.header.directory_count;
}

std::uint64_t check_all_chunks(const PackFile& file) {
    std::vector<std::byte> raw;
    const PackHeader& h = file.pack().header;
    for (std::uint64_t i = 0; i < h.directory_count; ++i) file.read_chunk(chunk_id(h, i), raw);
    return h.directory_count;
}

} // namespace fjell::io
