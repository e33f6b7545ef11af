// What a pack is and whether it keeps its promises, as `fjell-bake info` and `verify` say it, and Python's module.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "baker/bake/recipe.h"
#include "baker/check/second_reading.h"
#include "baker/check/verify.h"
#include "baker/check/verify_maps.h"
#include "baker/read/source.h"
#include "fjell/io/journal.h"
#include "fjell/io/pack_file.h"

namespace fjell::baker {

// With the journal that lies beside the pack, if one does: what journal_json() has, and `path` and `of_this_pack`. Of a
// damaged one `problem`, a line that says why, in place of its layers.
[[nodiscard]] nlohmann::json info_json(const io::PackFile& file);
// Layers, stamps and bytes.
[[nodiscard]] nlohmann::json journal_json(const io::Journal& journal);
// Of the materials in a pack's splat maps; empty: it has none.
[[nodiscard]] std::vector<std::string> layer_names(const io::PackFile& file);

struct PackCheck {
    Recipe source; // what it was compared with, and how that was read: as the pack says, unless it was given
    VerifyReport heights;
    MapsReport maps;
    SecondReading again;
    std::string seam; // where packs of a set differ, and how; empty: they do not, or it is no set
};
// source: inputs to compare it with, and how to read them; without inputs `heights`, or if that is null nothing.
// O(samples). Throws Failure for what cannot be read, and for heights whose spacing is another.
[[nodiscard]] PackCheck check_pack(const std::string& path, const Recipe& source,
                                   const HeightSource* heights = nullptr);
[[nodiscard]] nlohmann::json check_json(const PackCheck& check);
// One line on what is wrong with it, and what to do; empty: nothing.
[[nodiscard]] std::string verdict(const PackCheck& check, const std::string& pack);

} // namespace fjell::baker
