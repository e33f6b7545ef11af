// World-space errors of vertices by themselves, before their children's count (thesis 5.3.2).
#pragma once

#include <cstdint>

#include "baker/heights/ground.h"
#include "baker/heights/survey.h"
#include "fjell/pack.h"
#include "pack/page.h"

namespace fjell::baker {

struct OwnInput {
    const Ground& ground; // of the region's own places at least
    Region region;
    const Scales& scales;
    const LeafErrors& leaf;
    Estimate estimate = Estimate::max;
    double spacing_m[2] = {1, 1};
};

// Codes of the vertices of all steps above the finest, over the places of even coordinates of the region, borders
// included: out.x == region.first.x / 2, and so on. A vertex on the region's border is measured inside only: the larger
// one of both regions is its error. Estimate 1: the largest vertical difference between the diamond's two triangles and
// any sample under them, exact; O(samples * levels). Estimate 2: at its centre; O(samples). A triangle over a hole's
// rim has at least its longest edge.
void own_errors(const OwnInput& input, Patch<std::uint8_t>& out);

// One vertex, of any step, in the slow way that knows holes and the rim; own_errors and the finest step ask it where
// there is one. Triangles outside the region do not count.
[[nodiscard]] std::uint8_t own_error(const OwnInput& input, Coord v);
// Does its diamond reach beyond the last column or row?
[[nodiscard]] bool straddles_rim(const Tree& tree, Coord v);

} // namespace fjell::baker
