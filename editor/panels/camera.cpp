#include "editor/panels/panels.h"

namespace fjell::editor {

void draw_camera(const State& state, Commands&) {
    const fly::FreeCamera& c = state.eye.free;
    ui::row("Position", "%.0f %.0f %.0f m", c.position_m.x, c.position_m.y, c.position_m.z);
}

} // namespace fjell::editor
