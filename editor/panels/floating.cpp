// Panels that float over the picture. While a hand moves one, ImGui has its place, and the state follows; otherwise the
// state has it: a command, another scale or another window may have changed it.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include <imgui_internal.h> // StartMouseMovingWindow: a tab that is dragged out goes on as the window it has become

#include "editor/panels/keyboard.h"
#include "editor/panels/panels.h"

namespace fjell::editor {

namespace {

// Of the frame before.
struct FloatBefore {
    bool on = false, moved = false; // by the hand that still holds it
    FloatingPanel place;            // the state's
    ImVec2 at, size, display;
    double scale = 0;
};
std::array<FloatBefore, panels> floats_before;

bool same_place(const FloatingPanel& a, const FloatingPanel& b) {
    constexpr float rounding = 0.05F;
    return std::abs(a.x_px - b.x_px) < rounding && std::abs(a.y_px - b.y_px) < rounding &&
           std::abs(a.width_px - b.width_px) < rounding && std::abs(a.height_px - b.height_px) < rounding;
}

bool same_place(const ImVec2& a, const ImVec2& b) {
    return a.x == b.x && a.y == b.y;
}

bool is_inside(const ImVec2& p, const ui::Rect& r) {
    return p.x >= r.x && p.x < r.x + r.width && p.y >= r.y && p.y < r.y + r.height;
}

bool over_a_column(const ImVec2& p, const ui::Layout& layout) {
    for (const ui::ColumnLayout& c : layout.column)
        for (int i = 0; c.there && i < c.sections; ++i)
            if (is_inside(p, c.section[i].rect)) return true;
    return false;
}

// Where the state wants it, but all of it in the window if there is room.
void put_float(const FloatingPanel& f, double scale, const ui::Layout& layout) {
    const auto s = static_cast<float>(scale);
    const ImVec2 display = ImGui::GetIO().DisplaySize;
    const float top = layout.menu_height, bottom = display.y - layout.status_height;
    const ImVec2 size{std::min(f.width_px * s, display.x), std::min(f.height_px * s, bottom - top)};
    ImGui::SetNextWindowPos({std::round(std::clamp(f.x_px * s, 0.0F, display.x - size.x)),
                             std::round(std::clamp(f.y_px * s, top, bottom - size.y))},
                            ImGuiCond_Always);
    ImGui::SetNextWindowSize(size, ImGuiCond_Always);
}

// The hand that has dragged the tab out holds the window by its title.
void go_on_dragging() {
    ImGuiWindow* const window = ImGui::GetCurrentWindow();
    const ImVec2 pointer = ImGui::GetIO().MousePos;
    ImGui::StartMouseMovingWindow(window);
    ImGui::GetCurrentContext()->ActiveIdClickOffset = {pointer.x - window->Pos.x, pointer.y - window->Pos.y};
}

// The state learns where the window has been moved, and forgets the panel's window over a column.
void follow_float(Panel panel, FloatBefore& was, const State& state, const ui::Layout& layout, Commands& commands) {
    const ImGuiIO& io = ImGui::GetIO();
    const ImVec2 at = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
    const auto s = static_cast<float>(state.interface.scale);
    if (was.on && !ImGui::IsWindowCollapsed() && (!same_place(at, was.at) || !same_place(size, was.size))) {
        was.moved = was.moved || !same_place(at, was.at);
        was.place = {true, at.x / s, std::max(at.y / s, 0.0F), size.x / s, size.y / s};
        const FloatingPanel& p = was.place;
        commands.push(PlacePanel{panel, static_cast<double>(p.x_px), static_cast<double>(p.y_px),
                                 static_cast<double>(p.width_px), static_cast<double>(p.height_px)});
    }
    if (!ImGui::IsMouseDown(ImGuiMouseButton_Left)) {
        if (was.moved && over_a_column(io.MousePos, layout)) commands.push(FloatPanel{panel, false, {}});
        was.display = was.moved ? ImVec2{} : io.DisplaySize; // let go: back into the window, if it stands out of it
        was.moved = false;
    }
    was.on = true;
    was.at = at;
    was.size = size;
    was.scale = state.interface.scale;
}

void draw_float(Panel panel, const State& state, const ui::Layout& layout, Commands& commands) {
    const auto i = static_cast<std::size_t>(panel);
    const FloatingPanel& f = state.interface.arrangement.floating[i];
    FloatBefore& was = floats_before[i];
    const bool appears = !was.on;
    const bool elsewhere = !same_place(was.place, f) || was.scale != state.interface.scale ||
                           !same_place(was.display, ImGui::GetIO().DisplaySize);
    if (appears || elsewhere) {
        put_float(f, state.interface.scale, layout);
        was = {};
        was.place = f;
        was.display = ImGui::GetIO().DisplaySize;
    }
    const float em = ImGui::GetFontSize();
    ImGui::SetNextWindowSizeConstraints({10 * em, 6 * em}, ImGui::GetIO().DisplaySize);
    static Panel latest = Panel::tune;
    const Panel turned_to = state.interface.arrangement.latest.front();
    if (appears || (turned_to == panel && latest != panel)) ImGui::SetNextWindowFocus(); // on top of the others
    if (turned_to == panel || latest == panel) latest = turned_to;
    char name[64];
    (void)std::snprintf(name, sizeof name, "%s###floating-%s", title_of(panel), panel_names[i]);
    bool open = true;
    keyboard::Pane pane(state);
    const bool shown = ImGui::Begin(name, &open, ImGuiWindowFlags_NoSavedSettings | key_flags(state));
    pane.began();
    ui::mark("floating", panel_names[i]); // its title
    if (appears && ImGui::IsMouseDown(ImGuiMouseButton_Left)) go_on_dragging();
    if (shown) draw_panel(panel, state, commands);
    follow_float(panel, was, state, layout, commands);
    ImGui::End();
    if (!open) commands.push(FloatPanel{panel, false, {}});
}

} // namespace

void draw_floating(const State& state, const ui::Layout& layout, Commands& commands) {
    const Interface& i = state.interface;
    for (int p = 0; p < panels; ++p) {
        const auto panel = static_cast<Panel>(p);
        if (i.arrangement.panels && !i.picture_only && i.arrangement.floats(panel))
            draw_float(panel, state, layout, commands);
        else
            floats_before[static_cast<std::size_t>(p)].on = false;
    }
}

void draw_detaching(Panel panel, const ui::Rect& column, const State& state, Commands& commands) {
    const ImGuiIO& io = ImGui::GetIO();
    const bool twice = ImGui::IsItemHovered() && ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left);
    const bool dragged =
        ImGui::IsItemActive() && ImGui::IsMouseDragging(ImGuiMouseButton_Left) && !is_inside(io.MousePos, column);
    if (!twice && !dragged) return;
    const auto s = static_cast<float>(state.interface.scale);
    const float em = ImGui::GetFontSize();
    // Under the pointer that drags it; otherwise beside its column.
    const bool right = column.x > io.DisplaySize.x / 2;
    const float width = state.interface.arrangement.floating[static_cast<std::size_t>(panel)].width_px * s;
    const ImVec2 at = dragged
                          ? ImVec2{io.MousePos.x - 4 * em, io.MousePos.y - 0.7F * em}
                          : ImVec2{right ? column.x - width - 2 * em : column.x + column.width + 2 * em, column.y + em};
    commands.push(FloatPanel{panel, true, std::array{static_cast<double>(at.x / s), static_cast<double>(at.y / s)}});
}

} // namespace fjell::editor
