// What a user of the editor reads stands in one file: its other sources hold ids, formats and names of files, no words.
#include <catch2/catch.hpp>

#include <algorithm>
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
const fs::path editor_folder = fs::path(FJELL_SOURCE_DIR) / "editor";

// What the command line says stands beside what it describes; its refusals do not.
const std::set<std::string> command_line{"options.cpp", "command.cpp", "path_commands.cpp", "study_commands.cpp",
                                         "command_words.h"};

std::string spaces_for(const std::string& text, const char* pattern) {
    return std::regex_replace(text, std::regex(pattern), " ");
}

struct Literal {
    std::size_t line = 0;
    std::string text;
    bool refuses = false; // in a statement that throws
    bool draws = false;   // the first argument of what draws a text
};

// Character by character: comments, shaders, the lines of includes and assertions, and the patterns of regular
// expressions are passed over.
std::vector<Literal> literals_of(const std::string& source) {
    static const std::regex token(
        R"re(//[^\n]*|#[^\n]*|static_assert[^;]*;|R"\([^"]*\)"|'(?:\\.|[^'\\])'|"((?:\\.|[^"\\])*)")re");
    static const std::regex pattern(R"(std::regex( \w+)?\($)"), refusal(R"(throw [^;{}]*$)");
    static const std::regex drawn(
        R"(\b(Text\w*|Button|SmallButton|MenuItem|BeginMenu|Checkbox|RadioButton|Selectable|TreeNode\w*|heading|row|fact|tip|AddText|plate)\(([^;"]*, )?$)");
    std::vector<Literal> found;
    std::size_t line = 1, counted = 0;
    for (std::sregex_iterator at(source.begin(), source.end(), token), end; at != end; ++at) {
        const auto place = static_cast<std::size_t>(at->position());
        for (; counted < place; ++counted) line += source[counted] == '\n';
        if (source[place] != '"') continue;
        // As far back as a statement of ours may reach.
        const std::string before =
            source.substr(place - std::min<std::size_t>(place, 240), std::min<std::size_t>(place, 240));
        if (std::regex_search(before, pattern)) continue;
        const std::size_t statement = before.find_last_of(";{}");
        const std::string own = statement == std::string::npos ? before : before.substr(statement + 1);
        found.push_back({line, (*at)[1].str(), std::regex_search(before, refusal), std::regex_search(own, drawn)});
    }
    return found;
}

// What is left to read of a format: not conversions, escapes, what ImGui hides, units, and names of files, options and
// variables.
bool has_words(const std::string& text) {
    static const std::set<std::string> units{"m",   "px",  "ms", "s", "us", "kB", "MB", "GB", "TB", "B",
                                             "deg", "fps", "x",  "h", "km", "k",  "K",  "M",  "G"};
    static const std::regex variable("[A-Z_]+"), option("--[a-z-]+( .*)?");
    if (std::regex_match(text, variable) || std::regex_match(text, option)) return false;
    std::string rest = text.substr(0, text.find("##"));
    if (rest.starts_with('/') || rest.starts_with('.')) return false;
    rest = spaces_for(rest, R"(%[-+ 0#]*(\*|[0-9]+)?(\.(\*|[0-9]+))?(hh|h|ll|l|z)?[diouxXfeEgGscp%])");
    rest = spaces_for(rest, R"(\\.)");
    rest = spaces_for(rest, R"(\{[^}]*\})");
    static const std::regex word("[A-Za-z]+");
    for (std::sregex_iterator at(rest.begin(), rest.end(), word), end; at != end; ++at)
        if (!units.contains(at->str())) return true;
    return false;
}

// A single word in lower case may be the id of a control or a key of the profile: only where it is drawn is it known to
// be a label.
bool is_id(const Literal& literal) {
    static const std::regex id(R"([a-z0-9_]+([.-]([a-z0-9_]+|%zu))*)");
    return !literal.draws && std::regex_match(literal.text, id);
}

// Of what no panel draws also lists of such words and names of files, and these.
bool is_name(const std::string& text) {
    static const std::set<std::string> others{
        "SwiftShader", // a driver's name
        "F ",          // how a line of a recorded path begins
        "#version 450 core",
    };
    static const std::regex name(R"([a-z0-9_./{}:,*-]+(\\n)?)"), line_of_csv(R"(([a-z0-9_]+,)+[a-z0-9_]+\\n)");
    return others.contains(text) || std::regex_match(text, name) || std::regex_match(text, line_of_csv);
}

struct Source {
    std::string name; // from the editor's folder on
    std::string text;
    bool panel = false;
};

std::vector<Source> sources() {
    std::vector<Source> all;
    for (const auto& entry : fs::recursive_directory_iterator(editor_folder)) {
        const std::string ending = entry.path().extension();
        if ((ending != ".cpp" && ending != ".h") || entry.path().filename() == "strings.h") continue;
        const std::string name = entry.path().lexically_relative(editor_folder);
        all.push_back({name, slurp(entry.path()), name.starts_with("panels/")});
    }
    return all;
}

} // namespace

TEST_CASE("what a user reads in the editor stands in the table of strings, and nowhere else") {
    std::size_t files = 0;
    for (const Source& source : sources()) {
        ++files;
        for (const Literal& literal : literals_of(source.text)) {
            if (command_line.contains(source.name) && !literal.refuses) continue;
            INFO("editor/" << source.name << ":" << literal.line << ": \"" << literal.text
                           << "\" belongs into editor/strings.h");
            CHECK((is_id(literal) || (!source.panel && is_name(literal.text)) || !has_words(literal.text)));
        }
    }
    CHECK(files > 120);
}

TEST_CASE("each string of the table is used in the editor, and stands there once") {
    const std::string table = slurp(editor_folder / "strings.h");
    std::string used;
    for (const Source& source : sources()) used += source.text;
    static const std::regex entry_of(
        R"re(namespace ([a-z_]+) \{|char ([a-z0-9_]+)\[\]\s*=\s*((?:"(?:\\.|[^"\\])*"\s*)+);)re");
    static const std::regex break_of(R"("\s+")"), use(R"(strings::[a-z_]+::[a-z0-9_]+)");
    std::set<std::string> names;
    for (std::sregex_iterator at(used.begin(), used.end(), use), end; at != end; ++at) names.insert(at->str());
    std::map<std::string, std::string> seen;
    std::string group;
    for (std::sregex_iterator at(table.begin(), table.end(), entry_of), end; at != end; ++at) {
        if ((*at)[1].matched) {
            group = (*at)[1].str();
            continue;
        }
        const std::string name = "strings::" + group + "::" + (*at)[2].str();
        INFO(name);
        CHECK(names.contains(name));
        const auto [there, is_new] = seen.emplace(std::regex_replace((*at)[3].str(), break_of, ""), name);
        INFO("the same text as " << there->second);
        CHECK(is_new);
    }
    CHECK(seen.size() > 600);
}
