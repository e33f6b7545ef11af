// The sample terrain: a small synthetic landscape (content/terrain/mountains-small.json), baked at its first use.
#pragma once

#include <string>
#include <string_view>

#include "editor/command.h"

namespace fjell::editor {

[[nodiscard]] std::string_view sample_landscape(); // JSON, as fjell-bake takes it
[[nodiscard]] std::string sample_pack(const std::string& cache_folder);
// What bakes it: the landscape is written to the folder, which is made. Throws io::Failure.
[[nodiscard]] BakePack bake_sample(const std::string& cache_folder);

} // namespace fjell::editor
