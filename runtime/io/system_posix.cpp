#include <array>
#include <cerrno>
#include <csignal>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "fjell/io/failure.h"
#include "io/file.h"
#include "io/system.h"

// macOS and BSD, where none of this has been tried, lack some of what follows.
#if !defined(O_PATH)
#define O_PATH O_RDONLY
#endif

namespace fjell::io::os {

namespace {

void take(const struct stat& from, FileInfo& info) {
    info.kind = S_ISREG(from.st_mode)    ? FileKind::regular
                : S_ISDIR(from.st_mode)  ? FileKind::folder
                : S_ISFIFO(from.st_mode) ? FileKind::pipe
                : S_ISCHR(from.st_mode)  ? FileKind::device
                                         : FileKind::other;
    info.mode = from.st_mode;
    info.bytes = static_cast<std::uint64_t>(from.st_size);
    info.volume = from.st_dev, info.number = from.st_ino;
}

mode_t mode_of(const FileInfo* replaced) {
    return replaced ? (replaced->mode & 0777) | 0600 : 0666;
}

bool is_at(int fd, const std::string& name) {
    FileInfo held, there;
    return look(fd, held) && look(name, there) && held.same(there);
}

// Who writes a temporary file holds its lock until it has its name or is gone. File systems without locks are taken as
// if nobody else wrote.
bool lock(int fd) {
    return uninterrupted([&] { return flock(fd, LOCK_EX | LOCK_NB); }) == 0 || errno != EWOULDBLOCK;
}

// Removes what a program that was killed has left. False: it is another program's that is at work, or no file.
bool remove_stale(const std::string& name) {
    const int fd = uninterrupted([&] { return open(name.c_str(), O_WRONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK); });
    if (fd < 0) return errno == ENOENT;
    const bool free = lock(fd);
    if (free && is_at(fd, name)) unlink(name.c_str());
    close(fd);
    return free;
}

std::string beside(const std::string& place, int n) {
    return place + ".fjell-tmp" + (n > 1 ? std::to_string(n) : "");
}

} // namespace

const int stale_error = ESTALE;

bool is_full(int error) noexcept {
    return error == ENOSPC || error == EDQUOT || error == EFBIG;
}

bool look(int fd, FileInfo& info) noexcept {
    struct stat found {};
    if (fstat(fd, &found) != 0) return false;
    take(found, info);
    return true;
}

bool look(const std::string& path, FileInfo& info) noexcept {
    struct stat found {};
    if (stat(path.c_str(), &found) != 0) return false;
    take(found, info);
    return true;
}

int open_to_read(const std::string& path) noexcept {
    return uninterrupted([&] { return open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK); });
}

int close_file(int fd) noexcept {
    return close(fd) == 0 ? 0 : errno;
}

int read_at(int fd, std::uint64_t offset, std::span<std::byte> to) noexcept {
    while (!to.empty()) {
        const ssize_t n = pread(fd, to.data(), to.size(), static_cast<off_t>(offset));
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) return errno;
        if (n == 0) return EIO; // shorter than when it was opened
        to = to.subspan(static_cast<std::size_t>(n));
        offset += static_cast<std::uint64_t>(n);
    }
    return 0;
}

int write_at(int fd, std::uint64_t offset, std::span<const std::byte> bytes) noexcept {
    while (!bytes.empty()) {
        ssize_t n = pwrite(fd, bytes.data(), bytes.size(), static_cast<off_t>(offset));
        if (n < 0 && errno == ESPIPE) n = ::write(fd, bytes.data(), bytes.size()); // a device without places
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) return errno;
        if (n == 0) return ENOSPC; // nothing written and no reason given
        bytes = bytes.subspan(static_cast<std::size_t>(n));
        offset += static_cast<std::uint64_t>(n);
    }
    return 0;
}

int open_to_extend(const std::string& path) noexcept {
    const int fd = uninterrupted([&] { return open(path.c_str(), O_RDWR | O_CLOEXEC | O_NONBLOCK); });
    if (fd < 0 || (lock(fd) && is_at(fd, path))) return fd; // it has not been replaced in between
    close(fd);
    errno = EBUSY;
    return -1;
}

