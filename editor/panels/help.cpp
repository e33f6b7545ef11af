// Keys, and all messages.
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
    {strings::help::w_s_a_d, strings::help::fly_forwards_and_back_left},
    {strings::help::e_q, strings::help::up_and_down},
    {strings::help::shift, strings::help::five_times_as_fast},
    {strings::help::arrows_left_drag, strings::help::look_around_in_orbit_turn},
    {strings::help::wheel, strings::help::speed_in_orbit_zoom},
    {strings::help::right_drag_shift_drag, strings::help::in_orbit_pan},
    {"1  2  3", strings::help::fly_orbit_follow_the_path},
    {strings::keys::home, strings::help::look_at_the_whole_terrain},
    {strings::help::click_on_the_overview, strings::help::fly_there_at_the_same},
    {strings::keys::f, strings::help::freeze_refinement_to_look_at},
    {strings::common::camera_path, nullptr},
    {strings::keys::r, strings::help::record_the_flight_again_stop},
    {strings::keys::n, strings::help::add_a_point_where_the},
    {strings::hands::insert_delete, strings::hands::insert_or_remove_a_point},
    {strings::help::left_drag_on_a_point, strings::help::move_it_in_the_picture},
    {strings::help::arrows_on_the_timeline, strings::help::select_a_point_with_shift},
    {strings::keys::p, strings::help::play_again_pause},
    {strings::common::picture, nullptr},
    {strings::help::m_shift_m, strings::help::next_and_previous_picture_mode},
    {strings::keys::g, strings::help::wireframe},
    {strings::help::l_and_left_drag, strings::help::the_sun_across_its_azimuth},
    {strings::keys::i, strings::help::probe_the_ground_under_the},
    {strings::keys::t, strings::help::pause_graphs_and_times_again},
    {strings::help::window, nullptr},
    {strings::keys::tab, strings::help::hide_the_panels_or_show},
    {strings::keys::f11, strings::help::the_picture_alone_again_or},
    {strings::keys::f6, strings::help::keys_move_in_the_panels},
    {strings::help::ctrl_page, strings::help::the_panel_before_and_after},
    {strings::help::ctrl_tab_and_arrows, strings::help::move_a_floating_panel},
    {strings::help::f10_alt_f, strings::help::the_menu_again_the_next},
    {strings::help::enter_esc, strings::help::in_a_dialog_its_main},
    {strings::help::profile_and_program, nullptr},
    {"[  ]", strings::help::a_smaller_a_larger_threshold},
    {strings::help::ctrl_z_ctrl_shift_z, strings::help::undo_redo},
    {strings::keys::ctrl_o, strings::help::open_a_pack_a_dem},
    {strings::keys::ctrl_s, strings::help::save_the_profile},
    {strings::help::ctrl_click_on_a_slider, strings::help::type_a_value},
    {strings::help::page_up_and_down, strings::help::scroll_this_list},
    {strings::keys::f1, strings::help::this_list_of_keys},
    {strings::keys::ctrl_q, strings::help::quit},
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
                                ImGui::CalcTextSize(strings::help::arrows_on_the_timeline).x + ImGui::GetFontSize());
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
    const float button = ImGui::GetFrameHeightWithSpacing();
    ImGui::BeginChild("list", {0, -button});
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
    ImGui::EndChild();
    if (ui::button(strings::common::close, true)) commands.push(ShowDialog{Dialog::none});
    ui::mark("messages", "close");
}

} // namespace fjell::editor
