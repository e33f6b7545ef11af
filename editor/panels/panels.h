// Where panels, splitters and picture are in a window of that size.
//
// A window that is wide enough has two columns, so that the picture keeps two thirds of it; a narrower one has one, and
// a tall one stacks two sections in a column. Thread: the frame's. Memory: none.
#pragma once

#include "editor/command.h"
#include "editor/jobs/jobs.h"
#include "editor/panels/graph.h"
#include "editor/panels/ui.h"
#include "editor/state.h"

namespace fjell::editor::ui {

struct Section {
    Rect rect;
    unsigned groups = 0; // group_bit() of the panels that it may show
};
struct ColumnLayout {
    bool there = false;
    bool folded = false;
    Rect strip; // beside the picture: drags the width, and a click folds
    Rect split; // between two sections
    int sections = 0;
    Section section[2];
};
struct Layout {
    float menu_height = 0, status_height = 0; // 0: they are hidden
    ColumnLayout column[columns];
    Rect view;
};
[[nodiscard]] Layout layout(float width, float height, const Interface& interface);

} // namespace fjell::editor::ui

// --- Runs of benchmarks in the benchmark panel and on the overview.

namespace fjell::editor {

void draw_runs(const State& state, Commands& commands); // nothing when there are none
// Dots along the latest run's path, over an overview that lies there.
void draw_heat(const State& state, ImDrawList& list, ImVec2 from, ImVec2 size);

// --- What tuning found, drawn as in the thesis' figures 6.3 and 6.4: time over the threshold with the budget's line,
// and under it the vertices. ImPlot is no package of Debian 12's, so the axes are our own.

// Over the width of the window and that height in pixels. Hovering shows a threshold's values. Allocates nothing.
void draw_tune_curve(const JobView& job, float height);

// --- The panels: each reads the state and pushes commands, and touches nothing else.

// Everything of a frame: menu, columns, status line, the picture's area and whatever dialog is open.
void draw_panels(const State& state, Commands& commands);

// One panel's contents, and what it is called.
void draw_panel(Panel panel, const State& state, Commands& commands);
[[nodiscard]] const char* title_of(Panel panel);
// The keyboard is the camera's unless it was given to the panels: flags of a panel's window.
[[nodiscard]] ImGuiWindowFlags key_flags(const State& state);
// Panels that float over the picture: moved and resized by hand; back in a column when closed or dropped there.
void draw_floating(const State& state, const ui::Layout& layout, Commands& commands);
// Of a panel's tab, the last item: dragged out of that rectangle or clicked twice, the panel floats.
void draw_detaching(Panel panel, const ui::Rect& column, const State& state, Commands& commands);

void draw_menu(const State& state, Commands& commands);
// Keys that do what the menu has.
void draw_shortcuts(const State& state, Commands& commands);
void draw_status(const State& state, const ui::Layout& layout, Commands& commands);
// Within the status line: what the job that runs is at, and a button that stops it; then on the same line.
void draw_job_status(const State& state, Commands& commands);
// Keys and mouse over the picture.
void draw_view(const State& state, const ui::Layout& layout, Commands& commands);

// In the picture: points of the path, and the sun with L, follow the mouse. True: it is not the camera's.
[[nodiscard]] bool draw_hands(const State& state, const ui::Rect& view, Commands& commands);

// Over the picture.
void draw_probe(const State& state, const ui::Rect& view);
// What the probe's plate leaves of the picture, for what else is written at its top.
[[nodiscard]] ui::Rect beside_probe(const State& state, const ui::Rect& view);

// Inside a column.
void draw_tune(const State& state, Commands& commands);
void draw_camera(const State& state, Commands& commands);
void draw_picture(const State& state, Commands& commands);
void draw_pictures(const State& state, Commands& commands);
void draw_time(const State& state, Commands& commands);
void draw_budgets(const State& state, Commands& commands);
void draw_streaming(const State& state, Commands& commands);
void draw_levels(const State& state, Commands& commands);
void draw_auto_tune(const State& state, Commands& commands);
void draw_benchmark(const State& state, Commands& commands);

// Inside the view panel; and over the picture.
void draw_compare_picture(const State& state, Commands& commands);
void draw_divider(const State& state, const ui::Rect& view, Commands& commands);

// Inside the camera panel.
void draw_overview(const State& state, Commands& commands);
void draw_path(const State& state, Commands& commands);
// Inside that: the path over its time.
void draw_timeline(const State& state, Commands& commands);
void draw_path_edits(const State& state, Commands& commands); // below the list of points

// A graph over the frames that are shown: a click on it chooses one, a drag over it zooms.
void draw_measured_graph(ui::Graph graph, std::initializer_list<ui::GraphLine> lines, const State& state,
                         Commands& commands);

// As panel and menu call them.
[[nodiscard]] const char* label_of(flight::PictureMode mode);
[[nodiscard]] const char* label_of(Overlay overlay);

// The open one; it has its window, its place and its way to be closed already.
void draw_dialog(const State& state, Commands& commands);
void draw_start(const State& state, Commands& commands);
void draw_open_file(const State& state, Commands& commands);
void draw_save_profile(const State& state, Commands& commands);
void draw_save_path(const State& state, Commands& commands);
void draw_compare(const State& state, Commands& commands);
void draw_unsaved(const State& state, Commands& commands);
void draw_recover(const State& state, Commands& commands);
void draw_bake(const State& state, Commands& commands);
void draw_baked(const State& state, Commands& commands);
void draw_snapshot(const State& state, Commands& commands);
void draw_screenshot(const State& state, Commands& commands);
void draw_keys(const State& state, Commands& commands);
void draw_messages(const State& state, Commands& commands);

} // namespace fjell::editor
