#include "fly/profile.h"

#include <functional>
#include <type_traits>
#include <utility>
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

// Where a value goes.
template <typename Part, typename T>
auto at(Part Profile::*part, T Part::*field) {
    return [=](Profile& profile) -> T& { return profile.*part.*field; };
}
template <typename T>
auto at(T Profile::*field) {
    return [=](Profile& profile) -> T& { return profile.*field; };
}

template <typename Field>
Setter number(Field field, double least, double most, const char* unit = "") {
    return [=](const toml::node& node, Profile& profile) -> Problem {
        const auto value = node.value<double>();
        if (!node.is_number() || !value || !(*value >= least && *value <= most))
            return fmt::format("must be a number from {} to {}{}", least, most, unit);
        field(profile) = *value;
        return {};
    };
}

template <typename Field>
Setter whole(Field field, std::uint32_t least, std::uint32_t most) {
    return [=](const toml::node& node, Profile& profile) -> Problem {
        const auto value = node.value_exact<std::int64_t>();
        if (!value || *value < least || *value > most)
            return fmt::format("must be a whole number from {} to {}", least, most);
        field(profile) = static_cast<std::uint32_t>(*value);
        return {};
    };
}

template <typename Field>
Setter flag(Field field) {
    return [=](const toml::node& node, Profile& profile) -> Problem {
        const auto value = node.value_exact<bool>();
        if (!value) return "must be true or false";
        field(profile) = *value;
        return {};
    };
}

template <typename Field, typename T>
Setter choice(Field field, std::vector<std::pair<std::string, T>> choices) {
    return [=](const toml::node& node, Profile& profile) -> Problem {
        const auto value = node.value_exact<std::string>();
        std::string names;
        for (const auto& [name, meaning] : choices) {
            if (value == name) {
                field(profile) = meaning;
                return {};
            }
            names += (names.empty() ? "\"" : " or \"") + name + "\"";
        }
        return "must be " + names;
    };
}

// One key for both methods' vertex buffers: only one of them is made.
Problem set_vertices(const toml::node& node, Profile& profile) {
    const auto set = whole(at(&Profile::budget, &RecursiveBudget::vertices), min_budget, max_vertices);
    if (Problem problem = set(node, profile); !problem.empty()) return problem;
    profile.cut_budget.vertices = profile.budget.vertices;
    return {};
}

Problem set_items(const toml::node& node, Profile& profile) {
    const auto set = whole(at(&Profile::cut, &CutSettings::items), 0, max_items);
    if (Problem problem = set(node, profile); !problem.empty()) return problem;
    if (profile.cut.items == 0) profile.cut.items = unlimited_items;
    return {};
}

std::vector<Key> refine_keys() {
    return {
        {"refine", "method",
         choice(at(&Profile::method), std::vector<std::pair<std::string, Method>>{{"incremental", Method::incremental},
                                                                                  {"recursive", Method::recursive}})},
        {"refine", "error_px",
         number(at(&Profile::refine, &RefineSettings::error_px), min_error_px, max_error_px, " (pixels)")},
        {"refine", "corner_safe", flag(at(&Profile::refine, &RefineSettings::corner_safe))},
        {"refine", "hysteresis", number(at(&Profile::cut, &CutSettings::hysteresis), 0, max_hysteresis)},
        {"refine", "morph",
         choice(at(&Profile::cut, &CutSettings::morph),
                std::vector<std::pair<std::string, Morph>>{
                    {"none", Morph::none}, {"error", Morph::error}, {"time", Morph::time}})},
        {"refine", "morph_s", number(at(&Profile::cut, &CutSettings::morph_s), min_morph_s, max_morph_s, " (seconds)")},
        {"refine", "metric",
         choice(
             at(&Profile::refine, &RefineSettings::metric),
             std::vector<std::pair<std::string, Metric>>{{"isotropic", Metric::isotropic}, {"depth", Metric::depth}})},
        {"refine", "cull", flag(at(&Profile::refine, &RefineSettings::cull))},
        {"refine", "topology",
         choice(
             at(&Profile::refine, &RefineSettings::topology),
             std::vector<std::pair<std::string, Topology>>{{"list", Topology::triangles}, {"strip", Topology::strip}})},
    };
}

std::vector<Key> budget_keys() {
    return {
        {"budget", "vertices", set_vertices},
        {"budget", "triangles", whole(at(&Profile::cut_budget, &CutBudget::triangles), min_budget, max_triangles)},
        {"budget", "views", whole(at(&Profile::cut_budget, &CutBudget::views), 1, max_cut_views)},
        {"budget", "items", set_items},
        {"budget", "budget_us",
         number(at(&Profile::cut, &CutSettings::budget_us), 0, max_budget_us, " (microseconds)")},
        {"budget", "indices", whole(at(&Profile::budget, &RecursiveBudget::indices), min_budget, max_indices)},
    };
}

// Bytes, given in units of 1 << shift of them.
template <typename Field>
Setter bytes(Field field, int shift, std::uint32_t most) {
    return [=](const toml::node& node, Profile& profile) -> Problem {
        const auto value = node.value_exact<std::int64_t>();
        if (!value || *value < 1 || *value > most) return fmt::format("must be a whole number from 1 to {}", most);
        auto& to = field(profile);
        to = static_cast<std::remove_reference_t<decltype(to)>>(*value << shift);
        return {};
    };
}

std::vector<Key> stream_keys() {
    return {
        {"stream", "page_slots", whole(at(&Profile::page_slots), 1, max_page_slots)},
        {"stream", "page_requests",
         whole(at(&Profile::stream_budget, &StreamBudget::page_requests), 1, max_page_requests)},
        {"stream", "map_requests",
         whole(at(&Profile::stream_budget, &StreamBudget::map_requests), 1, max_map_requests)},
        {"stream", "map_mb", bytes(at(&Profile::stream_budget, &StreamBudget::map_bytes), 20, max_map_mb)},
        {"stream", "tail_log2",
         whole(at(&Profile::stream_budget, &StreamBudget::tail_log2), min_tail_log2, max_texture_log2)},
        {"stream", "texel_px",
         number(at(&Profile::stream, &StreamSettings::texel_px), min_texel_px, max_texel_px, " (pixels)")},
        {"stream", "lookahead_s",
         number(at(&Profile::stream, &StreamSettings::lookahead_s), 0, max_lookahead_s, " (seconds)")},
        {"stream", "fade_s", number(at(&Profile::stream, &StreamSettings::fade_s), 0, max_fade_s, " (seconds)")},
        {"stream", "pages", whole(at(&Profile::stream, &StreamSettings::pages), 1, max_stream_pages)},
        {"stream", "tests", whole(at(&Profile::stream, &StreamSettings::tests), min_stream_tests, 0xffffffff)},
        {"stream", "map_kb", bytes(at(&Profile::stream, &StreamSettings::map_bytes), 10, max_map_kb)},
    };
}

const std::vector<Key>& keys() {
    static const std::vector<Key> all = [] {
        std::vector<Key> keys = refine_keys();
        for (Key& key : budget_keys()) keys.push_back(std::move(key));
        for (Key& key : stream_keys()) keys.push_back(std::move(key));
        keys.push_back({"view", "width_px", whole(at(&Profile::width_px), 1, max_size_px)});
        keys.push_back({"view", "height_px", whole(at(&Profile::height_px), 1, max_size_px)});
        keys.push_back({"view", "fov_deg", number(at(&Profile::fov_deg), min_fov_deg, max_fov_deg)});
        return keys;
    }();
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
            fail(name, node, table_name, "unknown table; a profile has refine, budget, stream and view");
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

} // namespace fjell::fly
