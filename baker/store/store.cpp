#include "baker/store/store.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "fjell/io/failure.h"
#include "io/file.h"
#include "shared/compiler.h"

namespace fjell::baker {

namespace {

// The last steps of splitmix64: every bit of the argument moves about half of the result's.
constexpr std::uint64_t scrambled(std::uint64_t x) {
    x += 0x9e3779b97f4a7c15u;
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
    x = (x ^ x >> 27) * 0x94d049bb133111ebu;
    return x ^ x >> 31;
}

constexpr std::size_t block_words = 256;
constexpr std::array<std::uint64_t, block_words> in_block = [] {
    std::array<std::uint64_t, block_words> all{};
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = scrambled(i) << 1;
    return all;
}();

std::uint64_t word_at(const std::byte* bytes) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes, sizeof word);
    return word;
}

// Words of one block from its first on; odd factors, or a word's highest bit would not count.
void add_words(std::uint64_t block, std::size_t first, std::span<const std::byte> bytes, Digest& sum) {
    const std::uint64_t factor = scrambled(~block) | 1;
    Digest part;
    for (std::size_t i = 0; i < bytes.size() / 8; ++i) {
        const std::uint64_t word = word_at(bytes.data() + 8 * i), by = factor + in_block[first + i];
        part.forwards += word * by;
        part.backwards += byte_swapped(word) * by;
    }
    sum += part;
}

} // namespace

Digest digest_of(std::uint64_t offset, std::span<const std::byte> bytes) {
    Digest sum;
    while (!bytes.empty()) {
        const std::uint64_t block = offset / 8 / block_words;
        const std::size_t word = offset / 8 % block_words, within = offset % 8;
        std::size_t taken = std::min(bytes.size(), (block_words - word) * 8) / 8 * 8;
        if (within != 0 || taken == 0) { // a part of a word: the rest of it is another piece's
            std::array<std::byte, 8> padded{};
            taken = std::min(bytes.size(), 8 - within);
            std::copy_n(bytes.begin(), taken, padded.begin() + static_cast<std::ptrdiff_t>(within));
            add_words(block, word, padded, sum);
        } else {
            add_words(block, word, bytes.first(taken), sum);
        }
        bytes = bytes.subspan(taken);
        offset += taken;
    }
    return sum;
}

using io::Failure;

WorkFile::WorkFile(std::string path, std::uint64_t bytes, Room room) : path_(std::move(path)) {
    if (path_.empty()) {
        memory_ = ZeroedMemory(bytes);
        return;
    }
    fd_ = io::uninterrupted([&] { return open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666); });
    if (fd_ < 0) io::disk_failure(path_, "open");
    sum_ = std::make_unique<Sum>();
    const std::uint64_t before = size();
    found_ = before != 0;
    if (bytes != grows && before != bytes) reserve(bytes, room);
}

WorkFile WorkFile::complete(const std::string& path, std::uint64_t bytes) {
    WorkFile file;
    file.path_ = path;
    file.fd_ = io::open_regular_file(path);
    file.sum_ = std::make_unique<Sum>();
    if (const std::uint64_t there = file.size(); there != bytes)
        throw Failure(1, fmt::format("{}: has {} bytes where {} were written; delete it and run the step that makes it "
                                     "again",
                                     path, there, bytes));
    return file;
}

void WorkFile::reserve(std::uint64_t bytes, Room room) {
    // Taken where the file system can.
    const bool taken = bytes == 0 || room == Room::as_written ||
                       io::uninterrupted([&] { return fallocate(fd_, 0, 0, static_cast<off_t>(bytes)); }) == 0;
    if (!taken && errno != EOPNOTSUPP && errno != ENOSYS && errno != EINVAL) io::disk_failure(path_, "reserve");
    if (io::uninterrupted([&] { return ftruncate(fd_, static_cast<off_t>(bytes)); }) != 0)
        io::disk_failure(path_, "reserve");
}

WorkFile::~WorkFile() {
    if (fd_ >= 0) close(fd_);
}

void WorkFile::clear() {
    if (!found_) return;
    const std::uint64_t bytes = size();
    if (io::uninterrupted([&] { return ftruncate(fd_, 0); }) != 0) io::disk_failure(path_, "empty");
    reserve(bytes, Room::reserved);
    found_ = false;
}

std::uint64_t WorkFile::size() const {
    struct stat info {};
    return fd_ >= 0 && fstat(fd_, &info) == 0 ? static_cast<std::uint64_t>(info.st_size) : memory_.size();
}

Digest WorkFile::written() const {
    return sum_ ? Digest{sum_->forwards.load(), sum_->backwards.load()} : Digest{};
}

