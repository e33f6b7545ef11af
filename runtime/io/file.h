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

// Throws Failure (2) when two of the outputs, or an output and an input, are the same file. Empty names, "-" and
// devices do not count.
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

// A file that exists under its name only when it is complete. Throws Failure (exit code 1: the folder is missing or the
// name is a folder or a pipe; 3: no space, no permission, a write error).
class AtomicFile {
public:
    // temporary: where it is until then, on the same file system; empty: beside its place.
    explicit AtomicFile(const std::string& path, const std::string& temporary = {});
    ~AtomicFile(); // removes what was not committed
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    void write(std::span<const std::byte> bytes);
    void write_at(std::uint64_t offset, std::span<const std::byte> bytes);
    void commit(); // flushes to the disk and renames
    [[nodiscard]] std::uint64_t size() const { return size_; }

private:
    std::string path_, temporary_;
    int fd_ = -1;
    std::uint64_t size_ = 0;
};

} // namespace fjell::io
FJELL_API_END
