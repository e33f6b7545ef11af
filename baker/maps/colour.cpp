#include "baker/maps/colour.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "fjell/io/failure.h"
#include "io/file.h"
#include "io/json.h"
#include "shared/compiler.h"

namespace fjell::baker {

namespace {

double linear_of(double srgb) { // 0..1
    return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}

// Codes change at the middles between them, in sRGB.
struct SrgbTable {
    std::array<std::uint8_t, 65536> code{};
    SrgbTable() {
        std::size_t v = 0;
        for (std::size_t i = 0; i < code.size(); ++i) {
            while (v < 255 && static_cast<double>(i) / 65535 >= linear_of((static_cast<double>(v) + 0.5) / 255)) ++v;
            code[i] = static_cast<std::uint8_t>(v);
        }
    }
};

void scale_heights(std::vector<Ramp::Stop>& stops, double least_m, double most_m) {
    if (!(most_m > least_m) && !stops.empty())
        stops.erase(stops.begin() + 1, stops.end()); // level ground has one colour, however heights round
    for (Ramp::Stop& stop : stops) stop.height_m = least_m + stop.height_m * (most_m - least_m);
}

float up_of(double degrees) {
    return static_cast<float>(std::cos(degrees * std::numbers::pi / 180));
}

} // namespace

LightOfSrgb::LightOfSrgb() {
    for (std::size_t v = 0; v < light_.size(); ++v)
        light_[v] = static_cast<float>(linear_of(std::min(static_cast<double>(v) / 255, 1.0)));
}
const LightOfSrgb& LightOfSrgb::table() {
    static const LightOfSrgb made;
    return made;
}

const std::uint8_t* srgb_of_light() {
    static const SrgbTable table;
    return table.code.data();
}

std::vector<RampPainter::Stop> RampPainter::prepare(const std::vector<Ramp::Stop>& stops) {
    std::vector<Stop> all;
    for (std::size_t i = 0; i < stops.size(); ++i) {
        Stop stop{static_cast<float>(stops[i].height_m), {}, {}};
        const bool last = i + 1 == stops.size();
        // Of a flat terrain a relative ramp's stops all stand at one height.
        const double rise = last ? 0 : static_cast<float>(stops[i + 1].height_m) - stop.height_m;
        for (std::size_t c = 0; c < 3; ++c) {
            stop.rgb[c] = static_cast<float>(stops[i].rgb[c]);
            stop.per_metre[c] = rise > 0 ? static_cast<float>((stops[i + 1].rgb[c] - stops[i].rgb[c]) / rise) : 0;
        }
        all.push_back(stop);
    }
    return all;
}

RampPainter::RampPainter(const Ramp& ramp) {
    layers_.push_back({0, 0, prepare(ramp.stops)});
    for (const Ramp::Layer& layer : ramp.slopes) {
        const float from = up_of(layer.from_degrees), to = up_of(layer.degrees);
        layers_.push_back({from, 1 / (from - to), prepare(layer.stops)});
    }
}

void RampPainter::ask(Layer& layer, float height_m, float (&rgb)[3]) {
    const std::vector<Stop>& stops = layer.stops;
    std::size_t at = layer.at;
    while (at > 0 && height_m < stops[at].height_m) --at;
    while (at + 1 < stops.size() && height_m >= stops[at + 1].height_m) ++at;
    layer.at = at;
    const float above = std::max(height_m - stops[at].height_m, 0.0f);
    for (std::size_t c = 0; c < 3; ++c) rgb[c] = stops[at].rgb[c] + above * stops[at].per_metre[c];
}

void RampPainter::paint(float height_m, float up, float (&rgb)[3]) {
    // From the last layer that covers all down to the flat: nothing under it shows.
    std::size_t first = layers_.size() - 1;
    while (first > 0 && (layers_[first].from_up - up) * layers_[first].per_up < 1) --first;
    ask(layers_[first], height_m, rgb);
    for (std::size_t i = first + 1; i < layers_.size() && up < layers_[i].from_up; ++i) {
        const float part = (layers_[i].from_up - up) * layers_[i].per_up;
        float over[3];
        ask(layers_[i], height_m, over);
        for (std::size_t c = 0; c < 3; ++c) rgb[c] += (over[c] - rgb[c]) * part;
    }
    for (float& v : rgb) v = std::clamp(v, 0.0f, 255.0f);
}

// ---- many texels side by side

namespace {

constexpr std::size_t piece_texels = 64;

FJELL_CLONES void replace_by_light(float* codes, std::size_t count, const float* light) {
    for (std::size_t i = 0; i < count; ++i) {
        const auto v = static_cast<std::int32_t>(codes[i]);
        codes[i] = light[v] + (light[v + 1] - light[v]) * (codes[i] - static_cast<float>(v));
    }
}

struct Extent {
    float least, most;
};
// In lanes, which the compiler may take side by side without reordering anything.
FJELL_CLONES Extent extent_of(const float* values, std::size_t count) {
    constexpr std::size_t lanes = 16;
    float least[lanes], most[lanes];
    std::fill_n(least, lanes, values[0]);
    std::fill_n(most, lanes, values[0]);
    std::size_t i = 0;
    for (; i + lanes <= count; i += lanes)
        for (std::size_t k = 0; k < lanes; ++k) {
            least[k] = values[i + k] < least[k] ? values[i + k] : least[k];
            most[k] = values[i + k] > most[k] ? values[i + k] : most[k];
        }
    for (; i < count; ++i) least[0] = std::min(least[0], values[i]), most[0] = std::max(most[0], values[i]);
    return {*std::min_element(least, least + lanes), *std::max_element(most, most + lanes)};
}

// Straight from `from` on, by per_metre a metre.
FJELL_CLONES void set_slope(const float* heights_m, std::size_t count, float from_m, float from, float per_metre,
                            float* FJELL_RESTRICT to) {
    for (std::size_t i = 0; i < count; ++i) {
        const float above = heights_m[i] - from_m;
        to[i] = from + (above > 0 ? above : 0) * per_metre;
    }
}
// The same from its height on; below, what is there stays.
FJELL_CLONES void set_slope_above(const float* heights_m, std::size_t count, float from_m, float from, float per_metre,
                                  float* FJELL_RESTRICT to) {
    for (std::size_t i = 0; i < count; ++i) {
        const float above = heights_m[i] - from_m, value = from + (above > 0 ? above : 0) * per_metre;
        to[i] = heights_m[i] >= from_m ? value : to[i];
    }
}

// How much of a layer shows on each texel: 1 or more covers all; 0 where nothing of it does, or where it does not reach
// down to a layer that shows. showing: of the layer before, and of this one afterwards. Returns whether any of it does.
FJELL_CLONES bool find_parts(const float* up, std::size_t count, float from_up, float per_up,
                             std::int32_t* FJELL_RESTRICT showing, float* FJELL_RESTRICT parts) {
    std::int32_t any = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const float part = (from_up - up[i]) * per_up;
        const std::int32_t all = !(part < 1), some = (up[i] < from_up) & showing[i];
        showing[i] = all | some;
        any |= showing[i];
        parts[i] = all ? 1.0f : some ? part : 0.0f;
    }
    return any != 0;
}

FJELL_CLONES void blend_parts(const float* parts, const float* over, std::size_t count, float* FJELL_RESTRICT to) {
    for (std::size_t i = 0; i < count; ++i) {
        const float mixed = to[i] + (over[i] - to[i]) * parts[i];
        to[i] = parts[i] < 1 ? mixed : over[i];
    }
}

FJELL_CLONES void clamp_codes(float* codes, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
        const float v = codes[i] < 0 ? 0 : codes[i];
        codes[i] = v > 255 ? 255 : v;
    }
}

} // namespace

