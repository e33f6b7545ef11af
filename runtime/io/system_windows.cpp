// By Windows' own calls: the C library's open() takes paths in a code page, and keeps others from replacing the file.
#define NOMINMAX
#define WIN32_LEAN_AND_MEAN
#include <windows.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <exception>

#include <fcntl.h>
#include <io.h>

#include "io/system.h"

namespace fjell::io::os {

namespace {

constexpr DWORD share_all = FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE;
constexpr std::size_t most_bytes = std::size_t{1} << 30; // of one call, whose count has 32 bits

int last_error() {
    switch (GetLastError()) {
    case ERROR_FILE_NOT_FOUND:
    case ERROR_PATH_NOT_FOUND:
    case ERROR_INVALID_NAME:
    case ERROR_INVALID_DRIVE: return ENOENT;
    case ERROR_ACCESS_DENIED:
    case ERROR_SHARING_VIOLATION:
    case ERROR_LOCK_VIOLATION: return EACCES;
    case ERROR_WRITE_PROTECT: return EROFS;
    case ERROR_TOO_MANY_OPEN_FILES: return EMFILE;
    case ERROR_NOT_ENOUGH_MEMORY:
    case ERROR_OUTOFMEMORY:
    case ERROR_NO_SYSTEM_RESOURCES: return ENOMEM;
    case ERROR_DISK_FULL:
    case ERROR_HANDLE_DISK_FULL: return ENOSPC;
    case ERROR_FILE_EXISTS:
    case ERROR_ALREADY_EXISTS: return EEXIST;
    case ERROR_BROKEN_PIPE:
    case ERROR_NO_DATA: return EPIPE;
    default: return EIO;
    }
}

HANDLE handle_of(int fd) {
    return reinterpret_cast<HANDLE>(_get_osfhandle(fd));
}

// FILE_FLAG_BACKUP_SEMANTICS: folders too.
int open_file(const std::string& path, DWORD access, DWORD share, DWORD how) noexcept try {
    const HANDLE handle = CreateFileW(path_of(path).c_str(), access, share, nullptr, how,
                                      FILE_ATTRIBUTE_NORMAL | FILE_FLAG_BACKUP_SEMANTICS, nullptr);
    if (handle == INVALID_HANDLE_VALUE) {
        errno = last_error();
        return -1;
    }
    const int fd = _open_osfhandle(reinterpret_cast<std::intptr_t>(handle), _O_BINARY | _O_NOINHERIT);
    if (fd < 0) {
        CloseHandle(handle);
        errno = EMFILE;
    }
    return fd;
} catch (const std::exception&) { // no UTF-8, or no memory
    errno = EINVAL;
    return -1;
}

void remove_file(const std::string& path) noexcept try {
    DeleteFileW(path_of(path).c_str());
} catch (const std::exception&) { // no such name
}

// From that offset, wherever the handle is: calls of several threads do not disturb each other.
OVERLAPPED at(std::uint64_t offset) {
    OVERLAPPED place{};
    place.Offset = static_cast<DWORD>(offset & 0xffffffffu);
    place.OffsetHigh = static_cast<DWORD>(offset >> 32);
    return place;
}

} // namespace

const int stale_error = EIDRM;

bool is_full(int error) noexcept {
    return error == ENOSPC || error == EFBIG;
}

bool look(int fd, FileInfo& info) noexcept {
    BY_HANDLE_FILE_INFORMATION found{};
    const DWORD type = GetFileType(handle_of(fd));
    if (type != FILE_TYPE_DISK) {
        info.kind = type == FILE_TYPE_CHAR   ? FileKind::device
                    : type == FILE_TYPE_PIPE ? FileKind::pipe
                                             : FileKind::other;
        return true;
    }
    if (!GetFileInformationByHandle(handle_of(fd), &found)) {
        errno = last_error();
        return false;
    }
    info.kind = (found.dwFileAttributes & FILE_ATTRIBUTE_DIRECTORY) != 0 ? FileKind::folder : FileKind::regular;
    info.bytes = std::uint64_t{found.nFileSizeHigh} << 32 | found.nFileSizeLow;
    info.volume = found.dwVolumeSerialNumber;
    info.number = std::uint64_t{found.nFileIndexHigh} << 32 | found.nFileIndexLow;
    return true;
}

bool look(const std::string& path, FileInfo& info) noexcept {
    const int fd = open_file(path, 0, share_all, OPEN_EXISTING);
    const bool found = fd >= 0 && look(fd, info);
    const int error = errno;
    if (fd >= 0) (void)_close(fd);
    errno = error;
    return found;
}

int open_to_read(const std::string& path) noexcept {
    return open_file(path, GENERIC_READ, share_all, OPEN_EXISTING);
}

int close_file(int fd) noexcept {
    return _close(fd) == 0 ? 0 : errno;
}

int read_at(int fd, std::uint64_t offset, std::span<std::byte> to) noexcept {
    while (!to.empty()) {
        OVERLAPPED place = at(offset);
        DWORD n = 0;
        if (!ReadFile(handle_of(fd), to.data(), static_cast<DWORD>(std::min(to.size(), most_bytes)), &n, &place))
            return last_error(); // ERROR_HANDLE_EOF too
        if (n == 0) return EIO;
        to = to.subspan(n);
        offset += n;
    }
    return 0;
}

int write_at(int fd, std::uint64_t offset, std::span<const std::byte> bytes) noexcept {
    while (!bytes.empty()) {
        OVERLAPPED place = at(offset);
        DWORD n = 0;
        if (!WriteFile(handle_of(fd), bytes.data(), static_cast<DWORD>(std::min(bytes.size(), most_bytes)), &n, &place))
            return last_error();
        if (n == 0) return ENOSPC;
        bytes = bytes.subspan(n);
        offset += n;
    }
    return 0;
}

int open_to_extend(const std::string& path) noexcept {
    const int fd = open_file(path, GENERIC_READ | GENERIC_WRITE, FILE_SHARE_READ, OPEN_EXISTING);
    if (fd < 0 && errno == EACCES && GetLastError() == ERROR_SHARING_VIOLATION) errno = EBUSY;
    return fd;
}

int cut_to(int fd, std::uint64_t bytes) noexcept {
    FILE_END_OF_FILE_INFO end{};
    end.EndOfFile.QuadPart = static_cast<LONGLONG>(bytes);
    return SetFileInformationByHandle(handle_of(fd), FileEndOfFileInfo, &end, sizeof end) ? 0 : last_error();
}

void drop_cache(int) noexcept {}

Folder::~Folder() = default;

int Folder::open(const std::string& path) {
    FileInfo info;
    if (!look(path, info)) return errno;
    if (info.kind != FileKind::folder) return ENOTDIR;
    path_ = text_of(std::filesystem::absolute(path_of(path))) + "/"; // whatever the working folder becomes
    return 0;
}

int Folder::open_to_read(const std::string& file) const noexcept try {
    return os::open_to_read(path_ + file);
} catch (const std::exception&) {
    errno = ENOMEM;
    return -1;
}

// Who writes one has it open, and Windows deletes no file that is open so. What it deletes was left.
int open_beside(const std::string& place, const FileInfo*, std::string& name) {
    constexpr int most_writers = 1000;
    for (int n = 1; n <= most_writers; ++n) {
        name = place + ".fjell-tmp" + (n > 1 ? std::to_string(n) : "");
        remove_file(name);
        const int fd = open_file(name, GENERIC_WRITE, FILE_SHARE_READ, CREATE_NEW);
        if (fd >= 0 || (errno != EEXIST && errno != EACCES)) return fd;
        FileInfo there;
        if (errno == EACCES && !look(name, there)) { // the folder is at fault
            errno = EACCES;
            return -1;
        }
    }
    errno = EBUSY;
    return -1;
}

int open_to_write(const std::string& path, const FileInfo*) noexcept {
    return open_file(path, GENERIC_WRITE, FILE_SHARE_READ, CREATE_ALWAYS);
}

int open_pipe(const std::string& path) {
    return open_file(path, GENERIC_WRITE, share_all, OPEN_EXISTING);
}

void discard(int fd, const std::string& temporary) noexcept {
    (void)_close(fd); // what is open is not removed
    remove_file(temporary);
}

void keep_owner(int, const std::string&) noexcept {} // ReplaceFileW() does

int flush(int fd) noexcept {
    return GetFileType(handle_of(fd)) != FILE_TYPE_DISK || FlushFileBuffers(handle_of(fd)) ? 0 : last_error();
}

int replace(int fd, const std::string& temporary, const std::string& place) {
    if (const int error = close_file(fd); error != 0) return error;
    const std::filesystem::path from = path_of(temporary), to = path_of(place), aside = path_of(temporary + "-old");
    const auto with = [&](const wchar_t* backup) {
        return ReplaceFileW(to.c_str(), from.c_str(), backup, REPLACEFILE_IGNORE_MERGE_ERRORS, nullptr, nullptr) != 0;
    };
    // These keep owner and attributes of what is there; the second, if others have it open and the system takes only
    // names from such a file. The third gives a name to a file that is new.
    if (with(nullptr)) return 0;
    if (with(aside.c_str())) return remove_file(text_of(aside)), 0;
    if (MoveFileExW(from.c_str(), to.c_str(), MOVEFILE_REPLACE_EXISTING | MOVEFILE_WRITE_THROUGH) != 0) return 0;
    const int error = last_error();
    remove_file(temporary);
    return error;
}

void ignore_write_signals() noexcept {}

std::span<const int> stop_signals() noexcept {
    static constexpr std::array signals{SIGINT, SIGTERM, SIGBREAK};
    return signals;
}

void prefer_huge_pages(void*, std::size_t) noexcept {} // they take a right that few accounts have

} // namespace fjell::io::os
