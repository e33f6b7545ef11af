// What a pack says of its own making, for people and for `verify`: how its heights were read, and what they were
// before. A line of JSON between the chunks and the directory, named by the header (PackHeader::notes_offset). No
// reader of terrain needs it; packs without it, and readers that know nothing of it, are as good as before.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "baker/read/source.h"
#include "fjell/pack.h"

namespace fjell::baker {

struct PackNotes {
    std::string
        read; // a JSON object: keys of a recipe (bake/recipe.h) that say how files became heights; empty: not known
    SourceFacts source;
    std::optional<double> ground_error_m; // BakeSummary::ground_error_m
};

[[nodiscard]] std::string notes_text(const PackNotes& notes);
// Of a pack's file; nothing where it has none. Throws Failure 1 for notes that are damaged, 3 for a disk that fails.
[[nodiscard]] std::optional<PackNotes> read_notes(const std::string& pack_path);

} // namespace fjell::baker
