#include "io/file.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
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

// The file of a name: by where the name leads and, once it is there, by what all of its names share.
struct FileIdentity {
    explicit FileIdentity(const std::string& the_name) : name(the_name), folder(the_name.ends_with('/')) {
        while (name.size() > 1 && name.ends_with('/')) name.pop_back();
        place = resolved(name);
        struct stat info {};
        exists = stat(name.c_str(), &info) == 0;
        device = info.st_dev, number = info.st_ino;
        counts = !name.empty() && name != "-" && !(exists && S_ISCHR(info.st_mode));
    }
    [[nodiscard]] bool same(const FileIdentity& other) const {
        if (exists && other.exists) return device == other.device && number == other.number;
        return place == other.place;
    }
    [[nodiscard]] bool holds(const FileIdentity& other) const {
        return folder && other.place.size() > place.size() && other.place.starts_with(place + "/");
    }

    std::string name, place;
    bool folder, exists = false, counts = true;
    dev_t device = 0;
    ino_t number = 0;
};

} // namespace

void require(const Status& status, const std::string& path) {
    if (!status.ok()) throw Failure(1, path + ": " + status.field + ": " + message(status.code));
}

void refuse_overwriting(const std::vector<std::string>& outputs, const std::vector<std::string>& inputs) {
    std::vector<FileIdentity> taken;
    for (const std::string& input : inputs)
        if (!input.empty() && input != "-") taken.emplace_back(input);
    const std::size_t input_count = taken.size();
    for (const std::string& output : outputs) {
        const FileIdentity file(output);
        if (!file.counts) continue;
        for (std::size_t i = 0; i < taken.size(); ++i)
            if (taken[i].counts && (file.same(taken[i]) || file.holds(taken[i]) || taken[i].holds(file)))
                throw Failure(2, output + ": would overwrite the " + (i < input_count ? "input " : "output ") +
                                     taken[i].name + "; choose another name");
        taken.push_back(file);
    }
}

std::string where_written(const std::string& path) {
    std::error_code none;
    return std::filesystem::is_symlink(path, none) ? resolved(path) : path;
}

namespace {

bool is_at(int fd, const std::string& name) {
    struct stat held {
    }, there{};
    return fstat(fd, &held) == 0 && stat(name.c_str(), &there) == 0 && held.st_dev == there.st_dev &&
           held.st_ino == there.st_ino;
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

// A new file beside its place, locked: the first name that no other program has. -1: errno says why.
int open_beside(const std::string& place, mode_t mode, std::string& name) {
    constexpr int most_tries = 1000, most_writers = 4;
    for (int n = 1, tries = 0; tries < most_tries; ++tries) {
        name = beside(place, n);
        const int fd = uninterrupted([&] { return open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode); });
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

void keep_owner(int fd, const std::string& replaced) {
    struct stat before {};
    if (stat(replaced.c_str(), &before) != 0) return;
    if (fchown(fd, before.st_uid, before.st_gid) != 0) (void)!fchown(fd, static_cast<uid_t>(-1), before.st_gid);
    (void)fchmod(fd, before.st_mode & 07777); // last: a new owner takes bits away
}

} // namespace

AtomicFile::AtomicFile(const std::string& path, const std::string& temporary)
    : path_(where_written(path)), temporary_(temporary) {
    struct stat before {};
    if (path == "-") throw Failure(2, "-: this output cannot go to standard output; give it a file name");
    const bool replaces = stat(path_.c_str(), &before) == 0;
    const bool pipe = replaces && S_ISFIFO(before.st_mode), device = replaces && S_ISCHR(before.st_mode);
    if (replaces && !S_ISREG(before.st_mode) && !device && (!pipe || !temporary.empty()))
        throw Failure(1, path + ": is a " + (S_ISDIR(before.st_mode) ? "folder" : "pipe or the like") +
                             "; give the output a file name");
    if (pipe || device) temporary_ = path_; // cannot be renamed over
    const mode_t mode = replaces ? (before.st_mode & 0777) | 0600 : 0666;
    if (pipe)
        fd_ = open_pipe(path_);
    else if (temporary_.empty())
        fd_ = open_beside(path_, mode, temporary_);
    else
        fd_ = uninterrupted([&] { return open(temporary_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, mode); });
    if (fd_ >= 0) return;
    if (errno == ENOENT || errno == ENOTDIR)
        throw Failure(1, path + ": the output folder does not exist; create it or choose another");
    disk_failure(path_, "open");
}

AtomicFile::~AtomicFile() {
    if (fd_ < 0) return;
    if (temporary_ != path_) unlink(temporary_.c_str()); // before its lock goes
    close(fd_);
}

void disk_failure(const std::string& path, const char* doing) {
    const int error = errno;
    const char* remedy = error == ENOSPC || error == EDQUOT || error == EFBIG ? "free some space or choose another disk"
                         : error == EACCES || error == EPERM || error == EROFS ? "choose a folder you may write to"
                         : error == EMFILE || error == ENFILE ? "close other programs, or raise the limit (ulimit -n)"
                         : error == EPIPE                     ? "its reader has gone; keep that running"
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
    if (temporary_ != path_) keep_owner(fd_, path_);
    if (uninterrupted([&] { return fsync(fd_); }) != 0 && errno != EINVAL && errno != EROFS)
        disk_failure(path_, "flush");
    const int fd = std::exchange(fd_, -1);
    if (temporary_ == path_) {
        if (close(fd) != 0) disk_failure(path_, "close");
        return;
    }
    const int lock_holder = fcntl(fd, F_DUPFD_CLOEXEC, 0); // until it has its name
    const bool done = close(fd) == 0 && rename(temporary_.c_str(), path_.c_str()) == 0;
    const int error = errno;
    if (!done) unlink(temporary_.c_str());
    if (lock_holder >= 0) close(lock_holder);
    errno = error;
    if (!done) disk_failure(path_, "replace");
}

} // namespace fjell::io
