// Keys, and all messages.
#include <algorithm>
#include <cstdio>

#include "editor/panels/panels.h"
#include "editor/strings.h"

namespace fjell::editor {

namespace {

struct Key {
    const char *keys, *what; // what null: a heading
};
constexpr Key all_keys[] = {
    {strings::common::camera, nullptr},
    {strings::help::fly_keys, strings::help::about_fly_keys},
    {strings::help::height_keys, strings::help::about_height_keys},
    {strings::help::shift_key, strings::help::about_shift_key},
    {strings::help::look_keys, strings::help::about_look_keys},
    {strings::help::wheel, strings::help::about_wheel},
    {strings::help::pan_drag, strings::help::about_pan_drag},
    {"1  2  3", strings::help::about_navigation_keys},
    {strings::keys::home, strings::help::about_home},
    {strings::help::overview_click, strings::help::about_overview_click},
    {strings::keys::f, strings::help::about_freeze},
    {strings::common::camera_path, nullptr},
    {strings::keys::r, strings::help::about_record},
    {strings::keys::n, strings::help::about_add_point},
    {strings::hands::point_keys, strings::hands::about_point_keys},
    {strings::help::point_drag, strings::help::about_point_drag},
    {strings::help::timeline_keys, strings::help::about_timeline_keys},
    {strings::keys::p, strings::help::about_play},
    {strings::common::picture, nullptr},
    {strings::help::mode_keys, strings::help::about_mode_keys},
    {strings::keys::g, strings::help::about_wireframe},
    {strings::help::sun_drag, strings::help::about_sun_drag},
    {strings::keys::i, strings::help::about_probe},
    {strings::keys::t, strings::help::about_pause},
    {strings::help::window, nullptr},
    {strings::keys::tab, strings::help::about_tab},
    {strings::keys::f11, strings::help::about_picture_only},
    {strings::keys::f6, strings::help::about_panel_keys},
    {strings::help::panel_turn_keys, strings::help::about_panel_turn_keys},
    {strings::help::floating_keys, strings::help::about_floating_keys},
    {strings::help::menu_keys, strings::help::about_menu_keys},
    {strings::help::dialog_keys, strings::help::about_dialog_keys},
    {strings::help::profile_and_program, nullptr},
    {"[  ]", strings::help::about_threshold_keys},
    {strings::help::undo_keys, strings::help::about_undo_keys},
    {strings::keys::ctrl_o, strings::help::about_open},
    {strings::keys::ctrl_s, strings::help::about_save},
    {strings::help::slider_click, strings::help::about_slider_click},
    {strings::help::scroll_keys, strings::help::about_scroll_keys},
    {strings::keys::f1, strings::help::about_keys},
    {strings::keys::ctrl_q, strings::help::about_quit},
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
                                ImGui::CalcTextSize(strings::help::timeline_keys).x + ImGui::GetFontSize());
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
    if (ui::button(strings::common::close, true)) commands.push(ShowDialog{Dialog::none});
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
    if (state.messages.all.empty()) ImGui::TextUnformatted(strings::help::no_messages_yet);
    for (auto message = state.messages.all.rbegin(); message != state.messages.all.rend(); ++message) {
        const int seconds = static_cast<int>(message->at_s);
        char time[24];
        std::snprintf(time, sizeof time, "%d:%02d", seconds / 60, seconds % 60);
        ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(ui::quiet), "%s", time);
        ImGui::SameLine(4 * ImGui::GetFontSize());
        ImGui::PushStyleColor(ImGuiCol_Text, ImGui::ColorConvertU32ToFloat4(ui::severity_colour(message->severity)));
        ImGui::PushTextWrapPos(0);
        ImGui::TextUnformatted(message->text.c_str());
        if (message->times > 1) ImGui::Text(strings::help::times, message->times);
        ImGui::PopTextWrapPos();
        ImGui::PopStyleColor();
    }
    list_height = ImGui::GetCursorPosY();
    ImGui::EndChild();
    if (ui::button(strings::common::close, true)) commands.push(ShowDialog{Dialog::none});
    ui::mark("messages", "close");
}

} // namespace fjell::editor
