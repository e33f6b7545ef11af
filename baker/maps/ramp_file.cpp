// Ramps from files (content/README.md).
#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "baker/maps/colour.h"
#include "fjell/io/failure.h"
#include "io/file.h"
#include "io/json.h"

namespace fjell::baker {

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
