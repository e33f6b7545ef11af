// The heights that a recipe names.
#pragma once

#include <memory>

#include "baker/bake/recipe.h"
#include "baker/read/source.h"

namespace fjell::baker {

// Files of heights; a pack or a pack set, whose heights are in metres on a grid already; or one of content/terrain:
// mountains are made as they are asked for. With what `edits` and `coarse` make of them. Throws Failure: as
// open_source(), and 2 for a pack and options that say how files are read.
[[nodiscard]] std::unique_ptr<HeightSource> open_inputs(const Recipe& recipe);
// What the stamps of `edits` and the places of `coarse` make of heights; without any, the heights. Throws Failure.
[[nodiscard]] std::unique_ptr<HeightSource> edited_source(std::unique_ptr<HeightSource> source, const Recipe& recipe);

} // namespace fjell::baker
