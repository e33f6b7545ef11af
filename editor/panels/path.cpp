// The camera's path: played, recorded, laid and edited.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "editor/number_text.h"
#include "editor/panels/panels.h"

namespace fjell::editor {

namespace {

bool button(const char* label, const char* name, bool enabled, const char* about) {
    ImGui::BeginDisabled(!enabled);
    const bool pressed = ImGui::Button(label);
    ImGui::EndDisabled();
    ui::mark("path", name);
    ui::tip(about);
    return pressed;
}

// The next button beside the last one, where there is room for it.
void beside(const char* label) {
    ImGui::SameLine();
    const float width = ImGui::CalcTextSize(label).x + 2 * ImGui::GetStyle().FramePadding.x;
    if (ImGui::GetContentRegionAvail().x < width) ImGui::NewLine();
}

void draw_name(const Route& route) {
    const std::string& path = route.path();
    const std::size_t slash = path.find_last_of('/');
    const char* name = path.empty() ? "not saved yet" : path.c_str() + (slash == std::string::npos ? 0 : slash + 1);
    if (route.points().empty() && route.empty()) {
        ImGui::PushStyleColor(ImGuiCol_Text, ui::quiet);
        ImGui::TextWrapped("None. Record a flight, add points one by one, or open a file.");
        ImGui::PopStyleColor();
        return;
    }
    ImGui::PushStyleColor(ImGuiCol_Text, route.unsaved() ? ui::warning_colour : ImGui::GetColorU32(ImGuiCol_Text));
    ImGui::TextWrapped("%s%s", route.unsaved() ? "* " : "", name);
    ImGui::PopStyleColor();
    if (!path.empty()) ui::tip(path.c_str());
    if (route.as_read()) {
        ImGui::PushStyleColor(ImGuiCol_Text, ui::quiet);
        ImGui::TextUnformatted("as in the file; editing converts it to these points");
        ImGui::PopStyleColor();
    }
}

void draw_flight(const State& state, Commands& commands) {
    const Route& route = state.route;
    const bool there = !route.empty();
    if (button(route.playing() ? "Pause" : "Play", "play", there, "Fly along the path, or pause (P)."))
        commands.push(PlayPath{!route.playing()});
    beside("Restart");
    if (button("Restart", "again", there, "Play from the beginning.")) {
        commands.push(SeekPath{0});
        commands.push(PlayPath{true});
    }
    beside("Record");
    if (button(route.recording() ? "Stop recording" : "Record", "record", true,
               "Record the flight as points, which then become the path (R)."))
        commands.push(RecordPath{!route.recording()});
    ImGui::BeginDisabled(!there);
    auto share = static_cast<float>(route.share());
    char text[32];
    std::snprintf(text, sizeof text, "%.1f / %.1f s", route.share() * route.seconds(), route.seconds());
    ImGui::SetNextItemWidth(-FLT_MIN);
    if (ImGui::SliderFloat("##seek", &share, 0, 1, text, ImGuiSliderFlags_NoInput))
        commands.push(SeekPath{static_cast<double>(share)});
    ImGui::EndDisabled();
    ui::mark("path", "seek");
    ui::tip("Position along the path; drag to seek.");
    draw_timeline(state, commands);
    double seconds = route.requested_seconds();
    ImGui::SetNextItemWidth(6.5F * ImGui::GetFontSize());
    if (ImGui::InputDouble("Duration", &seconds, 0, 0, seconds > 0 ? "%.1f s" : "auto",
                           ImGuiInputTextFlags_EnterReturnsTrue) &&
        std::isfinite(seconds))
        commands.push(SetPathSeconds{seconds});
    ui::mark("path", "seconds");
    ui::tip("Duration of the flight in seconds, 1 to 3600; 0: chosen from the terrain's size. Enter applies it.");
    ImGui::SameLine();
    bool loops = route.loops();
    if (ImGui::Checkbox("Loop", &loops)) commands.push(LoopPath{loops});
    ui::mark("path", "loop");
    ui::tip("Starts again at the end.");
}

void draw_point(const Route& route, std::size_t i, Commands& commands) {
    const flight::ControlPoint& p = route.points()[i];
    char text[112];
    std::snprintf(text, sizeof text, "%zu: %.80s", i, place_text(p[0], p[1], p[2]).text);
    ImGui::PushID(static_cast<int>(i));
    if (ImGui::Selectable(text, route.selected() == i)) commands.push(SelectPoint{i});
    char name[24];
    std::snprintf(name, sizeof name, "point.%zu", i);
    ui::mark("path", name);
    ui::tip("Select it, and look from there.");
    ImGui::PopID();
}

void draw_points(const Route& route, Commands& commands) {
    const std::size_t n = route.points().size();
    if (n == 0) return;
    const float line = ImGui::GetTextLineHeightWithSpacing();
    const float height = line * static_cast<float>(std::clamp<std::size_t>(n, 2, 7)) + 4;
    ImGui::BeginChild("points", {0, height}, true);
    ImGuiListClipper clipper;
    clipper.Begin(static_cast<int>(n));
    while (clipper.Step())
        for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i)
            draw_point(route, static_cast<std::size_t>(i), commands);
    ImGui::EndChild();
}

void draw_editing(const State& state, Commands& commands) {
    const Route& route = state.route;
    const std::size_t at = route.selected().value_or(0), n = route.points().size();
    const bool selected = route.selected().has_value();
    if (button("Add", "add", true, "A point where the camera is, after the selected one, or last (N)."))
        commands.push(AddPoint{});
    beside("Replace");
    if (button("Replace", "replace", selected, "Puts the selected point where the camera is."))
        commands.push(ReplacePoint{at});
    beside("Remove");
    if (button("Remove", "remove", selected, "Removes the selected point.")) commands.push(RemovePoint{at});
    beside("Up");
    if (button("Up", "up", selected && at > 0, "Swaps the selected point with the one before."))
        commands.push(MovePoint{at, at - 1});
    beside("Down");
    if (button("Down", "down", selected && at + 1 < n, "Swaps the selected point with the one after."))
        commands.push(MovePoint{at, at + 1});
    if (button("Turntable", "circle", state.scene.open(), "Another path: once around what the camera looks at."))
        commands.push(CirclePath{});
    beside("Look at centre");
    if (button(
            "Look at centre", "aim", n > 0 && state.scene.open(),
            "All points look at the middle between the probe's marks, at its mark, or else at the terrain's middle.")) {
        Vec3 centre{state.scene.width_m() / 2, 0, state.scene.depth_m() / 2};
        if (state.probe.marks > 0) centre = state.probe.mark_m[0];
        if (state.probe.marks > 1) centre = (state.probe.mark_m[0] + state.probe.mark_m[1]) * 0.5;
        commands.push(AimPath{centre.x, centre.z});
    }
    if (button("Open...", "open", true, "A camera path from a file.")) commands.push(ShowDialog{Dialog::open_file});
    beside("Save...");
    if (button("Save...", "save", n >= 2, "The camera path to a file, as control points in metres."))
        commands.push(ShowDialog{Dialog::save_path});
    beside("Clear");
    if (button("Clear", "clear", n > 0, "Removes the path; Restore brings it back.")) commands.push(ClearPath{});
    beside("Restore");
    if (button("Restore", "restore", route.can_restore(), "The path as it was before it was last changed."))
        commands.push(RestorePath{});
}

} // namespace

void draw_path(const State& state, Commands& commands) {
    ui::heading("Camera path");
    draw_name(state.route);
    draw_flight(state, commands);
    draw_points(state.route, commands);
    draw_editing(state, commands);
}

} // namespace fjell::editor
