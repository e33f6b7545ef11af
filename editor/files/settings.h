// Settings and bookmarks that the editor keeps between runs, and the folders for them.
//
// Folders are XDG's: settings in $XDG_CONFIG_HOME/fjell (~/.config/fjell), changes that were not saved in
// $XDG_STATE_HOME/fjell (~/.local/state/fjell), the sample in $XDG_CACHE_HOME/fjell (~/.cache/fjell). Thread: the
// frame's, on user actions, never in a steady frame. Failure: writing throws io::Failure; settings that cannot be read
// become the defaults, with a problem to report.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <optional>
#include <string>
#include <vector>

#include "editor/names.h"
#include "session/options.h"
#include "session/path.h"

namespace fjell::editor {

// A panel that floats over the picture instead of standing in a column. Pixels as below, from the window's corner.
struct FloatingPanel {
    bool on = false;
    float x_px = 0, y_px = 0, width_px = 360, height_px = 440; // the place is kept while it is docked
    friend bool operator==(const FloatingPanel&, const FloatingPanel&) = default;
};

// Pixels are those of a scale of 1.
struct Arrangement {
    bool panels = true; // shown at all
    std::array<bool, columns> folded{};
    std::array<float, columns> width_px{325, 325};
    std::array<float, columns> split{0.6F, 0.55F}; // the upper section's share of a column that stacks two
    std::array<Panel, editor::panels> latest;      // the one that was turned to last comes first
    std::array<FloatingPanel, editor::panels> floating{};
    std::array<bool, groups> open = first_groups;

    Arrangement() {
        for (std::size_t i = 0; i < latest.size(); ++i) latest[i] = static_cast<Panel>(i);
    }
    friend bool operator==(const Arrangement&, const Arrangement&) = default;

    void turn_to(Panel panel) {
        const auto at = std::find(latest.begin(), latest.end(), panel);
        std::rotate(latest.begin(), at, at + 1);
    }
    [[nodiscard]] bool floats(Panel panel) const { return floating[static_cast<std::size_t>(panel)].on; }
    // Of these sections (a bit each) the panel that was turned to last, of those that stand in a column.
    [[nodiscard]] Panel shown(unsigned bits) const {
        for (const Panel panel : latest)
            if ((bits & section_bit(panel)) != 0 && !floats(panel)) return panel;
        return latest.front();
    }
    // Those of these sections that have a panel in a column.
    [[nodiscard]] unsigned docked(unsigned bits) const {
        unsigned some = 0;
        for (const Panel panel : latest)
            if (!floats(panel)) some |= bits & section_bit(panel);
        return some;
    }
};
inline constexpr float least_column_px = 220, most_column_px = 800;
inline constexpr float least_floating_px = 180, most_floating_px = 4000;
inline constexpr float least_split = 0.15F, most_split = 0.85F;

struct Folders {
    std::string config, state, cache; // folders, which need not exist yet; empty: there is no home
    std::string home;
};
[[nodiscard]] Folders standard_folders();

inline constexpr std::size_t most_recent = 10;

// How the window looked last.
struct Look {
    double scale = 0;                          // of the interface; 0: the desktop's
    std::uint32_t width_px = 0, height_px = 0; // of the window; 0: the default's
    Arrangement arrangement;
    session::PictureMode mode = session::PictureMode::shaded;
    std::array<bool, overlays> overlay = first_overlays;
    bool half_resolution = true; // while the camera moves, where software draws
    double contour_m = 0;        // as Interface has it
    friend bool operator==(const Look&, const Look&) = default;
};

inline constexpr std::size_t most_packs_with_materials = 64;
struct PackMaterials {
    std::string pack;             // absolute
    std::string materials, rules; // as ChooseMaterials has them
    friend bool operator==(const PackMaterials&, const PackMaterials&) = default;
};

struct Settings {
    std::vector<std::string> recent;      // packs, the latest first
    std::vector<PackMaterials> materials; // that were chosen, the latest first
    std::string folder;                   // that a dialog looked at last
    Look look;
    friend bool operator==(const Settings&, const Settings&) = default;
};
// problem: one line when there is a file that cannot be read, or has keys that mean nothing; the defaults for those.
// Keys that are not there are no problem: an older editor did not write them.
[[nodiscard]] Settings read_settings(const std::string& config_folder, std::string& problem);
// Makes the folder. Keys of others stay; a file that read_settings() had a problem with is kept as editor.json.damaged.
void write_settings(const std::string& config_folder, const Settings& settings);
// path becomes the first, made absolute; no path is there twice, and no more than most_recent are.
void remember(std::vector<std::string>& recent, const std::string& path);

// --- Places that the user keeps, in bookmarks.json beside the settings.

inline constexpr std::size_t most_bookmarks = 64;

struct Bookmark {
    std::string name, pack; // the pack's absolute path: a bookmark is of one terrain
    session::Pose pose;
};

struct Bookmarks {
    std::vector<Bookmark> all;
    std::string pack; // whose bookmarks are shown: the open one's
};

// folder: of the settings. Without one nothing is read or written.
[[nodiscard]] std::vector<Bookmark> read_bookmarks(const std::string& folder, std::string& problem);
void write_bookmarks(const std::string& folder, const std::vector<Bookmark>& bookmarks);

// What ends the reading of a value in a file of the editor's own, where whoever reads names the file, or the key, and
// says what becomes of it. Nobody is shown it.
struct Unusable : std::exception {};

} // namespace fjell::editor
