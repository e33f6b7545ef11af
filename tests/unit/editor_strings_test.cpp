// What a user of the editor reads stands in one file: the sources of its panels hold ids and formats, no words.
#include <catch2/catch.hpp>

#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "support/program.h"

using fjell::test::slurp;

namespace {

namespace fs = std::filesystem;
const fs::path panel_folder = fs::path(FJELL_SOURCE_DIR) / "editor/panels";

std::string spaces_for(const std::string& text, const char* pattern) {
    return std::regex_replace(text, std::regex(pattern), " ");
}

struct Literal {
    std::size_t line = 0;
    std::string text;
};

// Character by character: comments and the lines of includes and assertions are passed over.
std::vector<Literal> literals_of(const std::string& source) {
    static const std::regex token(R"re(//[^\n]*|#[^\n]*|static_assert[^;]*;|'(?:\\.|[^'\\])'|"((?:\\.|[^"\\])*)")re");
    std::vector<Literal> found;
    std::size_t line = 1, counted = 0;
    for (std::sregex_iterator at(source.begin(), source.end(), token), end; at != end; ++at) {
        const auto place = static_cast<std::size_t>(at->position());
        for (; counted < place; ++counted) line += source[counted] == '\n';
        if (source[place] == '"') found.push_back({line, (*at)[1].str()});
    }
    return found;
}

// What is left to read of a format: not conversions, escapes, what ImGui hides, units, and names of files.
bool has_words(const std::string& text) {
    static const std::set<std::string> units{"m",   "px", "ms", "s",  "us", "kB", "MB", "GB", "deg",
                                             "fps", "x",  "h",  "km", "k",  "K",  "M",  "G"};
    std::string rest = text.substr(0, text.find("##"));
    if (rest.starts_with('/') || rest.starts_with('.')) return false;
    rest = spaces_for(rest, R"(%[-+ 0#]*(\*|[0-9]+)?(\.(\*|[0-9]+))?(hh|h|ll|l|z)?[diouxXfeEgGscp%])");
    rest = spaces_for(rest, R"(\\.)");
    static const std::regex word("[A-Za-z]+");
    for (std::sregex_iterator at(rest.begin(), rest.end(), word), end; at != end; ++at)
        if (!units.contains(at->str())) return true;
    return false;
}

// A single word in lower case may be the id of a control or a key of the profile: nothing here can tell it from a
// label.
bool is_id(const std::string& text) {
    static const std::regex id("[a-z0-9_]+([.-][a-z0-9_]+)*");
    return std::regex_match(text, id);
}

} // namespace

TEST_CASE("what a user reads in the panels stands in the table of strings, and nowhere else") {
    std::size_t files = 0;
    for (const auto& entry : fs::directory_iterator(panel_folder)) {
        ++files;
        for (const Literal& literal : literals_of(slurp(entry.path()))) {
            INFO(entry.path().filename().string()
                 << ":" << literal.line << ": \"" << literal.text << "\" belongs into editor/strings.h");
            CHECK((is_id(literal.text) || !has_words(literal.text)));
        }
    }
    CHECK(files > 40);
}

TEST_CASE("each string of the table is shown by a panel, and stands there once") {
    const std::string table = slurp(fs::path(FJELL_SOURCE_DIR) / "editor/strings.h");
    std::string sources;
    for (const auto& entry : fs::directory_iterator(panel_folder)) sources += slurp(entry.path());
    static const std::regex entry_of(
        R"re(namespace ([a-z_]+) \{|char ([a-z0-9_]+)\[\]\s*=\s*((?:"(?:\\.|[^"\\])*"\s*)+);)re");
    static const std::regex break_of(R"("\s+")");
    std::map<std::string, std::string> seen;
    std::string group;
    for (std::sregex_iterator at(table.begin(), table.end(), entry_of), end; at != end; ++at) {
        if ((*at)[1].matched) {
            group = (*at)[1].str();
            continue;
        }
        const std::string name = "strings::" + group + "::" + (*at)[2].str();
        INFO(name);
        CHECK(std::regex_search(sources, std::regex(name + "\\b")));
        const auto [there, is_new] = seen.emplace(std::regex_replace((*at)[3].str(), break_of, ""), name);
        INFO("the same text as " << there->second);
        CHECK(is_new);
    }
    CHECK(seen.size() > 500);
}
