#include "editor/panels/keyboard.h"
#include "editor/panels/panels.h"

#include <algorithm>

#include <imgui_internal.h> // ClosePopupToLevel: the state closes a dialog, not only its own buttons

namespace fjell::editor {

namespace {

struct Window {
    const char* title;
    double width, height; // unscaled pixels; height 0: as its content
    void (*draw)(const State&, Commands&);
};
constexpr Window windows[] = {
    {"", 0, 0, nullptr},
    {"Welcome to Fjell", 560, 0, draw_start},
    {"Open", 640, 460, draw_open_file},
    {"Save profile", 640, 460, draw_save_profile},
    {"Save camera path", 640, 460, draw_save_path},
    {"Compare profiles", 640, 460, draw_compare},
    {"Bake", 820, 0, draw_bake},
    {"Export glTF", 520, 0, draw_snapshot},
    {"Screenshot", 520, 0, draw_screenshot},
    {"Keys", 560, 600, draw_keys},
    {"Messages", 640, 0, draw_messages},
    {"Unsaved changes", 480, 0, draw_unsaved},
    {"Recovered changes", 480, 0, draw_recover},
    {"The pack is ready", 480, 0, draw_baked},
};
static_assert(std::size(windows) == dialogs, "a dialog was added: add its window");

constexpr ImGuiWindowFlags dialog_flags =
    ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings;
constexpr float top_share = 0.12F; // of the window, above a dialog

// As the last frame left it: ImGui has handled Escape itself before a frame's panels are drawn.
struct Before {
    Dialog dialog = Dialog::none;
    ImVec2 display;
    double scale = 0;
    bool list = false;            // a list was dropped down over the dialog, or a question asked
    bool typing = false;          // an item was active
    std::uint64_t characters = 0; // that were typed before it was
};
Before before;

// Escape belongs to a list that is dropped down first, then to what has been typed.
bool escapes(const State& state) {
    const bool typed = before.typing && state.input.characters != before.characters;
    return ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape), false) && !before.list && !typed;
}

// Where it is stays the user's affair once it is open: its top is fixed, and what it says grows downwards.
void place(const Window& window, const State& state) {
    const ImVec2 display = ImGui::GetIO().DisplaySize;
    const bool opens = before.dialog != state.interface.dialog || before.scale != state.interface.scale ||
                       before.display.x != display.x || before.display.y != display.y;
    const auto fit = [&](double unscaled, float most) {
        return std::min(static_cast<float>(unscaled * state.interface.scale), 0.96F * most);
    };
    const float width = fit(window.width, display.x), height = fit(window.height, display.y);
    const float top = std::max(std::min(top_share * display.y, (display.y - height) / 2), 0.0F);
    ImGui::SetNextWindowPos({(display.x - width) / 2, top}, opens ? ImGuiCond_Always : ImGuiCond_Appearing);
    ImGui::SetNextWindowSize({width, height}, ImGuiCond_Always);
    ImGui::SetNextWindowSizeConstraints({0, 0}, {display.x, 0.98F * display.y - top});
}

} // namespace

void draw_dialog(const State& state, Commands& commands) {
    const Dialog dialog = state.interface.dialog;
    const Window& window = windows[static_cast<std::size_t>(dialog)];
    const bool modal = is_modal(dialog);
    const auto is_open = [](Dialog d) { return ImGui::IsPopupOpen(windows[static_cast<std::size_t>(d)].title); };
    if (before.dialog != dialog && is_modal(before.dialog) && is_open(before.dialog)) ImGui::ClosePopupToLevel(0, true);
    if (dialog == Dialog::none) {
        before.dialog = dialog;
        return;
    }
    place(window, state);
    bool open = true;
    if (modal && !is_open(dialog)) ImGui::OpenPopup(window.title);
    if (modal ? !ImGui::BeginPopupModal(window.title, &open, dialog_flags)
              : !ImGui::Begin(window.title, &open, dialog_flags)) {
        if (!modal) ImGui::End();
        return;
    }
    const bool escaped = escapes(state);
    if (ImGui::IsWindowAppearing()) keyboard::show_focus();
    {
        const keyboard::TabStops stops;
        window.draw(state, commands);
    }
    const bool list = ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopupId), active = ImGui::IsAnyItemActive();
    before = {dialog,
              ImGui::GetIO().DisplaySize,
              state.interface.scale,
              list,
              active,
              active && before.typing ? before.characters : state.input.characters};
    if (modal)
        ImGui::EndPopup();
    else
        ImGui::End();
    if (!open || escaped) commands.push(ShowDialog{Dialog::none});
}

} // namespace fjell::editor
