// Preloaded into one program (LD_PRELOAD), makes its file calls fail as disks, signals and kills do.
//
// FJELL_FAULT="CALLS TEXT WHAT WHEN": of CALLS (names with commas between, or all), those on files whose path contains
// TEXT are counted, and WHAT happens to the one numbered WHEN, from 1 on: `7`, `7+` (from the seventh on) or `%7`
// (every seventh). WHAT is a name of errno; `short` (half of the bytes); `kill` or `interrupt` (SIGKILL or SIGINT
// before the call); `shrink` (the file loses its second half before the call), `rewrite` (every byte of it changes),
// `replace` (FILE.new is renamed over it); `none`. FJELL_FAULT_COUNT=FILE: how many there were, written when the
// program ends. Of streams, `fread` and `fwrite` are seen as they are asked, and move nothing when they fail.
//
// Built without sanitizers and without anything of Fjell's: it is loaded before all else.
#include <atomic>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace {

struct Plan {
    char calls[128] = "", text[256] = "", what[32] = "none";
    long number = 0;
    enum { once, from, every } when = once;
    int error = 0;
};
Plan plan;
std::atomic<long> count{0};
thread_local bool inside = false; // in a call of ours

int errno_named(const char* name) {
    const struct {
        const char* name;
        int number;
    } known[] = {{"EIO", EIO},       {"ENOSPC", ENOSPC},        {"EACCES", EACCES}, {"EINTR", EINTR},
                 {"EINVAL", EINVAL}, {"EROFS", EROFS},          {"EMFILE", EMFILE}, {"EDQUOT", EDQUOT},
                 {"ENOENT", ENOENT}, {"EOPNOTSUPP", EOPNOTSUPP}};
    for (const auto& k : known)
        if (std::strcmp(name, k.name) == 0) return k.number;
    return 0;
}

__attribute__((constructor)) void begin() {
    const char* const text = std::getenv("FJELL_FAULT");
    char when[32] = "0";
    if (!text || std::sscanf(text, "%127s %255s %31s %31s", plan.calls, plan.text, plan.what, when) != 4) return;
    plan.when = when[0] == '%' ? Plan::every : std::strchr(when, '+') ? Plan::from : Plan::once;
    plan.number = std::strtol(when + (when[0] == '%'), nullptr, 10);
    plan.error = errno_named(plan.what);
}

__attribute__((destructor)) void end() {
    const char* const path = std::getenv("FJELL_FAULT_COUNT");
    if (!path) return;
    inside = true;
    if (std::FILE* const file = std::fopen(path, "w")) {
        std::fprintf(file, "%ld\n", count.load());
        std::fclose(file);
    }
}

bool named(const char* call) {
    if (std::strcmp(plan.calls, "all") == 0) return true;
    const std::size_t length = std::strlen(call);
    for (const char* at = plan.calls; (at = std::strstr(at, call)); at += length)
        if ((at == plan.calls || at[-1] == ',') && (at[length] == 0 || at[length] == ',')) return true;
    return false;
}

// What another program does to a file that this one has open.
void change(const char* path) {
    struct stat info {};
    if (stat(path, &info) != 0) return;
    if (std::strcmp(plan.what, "shrink") == 0) (void)!truncate(path, info.st_size / 2);
    if (std::strcmp(plan.what, "replace") == 0) {
        char other[PATH_MAX + 8];
        std::snprintf(other, sizeof other, "%s.new", path);
        (void)std::rename(other, path);
    }
    if (std::strcmp(plan.what, "rewrite") != 0) return;
    const int fd = open(path, O_RDWR);
    unsigned char bytes[4096];
    for (off_t at = 0; at < info.st_size;) {
        const ssize_t n = pread(fd, bytes, sizeof bytes, at);
        if (n <= 0) break;
        for (ssize_t i = 0; i < n; ++i) bytes[i] ^= 0x5a;
        if (pwrite(fd, bytes, static_cast<size_t>(n), at) != n) break;
        at += n;
    }
    close(fd);
}

enum class Do { go_on, fail, shorten };

// What becomes of this call.
Do decide(const char* call, const char* path) {
    if (plan.number == 0 || !path || !named(call) || !std::strstr(path, plan.text)) return Do::go_on;
    const long n = ++count;
    const bool hit = plan.when == Plan::once   ? n == plan.number
                     : plan.when == Plan::from ? n >= plan.number
                                               : n % plan.number == 0;
    if (!hit) return Do::go_on;
    if (std::strcmp(plan.what, "kill") == 0) ::kill(getpid(), SIGKILL);
    if (std::strcmp(plan.what, "interrupt") == 0) ::kill(getpid(), SIGINT);
    if (std::strcmp(plan.what, "short") == 0) return Do::shorten;
    change(path);
    if (plan.error == 0) return Do::go_on;
    errno = plan.error;
    return Do::fail;
}

struct Guard {
    Guard() { inside = true; }
    ~Guard() { inside = false; }
};

Do decide(const char* call, int fd) {
    if (inside) return Do::go_on;
    const Guard guard;
    char link[64], path[PATH_MAX + 1];
    std::snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    const int before = errno;
    const ssize_t n = readlink(link, path, PATH_MAX);
    errno = before;
    if (n <= 0) return Do::go_on;
    path[n] = 0;
    return decide(call, path);
}

Do decide_path(const char* call, const char* path) {
    if (inside) return Do::go_on;
    const Guard guard;
    return decide(call, path);
}

// A name within a folder that is open.
Do decide_at(const char* call, int folder, const char* path) {
    if (inside || folder == AT_FDCWD || path[0] == '/') return decide_path(call, path);
    return decide(call, folder);
}

