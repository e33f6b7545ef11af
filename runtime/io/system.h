// What fjell::io asks of the operating system. system_posix.cpp or system_windows.cpp answers; no other source of
// fjell::io includes a system's header.
//
// Paths are UTF-8, with slashes, on every system; descriptors are the C library's. An error is 0, or what errno would
// say; a descriptor of -1 has set errno.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace fjell::io::os {

// The standard library's narrow paths are UTF-8 on POSIX only.
[[nodiscard]] inline std::filesystem::path path_of(const std::string& utf8) {
    return {std::u8string(utf8.begin(), utf8.end())};
}
[[nodiscard]] inline std::string text_of(const std::filesystem::path& path) {
    const std::u8string text = path.generic_u8string();
    return {text.begin(), text.end()};
}

enum class FileKind : std::uint8_t { regular, folder, pipe, device, other };
struct FileInfo {
    FileKind kind = FileKind::other;
    std::uint32_t mode = 0; // permissions, where the system has bits for them
    std::uint64_t bytes = 0;
    std::uint64_t volume = 0, number = 0; // together: the file, by whatever name
    [[nodiscard]] bool same(const FileInfo& other) const { return volume == other.volume && number == other.number; }
};
// False: errno says why.
[[nodiscard]] bool look(int fd, FileInfo& info) noexcept;
[[nodiscard]] bool look(const std::string& path, FileInfo& info) noexcept;

// Also opens a folder, or a pipe without a writer, so that look() can say what it is. Never waits. The file may be
// replaced and deleted while it is open.
[[nodiscard]] int open_to_read(const std::string& path) noexcept;
int close_file(int fd) noexcept; // an error
// All of the bytes, however many calls it takes, from several threads at once. EIO: the file ends before.
[[nodiscard]] int read_at(int fd, std::uint64_t offset, std::span<std::byte> to) noexcept;
[[nodiscard]] int write_at(int fd, std::uint64_t offset, std::span<const std::byte> bytes) noexcept;
// An existing file, to be read and written, alone: EBUSY where another program has it so.
[[nodiscard]] int open_to_extend(const std::string& path) noexcept;
[[nodiscard]] int cut_to(int fd, std::uint64_t bytes) noexcept; // its length; an error
void drop_cache(int fd) noexcept;                               // what the system keeps of the file, if it listens

extern const int stale_error; // for a file that is another than it was: ESTALE, where there is that
[[nodiscard]] bool is_full(int error) noexcept;

// Files are opened in it by name. On POSIX it may be moved meanwhile; Windows moves no folder whose files are open.
class Folder {
public:
    Folder() = default;
    ~Folder();
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    [[nodiscard]] int open(const std::string& path); // an error
    [[nodiscard]] int open_to_read(const std::string& file) const noexcept;

private:
    [[maybe_unused]] int fd_ = -1; // on POSIX
    std::string path_;             // on Windows
};

// A new file beside its place, with the permissions of what it replaces (null: of a new file). name: by which it is
// found. What a program that was killed has left there is removed; what one that runs is writing is not.
[[nodiscard]] int open_beside(const std::string& place, const FileInfo* replaced, std::string& name);
[[nodiscard]] int open_to_write(const std::string& path, const FileInfo* replaced) noexcept; // emptied, or new
[[nodiscard]] int open_pipe(const std::string& path);                                        // waits for its reader
void discard(int fd, const std::string& temporary) noexcept;                                 // closes and removes it
void keep_owner(int fd, const std::string& replaced) noexcept; // and mode, as far as the system allows
[[nodiscard]] int flush(int fd) noexcept;                      // to the disk; an error
// Closes it and gives it the name of its place, whatever was there. An error: it is removed. Windows closes it first:
// another program that begins to write the same output in between takes it for one that was left.
[[nodiscard]] int replace(int fd, const std::string& temporary, const std::string& place);

void ignore_write_signals() noexcept;                       // a write that fails returns an error instead
[[nodiscard]] std::span<const int> stop_signals() noexcept; // by which people and systems end programs
void prefer_huge_pages(void* memory, std::size_t bytes) noexcept;

} // namespace fjell::io::os