void LightOfSrgb::replace(float* codes, std::size_t count) const {
    replace_by_light(codes, count, light_.data());
}

struct RampPainter::Piece {
    const float *heights_m, *up;
    std::size_t count;
    float least_m, most_m, most_up;
    std::int32_t showing[piece_texels];
};

// The stops that its heights lie between, from below; nearly always one or two.
void RampPainter::ask(const Layer& layer, const Piece& piece, float* const (&rgb)[3]) {
    const std::vector<Stop>& stops = layer.stops;
    std::size_t at = 0;
    while (at + 1 < stops.size() && piece.least_m >= stops[at + 1].height_m) ++at;
    for (std::size_t c = 0; c < 3; ++c)
        set_slope(piece.heights_m, piece.count, stops[at].height_m, stops[at].rgb[c], stops[at].per_metre[c], rgb[c]);
    for (++at; at < stops.size() && piece.most_m >= stops[at].height_m; ++at)
        for (std::size_t c = 0; c < 3; ++c)
            set_slope_above(piece.heights_m, piece.count, stops[at].height_m, stops[at].rgb[c], stops[at].per_metre[c],
                            rgb[c]);
}

void RampPainter::paint_piece(Piece& piece, float* const (&to)[3]) const {
    // As in paint(): nothing shows under a layer that covers all of the texels.
    std::size_t first = layers_.size() - 1;
    while (first > 0 && (layers_[first].from_up - piece.most_up) * layers_[first].per_up < 1) --first;
    ask(layers_[first], piece, to);
    std::fill_n(piece.showing, piece.count, 1);
    float parts[piece_texels], over[3][piece_texels];
    for (std::size_t i = first + 1; i < layers_.size(); ++i) {
        const Layer& layer = layers_[i];
        if (!find_parts(piece.up, piece.count, layer.from_up, layer.per_up, piece.showing, parts)) continue;
        ask(layer, piece, {over[0], over[1], over[2]});
        for (std::size_t c = 0; c < 3; ++c) blend_parts(parts, over[c], piece.count, to[c]);
    }
    for (float* const channel : to) {
        clamp_codes(channel, piece.count);
        LightOfSrgb::table().replace(channel, piece.count);
    }
}

