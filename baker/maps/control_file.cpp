// The rules of control maps from JSON.
#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "baker/maps/control.h"
#include "baker/read/gdal_file.h"
#include "fjell/io/failure.h"
#include "fjell/io/materials.h"
#include "io/file.h"
#include "io/json.h"

namespace fjell::baker {

namespace {

using io::Failure;
using Json = nlohmann::json;

struct RangeKey {
    const char *name, *soft;
    ControlRange ControlRule::*field;
    double least, most; // of both numbers; an end there is open
    double most_soft, usual_soft;
    bool turns = false; // azimuths: low may be more than high
};
constexpr RangeKey range_keys[] = {
    {"height_m", "height_soft_m", &ControlRule::height_m, -1e6, 1e6, 1e6, 0},
    {"slope_deg", "slope_soft_deg", &ControlRule::slope_deg, 0, 90, 90, 0},
    {"curvature_per_km", "curvature_soft_per_km", &ControlRule::curvature, -1e6, 1e6, 1e6, 0},
    {"aspect_deg", "aspect_soft_deg", &ControlRule::aspect_deg, 0, 360, 180, 0, true},
    {"wetness", "wetness_soft", &ControlRule::wetness, -100, 100, 100, 1},
    {"noise", "noise_soft", &ControlRule::noise, 0, 1, 1, 0.1},
};
struct NumberKey {
    const char* name;
    double ControlRule::*field;
    double least, most;
};
constexpr NumberKey number_keys[] = {
    {"noise_m", &ControlRule::noise_m, 1, 1e6},
    {"fine", &ControlRule::fine, 0, 1},
    {"ragged", &ControlRule::ragged, 0, 2},
    {"opacity", &ControlRule::opacity, 0, 1},
};

bool is_number(const Json& json, double least, double most) {
    return json.is_number() && json.get<double>() >= least && json.get<double>() <= most;
}

std::optional<unsigned> whole_number(std::string_view text, int base, unsigned most) {
    unsigned value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
    if (error != std::errc() || end != text.data() + text.size() || value > most) return {};
    return value;
}

class RuleReader {
public:
    RuleReader(const std::string& text, const std::string& file) : text_(text), file_(file) { plan_.text = text; }

    ControlPlan read() {
        const Json json = io::parse_json(text_, file_, io::JsonComments::yes);
        if (!json.is_object()) throw Failure(1, fmt::format("{}: is not a JSON object{}", file_, see));
        for (const auto& [key, value] : json.items())
            if (key != "rules" && key != "comment")
                throw Failure(1, fmt::format("{}: unknown field \"{}\"{}", file_, key, see));
        if (!json.contains("rules") || !json["rules"].is_array() || json["rules"].empty() ||
            json["rules"].size() > max_control_rules)
            throw Failure(
                1, fmt::format("{}: \"rules\" must be a list of 1 to {} rules{}", file_, max_control_rules, see));
        for (const Json& rule : json["rules"]) add(rule);
        return std::move(plan_);
    }

private:
    static constexpr const char* see = "; docs/guides/materials.md has rules that work";

    [[noreturn]] void refuse(const std::string& what) const {
        throw Failure(1, fmt::format("{}:{}: rule {}{}: {}{}", file_, io::line_of_item(text_, "rules", number_),
                                     number_, name_.empty() ? "" : " (" + name_ + ")", what, see));
    }

    std::uint8_t layer_named(const Json& json, const char* where) {
        if (!json.is_string()) refuse(fmt::format("\"{}\" must name a material", where));
        const std::string name = json.get<std::string>();
        if (name.empty() || name.size() > io::max_material_name ||
            std::any_of(name.begin(), name.end(), [](unsigned char c) { return c < ' ' || c == 127; }))
            refuse(fmt::format("\"{}\" must name a material in 1 to {} characters", where, io::max_material_name));
        const auto known = std::ranges::find(plan_.names, name);
        if (known != plan_.names.end()) return static_cast<std::uint8_t>(known - plan_.names.begin());
        if (plan_.names.size() == max_control_names)
            refuse(fmt::format("\"{}\" would be the {}th material; a pack has {} at most", name, max_control_names + 1,
                               max_control_names));
        plan_.names.push_back(name);
        return static_cast<std::uint8_t>(plan_.names.size() - 1);
    }

