// Runs of benchmarks in the benchmark panel and on the overview.
#pragma once

#include "editor/command.h"
#include "editor/panels/ui.h"
#include "editor/state.h"

namespace fjell::editor {

void draw_runs(const State& state, Commands& commands); // nothing when there are none
// Dots along the latest run's path, over an overview that lies there.
void draw_heat(const State& state, ImDrawList& list, ImVec2 from, ImVec2 size);

} // namespace fjell::editor
