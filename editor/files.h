// Where the editor keeps what is its own between runs, and what a file that is to be opened is.
//
// Folders are XDG's: settings in $XDG_CONFIG_HOME/fjell (~/.config/fjell), changes that were not saved in
// $XDG_STATE_HOME/fjell (~/.local/state/fjell), the sample in $XDG_CACHE_HOME/fjell (~/.cache/fjell). Thread: the
// frame's, at what a hand does, never in a steady frame. Failure: io::Failure, but for settings, which nothing
// depends on: those that cannot be read are the defaults, with a problem to tell.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace fjell::editor {

struct Places {
    std::string config, state, cache; // folders, which need not exist yet; empty: there is no home
    std::string home;
};
[[nodiscard]] Places places();

inline constexpr std::size_t most_recent = 10;

struct Settings {
    std::vector<std::string> recent; // packs, the latest first
    std::string folder;              // that a dialogue looked at last
    double scale = 0;                // of the interface; 0: the desktop's
    friend bool operator==(const Settings&, const Settings&) = default;
};
// problem: one line when there is a file that cannot be read, or is none of ours; the defaults then.
[[nodiscard]] Settings read_settings(const std::string& config_folder, std::string& problem);
// Makes the folder.
void write_settings(const std::string& config_folder, const Settings& settings);
// path becomes the first, made absolute; no path is there twice, and no more than most_recent are.
void remember(std::vector<std::string>& recent, const std::string& path);

enum class FileKind : std::uint8_t { pack, profile, path, heights };
// Told from the content. heights: what GDAL opens as a raster, a landscape of content/terrain, or a recipe of
// fjell-bake. Throws Failure (1) for anything else, in one line.
[[nodiscard]] FileKind kind_of(const std::string& path);

} // namespace fjell::editor
