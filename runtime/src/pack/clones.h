// Loops compiled twice, for the baseline and for AVX2; the loader picks one. The results are the same bit for bit:
// integers, or floats that round alike in both (no contraction, and AVX2 alone has none to offer).
#pragma once

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) &&               \
    !defined(__SANITIZE_THREAD__)
#define FJELL_CLONES [[gnu::target_clones("avx2", "default")]]
#else
#define FJELL_CLONES
#endif
