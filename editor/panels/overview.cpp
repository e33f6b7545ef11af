// The overview with the cameras and the path on it; a click flies there.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <optional>

#include "editor/panels/keyboard.h"
#include "editor/panels/panels.h"

namespace fjell::editor {

namespace {

constexpr ImU32 camera_colour = IM_COL32(255, 235, 90, 255), frozen_colour = IM_COL32(110, 225, 255, 255),
                path_colour = IM_COL32(255, 120, 200, 255), edge = IM_COL32(0, 0, 0, 200);
constexpr std::size_t most_segments = 256; // of the path, however long it is

// The terrain's metres to the overview's pixels.
struct Frame {
    ImVec2 from, size;
    double width_m = 1, depth_m = 1;

    [[nodiscard]] ImVec2 at(double x_m, double z_m) const {
        return {from.x + static_cast<float>(x_m / width_m) * size.x,
                from.y + static_cast<float>(z_m / depth_m) * size.y};
    }
};

// As wide as the column, as high as the terrain is deep; no higher than there is room below, and than half of what the
// column shows.
ImVec2 overview_size(const Scene& scene) {
    const ImVec2 room = ImGui::GetContentRegionAvail();
    const float below = ImGui::GetWindowPos().y + ImGui::GetWindowHeight() - ImGui::GetCursorScreenPos().y -
                        2 * ImGui::GetFrameHeightWithSpacing();
    const float aspect = std::clamp(static_cast<float>(scene.depth_m() / scene.width_m()), 0.05F, 20.0F);
    const float most = std::max(std::min(0.5F * ImGui::GetWindowHeight(), below), 12 * ImGui::GetFontSize());
    const float width = std::max(std::min(room.x, most / aspect), 1.0F);
    return {width, std::max(width * aspect, 1.0F)};
}

void draw_eye(ImDrawList& list, const Frame& frame, const View& view, ImU32 colour) {
    const ImVec2 at = frame.at(view.eye_m.x, view.eye_m.z);
    const float em = ImGui::GetFontSize(), reach = 2.2F * em;
    const double heading = std::atan2(view.forward.x, -view.forward.z);
    const auto rim = [&](double angle) {
        return ImVec2{at.x + reach * static_cast<float>(std::sin(angle)),
                      at.y - reach * static_cast<float>(std::cos(angle))};
    };
    const ImVec2 a = rim(heading + std::atan(view.left)), b = rim(heading + std::atan(view.right));
    list.AddTriangleFilled(at, a, b, (colour & ~IM_COL32_A_MASK) | (90u << IM_COL32_A_SHIFT));
    list.AddTriangle(at, a, b, colour);
    list.AddCircleFilled(at, 0.28F * em, edge);
    list.AddCircleFilled(at, 0.2F * em, colour);
}

void draw_route(ImDrawList& list, const Frame& frame, const Route& route) {
    const float em = ImGui::GetFontSize();
    const auto& poses = route.poses();
    if (!poses.empty()) {
        std::array<ImVec2, most_segments + 1> line;
        const std::size_t n = std::min(poses.size(), line.size());
        for (std::size_t i = 0; i < n; ++i) {
            const Vec3& p = poses[i * (poses.size() - 1) / std::max<std::size_t>(n - 1, 1)].position_m;
            line[i] = frame.at(p.x, p.z);
        }
        list.AddPolyline(line.data(), static_cast<int>(n), edge, 0, 0.26F * em);
        list.AddPolyline(line.data(), static_cast<int>(n), path_colour, 0, 0.13F * em);
    }
    const auto& points = route.points();
    const std::size_t step = points.size() / most_segments + 1;
    std::optional<ImVec2> before; // one that would lie over it is left out
    for (std::size_t i = 0; i < points.size(); i += step) {
        const ImVec2 at = frame.at(points[i][0], points[i][2]);
        if (before && std::hypot(at.x - before->x, at.y - before->y) < 0.5F * em) continue;
        before = at;
        list.AddCircleFilled(at, 0.22F * em, path_colour, 8);
    }
    if (route.selected()) {
        const session::ControlPoint& p = points[*route.selected()];
        list.AddCircle(frame.at(p[0], p[2]), 0.35F * em, IM_COL32_WHITE, 0, 1.5F);
    }
    if (poses.empty()) return;
    const Vec3 at = route.pose().position_m;
    list.AddCircle(frame.at(at.x, at.z), 0.3F * em, path_colour, 0, 1.5F);
}

void draw_tiles(ImDrawList& list, const Frame& frame, const Scene& scene) {
    const ImU32 line = IM_COL32(255, 255, 255, 60);
    if (std::max(scene.tiles_x, scene.tiles_y) > 128) return; // a grey veil
    for (std::uint32_t i = 1; i < scene.tiles_x; ++i) {
        const double x = i * scene.tile_cells * scene.spacing_m[0];
        list.AddLine(frame.at(x, 0), frame.at(x, frame.depth_m), line);
    }
    for (std::uint32_t i = 1; i < scene.tiles_y; ++i) {
        const double z = i * scene.tile_cells * scene.spacing_m[1];
        list.AddLine(frame.at(0, z), frame.at(frame.width_m, z), line);
    }
}

// The point of the path under the pointer; of a closing one and the first, the first.
std::optional<std::size_t> point_on(const Frame& frame, const Route& route) {
    const ImVec2 mouse = ImGui::GetMousePos();
    std::optional<std::size_t> found;
    float nearest = 0.7F * ImGui::GetFontSize();
    for (std::size_t i = 0; i < route.points().size(); ++i) {
        const ImVec2 at = frame.at(route.points()[i][0], route.points()[i][2]);
        const float away = std::max(std::abs(at.x - mouse.x), std::abs(at.y - mouse.y));
        if (away >= nearest) continue;
        nearest = away;
        found = i;
    }
    return found;
}

// A point of the path that was pressed, which follows the mouse. False: the press is none of a point.
bool drag_point_on(MapHand& hand, const Frame& frame, const Route& route, Commands& commands) {
    auto& [point, from, apart, far] = hand;
    const ImVec2 mouse = ImGui::GetMousePos();
    if (ImGui::IsItemActivated()) {
        point = point_on(frame, route);
        far = false;
        if (!point) return false;
        const session::ControlPoint& p = route.points()[*point];
        const ImVec2 at = frame.at(p[0], p[2]);
        from = mouse;
        apart = {at.x - mouse.x, at.y - mouse.y};
        const bool twice = ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left);
        commands.push(SelectPoint{*point, twice});
        return true;
    }
    if (!point) return false;
    const bool ends = ImGui::IsItemDeactivated();
    if (!ends && !ImGui::IsItemActive()) {
        point.reset();
        return false;
    }
    const bool moved = ImGui::GetIO().MouseDelta.x != 0 || ImGui::GetIO().MouseDelta.y != 0;
    far = far || std::max(std::abs(mouse.x - from.x), std::abs(mouse.y - from.y)) > 3;
    if (far && (moved || ends))
        commands.push(
            PlacePoint{*point, static_cast<double>((mouse.x + apart.x - frame.from.x) / frame.size.x) * frame.width_m,
                       static_cast<double>((mouse.y + apart.y - frame.from.y) / frame.size.y) * frame.depth_m, !ends});
    if (ends) point.reset();
    return true;
}

void mark_points(const Frame& frame, const Route& route) {
    if (!ui::recording_marks()) return;
    const std::size_t count = std::min<std::size_t>(route.points().size(), 64);
    for (std::size_t i = 0; i < count; ++i) {
        const ImVec2 at = frame.at(route.points()[i][0], route.points()[i][2]);
        char name[32];
        std::snprintf(name, sizeof name, "point.%zu", i);
        ui::mark_at("map", name, {at.x - 3, at.y - 3, 6, 6});
    }
}

} // namespace

