#include "editor/panels/panels.h"

namespace fjell::editor {

void draw_show(const State& state, Commands& commands) {
    ui::heading("Picture");
    for (int i = 0; i < fly::picture_modes; ++i) {
        const auto mode = static_cast<fly::PictureMode>(i);
        if (ImGui::RadioButton(fly::picture_mode_names[i], state.interface.mode == mode)) commands.push(SetMode{mode});
        ui::mark("mode", fly::picture_mode_names[i]);
    }
    ui::heading("Over it");
    for (int i = 0; i < overlays; ++i) {
        bool on = state.interface.overlay[static_cast<std::size_t>(i)];
        if (ImGui::Checkbox(overlay_names[i], &on)) commands.push(SetOverlay{static_cast<Overlay>(i), on});
        ui::mark("overlay", overlay_names[i]);
    }
}

} // namespace fjell::editor
