// Columns, tabs, floating panels and the status line.
#include "editor/panels/panels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include <imgui_internal.h> // StartMouseMovingWindow: a tab that is dragged out goes on as the window it has become

#include "editor/number_text.h"
#include "editor/panels/keyboard.h"

namespace fjell::editor::ui {

namespace {

constexpr float strip_px = 10, folded_strip_px = 14, stacked_from_px = 860;
// Two columns, each as wide as by default, leave the picture two thirds.
constexpr float two_columns_from_px = 1880;
constexpr unsigned upper_sections = 5; // the first of the left column's, and of the right one's
constexpr float least_view_share = 0.3F;

// bits: of the panels that stand there; those that float need no room.
ColumnLayout column_at(std::size_t side, const Rect& room, unsigned bits, const Interface& i) {
    const auto s = static_cast<float>(i.scale);
    const Arrangement& a = i.arrangement;
    ColumnLayout c;
    c.there = true;
    c.folded = a.folded[side];
    const float strip = (c.folded ? folded_strip_px : strip_px) * s;
    const float width = c.folded ? 0 : room.width - strip;
    const bool left = side == 0;
    c.strip = {left ? room.x + width : room.x, room.y, strip, room.height};
    if (c.folded) return c;
    const float x = left ? room.x : room.x + strip;
    const bool both = (bits & left_sections) != 0 && (bits & right_sections) != 0;
    const unsigned upper = bits & (both ? left_sections : upper_sections);
    if (room.height < stacked_from_px * s || upper == 0 || upper == bits) {
        c.sections = 1;
        c.section[0] = {{x, room.y, width, room.height}, bits};
        return c;
    }
    c.sections = 2;
    const float gap = 0.6F * strip_px * s, above = std::floor((room.height - gap) * a.split[side]);
    c.section[0] = {{x, room.y, width, above}, upper};
    c.split = {x, room.y + above, width, gap};
    c.section[1] = {{x, room.y + above + gap, width, room.height - above - gap}, bits & ~upper};
    return c;
}

} // namespace

Layout layout(float width, float height, const Interface& i) {
    const auto s = static_cast<float>(i.scale);
    Layout l;
    if (i.picture_only) {
        l.view = {0, 0, std::max(width, 1.0F), std::max(height, 1.0F)};
        return l;
    }
    l.menu_height = ImGui::GetFrameHeight();
    l.status_height = ImGui::GetFrameHeight() + 2 * s;
    const float top = l.menu_height, rest = std::max(height - top - l.status_height, 1.0F);
    l.view = {0, top, std::max(width, 1.0F), rest};
    const Arrangement& a = i.arrangement;
    if (!a.panels) return l;
    const unsigned all = a.docked(left_sections | right_sections);
    const bool two = width >= two_columns_from_px * s && (all & left_sections) != 0 && (all & right_sections) != 0;
    const unsigned bits[columns] = {two ? all & left_sections : all, two ? all & right_sections : 0};
    const float most = (1 - least_view_share) * width / (two ? 2 : 1);
    float taken[columns] = {};
    for (std::size_t side = 0; side < columns; ++side) {
        if (bits[side] == 0) continue; // all of its panels float
        taken[side] =
            std::floor(a.folded[side] ? folded_strip_px * s : std::min(a.width_px[side] * s + strip_px * s, most));
        const Rect room{side == 0 ? 0 : width - taken[side], top, taken[side], rest};
        l.column[side] = column_at(side, room, bits[side], i);
    }
    l.view.x = taken[0];
    l.view.width = std::max(width - taken[0] - taken[1], 1.0F);
    return l;
}

} // namespace fjell::editor::ui

// --- Columns and their tabs.