void draw_overview(const State& state, PanelState& own, Commands& commands) {
    const Scene& scene = state.scene;
    Frame frame;
    frame.size = overview_size(scene);
    frame.from = ImGui::GetCursorScreenPos();
    frame.from.x += std::max(0.0F, (ImGui::GetContentRegionAvail().x - frame.size.x) / 2);
    frame.width_m = scene.width_m();
    frame.depth_m = scene.depth_m();
    ImGui::SetCursorScreenPos(frame.from);
    {
        const keyboard::PointerOnly by_hand; // keys give the camera's place in its fields
        ImGui::InvisibleButton("map", frame.size);
    }
    ui::mark("map", "overview");
    const ImVec2 high{frame.from.x + frame.size.x, frame.from.y + frame.size.y};
    ImDrawList& list = *ImGui::GetWindowDrawList();
    if (state.overview.texture != 0)
        list.AddImage(reinterpret_cast<ImTextureID>(static_cast<std::uintptr_t>(state.overview.texture)), frame.from,
                      high);
    else
        list.AddRectFilled(frame.from, high, IM_COL32(40, 44, 52, 255));
    list.PushClipRect(frame.from, high, true);
    if (state.shows(Overlay::tile_borders)) draw_tiles(list, frame, scene);
    draw_route(list, frame, state.route);
    draw_heat(state, list, frame.from, frame.size);
    if (state.eye.refining) draw_eye(list, frame, *state.eye.refining, frozen_colour);
    draw_eye(list, frame, state.eye.view, camera_colour);
    mark_points(frame, state.route);
    const std::optional<std::size_t> under =
        ImGui::IsItemHovered() ? point_on(frame, state.route) : std::optional<std::size_t>();
    if (under) {
        const session::ControlPoint& p = state.route.points()[*under];
        list.AddCircle(frame.at(p[0], p[2]), 0.45F * ImGui::GetFontSize(), path_colour, 0, 2);
        ImGui::SetMouseCursor(ImGuiMouseCursor_Hand);
    }
    list.PopClipRect();
    if (drag_point_on(own.map, frame, state.route, commands)) return;
    if (ImGui::IsItemActive()) {
        const ImVec2 mouse = ImGui::GetMousePos();
        const JumpTo jump{static_cast<double>((mouse.x - frame.from.x) / frame.size.x) * frame.width_m,
                          static_cast<double>((mouse.y - frame.from.y) / frame.size.y) * frame.depth_m};
        // Held still it asks for nothing.
        if (ImGui::IsItemActivated() || ImGui::GetIO().MouseDelta.x != 0 || ImGui::GetIO().MouseDelta.y != 0)
            commands.push(jump);
    } else if (!under) {
        ui::tip("Click, or drag, to fly there at the same height above the ground. Yellow: the camera; blue: the "
                "frozen camera; pink: the path.");
    } else if (ui::begin_tip()) {
        ImGui::Text(
            "Point %zu. Drag: move it at the same height above the ground. Click: select it; twice: look from there.",
            *under);
        ui::end_tip();
    }
}

} // namespace fjell::editor
