// Counts this thread's allocations. malloc itself is interposed, so that neither operator new nor a library can hide.
// For one source file of a program.
#pragma once

#include <cstddef>

namespace fjell::test {
inline thread_local bool counting = false;
inline thread_local long allocations = 0; // made while counting
} // namespace fjell::test

#if defined(FJELL_SANITIZED)
inline constexpr bool interposed = false; // a sanitizer has malloc to itself
#else
inline constexpr bool interposed = true;
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* malloc(std::size_t bytes) {
    if (fjell::test::counting) ++fjell::test::allocations;
    return __libc_malloc(bytes);
}
void* calloc(std::size_t count, std::size_t bytes) {
    if (fjell::test::counting) ++fjell::test::allocations;
    return __libc_calloc(count, bytes);
}
void* realloc(void* block, std::size_t bytes) {
    if (fjell::test::counting) ++fjell::test::allocations;
    return __libc_realloc(block, bytes);
}
}
#endif
