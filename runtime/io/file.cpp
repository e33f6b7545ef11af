#include "io/file.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include "fjell/io/failure.h"
#include "io/system.h"

namespace fjell::io {

int open_regular_file(const std::string& path) {
    const int fd = os::open_to_read(path);
    if (fd < 0) {
        if (errno == EMFILE || errno == ENFILE || errno == ENOMEM || errno == EIO) disk_failure(path, "open");
        throw Failure(1, path + ": " + std::strerror(errno) + "; " +
                             (errno == EACCES ? "make it readable" : "give an existing file"));
    }
    os::FileInfo info;
    if (os::look(fd, info) && info.kind == os::FileKind::regular) return fd;
    os::close_file(fd);
    throw Failure(1, path + (info.kind == os::FileKind::folder ? ": is a folder, not a file; give a regular file"
                                                               : ": not a file; give a regular file"));
}

std::vector<std::byte> read_file(const std::string& path) {
    const int fd = open_regular_file(path);
    const struct Closer {
        int fd;
        ~Closer() { os::close_file(fd); }
    } closer{fd};
    os::FileInfo info, after;
    if (!os::look(fd, info)) disk_failure(path, "read");
    std::vector<std::byte> bytes(static_cast<std::size_t>(info.bytes));
    const int error = os::read_at(fd, 0, bytes);
    if (error == 0) return bytes;
    if (os::look(fd, after) && after.bytes < info.bytes)
        throw Failure(1, path + ": shrank while it was read; try again");
    errno = error;
    disk_failure(path, "read");
}

std::string read_text(const std::string& path) {
    const std::vector<std::byte> bytes = read_file(path);
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

namespace {

// What a name leads to: links followed, also to where nothing is yet.
std::string resolved(const std::string& path) {
    std::error_code error;
    std::filesystem::path place = std::filesystem::absolute(os::path_of(path), error);
    for (int links = 0; links < 16 && std::filesystem::is_symlink(place, error); ++links) {
        const std::filesystem::path target = std::filesystem::read_symlink(place, error);
        place = target.is_absolute() ? target : place.parent_path() / target;
    }
    const std::filesystem::path canonical = std::filesystem::weakly_canonical(place, error);
    return os::text_of(error ? place : canonical);
}

// The file of a name: by where the name leads and, once it is there, by what all of its names share.
struct FileIdentity {
    explicit FileIdentity(const std::string& the_name) : name(the_name), folder(the_name.ends_with('/')) {
        while (name.size() > 1 && name.ends_with('/')) name.pop_back();
        place = resolved(name);
        exists = os::look(name, info);
        counts = !name.empty() && name != "-" && !(exists && info.kind == os::FileKind::device);
    }
    [[nodiscard]] bool same(const FileIdentity& other) const {
        if (exists && other.exists) return info.same(other.info);
        return place == other.place;
    }
    [[nodiscard]] bool holds(const FileIdentity& other) const {
        return folder && other.place.size() > place.size() && other.place.starts_with(place + "/");
    }

    std::string name, place;
    bool folder, exists = false, counts = true;
    os::FileInfo info;
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
    return std::filesystem::is_symlink(os::path_of(path), none) ? resolved(path) : path;
}

AtomicFile::AtomicFile(const std::string& path, const std::string& temporary)
    : path_(where_written(path)), temporary_(temporary) {
    os::FileInfo before;
    if (path == "-") throw Failure(2, "-: this output cannot go to standard output; give it a file name");
    const bool replaces = os::look(path_, before);
    const bool pipe = replaces && before.kind == os::FileKind::pipe,
               device = replaces && before.kind == os::FileKind::device;
    if (replaces && before.kind != os::FileKind::regular && !device && (!pipe || !temporary.empty()))
        throw Failure(1, path + ": is a " + (before.kind == os::FileKind::folder ? "folder" : "pipe or the like") +
                             "; give the output a file name");
    if (pipe || device) temporary_ = path_; // cannot be renamed over
    const os::FileInfo* const replaced = replaces ? &before : nullptr;
    if (pipe)
        fd_ = os::open_pipe(path_);
    else if (temporary_.empty())
        fd_ = os::open_beside(path_, replaced, temporary_);
    else
        fd_ = os::open_to_write(temporary_, replaced);
    if (fd_ >= 0) return;
    if (errno == ENOENT || errno == ENOTDIR)
        throw Failure(1, path + ": the output folder does not exist; create it or choose another");
    disk_failure(path_, "open");
}

AtomicFile::~AtomicFile() {
    if (fd_ < 0) return;
    if (temporary_ != path_)
        os::discard(fd_, temporary_);
    else
        os::close_file(fd_);
}

void disk_failure(const std::string& path, const char* doing) {
    const int error = errno;
    const char* remedy = os::is_full(error) ? "free some space or choose another disk"
                         : error == EACCES || error == EPERM || error == EROFS ? "choose a folder you may write to"
                         : error == EMFILE || error == ENFILE ? "close other programs, or raise the limit (ulimit -n)"
                         : error == EPIPE                     ? "its reader has gone; keep that running"
                                                              : "check the disk";
    throw Failure(3, path + ": cannot " + doing + ": " + std::strerror(error) + "; " + remedy);
}

void write_all(int fd, std::uint64_t offset, std::span<const std::byte> bytes, const std::string& path) {
    if (const int error = os::write_at(fd, offset, bytes); error != 0) errno = error, disk_failure(path, "write");
}

void read_all(int fd, std::uint64_t offset, std::span<std::byte> bytes, const std::string& path) {
    if (const int error = os::read_at(fd, offset, bytes); error != 0) errno = error, disk_failure(path, "read");
}

void AtomicFile::write(std::span<const std::byte> bytes) {
    write_at(size_, bytes);
    size_ += bytes.size();
}

void AtomicFile::write_at(std::uint64_t offset, std::span<const std::byte> bytes) {
    write_all(fd_, offset, bytes, path_);
}

void AtomicFile::commit() {
    if (temporary_ != path_) os::keep_owner(fd_, path_);
    const auto check = [&](int error, const char* doing) {
        if (error != 0) errno = error, disk_failure(path_, doing);
    };
    check(os::flush(fd_), "flush");
    const int fd = std::exchange(fd_, -1);
    if (temporary_ == path_)
        check(os::close_file(fd), "close");
    else
        check(os::replace(fd, temporary_, path_), "replace");
}

} // namespace fjell::io
