#include <algorithm>
#include <cmath>
#include <cstring>

#include "fjell/gl/palette.h"
#include "fjell/texture.h"
#include "gl/state.h"

namespace fjell::gl {

namespace {

void set4(float (&to)[4], double a, double b, double c, double d) {
    const double from[4] = {a, b, c, d};
    for (int i = 0; i < 4; ++i) to[i] = static_cast<float>(from[i]);
}

void set_colour(float (&to)[4], const Rgb8& srgb, double opacity) {
    set4(to, to_linear(srgb[0]), to_linear(srgb[1]), to_linear(srgb[2]), opacity);
}

// Camera-relative scene to clip space. w = d, the distance along forward; z = near (far - d) / (far - near), so that
// z / w is 1 at near and 0 at far: reversed, because a float's precision lies near 0, where perspective crowds depths.
void view_projection(const View& view, float (&columns)[16]) {
    const double wide = view.right - view.left, high = view.top - view.bottom, range = view.far_m - view.near_m;
    const Vec3 right = (cross(view.forward, view.up) * 2 - view.forward * (view.right + view.left)) * (1 / wide);
    const Vec3 up = (view.up * 2 - view.forward * (view.top + view.bottom)) * (1 / high);
    const double r[3] = {right.x, right.y, right.z}, u[3] = {up.x, up.y, up.z};
    const double f[3] = {view.forward.x, view.forward.y, view.forward.z};
    for (int j = 0; j < 3; ++j) {
        columns[4 * j] = static_cast<float>(r[j]);
        columns[4 * j + 1] = static_cast<float>(u[j]);
        columns[4 * j + 2] = static_cast<float>(-view.near_m / range * f[j]);
        columns[4 * j + 3] = static_cast<float>(f[j]);
    }
    for (int i = 12; i < 16; ++i) columns[i] = 0;
    columns[14] = static_cast<float>(view.near_m * view.far_m / range);
}

// The eye's cell: positions are counted from its first sample (see shaders.cpp).
struct EyeCell {
    std::int64_t column, row;
};
EyeCell eye_cell(const View& view, double spacing_x, double spacing_z) {
    const auto cell = [](double metres, double spacing) {
        return static_cast<std::int64_t>(std::floor(std::clamp(metres / spacing, -1e9, 1e9)));
    };
    return {cell(view.eye_m.x, spacing_x), cell(view.eye_m.z, spacing_z)};
}

Rgb8 legend_rgb(Mode mode, int i, int tile_log2, int mips) {
    if (mode == Mode::error) return error_stops[std::min(i, 5)];
    if (mode == Mode::mips) return mip_rgb(std::min(i, mips - 1), mips);
    if (mode == Mode::residency) return step_rgb(std::min(i, tile_log2), tile_log2);
    return level_rgb(i, tile_log2);
}

std::uint32_t packed_tint(std::uint32_t column, std::uint32_t row) {
    std::uint32_t packed = 0;
    const Rgb8 rgb = tile_rgb(column, row);
    for (std::uint32_t i = 0; i < 3; ++i)
        packed |= static_cast<std::uint32_t>(std::lround(to_linear(rgb[i]) * 1023)) << (10 * i);
    return packed;
}

} // namespace

FrameBlock Renderer::State::make_frame(const View& view, const DrawOptions& now) const {
    FrameBlock block{};
    view_projection(view, block.view_projection);
    const EyeCell cell = eye_cell(view, spacing_x_m, spacing_z_m);
    const double high = static_cast<float>(view.eye_m.y);
    set4(block.eye, view.eye_m.x - static_cast<double>(cell.column) * spacing_x_m,
         view.eye_m.z - static_cast<double>(cell.row) * spacing_z_m, high, view.eye_m.y - high);
    const SampleToTexel colour = sample_to_texel(header.colour_log2, header.tile_log2);
    const SampleToTexel normal = sample_to_texel(header.normal_log2, header.tile_log2);
    set4(block.grid, spacing_x_m, spacing_z_m, colour.scale, colour.offset);
    // Mode::distance begins a twentieth of a cell away, or its greys would lie where nothing is.
    const double near_m = std::max(view.near_m, 0.05 * std::min(spacing_x_m, spacing_z_m));
    const double farthest_m = std::max(1.5 * diagonal_m, 2 * near_m);
    set4(block.grid2, normal.scale, normal.offset, near_m, 1 / std::log2(farthest_m / near_m));
    const Vec3 right = cross(view.forward, view.up);
    const Vec3 middle =
        view.forward + right * ((view.right + view.left) / 2) + view.up * ((view.top + view.bottom) / 2);
    set4(block.haze, now.haze ? 1 : 0, middle.x, middle.y, middle.z);
    const Vec3 x = right * ((view.right - view.left) / 2), y = view.up * ((view.top - view.bottom) / 2);
    set4(block.ray_x, x.x, x.y, x.z, 0);
    set4(block.ray_y, y.x, y.y, y.z, 0);
    set4(block.line, 0.01, 0.01, 0.012, 1);
    set4(block.maps, 1u << header.colour_log2, 1u << header.normal_log2, maps.anisotropy,
         1.0 / (1u << residency_square_log2(header)));
    const std::uint32_t shown_log2 = maps.kind[0].present() ? header.colour_log2 : header.normal_log2;
    block.tile[0] = static_cast<std::int32_t>(header.tile_log2);
    block.tile[1] = static_cast<std::int32_t>(std::max(mip_count(shown_log2), 1u));
    block.tile[2] = static_cast<std::int32_t>(cell.column);
    block.tile[3] = static_cast<std::int32_t>(cell.row);
    const MorphFrame& m = morph_frame;
    if (m.morph != Morph::none) set4(block.morph, m.views, m.now_s, 1 / m.morph_s, morph_clock_s);
    for (std::uint32_t i = 0; i < m.views; ++i) {
        const MorphView& v = m.view[i];
        set4(block.morph_eye[i], v.eye_x - view.eye_m.x, v.eye_y - view.eye_m.y, v.eye_z - view.eye_m.z, 0);
        set4(block.morph_reach[i], v.start_per_error, v.full_per_error, 0, 0);
    }
    const bool blocks = header.order != PageOrder::linear;
    set_colour(block.tile_border, tile_border_rgb, now.tile_borders ? 1 : 0);
    set_colour(block.page_border, page_border_rgb, now.page_borders && blocks ? 0.8 : 0);
    set4(block.relief, now.contour_m > 0 ? 1 / now.contour_m : 0, now.slope ? 1 : 0, now.hatch ? 1 : 0, 0);
    block.last[0] = static_cast<std::int32_t>(header.columns) - 1;
    block.last[1] = static_cast<std::int32_t>(header.rows) - 1;
    set_light(view, now, block);
    if (now.mode == Mode::error) set_error(view, now, block);
    for (int i = 0; i < max_triangle_levels; ++i)
        set_colour(block.legend[i], legend_rgb(now.mode, i, block.tile[0], block.tile[1]), 1);
    return block;
}

void Renderer::State::set_error(const View& view, const DrawOptions& now, FrameBlock& block) const {
    const Vec3 eye = now.error_eye_m.value_or(view.eye_m) - view.eye_m;
    const double lambda = now.error_lambda_px > 0 ? now.error_lambda_px : focal_length_px(view);
    set4(block.error_eye, eye.x, eye.y, eye.z, lambda / now.error_full_px);
    block.last[2] = heights.columns;
    block.last[3] = heights.rows;
    block.heights[0] = heights.step_log2;
    block.heights[1] = heights.step_log2 < block.tile[0] ? 1 : 0;
    block.heights[2] = heights.wide;
    block.heights[3] = heights.high;
    // In units of 2^-24 of the largest height and the range: both heights are floats of two roundings (measure.cpp), 2;
    // two products and two sums on each surface, 8; the place, which weights and sums leave 2^-23 of a cell off, where
    // slopes differ by twice the range a cell at most, 4.
    const double largest =
        std::max(std::abs(static_cast<double>(header.min_m)), std::abs(static_cast<double>(header.max_m)));
    set4(block.rounding, 0x1p-20 * (largest + static_cast<double>(header.max_m) - static_cast<double>(header.min_m)), 0,
         0, 0);
}

TileBlock Renderer::State::make_tile(std::uint32_t tile, std::uint32_t index) const {
    TileBlock block{};
    const SampleIndex place = terrain.tile_place(tile);
    const auto column = static_cast<std::uint32_t>(place.column), row = static_cast<std::uint32_t>(place.row);
    block.column = static_cast<std::int32_t>(column << header.tile_log2);
    block.row = static_cast<std::int32_t>(row << header.tile_log2);
    block.index = static_cast<std::int32_t>(index);
    block.tile = static_cast<std::int32_t>(tile);
    std::int32_t* const layers[map_kinds] = {&block.colour_layer, &block.normal_layer, &block.horizon_layer,
                                             &block.splat_layer};
    std::int32_t* const arrays[map_kinds] = {&block.colour_array, &block.normal_array, &block.horizon_array,
                                             &block.splat_array};
    for (std::uint32_t kind = 0; kind < map_kinds; ++kind) {
        const MapArrays& of = maps.kind[kind];
        *arrays[kind] = -1;
        if (!of.present()) continue;
        const TileMap& map = of.tiles[tile];
        *layers[kind] = static_cast<std::int32_t>(map.layer);
        if (map.side_log2 != 0) *arrays[kind] = of.array_of[map.side_log2];
        (void)min_lod_grid(of.tiles, terrain, tile, block.mip[kind]);
    }
    // Whose mips shaders count themselves.
    const auto first_mip = [&](const MapArrays& of) {
        return static_cast<std::int32_t>(of.slots.top_log2 - of.tiles[tile].side_log2);
    };
    if (block.horizon_array >= 0) block.horizon_mip = first_mip(maps.kind[2]);
    if (block.splat_array >= 0) block.splat_mip = first_mip(maps.kind[3]);
    block.tint = packed_tint(column, row);
    return block;
}

DrawData Renderer::State::write_draw(const MeshView& view_mesh, const View& view, const DrawOptions& now) {
    const std::size_t ranges = std::max<std::size_t>(view_mesh.tiles.size(), 1); // a binding must not be empty
    ring.reserve(draw_bytes(ranges));
    DrawData data;
    const FrameBlock frame = make_frame(view, now);
    data.frame = ring.take(sizeof frame);
    std::memcpy(data.frame.data, &frame, sizeof frame);
    data.tiles = ring.take(ranges * sizeof(TileBlock));
    data.commands = ring.take(ranges * sizeof(DrawCommand));
    stats.tiles = stats.triangles = 0;
    std::uint32_t last_tile = 0;
    for (const TileRange& range : view_mesh.tiles) {
        if (range.index_count == 0) continue;
        if (stats.tiles == 0 || range.tile != last_tile) { // a tile's ranges follow each other
            last_tile = range.tile;
            const TileBlock block = make_tile(range.tile, stats.tiles);
            std::memcpy(data.tiles.data + stats.tiles++ * sizeof block, &block, sizeof block);
        }
        const DrawCommand command{range.index_count, 1, range.first_index, 0, stats.tiles - 1};
        std::memcpy(data.commands.data + data.command_count++ * sizeof command, &command, sizeof command);
        stats.triangles += range.triangles;
    }
    data.tile_bytes = std::max<std::size_t>(stats.tiles, 1) * sizeof(TileBlock);
    stats.ring_waits = ring.waits();
    return data;
}

// A draw's light: from the settings and the sky's tables to the numbers of the block `Frame`.

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
    put(block.layers_at, place(view.eye_m.x), place(view.eye_m.y), place(view.eye_m.z), 0);
    // A texel of a few millimetres is finer than a pixel from there on.
    const double fine_m = std::min(160.0, 0.5 * now.layers.distance_m);
    put(block.layers, now.layers.distance_m, now.layers.tint, now.layers.relief, fine_m);
    // Noise moves places by half a texel, but no further than its own patches are wide.
    const double cells = std::ldexp(1.0, static_cast<int>(header.tile_log2)),
                 texels = std::ldexp(1.0, static_cast<int>(header.splat_log2)), half = 0.5 / texels, most_m = 30;
    put(block.splat, texels, mip_count(header.splat_log2), std::min(half, most_m / (cells * spacing_x_m)),
        std::min(half, most_m / (cells * spacing_z_m)));
}

