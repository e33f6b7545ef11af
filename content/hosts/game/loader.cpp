#include "loader.h"

#include <cerrno>
#include <span>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace game {

PackOnDisk::~PackOnDisk() {
    if (file_ >= 0) close(file_);
}

bool PackOnDisk::read(std::uint64_t offset, std::span<std::byte> to) const {
    while (!to.empty()) {
        const ssize_t n = pread(file_, to.data(), to.size(), static_cast<off_t>(offset));
        if (n < 0 && errno == EINTR) continue;        // a signal came
        if (n <= 0) return false;                     // the disk failed, or the file has become shorter
        to = to.subspan(static_cast<std::size_t>(n)); // a read may return less than was asked for
        offset += static_cast<std::uint64_t>(n);
    }
    return true;
}

std::string PackOnDisk::open(const char* path) {
    struct stat info {};
    file_ = ::open(path, O_RDONLY | O_CLOEXEC);
    const std::string name(path);
    if (file_ < 0 || fstat(file_, &info) != 0 || !S_ISREG(info.st_mode))
        return name + ": cannot be opened; give a pack that fjell-bake has written";
    const auto file_bytes = static_cast<std::uint64_t>(info.st_size);
    const auto refused = [&](fjell::Status s) { return name + ": " + s.field + ": " + fjell::message(s.code); };
    const std::string failed = name + ": cannot be read; check the disk";

    std::byte header[sizeof(fjell::PackHeader)];
    fjell::PackHeader h;
    if (file_bytes < sizeof header) return name + ": too short for a pack; give one that fjell-bake has written";
    if (!read(0, header)) return failed;
    if (fjell::Status s = fjell::read_header(header, file_bytes, h); !s.ok()) return refused(s);
    directory_.resize(h.directory_count * sizeof(fjell::ChunkEntry));
    if (!read(h.directory_offset, directory_)) return failed;
    if (fjell::Status s = fjell::open_index(header, directory_, file_bytes, pack_); !s.ok()) return refused(s);

    const fjell::ChunkEntry entry = pack_.entry(fjell::chunk_index(h, {fjell::ChunkKind::corners}));
    corners_.resize(entry.stored_bytes);
    return read(entry.offset, corners_) ? "" : failed;
}

void Loader::run() {
    // wakes_ is read before all else: a wake() from there on, the last one too, ends the wait below.
    for (std::uint32_t seen = wakes_; !stop_; seen = wakes_) {
        fjell::StreamRequest request;
        if (fjell::stream_next_request(stream_, request))
            serve(request);
        else
            wakes_.wait(seen);
    }
}

void Loader::serve(const fjell::StreamRequest& request) {
    if (!fjell::stream_still_wanted(stream_, request.ticket)) { // the camera has moved on
        (void)fjell::stream_fail(stream_, request.ticket, true);
        return;
    }
    bytes_.resize(request.bytes);
    if (file_.read(request.offset, bytes_))
        (void)fjell::stream_provide(stream_, request.ticket, bytes_); // damaged bytes are the stream's to report
    else
        (void)fjell::stream_fail(stream_, request.ticket);
}

void Loader::wake() {
    ++wakes_;
    wakes_.notify_one(); // enters the kernel only if the loader sleeps
}

Loader::~Loader() {
    stop_ = true;
    wake();
    thread_.join();
}

} // namespace game
