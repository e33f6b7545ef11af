// Keys, and all messages.
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
    {"Right drag, Shift drag", "in orbit: pan"},
    {"1  2  3", "fly, orbit, follow the path"},
    {"Home", "look at the whole terrain"},
    {"Click on the overview", "fly there, at the same height above the ground"},
    {"F", "freeze refinement, to look at the mesh from elsewhere"},
    {"Camera path", nullptr},
    {"R", "record the flight; again: stop"},
    {"N", "add a point where the camera is"},
    {"Left drag on a point", "move it, in the picture or on the overview; a click selects it"},
    {"P", "play; again: pause"},
    {"Picture", nullptr},
    {"M, Shift M", "next and previous picture mode"},
    {"G", "wireframe"},
    {"L and left drag", "the sun: across its azimuth, up and down its elevation"},
    {"I", "probe the ground under the pointer; a click marks a place, another one measures from there"},
    {"T", "pause graphs and times; again: go on"},
    {"Window", nullptr},
    {"Tab", "hide the panels, or show them"},
    {"F11", "the picture alone; again or Esc: all of it"},
    {"F6", "keys move in the panels (arrows, Tab, Space); again or Esc: back"},
    {"F10", "the menu, again: the next one (arrows, Space)"},
    {"Enter, Esc", "in a dialog: its main button, or close it"},
    {"Profile and program", nullptr},
    {"[  ]", "a smaller, a larger threshold"},
    {"Ctrl Z, Ctrl Shift Z", "undo, redo"},
    {"Ctrl O", "open a pack, a DEM, a profile or a camera path"},
    {"Ctrl S", "save the profile"},
    {"Ctrl click on a slider", "type a value"},
    {"F1", "this list of keys"},
    {"Ctrl Q", "quit"},
};

} // namespace

void draw_keys(const State&, Commands& commands) {
    ImGui::BeginChild("list", {0, -ImGui::GetFrameHeightWithSpacing()});
    if (ImGui::BeginTable("keys", 2, ImGuiTableFlags_SizingFixedFit)) {
        ImGui::TableSetupColumn("keys", ImGuiTableColumnFlags_WidthFixed,
                                ImGui::CalcTextSize("Right drag, Shift drag").x + ImGui::GetFontSize());
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
    const float button = ImGui::GetFrameHeightWithSpacing();
    ImGui::BeginChild("list", {0, -button});
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
    ImGui::EndChild();
    if (ui::button("Close", true)) commands.push(ShowDialog{Dialog::none});
    ui::mark("messages", "close");
}

} // namespace fjell::editor
