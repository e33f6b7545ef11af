#include "session/layers_file.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "fjell/io/failure.h"
#include "io/file.h"
#include "io/json.h"

namespace fjell::session {

namespace {

using io::Failure;
using Json = nlohmann::json;

[[noreturn]] void refuse(const std::string& file, const std::string& what) {
    throw Failure(1, fmt::format("{}: {}; see content/materials/rules/alpine.json for rules that work", file, what));
}

struct RangeKey {
    const char* name;
    double (gl::LayerRule::*field)[2];
    double least, most; // open ends
};
constexpr RangeKey range_keys[] = {
    {"height_m", &gl::LayerRule::height_m, -gl::open_height_m, gl::open_height_m},
    {"slope_deg", &gl::LayerRule::slope_deg, 0, 90},
    {"noise", &gl::LayerRule::noise, 0, 1},
};

struct NumberKey {
    const char* name;
    double gl::LayerRule::*field;
    double least, most;
};
constexpr NumberKey number_keys[] = {
    {"height_soft_m", &gl::LayerRule::height_soft_m, 0, gl::open_height_m},
    {"slope_soft_deg", &gl::LayerRule::slope_soft_deg, 0, 90},
    {"noise_soft", &gl::LayerRule::noise_soft, 0, 1},
    {"fine", &gl::LayerRule::fine, 0, 1},
    {"ragged", &gl::LayerRule::ragged, 0, 2},
    {"opacity", &gl::LayerRule::opacity, 0, 1},
};

bool is_number(const Json& json, double least, double most) {
    return json.is_number() && json.get<double>() >= least && json.get<double>() <= most;
}

// [low, high]; null for an open end.
void parse_range(const std::string& file, const std::string& where, const Json& json, const RangeKey& key,
                 gl::LayerRule& rule) {
    const auto fail = [&] {
        refuse(file, fmt::format("{}: \"{}\" must be two numbers in {}..{}, the lower first, or null for no end", where,
                                 key.name, key.least, key.most));
    };
    if (!json.is_array() || json.size() != 2) fail();
    double ends[2] = {key.least, key.most};
    for (std::size_t i = 0; i < 2; ++i) {
        if (json[i].is_null()) continue;
        if (!is_number(json[i], key.least, key.most)) fail();
        ends[i] = json[i].get<double>();
    }
    if (ends[0] > ends[1]) fail();
    std::copy(ends, ends + 2, rule.*key.field);
}

std::string names_of(const io::Materials& materials) {
    std::string names;
    for (const io::MaterialRecord& r : materials.records) names += (names.empty() ? "" : ", ") + std::string(r.name);
    return names;
}

gl::LayerRule parse_rule(const std::string& file, const Json& json, std::size_t number,
                         const io::Materials& materials) {
    std::string where = fmt::format("rule {}", number);
    if (!json.is_object()) refuse(file, where + " must be a JSON object");
    if (!json.contains("layer") || !json["layer"].is_string())
        refuse(file, where + ": \"layer\" must name a material, one of " + names_of(materials));
    const std::string name = json["layer"].get<std::string>();
    where += fmt::format(" ({})", name);
    const int material = materials.find(name);
    if (material < 0) refuse(file, where + ": there is no such material; there are " + names_of(materials));
    gl::LayerRule rule;
    rule.material = static_cast<std::uint32_t>(material);
    for (const auto& [key, value] : json.items()) {
        const auto is_key = [&key = key](const auto& known) { return key == known.name; };
        if (key == "layer" || key == "comment") continue;
        if (const auto range = std::ranges::find_if(range_keys, is_key); range != std::end(range_keys)) {
            parse_range(file, where, value, *range, rule);
            continue;
        }
        const auto known = std::ranges::find_if(number_keys, is_key);
        if (known == std::end(number_keys)) refuse(file, fmt::format("{}: unknown field \"{}\"", where, key));
        if (!is_number(value, known->least, known->most))
            refuse(file, fmt::format("{}: \"{}\" must be a number in {}..{}", where, key, known->least, known->most));
        rule.*known->field = value.get<double>();
    }
    return rule;
}

} // namespace

std::vector<gl::LayerRule> parse_layer_rules(const std::string& text, const std::string& file,
                                             const io::Materials& materials) {
    const Json json = io::parse_json(text, file, io::JsonComments::yes);
    if (!json.is_object()) refuse(file, "is not a JSON object");
    for (const auto& [key, value] : json.items())
        if (key != "rules" && key != "comment") refuse(file, fmt::format("unknown field \"{}\"", key));
    if (!json.contains("rules") || !json["rules"].is_array() || json["rules"].empty() ||
        json["rules"].size() > gl::max_layer_rules)
        refuse(file, fmt::format("\"rules\" must be a list of 1 to {} rules", gl::max_layer_rules));
    std::vector<gl::LayerRule> rules;
    for (const Json& rule : json["rules"]) {
        const std::string at = fmt::format("{}:{}", file, io::line_of_item(text, "rules", rules.size()));
        rules.push_back(parse_rule(at, rule, rules.size(), materials));
    }
    return rules;
}

GroundLayers read_ground_layers(const std::string& materials, const std::string& rules) {
    GroundLayers layers;
    layers.file = io::read_file(materials);
    layers.materials = io::open_materials(layers.file, materials);
    if (!rules.empty()) layers.rules = parse_layer_rules(io::read_text(rules), rules, layers.materials);
    return layers;
}

} // namespace fjell::session
