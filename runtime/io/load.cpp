#include "fjell/io/load.h"

#include <cerrno>
#include <cstring>
#include <new>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "fjell/io/failure.h"
#include "io/file.h"

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
    if (bytes >= huge_page_bytes) (void)madvise(memory.get(), bytes, MADV_HUGEPAGE); // a wish; refusal costs speed only
    return memory;
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
    loaded.memory = allocate(bytes);
    require(load_terrain(loaded.pack, {loaded.memory.get(), bytes}, loaded.terrain), path);
    return loaded;
}

MappedPack::MappedPack(const std::string& path) : path_(path) {
    const int fd = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK); // a pipe without a writer must not hang
    if (fd < 0) throw Failure(1, path + ": " + std::strerror(errno) + "; give an existing file");
    struct stat info {};
    const bool regular = fstat(fd, &info) == 0 && S_ISREG(info.st_mode);
    size_ = regular ? static_cast<std::size_t>(info.st_size) : 0;
    if (size_ > 0) bytes_ = mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, fd, 0);
    const int error = errno;
    close(fd);
    if (!regular) throw Failure(1, path + ": not a file; give a regular file");
    if (bytes_ == MAP_FAILED)
        throw Failure(3, path + ": cannot be mapped: " + std::strerror(error) + "; check memory and the disk");
    try {
        require(open_pack({static_cast<const std::byte*>(bytes_), size_}, pack_), path);
        crs_.resize(pack_.header.crs_bytes);
        if (!crs_.empty())
            require(read_chunk(pack_, {ChunkKind::crs, 0, 0}, std::as_writable_bytes(std::span(crs_))), path);
    } catch (...) {
        if (bytes_) munmap(bytes_, size_);
        throw;
    }
}

MappedPack::~MappedPack() {
    if (bytes_) munmap(bytes_, size_);
}

void MappedPack::release() const {
    (void)madvise(bytes_, size_, MADV_DONTNEED); // a private mapping that no one writes: the file has it all
}

namespace {

void check_chunk(const Pack& pack, const std::string& path, std::uint64_t i, std::vector<std::byte>& raw) {
    raw.resize(pack.entry(i).raw_bytes);
    const ChunkId id = chunk_id(pack.header, i);
    const Status s = read_chunk(pack, id, raw);
    if (!s.ok())
        throw Failure(1, path + ": chunk " + std::to_string(i) + " of tile " + std::to_string(id.tile) + ": " +
                             message(s.code));
}

} // namespace

std::uint64_t check_all_chunks(const Pack& pack, const std::string& path) {
    std::vector<std::byte> raw;
    for (std::uint64_t i = 0; i < pack.header.directory_count; ++i) check_chunk(pack, path, i, raw);
    return pack.header.directory_count;
}

std::uint64_t check_all_chunks(const MappedPack& mapped) {
    const Pack& pack = mapped.pack();
    std::vector<std::byte> raw;
    std::uint64_t seen = 0;
    for (std::uint64_t i = 0; i < pack.header.directory_count; ++i) {
        check_chunk(pack, mapped.path(), i, raw);
        seen += pack.entry(i).stored_bytes;
        if (seen < (std::uint64_t{16} << 20)) continue;
        mapped.release();
        seen = 0;
    }
    return pack.header.directory_count;
}

} // namespace fjell::io
