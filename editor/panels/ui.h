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
#include "editor/panels/fonts.h"
#include "editor/state.h"
#include "fjell/gl/palette.h"

namespace fjell::editor::ui {

// Fonts and metrics for that scale, 0.5 to 4; the atlas is recreated, and with it what the back end has of it.
void apply_style(double scale);

// After ImGui::Render(): leaves half as much room again in what it has drawn into, so that a word more in a later frame
// allocates nothing.
void leave_room();

// Pixels.
struct Rect {
    float x = 0, y = 0, width = 0, height = 0;
};

// The last item's place, under a name that tests know: "tune.refine.max_error_px". Recorded on request only.
struct Mark {
    std::string name;
    Rect rect;
};
// The item that the pointer rests on.
struct Resting {
    ImVec2 at;
    double since_s = 0;
    int frame = -2; // in which it was seen last
    bool clicked = false;
};
// Panes in the order in which they are drawn.
struct Panes {
    int count = 0;  // of this frame, so far
    int before = 0; // of the last one
    int at = -1;    // that keys move in; -1: none
    int at_next = -1;
    int wanted = -1; // that shall get them
    bool had_keys = false;
};
// What is known from one frame to the next, of all panels; ImGui's io.UserData points at it.
struct Context {
    std::vector<Mark> marks;
    std::string focus; // the mark that the keyboard is at
    bool recording = false;
    Resting resting;
    int keyboard_at = -2; // frame in which the keyboard was at a button
    Panes panes;
    Glyphs glyphs;
};
[[nodiscard]] Context& context();
void mark(const char* group, const char* name);
void mark(const char* group, const char* name, const Rect& rect);    // the part of it that a pointer is for
void mark_at(const char* group, const char* name, const Rect& rect); // of what is no item
[[nodiscard]] bool recording_marks();                                // for names that cost something to make
void record_marks(bool on);                                          // starts again
[[nodiscard]] const std::vector<Mark>& marks();
[[nodiscard]] const std::string& marked_focus(); // the mark that the keyboard is at; empty: at none

// The last item's explanation, once the mouse has rested on it for a while: beside it, never over what lies below the
// pointer, and not again after a click before the pointer has left.
void tip(const char* text);
inline void control(const char* group, const char* name, const char* about) { // both
    mark(group, name);
    tip(about);
}
// Whether to say it now, of the last item: for tips whose text is made first.
[[nodiscard]] bool begin_tip();
void end_tip();
// How long until a tip is due, seconds; below 0: none is. For whoever draws frames only when something changes.
[[nodiscard]] double tip_due_s();
// A column's window: fixed. Ends with ImGui::End().
void begin_column(const char* name, const Rect& rect, ImGuiWindowFlags more = 0);
// A dialog's button. Enter presses the one that the keyboard is at, or else the primary one.
[[nodiscard]] bool button(const char* label, bool primary = false);
// A panel's: grey while it cannot be pressed, with a mark and a tip.
[[nodiscard]] bool panel_button(const char* label, const char* group, const char* name, bool enabled,
                                const char* about);
// The next button stands beside the last one, where there is room for it.
void beside(const char* label);
// The next item gets the keyboard, when its dialog has just opened.
void focus_first();
void heading(const char* text);
void right_text(const char* text, ImU32 colour); // at the right of the room that is left
// A file's path in one line: where it is too long its end is shown, after dots; all of it is the tip.
void path_text(const std::string& path);
// In as many lines as it takes; they end at spaces alone.
void wrapped(const char* text);
void note(const char* text); // quiet, in as many lines as it takes
// "label   value" over the width of the column, the value on its right.
void row(const char* label, const char* format, ...) IM_FMTARGS(2);

inline constexpr ImU32 good = IM_COL32(110, 200, 120, 255), warning_colour = IM_COL32(235, 190, 80, 255),
                       bad = IM_COL32(240, 105, 95, 255), quiet = IM_COL32(150, 158, 170, 255);
// While it lives a list fills shapes without smooth edges, which take twice as many vertices: for shapes side by
// side, where the next one or a line covers the edge.
class PlainEdges {
public:
    explicit PlainEdges(ImDrawList& list) : list_(list), before_(list.Flags) {
        list.Flags &= ~ImDrawListFlags_AntiAliasedFill;
    }
    ~PlainEdges() { list_.Flags = before_; }
    PlainEdges(const PlainEdges&) = delete;
    PlainEdges& operator=(const PlainEdges&) = delete;

private:
    ImDrawList& list_;
    ImDrawListFlags before_;
};
[[nodiscard]] ImU32 severity_colour(Severity severity);
[[nodiscard]] ImU32 colour(const gl::Rgb8& rgb);

} // namespace fjell::editor::ui
