#include "editor/panels/panels.h"

namespace fjell::editor {

namespace {

struct Window {
    const char* title;
    double width, height; // unscaled pixels; height 0: as its content
    void (*draw)(const State&, Commands&);
};
constexpr Window windows[] = {
    {"", 0, 0, nullptr},
    {"Welcome to Fjell", 560, 380, draw_start},
    {"Open", 640, 460, draw_open_file},
    {"Save profile", 640, 460, draw_save_profile},
    {"Save camera path", 640, 460, draw_save_path},
    {"Compare profiles", 640, 460, draw_compare},
    {"Bake", 560, 0, draw_bake},
    {"Auto-tune", 640, 520, draw_auto_tune},
    {"Benchmark", 520, 0, draw_benchmark},
    {"Export glTF", 520, 300, draw_snapshot},
    {"Screenshot", 520, 0, draw_screenshot},
    {"Keys", 560, 570, draw_keys},
    {"Messages", 640, 420, draw_messages},
    {"Unsaved changes", 480, 0, draw_unsaved},
    {"Recovered changes", 480, 0, draw_recover},
};
static_assert(std::size(windows) == dialogs, "a dialog was added: add its window");

// Asked before the dialog is drawn: what is typed into takes the key for itself, and a list that is dropped down.
bool escapes() {
    return ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape), false) && !ImGui::IsAnyItemActive() &&
           !ImGui::IsPopupOpen(nullptr, ImGuiPopupFlags_AnyPopup);
}

} // namespace

void draw_dialog(const State& state, Commands& commands) {
    const Dialog dialog = state.interface.dialog;
    if (dialog == Dialog::none) return;
    const Window& window = windows[static_cast<std::size_t>(dialog)];
    const bool escaped = escapes();
    bool open = true;
    ui::begin_dialog(window.title, window.width, window.height, state, open);
    window.draw(state, commands);
    ImGui::End();
    if (!open || escaped) commands.push(ShowDialog{Dialog::none});
}

} // namespace fjell::editor
