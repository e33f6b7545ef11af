// Files for tools: read whole, written beside their place and renamed.
#pragma once

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "fjell/export.h"
#include "fjell/status.h"

FJELL_API_BEGIN
namespace fjell::io {

// A descriptor for reading, the caller's to close. Throws Failure: 1 when there is no such file, it may not be read or
// it is a folder or a pipe; 3 when the machine has no descriptor left.
[[nodiscard]] int open_regular_file(const std::string& path);
// Throws Failure: 1 as open_regular_file() does, 3 when the disk fails.
[[nodiscard]] std::vector<std::byte> read_file(const std::string& path);
[[nodiscard]] std::string read_text(const std::string& path);

// Throws Failure (1) that names the file and the field, unless the status is ok.
void require(const Status& status, const std::string& path);

// Throws Failure (2) when two of the outputs, or an output and an input, are the same file, by whatever names and
// links. An output whose name ends in a slash is a folder that is taken over with all that is in it. Empty names, "-"
// and devices do not count. Call it before anything is opened for writing.
void refuse_overwriting(const std::vector<std::string>& outputs, const std::vector<std::string>& inputs);

// Throws Failure (3) that says what errno means and what to do about it. doing: "write", "read", ...
[[noreturn]] void disk_failure(const std::string& path, const char* doing);
// Calls that a signal has cut short are made again.
template <typename Call>
auto uninterrupted(const Call& call) {
    auto result = call();
    while (result < 0 && errno == EINTR) result = call();
    return result;
}
// All of the bytes, however many calls it takes. Throw Failure (3); path: for the message.
void write_all(int fd, std::uint64_t offset, std::span<const std::byte> bytes, const std::string& path);
void read_all(int fd, std::uint64_t offset, std::span<std::byte> bytes, const std::string& path);

// Where an output of that name comes to lie: a link's target, also where nothing is yet.
[[nodiscard]] std::string where_written(const std::string& path);

// A file that is replaced whole: until commit() its name leads to what was there before, whose mode and owner it keeps
// (the owner as far as the system allows). A link is followed to its target. Devices and pipes are written in place.
// What it is until then lies beside it as NAME.fjell-tmp; a program that is killed leaves that, and the next one that
// writes the same output removes it. Two programs at once do not disturb each other: the later commit() stays.
// Throws Failure (exit code 1: the folder is missing, the name is a folder, nobody reads the pipe; 3: no space, no
// permission, a write error).
class AtomicFile {
public:
    // temporary: where it is until then, on the same file system, in a folder of the caller's own; empty: beside its
    // place. Only a file with places can have one of its own: then a pipe is refused.
    explicit AtomicFile(const std::string& path, const std::string& temporary = {});
    ~AtomicFile(); // removes what was not committed
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    void write(std::span<const std::byte> bytes);
    void write_at(std::uint64_t offset, std::span<const std::byte> bytes);
    void commit(); // flushes to the disk and renames
    [[nodiscard]] std::uint64_t size() const { return size_; }

private:
    std::string path_, temporary_; // the same: written in place
    int fd_ = -1;
    std::uint64_t size_ = 0;
};

} // namespace fjell::io
FJELL_API_END
