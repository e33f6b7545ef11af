// fjell-editor: tunes thresholds and budgets over a terrain, by eye and by number. Exit codes: 0 done, 1 the input is
// at fault, 2 usage, 3 the machine (disk, memory, GPU) is.
#include <charconv>
#include <cstdio>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "editor/app.h"
#include "editor/command.h"
#include "fjell/io/failure.h"
#include "fjell/version.h"
#include "io/command_line.h"

namespace fjell::editor {

namespace {

using io::Failure;

void read_size(const std::string& text, Options& options) {
    const char* const end = text.data() + text.size();
    const auto [cross, first] = std::from_chars(text.data(), end, options.width);
    if (first == std::errc{} && cross != end && *cross == 'x') {
        const auto [last, second] = std::from_chars(cross + 1, end, options.height);
        const auto fits = [](std::uint32_t px) { return px >= 320 && px <= 8192; };
        if (second == std::errc{} && last == end && fits(options.width) && fits(options.height)) return;
    }
    throw Failure(2, fmt::format("--size {}: must be WIDTHxHEIGHT, 320 to 8192 each", text));
}

// False when there is nothing left to do (--help, --version, --help-commands). Throws Failure 2.
bool parse_options(int argc, char** argv, Options& options) {
    CLI::App app("Tunes thresholds and budgets over a terrain, by eye and by number.", "fjell-editor");
    std::string size;
    bool help_commands = false, no_vsync = false;
    app.add_option("PACK", options.pack,
                   "the terrain: a pack, or heights to bake (with --headless the pack is written beside them and never "
                   "replaces a file); default: the start page");
    app.add_option("--profile", options.profile, "the profile to tune (profiles/*.toml)");
    app.add_option("--path", options.path, "a camera path (content/paths/*.json)");
    auto* const materials =
        app.add_option("--materials", options.materials, "textures of near ground: a file of fjell-bake materials");
    app.add_option("--layers", options.layers,
                   "rules that place the materials, if the pack has no splat maps (content/materials/rules/*.json)")
        ->needs(materials);
    app.add_option("--screenshot", options.screenshot, "writes the window as PNG after --frames, and quits");
    app.add_option("--frames", options.frames, "quits after so many frames")->check(io::whole_within(1, 1'000'000'000));
    app.add_option("--do", options.commands, "a command; may be repeated (see --help-commands)")
        ->allow_extra_args(false);
    app.add_option("--script", options.script, "a file of commands, one a line; -: standard input");
    app.add_flag("--headless", options.headless, "no window: for scripts; quits when they are done");
    app.add_option("--size", size, "window in pixels, WIDTHxHEIGHT; default: as last time, or 1280x720");
    app.add_option("--scale", options.scale,
                   "scale of the interface, 0.5 to 4; default: as last time, or the desktop's")
        ->check(io::within(0.5, 4.0));
    app.add_flag("--no-vsync", no_vsync, "does not wait for vertical sync");
    app.add_flag("--help-commands", help_commands, "lists the commands of --do and --script");
    app.set_version_flag("--version", std::string("fjell-editor ") + FJELL_VERSION_STRING);
    if (!io::parse_command_line(app, argc, argv, "fjell-editor")) return false;
    if (help_commands) {
        fmt::print("{}", command_help());
        return false;
    }
    if (!size.empty()) read_size(size, options);
    options.vsync = !no_vsync;
    if (!options.screenshot.empty() && options.frames == 0) options.frames = 60;
    return true;
}

} // namespace

} // namespace fjell::editor

int main(int argc, char** argv) {
    return fjell::io::run_tool("fjell-editor", [&] {
        fjell::editor::Options options;
        if (!fjell::editor::parse_options(argc, argv, options)) return 0;
        fjell::io::catch_interrupts();
        return fjell::editor::App(std::move(options)).run();
    });
}
