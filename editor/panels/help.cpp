#include "editor/panels/panels.h"

namespace fjell::editor {

void draw_keys(const State&, Commands&) {}
void draw_messages(const State&, Commands&) {}

} // namespace fjell::editor
