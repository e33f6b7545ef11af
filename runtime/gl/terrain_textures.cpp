#include "gl/terrain_textures.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <epoxy/gl.h>

#include "fjell/pages.h"
#include "gl/fail.h"

namespace fjell::gl {

namespace {

constexpr float hole_m = -3e38f; // what the shader takes for one: below -1e38

void check(const HeightGrid& grid, const Terrain& terrain) {
    if (!terrain.valid()) fail("the terrain is destroyed; create it again, and a renderer for it");
    const auto along = [&](std::uint32_t extent) { // the last one at the rim or beyond
        return static_cast<std::int32_t>(((extent - 1 + (1u << grid.step_log2) - 1) >> grid.step_log2) + 1);
    };
    if (grid.step_log2 > terrain.header().tile_log2)
        fail("HeightGrid::step_log2 is more than a tile's: take every 2^step_log2-th sample, a tile's corners at "
             "most");
    if (grid.columns != along(terrain.columns()) || grid.rows != along(terrain.rows()) ||
        grid.heights_m.size() != static_cast<std::size_t>(grid.columns) * static_cast<std::size_t>(grid.rows))
        fail("the heights are not this terrain's: HeightGrid must have " + std::to_string(along(terrain.columns())) +
             " columns and " + std::to_string(along(terrain.rows())) +
             " rows for its step_log2, and a height for each");
}

// Parts of equal size, as few as `most` allows.
std::int32_t part_of(std::int32_t extent, std::int32_t most) {
    const std::int32_t parts = (extent + most - 1) / most;
    return (extent + parts - 1) / parts;
}

} // namespace

void Heights::set(const HeightGrid& grid, const Terrain& terrain, std::uint32_t texture_side) {
    if (grid.heights_m.empty()) {
        texture_ = Texture();
        return;
    }
    check(grid, terrain);
    int most = 0, most_layers = 0;
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &most);
    glGetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &most_layers);
    if (texture_side != 0) most = std::min(most, static_cast<int>(texture_side));
    const std::int32_t w = part_of(grid.columns, most), h = part_of(grid.rows, most);
    const std::int32_t across = (grid.columns + w - 1) / w, down = (grid.rows + h - 1) / h;
    if (across > most_layers / down)
        fail("this GPU's textures have no room for " + std::to_string(grid.heights_m.size()) +
             " heights: give a HeightGrid of a larger step_log2");
    while (glGetError() != GL_NO_ERROR) {
    } // so that the check below speaks of this texture
    unsigned name = 0;
    glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &name);
    Texture texture(name);
    glTextureStorage3D(name, 1, GL_R32F, w, h, across * down);
    if (glGetError() != GL_NO_ERROR)
        fail("the GPU has no room for " + std::to_string(grid.heights_m.size()) +
             " heights: give a HeightGrid of a larger step_log2");
    glTextureParameteri(name, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTextureParameteri(name, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
    glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
    std::vector<float> row(static_cast<std::size_t>(grid.columns));
    for (std::int32_t y = 0; y < grid.rows; ++y) {
        const float* const from = grid.heights_m.data() + static_cast<std::size_t>(y) * row.size();
        std::transform(from, from + row.size(), row.begin(), [](float m) { return std::isnan(m) ? hole_m : m; });
        for (std::int32_t x = 0; x < grid.columns; x += w)
            glTextureSubImage3D(name, 0, 0, y % h, y / h * across + x / w, std::min(w, grid.columns - x), 1, 1, GL_RED,
                                GL_FLOAT, row.data() + x);
    }
    texture_ = std::move(texture);
    columns = grid.columns;
    rows = grid.rows;
    step_log2 = static_cast<std::int32_t>(grid.step_log2);
    wide = w;
    high = h;
}

namespace {

constexpr std::uint32_t finest_page_log2 = 6; // samples a side of a page of step 1

} // namespace

std::uint32_t residency_square_log2(const PackHeader& header) {
    return std::min(header.tile_log2, finest_page_log2);
}

std::uint32_t resident_step_log2(const Terrain& terrain, std::uint32_t tile, std::uint32_t square_x,
                                 std::uint32_t square_y) {
    const PackHeader& h = terrain.header();
    if (h.order == PageOrder::linear) { // its pages are of no step
        for (std::uint32_t page = 0; page < terrain.pages_per_tile(); ++page)
            if (!page_loaded(terrain, tile, page)) return h.tile_log2;
        return 0;
    }
    if (!page_loaded(terrain, tile, 0)) return h.tile_log2;
    const std::uint32_t x = square_x << finest_page_log2, y = square_y << finest_page_log2;
    std::uint32_t z = h.tile_log2;
    while (z > 0 && page_loaded(terrain, tile, page_at(h, z - 1, x, y))) --z;
    return z;
}

void Residency::follow(const Terrain& terrain) {
    if (!terrain.valid()) fail("the terrain is destroyed; create it again, and a renderer for it");
    if (texture_.get() != 0 && changes_ == page_changes(terrain)) return;
    const PackHeader& h = terrain.header();
    const std::uint32_t a_side = 1u << (h.tile_log2 - residency_square_log2(h));
    const std::uint32_t wide = h.tiles_x * a_side, high = h.tiles_y * a_side;
    if (texture_.get() == 0) {
        int largest = 0;
        glGetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
        if (std::max(wide, high) > static_cast<std::uint32_t>(largest))
            fail("the terrain has " + std::to_string(std::max(wide, high)) + " blocks a side and this GPU's textures " +
                 std::to_string(largest) + " texels: residency cannot be drawn, use Mode::levels");
        unsigned name = 0;
        glCreateTextures(GL_TEXTURE_2D, 1, &name);
        texture_ = Texture(name);
        glTextureStorage2D(name, 1, GL_R8UI, static_cast<GLsizei>(wide), static_cast<GLsizei>(high));
        glTextureParameteri(name, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
        glTextureParameteri(name, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
        steps_.resize(std::size_t{wide} * high);
    }
    for (std::uint32_t y = 0; y < high; ++y)
        for (std::uint32_t x = 0; x < wide; ++x) {
            const std::uint32_t tile =
                terrain.tile_at({static_cast<std::int32_t>(x / a_side), static_cast<std::int32_t>(y / a_side)});
            steps_[std::size_t{y} * wide + x] = static_cast<std::uint8_t>(
                tile == no_tile ? h.tile_log2 : resident_step_log2(terrain, tile, x % a_side, y % a_side));
        }
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
    glTextureSubImage2D(texture_.get(), 0, 0, 0, static_cast<GLsizei>(wide), static_cast<GLsizei>(high), GL_RED_INTEGER,
                        GL_UNSIGNED_BYTE, steps_.data());
    glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
    changes_ = page_changes(terrain);
    ++updates_;
}

} // namespace fjell::gl
