// How much a bake keeps outside of its threads: in memory when it fits there, in the work folder otherwise.
#pragma once

#include <cstdint>

#include "tree/order.h"
#include "tree/tree.h"

namespace fjell::baker {

// log2 of texels a side of a tile's maps; 0: none.
struct MapSizes {
    std::uint32_t colour_log2 = 0, normal_log2 = 0, horizon_log2 = 0, control_log2 = 0;
};

// The most bytes that all stores of a bake and the pack's compressed chunks take at once, whatever the heights are:
// the stores by their sizes, chunks as if nothing in them could be compressed. Not the pack itself, which grows when
// the other stores are gone. O(1).
[[nodiscard]] std::uint64_t work_bytes(const Tree& tree, Order order, const MapSizes& maps);

} // namespace fjell::baker
