// What is taken hold of in the picture instead of the camera: points of the path, and with L the sun.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <optional>

#include "editor/panels/panels.h"
#include "flight/profile_keys.h"

namespace fjell::editor {

namespace {

constexpr double sun_deg_a_pixel = 0.25;
constexpr float drag_begins_px = 4;
constexpr std::size_t most_looked_at = 2000; // points, in every frame and not only when the button is pressed

struct Held {
    std::optional<std::size_t> point; // of the path
    ImVec2 apart;                     // from the pointer to it, when it was taken
    double height_m = 0;              // that it keeps while it is moved level
    bool moved = false;
    const flight::ProfileKey* key = nullptr; // of the sun
    double value = 0;                        // of the key, when it was taken
    bool sun = false;                        // taken, but whether along or across is not clear yet
};
Held taken;

// Where a point of the path is in the window; none: behind the eye.
std::optional<ImVec2> seen_at(const State& state, const ui::Rect& view, std::size_t point) {
    const flight::ControlPoint& p = state.route.points()[point];
    const auto place = place_in(state.eye.view, {p[0], p[1], p[2]});
    if (!place) return {};
    return ImVec2{view.x + static_cast<float>((*place)[0]) * view.width,
                  view.y + static_cast<float>((*place)[1]) * view.height};
}

// The point that lies under the pointer, the nearest to the eye of several.
std::optional<std::size_t> point_under(const State& state, const ui::Rect& view) {
    if (!state.shows(Overlay::path) || state.route.playing() || state.probe.on) return {};
    const ImVec2 mouse = ImGui::GetIO().MousePos;
    const auto& points = state.route.points();
    std::optional<std::size_t> found;
    double nearest_m = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto at = seen_at(state, view, i);
        if (!at || std::hypot(at->x - mouse.x, at->y - mouse.y) > 0.8F * ImGui::GetFontSize()) continue;
        const double away_m = length(Vec3{points[i][0], points[i][1], points[i][2]} - state.eye.view.eye_m);
        if (found && away_m >= nearest_m) continue;
        found = i;
        nearest_m = away_m;
    }
    return found;
}

void take_point(const State& state, const ui::Rect& view, std::size_t point, Commands& commands) {
    const ImVec2 at = *seen_at(state, view, point), mouse = ImGui::GetIO().MousePos;
    taken.apart = {at.x - mouse.x, at.y - mouse.y};
    taken.height_m = state.route.points()[point][1];
    const bool twice = ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left);
    commands.push(SelectPoint{point, twice});
    if (!twice) taken.point = point; // otherwise the view jumps from under the hand
}

// Under the pointer: at the height that it has or, with Shift, over the place that it has.
void drag_point(const State& state, const ui::Rect& view, bool ends, Commands& commands) {
    const auto& points = state.route.points();
    if (*taken.point >= points.size()) return;
    const flight::ControlPoint& p = points[*taken.point];
    const Vec3 at{p[0], p[1], p[2]}, eye = state.eye.view.eye_m;
    const ImVec2 mouse{ImGui::GetIO().MousePos.x + taken.apart.x, ImGui::GetIO().MousePos.y + taken.apart.y};
    const Vec3 way = normalised(direction_at(state.eye.view, static_cast<double>((mouse.x - view.x) / view.width),
                                             static_cast<double>((mouse.y - view.y) / view.height)));
    const bool upright = ImGui::GetIO().KeyShift;
    PlacePoint place{*taken.point, p[0], p[2], !ends, upright ? p[1] : taken.height_m};
    // The plane through it that is level, or upright and across the view.
    const Vec3 forward = state.eye.view.forward, up = state.eye.view.up;
    const double sense = forward.y < 0 ? 1 : -1; // straight down or up it is the picture's upper edge that lies ahead
    const Vec3 ahead{forward.x + sense * up.x, 0, forward.z + sense * up.z};
    const Vec3 across = upright ? ahead : Vec3{0, 1, 0};
    const double along = dot(way, across);
    const double height_m = upright ? at.y : taken.height_m;
    const double reach_m = along == 0 ? -1 : dot(Vec3{at.x, height_m, at.z} - eye, across) / along;
    // Towards the horizon that plane is met nowhere, or behind the eye.
    if (reach_m > 0 && reach_m < 2 * (state.scene.width_m() + state.scene.depth_m())) {
        const Vec3 there = eye + way * reach_m;
        if (upright)
            place.y_m = taken.height_m = there.y;
        else
            place.x_m = there.x, place.z_m = there.z;
    }
    commands.push(place);
}

