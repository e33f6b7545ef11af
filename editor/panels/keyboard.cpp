#include "editor/panels/keyboard.h"

#include <algorithm>
#include <utility>

#include <imgui.h>
#include <imgui_internal.h> // ImGui's public functions neither tab through buttons nor show where Tab has arrived

namespace fjell::editor::keyboard {

namespace {

// ImGui 1.86 knows these by the window system's number only; the GLFW back end passes those through.
constexpr int page_up_key = 266, page_down_key = 267, f6_key = 295;

bool pressed(int key) {
    return ImGui::IsKeyPressed(key, false);
}

// A modal dialog's Enter is its main button's (ui::button).
bool enter_presses(const ImGuiContext& g) {
    const ImGuiIO& io = ImGui::GetIO();
    if (g.ActiveId != 0 || g.NavWindow == nullptr) return false; // a field that is typed into has it
    if ((g.NavWindow->RootWindow->Flags & ImGuiWindowFlags_Modal) != 0) return false;
    for (const ImGuiKey key : {ImGuiKey_Enter, ImGuiKey_KeyPadEnter}) {
        const int index = io.KeyMap[key];
        if (index >= 0 && io.KeysDown[index] && io.KeysDownDuration[index] < 0) return true;
    }
    return false;
}

} // namespace

void begin_frame(const State& state) {
    const Interface& i = state.interface;
    ImGuiIO& io = ImGui::GetIO();
    const bool on = !state.headless && // which has no keyboard
                    (i.panel_keys || is_modal(i.dialog) || i.dialog == Dialog::start ||
                     ImGui::IsPopupOpen(nullptr, ImGuiPopupFlags_AnyPopup));
    io.ConfigFlags =
        on ? io.ConfigFlags | ImGuiConfigFlags_NavEnableKeyboard : io.ConfigFlags & ~ImGuiConfigFlags_NavEnableKeyboard;
    if (on && enter_presses(*ImGui::GetCurrentContext())) io.NavInputs[ImGuiNavInput_Activate] = 1;
}

void begin_panels(const State& state, Commands& commands) {
    ImGuiContext& g = *ImGui::GetCurrentContext();
    const ImGuiIO& io = ImGui::GetIO();
    ui::context().panes.before = ui::context().panes.count;
    ui::context().panes.count = 0;
    ui::context().panes.at = std::exchange(ui::context().panes.at_next, -1);
    const bool on = (io.ConfigFlags & ImGuiConfigFlags_NavEnableKeyboard) != 0;
    if (on && (g.NavMoveFlags & ImGuiNavMoveFlags_Tabbing) != 0 && g.NavMoveSubmitted) {
        // From what has the focus, not from the top, although it is no field that is typed into.
        if (g.NavTabbingDir == 0 && g.NavId != 0) g.NavTabbingDir = 1;
        show_focus();
    }
    const Interface& i = state.interface;
    if (std::exchange(ui::context().panes.had_keys, i.panel_keys) != i.panel_keys && i.panel_keys &&
        ui::context().panes.wanted < 0)
        ui::context().panes.wanted = 0; // given by a command
    if (!pressed(f6_key) || is_modal(i.dialog) || ImGui::IsPopupOpen(nullptr, ImGuiPopupFlags_AnyPopup)) return;
    const int step = io.KeyShift ? -1 : 1;
    if (!i.panel_keys)
        ui::context().panes.wanted = step > 0 ? 0 : std::max(ui::context().panes.before - 1, 0);
    else
        ui::context().panes.wanted = ui::context().panes.at + step;
    if (i.panel_keys && (ui::context().panes.wanted < 0 || ui::context().panes.wanted >= ui::context().panes.before)) {
        ui::context().panes.wanted = -1;
        commands.push(SetSwitch{Switch::panel_keys, false});
    } else if (!i.panel_keys) {
        commands.push(SetSwitch{Switch::panel_keys, true});
    }
}

TabStops::TabStops(bool on) {
    ImGui::PushItemFlag(ImGuiItemFlags_Inputable, on);
}

TabStops::~TabStops() {
    ImGui::PopItemFlag();
}

PointerOnly::PointerOnly() {
    ImGui::PushItemFlag(ImGuiItemFlags_NoNav, true);
    ImGui::PushItemFlag(ImGuiItemFlags_NoTabStop, true);
}

PointerOnly::~PointerOnly() {
    ImGui::PopItemFlag();
    ImGui::PopItemFlag();
}

Pane::Pane(const State& state)
    : index_(ui::context().panes.count++), keys_(state.interface.panel_keys),
      focuses_(keys_ && ui::context().panes.wanted == index_) {
    if (focuses_) ImGui::SetNextWindowFocus();
}

void Pane::began() {
    if (focuses_) {
        ui::context().panes.wanted = -1;
        if (ImGui::GetCurrentContext()->NavId == 0) ImGui::NavInitWindow(ImGui::GetCurrentWindow(), false);
        show_focus();
    }
    if (keys_ && ImGui::IsWindowFocused(ImGuiFocusedFlags_RootAndChildWindows)) ui::context().panes.at_next = index_;
}

int Pane::turns() const {
    const ImGuiIO& io = ImGui::GetIO();
    if (!io.KeyCtrl || ImGui::IsPopupOpen(nullptr, ImGuiPopupFlags_AnyPopup)) return 0;
    if (index_ != (keys_ ? ui::context().panes.at : 0)) return 0;
    const int way = pressed(page_down_key) ? 1 : pressed(page_up_key) ? -1 : 0;
    if (way != 0 && keys_) ui::context().panes.wanted = index_; // its window is another one then
    return way;
}

bool outline() {
    const ImGuiContext& g = *ImGui::GetCurrentContext();
    const bool at = ImGui::IsItemFocused() && ImGui::GetIO().NavVisible;
    if (at) ImGui::RenderNavHighlight(g.LastItemData.Rect, g.LastItemData.ID);
    return at;
}

void keep_arrows() {
    const ImGuiContext& g = *ImGui::GetCurrentContext();
    const bool sideways = g.NavMoveDir == ImGuiDir_Left || g.NavMoveDir == ImGuiDir_Right;
    if (g.NavMoveSubmitted && (g.NavMoveFlags & ImGuiNavMoveFlags_Tabbing) == 0 && (sideways || g.IO.KeyShift))
        ImGui::NavMoveRequestCancel();
}

void show_focus() {
    ImGuiContext& g = *ImGui::GetCurrentContext();
    g.NavDisableHighlight = false;
    g.NavDisableMouseHover = true;
}

bool arrived() {
    const ImGuiContext& g = *ImGui::GetCurrentContext();
    return g.LastItemData.ID != 0 && g.NavJustMovedToId == g.LastItemData.ID;
}

} // namespace fjell::editor::keyboard
