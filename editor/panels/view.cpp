// Keys, mouse and hands over the picture, the probe, and what is written over it.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <numbers>
#include <optional>

#include "editor/number_text.h"
#include "editor/panels/panels.h"
#include "fjell/profile/keys.h"

namespace fjell::editor {

namespace {

constexpr double sun_deg_a_pixel = 0.25;
constexpr float drag_begins_px = 4;
constexpr std::size_t most_looked_at = 2000; // points, in every frame and not only when the button is pressed

// Where a point of the path is in the window; none: behind the eye.
std::optional<ImVec2> seen_at(const State& state, const ui::Rect& view, std::size_t point) {
    const session::ControlPoint& p = state.route.points()[point];
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

void take_point(PictureHand& taken, const State& state, const ui::Rect& view, std::size_t point, Commands& commands) {
    const ImVec2 at = *seen_at(state, view, point), mouse = ImGui::GetIO().MousePos;
    taken.apart = {at.x - mouse.x, at.y - mouse.y};
    taken.height_m = state.route.points()[point][1];
    const bool twice = ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left);
    commands.push(SelectPoint{point, twice});
    if (!twice) taken.point = point; // otherwise the view jumps from under the hand
}

// Under the pointer: at the height that it has or, with Shift, over the place that it has.
void drag_point(PictureHand& taken, const State& state, const ui::Rect& view, bool ends, Commands& commands) {
    const auto& points = state.route.points();
    if (*taken.point >= points.size()) return;
    const session::ControlPoint& p = points[*taken.point];
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
void drag_sun(PictureHand& taken, const State& state, bool ends, Commands& commands) {
    const ImVec2 moved = ImGui::GetMouseDragDelta(ImGuiMouseButton_Left, 0);
    const Profile& profile = state.document.profile();
    const bool by_time = profile.light.sun == gl::SunBy::time;
    if (taken.key == nullptr) {
        if (std::max(std::abs(moved.x), std::abs(moved.y)) < drag_begins_px) return;
        const bool across = std::abs(moved.x) >= std::abs(moved.y);
        taken.key = find_profile_key(by_time ? "light.hour_utc" : across ? "light.azimuth_deg" : "light.elevation_deg");
        taken.value = taken.key->get(profile);
    }
    const bool up = taken.key == find_profile_key("light.elevation_deg");
    double value = taken.value + sun_deg_a_pixel * static_cast<double>(up ? -moved.y : moved.x) * (by_time ? 0.1 : 1);
    const double turn = by_time ? 24 : 360;
    value = up ? std::clamp(value, taken.key->least, taken.key->most) : value - turn * std::floor(value / turn);
    commands.push(SetKey{taken.key, std::min(value, taken.key->most), !ends});
}

// Points of the path, and the sun with L, follow the mouse. True: it is not the camera's.
bool draw_hands(const State& state, const ui::Rect& view, PictureHand& taken, Commands& commands) {
    const ImGuiIO& io = ImGui::GetIO();
    mark_points_in(state, view);
    auto under = taken.point;
    if (!under && state.route.points().size() <= most_looked_at) under = point_under(state, view);
    if (ImGui::IsMouseClicked(ImGuiMouseButton_Left)) {
        taken = {};
        if (io.KeysDown[static_cast<int>('L')] && !io.WantTextInput)
            taken.sun = true;
        else if (const auto point = point_under(state, view))
            take_point(taken, state, view, *point, commands);
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
        if (!ends || taken.key != nullptr) drag_sun(taken, state, ends, commands);
    } else {
        const ImVec2 moved = ImGui::GetMouseDragDelta(ImGuiMouseButton_Left, 0);
        taken.moved = taken.moved || std::max(std::abs(moved.x), std::abs(moved.y)) >= drag_begins_px;
        if (taken.moved && (ends || io.MouseDelta.x != 0 || io.MouseDelta.y != 0))
            drag_point(taken, state, view, ends, commands);
    }
    if (ends) taken = {};
    return true;
}

} // namespace

// --- What the probe knows, in the picture's corner, and where it was measured: drawn over the picture, and no window,
// so that the mouse goes through it.

namespace {

constexpr ImU32 paper = IM_COL32(12, 14, 18, 215), mark_colour = IM_COL32(255, 214, 102, 255),
                shadow = IM_COL32(0, 0, 0, 200);

// Lines of text from the top down, each label with its value beside it.
class Rows {
public:
    Rows(ImDrawList& list, ImVec2 at, float values) : list_(list), at_(at), values_(values) {}
    void row(const char* label, const char* value, ImU32 colour = IM_COL32_WHITE) {
        list_.AddText(at_, ui::quiet, label);
        list_.AddText({at_.x + values_, at_.y}, colour, value);
        at_.y += 1.3F * ImGui::GetFontSize();
    }
    void line(const char* text, float wrap_width = 0) {
        list_.AddText(nullptr, 0, at_, ui::quiet, text, nullptr, wrap_width);
        at_.y += 1.3F * ImGui::GetFontSize();
    }
    [[nodiscard]] float y() const { return at_.y; }
    void skip(float height) { at_.y += height; }

private:
    ImDrawList& list_;
    ImVec2 at_;
    float values_;
};

// Where it is in the terrain's CRS, to a tenth of its unit, and in degrees.
void coordinate_rows(const State& state, const ProbedGround& g, Rows& rows) {
    const baker::Coordinates& c = *state.scene.coordinates;
    char text[120];
    if (c.projected()) {
        const auto [east, north] = c.in_crs(g.position_m.x, g.position_m.z);
        std::snprintf(text, sizeof text, "%.1f, %.1f %.20s", east, north, c.unit().c_str());
        rows.row("East, north", text);
    }
    if (c.datum().empty()) return;
    if (g.degrees)
        std::snprintf(text, sizeof text, "%.6f, %.6f (%.24s)", (*g.degrees)[0], (*g.degrees)[1], c.datum().c_str());
    else
        std::snprintf(text, sizeof text, "not known here");
    rows.row("Lat., lon.", text);
}
// How many rows these are.
int coordinate_rows(const State& state) {
    const baker::Coordinates& c = *state.scene.coordinates;
    return (c.projected() ? 1 : 0) + (c.datum().empty() ? 0 : 1);
}

void ground_rows(const State& state, Rows& rows) {
    char text[96];
    const ProbedGround& g = *state.probe.ground;
    rows.row("Place", place_text(g.position_m.x, g.position_m.y, g.position_m.z).text);
    coordinate_rows(state, g, rows);
    std::snprintf(text, sizeof text, "%.20s m away", metre_text(g.distance_m).text);
    rows.row("Distance", text);
    std::snprintf(text, sizeof text, "%.0f deg", g.slope_rad * 180 / std::numbers::pi);
    rows.row("Slope", text);
    std::snprintf(text, sizeof text, "%d, %d: tile %u, %u, page %u", g.sample.column, g.sample.row, g.tile_x, g.tile_y,
                  g.page);
    rows.row("Sample", text);
    if (g.finest)
        std::snprintf(text, sizeof text, "full resolution, within %.3g m", g.error_m);
    else
        std::snprintf(text, sizeof text, "within %.3g m: pages missing", g.error_m);
    rows.row("Ground", text, g.finest ? IM_COL32_WHITE : ui::warning_colour);
    if (!g.mesh) return rows.row("Mesh", state.probe.looking ? "..." : "nothing is drawn here");
    std::snprintf(text, sizeof text, "level %d, off by %.2f m: %.2f px", g.mesh->level,
                  std::abs(g.mesh->height_m - g.position_m.y), g.mesh->error_px);
    rows.row("Mesh", text);
}

void draw_profile(const HeightProfile& p, const ui::Rect& at, ImDrawList& list) {
    const double most = static_cast<double>(p.highest_m), least = static_cast<double>(p.lowest_m);
    const double range = std::max(most - least, 1e-3);
    std::array<ImVec2, HeightProfile::samples> points;
    for (std::size_t i = 0; i < p.samples; ++i) {
        const auto share = static_cast<float>((static_cast<double>(p.height_m[i]) - least) / range);
        points[i] = {at.x + at.width * static_cast<float>(i) / (HeightProfile::samples - 1),
                     at.y + at.height * (1 - share)};
    }
    list.AddRectFilled({at.x, at.y}, {at.x + at.width, at.y + at.height}, IM_COL32(28, 31, 37, 255));
    for (std::size_t i = 1; i < p.samples; ++i)
        list.AddQuadFilled({points[i - 1].x, at.y + at.height}, points[i - 1], points[i],
                           {points[i].x, at.y + at.height}, IM_COL32(255, 214, 102, 60));
    list.AddPolyline(points.data(), static_cast<int>(p.samples), mark_colour, 0, 1.5F);
}

void profile_rows(const Probe& probe, Rows& rows) {
    char text[96];
    const HeightProfile& p = probe.profile;
    const double rise_m = probe.mark_m[probe.marks - 1].y - probe.mark_m[0].y;
    const auto metres = [&](const char* label, double m) {
        std::snprintf(text, sizeof text, "%.20s m", metre_text(m).text);
        rows.row(label, text, mark_colour);
    };
    metres("Distance", p.length_m);
    metres("On ground", p.ground_length_m);
    if (probe.marks > 2) {
        rows.row("Area", area_text(p.area_m2).text, mark_colour);
        rows.row("Of ground", area_text(p.ground_area_m2).text, mark_colour);
    }
    std::snprintf(text, sizeof text, "1 to %zu: %.20s m %s", probe.marks, metre_text(std::abs(rise_m)).text,
                  rise_m < 0 ? "down" : "up");
    rows.row("Rise", text);
    std::snprintf(text, sizeof text, "%.20s to %.20s m", metre_text(static_cast<double>(p.lowest_m)).text,
                  metre_text(static_cast<double>(p.highest_m)).text);
    rows.row("Heights", text);
}

// Positions in the picture, in pixels of the window.
struct Picture {
    const View& view;
    const ui::Rect& rect;
    [[nodiscard]] std::optional<ImVec2> at(const Vec3& position_m) const {
        const auto place = place_in(view, position_m);
        if (!place) return {};
        return ImVec2{rect.x + static_cast<float>((*place)[0]) * rect.width,
                      rect.y + static_cast<float>((*place)[1]) * rect.height};
    }
};

// The line over the ground from mark to mark, whether something stands before it or not, and the marks.
void draw_marks(const Probe& probe, const Picture& picture, const ui::Rect& plate, ImDrawList& list) {
    const float em = ImGui::GetFontSize();
    if (probe.marks >= 2) {
        const HeightProfile& p = probe.profile;
        std::optional<ImVec2> before;
        for (std::size_t i = 0; i < p.samples; ++i) {
            const auto now = picture.at({p.place_m[i][0], static_cast<double>(p.height_m[i]), p.place_m[i][1]});
            if (before && now) list.AddLine(*before, *now, mark_colour, std::max(1.0F, em / 8));
            before = now;
        }
    }
    for (std::size_t i = 0; i < probe.marks; ++i) {
        const auto at = picture.at(probe.mark_m[i]);
        if (!at) continue;
        list.AddCircleFilled(*at, 0.35F * em, shadow);
        list.AddCircleFilled(*at, 0.25F * em, mark_colour);
        if (at->x < plate.x + plate.width && at->y < plate.y + plate.height) continue; // which covers its number
        // Of marks that lie together the first one has a number: two would be read as one.
        const auto hides = [&](const Vec3& other) {
            const auto there = picture.at(other);
            return there && std::abs(there->x - at->x) < 1.5F * em && std::abs(there->y - at->y) < em;
        };
        if (std::any_of(probe.mark_m.begin(), probe.mark_m.begin() + static_cast<std::ptrdiff_t>(i), hides)) continue;
        char name[24];
        std::snprintf(name, sizeof name, "%zu", i + 1);
        list.AddText({at->x + 0.5F * em, at->y - 1.1F * em}, mark_colour, name);
    }
}

const char* probe_help(const Probe& probe) {
    return probe.marks == 0 ? "Click: mark a place, then others: distance and area. Esc or I: end."
                            : "Click: one more place. Backspace: remove the last, with Shift all. Esc or I: end.";
}

struct ProbePlate {
    ui::Rect rect;
    float text_width = 0, graph = 0; // graph: 0 without one
};

ProbePlate probe_plate(const State& state, const ui::Rect& view) {
    const Probe& probe = state.probe;
    const float em = ImGui::GetFontSize();
    const bool both = probe.marks >= 2;
    const int rows = 6 + coordinate_rows(state) + (both ? 4 : 0) + (probe.marks > 2 ? 2 : 0);
    ProbePlate p;
    p.graph = both ? 5 * em : 0;
    p.rect = {view.x + 0.6F * em, view.y + 0.6F * em, std::min(28 * em, view.width - 1.2F * em), 0};
    p.text_width = p.rect.width - 1.2F * em;
    const float help = ImGui::CalcTextSize(probe_help(probe), nullptr, false, p.text_width).y;
    p.rect.height = (1.3F * static_cast<float>(rows) + 1.2F) * em + p.graph + help;
    return p;
}

} // namespace

ui::Rect beside_probe(const State& state, const ui::Rect& view) {
    if (!state.probe.on || !state.scene.open()) return view;
    const ui::Rect taken = probe_plate(state, view).rect;
    const float right = taken.x + taken.width, low = taken.y + taken.height;
    if (view.x + view.width - right >= 30 * ImGui::GetFontSize())
        return {right, view.y, view.x + view.width - right, view.height};
    return {view.x, low, view.width, std::max(view.y + view.height - low, 0.0F)};
}

void draw_probe(const State& state, const ui::Rect& view) {
    const Probe& probe = state.probe;
    if (!probe.on || !state.scene.open()) return;
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    list.PushClipRect({view.x, view.y}, {view.x + view.width, view.y + view.height});
    const float em = ImGui::GetFontSize();
    const Picture picture{state.eye.view, view};
    const ProbePlate plate = probe_plate(state, view);
    draw_marks(probe, picture, plate.rect, list);
    if (probe.ground)
        if (const auto at = picture.at(probe.ground->position_m)) {
            list.AddCircle(*at, 0.4F * em, shadow, 0, 3);
            list.AddCircle(*at, 0.4F * em, IM_COL32_WHITE, 0, 1.5F);
        }
    const ImVec2 from{plate.rect.x, plate.rect.y};
    list.AddRectFilled(from, {from.x + plate.rect.width, from.y + plate.rect.height}, paper, 0.25F * em);
    Rows rows(list, {from.x + 0.6F * em, from.y + 0.5F * em}, 5.4F * em);
    if (probe.ground) {
        ground_rows(state, rows);
    } else {
        rows.row("Place", probe.pointer ? "no ground here" : "move the pointer over the ground");
        for (int i = 0; i < 5 + coordinate_rows(state); ++i) rows.line("");
    }
    if (probe.marks >= 2) {
        profile_rows(probe, rows);
        draw_profile(probe.profile, {from.x + 0.6F * em, rows.y(), plate.text_width, plate.graph - 0.4F * em}, list);
        rows.skip(plate.graph);
    }
    rows.line(probe_help(probe), plate.text_width);
    list.PopClipRect();
}

// --- Heights beside contours.

namespace {

void draw_contour_labels(const State& state, const ui::Rect& view) {
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    list.PushClipRect({view.x, view.y}, {view.x + view.width, view.y + view.height});
    const float em = ImGui::GetFontSize();
    const ui::Rect room = beside_probe(state, view);
    for (std::size_t i = 0; i < state.contour_labels.count; ++i) {
        const ContourLabel& label = state.contour_labels.all[i];
        char text[32];
        std::snprintf(text, sizeof text, "%.10g", label.height_m);
        const ImVec2 size = ImGui::CalcTextSize(text);
        const ImVec2 at{view.x + static_cast<float>(label.x) * view.width - size.x / 2,
                        view.y + static_cast<float>(label.y) * view.height - size.y / 2};
        // The probe's plate and what is written at the foot are in front.
        if (at.x < room.x || at.y < room.y || at.y + size.y > view.y + view.height - 2.4F * em) continue;
        list.AddRectFilled({at.x - 0.25F * em, at.y - 0.05F * em}, {at.x + size.x + 0.25F * em, at.y + size.y},
                           IM_COL32(12, 14, 18, 170), 0.2F * em);
        list.AddText(at, IM_COL32(255, 232, 200, 255), text);
    }
    list.PopClipRect();
}

} // namespace

// --- Keys and mouse over the picture, and what is written over it.

namespace {

constexpr float radians_a_pixel = 0.003F;
constexpr double fast = 5; // with Shift

// ImGui 1.86 knows most keys by the window system's number only; the GLFW back end passes those through. Letters and
// digits are their ASCII codes.
namespace key {
constexpr int enter = 257, right = 262, left = 263, down = 264, up = 265, home = 268, f1 = 290, insert = 260,
              remove = 261, backspace = 259;
}

double axis(int plus, int minus) {
    const bool* const down = ImGui::GetIO().KeysDown;
    return (down[plus] ? 1.0 : 0.0) - (down[minus] ? 1.0 : 0.0);
}

bool pressed(int number) {
    return ImGui::IsKeyPressed(number, false);
}

// Keys that stay down: where the camera goes.
void steer(MoveCamera& move) {
    const double speed = ImGui::GetIO().KeyShift ? fast : 1;
    move.steering = {speed * axis('W', 'S'), speed * axis('D', 'A'), speed * axis('E', 'Q'), 0, 0};
    move.steering.turn_right = axis(key::right, key::left);
    move.steering.turn_up = axis(key::up, key::down);
}

void point(const State& state, MoveCamera& move) {
    const ImGuiIO& io = ImGui::GetIO();
    move.speed_steps = static_cast<double>(io.MouseWheel);
    const bool orbit = state.eye.navigation == Navigation::orbit;
    const bool right = ImGui::IsMouseDragging(ImGuiMouseButton_Right, 0);
    const bool brush = state.ground.brush.tool != BrushTool::off; // the left button is its
    const bool left = brush ? right : ImGui::IsMouseDragging(ImGuiMouseButton_Left, 0);
    const bool pans = (right && !brush) || (left && io.KeyShift);
    if (orbit && pans) {
        // As if the ground were held: a picture's height is about 0.8 of the distance.
        const double share = 0.8 / std::max(state.interface.view_height_px, 1u);
        move.pan_right = -static_cast<double>(io.MouseDelta.x) * share;
        move.pan_back = -static_cast<double>(io.MouseDelta.y) * share;
    } else if (left) {
        move.right_rad = static_cast<double>(io.MouseDelta.x * radians_a_pixel);
        move.up_rad = static_cast<double>(-io.MouseDelta.y * radians_a_pixel);
    }
}

// Keys that are struck.
void handle_key_presses(const State& state, Commands& commands) {
    for (int i = 0; i < 3; ++i)
        if (pressed('1' + i)) commands.push(SetNavigation{static_cast<Navigation>(i)});
    if (pressed('F')) commands.push(FreezeRefinement{!state.eye.frozen});
    if (pressed('P')) commands.push(PlayPath{!state.route.playing()});
    if (pressed('R')) commands.push(RecordPath{!state.route.recording()});
    if (pressed(key::enter) && state.probe.on && state.probe.ground)
        commands.push(MarkPlace{state.probe.ground->position_m.x, state.probe.ground->position_m.z});
    if (pressed(key::backspace) && state.probe.on && state.probe.marks != 0) {
        if (ImGui::GetIO().KeyShift)
            commands.push(ClearMarks{});
        else
            commands.push(RemoveMark{});
    }
    if (pressed('I')) commands.push(SetSwitch{Switch::probe, !state.probe.on});
    if (pressed('B')) {
        Brush brush = state.ground.brush;
        brush.tool = brush.tool == BrushTool::off ? BrushTool::raise : BrushTool::off;
        commands.push(SetBrush{brush});
        if (brush.tool != BrushTool::off) commands.push(ShowPanel{Panel::ground});
    }
    if (pressed('T')) commands.push(HoldMeasures{!state.measures.held()});
    if (pressed('N')) commands.push(AddPoint{});
    if (pressed(key::insert) && !state.route.empty()) commands.push(InsertPoint{});
    if (pressed(key::remove) && state.route.selected()) commands.push(RemovePoint{*state.route.selected()});
    if (pressed(key::home)) commands.push(ViewAll{});
    if (pressed('G')) commands.push(SetOverlay{Overlay::wireframe, !state.shows(Overlay::wireframe)});
    if (pressed('M')) {
        const int count = session::picture_modes, step = ImGui::GetIO().KeyShift ? count - 1 : 1;
        commands.push(
            SetPictureMode{static_cast<session::PictureMode>((static_cast<int>(state.interface.mode) + step) % count)});
    }
}

// Text on a dark plate, in the picture; x and y: where in it its own share of its extent lies.
void plate(const ui::Rect& view, float x, float y, ImU32 colour, const char* text) {
    const float em = ImGui::GetFontSize();
    const float margin = 0.6F * em;
    const ImVec2 pad{0.6F * em, 0.3F * em};
    const float wrap = std::max(view.width - 2 * margin - 2 * pad.x, 4 * em); // a file's path may be long
    const ImVec2 size = ImGui::CalcTextSize(text, nullptr, false, wrap);
    const float w = size.x + 2 * pad.x, h = size.y + 2 * pad.y;
    const ImVec2 from{view.x + margin + x * (view.width - 2 * margin - w),
                      view.y + margin + y * (view.height - 2 * margin - h)};
    ImDrawList& list = *ImGui::GetBackgroundDrawList(); // over the picture, under the panels, and no window: the
                                                        // mouse goes through it
    list.AddRectFilled(from, {from.x + w, from.y + h}, IM_COL32(12, 14, 18, 205), 0.25F * em);
    list.AddText(nullptr, 0, {from.x + pad.x, from.y + pad.y}, colour, text, nullptr, wrap);
}

// Where the pointer is in the picture, and a click there that was no drag.
void aim_probe(const State& state, const ui::Rect& view, Commands& commands) {
    const ImGuiIO& io = ImGui::GetIO();
    if (!state.probe.on || io.WantCaptureMouse) return;
    PointProbe at{static_cast<double>((io.MousePos.x - view.x) / view.width),
                  static_cast<double>((io.MousePos.y - view.y) / view.height)};
    // Without a pointer it looks where the camera does.
    if (!(at.x >= 0 && at.x <= 1 && at.y >= 0 && at.y <= 1)) at = {0.5, 0.5};
    if (!state.probe.pointer || (*state.probe.pointer)[0] != at.x || (*state.probe.pointer)[1] != at.y)
        commands.push(at);
    const float moved = std::max(std::abs(io.MousePos.x - io.MouseClickedPos[ImGuiMouseButton_Left].x),
                                 std::abs(io.MousePos.y - io.MouseClickedPos[ImGuiMouseButton_Left].y));
    if (ImGui::IsMouseReleased(ImGuiMouseButton_Left) && moved < 3 && state.probe.ground)
        commands.push(MarkPlace{state.probe.ground->position_m.x, state.probe.ground->position_m.z});
}

void write_over(const State& state, const ui::Rect& view) {
    char text[96];
    const Eye& eye = state.eye;
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    list.PushClipRect({view.x, view.y}, {view.x + view.width, view.y + view.height});
    if (eye.frozen) plate(beside_probe(state, view), 0.5F, 0, ui::warning_colour, "Refinement frozen (F to release)");
    if (state.now_s < eye.speed_shown_until_s) {
        plate(view, 1, 1, IM_COL32_WHITE, speed_text(eye.free.speed_m_s).text);
    }
    if (state.route.recording()) {
        std::snprintf(text, sizeof text, "Recording: %zu points (R to stop)", state.route.recorded());
        plate(view, 0, 1, ui::bad, text);
    } else if (state.route.playing()) {
        std::snprintf(text, sizeof text, "Path: %.1f of %.1f s (P to pause)",
                      state.route.share() * state.route.seconds(), state.route.seconds());
        plate(view, 0, 1, IM_COL32_WHITE, text);
    } else if (state.ground.brush.tool != BrushTool::off && state.ground.problem.empty()) {
        plate(view, 0.5F, 1, IM_COL32_WHITE,
              "Drag: brush   Right button: look around   Wheel: size   Ctrl+Z: undo   B: put the brush away");
    } else if (eye.navigation == Navigation::orbit) {
        plate(view, 0, 1, IM_COL32_WHITE, "Orbit (1 to fly)");
    } else if (!eye.moved && state.route.points().empty() && state.interface.dialog == Dialog::none) {
        plate(view, 0.5F, 1, IM_COL32_WHITE,
              "W A S D: fly   Drag: look around   Wheel: speed   Home: all of it   Tab: panels   F1: all keys");
    }
    list.PopClipRect();
}

} // namespace

void draw_view(const State& state, const ui::Layout& layout, PanelState& own, Commands& commands) {
    const ImGuiIO& io = ImGui::GetIO();
    const bool modal = is_modal(state.interface.dialog), panel_keys = state.interface.panel_keys;
    const bool is_typing = modal || panel_keys || io.WantTextInput || io.WantCaptureKeyboard;
    if (!modal && !io.WantTextInput && pressed(key::f1)) {
        const bool shown = state.interface.dialog == Dialog::keys;
        commands.push(ShowDialog{shown ? Dialog::none : Dialog::keys});
    }
    if (!state.opening.empty()) {
        char text[600];
        std::snprintf(text, sizeof text, "Opening %.500s", state.opening.c_str());
        plate(layout.view, 0.5F, 0.5F, IM_COL32_WHITE, text);
    } else if (!state.scene.open() && state.interface.dialog == Dialog::none) { // a dialog would lie half over it
        plate(layout.view, 0.5F, 0.5F, ui::quiet, "No terrain is open: use File > Open, or drop a file here");
    }
    if (!state.scene.open()) return;
    MoveCamera move;
    move.seconds = state.frame_s;
    if (!is_typing && !io.KeyCtrl && !io.KeyAlt && !io.KeySuper) {
        steer(move);
        handle_key_presses(state, commands);
    }
    if (!draw_brush_hand(state, layout.view, own.brush, commands) && !io.WantCaptureMouse &&
        !draw_hands(state, layout.view, own.hand, commands))
        point(state, move);
    if (panel_keys && !io.WantCaptureMouse && ImGui::IsMouseClicked(ImGuiMouseButton_Left))
        commands.push(SetSwitch{Switch::panel_keys, false});
    commands.push(move);
    aim_probe(state, layout.view, commands);
    draw_contour_labels(state, layout.view);
    draw_probe(state, layout.view);
    draw_brush_ring(state, layout.view);
    write_over(state, layout.view);
}

} // namespace fjell::editor
