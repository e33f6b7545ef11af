#include "fjell/gl/palette.h"

#include <algorithm>
#include <cmath>

namespace fjell::gl {

namespace {

// Two hues that every kind of colour vision tells apart, each from dark to light, with the lightest in the middle:
// green between red and yellow would look like either to one in twenty.
constexpr Rgb8 level_stops[6] = {{110, 60, 190},  {60, 110, 235}, {110, 195, 245},
                                 {250, 240, 160}, {250, 165, 50}, {230, 70, 40}};
constexpr double odd_level_share = 0.52; // of the light of an even one

} // namespace

Rgb8 level_rgb(int level, int tile_log2) {
    const int deepest = std::max(1, 2 * tile_log2);
    const double t = 5 * std::clamp(static_cast<double>(level) / deepest, 0.0, 1.0);
    const auto i = static_cast<std::size_t>(std::min(t, 4.0));
    const double share = level % 2 == 0 ? 1 : odd_level_share;
    Rgb8 rgb{};
    for (std::size_t k = 0; k < 3; ++k) {
        const double from = level_stops[i][k], to = level_stops[i + 1][k];
        rgb[k] = static_cast<std::uint8_t>(std::lround(share * (from + (to - from) * (t - static_cast<double>(i)))));
    }
    return rgb;
}

Rgb8 step_rgb(int step_log2, int tile_log2) {
    return level_rgb(2 * (tile_log2 - step_log2), tile_log2);
}

Rgb8 mip_rgb(int mip, int mips) {
    const int coarsest = std::max(mips - 1, 1);
    return level_rgb(2 * (coarsest - mip), coarsest);
}

Rgb8 tile_rgb(std::uint32_t column, std::uint32_t row) {
    constexpr Rgb8 hue[4] = {{214, 122, 74}, {96, 160, 112}, {86, 130, 190}, {204, 176, 92}};
    const Rgb8 full = hue[column % 2 + 2 * (row % 2)];
    const unsigned share = 80 + 10 * ((column / 2 + row / 2) % 3); // of 100
    Rgb8 rgb{};
    for (std::size_t i = 0; i < 3; ++i) rgb[i] = static_cast<std::uint8_t>(full[i] * share / 100);
    return rgb;
}

double to_linear(std::uint8_t srgb) {
    const double c = srgb / 255.0;
    return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

Rgb8 error_rgb(double share) {
    if (share > 1) return error_stops[4];
    const double t = std::clamp((share - 0.1) / 0.3, 0.0, 3.0);
    const auto i = static_cast<std::size_t>(std::min(t, 2.0));
    Rgb8 rgb{};
    for (std::size_t k = 0; k < 3; ++k) {
        const double from = to_linear(error_stops[i][k]), to = to_linear(error_stops[i + 1][k]);
        const double light = from + (to - from) * (t - static_cast<double>(i));
        const double code = light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
        rgb[k] = static_cast<std::uint8_t>(std::lround(255 * code));
    }
    return rgb;
}

} // namespace fjell::gl