Digest WorkFile::digest(std::uint64_t bytes) const {
    Digest sum;
    if (fd_ < 0) return sum;
    constexpr std::size_t piece_bytes = std::size_t{1} << 20;
    Buffer<std::byte> piece(piece_bytes);
    bytes = std::min(bytes, size());
    for (std::uint64_t at = 0; at < bytes; at += piece.size()) {
        // Over what was never written; where the file system cannot tell, this says that all of it was.
        if (const off_t data = lseek(fd_, static_cast<off_t>(at), SEEK_DATA); data < 0 && errno == ENXIO)
            break;
        else if (data > static_cast<off_t>(at))
            at = std::min(bytes, static_cast<std::uint64_t>(data) / piece_bytes * piece_bytes);
        if (at == bytes) break;
        piece.resize(std::min<std::uint64_t>(piece_bytes, bytes - at));
        read(at, piece);
        sum += digest_of(at, piece);
    }
    return sum;
}

void WorkFile::read(std::uint64_t offset, std::span<std::byte> to) const {
    if (fd_ >= 0)
        io::read_all(fd_, offset, to, path_);
    else
        std::memcpy(to.data(), memory_.data() + offset, to.size());
}

void WorkFile::write(std::uint64_t offset, std::span<const std::byte> from) {
    if (fd_ < 0) {
        std::memcpy(memory_.data() + offset, from.data(), from.size());
        return;
    }
    io::write_all(fd_, offset, from, path_);
    const Digest part = digest_of(offset, from);
    sum_->forwards += part.forwards;
    sum_->backwards += part.backwards;
}

void WorkFile::remove() {
    if (fd_ >= 0) {
        close(fd_);
        unlink(path_.c_str());
    }
    fd_ = -1;
    memory_ = {};
}

WorkFolder::WorkFolder(const std::string& pack_path) : path_(io::where_written(pack_path) + ".work") {
    std::error_code error;
    if (std::filesystem::is_character_file(pack_path, error)) // beside devices is no place for anything
        path_ = (std::filesystem::temp_directory_path() / fmt::format("fjell-bake-{}.work", getpid())).string();
    do {
        std::filesystem::create_directory(path_, error);
        if (error) {
            errno = error.value();
            if (errno == ENOENT || errno == ENOTDIR)
                throw Failure(
                    1, fmt::format("{}: the output folder does not exist; create it or choose another", pack_path));
            io::disk_failure(path_, "make the folder");
        }
    } while (!take_lock(pack_path));
    for (const auto& entry : std::filesystem::directory_iterator(path_, error))
        keep_ = keep_ || entry.path().filename() != "lock";
}

bool WorkFolder::take_lock(const std::string& pack_path) {
    const std::string name = file("lock");
    std::error_code ignored;
    // Asked twice: a bake that moves in makes its lock first.
    if (!std::filesystem::exists(name, ignored) && !std::filesystem::is_empty(path_, ignored) && !ignored &&
        !std::filesystem::exists(name, ignored))
        throw Failure(1,
                      fmt::format("{}: is not the work folder of a bake, and its files would be lost; move it away, or "
                                  "choose another name for {}",
                                  path_, pack_path));
    lock_ = io::uninterrupted([&] { return open(name.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666); });
    if (lock_ < 0 && errno == ENOENT) return false;
    if (lock_ < 0) {
        const int why = errno;
        rmdir(path_.c_str()); // only when there is nothing in it
        errno = why;
        io::disk_failure(path_, "open the lock in");
    }
    struct stat held {
    }, there{};
    if (io::uninterrupted([&] { return flock(lock_, LOCK_EX | LOCK_NB); }) != 0) {
        close(lock_);
        throw Failure(
            1, fmt::format("{}: another bake is writing this pack; wait for it, or choose another name", pack_path));
    }
    // Whoever had it may have removed it between our two calls: then what is held is a lock on nothing.
    if (fstat(lock_, &held) == 0 && stat(name.c_str(), &there) == 0 && held.st_ino == there.st_ino) return true;
    close(lock_);
    return false;
}

bool WorkFolder::empty() {
    // First the file that says what can be resumed: it must not outlive what it speaks of, wherever this ends.
    unlink(file("checkpoint").c_str());
    std::error_code error, first, failed;
    std::filesystem::directory_iterator at(path_, first);
    while (!first && at != std::filesystem::directory_iterator()) {
        if (at->path().filename() != "lock") std::filesystem::remove_all(at->path(), error);
        at.increment(first);
        if (error) failed = error;
    }
    return !first && !failed;
}

// The lock goes last, by which the folder is known for ours, and the folder only when it is empty: another bake may
// have moved in by then.
WorkFolder::~WorkFolder() {
    if (!keep_ && empty()) {
        unlink(file("lock").c_str());
        rmdir(path_.c_str());
    }
    close(lock_);
}

} // namespace fjell::baker