int cut_to(int fd, std::uint64_t bytes) noexcept {
    return uninterrupted([&] { return ftruncate(fd, static_cast<off_t>(bytes)); }) == 0 ? 0 : errno;
}

void drop_cache([[maybe_unused]] int fd) noexcept {
#if defined(POSIX_FADV_DONTNEED)
    (void)posix_fadvise(fd, 0, 0, POSIX_FADV_DONTNEED);
#endif
}

Folder::~Folder() {
    if (fd_ >= 0) close(fd_);
}

int Folder::open(const std::string& path) {
    fd_ = uninterrupted([&] { return ::open(path.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC); });
    return fd_ >= 0 ? 0 : errno;
}

int Folder::open_to_read(const std::string& file) const noexcept {
    return uninterrupted([&] { return openat(fd_, file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK); });
}

int open_beside(const std::string& place, const FileInfo* replaced, std::string& name) {
    constexpr int most_tries = 1000, most_writers = 4;
    for (int n = 1, tries = 0; tries < most_tries; ++tries) {
        name = beside(place, n);
        const int fd = uninterrupted(
            [&] { return open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode_of(replaced)); });
        if (fd < 0 && errno != EEXIST) return -1;
        if (fd < 0) {
            n += !remove_stale(name);
        } else if (lock(fd) && is_at(fd, name)) {
            for (int later = n + 1; later <= most_writers; ++later) (void)remove_stale(beside(place, later));
            return fd;
        } else {
            close(fd); // removed for a stale one before it was locked
        }
    }
    errno = EBUSY;
    return -1;
}

int open_to_write(const std::string& path, const FileInfo* replaced) noexcept {
    return uninterrupted(
        [&] { return open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, mode_of(replaced)); });
}

// In time for a reader that is only just starting.
int open_pipe(const std::string& path) {
    constexpr int most_looks = 500; // every 10 ms
    for (int i = 0; i < most_looks; ++i) {
        const int fd = open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NONBLOCK);
        if (fd >= 0) {
            (void)fcntl(fd, F_SETFL, 0); // from here on writing waits for the reader
            return fd;
        }
        if (errno != ENXIO && errno != EINTR) return -1;
        check_interrupt();
        usleep(10'000);
    }
    throw Failure(1, path + ": a pipe that nobody reads; start its reader first");
}

void discard(int fd, const std::string& temporary) noexcept {
    unlink(temporary.c_str()); // before its lock goes
    close(fd);
}

void keep_owner(int fd, const std::string& replaced) noexcept {
    struct stat before {};
    if (stat(replaced.c_str(), &before) != 0) return;
    if (fchown(fd, before.st_uid, before.st_gid) != 0) (void)!fchown(fd, static_cast<uid_t>(-1), before.st_gid);
    (void)fchmod(fd, before.st_mode & 07777); // last: a new owner takes bits away
}

int flush(int fd) noexcept {
    return uninterrupted([&] { return fsync(fd); }) == 0 || errno == EINVAL || errno == EROFS ? 0 : errno;
}

int replace(int fd, const std::string& temporary, const std::string& place) {
    const int lock_holder = fcntl(fd, F_DUPFD_CLOEXEC, 0); // until it has its name
    const bool done = close(fd) == 0 && rename(temporary.c_str(), place.c_str()) == 0;
    const int error = done ? 0 : errno;
    if (!done) unlink(temporary.c_str());
    if (lock_holder >= 0) close(lock_holder);
    return error;
}

void ignore_write_signals() noexcept {
    std::signal(SIGXFSZ, SIG_IGN); // a file-size limit is a write error like any other
    std::signal(SIGPIPE, SIG_IGN);
}

std::span<const int> stop_signals() noexcept {
    static constexpr std::array signals{SIGINT, SIGTERM, SIGHUP};
    return signals;
}

void prefer_huge_pages([[maybe_unused]] void* memory, [[maybe_unused]] std::size_t bytes) noexcept {
#if defined(MADV_HUGEPAGE)
    (void)madvise(memory, bytes, MADV_HUGEPAGE); // a wish; refusal costs speed only
#endif
}

} // namespace fjell::io::os
