// Profiles as text: what profile_keys.h promises of writing them.
#include <algorithm>

#include <fmt/format.h>

#include "flight/profile_keys.h"

namespace fjell::flight {

namespace {

constexpr std::size_t columns = 120;

constexpr const char* terms = "Flags of fjell-fly win over this file; keys left out keep fjell's defaults. A key that "
                              "is not listed here is refused. Keys of the method that is not chosen wait until "
                              "--method chooses it.";

// What may stand in a line of TOML's comments: a space instead of what parts words, and of what no comment may hold.
bool parts_words(char c) {
    return c == ' ' || static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
}

// As lines of a comment. Bytes count as columns; a word that is longer than a line has one to itself.
std::string comment(std::string_view text) {
    std::string lines;
    std::size_t column = 0;
    for (std::size_t at = 0; at < text.size();) {
        std::size_t end = at;
        while (end < text.size() && !parts_words(text[end])) ++end;
        const std::string_view word = text.substr(at, end - at);
        at = end + 1;
        if (word.empty()) continue;
        if (column != 0 && column + 1 + word.size() > columns) {
            lines += '\n';
            column = 0;
        }
        if (column == 0) lines += '#';
        lines += ' ';
        lines += word;
        column += (column == 0 ? 2 : 1) + word.size();
    }
    if (column != 0) lines += '\n';
    return lines;
}

} // namespace

std::string value_text(const ProfileKey& key, const Profile& profile) {
    const double value = key.get(profile);
    switch (key.kind) {
    case KeyKind::flag: return value != 0 ? "true" : "false";
    case KeyKind::choice: return fmt::format("\"{}\"", key.choices[static_cast<std::size_t>(value)]);
    case KeyKind::whole: return fmt::format("{}", static_cast<std::int64_t>(value));
    case KeyKind::number: break;
    }
    std::string text = fmt::format("{}", value); // the shortest that reads back to the same
    if (text.find_first_of(".e") == std::string::npos) text += ".0";
    return text;
}

std::string profile_text(const Profile& profile, std::string_view heading) {
    std::string text = comment(heading);
    if (!text.empty()) text += "#\n";
    text += comment(terms);
    for (const ProfileTable& table : profile_tables()) {
        text += fmt::format("\n[{}]\n", table.name);
        if (table.about) text += comment(table.about) + '\n';
        bool first = true;
        for (const ProfileKey& key : profile_keys()) {
            if (std::string_view(key.table) != table.name) continue;
            if (!first) text += '\n';
            first = false;
            text += comment(key.about);
            text += fmt::format("{} = {}\n", key.name, value_text(key, profile));
        }
    }
    return text;
}

std::string profile_heading(std::string_view text) {
    std::string heading;
    while (text.starts_with("# ")) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        std::string_view line = text.substr(2, end - 2);
        if (line.ends_with('\r')) line.remove_suffix(1);
        if (!heading.empty()) heading += ' ';
        heading += line;
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return heading == terms ? std::string() : heading;
}

} // namespace fjell::flight
