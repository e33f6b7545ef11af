// What compilers spell each in their own way. Nothing else of ours names a compiler but fjell/export.h, for public
// headers; tests/unit/compiler_test.cpp holds that. For g++ and clang, and for MSVC by its documentation: that has
// never been tried.
#pragma once

#include <cstdint>

#if !defined(__GNUC__)
#include <atomic>
#include <cstdlib>
#include <intrin.h>
#endif

// --- functions

#if defined(__GNUC__)
#if defined(__OPTIMIZE__)
#define FJELL_ALWAYS_INLINE [[gnu::always_inline]]
#define FJELL_ALWAYS_INLINE_LAMBDA __attribute__((always_inline)) // behind a lambda's parameters
#else // copies that nobody optimises took half of the time to compile them
#define FJELL_ALWAYS_INLINE
#define FJELL_ALWAYS_INLINE_LAMBDA
#endif
#define FJELL_NOINLINE [[gnu::noinline]]
#define FJELL_COLD [[gnu::cold, gnu::noinline]]
#define FJELL_RESTRICT __restrict
#else
#define FJELL_ALWAYS_INLINE [[msvc::forceinline]]
#define FJELL_ALWAYS_INLINE_LAMBDA
#define FJELL_NOINLINE [[msvc::noinline]]
#define FJELL_COLD [[msvc::noinline]]
#define FJELL_RESTRICT __restrict
#endif

// Loops compiled twice, for the baseline and for AVX2; the loader picks one, where it can (ELF). The results are the
// same bit for bit: integers, or floats that round alike in both (no contraction, and AVX2 alone has none to offer).
// For plain loops, which the compiler vectorises. Highway would have it compile the same loops for the same processors,
// but takes two more names a loop and a namespace a target, and its headers 2.6 s of compiling in each of eleven files
// (0.07 s without; g++ 12, -O3, two targets). Where vectors are written by hand they are Highway's.
#if defined(__x86_64__) && defined(__ELF__) && defined(__GNUC__) && !defined(__clang__) &&                             \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define FJELL_CLONES [[gnu::target_clones("avx2", "default")]]
#else
#define FJELL_CLONES
#endif

// --- memory

// Hints: any address will do, even one of nothing.
#if defined(__GNUC__)
#define FJELL_PREFETCH(at) __builtin_prefetch(at)
// For what is written next. g++ takes a function that only prefetches for one without effects, and drops calls of it;
// hence the asm.
#define FJELL_PREFETCH_TO_WRITE(at)                                                                                    \
    do {                                                                                                               \
        const void* const prefetched_at = (at);                                                                        \
        asm volatile("" : : "r"(prefetched_at));                                                                       \
        __builtin_prefetch(prefetched_at, 1);                                                                          \
    } while (false)
#elif defined(_M_ARM64)
#define FJELL_PREFETCH(at) __prefetch(at)
#define FJELL_PREFETCH_TO_WRITE(at) __prefetch(at)
#else
#define FJELL_PREFETCH(at) _mm_prefetch(reinterpret_cast<const char*>(at), _MM_HINT_T0)
#define FJELL_PREFETCH_TO_WRITE(at) _mm_prefetch(reinterpret_cast<const char*>(at), _MM_HINT_T0)
#endif

// Whether 16 aligned bytes are written without tearing eight of them, and all tools believe it: ThreadSanitizer knows
// atomic operations only.
#define FJELL_WRITES_FOURS 0
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__SANITIZE_THREAD__)
#undef FJELL_WRITES_FOURS
#define FJELL_WRITES_FOURS 1
#if defined(__has_feature)
#if __has_feature(thread_sanitizer)
#undef FJELL_WRITES_FOURS
#define FJELL_WRITES_FOURS 0
#endif
#endif
#endif

namespace fjell {

[[nodiscard]] inline std::uint64_t byte_swapped(std::uint64_t value) {
#if defined(__GNUC__)
    return __builtin_bswap64(value);
#else
    return _byteswap_uint64(value);
#endif
}

// std::bit_cast, which older standard libraries lack where the compiler has it.
template <typename To, typename From>
[[nodiscard]] constexpr To bits_as(const From& from) {
    static_assert(sizeof(To) == sizeof(From));
    return __builtin_bit_cast(To, from);
}

// Atomic operations on plain objects in the host's memory: std::atomic_ref, which older standard libraries lack.
#if defined(__GNUC__)
template <typename T>
[[nodiscard]] T load_acquire(const T& from) {
    T value;
    __atomic_load(&from, &value, __ATOMIC_ACQUIRE);
    return value;
}
template <typename T>
[[nodiscard]] T load_relaxed(const T& from) {
    T value;
    __atomic_load(&from, &value, __ATOMIC_RELAXED);
    return value;
}
template <typename T>
void store_release(T& to, T value) {
    __atomic_store(&to, &value, __ATOMIC_RELEASE);
}
inline void set_bits_relaxed(std::uint64_t& to, std::uint64_t bits) {
    __atomic_fetch_or(&to, bits, __ATOMIC_RELAXED);
}
// Words that hold objects of another type, which the compiler must expect.
using AliasedWord [[gnu::may_alias]] = std::uint32_t;
using AliasedPair [[gnu::may_alias]] = std::uint64_t;
[[nodiscard]] inline std::uint32_t load_word_relaxed(const void* from) {
    return __atomic_load_n(static_cast<const AliasedWord*>(from), __ATOMIC_RELAXED);
}
inline void store_word_relaxed(void* to, std::uint32_t word) {
    __atomic_store_n(static_cast<AliasedWord*>(to), word, __ATOMIC_RELAXED);
}
inline void store_pair_relaxed(void* to, std::uint64_t pair) {
    __atomic_store_n(static_cast<AliasedPair*>(to), pair, __ATOMIC_RELAXED);
}
inline void fence_acquire() {
    __atomic_thread_fence(__ATOMIC_ACQUIRE);
}
inline void fence_release() {
    __atomic_thread_fence(__ATOMIC_RELEASE);
}
#else // MSVC makes no use of types to tell addresses apart
template <typename T>
[[nodiscard]] T load_acquire(const T& from) {
    return std::atomic_ref<T>(const_cast<T&>(from)).load(std::memory_order_acquire);
}
template <typename T>
[[nodiscard]] T load_relaxed(const T& from) {
    return std::atomic_ref<T>(const_cast<T&>(from)).load(std::memory_order_relaxed);
}
template <typename T>
void store_release(T& to, T value) {
    std::atomic_ref<T>(to).store(value, std::memory_order_release);
}
inline void set_bits_relaxed(std::uint64_t& to, std::uint64_t bits) {
    std::atomic_ref<std::uint64_t>(to).fetch_or(bits, std::memory_order_relaxed);
}
[[nodiscard]] inline std::uint32_t load_word_relaxed(const void* from) {
    return load_relaxed(*static_cast<const std::uint32_t*>(from));
}
inline void store_word_relaxed(void* to, std::uint32_t word) {
    std::atomic_ref<std::uint32_t>(*static_cast<std::uint32_t*>(to)).store(word, std::memory_order_relaxed);
}
inline void store_pair_relaxed(void* to, std::uint64_t pair) {
    std::atomic_ref<std::uint64_t>(*static_cast<std::uint64_t*>(to)).store(pair, std::memory_order_relaxed);
}
inline void fence_acquire() {
    std::atomic_thread_fence(std::memory_order_acquire);
}
inline void fence_release() {
    std::atomic_thread_fence(std::memory_order_release);
}
#endif

} // namespace fjell
