// What all panels share: look, scale, the layout's rectangles, and the places of controls for tests.
//
// Thread: the frame's. Memory: nothing a frame, unless places are being recorded.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <imgui.h>

#include "editor/command.h"
#include "editor/state.h"
#include "fjell/gl/palette.h"

namespace fjell::editor::ui {

// Fonts and metrics for that scale, 0.5 to 4; the atlas is recreated, and with it what the back end has of it.
void apply_style(double scale);

// Pixels.
struct Rect {
    float x = 0, y = 0, width = 0, height = 0;
};
struct Layout {
    float menu_height = 0, status_height = 0;
    Rect left, right, view; // right: empty when there is room for one column only, which then has all panels
    [[nodiscard]] bool one_column() const { return right.width <= 0; }
};
[[nodiscard]] Layout layout(float width, float height, double scale);

// The last item's place, under a name that tests know: "tune.refine.error_px". Recorded on request only.
struct Mark {
    std::string name;
    Rect rect;
};
void mark(const char* group, const char* name);
void record_marks(bool on); // starts again
[[nodiscard]] const std::vector<Mark>& marks();

// The last item's explanation, when the mouse rests on it.
void tip(const char* text);
// A column's window: fixed, with a scroll bar when it needs one. Ends with ImGui::End().
void begin_column(const char* name, const Rect& rect);
// A dialog in the middle, as large as given in unscaled pixels, height 0: as its content, and never beyond the
// window; `open` becomes false when it is closed. Ends with ImGui::End().
void begin_dialog(const char* title, double width, double height, const State& state, bool& open);
void heading(const char* text);
// "label   value" over the width of the column, the value on its right.
void row(const char* label, const char* format, ...) IM_FMTARGS(2);

inline constexpr ImU32 good = IM_COL32(110, 200, 120, 255), warning_colour = IM_COL32(235, 190, 80, 255),
                       bad = IM_COL32(240, 105, 95, 255), quiet = IM_COL32(150, 158, 170, 255);
[[nodiscard]] ImU32 severity_colour(Severity severity);
[[nodiscard]] ImU32 colour(const gl::Rgb8& rgb);

} // namespace fjell::editor::ui