void RampPainter::paint_light(const float* heights_m, const float* up, std::size_t count, float* const (&to)[3]) const {
    for (std::size_t from = 0; from < count; from += piece_texels) {
        const std::size_t n = std::min(piece_texels, count - from);
        const auto [least_m, most_m] = extent_of(heights_m + from, n);
        Piece piece{heights_m + from, up + from, n, least_m, most_m, extent_of(up + from, n).most, {}};
        paint_piece(piece, {to[0] + from, to[1] + from, to[2] + from});
    }
}

Ramp absolute(const Ramp& ramp, double least_m, double most_m) {
    Ramp metres = ramp;
    if (!ramp.relative) return metres;
    metres.relative = false;
    scale_heights(metres.stops, least_m, most_m);
    for (Ramp::Layer& layer : metres.slopes) scale_heights(layer.stops, least_m, most_m);
    return metres;
}

std::uint32_t fitting_log2(double texels_per_tile, std::uint32_t max_log2) {
    std::uint32_t log2 = 2;
    // An eighth too few is no visible loss, and saves three quarters of the bytes.
    while (log2 < max_log2 && static_cast<double>(std::uint32_t{1} << log2) * 1.125 < texels_per_tile) ++log2;
    return log2;
}

// Ramps from files (content/README.md).

using io::Failure;

