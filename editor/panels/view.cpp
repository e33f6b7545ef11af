#include <algorithm>

#include "editor/panels/panels.h"

namespace fjell::editor {

namespace {

constexpr float radians_a_pixel = 0.003F;

// ImGui 1.86 knows most letters by the window system's number only; the GLFW back end passes those through.
double axis(int plus, int minus) {
    const bool* const down = ImGui::GetIO().KeysDown;
    return (down[plus] ? 1.0 : 0.0) - (down[minus] ? 1.0 : 0.0);
}

} // namespace

void draw_view(const State& state, const ui::Layout& layout, Commands& commands) {
    const ImGuiIO& io = ImGui::GetIO();
    Move move;
    move.seconds = std::min(static_cast<double>(io.DeltaTime), 0.25);
    if (!io.WantTextInput && !io.KeyCtrl) {
        move.steering = {axis('W', 'S'), axis('D', 'A'), axis('E', 'Q'), 0, 0};
        if (!io.WantCaptureKeyboard) {
            move.steering.turn_right = axis(ImGui::GetKeyIndex(ImGuiKey_RightArrow), ImGui::GetKeyIndex(ImGuiKey_LeftArrow));
            move.steering.turn_up = axis(ImGui::GetKeyIndex(ImGuiKey_UpArrow), ImGui::GetKeyIndex(ImGuiKey_DownArrow));
        }
    }
    if (!io.WantCaptureMouse) {
        move.speed_steps = static_cast<double>(io.MouseWheel);
        if (ImGui::IsMouseDragging(ImGuiMouseButton_Left, 0)) {
            move.right_rad = static_cast<double>(io.MouseDelta.x * radians_a_pixel);
            move.up_rad = static_cast<double>(-io.MouseDelta.y * radians_a_pixel);
        }
    }
    (void)layout;
    (void)state;
    commands.push(move);
}

void draw_status(const State& state, const ui::Layout& layout, Commands& commands) {
    const ImVec2 display = ImGui::GetIO().DisplaySize;
    ui::begin_column("status", {0, display.y - layout.status_height, display.x, layout.status_height});
    draw_job_status(state, commands);
    if (!state.messages.all.empty() && state.now_s < state.messages.shown_until_s)
        ImGui::TextUnformatted(state.messages.all.back().text.c_str());
    else
        ImGui::Text("%u triangles drawn", state.measures.last().triangles_drawn);
    ImGui::End();
}

} // namespace fjell::editor
