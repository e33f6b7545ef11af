// What the command lines of our programs have in common, on top of CLI11.
#pragma once

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "fjell/io/failure.h"

namespace fjell::io {

// Our words instead of CLI11's. CLI::Range also lets NaN through: it is neither below nor above.
[[nodiscard]] inline CLI::Validator within(double least, double most) {
    const auto check = [=](const std::string& text) -> std::string {
        double value = 0;
        if (CLI::detail::lexical_cast(text, value) && value >= least && value <= most) return {};
        return fmt::format("{}: must be a number from {:g} to {:g}", text, least, most);
    };
    return {check, fmt::format("{:g} to {:g}", least, most)};
}
[[nodiscard]] inline CLI::Validator whole_within(std::uint64_t least, std::uint64_t most) {
    const auto check = [=](const std::string& text) -> std::string {
        std::uint64_t value = 0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (error == std::errc() && end == text.data() + text.size() && value >= least && value <= most) return {};
        return fmt::format("{}: must be a whole number from {} to {}", text, least, most);
    };
    return {check, fmt::format("{} to {}", least, most)};
}
[[nodiscard]] inline CLI::Validator one_of(const std::vector<std::string>& words) {
    const auto check = [=](const std::string& text) -> std::string {
        if (std::find(words.begin(), words.end(), text) != words.end()) return {};
        return fmt::format("{}: must be one of {}", text, fmt::join(words, ", "));
    };
    return {check, fmt::format("{{{}}}", fmt::join(words, ","))};
}

// What CLI11 found wrong, in our words; of our validators it says what they said.
[[nodiscard]] inline std::string command_line_problem(const CLI::App& app, const CLI::ParseError& error) {
    const std::string text = error.what(), no_number = "Could not convert: ";
    const auto after = [&](const std::string& part) { return text.substr(text.find(part) + part.size()); };
    const std::string name = text.substr(0, text.find(':'));
    if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr)
        return fmt::format("{}: no such option, or a word too many", after(": "));
    if (dynamic_cast<const CLI::RequiredError*>(&error) != nullptr)
        return fmt::format("{} is missing", text.substr(0, text.find(" is required")));
    if (text.starts_with(no_number)) {
        const std::string given = after(no_number);
        const CLI::Option* const option = app.get_option_no_throw(given.substr(0, given.find(' ')));
        const bool flag = option != nullptr && option->get_items_expected_max() == 0;
        return fmt::format("{}: {}", given, flag ? "takes no value" : "must be a number");
    }
    if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) == nullptr) return text;
    return fmt::format("{}: {}", name, text.ends_with("missing") ? "its value is missing" : "is there more than once");
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
        throw Failure(2, fmt::format("{}; see {} --help", command_line_problem(app, error), program));
    }
    return true;
}

} // namespace fjell::io