namespace {

using Json = nlohmann::json;

[[noreturn]] void refuse(const std::string& path, const std::string& what) {
    throw Failure(1, fmt::format("{}: {}; see content/ramps/alpine.json for a ramp that works", path, what));
}

void parse_rgb(const std::string& path, const Json& rgb, const std::string& where, double (&to)[3]) {
    if (!rgb.is_array() || rgb.size() != 3) refuse(path, where + ": \"rgb\" must hold three numbers");
    for (std::size_t c = 0; c < 3; ++c) {
        to[c] = rgb[c].is_number() ? rgb[c].get<double>() : -1;
        if (!(to[c] >= 0 && to[c] <= 255)) refuse(path, where + ": \"rgb\" must hold numbers in 0..255");
    }
}

Ramp::Stop parse_stop(const std::string& path, const Json& json, const std::string& where) {
    if (!json.is_object() || json.size() != 2 || !json.contains("height_m") || !json.contains("rgb"))
        refuse(path, where + " must have \"height_m\" and \"rgb\" and nothing else");
    const Json& height = json["height_m"];
    if (!height.is_number() || std::abs(height.get<double>()) > 1e9)
        refuse(path, where + ": \"height_m\" must be a number in -1e9..1e9");
    Ramp::Stop stop{height.get<double>(), {}};
    parse_rgb(path, json["rgb"], where, stop.rgb);
    return stop;
}

// before: "" or "slope 2, ".
std::vector<Ramp::Stop> parse_stops(const std::string& path, const Json& list, const std::string& before) {
    if (!list.is_array() || list.size() < 2) refuse(path, before + "\"stops\" must be a list of at least two");
    std::vector<Ramp::Stop> stops;
    for (const Json& entry : list) {
        const std::string where = fmt::format("{}stop {}", before, stops.size());
        const Ramp::Stop stop = parse_stop(path, entry, where);
        if (!stops.empty() && stop.height_m <= stops.back().height_m)
            refuse(path, where + ": heights must rise from stop to stop");
        stops.push_back(stop);
    }
    return stops;
}

double parse_degrees(const std::string& path, const Json& json, const char* field, const std::string& where) {
    const Json& value = json[field];
    if (!value.is_number() || !(value.get<double>() >= 0 && value.get<double>() <= 90))
        refuse(path, fmt::format("{}: \"{}\" must be a number in 0..90", where, field));
    return value.get<double>();
}

Ramp::Layer parse_layer(const std::string& path, const Json& json, const std::string& where) {
    if (!json.is_object() || json.size() != 3 || !json.contains("from_degrees") || !json.contains("degrees") ||
        json.contains("rgb") == json.contains("stops"))
        refuse(path,
               where + " must have \"from_degrees\", \"degrees\", one of \"rgb\" and \"stops\", and nothing else");
    Ramp::Layer layer{
        parse_degrees(path, json, "from_degrees", where), parse_degrees(path, json, "degrees", where), {}};
    if (layer.degrees - layer.from_degrees < 0.1)
        refuse(path, where + ": \"degrees\" must be at least 0.1 above \"from_degrees\"");
    if (json.contains("stops")) {
        layer.stops = parse_stops(path, json["stops"], where + ", ");
    } else {
        layer.stops.resize(1);
        parse_rgb(path, json["rgb"], where, layer.stops[0].rgb);
    }
    return layer;
}

void parse_slopes(const std::string& path, const Json& list, Ramp& ramp) {
    if (!list.is_array()) refuse(path, "\"slopes\" must be a list");
    for (const Json& entry : list) {
        const std::string where = fmt::format("slope {}", ramp.slopes.size());
        Ramp::Layer layer = parse_layer(path, entry, where);
        if (!ramp.slopes.empty() && layer.from_degrees < ramp.slopes.back().degrees)
            refuse(path, where + ": must begin where the one before it ends, or later");
        ramp.slopes.push_back(std::move(layer));
    }
}

constexpr char alpine[] = {
#include "alpine.inc"
};
constexpr char sea[] = {
#include "sea.inc"
};

// Colours of the sea up to 0 and of the land from there on. Their slopes are the same: colour_test.cpp.
void add_below(const std::vector<Ramp::Stop>& water, std::vector<Ramp::Stop>& land) {
    land.insert(land.begin(), water.begin(), water.end());
}

} // namespace

Ramp parse_ramp(const std::string& text, const std::string& path) {
    const Json json = io::parse_json(text, path, io::JsonComments::yes);
    if (!json.is_object()) refuse(path, "is not a JSON object");
    for (const auto& [key, value] : json.items())
        if (key != "stops" && key != "relative" && key != "slopes" && key != "comment")
            refuse(path, fmt::format("unknown field \"{}\"", key));
    Ramp ramp;
    if (json.contains("relative")) {
        if (!json["relative"].is_boolean()) refuse(path, "\"relative\" must be true or false");
        ramp.relative = json["relative"].get<bool>();
    }
    ramp.stops = parse_stops(path, json.contains("stops") ? json["stops"] : Json(), "");
    if (json.contains("slopes")) parse_slopes(path, json["slopes"], ramp);
    return ramp;
}

Ramp read_ramp(const std::string& path) {
    return parse_ramp(io::read_text(path), path);
}

Ramp default_ramp() {
    return parse_ramp(std::string(alpine, std::size(alpine)), "the default ramp");
}

Ramp default_ramp(double least_m, double most_m) {
    if (least_m >= 0) return absolute(default_ramp(), least_m, most_m);
    const Ramp water = parse_ramp(std::string(sea, std::size(sea)), "the default ramp of the sea");
    if (most_m <= 0) return absolute(water, least_m, most_m);
    // Shallow beside the land's height is shallow water: a coast with some noise below 0 has no trenches.
    const double depth_m = std::max(-least_m, most_m / 10), shore_m = std::min(0.5, depth_m / 100);
    Ramp ramp = absolute(default_ramp(), 0, std::max(most_m, -least_m / 10)); // nor a low island snow
    const Ramp below = absolute(water, -depth_m, -shore_m);
    add_below(below.stops, ramp.stops);
    for (std::size_t i = 0; i < ramp.slopes.size(); ++i) add_below(below.slopes[i].stops, ramp.slopes[i].stops);
    return ramp;
}

} // namespace fjell::baker
