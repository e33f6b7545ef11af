#include "shared/hash.h"

// All of xxHash is a part of this file, under names that no linker sees: a host with functions of these names, of
// another version or its own, would else be called in their place.
#define XXH_INLINE_ALL
#include <xxhash.h>

namespace fjell {

std::uint64_t hash_of(const void* bytes, std::size_t count) {
    return XXH3_64bits(bytes, count);
}

} // namespace fjell
