#include <algorithm>
#include <cmath>
#include <cstring>

#include "fjell/gl/palette.h"
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
        set4(block.morph_reach[i], v.q_start, v.q_full, 0, 0);
    }
    const bool blocks = header.order != Order::linear;
    set_colour(block.tile_border, tile_border_rgb, now.tile_borders ? 1 : 0);
    set_colour(block.page_border, page_border_rgb, now.page_borders && blocks ? 0.8 : 0);
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
    const double lambda = now.error_lambda_px > 0 ? now.error_lambda_px : lambda_px(view);
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
    const Coord place = terrain.tile_place(tile);
    const auto column = static_cast<std::uint32_t>(place.x), row = static_cast<std::uint32_t>(place.y);
    block.column = static_cast<std::int32_t>(column << header.tile_log2);
    block.row = static_cast<std::int32_t>(row << header.tile_log2);
    block.index = static_cast<std::int32_t>(index);
    block.tile = static_cast<std::int32_t>(tile);
    std::int32_t* const layers[map_kinds] = {&block.colour_layer, &block.normal_layer, &block.horizon_layer,
                                             &block.control_layer};
    std::int32_t* const arrays[map_kinds] = {&block.colour_array, &block.normal_array, &block.horizon_array,
                                             &block.control_array};
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
    if (block.control_array >= 0) block.control_mip = first_mip(maps.kind[3]);
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

} // namespace fjell::gl
