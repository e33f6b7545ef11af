#include "editor/panels/panels.h"
#include "editor/panels/keyboard.h"

#include <algorithm>

namespace fjell::editor {

namespace {

using Draw = void (*)(const State&, Commands&);
constexpr Draw draws[] = {draw_tune,    draw_camera,    draw_picture, draw_pictures,  draw_time,
                          draw_budgets, draw_streaming, draw_levels,  draw_auto_tune, draw_benchmark};
constexpr const char* titles[] = {"Tune",    "Camera",    "View",   "Pictures",  "Time",
                                  "Budgets", "Streaming", "Levels", "Auto-tune", "Benchmark"};
static_assert(std::size(draws) == panels && std::size(titles) == panels, "a panel was added: draw and title it");

// Tabs that the state, not ImGui, remembers, so that scripts can turn to them.
void draw_tabs(const ui::Section& section, Panel shown, const State& state, Commands& commands) {
    const float right = ImGui::GetWindowContentRegionMax().x;
    bool first = true;
    for (int i = 0; i < panels; ++i) {
        const auto panel = static_cast<Panel>(i);
        if ((section.groups & group_bit(panel)) == 0 || state.interface.arrangement.floats(panel)) continue;
        const float width = ImGui::CalcTextSize(titles[i]).x + 2 * ImGui::GetStyle().FramePadding.x;
        if (!first) {
            ImGui::SameLine(0, 0.5F * ImGui::GetStyle().ItemSpacing.x);
            if (ImGui::GetCursorPosX() + width > right) ImGui::NewLine();
        }
        first = false;
        const bool on = panel == shown;
        if (!on) ImGui::PushStyleColor(ImGuiCol_Button, ImGui::GetStyleColorVec4(ImGuiCol_FrameBg));
        const keyboard::TabStops stop(on); // the row is one stop; arrows move in it
        if (ImGui::Button(titles[i])) commands.push(ShowPanel{panel});
        ui::mark("panel", panel_names[i]);
        if (!on) ImGui::PopStyleColor();
        draw_detaching(panel, section.rect, state, commands);
        ui::tip("Drag it onto the picture, or click it twice, and the panel floats there. Ctrl+Page Up and Page Down "
                "turn to the panels beside it.");
    }
    ImGui::Separator();
}

// The panel of the section that stands before or after that one, around its ends.
Panel neighbour(const ui::Section& section, Panel of, int way, const Arrangement& arrangement) {
    int i = static_cast<int>(of);
    for (int step = 0; step < panels; ++step) {
        i = (i + way + panels) % panels;
        const auto panel = static_cast<Panel>(i);
        if ((section.groups & group_bit(panel)) != 0 && !arrangement.floats(panel)) return panel;
    }
    return of;
}

void draw_section(const char* name, const ui::Section& section, const State& state, Commands& commands) {
    const Panel shown = state.interface.arrangement.shown(section.groups);
    ui::begin_column(name, section.rect, key_flags(state) | ImGuiWindowFlags_NoScrollbar);
    draw_tabs(section, shown, state, commands);
    // The scroll bar has its room always, in the column's margin, and stands off what it scrolls.
    const ImGuiStyle& style = ImGui::GetStyle();
    const float width = ImGui::GetContentRegionAvail().x + style.WindowPadding.x / 2;
    ImGui::SetNextWindowContentSize({width - style.ScrollbarSize - style.WindowPadding.x / 2, 0});
    keyboard::Pane pane(state);
    // Each where it was scrolled to.
    ImGui::BeginChild(titles[static_cast<int>(shown)], {width, 0}, false,
                      key_flags(state) | ImGuiWindowFlags_NavFlattened);
    pane.began();
    if (const int way = pane.turns(); way != 0)
        commands.push(ShowPanel{neighbour(section, shown, way, state.interface.arrangement)});
    draw_panel(shown, state, commands);
    ImGui::EndChild();
    ImGui::End();
}

// An arrow in the strip's middle: to fold the column, or to unfold it.
void draw_arrow(const ui::Rect& r, bool to_left, ImU32 colour) {
    const ImVec2 c{r.x + r.width / 2, r.y + r.height / 2};
    const float w = 0.28F * r.width * (to_left ? 1.0F : -1.0F), h = 0.45F * r.width;
    ImGui::GetWindowDrawList()->AddTriangleFilled({c.x - w, c.y}, {c.x + w, c.y - h}, {c.x + w, c.y + h}, colour);
}

// A window as large as the rectangle, and one button over all of it.
void begin_handle(const char* name, const ui::Rect& rect) {
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0, 0});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, {1, 1});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 0);
    ui::begin_column(name, rect, ImGuiWindowFlags_NoNavInputs | ImGuiWindowFlags_NoNavFocus);
    ImGui::PopStyleVar(3);
    ImGui::InvisibleButton(name, {rect.width, rect.height});
    ui::mark("handle", name);
    if (ImGui::IsItemHovered() || ImGui::IsItemActive())
        ImGui::GetWindowDrawList()->AddRectFilled({rect.x, rect.y}, {rect.x + rect.width, rect.y + rect.height},
                                                  ImGui::GetColorU32(ImGuiCol_FrameBgHovered));
}

