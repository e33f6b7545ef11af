// Synthetic mountains as a source: any window of any size, made when it is asked for.
#pragma once

#include <memory>
#include <string>

#include "baker/read/source.h"

namespace fjell::baker {

// The landscape of a recipe (JSON; fields in content/README.md): the same recipe gives the same heights, bit for bit,
// on every machine and however windows are cut. Any number of readers, a thread each; they may not outlive the source.
// No samples are kept. Throws Failure 1 on a recipe that is not one.
[[nodiscard]] std::unique_ptr<HeightSource> synth_source(const std::string& recipe_json);
[[nodiscard]] std::unique_ptr<HeightSource> open_synth(const std::string& recipe_path);

} // namespace fjell::baker