// What a point that could be taken, or is, does: below the picture's middle, where it hides nothing that is aimed at.
void explain_point(const ui::Rect& view, std::size_t point, ImVec2 at) {
    char text[160];
    std::snprintf(
        text, sizeof text,
        "Point %zu. Drag: move it level; with Shift: up and down. Click twice: look from there. Delete: remove it.",
        point);
    const float em = ImGui::GetFontSize();
    const ImVec2 size = ImGui::CalcTextSize(text), pad{0.6F * em, 0.3F * em};
    const ImVec2 from{view.x + std::max((view.width - size.x) / 2 - pad.x, 0.0F),
                      view.y + view.height - size.y - 2 * pad.y - 0.6F * em};
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    list.PushClipRect({view.x, view.y}, {view.x + view.width, view.y + view.height});
    list.AddCircle(at, 0.8F * em, IM_COL32_WHITE, 0, 1.5F);
    list.AddRectFilled(from, {from.x + size.x + 2 * pad.x, from.y + size.y + 2 * pad.y}, IM_COL32(12, 14, 18, 205),
                       0.25F * em);
    list.AddText({from.x + pad.x, from.y + pad.y}, IM_COL32_WHITE, text);
    list.PopClipRect();
}

void mark_points_in(const State& state, const ui::Rect& view) {
    if (!ui::recording_marks() || !state.shows(Overlay::path)) return;
    const std::size_t count = std::min<std::size_t>(state.route.points().size(), 64);
    for (std::size_t i = 0; i < count; ++i) {
        const auto at = seen_at(state, view, i);
        if (!at) continue;
        char name[32];
        std::snprintf(name, sizeof name, "point.%zu", i);
        ui::mark_at("view", name, {at->x - 4, at->y - 4, 8, 8});
    }
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
    mark_points_in(state, view);
    auto under = taken.point;
    if (!under && state.route.points().size() <= most_looked_at) under = point_under(state, view);
    if (ImGui::IsMouseClicked(ImGuiMouseButton_Left)) {
        taken = {};
        if (io.KeysDown[static_cast<int>('L')] && !io.WantTextInput)
            taken.sun = true;
        else if (const auto point = point_under(state, view))
            take_point(state, view, *point, commands);
    }
    if (under && *under < state.route.points().size() && !taken.sun)
        if (const auto at = seen_at(state, view, *under)) {
            explain_point(view, *under, *at);
            ImGui::SetMouseCursor(ImGuiMouseCursor_Hand);
        }
    const bool ends = ImGui::IsMouseReleased(ImGuiMouseButton_Left);
    if (!taken.sun && !taken.point) return false;
    if (!ends && !ImGui::IsMouseDown(ImGuiMouseButton_Left)) { // let go outside the window
        taken = {};
        return false;
    }
    if (taken.sun) {
        if (!ends || taken.key != nullptr) drag_sun(state, ends, commands);
    } else {
        const ImVec2 moved = ImGui::GetMouseDragDelta(ImGuiMouseButton_Left, 0);
        taken.moved = taken.moved || std::max(std::abs(moved.x), std::abs(moved.y)) >= drag_begins_px;
        if (taken.moved && (ends || io.MouseDelta.x != 0 || io.MouseDelta.y != 0))
            drag_point(state, view, ends, commands);
    }
    if (ends) taken = {};
    return true;
}

} // namespace fjell::editor
