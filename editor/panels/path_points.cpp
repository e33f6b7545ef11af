// What is done to the camera path and its points, below their list.
#include "editor/panels/panels.h"
#include "editor/strings.h"

namespace fjell::editor {

namespace {

void row_of(const char* label) {
    ImGui::AlignTextToFramePadding();
    ImGui::TextUnformatted(label);
    ImGui::SameLine(4.2F * ImGui::GetFontSize());
}

void draw_list_edits(const Route& route, Commands& commands) {
    const std::size_t at = route.selected().value_or(0), n = route.points().size();
    const bool selected = route.selected().has_value();
    if (ui::panel_button(strings::common::add, "path", "add", true, strings::path::about_add))
        commands.push(AddPoint{});
    ui::beside(strings::path_points::insert);
    if (ui::panel_button(strings::path_points::insert, "path", "insert", !route.empty(),
                         strings::path_points::about_insert))
        commands.push(InsertPoint{});
    ui::beside(strings::path::replace);
    if (ui::panel_button(strings::path::replace, "path", "replace", selected, strings::path::about_replace))
        commands.push(ReplacePoint{at});
    ui::beside(strings::common::remove);
    if (ui::panel_button(strings::common::remove, "path", "remove", selected, strings::path::about_remove))
        commands.push(RemovePoint{at});
    ui::beside(strings::common::up);
    if (ui::panel_button(strings::common::up, "path", "up", selected && at > 0, strings::path::about_up))
        commands.push(MovePoint{at, at - 1});
    ui::beside(strings::path::down);
    if (ui::panel_button(strings::path::down, "path", "down", selected && at + 1 < n, strings::path::about_down))
        commands.push(MovePoint{at, at + 1});
}

void draw_speeds(const Route& route, Commands& commands) {
    row_of(strings::camera::speed);
    if (ui::panel_button(strings::path_points::constant, "path", "constant", route.points().size() > 1,
                         strings::path_points::about_constant))
        commands.push(PacePath{Pace::constant});
    ui::beside(strings::path_points::ease);
    if (ui::panel_button(strings::path_points::ease, "path", "ease", route.points().size() > 1,
                         strings::path_points::about_ease))
        commands.push(PacePath{Pace::ease});
}

// Where the probe's marks are, or else the terrain's middle.
void draw_targets(const State& state, Commands& commands) {
    const Route& route = state.route;
    Vec3 target{state.scene.width_m() / 2, 0, state.scene.depth_m() / 2};
    if (state.probe.marks > 0) target = state.probe.mark_m[0];
    if (state.probe.marks > 1) target = (state.probe.mark_m[0] + state.probe.mark_m[1]) * 0.5;
    const bool there = state.scene.open() && !route.points().empty();
    row_of(strings::path_points::target);
    if (ui::panel_button(strings::path_points::all, "path", "aim", there, strings::path_points::about_all))
        commands.push(AimPath{target.x, target.z});
    ui::beside(strings::path_points::selected);
    if (ui::panel_button(strings::path_points::selected, "path", "aim-point", there && route.selected(),
                         strings::path_points::about_selected))
        commands.push(AimPath{target.x, target.z, *route.selected(), *route.selected()});
    ui::beside(strings::path_points::none);
    if (ui::panel_button(strings::path_points::none, "path", "free", !route.targets().empty(),
                         strings::path_points::about_none)) {
        if (route.selected())
            commands.push(FreePath{*route.selected(), *route.selected()});
        else
            commands.push(FreePath{});
    }
}

} // namespace

void draw_path_edits(const State& state, Commands& commands) {
    const Route& route = state.route;
    const std::size_t n = route.points().size();
    draw_list_edits(route, commands);
    draw_speeds(route, commands);
    draw_targets(state, commands);
    if (ui::panel_button(strings::path::turntable, "path", "circle", state.scene.open(),
                         strings::path::about_turntable))
        commands.push(CirclePath{});
    ui::beside(strings::common::open_dots);
    if (ui::panel_button(strings::common::open_dots, "path", "open", true, strings::path::about_open))
        commands.push(ShowDialog{Dialog::open_file});
    ui::beside(strings::path::save_dots);
    if (ui::panel_button(strings::path::save_dots, "path", "save", n >= 2, strings::path::about_save))
        commands.push(ShowDialog{Dialog::save_path});
    ui::beside(strings::path::clear);
    if (ui::panel_button(strings::path::clear, "path", "clear", n > 0, strings::path::about_clear))
        commands.push(ClearPath{});
    ui::beside(strings::common::restore);
    if (ui::panel_button(strings::common::restore, "path", "restore", route.can_restore(),
                         strings::path::about_restore))
        commands.push(RestorePath{});
}

} // namespace fjell::editor