void draw_strip(std::size_t side, const ui::ColumnLayout& column, const State& state, Commands& commands) {
    begin_handle(side == 0 ? "left-column" : "right-column", column.strip);
    const ImGuiIO& io = ImGui::GetIO();
    const auto c = static_cast<Column>(side);
    const bool dragged = ImGui::GetMouseDragDelta(ImGuiMouseButton_Left, 0).x != 0;
    if (ImGui::IsItemHovered() || ImGui::IsItemActive()) ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeEW);
    if (ImGui::IsItemActive() && !column.folded && io.MouseDelta.x != 0) {
        // Where the pointer is, not how far it went: it does not run away from the strip at the ends.
        const float at = side == 0 ? io.MousePos.x : io.DisplaySize.x - io.MousePos.x;
        commands.push(ArrangeColumn{c, ColumnPart::width,
                                    static_cast<double>(at - column.strip.width / 2) / state.interface.scale});
    }
    if (ImGui::IsItemDeactivated() && !dragged)
        commands.push(ArrangeColumn{c, ColumnPart::folded, column.folded ? 0.0 : 1.0});
    ui::tip(column.folded ? "Click to unfold the panels (Tab shows and hides them all)."
                          : "Drag to resize the panels, click to fold them (Tab shows and hides them all).");
    draw_arrow(column.strip, (side == 0) != column.folded, ui::quiet);
    ImGui::End();
}

void draw_split(std::size_t side, const ui::ColumnLayout& column, Commands& commands) {
    begin_handle(side == 0 ? "left-split" : "right-split", column.split);
    const ImGuiIO& io = ImGui::GetIO();
    if (ImGui::IsItemHovered() || ImGui::IsItemActive()) ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeNS);
    if (ImGui::IsItemActive() && io.MouseDelta.y != 0) {
        const float top = column.section[0].rect.y;
        const float all = column.section[0].rect.height + column.section[1].rect.height;
        const float share = (io.MousePos.y - top - column.split.height / 2) / std::max(all, 1.0F);
        commands.push(ArrangeColumn{static_cast<Column>(side), ColumnPart::split, static_cast<double>(share)});
    }
    ui::tip("Drag to divide the column.");
    ImGui::End();
}

void draw_column(std::size_t side, const ui::ColumnLayout& column, const State& state, Commands& commands) {
    if (!column.there) return;
    constexpr const char* names[columns][2] = {{"left", "left, below"}, {"right", "right, below"}};
    for (int i = 0; i < column.sections; ++i) draw_section(names[side][i], column.section[i], state, commands);
    if (column.sections == 2) draw_split(side, column, commands);
    draw_strip(side, column, state, commands);
}

} // namespace

void draw_panel(Panel panel, const State& state, Commands& commands) {
    const keyboard::TabStops stops;
    draws[static_cast<int>(panel)](state, commands);
}

const char* title_of(Panel panel) {
    return titles[static_cast<int>(panel)];
}

ImGuiWindowFlags key_flags(const State& state) {
    const bool keys = state.interface.panel_keys || ImGui::GetIO().WantTextInput;
    return keys ? 0 : ImGuiWindowFlags_NoNavInputs;
}

void draw_panels(const State& state, Commands& commands) {
    const ImVec2 display = ImGui::GetIO().DisplaySize;
    const ui::Layout layout = ui::layout(display.x, display.y, state.interface);
    keyboard::begin_panels(state, commands);
    draw_shortcuts(state, commands);
    if (layout.menu_height > 0) draw_menu(state, commands);
    for (std::size_t side = 0; side < columns; ++side) draw_column(side, layout.column[side], state, commands);
    draw_floating(state, layout, commands);
    draw_view(state, layout, commands);
    draw_divider(state, layout.view, commands);
    if (layout.status_height > 0) draw_status(state, layout, commands);
    draw_dialog(state, commands);
}

} // namespace fjell::editor
