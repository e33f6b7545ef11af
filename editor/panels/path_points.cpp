// What is done to the camera path and its points, below their list.
#include "editor/panels/panels.h"
#include "editor/strings.h"

namespace fjell::editor {

namespace {

bool act(const char* label, const char* name, bool enabled, const char* about) {
    ImGui::BeginDisabled(!enabled);
    const bool pressed = ImGui::Button(label);
    ImGui::EndDisabled();
    ui::mark("path", name);
    ui::tip(about);
    return pressed;
}

// The next item beside the last one, where there is room for it.
void next_beside(const char* label) {
    ImGui::SameLine();
    const float width = ImGui::CalcTextSize(label).x + 2 * ImGui::GetStyle().FramePadding.x;
    if (ImGui::GetContentRegionAvail().x < width) ImGui::NewLine();
}

void row_of(const char* label) {
    ImGui::AlignTextToFramePadding();
    ImGui::TextUnformatted(label);
    ImGui::SameLine(4.2F * ImGui::GetFontSize());
}

void draw_list_edits(const Route& route, Commands& commands) {
    const std::size_t at = route.selected().value_or(0), n = route.points().size();
    const bool selected = route.selected().has_value();
    if (act(strings::common::add, "add", true, strings::path::a_point_where_the_camera)) commands.push(AddPoint{});
    next_beside(strings::path_points::insert);
    if (act(strings::path_points::insert, "insert", !route.empty(), strings::path_points::about_insert))
        commands.push(InsertPoint{});
    next_beside(strings::path::replace);
    if (act(strings::path::replace, "replace", selected, strings::path::puts_the_selected_point_where))
        commands.push(ReplacePoint{at});
    next_beside(strings::common::remove);
    if (act(strings::common::remove, "remove", selected, strings::path::removes_the_selected_point))
        commands.push(RemovePoint{at});
    next_beside(strings::common::up);
    if (act(strings::common::up, "up", selected && at > 0, strings::path::swaps_the_selected_point_with))
        commands.push(MovePoint{at, at - 1});
    next_beside(strings::path::down);
    if (act(strings::path::down, "down", selected && at + 1 < n, strings::path::swaps_the_selected_point_with_the))
        commands.push(MovePoint{at, at + 1});
}

void draw_speeds(const Route& route, Commands& commands) {
    row_of(strings::camera::speed);
    if (act(strings::path_points::constant, "constant", route.points().size() > 1,
            strings::path_points::about_constant))
        commands.push(PacePath{Pace::constant});
    next_beside(strings::path_points::ease);
    if (act(strings::path_points::ease, "ease", route.points().size() > 1, strings::path_points::about_ease))
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
    if (act(strings::path_points::all, "aim", there, strings::path_points::about_all))
        commands.push(AimPath{target.x, target.z});
    next_beside(strings::path_points::selected);
    if (act(strings::path_points::selected, "aim-point", there && route.selected(),
            strings::path_points::about_selected))
        commands.push(AimPath{target.x, target.z, *route.selected(), *route.selected()});
    next_beside(strings::path_points::none);
    if (act(strings::path_points::none, "free", !route.targets().empty(), strings::path_points::about_none)) {
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
    if (act(strings::path::turntable, "circle", state.scene.open(), strings::path::another_path_once_around_what))
        commands.push(CirclePath{});
    next_beside(strings::common::open_more);
    if (act(strings::common::open_more, "open", true, strings::path::a_camera_path_from_a))
        commands.push(ShowDialog{Dialog::open_file});
    next_beside(strings::path::save);
    if (act(strings::path::save, "save", n >= 2, strings::path::the_camera_path_to_a))
        commands.push(ShowDialog{Dialog::save_path});
    next_beside(strings::path::clear);
    if (act(strings::path::clear, "clear", n > 0, strings::path::removes_the_path_restore_brings))
        commands.push(ClearPath{});
    next_beside(strings::common::restore);
    if (act(strings::common::restore, "restore", route.can_restore(), strings::path::the_path_as_it_was))
        commands.push(RestorePath{});
}

} // namespace fjell::editor
