#include "fjell/profile.h"

#include <algorithm>
#include <optional>
#include <string>

#include <fmt/format.h>
#include <toml++/toml.h>

#include "fjell/io/failure.h"
#include "fjell/profile/keys.h"
#include "io/file.h"

namespace fjell {

namespace {

using io::Failure;

// What messages say of a unit.
std::string_view words(std::string_view unit) {
    return unit == "px" ? " (pixels)" : unit == "s" ? " (seconds)" : unit == "us" ? " (microseconds)" : "";
}

// The value, when it is one of the key's.
std::optional<double> read_value(const ProfileKey& key, const toml::node& node) {
    std::optional<double> value;
    switch (key.kind) {
    case KeyKind::number:
        if (node.is_number()) value = node.value<double>();
        break;
    case KeyKind::whole:
        if (const auto whole = node.value_exact<std::int64_t>()) value = static_cast<double>(*whole);
        break;
    case KeyKind::flag:
        if (const auto flag = node.value_exact<bool>()) value = *flag ? 1 : 0;
        break;
    case KeyKind::choice:
        if (const auto name = node.value_exact<std::string>())
            for (std::size_t i = 0; i < key.choices.size(); ++i)
                if (*name == key.choices[i]) value = static_cast<double>(i);
        break;
    }
    if (value && !(*value >= key.least && *value <= key.most)) value.reset();
    return value;
}

[[noreturn]] void fail(const std::string& name, const toml::node& node, const std::string& key,
                       const std::string& what) {
    throw Failure(1, fmt::format("{}:{}: {}: {}", name, node.source().begin.line, key, what));
}

std::string known_keys(std::string_view table) {
    std::string names;
    for (const ProfileKey& key : profile_keys())
        if (table == key.table) names += (names.empty() ? "" : ", ") + std::string(key.name);
    return names;
}

void read_table(const toml::table& table, const std::string& table_name, Profile& profile, const std::string& name,
                std::vector<std::string>* renamed) {
    for (const auto& [toml_key, node] : table) {
        const std::string full = fmt::format("{}.{}", table_name, toml_key.str());
        const ProfileKey* const key = find_profile_key(full);
        if (!key) fail(name, node, full, fmt::format("unknown key; [{}] has {}", table_name, known_keys(table_name)));
        if (toml_key.str() != key->name) {
            if (table.contains(key->name))
                fail(name, node, full, fmt::format("is now {}, which is there too", key->name));
            if (renamed)
                renamed->push_back(fmt::format("{}:{}: {} is called {}.{} now, and read by its old name until 0.4",
                                               name, node.source().begin.line, full, table_name, key->name));
        }
        const std::optional<double> value = read_value(*key, node);
        if (!value) fail(name, node, full, key_refusal(*key));
        key->set(profile, *value);
    }
}

} // namespace

Profile parse_profile(std::string_view text, const std::string& name, std::vector<std::string>* renamed) {
    toml::table root;
    try {
        root = toml::parse(text, name);
    } catch (const toml::parse_error& error) {
        const bool twice = error.description().find("redefine") != std::string_view::npos;
        throw Failure(1, fmt::format("{}:{}: {}", name, error.source().begin.line,
                                     twice ? "a key or a table is there twice; leave one of them"
                                           : "is not TOML; write [TABLE] and KEY = VALUE, one a line"));
    }
    Profile profile;
    for (const auto& [key, node] : root) {
        const std::string table_name(key.str());
        if (known_keys(table_name).empty())
            fail(name, node, table_name, "unknown table; a profile has refine, budget, stream and view");
        const toml::table* table = node.as_table();
        if (!table) fail(name, node, table_name, fmt::format("must be a table; write [{}]", table_name));
        read_table(*table, table_name, profile, name, renamed);
    }
    if (const std::string conflict = profile_conflict(profile); !conflict.empty())
        throw Failure(1, fmt::format("{}: {}", name, conflict));
    return profile;
}

std::string profile_conflict(const Profile& profile) {
    if (profile.refine.metric == Metric::depth && !profile.refine.cull)
        return "refine.metric \"depth\" needs refine.cull = true";
    return {};
}

std::string key_refusal(const ProfileKey& key) {
    switch (key.kind) {
    case KeyKind::number: return fmt::format("must be a number from {} to {}{}", key.least, key.most, words(key.unit));
    case KeyKind::whole: return fmt::format("must be a whole number from {} to {}", key.least, key.most);
    case KeyKind::flag: return "must be true or false";
    case KeyKind::choice: break;
    }
    return fmt::format("must be \"{}\"", fmt::join(key.choices, "\" or \""));
}

std::string parse_value(const ProfileKey& key, std::string_view text, double& value) {
    for (std::size_t i = 0; i < key.choices.size(); ++i)
        if (text == key.choices[i]) {
            value = static_cast<double>(i);
            return {};
        }
    if (text.find_first_of("\r\n#") != std::string_view::npos) return key_refusal(key); // more than a value
    try {
        const toml::table table = toml::parse(fmt::format("value = {}", text));
        if (const auto read = read_value(key, *table.get("value"))) {
            value = *read;
            return {};
        }
    } catch (const toml::parse_error&) { // what is no TOML is no value either
    }
    return key_refusal(key);
}

Profile read_profile(const std::string& file, std::vector<std::string>* renamed) {
    const std::vector<std::byte> bytes = io::read_file(file);
    return parse_profile({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, file, renamed);
}

StreamSettings stream_settings(const Profile& profile, double now_s) {
    StreamSettings settings = profile.stream;
    settings.now_s = now_s;
    return settings;
}

CutSettings cut_settings(const Profile& profile, double now_s) {
    CutSettings settings = profile.cut;
    settings.max_error_px = profile.refine.max_error_px;
    settings.corner_safe = profile.refine.corner_safe;
    settings.now_s = now_s;
    return settings;
}

void set_profile_key(Profile& profile, std::string_view key, std::string_view value) {
    const ProfileKey* const found = find_profile_key(key);
    if (!found) throw Failure(1, fmt::format("{}: unknown key; write TABLE.KEY as profiles/laptop.toml has them", key));
    double number = 0;
    if (const std::string refusal = parse_value(*found, value, number); !refusal.empty())
        throw Failure(1, fmt::format("{}: {}", key, refusal));
    Profile changed = profile;
    found->set(changed, number);
    if (const std::string conflict = profile_conflict(changed); !conflict.empty()) throw Failure(1, conflict);
    profile = changed;
}

io::LiveOptions live_options(const Profile& profile) {
    if (profile.method != Method::incremental)
        throw Failure(1, "refine.method is \"recursive\", which a LiveTerrain is not; set it to \"incremental\"");
    io::LiveOptions options;
    options.page_slots = profile.page_slots;
    options.cut = profile.cut_budget;
    options.stream = profile.stream_budget;
    options.stream.horizons = profile.light.shadows;
    options.reader.threads = profile.stream_budget.decoders;
    options.settings = {cut_settings(profile, 0), stream_settings(profile, 0)};
    return options;
}

// Profiles as text: what keys.h promises of writing them.

namespace {

constexpr std::size_t columns = 120;

constexpr const char* terms =
    "Flags of fjell-fly override this file. A key that is left out has its default. A key that "
    "is not listed here is refused. Keys of the method that is not chosen are kept until "
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

std::string profile_as_cpp(const Profile& profile) {
    std::string text = "fjell::Profile profile;\n";
    for (const ProfileKey* const key : differing_keys(Profile{}, profile)) {
        std::string value = value_text(*key, profile);
        if (key->kind == KeyKind::choice) value = value.substr(1, value.size() - 2); // without TOML's quotes
        text += fmt::format("fjell::set_profile_key(profile, \"{}.{}\", \"{}\");\n", key->table, key->name, value);
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

} // namespace fjell