namespace fjell::editor {

namespace {

constexpr const char* titles[] = {"Tune", "View", "Cost", "Auto-tune", "Pictures and paths", "Light", "Ground"};
static_assert(std::size(titles) == panels, "a panel was added: title it");

struct GroupContents {
    void (*draw)(const State&, PanelState&, Commands&);
    bool of_terrain = true; // nothing to be shown without one
};
template <Group group>
void draw_keys_of(const State& state, PanelState& own, Commands& commands) {
    draw_profile_keys(group, state, own, commands);
}
constexpr GroupContents contents[] = {{draw_keys_of<Group::tune_refinement>, false},
                                      {draw_keys_of<Group::tune_budgets>, false},
                                      {draw_keys_of<Group::tune_streaming>, false},
                                      {draw_keys_of<Group::tune_screen>, false},
                                      {draw_keys_of<Group::tune_advanced>, false},
                                      {draw_modes, false},
                                      {draw_overlays, false},
                                      {draw_compare_picture},
                                      {draw_navigation},
                                      {draw_overview},
                                      {draw_position},
                                      {draw_scale, false},
                                      {draw_budgets},
                                      {draw_time},
                                      {draw_streaming},
                                      {draw_levels},
                                      {draw_auto_tune, false},
                                      {draw_benchmark, false},
                                      {draw_path},
                                      {draw_bookmarks},
                                      {draw_render},
                                      {draw_light_presets, false},
                                      {draw_keys_of<Group::light_sun>, false},
                                      {draw_keys_of<Group::light_air>, false},
                                      {draw_keys_of<Group::light_ground>, false},
                                      {draw_materials, false},
                                      {draw_brush},
                                      {draw_edit_layers}};
static_assert(std::size(contents) == groups, "a group was added: draw it");

// Tabs that the state, not ImGui, remembers, so that scripts can turn to them.
void draw_tabs(const ui::Section& section, Panel shown, const State& state, Commands& commands) {
    const float right = ImGui::GetWindowContentRegionMax().x;
    bool first = true;
    for (int i = 0; i < panels; ++i) {
        const auto panel = static_cast<Panel>(i);
        if ((section.bits & section_bit(panel)) == 0 || state.interface.arrangement.floats(panel)) continue;
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
        if ((section.bits & section_bit(panel)) != 0 && !arrangement.floats(panel)) return panel;
    }
    return of;
}

void draw_section(const char* name, const ui::Section& section, const State& state, PanelState& own,
                  Commands& commands) {
    const Panel shown = state.interface.arrangement.shown(section.bits);
    ui::begin_column(name, section.rect, key_flags(state) | ImGuiWindowFlags_NoScrollbar);
    draw_tabs(section, shown, state, commands);
    // The scroll bar has its room always, in the column's margin, and stands off what it scrolls.
    const ImGuiStyle& style = ImGui::GetStyle();
    const float width = ImGui::GetContentRegionAvail().x + style.WindowPadding.x / 2;
    ImGui::SetNextWindowContentSize({width - style.ScrollbarSize - style.WindowPadding.x / 2, 0});
    keyboard::Pane pane(state);
    // Each where it was scrolled to.
    ImGui::BeginChild(title_of(shown), {width, 0}, false, key_flags(state) | ImGuiWindowFlags_NavFlattened);
    pane.began();
    if (const int way = pane.turns(); way != 0)
        commands.push(ShowPanel{neighbour(section, shown, way, state.interface.arrangement)});
    draw_panel(shown, state, own, commands);
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

void draw_column(std::size_t side, const ui::ColumnLayout& column, const State& state, PanelState& own,
                 Commands& commands) {
    if (!column.there) return;
    constexpr const char* names[columns][2] = {{"left", "left, below"}, {"right", "right, below"}};
    for (int i = 0; i < column.sections; ++i) draw_section(names[side][i], column.section[i], state, own, commands);
    if (column.sections == 2) draw_split(side, column, commands);
    draw_strip(side, column, state, commands);
}

} // namespace

void draw_panel(Panel panel, const State& state, PanelState& own, Commands& commands) {
    const keyboard::TabStops stops;
    if (panel == Panel::tune && draw_search(state, own, commands)) return;
    for (std::size_t i = 0; i < groups; ++i) {
        const GroupName& group = group_names[i];
        if (group.panel != panel) continue;
        const bool open = state.interface.arrangement.open[i];
        ImGui::SetNextItemOpen(open);
        const bool shown = ImGui::CollapsingHeader(group.label);
        ui::mark("group", group.name);
        if (shown != open) commands.push(ShowGroup{static_cast<Group>(i), shown});
        if (!shown) continue;
        ImGui::PushID(group.name);
        if (contents[i].of_terrain && !state.scene.open())
            ui::note("No terrain is open.");
        else
            contents[i].draw(state, own, commands);
        ImGui::Spacing();
        ImGui::PopID();
    }
}

const char* title_of(Panel panel) {
    return titles[static_cast<int>(panel)];
}

ImGuiWindowFlags key_flags(const State& state) {
    const bool keys = state.interface.panel_keys || ImGui::GetIO().WantTextInput;
    return keys ? 0 : ImGuiWindowFlags_NoNavInputs;
}

void draw_panels(const State& state, PanelState& own, Commands& commands) {
    const ImVec2 display = ImGui::GetIO().DisplaySize;
    const ui::Layout layout = ui::layout(display.x, display.y, state.interface);
    keyboard::begin_panels(state, commands);
    draw_shortcuts(state, own, commands);
    if (layout.menu_height > 0) draw_menu(state, own, commands);
    for (std::size_t side = 0; side < columns; ++side) draw_column(side, layout.column[side], state, own, commands);
    draw_floating(state, layout, own, commands);
    draw_view(state, layout, own, commands);
    draw_divider(state, layout.view, commands);
    if (layout.status_height > 0) draw_status(state, layout, commands);
    draw_dialog(state, own, commands);
}

// --- Panels that float over the picture. While a hand moves one, ImGui has its place, and the state follows; otherwise
// the state has it: a command, another scale or another window may have changed it.

namespace {

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

void draw_float(Panel panel, const State& state, const ui::Layout& layout, PanelState& own, Commands& commands) {
    const auto i = static_cast<std::size_t>(panel);
    const FloatingPanel& f = state.interface.arrangement.floating[i];
    FloatBefore& was = own.floats[i];
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
    Panel& latest = own.float_on_top;
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
    if (shown) draw_panel(panel, state, own, commands);
    follow_float(panel, was, state, layout, commands);
    ImGui::End();
    if (!open) commands.push(FloatPanel{panel, false, {}});
}

} // namespace

void draw_floating(const State& state, const ui::Layout& layout, PanelState& own, Commands& commands) {
    const Interface& i = state.interface;
    for (int p = 0; p < panels; ++p) {
        const auto panel = static_cast<Panel>(p);
        if (i.arrangement.panels && !i.picture_only && i.arrangement.floats(panel))
            draw_float(panel, state, layout, own, commands);
        else
            own.floats[static_cast<std::size_t>(p)].on = false;
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

// --- The line at the bottom: the newest message, and the figures that matter most; what has no room is left out, the
// least important first.

const char* exhausted_budget(std::uint32_t exhausted) {
    constexpr struct {
        std::uint32_t bit;
        const char* name;
    } budgets[] = {{session::exhausted_vertices, "vertices"}, {session::exhausted_triangles, "triangles"},
                   {session::exhausted_indices, "indices"},   {session::exhausted_page_slots, "page slots"},
                   {session::exhausted_items, "work items"},  {session::exhausted_time, "time"}};
    for (const auto& budget : budgets)
        if ((exhausted & budget.bit) != 0) return budget.name;
    return "";
}

namespace {

struct Part {
    char text[96] = "";
    ImU32 colour = 0;
    int importance = 0; // 1 goes last
    const char* name = "";
    const char* about = "";
};

// Green: as asked for. Amber: it lags, or pages are missing. Red: a budget does not suffice.
Part threshold_part(const State& state) {
    const session::FrameEntry& e = state.measures.last();
    Part part{"", ui::good, 1, "threshold",
              "The error bound of the mesh now, and the reason if it is not the requested threshold."};
    constexpr std::uint32_t lasting = session::exhausted_vertices | session::exhausted_indices |
                                      session::exhausted_triangles | session::exhausted_page_slots;
    char why[48] = "";
    if ((e.exhausted & lasting) != 0) {
        part.colour = ui::bad;
        std::snprintf(why, sizeof why, "%s exhausted", exhausted_budget(e.exhausted));
    } else if (e.streamed && !e.stream.converged) {
        part.colour = ui::warning_colour;
        std::snprintf(why, sizeof why, "pages missing");
    } else if (!e.converged) {
        part.colour = ui::warning_colour;
        if (const char* const budget = exhausted_budget(e.exhausted); *budget != '\0')
            std::snprintf(why, sizeof why, "lags: %s exhausted", budget);
        else
            std::snprintf(why, sizeof why, "%s", e.morphing > 0 ? "morphing" : "lags");
    }
    if (e.error_bound_px >= 1e6)
        std::snprintf(part.text, sizeof part.text, "error unbounded, %s", why);
    else
        std::snprintf(part.text, sizeof part.text, "within %.4g px%s%s", e.error_bound_px, *why ? ", " : "", why);
    return part;
}

Part stream_part(const State& state) {
    const StreamReport& r = state.measures.last().stream;
    const bool there = r.converged && r.maps_converged;
    Part part{"", there ? ui::good : ui::warning_colour, 4, "streaming",
              "Whether everything that the view needs is loaded."};
    if (there)
        std::snprintf(part.text, sizeof part.text, "streaming: complete");
    else
        std::snprintf(part.text, sizeof part.text, "streaming: %.12s wanted, %.12s in flight",
                      count_text(r.pages_wanted).text, count_text(r.in_flight).text);
    return part;
}

using Parts = std::array<Part, 6>;

std::size_t make_parts(const State& state, Parts& parts) {
    const Measures& m = state.measures;
    const ImU32 plain = ImGui::GetColorU32(ImGuiCol_Text);
    std::size_t n = 0;
    if (!state.scene.open()) {
        parts[n] = {"", ui::quiet, 1, "nothing", "Use File > Open, or drop a file here."};
        std::snprintf(parts[n].text, sizeof parts[n].text, "no terrain is open");
        return 1;
    }
    parts[n++] = threshold_part(state);
    if (m.ring(Series::update_us).size() != 0) {
        Part& update = parts[n++] = {"", plain, 2, "update", "99% of the last 512 updates took no longer than this."};
        std::snprintf(update.text, sizeof update.text, "update p99 %s ms",
                      ms_text(static_cast<double>(m.ring(Series::update_us).quantiles().p99)).text);
        Part& fps = parts[n++] = {"", plain, 3, "fps", "Frames per second, from the median frame time."};
        const float frame_us = m.ring(Series::frame_us).quantiles().p50;
        std::snprintf(fps.text, sizeof fps.text, "%.0f fps", frame_us > 0 ? 1e6 / static_cast<double>(frame_us) : 0.0);
    }
    if (m.last().streamed) parts[n++] = stream_part(state);
    Part& drawn = parts[n++] = {"", plain, 5, "triangles", "Triangles drawn in this frame."};
    std::snprintf(drawn.text, sizeof drawn.text, "%s triangles", count_text(m.last().triangles_drawn).text);
    return n;
}

float width_of(const Parts& parts, std::size_t n, float gap) {
    float width = 0;
    for (std::size_t i = 0; i < n; ++i) width += ImGui::CalcTextSize(parts[i].text).x + gap;
    return width;
}

void drop_least(Parts& parts, std::size_t& n) {
    const auto end = parts.begin() + static_cast<std::ptrdiff_t>(n);
    const auto least =
        std::max_element(parts.begin(), end, [](const Part& a, const Part& b) { return a.importance < b.importance; });
    std::move(least + 1, end, least);
    --n;
}

// One line of it, cut with dots where it is too long; a click shows all messages.
void draw_message(const State& state, float room, Commands& commands) {
    const Message& newest = state.messages.all.back();
    ui::need_glyphs(newest.text);
    const ImVec2 from = ImGui::GetCursorScreenPos();
    const float em = ImGui::GetFontSize();
    if (ImGui::InvisibleButton("message", {std::max(room, em), em})) commands.push(ShowDialog{Dialog::messages});
    ui::control("status", "message", newest.text.c_str());
    const char* const text = newest.text.c_str();
    const char* end = text + newest.text.size();
    const float dots = ImGui::CalcTextSize(" ...").x;
    const bool long_one = ImGui::CalcTextSize(text, end).x > room;
    // A UTF-8 character's later bytes are not cut from its first.
    while (long_one && end > text && (ImGui::CalcTextSize(text, end).x + dots > room || (*end & 0xC0) == 0x80)) --end;
    ImDrawList& list = *ImGui::GetWindowDrawList();
    const ImU32 colour = ui::severity_colour(newest.severity);
    list.AddText(from, colour, text, end);
    if (long_one) list.AddText({from.x + ImGui::CalcTextSize(text, end).x, from.y}, colour, " ...");
}

} // namespace

void draw_status(const State& state, const ui::Layout& layout, Commands& commands) {
    const ImVec2 display = ImGui::GetIO().DisplaySize;
    const float em = ImGui::GetFontSize(), gap = 1.4F * em;
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0.7F * em, 0.5F * (layout.status_height - em) - 1});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, {1, 1});
    ui::begin_column("status", {0, display.y - layout.status_height, display.x, layout.status_height});
    ImGui::PopStyleVar(2);
    draw_job_status(state, commands);
    Parts parts;
    std::size_t n = make_parts(state, parts);
    const bool message = !state.messages.all.empty() && state.now_s < state.messages.shown_until_s;
    const float all = ImGui::GetContentRegionAvail().x, least_message = message ? 16 * em : 0;
    while (n > 1 && width_of(parts, n, gap) + least_message > all) drop_least(parts, n);
    for (std::size_t i = 0; i < n; ++i) {
        if (i > 0) ImGui::SameLine(0, gap);
        ImGui::PushStyleColor(ImGuiCol_Text, parts[i].colour);
        ImGui::TextUnformatted(parts[i].text);
        ImGui::PopStyleColor();
        ui::control("status", parts[i].name, parts[i].about);
    }
    if (message) {
        ImGui::SameLine(0, gap);
        draw_message(state, ImGui::GetContentRegionAvail().x, commands);
    }
    ImGui::End();
}

} // namespace fjell::editor
