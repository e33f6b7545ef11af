// What a pack says of its own making, for people and for `verify`: how its heights were read, and what they were
// before. A line of JSON between the chunks and the directory, named by the header (PackHeader::notes_offset). No
// reader of terrain needs it; packs without it, and readers that know nothing of it, are as good as before.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "baker/heights/statistics.h"
#include "baker/maps/smooth.h"
#include "baker/read/source.h"
#include "fjell/io/pack_file.h"

namespace fjell::baker {

// What a later bake of the same ground has to know, to take over what it would make again.
struct BakedWith {
    std::uint64_t options = 0; // options_hash() of bake/stages.h
    HeightStatistics heights;  // of all samples
    bool on_scale = false;     // every height that was baked lies on the pack's height scale, bit for bit
    SmoothGround smooth;       // of its maps; of the terrain that was baked, which a part of it is not
    bool painted = false;      // stamps have painted its maps
};

struct PackNotes {
    // A JSON object: keys of a recipe (bake/recipe.h) that say how files became heights. Empty: not known.
    std::string read;
    SourceFacts source;
    std::vector<std::string> images;      // an account of each texture: its numbers, and how it was placed
    std::string locks;                    // what they are, and cost; empty: none
    std::optional<double> ground_error_m; // BakeSummary::ground_error_m
    std::optional<BakedWith> baked;       // not in packs of earlier versions
};

[[nodiscard]] std::string notes_text(const PackNotes& notes);
// Nothing where it has none. Throws Failure 1 for notes that are damaged or a file that was changed since it was
// opened, 3 for a disk that fails.
[[nodiscard]] std::optional<PackNotes> read_notes(const io::PackFile& file);

} // namespace fjell::baker
