// The panels: each reads the state and pushes commands, and touches nothing else but what is its own (PanelState).
//
// Thread: the frame's. Memory: none in a steady frame.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "editor/command.h"
#include "editor/jobs/jobs.h"
#include "editor/panels/forms.h"
#include "editor/panels/graph.h"
#include "editor/panels/ui.h"
#include "editor/state.h"

namespace fjell::editor::ui {

// Where panels, splitters and picture are in a window of that size: one that is wide enough has two columns, so that
// the picture keeps two thirds of it; a narrower one has one, and a tall one stacks two sections in a column.
struct Section {
    Rect rect;
    unsigned bits = 0; // section_bit() of the panels that it may show
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

namespace fjell::editor {

// The dialog that bakes: what is typed lives here, and goes to the state as a draft, which is looked at
// (jobs/heights.h).
struct BakeForm {
    std::uint64_t given = ~std::uint64_t{0}; // BakeDraft::given that it holds
    fields::PathText input = "", output = "", texture = "", ramp = "", rules = "", voids = "", crs = "", bbox = "",
                     band = "", size = "", vertical_unit = "", texture_bands = "";
    std::vector<std::string> more; // heights, beside the first
    bool output_is_chosen = false;
    int tile = 0, order = 0, nodata = 0, splat = 1, horizons = 0, encoding = 0;
    double spacing_m = 0, height_scale = 0, height_offset_m = 0;
    BakePack sent;
    BakeField browsing = BakeField::none; // for this one's file
    bool browsing_another = false;
    FileBrowserForm browser, overwrite;
};

// As the last frame left it: ImGui has handled Escape itself before a frame's panels are drawn.
struct DialogBefore {
    Dialog dialog = Dialog::none;
    ImVec2 display;
    double scale = 0;
    bool list = false;            // a list was dropped down over the dialog, or a question asked
    bool typing = false;          // an item was active
    std::uint64_t characters = 0; // that were typed before it was
};
// Of the frame before.
struct FloatBefore {
    bool on = false, moved = false; // by the hand that still holds it
    FloatingPanel place;            // the state's
    ImVec2 at, size, display;
    double scale = 0;
};
// What is held in the picture: a point of the path, or the sun.
struct PictureHand {
    std::optional<std::size_t> point; // of the path
    ImVec2 apart;                     // from the pointer to it, when it was taken
    double height_m = 0;              // that it keeps while it is moved level
    bool moved = false;
    const ProfileKey* key = nullptr; // of the sun
    double value = 0;                // of the key, when it was taken
    bool sun = false;                // taken, but whether along or across is not clear yet
};
struct BrushHand {
    bool down = false;
    ImVec2 at; // that was told
};
// A point of the path that is held on the overview.
struct MapHand {
    std::optional<std::size_t> point;
    ImVec2 from;  // where it was pressed
    ImVec2 apart; // from there to the point
    bool far = false;
};
struct ExportForm {
    std::string made_for = fields::nothing_yet;
    fields::PathText path = "";
    bool converged = false;
    int own = 0; // a threshold of its own
    double error_px = 1, texel_m = 0;
    bool quantised = false, meshopt = false;
    int texture = 0;       // png, jpeg
    bool browsing = false; // for the file
    FileBrowserForm browser;
};

struct ScreenshotForm {
    fields::PathText path = "fjell.png";
    int what = 0;
};
struct TuneForm {
    double budget_ms = TuneSettings{}.budget_us / 1000, least_px = TuneSettings{}.least_px,
           most_px = TuneSettings{}.most_px;
    int measure = 0, frames = 0;
    bool also = false;
};
struct CsvForm {
    std::string made_for = fields::nothing_yet;
    fields::PathText path = "";
    int frames = 0;
};
struct RenderForm {
    std::string made_for = fields::nothing_yet;
    fields::PathText file = "";
    int width = 3840, height = 2160;
};
// The field that is being typed into, and whether what is there so far is no value: it turns red.
struct TypingField {
    const ProfileKey* key = nullptr;
    bool wrong = false;
};

// What panels know from one frame to the next and the state does not: what is being typed, held or asked. What is typed
// lives in one form each, until its button makes it a command.
struct PanelState {
    ui::Context ui;
    BakeForm bake;
    FileBrowserForm browser; // one file dialog is open at a time
    DialogBefore dialog;
    std::array<FloatBefore, panels> floats;
    Panel float_on_top = Panel::tune;
    PictureHand hand;
    BrushHand brush;
    MapHand map;
    ExportForm mesh_export;
    ScreenshotForm screenshot;
    TuneForm tune;
    CsvForm benchmark;
    RenderForm render;
    char bookmark_name[61] = "";
    char layer_name[61] = "";
    double layer_strength = 1;  // while its slider is held
    char search[61] = "";       // of the settings
    bool search_begins = false; // its field gets the keyboard
    TypingField typing;
    double compared_px = 4;    // the threshold that was compared last
    float messages_height = 0; // of the list
    int menu_shown = -1;
    bool timeline_seeks = false;
};

// Everything of a frame: menu, columns, status line, the picture's area and whatever dialog is open.
void draw_panels(const State& state, PanelState& own, Commands& commands);

// One panel's groups, and what it is called.
void draw_panel(Panel panel, const State& state, PanelState& own, Commands& commands);
[[nodiscard]] const char* title_of(Panel panel);
// The keyboard is the camera's unless it was given to the panels: flags of a panel's window.
[[nodiscard]] ImGuiWindowFlags key_flags(const State& state);
// Panels that float over the picture: moved and resized by hand; back in a column when closed or dropped there.
void draw_floating(const State& state, const ui::Layout& layout, PanelState& own, Commands& commands);
// Of a panel's tab, the last item: dragged out of that rectangle or clicked twice, the panel floats.
void draw_detaching(Panel panel, const ui::Rect& column, const State& state, Commands& commands);

void draw_menu(const State& state, PanelState& own, Commands& commands);
// Keys that do what the menu has.
void draw_shortcuts(const State& state, PanelState& own, Commands& commands);
void draw_status(const State& state, const ui::Layout& layout, Commands& commands);
// Within the status line: what the job that runs is at, and a button that stops it; then on the same line.
void draw_job_status(const State& state, Commands& commands);
// Keys and mouse over the picture.
void draw_view(const State& state, const ui::Layout& layout, PanelState& own, Commands& commands);

// Over the picture.
void draw_probe(const State& state, const ui::Rect& view);
// What the probe's plate leaves of the picture, for what else is written at its top.
[[nodiscard]] ui::Rect beside_probe(const State& state, const ui::Rect& view);

// Above a panel's groups: a field, and what is found instead of the groups. False: nothing is looked for.
[[nodiscard]] bool draw_search(const State& state, PanelState& own, Commands& commands);

// Inside a group.
void draw_profile_keys(Group group, const State& state, PanelState& own, Commands& commands);
void draw_navigation(const State& state, PanelState& own, Commands& commands);
void draw_overview(const State& state, PanelState& own, Commands& commands);
void draw_position(const State& state, PanelState& own, Commands& commands);
void draw_modes(const State& state, PanelState& own, Commands& commands);
void draw_overlays(const State& state, PanelState& own, Commands& commands);
void draw_compare_picture(const State& state, PanelState& own, Commands& commands);
void draw_scale(const State& state, PanelState& own, Commands& commands);
void draw_light_presets(const State& state, PanelState& own, Commands& commands);
void draw_materials(const State& state, PanelState& own, Commands& commands);
void draw_brush(const State& state, PanelState& own, Commands& commands);
void draw_edit_layers(const State& state, PanelState& own, Commands& commands);
void draw_path(const State& state, PanelState& own, Commands& commands);
void draw_bookmarks(const State& state, PanelState& own, Commands& commands);
void draw_render(const State& state, PanelState& own, Commands& commands);
void draw_time(const State& state, PanelState& own, Commands& commands);
void draw_budgets(const State& state, PanelState& own, Commands& commands);
void draw_streaming(const State& state, PanelState& own, Commands& commands);
void draw_levels(const State& state, PanelState& own, Commands& commands);
void draw_auto_tune(const State& state, PanelState& own, Commands& commands);
void draw_benchmark(const State& state, PanelState& own, Commands& commands);

// Inside the panels of jobs, and on the overview.
void draw_runs(const State& state, Commands& commands); // nothing when there are none
// Dots along the latest run's path, over an overview that lies there.
void draw_heat(const State& state, ImDrawList& list, ImVec2 from, ImVec2 size);

// What tuning found, drawn as in the thesis' figures 6.3 and 6.4: time over the threshold with the budget's line, and
// under it the vertices; over the width of the window and that height in pixels. ImPlot is no package of Debian 12's.
void draw_tune_curve(const JobView& job, float height);

// Over the picture.
void draw_brush_ring(const State& state, const ui::Rect& view);
// The pointer's and the left button's, while there is a brush. True: it is not the camera's.
bool draw_brush_hand(const State& state, const ui::Rect& view, BrushHand& hand, Commands& commands);
void draw_divider(const State& state, const ui::Rect& view, Commands& commands);

// Inside the group of the camera path: the path over its time.
void draw_timeline(const State& state, PanelState& own, Commands& commands);
void draw_path_edits(const State& state, Commands& commands); // below the list of points

// The budget that keeps a mesh from its threshold, as the status line has it: "vertices"; empty: none.
[[nodiscard]] const char* exhausted_budget(std::uint32_t exhausted);
// A graph over the frames that are shown: a click on it chooses one, a drag over it zooms.
void draw_measured_graph(ui::Graph graph, std::initializer_list<ui::GraphLine> lines, const State& state,
                         Commands& commands);

// As panel and menu call them.
[[nodiscard]] const char* label_of(session::PictureMode mode);
[[nodiscard]] const char* label_of(Overlay overlay);

// The open one; it has its window, its place and its way to be closed already.
void draw_dialog(const State& state, PanelState& own, Commands& commands);
void draw_start(const State& state, PanelState& own, Commands& commands);
void draw_open_file(const State& state, PanelState& own, Commands& commands);
void draw_save_profile(const State& state, PanelState& own, Commands& commands);
void draw_save_path(const State& state, PanelState& own, Commands& commands);
void draw_compare(const State& state, PanelState& own, Commands& commands);
void draw_unsaved(const State& state, PanelState& own, Commands& commands);
void draw_recover(const State& state, PanelState& own, Commands& commands);
void draw_bake(const State& state, PanelState& own, Commands& commands);
void draw_baked(const State& state, PanelState& own, Commands& commands);
void draw_snapshot(const State& state, PanelState& own, Commands& commands);
void draw_screenshot(const State& state, PanelState& own, Commands& commands);
void draw_keys(const State& state, PanelState& own, Commands& commands);
void draw_messages(const State& state, PanelState& own, Commands& commands);

} // namespace fjell::editor
