#include "fly/profile.h"

#include <array>
#include <functional>
#include <vector>

#include <fmt/format.h>
#include <toml++/toml.h>

#include "host/failure.h"
#include "host/file.h"

namespace fjell::fly {

namespace {

using host::Failure;

// A value on its way from the file into the profile; its functions answer with what is wrong, or nothing.
using Problem = std::string;
using Setter = std::function<Problem(const toml::node&, Profile&)>;

struct Key {
    const char *table, *name;
    Setter set;
};

template <typename T>
Setter number(T Profile::*field, double least, double most) {
    return [=](const toml::node& node, Profile& profile) -> Problem {
        const auto value = node.value<double>();
        if (!node.is_number() || !value || !(*value >= least && *value <= most))
            return fmt::format("must be a number from {} to {}", least, most);
        profile.*field = static_cast<T>(*value);
        return {};
    };
}

template <typename T, typename Part>
Setter whole(Part Profile::*part, T Part::*field, std::uint32_t least, std::uint32_t most) {
    return [=](const toml::node& node, Profile& profile) -> Problem {
        const auto value = node.value_exact<std::int64_t>();
        if (!value || *value < least || *value > most)
            return fmt::format("must be a whole number from {} to {}", least, most);
        (profile.*part).*field = static_cast<T>(*value);
        return {};
    };
}

Setter pixels(std::uint32_t Profile::*field) {
    return [=](const toml::node& node, Profile& profile) -> Problem {
        const auto value = node.value_exact<std::int64_t>();
        if (!value || *value < 1 || *value > max_size_px)
            return fmt::format("must be a whole number from 1 to {}", max_size_px);
        profile.*field = static_cast<std::uint32_t>(*value);
        return {};
    };
}

Setter flag(bool RefineSettings::*field) {
    return [=](const toml::node& node, Profile& profile) -> Problem {
        const auto value = node.value_exact<bool>();
        if (!value) return "must be true or false";
        profile.refine.*field = *value;
        return {};
    };
}

template <typename T>
Setter choice(T RefineSettings::*field, std::vector<std::pair<std::string, T>> choices) {
    return [=](const toml::node& node, Profile& profile) -> Problem {
        const auto value = node.value_exact<std::string>();
        std::string names;
        for (const auto& [name, meaning] : choices) {
            if (value == name) {
                profile.refine.*field = meaning;
                return {};
            }
            names += (names.empty() ? "\"" : " or \"") + name + "\"";
        }
        return "must be " + names;
    };
}

Problem set_error_px(const toml::node& node, Profile& profile) {
    const auto value = node.value<double>();
    if (!node.is_number() || !value || !(*value >= min_error_px && *value <= max_error_px))
        return fmt::format("must be a number from {} to {} (pixels)", min_error_px, max_error_px);
    profile.refine.error_px = *value;
    return {};
}

Problem set_method(const toml::node& node, Profile&) {
    const auto value = node.value_exact<std::string>();
    if (value == "recursive") return {};
    if (value == "incremental") return "\"incremental\" is not in this version; give \"recursive\"";
    return "must be \"recursive\"";
}

const std::vector<Key>& keys() {
    static const std::vector<Key> all{
        {"refine", "method", set_method},
        {"refine", "error_px", set_error_px},
        {"refine", "metric",
         choice<Metric>(&RefineSettings::metric, {{"isotropic", Metric::isotropic}, {"depth", Metric::depth}})},
        {"refine", "cull", flag(&RefineSettings::cull)},
        {"refine", "corner_safe", flag(&RefineSettings::corner_safe)},
        {"refine", "topology",
         choice<Topology>(&RefineSettings::topology, {{"list", Topology::triangles}, {"strip", Topology::strip}})},
        {"budget", "vertices", whole(&Profile::budget, &RecursiveBudget::vertices, min_budget, max_vertices)},
        {"budget", "indices", whole(&Profile::budget, &RecursiveBudget::indices, min_budget, max_indices)},
        {"view", "width_px", pixels(&Profile::width_px)},
        {"view", "height_px", pixels(&Profile::height_px)},
        {"view", "fov_deg", number(&Profile::fov_deg, min_fov_deg, max_fov_deg)},
    };
    return all;
}

[[noreturn]] void fail(const std::string& name, const toml::node& node, const std::string& key,
                       const std::string& what) {
    throw Failure(1, fmt::format("{}:{}: {}: {}", name, node.source().begin.line, key, what));
}

std::string known_keys(std::string_view table) {
    std::string names;
    for (const Key& key : keys())
        if (table == key.table) names += (names.empty() ? "" : ", ") + std::string(key.name);
    return names;
}

void read_table(const toml::table& table, const std::string& table_name, Profile& profile, const std::string& name) {
    for (const auto& [toml_key, node] : table) {
        const std::string_view key_name = toml_key.str();
        const std::string full = fmt::format("{}.{}", table_name, key_name);
        const Key* found = nullptr;
        for (const Key& key : keys())
            if (table_name == key.table && key_name == key.name) found = &key;
        if (!found) fail(name, node, full, fmt::format("unknown key; [{}] has {}", table_name, known_keys(table_name)));
        if (const Problem problem = found->set(node, profile); !problem.empty()) fail(name, node, full, problem);
    }
}

} // namespace

Profile parse_profile(std::string_view text, const std::string& name) {
    toml::table root;
    try {
        root = toml::parse(text, name);
    } catch (const toml::parse_error& error) {
        throw Failure(1, fmt::format("{}:{}: not TOML: {}", name, error.source().begin.line, error.description()));
    }
    Profile profile;
    for (const auto& [key, node] : root) {
        const std::string table_name(key.str());
        if (known_keys(table_name).empty())
            fail(name, node, table_name, "unknown table; a profile has refine, budget and view");
        const toml::table* table = node.as_table();
        if (!table) fail(name, node, table_name, fmt::format("must be a table; write [{}]", table_name));
        read_table(*table, table_name, profile, name);
    }
    if (profile.refine.metric == Metric::depth && !profile.refine.cull)
        throw Failure(1, fmt::format("{}: refine.metric \"depth\" needs refine.cull = true", name));
    return profile;
}

Profile read_profile(const std::string& file) {
    const std::vector<std::byte> bytes = host::read_file(file);
    return parse_profile({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, file);
}

} // namespace fjell::fly