    void add(const Json& json) {
        name_.clear();
        if (!json.is_object()) refuse("must be a JSON object");
        ControlRule rule;
        const int kinds = static_cast<int>(json.contains("layer")) + static_cast<int>(json.contains("classes")) +
                          static_cast<int>(json.contains("painted"));
        if (kinds != 1)
            refuse(kinds == 0 ? "names no layer; give \"layer\": a material, or \"classes\" or \"painted\": a raster"
                              : "\"layer\", \"classes\" and \"painted\" exclude each other; make rules of their own");
        if (json.contains("layer")) {
            rule.layer = layer_named(json["layer"], "layer");
            name_ = plan_.names[rule.layer];
        } else {
            add_raster(json);
            rule.raster = static_cast<int>(plan_.rasters.size()) - 1;
        }
        for (const auto& [key, value] : json.items()) take(json, key, value, rule);
        for (const RangeKey& known : range_keys)
            if (!(rule.*known.field).given && json.contains(known.soft) && known.field != &ControlRule::height_m &&
                known.field != &ControlRule::slope_deg && known.field != &ControlRule::noise)
                refuse(fmt::format("\"{}\" is of no use without \"{}\"", known.soft, known.name));
        plan_.rules.push_back(rule);
        ++number_;
    }

    void take(const Json& json, const std::string& key, const Json& value, ControlRule& rule) {
        for (const RangeKey& known : range_keys) {
            if (key == known.soft) {
                if (!is_number(value, 0, known.most_soft))
                    refuse(fmt::format("\"{}\" must be a number in 0..{}", key, known.most_soft));
                return;
            }
            if (key == known.name) return take_range(json, value, known, rule.*known.field);
        }
        for (const NumberKey& known : number_keys)
            if (key == known.name) {
                if (!is_number(value, known.least, known.most))
                    refuse(fmt::format("\"{}\" must be a number in {}..{}", key, known.least, known.most));
                rule.*known.field = value.get<double>();
                return;
            }
        const bool known = key == "layer" || key == "comment" || (key == "classes" && rule.raster >= 0) ||
                           (key == "layers" && json.contains("classes")) ||
                           ((key == "painted" || key == "colours" || key == "channels") && json.contains("painted"));
        if (!known) refuse(fmt::format("unknown field \"{}\"", key));
    }

    void take_range(const Json& json, const Json& value, const RangeKey& key, ControlRange& range) {
        const auto fail = [&] {
            refuse(fmt::format("\"{}\" must be two numbers in {}..{}{}, or null for no end", key.name, key.least,
                               key.most, key.turns ? ", clockwise" : ", the lower first"));
        };
        if (!value.is_array() || value.size() != 2) fail();
        double ends[2] = {key.least, key.most};
        for (std::size_t i = 0; i < 2; ++i) {
            if (value[i].is_null()) continue;
            if (!is_number(value[i], key.least, key.most)) fail();
            ends[i] = value[i].get<double>();
        }
        if (ends[0] > ends[1] && !key.turns) fail();
        range.given = true;
        range.low = ends[0], range.high = ends[1];
        range.open_low = !key.turns && ends[0] <= key.least;
        range.open_high = !key.turns && ends[1] >= key.most;
        range.soft = key.usual_soft;
        if (json.contains(key.soft) && json[key.soft].is_number()) range.soft = json[key.soft].get<double>();
    }

