// The camera's path: played, recorded, laid and edited.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "editor/number_text.h"
#include "editor/panels/keyboard.h"
#include "editor/panels/panels.h"

namespace fjell::editor {

namespace {

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
        ImGui::TextUnformatted("as in the file; an edit converts it to these points");
        ImGui::PopStyleColor();
    }
}

void draw_flight(const State& state, Commands& commands) {
    const Route& route = state.route;
    const bool there = !route.empty();
    if (ui::panel_button(route.playing() ? "Pause" : "Play", "path", "play", there,
                         "Flies along the path, or pauses (P)."))
        commands.push(PlayPath{!route.playing()});
    ui::beside("Restart");
    if (ui::panel_button("Restart", "path", "again", there, "Plays from the beginning.")) {
        commands.push(SeekPath{0});
        commands.push(PlayPath{true});
    }
    ui::beside("Record");
    if (ui::panel_button(route.recording() ? "Stop recording" : "Record", "path", "record", true,
                         "Records the flight as points, which then become the path (R)."))
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
    ui::tip("Position along the path; drag to move along it.");
    draw_timeline(state, commands);
    double seconds = route.requested_seconds();
    ImGui::SetNextItemWidth(6.5F * ImGui::GetFontSize());
    if (ImGui::InputDouble("Duration", &seconds, 0, 0, seconds > 0 ? "%.1f s" : "auto",
                           ImGuiInputTextFlags_EnterReturnsTrue) &&
        std::isfinite(seconds))
        commands.push(SetPathSeconds{seconds});
    ui::mark("path", "seconds");
    ui::tip("Duration of the flight in seconds, 1 to 3,600; 0: a "
            "duration chosen from the terrain's size. Enter applies it.");
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
    ui::tip("Selects this point, and looks from there.");
    ImGui::PopID();
}

void draw_points(const Route& route, Commands& commands) {
    const std::size_t n = route.points().size();
    if (n == 0) return;
    const float line = ImGui::GetTextLineHeightWithSpacing();
    const float height = line * static_cast<float>(std::clamp<std::size_t>(n, 2, 7)) + 4;
    ImGui::BeginChild("points", {0, height}, true, ImGuiWindowFlags_NavFlattened);
    ImGuiListClipper clipper;
    clipper.Begin(static_cast<int>(n));
    while (clipper.Step())
        for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i)
            draw_point(route, static_cast<std::size_t>(i), commands);
    ImGui::EndChild();
}

} // namespace

void draw_path(const State& state, Commands& commands) {
    ui::heading("Camera path");
    draw_name(state.route);
    draw_flight(state, commands);
    draw_points(state.route, commands);
    draw_path_edits(state, commands);
}

} // namespace fjell::editor
