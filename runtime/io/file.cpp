#include "io/file.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "fjell/io/failure.h"

namespace fjell::io {

int open_regular_file(const std::string& path) {
    const int fd = uninterrupted([&] {
        return open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK); // a pipe without a writer must not hang
    });
    if (fd < 0) {
        if (errno == EMFILE || errno == ENFILE || errno == ENOMEM || errno == EIO) disk_failure(path, "open");
        throw Failure(1, path + ": " + std::strerror(errno) + "; " +
                             (errno == EACCES ? "make it readable" : "give an existing file"));
    }
    struct stat info {};
    if (fstat(fd, &info) == 0 && S_ISREG(info.st_mode)) return fd;
    close(fd);
    throw Failure(1, path + (S_ISDIR(info.st_mode) ? ": is a folder, not a file; give a regular file"
                                                   : ": not a file; give a regular file"));
}

std::vector<std::byte> read_file(const std::string& path) {
    const int fd = open_regular_file(path);
    const struct Closer {
        int fd;
        ~Closer() { close(fd); }
    } closer{fd};
    struct stat info {};
    if (fstat(fd, &info) != 0) disk_failure(path, "read");
    std::vector<std::byte> bytes(static_cast<std::size_t>(info.st_size));
    for (std::size_t at = 0; at < bytes.size();) {
        const ssize_t n = read(fd, bytes.data() + at, bytes.size() - at);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) disk_failure(path, "read");
        if (n == 0) throw Failure(1, path + ": shrank while it was read; try again");
        at += static_cast<std::size_t>(n);
    }
    return bytes;
}

std::string read_text(const std::string& path) {
    const std::vector<std::byte> bytes = read_file(path);
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

namespace {

// What a name leads to: links followed, also to where nothing is yet.
std::string resolved(const std::string& path) {
    std::error_code error;
    std::filesystem::path place = std::filesystem::absolute(path, error);
    for (int links = 0; links < 16 && std::filesystem::is_symlink(place, error); ++links) {
        const std::filesystem::path target = std::filesystem::read_symlink(place, error);
        place = target.is_absolute() ? target : place.parent_path() / target;
    }
    const std::filesystem::path canonical = std::filesystem::weakly_canonical(place, error);
    return error ? place.string() : canonical.string();
}

bool counts(const std::string& path) {
    std::error_code none;
    return !path.empty() && path != "-" && !std::filesystem::is_character_file(path, none);
}

} // namespace

void require(const Status& status, const std::string& path) {
    if (!status.ok()) throw Failure(1, path + ": " + status.field + ": " + message(status.code));
}

void refuse_overwriting(const std::vector<std::string>& outputs, const std::vector<std::string>& inputs) {
    std::vector<std::string> taken;
    for (const std::string& input : inputs)
        if (counts(input)) taken.push_back(resolved(input));
    for (const std::string& output : outputs) {
        if (!counts(output)) continue;
        const std::string place = resolved(output);
        if (std::find(taken.begin(), taken.end(), place) != taken.end())
            throw Failure(2, output + ": would overwrite an input or another output; choose another name");
        taken.push_back(place);
    }
}

std::string where_written(const std::string& path) {
    std::error_code none;
    return std::filesystem::is_symlink(path, none) ? resolved(path) : path;
}

AtomicFile::AtomicFile(const std::string& path, const std::string& temporary)
    : path_(where_written(path)),
      temporary_(temporary.empty() ? path_ + "." + std::to_string(getpid()) + ".tmp" : temporary) {
    struct stat info {};
    if (stat(path_.c_str(), &info) == 0 && !S_ISREG(info.st_mode)) {
        if (!S_ISCHR(info.st_mode))
            throw Failure(1, path + ": is a " + (S_ISDIR(info.st_mode) ? "folder" : "pipe or the like") +
                                 "; give the output a file name");
        temporary_ = path_; // a device such as /dev/full cannot be renamed over: it is written in place
    }
    fd_ = uninterrupted([&] { return open(temporary_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666); });
    if (fd_ >= 0) return;
    if (errno == ENOENT || errno == ENOTDIR)
        throw Failure(1, path + ": the output folder does not exist; create it or choose another");
    disk_failure(path_, "open");
}

AtomicFile::~AtomicFile() {
    if (fd_ < 0) return;
    close(fd_);
    if (temporary_ != path_) unlink(temporary_.c_str());
}

void disk_failure(const std::string& path, const char* doing) {
    const int error = errno;
    const char* remedy = error == ENOSPC || error == EDQUOT || error == EFBIG ? "free some space or choose another disk"
                         : error == EACCES || error == EPERM || error == EROFS ? "choose a folder you may write to"
                         : error == EMFILE || error == ENFILE ? "close other programs, or raise the limit (ulimit -n)"
                                                              : "check the disk";
    throw Failure(3, path + ": cannot " + doing + ": " + std::strerror(error) + "; " + remedy);
}

void write_all(int fd, std::uint64_t offset, std::span<const std::byte> bytes, const std::string& path) {
    while (!bytes.empty()) {
        ssize_t n = pwrite(fd, bytes.data(), bytes.size(), static_cast<off_t>(offset));
        if (n < 0 && errno == ESPIPE) n = ::write(fd, bytes.data(), bytes.size()); // a device without places
        if (n < 0 && errno == EINTR) continue;
        if (n == 0) errno = ENOSPC; // nothing written and no reason given
        if (n <= 0) disk_failure(path, "write");
        bytes = bytes.subspan(static_cast<std::size_t>(n));
        offset += static_cast<std::uint64_t>(n);
    }
}

void read_all(int fd, std::uint64_t offset, std::span<std::byte> bytes, const std::string& path) {
    while (!bytes.empty()) {
        const ssize_t n = pread(fd, bytes.data(), bytes.size(), static_cast<off_t>(offset));
        if (n < 0 && errno == EINTR) continue;
        if (n == 0) errno = EIO; // shorter than it was made
        if (n <= 0) disk_failure(path, "read");
        bytes = bytes.subspan(static_cast<std::size_t>(n));
        offset += static_cast<std::uint64_t>(n);
    }
}

void AtomicFile::write(std::span<const std::byte> bytes) {
    write_at(size_, bytes);
    size_ += bytes.size();
}

void AtomicFile::write_at(std::uint64_t offset, std::span<const std::byte> bytes) {
    write_all(fd_, offset, bytes, path_);
}

void AtomicFile::commit() {
    if (uninterrupted([&] { return fsync(fd_); }) != 0 && errno != EINVAL && errno != EROFS)
        disk_failure(path_, "flush");
    const int fd = std::exchange(fd_, -1);
    const bool closed = close(fd) == 0;
    if (temporary_ == path_) {
        if (!closed) disk_failure(path_, "close");
        return;
    }
    if (closed && rename(temporary_.c_str(), path_.c_str()) == 0) return;
    const int error = errno;
    unlink(temporary_.c_str());
    errno = error;
    disk_failure(path_, "rename");
}

} // namespace fjell::io
