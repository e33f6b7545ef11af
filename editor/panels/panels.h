// The panels: each reads the state and pushes commands, and touches nothing else.
#pragma once

#include "editor/command.h"
#include "editor/panels/graph.h"
#include "editor/panels/layout.h"
#include "editor/panels/ui.h"
#include "editor/state.h"

namespace fjell::editor {

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
