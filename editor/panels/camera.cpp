// Where the camera is, how it moves, and the camera's path.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <optional>

#include "editor/number_text.h"
#include "editor/panels/keyboard.h"
#include "editor/panels/panels.h"

namespace fjell::editor {

namespace {

void draw_name(const Route& route) {
    const std::string& path = route.path();
    const char* const name = path.empty() ? "not saved yet" : file_name(path);
    if (route.points().empty() && route.empty()) {
        ui::note("None. Record a flight, add points one by one, or open a file.");
        return;
    }
    ui::need_glyphs(path);
    ImGui::PushStyleColor(ImGuiCol_Text, route.unsaved() ? ui::warning_colour : ImGui::GetColorU32(ImGuiCol_Text));
    ImGui::TextWrapped("%s%s", route.unsaved() ? "* " : "", name);
    ImGui::PopStyleColor();
    if (!path.empty()) ui::tip(path.c_str());
    if (route.as_read()) {
        ui::note("as in the file; an edit converts it to these points");
    }
}

void draw_flight(const State& state, PanelState& own, Commands& commands) {
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
    ui::control("path", "seek", "Position along the path; drag to move along it.");
    draw_timeline(state, own, commands);
    double seconds = route.requested_seconds();
    ImGui::SetNextItemWidth(6.5F * ImGui::GetFontSize());
    if (ImGui::InputDouble("Duration", &seconds, 0, 0, seconds > 0 ? "%.1f s" : "auto",
                           ImGuiInputTextFlags_EnterReturnsTrue) &&
        std::isfinite(seconds))
        commands.push(SetPathSeconds{seconds});
    ui::control("path", "seconds",
                "Duration of the flight in seconds, 1 to 3,600; 0: a "
                "duration chosen from the terrain's size. Enter applies it.");
    ImGui::SameLine();
    bool loops = route.loops();
    if (ImGui::Checkbox("Loop", &loops)) commands.push(LoopPath{loops});
    ui::control("path", "loop", "Starts again at the end.");
}

void draw_point(const Route& route, std::size_t i, Commands& commands) {
    const session::ControlPoint& p = route.points()[i];
    char text[112];
    std::snprintf(text, sizeof text, "%zu: %.80s", i, place_text(p[0], p[1], p[2]).text);
    ImGui::PushID(static_cast<int>(i));
    if (ImGui::Selectable(text, route.selected() == i)) commands.push(SelectPoint{i});
    char name[24];
    std::snprintf(name, sizeof name, "point.%zu", i);
    ui::control("path", name, "Selects this point, and looks from there.");
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

void draw_path(const State& state, PanelState& own, Commands& commands) {
    draw_name(state.route);
    draw_flight(state, own, commands);
    draw_points(state.route, commands);
    draw_path_edits(state, commands);
}

// --- What is done to the camera path and its points, below their list.

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
    if (ui::panel_button("Clear", "path", "clear", n > 0, "Removes the path. Restore brings it back."))
        commands.push(ClearPath{});
    ui::beside("Restore");
    if (ui::panel_button("Restore", "path", "restore", route.can_restore(),
                         "Brings back the path as it was before its last change."))
        commands.push(RestorePath{});
}

// --- The camera path over its time: where its points are, and where it is being played. A drag moves the playhead, a
// press on a mark selects its point, and so do keys; the playhead's keys are those of the slider above.

namespace {

constexpr std::size_t most_marked = 64;

// Where times lie.
struct TimelineScale {
    float left, right, em;
    [[nodiscard]] float x(double share) const { return left + static_cast<float>(share) * (right - left); }
    [[nodiscard]] double share(float x) const {
        return std::clamp(static_cast<double>((x - left) / (right - left)), 0.0, 1.0);
    }
};

// The point whose mark lies under the pointer.
std::optional<std::size_t> timeline_point(const Route& route, const TimelineScale& scale) {
    std::optional<std::size_t> found;
    float away = 0.7F * scale.em;
    for (std::size_t i = 0; i < route.points().size(); ++i) {
        const float at = std::abs(scale.x(route.share_of(i)) - ImGui::GetMousePos().x);
        if (at > away) continue;
        away = at;
        found = i;
    }
    return found;
}

// Keys are at the timeline.
void follow_keys(const Route& route, bool enter, Commands& commands) {
    const auto struck = [](ImGuiKey key, bool repeats) {
        return ImGui::IsKeyPressed(ImGui::GetKeyIndex(key), repeats);
    };
    const int right = struck(ImGuiKey_RightArrow, true) - struck(ImGuiKey_LeftArrow, true);
    const std::size_t n = route.points().size();
    const auto selected = route.selected();
    if (n == 0) return;
    if (right != 0) {
        std::size_t to = right > 0 ? 0 : n - 1; // when none is selected
        if (selected) to = right > 0 ? std::min(*selected + 1, n - 1) : *selected - std::min<std::size_t>(*selected, 1);
        commands.push(SelectPoint{to, false});
    }
    if (struck(ImGuiKey_Insert, false)) commands.push(InsertPoint{});
    if (!selected || *selected >= n) return;
    if (struck(ImGuiKey_Delete, false)) commands.push(RemovePoint{*selected});
    if (enter) commands.push(SelectPoint{*selected, true});
}

} // namespace

void draw_timeline(const State& state, PanelState& own, Commands& commands) {
    bool& seeks = own.timeline_seeks;
    const Route& route = state.route;
    if (route.poses().size() < 2) return;
    const float em = ImGui::GetFontSize(), width = std::max(ImGui::GetContentRegionAvail().x, 4 * em);
    const ImVec2 low = ImGui::GetCursorScreenPos(), high{low.x + width, low.y + 3.4F * em};
    const float lane = low.y + 2 * em; // of the points, below it
    ImGui::InvisibleButton("timeline", {width, high.y - low.y});
    const float edge = std::min(0.7F * em, width / 4); // where half of the first and the last mark have room
    ui::mark("path", "timeline", {low.x + edge, low.y, width - 2 * edge, high.y - low.y});
    const bool at_it = ImGui::IsItemFocused() && ImGui::GetIO().NavVisible, pressed = ImGui::IsItemActivated(),
               by_hand = pressed && ImGui::IsMouseDown(ImGuiMouseButton_Left);
    if (at_it) keyboard::keep_arrows();
    if (at_it) follow_keys(route, pressed && !by_hand, commands);
    if (!ImGui::IsItemVisible() && !ImGui::IsItemActive()) return;
    const TimelineScale scale{low.x + edge, high.x - edge, em};
    const ImVec2 mouse = ImGui::GetMousePos();
    const double share = scale.share(mouse.x);
    std::optional<std::size_t> under;
    if (ImGui::IsItemHovered() && mouse.y >= lane && !seeks) under = timeline_point(route, scale);
    if (by_hand) {
        const bool twice = ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left);
        seeks = !under && !twice;
        if (under)
            commands.push(SelectPoint{*under, twice});
        else if (twice && mouse.y >= lane)
            commands.push(InsertPoint{share});
        else
            commands.push(SeekPath{share});
    } else if (seeks && ImGui::IsItemActive() && ImGui::GetIO().MouseDelta.x != 0) {
        commands.push(SeekPath{share});
    }
    if (!ImGui::IsItemActive()) seeks = false;

    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.PushClipRect(low, high, true);
    list.AddRectFilled(low, high, IM_COL32(28, 31, 37, 255));
    list.AddRectFilled({low.x, lane}, high, IM_COL32(38, 42, 50, 255));
    // Of many points the marks are smaller, or they would be one bar.
    const auto n = static_cast<float>(std::max<std::size_t>(route.points().size(), 1));
    const float r = std::clamp((scale.right - scale.left) / n / 2.4F, 0.15F * em, 0.5F * em), y = (lane + high.y) / 2;
    for (std::size_t i = 0; i < route.points().size(); ++i) {
        const float x = scale.x(route.share_of(i)), reach = under == i ? 1.25F * r : r;
        list.AddQuadFilled({x - reach, y}, {x, y - reach}, {x + reach, y}, {x, y + reach},
                           route.selected() == i ? IM_COL32_WHITE : IM_COL32(255, 120, 200, 255));
        if (!ui::recording_marks() || i >= most_marked) continue;
        char name[32];
        std::snprintf(name, sizeof name, "point.%zu", i);
        ui::mark_at("timeline", name, {x - r, y - r, 2 * r, 2 * r});
    }
    const float x = scale.x(route.share());
    list.AddLine({x, low.y + 0.2F * em}, {x, high.y}, IM_COL32_WHITE, std::max(1.0F, em / 10));
    list.PopClipRect();
    (void)keyboard::outline();
    if (!ui::begin_tip()) return;
    if (under)
        ImGui::Text("Point %zu at %.1f s. Click: select it; twice: look from there. Keys: left and right select a "
                    "point; Enter: look from there; Delete: remove it.",
                    *under, route.share_of(*under) * route.seconds());
    else
        ImGui::Text("%.1f s. Click or drag: go there. Click twice on the lower edge: a new point there.",
                    share * route.seconds());
    ui::end_tip();
}

// --- Where the camera is, and how it moves.

namespace {

constexpr double degree = std::numbers::pi / 180;

// A number under its name; true when another one was given. ImGui keeps what is being typed.
bool number(const char* name, double& value, const char* format, const char* about) {
    ImGui::PushID(name);
    ImGui::SetNextItemWidth(-FLT_MIN);
    const bool given = ImGui::InputDouble("##value", &value, 0, 0, format, ImGuiInputTextFlags_EnterReturnsTrue) &&
                       std::isfinite(value);
    ui::control("camera", name, about);
    ImGui::PopID();
    return given;
}

void labelled(const char* label) {
    ImGui::AlignTextToFramePadding();
    ImGui::TextUnformatted(label);
    ImGui::SameLine(6.2F * ImGui::GetFontSize());
}

} // namespace

void draw_position(const State& state, PanelState&, Commands& commands) {
    const session::FreeCamera& c = state.eye.free;
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
    const baker::Coordinates& there = *state.scene.coordinates;
    ImGui::TextWrapped("CRS: %s", there.crs().empty() ? "none" : there.crs().c_str());
    ui::mark("camera", "crs");
    if (!there.crs().empty()) {
        const auto [east, north] = there.in_crs(place.position_m.x, place.position_m.z);
        const int digits = there.projected() ? 1 : 6;
        labelled("In the CRS");
        ImGui::Text("%.*f, %.*f %s", digits, east, digits, north, there.unit().c_str());
        ui::tip("The camera's place in the CRS, east and north. The probe (I) shows that of the ground under the "
                "pointer, and its degrees.");
    }
    if (!given) return;
    place.heading_rad = heading * degree;
    place.pitch_rad = pitch * degree;
    commands.push(place);
}

void draw_navigation(const State& state, PanelState&, Commands& commands) {
    constexpr const char* names[] = {"Fly", "Orbit", "Path"};
    constexpr const char* abouts[] = {
        "W, A, S, D, Q and E move, dragging looks around, the wheel sets the speed (1).",
        "Dragging orbits the ground in the middle of the picture, the wheel zooms, right drag pans (2).",
        "Follows the camera path (3)."};
    for (int i = 0; i < 3; ++i) {
        const auto navigation = static_cast<Navigation>(i);
        if (i > 0) ImGui::SameLine();
        if (ImGui::RadioButton(names[i], state.eye.navigation == navigation)) commands.push(SetNavigation{navigation});
        ui::control("navigate", navigation_names[i], abouts[i]);
    }
    ImGui::SameLine();
    if (ImGui::Button("View all")) commands.push(ViewAll{});
    ui::control("camera", "home", "Look at the whole terrain from the south (Home).");
    labelled("Speed");
    double speed = state.eye.free.speed_m_s;
    const double least = 0.1, most = std::max(1000.0, 0.2 * std::max(state.scene.width_m(), state.scene.depth_m()));
    ImGui::SetNextItemWidth(-FLT_MIN);
    if (ImGui::SliderScalar("##speed", ImGuiDataType_Double, &speed, &least, &most,
                            speed < 1000 ? "%.4g m/s" : "%.0f m/s", ImGuiSliderFlags_Logarithmic))
        commands.push(SetSpeed{speed});
    ui::control(
        "camera", "speed",
        "Flying speed in metres per second; with Shift five times as fast. The wheel over the picture changes it "
        "too; Ctrl+click to type a value.");
    bool frozen = state.eye.frozen;
    if (ImGui::Checkbox("Freeze refinement (F)", &frozen)) commands.push(FreezeRefinement{frozen});
    ui::control("camera", "freeze",
                "The mesh stays refined and culled for the current camera while you look at it from elsewhere. The "
                "overview shows both cameras.");
}

} // namespace fjell::editor