    void add_raster(const Json& json) {
        const bool classes = json.contains("classes");
        const char* const key = classes ? "classes" : "painted";
        if (!json[key].is_string() || json[key].get<std::string>().empty() ||
            json[key].get<std::string>().find('\0') != std::string::npos)
            refuse(fmt::format("\"{}\" must name a raster file", key));
        ControlRaster raster;
        raster.path = json[key].get<std::string>();
        name_ = raster.path;
        if (!is_gdal_name(raster.path) && std::filesystem::path(raster.path).is_relative())
            raster.path = (std::filesystem::path(file_).parent_path() / raster.path).lexically_normal().string();
        if (classes)
            read_classes(json, raster);
        else if (json.contains("colours") == json.contains("channels"))
            refuse("an image needs either \"colours\", {\"#rrggbb\": material}, or \"channels\", materials of red, "
                   "green, blue and alpha");
        else if (json.contains("colours"))
            read_colours(json["colours"], raster);
        else
            read_channels(json["channels"], raster);
        std::ranges::sort(raster.layers);
        raster.layers.erase(std::unique(raster.layers.begin(), raster.layers.end()), raster.layers.end());
        plan_.rasters.push_back(std::move(raster));
    }

    void read_classes(const Json& json, ControlRaster& raster) {
        if (!json.contains("layers") || !json["layers"].is_object() || json["layers"].empty())
            refuse("a raster of classes needs \"layers\", {\"class\": material}");
        raster.of_class.assign(65536, no_layer);
        for (const auto& [number, name] : json["layers"].items()) {
            const auto value = whole_number(number, 10, 65535);
            if (!value) refuse(fmt::format("class \"{}\" must be a whole number in 0..65535", number));
            raster.of_class[*value] = layer_named(name, "layers");
            raster.layers.push_back(raster.of_class[*value]);
        }
    }

    void read_colours(const Json& json, ControlRaster& raster) {
        raster.kind = ControlRaster::Kind::colours;
        if (!json.is_object() || json.empty() || json.size() > 64)
            refuse("\"colours\" must be 1 to 64 of {\"#rrggbb\": material}");
        for (const auto& [colour, name] : json.items()) {
            const auto value = colour.size() == 7 && colour[0] == '#'
                                   ? whole_number(std::string_view(colour).substr(1), 16, 0xffffff)
                                   : std::nullopt;
            if (!value) refuse(fmt::format("colour \"{}\" must be #rrggbb", colour));
            const std::uint8_t layer = layer_named(name, "colours");
            raster.colours.push_back(
                {{static_cast<std::uint8_t>(*value >> 16), static_cast<std::uint8_t>(*value >> 8 & 255),
                  static_cast<std::uint8_t>(*value & 255)},
                 layer});
            raster.layers.push_back(layer);
        }
    }

    void read_channels(const Json& json, ControlRaster& raster) {
        raster.kind = ControlRaster::Kind::weights;
        if (!json.is_array() || json.empty() || json.size() > 4)
            refuse("\"channels\" must be a list of 1 to 4 materials, null for a channel without");
        for (std::size_t i = 0; i < json.size(); ++i) {
            if (json[i].is_null()) continue;
            raster.of_channel[i] = layer_named(json[i], "channels");
            raster.layers.push_back(raster.of_channel[i]);
        }
        if (raster.layers.empty()) refuse("\"channels\" must name a material");
    }

    const std::string &text_, &file_;
    ControlPlan plan_;
    std::size_t number_ = 0;
    std::string name_; // of the rule that is read, for messages
};

} // namespace

std::string ControlPlan::stored_names() const {
    std::string all;
    for (const std::string& name : names) all += name + '\n';
    return all;
}

bool ControlPlan::wants_wetness() const {
    return std::ranges::any_of(rules, [](const ControlRule& rule) { return rule.wetness.given; });
}

ControlPlan parse_control(const std::string& text, const std::string& file) {
    return RuleReader(text, file).read();
}

ControlPlan read_control(const std::string& path) {
    return parse_control(io::read_text(path), path);
}

} // namespace fjell::baker
