// A height field looked at by GDAL alone, against the pack that was baked of it. `verify --against` reads heights as
// the bake does, so that it repeats what the bake mistakes; this shares nothing with it but the choice of the band and
// the unit.
#pragma once

#include <string>
#include <vector>

#include "baker/read/options.h"
#include "baker/read/source.h"
#include "fjell/io/pack_file.h"

namespace fjell::baker {

struct SecondReading {
    std::string account; // what was compared, in words; empty: nothing could be
    std::string wrong;   // the first thing that does not agree; empty: none
};

// paths, options: what the pack was baked from, and how. facts: what the baker's own reading says of it. The range of
// all numbers; of one file that was neither reprojected nor cut also five samples. Heights in the pack that the file
// has no number for are not compared. O(samples). Throws Failure for a pack that is damaged.
[[nodiscard]] SecondReading read_again(const std::vector<std::string>& paths, const ReadOptions& options,
                                       const SourceFacts& facts, const io::PackFile& pack);

} // namespace fjell::baker
