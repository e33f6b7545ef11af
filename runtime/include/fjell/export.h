// What every public header includes, C headers too: the visibility of symbols, and checks of the processor.
//
// The declarations of a public header are between FJELL_API_BEGIN and FJELL_API_END. A shared library shows these
// symbols and no others. A static library shows none, so a host's own library does not show them either. A compiler
// without visibility (MSVC) can build the static library only.
#pragma once

#if defined(FJELL_STATIC_BUILD) || !defined(__GNUC__) // our CMake files set it for static libraries
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
#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__ // MSVC has none, and is always little
#error "Fjell needs a little-endian processor: packs are read in place, and they are little-endian"
#endif