template <typename Function>
Function next(const char* name) {
    return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

std::size_t half(std::size_t bytes) {
    return bytes > 1 ? bytes / 2 : bytes;
}

mode_t mode_of(int flags, va_list list) {
    return flags & (O_CREAT | O_TMPFILE) ? va_arg(list, mode_t) : 0;
}

} // namespace

extern "C" {

#define OPEN(name)                                                                                                     \
    int name(const char* path, int flags, ...) {                                                                       \
        va_list list;                                                                                                  \
        va_start(list, flags);                                                                                         \
        const mode_t mode = mode_of(flags, list);                                                                      \
        va_end(list);                                                                                                  \
        static const auto real = next<int (*)(const char*, int, ...)>(#name);                                          \
        return decide_path("open", path) == Do::fail ? -1 : real(path, flags, mode);                                   \
    }
#define OPENAT(name)                                                                                                   \
    int name(int folder, const char* path, int flags, ...) {                                                           \
        va_list list;                                                                                                  \
        va_start(list, flags);                                                                                         \
        const mode_t mode = mode_of(flags, list);                                                                      \
        va_end(list);                                                                                                  \
        static const auto real = next<int (*)(int, const char*, int, ...)>(#name);                                     \
        return decide_at("open", folder, path) == Do::fail ? -1 : real(folder, path, flags, mode);                     \
    }
#define TRANSFER(name, call, Bytes)                                                                                    \
    ssize_t name(int fd, Bytes bytes, size_t size, off_t offset) {                                                     \
        static const auto real = next<ssize_t (*)(int, Bytes, size_t, off_t)>(#name);                                  \
        const Do what = decide(call, fd);                                                                              \
        if (what == Do::fail) return -1;                                                                               \
        return real(fd, bytes, what == Do::shorten ? half(size) : size, offset);                                       \
    }
#define SIZE(name, call, attribute)                                                                                    \
    int name(int fd, off_t bytes) attribute {                                                                          \
        static const auto real = next<int (*)(int, off_t)>(#name);                                                     \
        return decide(call, fd) == Do::fail ? -1 : real(fd, bytes);                                                    \
    }
#define RESERVE(name)                                                                                                  \
    int name(int fd, int mode, off_t offset, off_t bytes) {                                                            \
        static const auto real = next<int (*)(int, int, off_t, off_t)>(#name);                                         \
        return decide("fallocate", fd) == Do::fail ? -1 : real(fd, mode, offset, bytes);                               \
    }

void* dlopen(const char* file, int mode) {
    static const auto real = next<void* (*)(const char*, int)>("dlopen");
    return file && decide_path("dlopen", file) == Do::fail ? nullptr : real(file, mode);
}
OPEN(open)
OPEN(open64)
OPENAT(openat)
OPENAT(openat64)
TRANSFER(pwrite, "pwrite", const void*)
TRANSFER(pwrite64, "pwrite", const void*)
TRANSFER(pread, "pread", void*)
TRANSFER(pread64, "pread", void*)
SIZE(ftruncate, "ftruncate", noexcept)
SIZE(ftruncate64, "ftruncate", noexcept)
RESERVE(fallocate)
RESERVE(fallocate64)

ssize_t write(int fd, const void* bytes, size_t size) {
    static const auto real = next<ssize_t (*)(int, const void*, size_t)>("write");
    const Do what = decide("write", fd);
    if (what == Do::fail) return -1;
    return real(fd, bytes, what == Do::shorten ? half(size) : size);
}

ssize_t read(int fd, void* bytes, size_t size) {
    static const auto real = next<ssize_t (*)(int, void*, size_t)>("read");
    const Do what = decide("read", fd);
    if (what == Do::fail) return -1;
    return real(fd, bytes, what == Do::shorten ? half(size) : size);
}

size_t fread(void* bytes, size_t size, size_t n, FILE* file) {
    static const auto real = next<size_t (*)(void*, size_t, size_t, FILE*)>("fread");
    return decide("fread", fileno(file)) == Do::fail ? 0 : real(bytes, size, n, file);
}

size_t fwrite(const void* bytes, size_t size, size_t n, FILE* file) {
    static const auto real = next<size_t (*)(const void*, size_t, size_t, FILE*)>("fwrite");
    return decide("fwrite", fileno(file)) == Do::fail ? 0 : real(bytes, size, n, file);
}

int fsync(int fd) {
    static const auto real = next<int (*)(int)>("fsync");
    return decide("fsync", fd) == Do::fail ? -1 : real(fd);
}

int close(int fd) {
    static const auto real = next<int (*)(int)>("close");
    if (decide("close", fd) != Do::fail) return real(fd);
    const int error = errno;
    (void)real(fd); // closed it is, whatever it says
    errno = error;
    return -1;
}

int rename(const char* from, const char* to) noexcept {
    static const auto real = next<int (*)(const char*, const char*)>("rename");
    return decide_path("rename", to) == Do::fail ? -1 : real(from, to);
}

int mkdir(const char* path, mode_t mode) noexcept {
    static const auto real = next<int (*)(const char*, mode_t)>("mkdir");
    return decide_path("mkdir", path) == Do::fail ? -1 : real(path, mode);
}

int unlink(const char* path) noexcept {
    static const auto real = next<int (*)(const char*)>("unlink");
    return decide_path("unlink", path) == Do::fail ? -1 : real(path);
}

int unlinkat(int folder, const char* path, int flags) noexcept {
    static const auto real = next<int (*)(int, const char*, int)>("unlinkat");
    return decide_at("unlink", folder, path) == Do::fail ? -1 : real(folder, path, flags);
}
}
