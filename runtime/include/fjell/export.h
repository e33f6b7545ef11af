// What every public header needs, those for C too: symbols that a shared library shows, and machines that Fjell is not
// for.
//
// FJELL_API_BEGIN and FJELL_API_END stand around the declarations of a public header. All of them are visible in a
// shared library, and nothing else is; a static library shows none, so that a host's own library does not either.
// Compilers without visibility (MSVC) build the static library alone.
#pragma once

#if defined(FJELL_STATIC_BUILD) || !defined(__GNUC__) // the first by our CMake files, while the static library is made
#define FJELL_API_BEGIN
#define FJELL_API_END
#else
#define FJELL_API_BEGIN _Pragma("GCC visibility push(default)")
#define FJELL_API_END _Pragma("GCC visibility pop")
#endif

#if ((defined(__SIZEOF_POINTER__) && __SIZEOF_POINTER__ < 8) || (defined(_WIN32) && !defined(_WIN64))) &&              \
    !defined(__wasm__)
#error "Fjell needs 64 bits, or WebAssembly: compile it and what includes it for a 64-bit processor"
#endif
#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__ // where it is not defined: MSVC, always little
#error "Fjell needs a little-endian processor: packs are read in place, and they are little-endian"
#endif
