#include "flight/profile.h"

#include <optional>
#include <string>

#include <fmt/format.h>
#include <toml++/toml.h>

#include "fjell/io/failure.h"
#include "flight/profile_keys.h"
#include "io/file.h"

namespace fjell::flight {

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

void read_table(const toml::table& table, const std::string& table_name, Profile& profile, const std::string& name) {
    for (const auto& [toml_key, node] : table) {
        const std::string full = fmt::format("{}.{}", table_name, toml_key.str());
        const ProfileKey* const key = find_profile_key(full);
        if (!key) fail(name, node, full, fmt::format("unknown key; [{}] has {}", table_name, known_keys(table_name)));
        const std::optional<double> value = read_value(*key, node);
        if (!value) fail(name, node, full, key_refusal(*key));
        key->set(profile, *value);
    }
}

} // namespace

Profile parse_profile(std::string_view text, const std::string& name) {
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
        read_table(*table, table_name, profile, name);
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

Profile read_profile(const std::string& file) {
    const std::vector<std::byte> bytes = io::read_file(file);
    return parse_profile({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, file);
}

StreamSettings stream_settings(const Profile& profile, double now_s) {
    StreamSettings settings = profile.stream;
    settings.now_s = now_s;
    return settings;
}

CutSettings cut_settings(const Profile& profile, double now_s) {
    CutSettings settings = profile.cut;
    settings.error_px = profile.refine.error_px;
    settings.corner_safe = profile.refine.corner_safe;
    settings.now_s = now_s;
    return settings;
}

} // namespace fjell::flight
