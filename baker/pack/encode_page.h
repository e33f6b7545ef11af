// A page from heights and codes to bytes; runtime/src/shared/page.cpp undoes it (docs/pack-format.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "baker/errors/step.h"
#include "shared/order.h"
#include "shared/page.h"

namespace fjell::baker {

// A page of page_squares squares a side, from square (i, j) of the region on. Errors are left out when a reader can
// tell them from the heights.
struct StepPageInput {
    const VertexPlanes<std::int32_t>& steps;
    const VertexPlanes<std::uint8_t>& error;
    const VertexPlanes<std::uint8_t>* voids = nullptr; // none here
    const Radii& radii;
    std::int32_t i = 0, j = 0;
    const LeafErrors* leaf = nullptr; // for the finest step
    const ErrorScale& scale;
    const PackHeader& header; // what the bound is counted on: height_steps, tile_log2 and level_radius_m
    int z = 0;                // log2 of the step
};
struct EncodedPage {
    std::vector<std::byte> bytes;
    std::size_t low_end; // bytes[0, low_end): the head, and the low bytes of heights
    PageBound bound;     // over all vertices that the page stores, the closed borders included
};
[[nodiscard]] EncodedPage encode_step_page(const StepPageInput& input);

// Any other page: of several steps, or of linear order. vertex(c): of tile-local coordinates.
struct MixedPageVertex {
    std::int32_t steps = 0;
    std::uint8_t error = 0, radius = 0; // radius with void_bit
};
[[nodiscard]] EncodedPage encode_mixed_page(const PackHeader& header, std::uint32_t page,
                                            const std::function<MixedPageVertex(SampleIndex)>& vertex);

} // namespace fjell::baker
