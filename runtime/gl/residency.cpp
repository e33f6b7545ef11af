#include "gl/residency.h"

#include <algorithm>

#include <epoxy/gl.h>

#include "fjell/pages.h"

namespace fjell::gl {
namespace {

constexpr std::uint32_t finest_page_log2 = 6; // samples a side of a page of step 1

} // namespace

std::uint32_t residency_square_log2(const PackHeader& header) {
    return std::min(header.tile_log2, finest_page_log2);
}

std::uint32_t resident_step_log2(const Terrain& terrain, std::uint32_t tile, std::uint32_t square_x,
                                 std::uint32_t square_y) {
    const PackHeader& h = terrain.header();
    if (h.order == Order::linear) { // its pages are of no step
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

std::string Residency::follow(const Terrain& terrain) {
    if (!terrain.valid()) return "the terrain is destroyed; create it again, and a renderer for it";
    if (texture_.get() != 0 && changes_ == page_changes(terrain)) return {};
    const PackHeader& h = terrain.header();
    const std::uint32_t a_side = 1u << (h.tile_log2 - residency_square_log2(h));
    const std::uint32_t wide = h.tiles_x * a_side, high = h.tiles_y * a_side;
    if (texture_.get() == 0) {
        int largest = 0;
        glGetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
        if (std::max(wide, high) > static_cast<std::uint32_t>(largest))
            return "the terrain has " + std::to_string(std::max(wide, high)) +
                   " blocks a side and this GPU's textures " + std::to_string(largest) +
                   " texels: residency cannot be drawn, use Mode::levels";
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
    return {};
}

} // namespace fjell::gl
