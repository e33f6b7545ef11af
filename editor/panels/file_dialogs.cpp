#include "editor/panels/panels.h"

namespace fjell::editor {

void draw_start(const State&, Commands&) {}
void draw_open_file(const State&, Commands&) {}
void draw_save_profile(const State&, Commands&) {}
void draw_save_path(const State&, Commands&) {}
void draw_compare(const State&, Commands&) {}
void draw_unsaved(const State&, Commands&) {}
void draw_recover(const State&, Commands&) {}

} // namespace fjell::editor
