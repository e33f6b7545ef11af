// Keys, and all messages.
#include <algorithm>
#include <cstdio>

#include "editor/panels/panels.h"

namespace fjell::editor {

namespace {

struct Key {
    const char *keys, *what; // what null: a heading
};
constexpr Key all_keys[] = {
    {"Camera", nullptr},
    {"W S, A D", "fly forwards and back, left and right; in orbit: pan"},
    {"E Q", "up and down"},
    {"Shift", "five times as fast"},
    {"Arrows, left drag", "look around; in orbit: turn around the centre"},
    {"Wheel", "speed; in orbit: zoom"},
    {"Right drag, Shift+drag", "in orbit: pan"},
    {"1  2  3", "fly, orbit, follow the path"},
    {"Home", "look at the whole terrain"},
    {"Click on the overview", "fly there, at the same height above the ground"},
    {"F", "freeze refinement, to look at the mesh from elsewhere"},
    {"Camera path", nullptr},
    {"R", "record the flight; again: stop recording"},
    {"N", "add a point where the camera is"},
    {"Insert  Delete", "add a point where the path is being played; remove the selected point"},
    {"Left drag on a point", "move it, in the picture (Shift: up and down) or on the overview; a click selects it"},
    {"Arrows on the timeline", "select a point; Enter: look from there; Insert, Delete"},
    {"P", "play; again: pause"},
    {"Picture", nullptr},
    {"M, Shift+M", "next and previous picture mode"},
    {"G", "wireframe"},
    {"L and left drag", "the sun: across its azimuth, up and down its elevation"},
    {"I", "probe the ground under the pointer, or where the camera looks; a click or Enter marks a place, another one "
          "measures from there"},
    {"T", "pause graphs and times; again: go on"},
    {"Window", nullptr},
    {"Tab", "hide the panels, or show them"},
    {"F11", "the picture alone; again or Esc: all of it"},
    {"F6", "move in the panels by keys: Tab and arrows move, Enter presses, Space changes a value; again: the next "
           "panel, after the last one the camera; Shift+F6: the one before; Esc: the camera"},
    {"Ctrl+Page Up, Page Down", "turn to the panel before or after"},
    {"Ctrl+Tab and arrows", "with F6: move a floating panel; with Shift: resize it"},
    {"F10, Alt+F, Alt+E, ...",
     "the first menu; again: the next one; Alt and its first letter: any; arrows move, Enter chooses"},
    {"Enter, Esc", "in a dialog: its main button, or close it"},
    {"Profile and program", nullptr},
    {"[  ]", "lower, raise the threshold"},
    {"Ctrl+Z, Ctrl+Shift+Z", "undo, redo"},
    {"Ctrl+O", "open a pack, a DEM, a profile or a camera path"},
    {"Ctrl+S", "save the profile"},
    {"Ctrl+click on a slider", "type a value"},
    {"Page Up, Page Down", "scroll this list"},
    {"F1", "this list of keys"},
    {"Ctrl+Q", "quit"},
};

// Arrows stay the camera's beside these lists.
void scroll_by_keys() {
    constexpr ImGuiKey keys[] = {ImGuiKey_PageUp, ImGuiKey_PageDown};
    for (int i = 0; i < 2; ++i)
        if (ImGui::IsKeyPressed(ImGui::GetKeyIndex(keys[i])))
            ImGui::SetScrollY(ImGui::GetScrollY() + (i == 0 ? -0.9F : 0.9F) * ImGui::GetWindowHeight());
}

} // namespace

void draw_keys(const State&, Commands& commands) {
    ImGui::BeginChild("list", {0, -ImGui::GetFrameHeightWithSpacing()});
    scroll_by_keys();
    if (ImGui::BeginTable("keys", 2, ImGuiTableFlags_SizingFixedFit)) {
        ImGui::TableSetupColumn("keys", ImGuiTableColumnFlags_WidthFixed,
                                ImGui::CalcTextSize("Arrows on the timeline").x + ImGui::GetFontSize());
        ImGui::TableSetupColumn("what", ImGuiTableColumnFlags_WidthStretch);
        for (const Key& key : all_keys) {
            ImGui::TableNextRow();
            ImGui::TableNextColumn();
            if (key.what == nullptr) {
                ImGui::Spacing();
                ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(ui::quiet), "%s", key.keys);
                continue;
            }
            ImGui::TextUnformatted(key.keys);
            ImGui::TableNextColumn();
            ImGui::TextWrapped("%s", key.what);
        }
        ImGui::EndTable();
    }
    ImGui::EndChild();
    if (ui::button("Close", true)) commands.push(ShowDialog{Dialog::none});
    ui::mark("keys", "close");
}

void draw_messages(const State& state, Commands& commands) {
    // As high as they are, as far as the button stays in the window.
    static float list_height = 0;
    const float line = ImGui::GetTextLineHeight();
    const float below = ImGui::GetFrameHeightWithSpacing() + 2 * ImGui::GetStyle().WindowPadding.y;
    const float room = 0.98F * ImGui::GetIO().DisplaySize.y - ImGui::GetCursorScreenPos().y - below;
    ImGui::BeginChild("list", {0, std::max(std::min({list_height, 24 * line, room}), 3 * line)});
    scroll_by_keys();
    if (state.messages.all.empty()) ImGui::TextUnformatted("No messages yet.");
    for (auto message = state.messages.all.rbegin(); message != state.messages.all.rend(); ++message) {
        const int seconds = static_cast<int>(message->at_s);
        char time[24];
        std::snprintf(time, sizeof time, "%d:%02d", seconds / 60, seconds % 60);
        ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(ui::quiet), "%s", time);
        ImGui::SameLine(4 * ImGui::GetFontSize());
        ImGui::PushStyleColor(ImGuiCol_Text, ImGui::ColorConvertU32ToFloat4(ui::severity_colour(message->severity)));
        ImGui::PushTextWrapPos(0);
        ImGui::TextUnformatted(message->text.c_str());
        if (message->times > 1) ImGui::Text("(%u times)", message->times);
        ImGui::PopTextWrapPos();
        ImGui::PopStyleColor();
    }
    list_height = ImGui::GetCursorPosY();
    ImGui::EndChild();
    if (ui::button("Close", true)) commands.push(ShowDialog{Dialog::none});
    ui::mark("messages", "close");
}

} // namespace fjell::editor
