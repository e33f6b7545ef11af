// Where the camera is, how it moves, the map, and the camera's path.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "editor/panels/panels.h"
#include "editor/strings.h"

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
    labelled(strings::camera::east);
    given |= number("x", place.position_m.x, "%.1f m", strings::camera::about_east);
    labelled(strings::camera::south);
    given |= number("z", place.position_m.z, "%.1f m", strings::camera::about_south);
    labelled(strings::camera::height);
    given |= number("y", place.position_m.y, "%.1f m", strings::camera::about_height);
    labelled(strings::camera::above_ground);
    if (number("above", above, "%.1f m", strings::camera::about_above_ground)) {
        place.position_m.y = state.eye.ground_m + above;
        given = true;
    }
    labelled(strings::camera::heading);
    given |= number("heading", heading, "%.1f deg", strings::camera::about_heading);
    labelled(strings::camera::pitch);
    given |= number("pitch", pitch, "%.1f deg", strings::camera::about_pitch);
    if (!given) return;
    place.heading_rad = heading * degree;
    place.pitch_rad = pitch * degree;
    commands.push(place);
}

void draw_navigation(const State& state, Commands& commands) {
    constexpr const char* names[] = {strings::common::fly, strings::common::orbit, strings::camera::path};
    constexpr const char* abouts[] = {strings::camera::about_fly, strings::camera::about_orbit,
                                      strings::camera::about_path};
    for (int i = 0; i < 3; ++i) {
        const auto navigation = static_cast<Navigation>(i);
        if (i > 0) ImGui::SameLine();
        if (ImGui::RadioButton(names[i], state.eye.navigation == navigation)) commands.push(SetNavigation{navigation});
        ui::mark("navigate", navigation_names[i]);
        ui::tip(abouts[i]);
    }
    ImGui::SameLine();
    if (ImGui::Button(strings::camera::view_all)) commands.push(ViewAll{});
    ui::mark("camera", "home");
    ui::tip(strings::camera::about_view_all);
    labelled(strings::camera::speed);
    double speed = state.eye.free.speed_m_s;
    const double least = 0.1, most = std::max(1000.0, 0.2 * std::max(state.scene.width_m(), state.scene.depth_m()));
    ImGui::SetNextItemWidth(-FLT_MIN);
    if (ImGui::SliderScalar("##speed", ImGuiDataType_Double, &speed, &least, &most,
                            speed < 1000 ? "%.4g m/s" : "%.0f m/s", ImGuiSliderFlags_Logarithmic))
        commands.push(SetSpeed{speed});
    ui::mark("camera", "speed");
    ui::tip(strings::camera::about_speed);
    bool frozen = state.eye.frozen;
    if (ImGui::Checkbox(strings::camera::freeze, &frozen)) commands.push(FreezeRefinement{frozen});
    ui::mark("camera", "freeze");
    ui::tip(strings::camera::about_freeze);
}

} // namespace

void draw_camera(const State& state, Commands& commands) {
    if (!state.scene.open()) {
        ImGui::TextWrapped(strings::common::no_terrain_is_open);
        return;
    }
    draw_navigation(state, commands);
    draw_overview(state, commands);
    draw_path(state, commands);
    ui::heading(strings::camera::position);
    draw_place(state, commands);
}

} // namespace fjell::editor
