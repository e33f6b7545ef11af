// The editor's enumerations and their names, as scripts and panels spell them.
#pragma once

#include <array>
#include <cstdint>
#include <iterator>

#include "session/options.h"

namespace fjell::editor {

enum class Navigation : std::uint8_t { fly, orbit, path };
inline constexpr const char* navigation_names[] = {"fly", "orbit", "path"};

enum class Overlay : std::uint8_t {
    wireframe,
    tile_borders,
    page_borders,
    spheres,
    culled,
    error,
    path,
    contours,
    slope
};
inline constexpr const char* overlay_names[] = {"wireframe", "tile-borders", "page-borders", "spheres", "culled",
                                                "error",     "path",         "contours",     "slope"};
inline constexpr int overlays = static_cast<int>(std::size(overlay_names));
inline constexpr std::array<bool, overlays> first_overlays{false, false, false, false,
                                                           false, false, true}; // the path alone

inline constexpr double least_contour_m = 0.01, most_contour_m = 10'000; // between contours

// Each in groups that fold.
enum class Panel : std::uint8_t { tune, view, cost, auto_tune, pictures, light, ground };
inline constexpr const char* panel_names[] = {"tune", "view", "cost", "auto-tune", "pictures", "light", "ground"};
inline constexpr int panels = static_cast<int>(std::size(panel_names));
// Panels of one section bit share a section of a column, however much room there is: two sections a column.
inline constexpr unsigned section_bit(Panel panel) {
    constexpr unsigned sections[] = {1, 2, 4, 8, 2, 1, 1};
    static_assert(std::size(sections) == panels, "a panel was added: give it a section");
    return sections[static_cast<std::size_t>(panel)];
}
inline constexpr unsigned left_sections = 3, right_sections = 12;

// The groups of all panels, panel by panel, from the top down.
enum class Group : std::uint8_t {
    tune_refinement,
    tune_budgets,
    tune_streaming,
    tune_screen,
    tune_advanced,
    view_picture,
    view_overlays,
    view_compare,
    view_camera,
    view_map,
    view_position,
    view_interface,
    cost_budgets,
    cost_time,
    cost_streaming,
    cost_levels,
    auto_tune_threshold,
    auto_tune_benchmark,
    pictures_path,
    pictures_bookmarks,
    pictures_render,
    light_presets,
    light_sun,
    light_air,
    light_ground,
    light_materials,
    ground_brush,
    ground_layers
};
struct GroupName {
    Panel panel;
    const char* name;   // as scripts and settings have it
    const char* label;  // as its panel has it
    bool opens = false; // unfolded at first
};
inline constexpr GroupName group_names[] = {{Panel::tune, "tune.refinement", "Refinement", true},
                                            {Panel::tune, "tune.budgets", "Budgets", true},
                                            {Panel::tune, "tune.streaming", "Streaming"},
                                            {Panel::tune, "tune.screen", "Screen"},
                                            {Panel::tune, "tune.advanced", "Advanced: recursive method"},
                                            {Panel::view, "view.picture", "Picture mode", true},
                                            {Panel::view, "view.overlays", "Overlays", true},
                                            {Panel::view, "view.compare", "Compare in the picture"},
                                            {Panel::view, "view.camera", "Camera"},
                                            {Panel::view, "view.map", "Overview", true},
                                            {Panel::view, "view.position", "Position"},
                                            {Panel::view, "view.interface", "Interface"},
                                            {Panel::cost, "cost.budgets", "Budgets and memory", true},
                                            {Panel::cost, "cost.time", "Time"},
                                            {Panel::cost, "cost.streaming", "Streaming"},
                                            {Panel::cost, "cost.levels", "Levels"},
                                            {Panel::auto_tune, "auto-tune.threshold", "Auto-tune", true},
                                            {Panel::auto_tune, "auto-tune.benchmark", "Benchmark", true},
                                            {Panel::pictures, "pictures.path", "Camera path", true},
                                            {Panel::pictures, "pictures.bookmarks", "Bookmarks", true},
                                            {Panel::pictures, "pictures.render", "Render"},
                                            {Panel::light, "light.presets", "Presets", true},
                                            {Panel::light, "light.sun", "Sun", true},
                                            {Panel::light, "light.air", "Air and exposure"},
                                            {Panel::light, "light.ground", "Shadows and water"},
                                            {Panel::light, "light.materials", "Materials", true},
                                            {Panel::ground, "ground.brush", "Brush", true},
                                            {Panel::ground, "ground.layers", "Edit layers", true}};
inline constexpr std::size_t groups = std::size(group_names);
static_assert(groups == static_cast<std::size_t>(Group::ground_layers) + 1, "a group was added: name it");
inline constexpr std::array<bool, groups> first_groups = [] {
    std::array<bool, groups> open{};
    for (std::size_t i = 0; i < groups; ++i) open[i] = group_names[i].opens;
    return open;
}();
// Panels before 0.4, which scripts and settings may name until 0.5.
inline constexpr struct {
    const char* name;
    Group group;
} former_panels[] = {
    {"camera", Group::view_camera},           {"show", Group::view_picture},        {"time", Group::cost_time},
    {"budgets", Group::cost_budgets},         {"streaming", Group::cost_streaming}, {"levels", Group::cost_levels},
    {"benchmark", Group::auto_tune_benchmark}};

enum class Column : std::uint8_t { left, right }; // one alone is the left one
inline constexpr const char* column_names[] = {"left", "right"};
inline constexpr int columns = static_cast<int>(std::size(column_names));
enum class ColumnPart : std::uint8_t { width, split, folded };
inline constexpr const char* column_part_names[] = {"width", "split", "folded"};

// Of the sun, the air and the exposure.
enum class LightPreset : std::uint8_t { relief, morning, noon, evening, dusk, haze };
inline constexpr const char* light_preset_names[] = {"relief", "morning", "noon", "evening", "dusk", "haze"};

// Of the window as a whole.
enum class Switch : std::uint8_t {
    show_panels,     // beside the picture
    picture_only,    // neither panels nor menu nor status line
    panel_keys,      // keys move in the panels, not the camera
    half_resolution, // while the camera moves
    probe            // of the ground under the pointer
};
inline constexpr const char* switch_names[] = {"panels", "picture-only", "panel-keys", "half-resolution", "probe"};

// At most one is open, over everything else.
enum class Dialog : std::uint8_t {
    none,
    start, // nothing is open yet
    open_file,
    save_profile,
    save_path,
    compare,
    bake,
    snapshot,
    screenshot,
    keys,
    messages,
    unsaved, // before what would lose changes
    recover, // changes that an earlier run did not save
    baked    // a pack, while another terrain is flown
};
inline constexpr const char* dialog_names[] = {"none",     "start",   "open",    "save-profile", "save-path",
                                               "compare",  "bake",    "export",  "screenshot",   "keys",
                                               "messages", "unsaved", "recover", "baked"};
inline constexpr int dialogs = static_cast<int>(std::size(dialog_names));
// Nothing beneath these reacts.
inline constexpr bool is_modal(Dialog dialog) {
    return dialog != Dialog::none && dialog != Dialog::start && dialog != Dialog::keys && dialog != Dialog::messages;
}

// Which files a dialog lists.
enum class FileFilter : std::uint8_t { everything, profiles, paths, heights, images, ramps, rules, packs, meshes };

// What the dialog that bakes asks for.
enum class BakeField : std::uint8_t {
    none,
    heights, // the first file, or one more
    output,
    texture,
    ramp,
    rules,
    spacing,
    height_scale,
    nodata,
    voids,
    crs,
    encoding,
    bbox,
    band,
    size,
    vertical_unit,
    texture_bands
};
inline constexpr const char* bake_field_names[] = {
    "none", "heights", "output",   "texture", "ramp", "rules", "spacing",       "zscale",       "nodata",
    "void", "crs",     "encoding", "bbox",    "band", "size",  "vertical_unit", "texture_bands"};

// To the question about unsaved changes.
enum class Answer : std::uint8_t { save, discard, cancel };
inline constexpr const char* answer_names[] = {"save", "discard", "cancel"};

} // namespace fjell::editor
