// The editor's enumerations and their names, as scripts and panels spell them.
#pragma once

#include <cstdint>
#include <iterator>

#include "flight/options.h"

namespace fjell::editor {

enum class Navigation : std::uint8_t { fly, orbit, path };
inline constexpr const char* navigation_names[] = {"fly", "orbit", "path"};

enum class Overlay : std::uint8_t { wireframe, tile_borders, page_borders, spheres, culled, error, path };
inline constexpr const char* overlay_names[] = {"wireframe", "tile-borders", "page-borders", "spheres",
                                                "culled",    "error",        "path"};
inline constexpr int overlays = static_cast<int>(std::size(overlay_names));

// Those of the left column, then those of the right one.
enum class Panel : std::uint8_t { tune, camera, show, time, budgets, streaming, levels };
inline constexpr const char* panel_names[] = {"tune", "camera", "show", "time", "budgets", "streaming", "levels"};
inline constexpr int panels = static_cast<int>(std::size(panel_names)), left_panels = 3;

// At most one is open, over everything else.
enum class Dialog : std::uint8_t {
    none,
    start, // nothing is open yet
    open_file,
    save_profile,
    save_path,
    compare,
    bake,
    tune,
    benchmark,
    snapshot,
    screenshot,
    keys,
    messages,
    unsaved, // before what would lose changes
    recover  // changes that an earlier run did not save
};
inline constexpr const char* dialog_names[] = {"none",       "start", "open",     "save-profile", "save-path",
                                               "compare",    "bake",  "tune",     "benchmark",    "export",
                                               "screenshot", "keys",  "messages", "unsaved",      "recover"};
inline constexpr int dialogs = static_cast<int>(std::size(dialog_names));

// To the question about unsaved changes.
enum class Answer : std::uint8_t { save, discard, cancel };
inline constexpr const char* answer_names[] = {"save", "discard", "cancel"};

} // namespace fjell::editor
