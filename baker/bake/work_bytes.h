// How much a bake keeps outside of its threads: in memory when it fits there, in the work folder otherwise.
#pragma once

#include <cstdint>

#include "tree/order.h"
#include "tree/tree.h"

namespace fjell::baker {

// The most bytes that all stores of a bake and the pack's compressed chunks take at once, whatever the heights are:
// the stores by their sizes, chunks as if nothing in them could be compressed. Not the pack itself, which grows when
// the other stores are gone. colour_log2, normal_log2: log2 of texels a side of a tile's maps; 0: none. O(1).
[[nodiscard]] std::uint64_t work_bytes(const Tree& tree, Order order, std::uint32_t colour_log2,
                                       std::uint32_t normal_log2);

} // namespace fjell::baker
