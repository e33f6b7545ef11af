// Files for tools: read whole, written beside their place and renamed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace fjell::host {

// Throws Failure: 1 when there is no such file or it is not one, 3 when the disk fails.
[[nodiscard]] std::vector<std::byte> read_file(const std::string& path);
[[nodiscard]] std::string read_text(const std::string& path);

// Throws Failure (2) when two of the outputs, or an output and an input, are the same file. Empty names, "-" and
// devices do not count.
void refuse_overwriting(const std::vector<std::string>& outputs, const std::vector<std::string>& inputs);

// A file that exists under its name only when it is complete. Throws Failure (exit code 1: the folder is missing or the
// name is a folder or a pipe; 3: no space, no permission, a write error).
class AtomicFile {
public:
    explicit AtomicFile(const std::string& path);
    ~AtomicFile(); // removes what was not committed
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    void write(std::span<const std::byte> bytes);
    void write_at(std::uint64_t offset, std::span<const std::byte> bytes);
    void commit(); // flushes to the disk and renames
    [[nodiscard]] std::uint64_t size() const { return size_; }

private:
    [[noreturn]] void fail(const char* doing) const;
    std::string path_, temporary_;
    int fd_ = -1;
    std::uint64_t size_ = 0;
};

} // namespace fjell::host
