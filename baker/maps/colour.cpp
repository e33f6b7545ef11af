#include "baker/maps/colour.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

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

} // namespace fjell::baker
