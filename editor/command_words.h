// How a line of a script becomes a command: its words, and the table of verbs. For the files that list verbs alone.
//
// Thread: any. Failure: io::Failure (2) that names the word and what it must be.
#pragma once

#include <charconv>
#include <cmath>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "editor/command.h"
#include "fjell/io/failure.h"

namespace fjell::editor {

// The words after the verb. Quotes hold words with spaces together.
class Words {
public:
    explicit Words(std::vector<std::string> words) : words_(std::move(words)) {}

    [[nodiscard]] bool more() const { return at_ < words_.size(); }
    [[nodiscard]] std::string text(const char* what) {
        if (!more()) throw io::Failure(2, fmt::format("{} is missing", what));
        return words_[at_++];
    }
    [[nodiscard]] std::string text_or(std::string otherwise) { return more() ? words_[at_++] : std::move(otherwise); }
    [[nodiscard]] double number(const char* what) { return number_of(text(what), what); }
    [[nodiscard]] double number_or(double otherwise, const char* what) { return more() ? number(what) : otherwise; }
    [[nodiscard]] std::size_t count(const char* what) { return count_of(text(what), what); }
    // Whether the last word is that one; no other may be there.
    [[nodiscard]] bool flag(const char* name) {
        if (!more()) return false;
        const std::string word = text(name);
        if (word != name) throw io::Failure(2, fmt::format("{}: only {} may follow", word, name));
        return true;
    }
    [[nodiscard]] bool on() {
        const std::string word = text("on or off");
        if (word != "on" && word != "off") throw io::Failure(2, fmt::format("{}: must be on or off", word));
        return word == "on";
    }
    template <typename E>
    [[nodiscard]] E one_of(std::span<const char* const> names, const char* what) {
        const std::string word = text(what);
        std::string all;
        for (std::size_t i = 0; i < names.size(); ++i) {
            if (word == names[i]) return static_cast<E>(i);
            all += (all.empty() ? "" : ", ") + std::string(names[i]);
        }
        throw io::Failure(2, fmt::format("{}: no such {}; choose one of {}", word, what, all));
    }
    // NAME=VALUE words from here on.
    void options(const std::map<std::string, std::function<void(const std::string&)>>& known) {
        while (more()) {
            const std::string word = text("");
            const std::size_t sign = word.find('=');
            const auto found = sign == std::string::npos ? known.end() : known.find(word.substr(0, sign));
            if (found == known.end()) {
                std::string all;
                for (const auto& [name, set] : known) all += (all.empty() ? "" : ", ") + name + "=";
                throw io::Failure(2, fmt::format("{}: no such option; choose from {}", word, all));
            }
            found->second(word.substr(sign + 1));
        }
    }
    // NAME=..., which no file is called here; after a folder it may be.
    [[nodiscard]] bool is_option() const {
        const std::size_t sign = words_[at_].find('=');
        return sign != std::string::npos && sign != 0 && words_[at_].find('/') > sign;
    }
    void end() const {
        if (more()) throw io::Failure(2, fmt::format("{}: unexpected extra word", words_[at_]));
    }
    [[nodiscard]] static double number_of(const std::string& word, const char* what) {
        double value = 0;
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
        if (error != std::errc{} || end != word.data() + word.size() || !std::isfinite(value))
            throw io::Failure(2, fmt::format("{}: {} must be a number", word, what));
        return value;
    }
    [[nodiscard]] static std::uint32_t count_of(const std::string& word, const char* what, double least = 0,
                                                double most = 1e9) {
        const double value = number_of(word, what);
        if (!(value >= least && value <= most && value == std::floor(value)))
            throw io::Failure(2, fmt::format("{} must be a whole number from {} to {}", what, least, most));
        return static_cast<std::uint32_t>(value);
    }
    [[nodiscard]] static double number_in(const std::string& word, const char* what, double least, double most) {
        const double value = number_of(word, what);
        if (!(value >= least && value <= most))
            throw io::Failure(2, fmt::format("{} must be a number from {} to {}", what, least, most));
        return value;
    }

private:
    std::vector<std::string> words_;
    std::size_t at_ = 0;
};

struct Verb {
    const char *name, *words, *about;
    std::function<Command(Words&)> parse;
};

template <typename C>
std::function<Command(Words&)> plain() {
    return [](Words&) { return C{}; };
}
template <typename C>
std::function<Command(Words&)> with_path(bool needed) {
    return [=](Words& w) { return C{needed ? w.text("a file") : w.text_or("")}; };
}
template <typename C>
std::function<Command(Words&)> with_path_and_discard() {
    return [](Words& w) {
        const std::string path = w.text("a file");
        return C{path, w.flag("discard")};
    };
}
template <typename C>
std::function<Command(Words&)> with_switch() {
    return [](Words& w) { return C{w.on()}; };
}
template <typename C>
std::function<Command(Words&)> with_point() {
    return [](Words& w) { return C{w.count("a point, from 0")}; };
}

// study_commands.cpp: runs that were flown, pictures rendered beside the frame, bookmarks, comparison.
[[nodiscard]] std::vector<Verb> study_verbs();
// path_commands.cpp: points of the camera path, their times and targets.
[[nodiscard]] std::vector<Verb> path_verbs();

} // namespace fjell::editor
