// Packs that were baked apart made one pack set: they stay as they are and get an index, if they may be one.
#pragma once

#include <string>

#include "baker/pack/set_borders.h"
#include "baker/pack/write_set.h"

namespace fjell::baker {

struct JoinSummary {
    SetSummary set;
    BorderReport borders;
};

// Writes set.json for all packs (*.fjell) of the folder. Where each lies follows from its origin, so that packs side by
// side must be cut at whole tiles and share a column or a row of samples. Whatever else the folder's set.json said is
// gone; it is replaced whole, or not at all. Throws Failure: 1 for packs that overlap, lie off the first one's tiles,
// differ where they meet (set_borders.h), or cannot be of one set (io::SetParts); 3 for the disk.
[[nodiscard]] JoinSummary join_packs(const std::string& folder);

} // namespace fjell::baker
