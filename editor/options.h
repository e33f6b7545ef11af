// fjell-editor's command line.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace fjell::editor {

struct Options {
    std::string pack, profile, path;   // may be empty
    std::string materials, layers;     // of detail layers: both or neither
    std::string screenshot;            // of the last of so many frames
    std::size_t frames = 0;            // then it quits; 0: until it is closed
    std::string script;                // a file of commands, "-": standard input
    std::vector<std::string> commands; // --do: before the script's
    bool headless = false;
    std::uint32_t width = 0, height = 0; // 0: as last time, or 1280x720
    double scale = 0;                    // 0: the desktop's
    bool vsync = true;
};

// False when there is nothing left to do (--help, --version, --help-commands). Throws Failure 2.
[[nodiscard]] bool parse_options(int argc, char** argv, Options& options);

} // namespace fjell::editor
