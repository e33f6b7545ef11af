// What every public header needs: symbols that a shared library shows, and what a host must not compile with.
//
// FJELL_API_BEGIN and FJELL_API_END stand around the declarations of a public header. All of them are visible in a
// shared library, and nothing else is; a static library shows none, so that a host's own library does not either.
#pragma once

#if defined(FJELL_STATIC_BUILD) // by our CMake files, while the static library itself is compiled
#define FJELL_API_BEGIN
#define FJELL_API_END
#else
#define FJELL_API_BEGIN _Pragma("GCC visibility push(default)")
#define FJELL_API_END _Pragma("GCC visibility pop")
#endif

static_assert(sizeof(void*) >= 8, "Fjell needs 64 bits: sizes such as cut_bytes() would wrap in less");