// The sky's light as the eye takes it in, and the light of sunlit ground. Film for daylight makes a clear sky's light
// navy, where the eye adapts; and slopes lie among other slopes, not on a plain: of what they see below the horizon
// most is lit. Where the ground hides the sky, other ground is seen in its place (block.bounce).
void Renderer::State::set_ambient(const SkyLight& ground, double sun_y, FrameBlock& block) const {
    constexpr float adapted = 0.55f, ground_albedo = 0.25f;
    const auto eased = [](Rgb c) {
        const float grey = luminance(c);
        return c * (1 - adapted) + Rgb{grey, grey, grey} * adapted;
    };
    // Slopes that face a low sun are lit more than level ground is.
    const double facing = std::clamp(0.7 * sun_y + 0.2, 0.0, 0.8);
    const Rgb lit =
        (ground.ambient[0] + ground.ambient[1] * 0.5f + ground.sun * static_cast<float>(facing / pi)) * ground_albedo;
    const Rgb bounce{1.08f * lit.r, lit.g, 0.86f * lit.b};
    put(block.ambient[0], eased(ground.ambient[0]) + bounce * 0.5f);
    put(block.ambient[1], eased(ground.ambient[1]) - bounce * 0.4f);
    put(block.ambient[2], eased(ground.ambient[2]));
    put(block.bounce, bounce);
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
    set_ambient(ground, sun.y, block);
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
    // Heights are stored to half a quantum, and both of them reach the shader as floats.
    const double same_m = 0.5 * static_cast<double>(header.quantum_m) +
                          0x1p-21 * std::max(std::abs(eye_m), std::abs(light.water_level_m));
    constexpr double shore_m = 0.15; // so deep that the surface is all there
    put(block.water, light.water_level_m - eye_m, wet ? 1 : 0, same_m, shore_m);
    put(block.water_tint, 0.30 * shrunk, 0.075 * shrunk, 0.05 * shrunk, 0);
    // A metre below the lowest ground, or the sea.
    const double around_m = std::min((wet ? light.water_level_m : low_m) - eye_m, -1.0);
    put(block.backdrop, wet ? Rgb{0.012f, 0.045f, 0.06f} : Rgb{0.17f, 0.155f, 0.125f}, around_m);
    put(block.surround, 1 / (surround_fade_diagonals * diagonal_m), 0, 0, 0);
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
