// A draw's light: from the settings and the sky's tables to the numbers of the block `Frame`.
#include <algorithm>
#include <cmath>

#include "fjell/texture.h"
#include "gl/state.h"

namespace fjell::gl {
namespace {

constexpr double pi = 3.14159265358979323846;
constexpr double largest_model_m = 400'000; // terrain beyond that is a model of one that size (light.h)
constexpr double sun_lux = 128'000;         // above the air

void put(float (&to)[4], Rgb rgb, double w = 0) {
    to[0] = rgb.r, to[1] = rgb.g, to[2] = rgb.b, to[3] = static_cast<float>(w);
}
void put(float (&to)[4], double a, double b, double c, double d) {
    put(to, Rgb{static_cast<float>(a), static_cast<float>(b), static_cast<float>(c)}, d);
}

// The mean of exp(-h / height) on the way from one height to another, above zero.
double mean_density(double from_m, double to_m, double height_m) {
    const double a = std::max(from_m, 0.0) / height_m, b = std::max(to_m, 0.0) / height_m;
    return std::abs(b - a) < 1e-3 ? std::exp(-a) : (std::exp(-a) - std::exp(-b)) / (b - a);
}

// What a white card's light is multiplied by to be 1. Automatic: the card lies on the lowest ground, tilted towards a
// sun that is low. Film follows it for four of five stops, so that dusk is darker than noon.
double exposure_of(const LightSettings& light, const SkyLight& ground, double sun_y) {
    const double bias = std::exp2(light.exposure_bias_ev);
    if (light.exposure == Exposure::fixed) return bias * sun_lux / (1.2 * std::exp2(light.ev100));
    const double sky = pi * static_cast<double>(luminance(ground.ambient[0] + ground.ambient[1]));
    const double sun = static_cast<double>(luminance(ground.sun)) * std::clamp(sun_y + 0.25, 0.0, 1.0);
    return bias * pi / std::pow(std::max(sky + sun, 1e-3), 0.8);
}

// The power of two times `unit_m` that is nearest to `wish_m`: noise then repeats with the samples, wherever the eye
// is.
double nearest_power(double wish_m, double unit_m) {
    return unit_m * std::exp2(std::round(std::log2(wish_m / unit_m)));
}

} // namespace

void Renderer::State::set_noise(const View& view, FrameBlock& block, double shrunk) const {
    const std::uint32_t texels_log2 = maps.kind[0].present()   ? header.colour_log2
                                      : maps.kind[1].present() ? header.normal_log2
                                                               : header.tile_log2;
    const double texel_m = std::ldexp(spacing_x_m, static_cast<int>(header.tile_log2) - static_cast<int>(texels_log2));
    // The coarsest noise begins where the map's texels end.
    const double coarse_m = nearest_power(16 * texel_m, spacing_x_m);
    const double waves_m = nearest_power(48 / shrunk, spacing_x_m);
    put(block.noise_scale, 1 / coarse_m, 1 / waves_m, texel_m, 0);
    const double repeats_m = std::max({coarse_m, 4 * waves_m, spacing_x_m});
    const auto place = [&](double metres, double spacing, std::int32_t cell) {
        const double corner = cell * spacing;
        return std::fmod(corner, repeats_m) + (metres - corner);
    };
    put(block.noise_at, place(view.eye_m.x, spacing_x_m, block.tile[2]), view.eye_m.y,
        place(view.eye_m.z, spacing_z_m, block.tile[3]), 0);
}

void Renderer::State::set_layers(const View& view, const DrawOptions& now, FrameBlock& block) const {
    const auto place = [](double metres) { return metres - layer_period_m * std::floor(metres / layer_period_m); };
    put(block.layers_at, place(view.eye_m.x), place(view.eye_m.y), place(view.eye_m.z), ground_layers.one_mip ? 1 : 0);
    // A texel of a few millimetres is finer than a pixel from there on.
    const double fine_m = std::min(160.0, 0.5 * now.layers.distance_m);
    put(block.layers, now.layers.distance_m, now.layers.tint, now.layers.relief, fine_m);
    // Noise moves places by half a texel, but no further than its own patches are wide.
    const double cells = std::ldexp(1.0, static_cast<int>(header.tile_log2)),
                 texels = std::ldexp(1.0, static_cast<int>(header.control_log2)), half = 0.5 / texels, most_m = 30;
    put(block.control, texels, mip_count(header.control_log2), std::min(half, most_m / (cells * spacing_x_m)),
        std::min(half, most_m / (cells * spacing_z_m)));
}

void Renderer::State::set_light(const View& view, const DrawOptions& now, FrameBlock& block) const {
    const LightSettings& light = now.light;
    const Sky& tables = lighting.sky;
    const Vec3 sun = lighting.sun;
    const double shrunk = std::min(1.0, largest_model_m / std::max(diagonal_m, 1.0));
    const double low_m = header.min_m, high_m = std::max<double>(header.max_m, low_m + 1), eye_m = view.eye_m.y;
    const double altitude = std::max(eye_m * shrunk, 0.0);
    put(block.sun, sun.x, sun.y, sun.z, now.lit ? 1 : 0);
    const double level = std::hypot(sun.x, sun.z);
    const double at_slice = std::sqrt(std::clamp(altitude / sky_top_m, 0.0, 1.0)) * (sky_slices - 1);
    const double slice = std::min(std::floor(at_slice), sky_slices - 2.0);
    put(block.sun_level, level > 1e-9 ? sun.x / level : 1, level > 1e-9 ? sun.z / level : 0, slice, at_slice - slice);
    put(block.sun_low, sun_at(tables, low_m * shrunk, sun.y), low_m - eye_m);
    put(block.sun_high, sun_at(tables, high_m * shrunk, sun.y), 1 / (high_m - low_m));
    const SkyLight at_eye = light_at(tables, altitude), ground = light_at(tables, low_m * shrunk);
    for (std::size_t i = 0; i < 3; ++i) put(block.ambient[i], ground.ambient[i]);
    for (std::size_t i = 0; i < 5; ++i) put(block.source[i], at_eye.source[i]);
    put(block.sky_simple[0], at_eye.horizon);
    put(block.sky_simple[1], at_eye.zenith);
    put(block.sky_simple[2], at_eye.sun * 0.12f);
    const auto metre = static_cast<float>(shrunk);
    if ((light_bits & light_air) != 0) {
        const auto thin = [&](double height) { return metre * static_cast<float>(std::exp(-altitude / height)); };
        put(block.air[0], tables.rayleigh * thin(rayleigh_height_m), shrunk / rayleigh_height_m);
        put(block.air[1], tables.mie * thin(mie_height_m), shrunk / mie_height_m);
    } else {
        const auto mean = [&](double height) {
            return static_cast<float>(mean_density(altitude, low_m * shrunk, height));
        };
        put(block.air[0], (tables.rayleigh * mean(rayleigh_height_m) + tables.mie * mean(mie_height_m)) * metre);
    }
    const bool filmic = light.tone_curve == ToneCurve::filmic;
    // The curve gives middle grey back, and a little more, at twice the light.
    put(block.film, exposure_of(light, ground, sun.y) * (filmic ? 2.0 : 1.0), filmic ? 1 : 0, light.dither ? 1 : 0,
        std::fmod(now.time_s, 4096.0));
    const bool wet = light.water && eye_m > light.water_level_m;
    put(block.water, light.water_level_m - eye_m, wet ? 1 : 0, 0, 0);
    put(block.water_tint, 0.30 * shrunk, 0.075 * shrunk, 0.05 * shrunk, 0);
    // A metre below the lowest ground, or the sea.
    const double around_m = std::min((wet ? light.water_level_m : low_m) - eye_m, -1.0);
    put(block.backdrop, wet ? Rgb{0.012f, 0.045f, 0.06f} : Rgb{0.17f, 0.155f, 0.125f}, around_m);
    put(block.to_rim, view.eye_m.x, (header.columns - 1) * spacing_x_m - view.eye_m.x, view.eye_m.z,
        (header.rows - 1) * spacing_z_m - view.eye_m.z);
    set_noise(view, block, shrunk);
    set_layers(view, now, block);
    set_shadow(sun, block);
}

// Between which two directions of the horizon maps the sun stands. The penumbra is wider than the sun's disc, because
// texels and directions are interpolated: docs/notes/horizons.md.
void Renderer::State::set_shadow(const Vec3& sun, FrameBlock& block) const {
    constexpr double penumbra_sine = 0.02;
    const double turns = std::atan2(sun.x, -sun.z) / (2 * pi), at = (turns - std::floor(turns)) * horizon_directions;
    const auto before = static_cast<std::uint32_t>(at) % horizon_directions, after = (before + 1) % horizon_directions;
    put(block.shadow_plane, before % horizon_planes_across, before / horizon_planes_across,
        after % horizon_planes_across, after / horizon_planes_across);
    put(block.shadow, at - std::floor(at), penumbra_sine, std::uint32_t{1} << header.horizon_log2,
        mip_count(header.horizon_log2));
}

} // namespace fjell::gl
