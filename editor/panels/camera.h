// The parts of the camera's panel.
#pragma once

#include "editor/panels/panels.h"

namespace fjell::editor {

void draw_map(const State& state, Commands& commands);  // panels/overview.cpp
void draw_path(const State& state, Commands& commands); // panels/path.cpp

} // namespace fjell::editor
