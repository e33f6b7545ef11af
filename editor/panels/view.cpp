// Keys and mouse over the picture, and what is written over it.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "editor/number_text.h"
#include "editor/panels/panels.h"

namespace fjell::editor {

namespace {

constexpr float radians_a_pixel = 0.003F;
constexpr double fast = 5; // with Shift

// ImGui 1.86 knows most keys by the window system's number only; the GLFW back end passes those through. Letters and
// digits are their ASCII codes.
namespace key {
constexpr int enter = 257, right = 262, left = 263, down = 264, up = 265, home = 268, f1 = 290, insert = 260,
              remove = 261;
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
    const bool left = ImGui::IsMouseDragging(ImGuiMouseButton_Left, 0);
    const bool pans = ImGui::IsMouseDragging(ImGuiMouseButton_Right, 0) || (left && io.KeyShift);
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
    if (pressed('I')) commands.push(SetSwitch{Switch::probe, !state.probe.on});
    if (pressed('T')) commands.push(HoldMeasures{!state.measures.held()});
    if (pressed('N')) commands.push(AddPoint{});
    if (pressed(key::insert) && !state.route.empty()) commands.push(InsertPoint{});
    if (pressed(key::remove) && state.route.selected()) commands.push(RemovePoint{*state.route.selected()});
    if (pressed(key::home)) commands.push(ViewAll{});
    if (pressed('G')) commands.push(SetOverlay{Overlay::wireframe, !state.shows(Overlay::wireframe)});
    if (pressed('M')) {
        const int count = flight::picture_modes, step = ImGui::GetIO().KeyShift ? count - 1 : 1;
        commands.push(
            SetPictureMode{static_cast<flight::PictureMode>((static_cast<int>(state.interface.mode) + step) % count)});
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
    } else if (eye.navigation == Navigation::orbit) {
        plate(view, 0, 1, IM_COL32_WHITE, "Orbit (1 to fly)");
    }
    list.PopClipRect();
}

} // namespace

void draw_view(const State& state, const ui::Layout& layout, Commands& commands) {
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
    if (!io.WantCaptureMouse && !draw_hands(state, layout.view, commands)) point(state, move);
    if (panel_keys && !io.WantCaptureMouse && ImGui::IsMouseClicked(ImGuiMouseButton_Left))
        commands.push(SetSwitch{Switch::panel_keys, false});
    commands.push(move);
    aim_probe(state, layout.view, commands);
    draw_probe(state, layout.view);
    write_over(state, layout.view);
}

} // namespace fjell::editor
