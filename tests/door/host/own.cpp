// Functions of a host that happen to have the names of xxHash's and zstd's. Whoever else calls them is wrong.
#include <cstddef>
#include <cstdio>
#include <cstdlib>

namespace {
std::size_t called(const char* name) {
    std::printf("the host's %s was called\n", name);
    std::exit(1);
}
} // namespace

extern "C" {
unsigned long long XXH3_64bits(const void*, std::size_t) {
    return called("XXH3_64bits");
}
unsigned long long XXH64(const void*, std::size_t, unsigned long long) {
    return called("XXH64");
}
#ifdef OWN_ZSTD
std::size_t ZSTD_decompress(void*, std::size_t, const void*, std::size_t) {
    return called("ZSTD_decompress");
}
std::size_t ZSTD_decompressDCtx(void*, void*, std::size_t, const void*, std::size_t) {
    return called("ZSTD_decompressDCtx");
}
unsigned ZSTD_isError(std::size_t) {
    return static_cast<unsigned>(called("ZSTD_isError"));
}
#endif
}
