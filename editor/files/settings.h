// Settings that the editor keeps between runs, and the folders for them.
//
// Folders are XDG's: settings in $XDG_CONFIG_HOME/fjell (~/.config/fjell), changes that were not saved in
// $XDG_STATE_HOME/fjell (~/.local/state/fjell), the sample in $XDG_CACHE_HOME/fjell (~/.cache/fjell). Thread: the
// frame's, on user actions, never in a steady frame. Failure: writing throws io::Failure; settings that cannot be read
// become the defaults, with a problem to report.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "editor/arrangement.h"
#include "flight/options.h"

namespace fjell::editor {

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
    flight::PictureMode mode = flight::PictureMode::shaded;
    std::array<bool, overlays> overlay = first_overlays;
    bool half_resolution = true; // while the camera moves, where software draws
    friend bool operator==(const Look&, const Look&) = default;
};

struct Settings {
    std::vector<std::string> recent; // packs, the latest first
    std::string folder;              // that a dialog looked at last
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

} // namespace fjell::editor
