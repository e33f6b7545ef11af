#include "editor/panels/panels.h"

namespace fjell::editor {

namespace {

using Draw = void (*)(const State&, Commands&);
constexpr Draw draws[] = {draw_tune, draw_camera, draw_picture, draw_time, draw_budgets, draw_streaming, draw_levels};
constexpr const char* titles[] = {"Tune", "Camera", "View", "Time", "Budgets", "Streaming", "Levels"};
static_assert(std::size(draws) == panels && std::size(titles) == panels, "a panel was added: draw and title it");

// Tabs that the state, not ImGui, remembers, so that scripts can turn to them.
void draw_tabs(int first, int last, Panel shown, Commands& commands) {
    const float right = ImGui::GetWindowContentRegionMax().x;
    for (int i = first; i < last; ++i) {
        const auto panel = static_cast<Panel>(i);
        const float width = ImGui::CalcTextSize(titles[i]).x + 2 * ImGui::GetStyle().FramePadding.x;
        if (i != first) {
            ImGui::SameLine();
            if (ImGui::GetCursorPosX() + width > right) ImGui::NewLine();
        }
        const bool on = panel == shown;
        if (!on) ImGui::PushStyleColor(ImGuiCol_Button, ImGui::GetStyleColorVec4(ImGuiCol_FrameBg));
        if (ImGui::Button(titles[i])) commands.push(ShowPanel{panel});
        ui::mark("panel", panel_names[i]);
        if (!on) ImGui::PopStyleColor();
    }
    ImGui::Separator();
}

void draw_column(const char* name, const ui::Rect& rect, int first, int last, Panel shown, const State& state,
                 Commands& commands) {
    ui::begin_column(name, rect);
    draw_tabs(first, last, shown, commands);
    // The scroll bar has its room always, in the column's margin, and stands off what it scrolls.
    const ImGuiStyle& style = ImGui::GetStyle();
    const float width = ImGui::GetContentRegionAvail().x + style.WindowPadding.x / 2;
    ImGui::SetNextWindowContentSize({width - style.ScrollbarSize - style.WindowPadding.x / 2, 0});
    ImGui::BeginChild(titles[static_cast<int>(shown)], {width, 0}); // each where it was scrolled to
    draws[static_cast<int>(shown)](state, commands);
    ImGui::EndChild();
    ImGui::End();
}

} // namespace

void draw_panels(const State& state, Commands& commands) {
    const ImVec2 display = ImGui::GetIO().DisplaySize;
    const ui::Layout layout = ui::layout(display.x, display.y, state.interface.scale);
    draw_menu(state, commands);
    if (layout.one_column()) {
        draw_column("left", layout.left, 0, panels, state.interface.newest, state, commands);
    } else {
        draw_column("left", layout.left, 0, left_panels, state.interface.left, state, commands);
        draw_column("right", layout.right, left_panels, panels, state.interface.right, state, commands);
    }
    draw_view(state, layout, commands);
    draw_status(state, layout, commands);
    draw_dialog(state, commands);
}

} // namespace fjell::editor
