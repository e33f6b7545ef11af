// What is done to the camera path and its points, below their list.
#include "editor/panels/panels.h"

namespace fjell::editor {

namespace {

void draw_list_edits(const Route& route, Commands& commands) {
    const std::size_t at = route.selected().value_or(0), n = route.points().size();
    const bool selected = route.selected().has_value();
    if (ui::panel_button("Add", "path", "add", true,
                         "Adds a point where the camera is, after the selected point, or else as the last one (N)."))
        commands.push(AddPoint{});
    ui::beside("Insert");
    if (ui::panel_button("Insert", "path", "insert", !route.empty(),
                         "Adds a point on the path, where it is being played (Insert)."))
        commands.push(InsertPoint{});
    ui::beside("Replace");
    if (ui::panel_button("Replace", "path", "replace", selected, "Puts the selected point where the camera is."))
        commands.push(ReplacePoint{at});
    ui::beside("Remove");
    if (ui::panel_button("Remove", "path", "remove", selected, "Removes the selected point."))
        commands.push(RemovePoint{at});
    ui::beside("Up");
    if (ui::panel_button("Up", "path", "up", selected && at > 0, "Swaps the selected point with the one before it."))
        commands.push(MovePoint{at, at - 1});
    ui::beside("Down");
    if (ui::panel_button("Down", "path", "down", selected && at + 1 < n,
                         "Swaps the selected point with the one after it."))
        commands.push(MovePoint{at, at + 1});
}

} // namespace

void draw_path_edits(const State& state, Commands& commands) {
    const Route& route = state.route;
    const std::size_t n = route.points().size();
    draw_list_edits(route, commands);
    if (ui::panel_button("Open...", "path", "open", true, "Opens a camera path."))
        commands.push(ShowDialog{Dialog::open_file});
    ui::beside("Save...");
    if (ui::panel_button("Save...", "path", "save", n >= 2,
                         "Saves the camera path to a file, as control points in metres."))
        commands.push(ShowDialog{Dialog::save_path});
    ui::beside("Clear");
    if (ui::panel_button("Clear", "path", "clear", n > 0, "Removes the path; Restore brings it back."))
        commands.push(ClearPath{});
    ui::beside("Restore");
    if (ui::panel_button("Restore", "path", "restore", route.can_restore(),
                         "Brings back the path as it was before its last change."))
        commands.push(RestorePath{});
}

} // namespace fjell::editor
