// The hash that packs are checked by: XXH3 of 64 bits.
#pragma once

#include <cstddef>
#include <cstdint>

namespace fjell {

[[nodiscard]] std::uint64_t hash_of(const void* bytes, std::size_t count);

} // namespace fjell
