// What the command lines of our programs have in common, on top of CLI11.
#pragma once

#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "fjell/io/failure.h"

namespace fjell::io {

// CLI::Range lets NaN through: it is neither below nor above.
[[nodiscard]] inline CLI::Validator within(double least, double most) {
    const auto check = [=](const std::string& text) -> std::string {
        double value = 0;
        if (CLI::detail::lexical_cast(text, value) && value >= least && value <= most) return {};
        return fmt::format("{}: must be a number from {} to {}", text, least, most);
    };
    return {check, fmt::format("{} to {}", least, most)};
}

// False: it asked for the help or the version, which was printed. Throws Failure (2) with one line.
[[nodiscard]] inline bool parse_command_line(CLI::App& app, int argc, char** argv, const char* program) {
    // An empty word is a shell variable that was never set. "Not given" would do what nobody asked for.
    for (int i = 1; i < argc; ++i) {
        const std::string word = argv[i];
        if (word.empty())
            throw Failure(
                2, fmt::format("an empty word after {}: is a shell variable not set?", i > 1 ? argv[i - 1] : program));
        if (word.starts_with("--") && word.ends_with("="))
            throw Failure(2, fmt::format("{}: nothing after =; is a shell variable not set?", word));
    }
    try {
        app.parse(argc, argv);
    } catch (const CLI::Success& done) {
        (void)app.exit(done);
        return false;
    } catch (const CLI::ParseError& error) {
        throw Failure(2, fmt::format("{}; see {} --help", error.what(), program));
    }
    return true;
}

} // namespace fjell::io
