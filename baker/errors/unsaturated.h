// World-space errors of vertices before they are saturated, that is, before their children count (thesis 5.3.2).
#pragma once

#include <cstdint>

#include "baker/heights/region.h"
#include "baker/heights/scales.h"
#include "fjell/pack.h"
#include "shared/diamond_error.h"
#include "shared/page.h"

namespace fjell::baker {

struct UnsaturatedInput {
    const QuantisedHeights& ground; // of the region's own places at least
    Region region;
    const Scales& scales;
    const LeafErrors& leaf;
    ErrorEstimate estimate = ErrorEstimate::max;
    double spacing_m[2] = {1, 1};
};

// Codes of the vertices of all steps above the finest, over the places of even coordinates of the region, borders
// included: out.x == region.first.x / 2, and so on. A vertex on the region's border is measured inside only: the larger
// one of both regions is its error. Estimate 1: the largest vertical difference between the diamond's two triangles and
// any sample under them, exact; O(samples * levels). Estimate 2: at its centre; O(samples). A triangle over a hole's
// rim has at least its longest edge. Returns the largest UnsaturatedError::on_ground.
std::uint8_t unsaturated_errors(const UnsaturatedInput& input, Patch<std::uint8_t>& out);

// One vertex, of any step, the slow way, which handles holes and the rim; unsaturated_errors and the finest step use it
// there. Triangles outside the region do not count.
[[nodiscard]] UnsaturatedError unsaturated_error(const UnsaturatedInput& input, SampleIndex v);

} // namespace fjell::baker
