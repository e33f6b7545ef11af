#include "asserts.h"

#include <atomic>
#include <cstdio>
#include <cstdlib>

namespace fjell {

namespace {

std::atomic<AssertHandler> handler{nullptr};

} // namespace

bool set_assert_handler(AssertHandler host) {
    handler.store(host, std::memory_order_relaxed);
#ifdef FJELL_VALIDATE
    return true;
#else
    return false;
#endif
}

void fail_assert(const char* file, int line, const char* condition) {
    if (const AssertHandler host = handler.load(std::memory_order_relaxed))
        host(condition, file, line);
    else
        (void)std::fprintf(stderr, "%s:%d: must hold: %s\n", file, line, condition);
    std::abort();
}

} // namespace fjell
