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

// Those of the left column, then those of the right one.
enum class Panel : std::uint8_t {
    tune,
    camera,
    show,
    pictures,
    time,
    budgets,
    streaming,
    levels,
    auto_tune,
    benchmark
};
inline constexpr const char* panel_names[] = {"tune",    "camera",    "show",   "pictures",  "time",
                                              "budgets", "streaming", "levels", "auto-tune", "benchmark"};
inline constexpr int panels = static_cast<int>(std::size(panel_names));
// Panels of one group share a section of a column, however much room there is: two groups a column.
inline constexpr unsigned group_bit(Panel panel) {
    constexpr unsigned groups[] = {1, 2, 1, 2, 4, 8, 8, 4, 4, 4};
    static_assert(std::size(groups) == panels, "a panel was added: give it a group");
    return groups[static_cast<std::size_t>(panel)];
}
inline constexpr unsigned left_groups = 3, right_groups = 12;

enum class Column : std::uint8_t { left, right }; // one alone is the left one
inline constexpr const char* column_names[] = {"left", "right"};
inline constexpr int columns = static_cast<int>(std::size(column_names));
enum class ColumnPart : std::uint8_t { width, split, folded };
inline constexpr const char* column_part_names[] = {"width", "split", "folded"};

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
enum class FileFilter : std::uint8_t { everything, profiles, paths, heights, images, ramps, rules, packs };

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
