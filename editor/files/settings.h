// Settings that the editor keeps between runs, and the folders for them.
//
// Folders are XDG's: settings in $XDG_CONFIG_HOME/fjell (~/.config/fjell), changes that were not saved in
// $XDG_STATE_HOME/fjell (~/.local/state/fjell), the sample in $XDG_CACHE_HOME/fjell (~/.cache/fjell). Thread: the
// frame's, on user actions, never in a steady frame. Failure: writing throws io::Failure; settings that cannot be read
// become the defaults, with a problem to report.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace fjell::editor {

struct Folders {
    std::string config, state, cache; // folders, which need not exist yet; empty: there is no home
    std::string home;
};
[[nodiscard]] Folders standard_folders();

inline constexpr std::size_t most_recent = 10;

struct Settings {
    std::vector<std::string> recent; // packs, the latest first
    std::string folder;              // that a dialog looked at last
    double scale = 0;                // of the interface; 0: the desktop's
    friend bool operator==(const Settings&, const Settings&) = default;
};
// problem: one line when there is a file that cannot be read, or is none of ours; the defaults then.
[[nodiscard]] Settings read_settings(const std::string& config_folder, std::string& problem);
// Makes the folder.
void write_settings(const std::string& config_folder, const Settings& settings);
// path becomes the first, made absolute; no path is there twice, and no more than most_recent are.
void remember(std::vector<std::string>& recent, const std::string& path);

} // namespace fjell::editor
