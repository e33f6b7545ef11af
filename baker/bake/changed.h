// A bake of a pack with stamps that makes anew only what they reach, and takes the rest out of the pack.
#pragma once

#include <optional>
#include <string>

#include "baker/bake/bake.h"

namespace fjell::baker {

struct ChangedBake {
    std::optional<BakeSummary> done; // none: nothing was written
    std::string why_not;             // a line; empty: the source is no pack with stamps
};

// The pack that bake() makes of this source, byte for byte, if the pack was baked from the heights that it holds. If it
// was baked from finer ones, what stamps do not reach stays as it was, truer than a bake of rounded heights would make
// it; what they reach is made from the pack's heights, on the pack's scales. It costs in proportion to the tiles that
// stamps reach, and a copy of the pack; horizon maps, which look over all of the terrain, are all made anew. It is not
// done where the bytes could be others than a bake's, or cannot be known: other options than the pack was baked with,
// holes, locks, linear order, rules that ask for wetness, stamps that move the bounds which all scales follow from.
// O(tiles reached) of memory in stores of the whole terrain's extents; not resumable. Throws Failure as bake() does.
[[nodiscard]] ChangedBake bake_changed(const HeightSource& source, const BakeOptions& options,
                                       const std::string& out_path);

} // namespace fjell::baker
