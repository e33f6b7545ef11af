#include "editor/panels/panels.h"

namespace fjell::editor {

void draw_bake(const State&, Commands&) {}
void draw_auto_tune(const State&, Commands&) {}
void draw_benchmark(const State&, Commands&) {}
void draw_snapshot(const State&, Commands&) {}
void draw_screenshot(const State&, Commands&) {}

} // namespace fjell::editor
