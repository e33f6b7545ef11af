#include "fjell/io/pack_file.h"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "fjell/io/failure.h"
#include "io/file.h"

namespace fjell::io {

PackFile::PackFile(const std::string& path) : path_(path) {
    fd_ = uninterrupted([&] {
        return open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK); // a pipe without a writer must not hang
    });
    if (fd_ < 0) throw Failure(1, path + ": " + std::strerror(errno) + "; give an existing file");
    try {
        open_pack_file();
    } catch (...) {
        close(fd_);
        throw;
    }
}

PackFile::~PackFile() {
    close(fd_);
}

void PackFile::open_pack_file() {
    struct stat info {};
    if (fstat(fd_, &info) != 0 || !S_ISREG(info.st_mode)) throw Failure(1, path_ + ": not a file; give a regular file");
    const auto file_bytes = static_cast<std::uint64_t>(info.st_size);
    std::byte head[sizeof(PackHeader)];
    const std::span header = std::span(head).first(std::min<std::uint64_t>(sizeof head, file_bytes));
    read_or_throw(0, header);
    PackHeader h;
    require(read_header(header, file_bytes, h), path_);
    directory_.resize(h.directory_count * sizeof(ChunkEntry)); // no more than the file has: read_header has seen to it
    read_or_throw(h.directory_offset, directory_);
    require(open_index(header, directory_, file_bytes, pack_), path_);
    corners_ = stored({ChunkKind::corners, 0, 0});
    crs_.resize(h.crs_bytes);
    if (crs_.empty()) return;
    const ChunkId crs{ChunkKind::crs, 0, 0};
    const Status s =
        decode_chunk(pack_.entry(chunk_index(h, crs)), stored(crs), std::as_writable_bytes(std::span(crs_)));
    if (!s.ok()) require({s.code, "CRS"}, path_);
}

std::vector<std::byte> PackFile::stored(ChunkId id) const {
    const ChunkEntry entry = pack_.entry(chunk_index(pack_.header, id));
    std::vector<std::byte> bytes(entry.stored_bytes);
    read_or_throw(entry.offset, bytes);
    return bytes;
}

void PackFile::read_or_throw(std::uint64_t offset, std::span<std::byte> to) const {
    errno = read(offset, to);
    if (errno != 0) disk_failure(path_, "read");
}

int PackFile::read(std::uint64_t offset, std::span<std::byte> to) const noexcept {
    while (!to.empty()) {
        const ssize_t n = pread(fd_, to.data(), to.size(), static_cast<off_t>(offset));
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) return errno;
        if (n == 0) return EIO; // shorter than when it was opened
        to = to.subspan(static_cast<std::size_t>(n));
        offset += static_cast<std::uint64_t>(n);
    }
    return 0;
}

void PackFile::drop_cache() const noexcept {
    (void)posix_fadvise(fd_, 0, 0, POSIX_FADV_DONTNEED);
}

} // namespace fjell::io
