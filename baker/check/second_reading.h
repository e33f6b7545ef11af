// A second reading of a height field, by GDAL alone, so that what both halves of `verify --against` read alike is not
// taken for right.
#pragma once

#include <string>

#include "baker/bake/recipe.h"
#include "baker/read/source.h"
#include "fjell/io/pack_file.h"

namespace fjell::baker {

// Compares the range and five samples with the pack's. Empty: they agree, or the source is one of those that only ours
// can read: several files, recipes, coded pictures, raw numbers, boxes, what was reprojected. Else what differs, in one
// line. Throws Failure when the file cannot be opened. O(samples).
[[nodiscard]] std::string second_reading(const Recipe& source, const SourceFacts& facts, const io::PackFile& pack);

} // namespace fjell::baker
