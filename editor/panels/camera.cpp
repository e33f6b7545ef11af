// Where the camera is, how it moves, the map, and the camera's path.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "editor/panels/panels.h"

namespace fjell::editor {

namespace {

constexpr double degree = std::numbers::pi / 180;

// A number under its name; true when another one was given. ImGui keeps what is being typed.
bool number(const char* name, double& value, const char* format, const char* about) {
    ImGui::PushID(name);
    ImGui::SetNextItemWidth(-FLT_MIN);
    const bool given = ImGui::InputDouble("##value", &value, 0, 0, format, ImGuiInputTextFlags_EnterReturnsTrue) &&
                       std::isfinite(value);
    ui::mark("camera", name);
    ui::tip(about);
    ImGui::PopID();
    return given;
}

void labelled(const char* label) {
    ImGui::AlignTextToFramePadding();
    ImGui::TextUnformatted(label);
    ImGui::SameLine(6.2F * ImGui::GetFontSize());
}

void draw_place(const State& state, Commands& commands) {
    const flight::FreeCamera& c = state.eye.free;
    PlaceCamera place{c.position_m, c.heading, c.pitch};
    double heading = std::fmod(c.heading / degree + 360, 360), pitch = c.pitch / degree;
    double above = c.position_m.y - state.eye.ground_m;
    bool given = false;
    labelled("East");
    given |= number("x", place.position_m.x, "%.1f m", "Metres east of the terrain's first sample. Enter applies it.");
    labelled("South");
    given |= number("z", place.position_m.z, "%.1f m", "Metres south of the terrain's first sample. Enter applies it.");
    labelled("Height");
    given |=
        number("y", place.position_m.y, "%.1f m", "Metres above height 0; never below the ground. Enter applies it.");
    labelled("Above ground");
    if (number("above", above, "%.1f m", "Metres above the ground under the camera. Enter applies it.")) {
        place.position_m.y = state.eye.ground_m + above;
        given = true;
    }
    labelled("Heading");
    given |= number("heading", heading, "%.1f deg", "Degrees clockwise from north. Enter applies it.");
    labelled("Pitch");
    given |= number("pitch", pitch, "%.1f deg", "Degrees up from the horizon, -86 to 86. Enter applies it.");
    if (!given) return;
    place.heading_rad = heading * degree;
    place.pitch_rad = pitch * degree;
    commands.push(place);
}

void draw_navigation(const State& state, Commands& commands) {
    constexpr const char* names[] = {"Fly", "Orbit", "Path"};
    constexpr const char* abouts[] = {
        "W, A, S, D, Q and E move, dragging looks around, the wheel sets the speed (1).",
        "Dragging orbits the ground in the middle of the picture, the wheel zooms, right drag pans (2).",
        "Follows the camera path (3)."};
    for (int i = 0; i < 3; ++i) {
        const auto navigation = static_cast<Navigation>(i);
        if (i > 0) ImGui::SameLine();
        if (ImGui::RadioButton(names[i], state.eye.navigation == navigation)) commands.push(SetNavigation{navigation});
        ui::mark("navigate", navigation_names[i]);
        ui::tip(abouts[i]);
    }
    ImGui::SameLine();
    if (ImGui::Button("View all")) commands.push(ViewAll{});
    ui::mark("camera", "home");
    ui::tip("Look at the whole terrain from the south (Home).");
    labelled("Speed");
    double speed = state.eye.free.speed_m_s;
    const double least = 0.1, most = std::max(1000.0, 0.2 * std::max(state.scene.width_m(), state.scene.depth_m()));
    ImGui::SetNextItemWidth(-FLT_MIN);
    if (ImGui::SliderScalar("##speed", ImGuiDataType_Double, &speed, &least, &most,
                            speed < 1000 ? "%.4g m/s" : "%.0f m/s", ImGuiSliderFlags_Logarithmic))
        commands.push(SetSpeed{speed});
    ui::mark("camera", "speed");
    ui::tip("Flying speed in metres per second; with Shift five times as fast. The wheel over the picture changes it "
            "too; Ctrl+click to type a value.");
    bool frozen = state.eye.frozen;
    if (ImGui::Checkbox("Freeze refinement (F)", &frozen)) commands.push(FreezeRefinement{frozen});
    ui::mark("camera", "freeze");
    ui::tip("The mesh stays refined and culled for the current camera while you look at it from elsewhere. The "
            "overview shows both cameras.");
}

} // namespace

void draw_camera(const State& state, Commands& commands) {
    if (!state.scene.open()) {
        ImGui::TextWrapped("No terrain is open.");
        return;
    }
    draw_navigation(state, commands);
    draw_overview(state, commands);
    draw_path(state, commands);
    ui::heading("Position");
    draw_place(state, commands);
}

} // namespace fjell::editor
