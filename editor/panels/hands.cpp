// What is taken hold of in the picture instead of the camera: points of the path, and with L the sun.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "editor/panels/panels.h"
#include "flight/profile_keys.h"

namespace fjell::editor {

namespace {

constexpr double sun_deg_a_pixel = 0.25;
constexpr float drag_begins_px = 4;

struct Held {
    std::optional<std::size_t> point;        // of the path
    const flight::ProfileKey* key = nullptr; // of the sun
    double value = 0;                        // of the key, when it was taken
    bool sun = false;                        // taken, but whether along or across is not clear yet
};
Held taken;

// The point that lies under the pointer, the nearest to the eye of several.
std::optional<std::size_t> point_under(const State& state, const ui::Rect& view) {
    if (!state.shows(Overlay::path) || state.route.playing()) return {};
    const ImVec2 mouse = ImGui::GetIO().MousePos;
    const auto& points = state.route.points();
    std::optional<std::size_t> found;
    double nearest_m = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Vec3 at{points[i][0], points[i][1], points[i][2]};
        const auto place = place_in(state.eye.view, at);
        if (!place) continue;
        const double x = static_cast<double>(view.x) + (*place)[0] * static_cast<double>(view.width);
        const double y = static_cast<double>(view.y) + (*place)[1] * static_cast<double>(view.height);
        const double away = std::hypot(x - static_cast<double>(mouse.x), y - static_cast<double>(mouse.y));
        const double away_m = length(at - state.eye.view.eye_m);
        if (away > static_cast<double>(0.8F * ImGui::GetFontSize()) || (found && away_m >= nearest_m)) continue;
        found = i;
        nearest_m = away_m;
    }
    return found;
}

// Under the pointer, at the height that it has.
void drag_point(const State& state, const ui::Rect& view, bool ends, Commands& commands) {
    const auto& points = state.route.points();
    if (*taken.point >= points.size()) return;
    const flight::ControlPoint& p = points[*taken.point];
    const ImVec2 mouse = ImGui::GetIO().MousePos;
    const Vec3 eye = state.eye.view.eye_m;
    const Vec3 way = direction_at(state.eye.view, static_cast<double>((mouse.x - view.x) / view.width),
                                  static_cast<double>((mouse.y - view.y) / view.height));
    const double reach = way.y == 0 ? -1 : (p[1] - eye.y) / way.y;
    PlacePoint place{*taken.point, p[0], p[2], !ends};
    // Towards the horizon that height is met nowhere, or behind the eye.
    if (reach > 0 && reach * length(way) < 2 * (state.scene.width_m() + state.scene.depth_m())) {
        place.x_m = eye.x + way.x * reach;
        place.z_m = eye.z + way.z * reach;
    }
    commands.push(place);
}

// Across: around; along: up and down. By the clock there is only the hour.
void drag_sun(const State& state, bool ends, Commands& commands) {
    const ImVec2 moved = ImGui::GetMouseDragDelta(ImGuiMouseButton_Left, 0);
    const flight::Profile& profile = state.document.profile();
    const bool by_time = profile.light.sun == gl::SunBy::time;
    if (taken.key == nullptr) {
        if (std::max(std::abs(moved.x), std::abs(moved.y)) < drag_begins_px) return;
        const bool across = std::abs(moved.x) >= std::abs(moved.y);
        taken.key = flight::find_profile_key(by_time  ? "light.hour_utc"
                                             : across ? "light.azimuth_deg"
                                                      : "light.elevation_deg");
        taken.value = taken.key->get(profile);
    }
    const bool up = taken.key == flight::find_profile_key("light.elevation_deg");
    double value = taken.value + sun_deg_a_pixel * static_cast<double>(up ? -moved.y : moved.x) * (by_time ? 0.1 : 1);
    const double turn = by_time ? 24 : 360;
    value = up ? std::clamp(value, taken.key->least, taken.key->most) : value - turn * std::floor(value / turn);
    commands.push(SetKey{taken.key, std::min(value, taken.key->most), !ends});
}

} // namespace

bool draw_hands(const State& state, const ui::Rect& view, Commands& commands) {
    const ImGuiIO& io = ImGui::GetIO();
    if (ImGui::IsMouseClicked(ImGuiMouseButton_Left)) {
        taken = {};
        if (io.KeysDown[static_cast<int>('L')] && !io.WantTextInput)
            taken.sun = true;
        else if (!state.probe.on)
            taken.point = point_under(state, view);
    }
    const bool ends = ImGui::IsMouseReleased(ImGuiMouseButton_Left);
    if (!taken.sun && !taken.point) return false;
    if (!ends && !ImGui::IsMouseDown(ImGuiMouseButton_Left)) { // let go outside the window
        taken = {};
        return false;
    }
    if (taken.sun) {
        if (!ends || taken.key != nullptr) drag_sun(state, ends, commands);
    } else if (ImGui::IsMouseDragging(ImGuiMouseButton_Left, drag_begins_px) ||
               (ends && io.MouseDragMaxDistanceSqr[0] >= drag_begins_px * drag_begins_px)) {
        if (ends || io.MouseDelta.x != 0 || io.MouseDelta.y != 0) drag_point(state, view, ends, commands);
    } else if (ends) {
        commands.push(SelectPoint{*taken.point});
    }
    if (ends) taken = {};
    return true;
}

} // namespace fjell::editor
