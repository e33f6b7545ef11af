#include "gl/ground_normals.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include <epoxy/gl.h>

#include "fjell/query.h"
#include "fjell/texture.h"

namespace fjell::gl {

namespace {

constexpr std::size_t most_rects = 64; // of a tile; then one around all of them
constexpr double widest_texel = 32;    // in samples

// The inverse of sample_to_texel(): where the texels of a mip lie, in samples from the tile's first. Every mip covers
// the square of the pack's own size.
struct MipAxis {
    double first, spacing;
    MipAxis(std::uint32_t pack_log2, std::uint32_t mip_log2, std::uint32_t tile_log2) {
        const double texels = 1u << pack_log2, side = 1u << mip_log2, cells = 1u << tile_log2;
        spacing = texels / side * cells / (texels - 1);
        first = (0.5 * texels / side - 0.5) * cells / (texels - 1);
    }
    [[nodiscard]] double sample(std::int32_t texel) const { return first + texel * spacing; }
    [[nodiscard]] double texel(double sample) const { return (sample - first) / spacing; }
};

// A BC4 block of codes: two of them and six between, 3 bits a texel.
void encode(const std::uint8_t (&codes)[16], std::byte* block) {
    const auto [low, high] = std::minmax_element(std::begin(codes), std::end(codes));
    const int first = *high, range = *high - *low;
    std::uint64_t bits = 0;
    for (int i = 0; i < 16 && range != 0; ++i) {
        const int step = ((first - codes[i]) * 14 + range) / (2 * range); // 0 to 7, from the higher to the lower
        bits |= static_cast<std::uint64_t>(step == 0 ? 0 : step == 7 ? 1 : step + 1) << (3 * i);
    }
    block[0] = static_cast<std::byte>(*high);
    block[1] = static_cast<std::byte>(*low);
    for (int i = 0; i < 6; ++i) block[2 + i] = static_cast<std::byte>(bits >> (8 * i));
}

std::uint8_t code_of(double component) {
    return static_cast<std::uint8_t>(std::lround(std::clamp(128 + 127 * component, 1.0, 255.0)));
}

// Heights every 2^step_log2 samples, and the normals between them.
class NormalGrid {
public:
    NormalGrid(const Terrain& terrain, int step_log2, std::int32_t first_x, std::int32_t first_y, std::uint32_t side,
               std::vector<float>& heights_m)
        : terrain_(terrain), step_(1 << step_log2), first_x_(first_x), first_y_(first_y), side_(side),
          heights_m_(heights_m) {
        heights_m_.resize(std::size_t{side} * side);
        (void)ground_patch(terrain, {first_x * step_, first_y * step_}, step_log2, side, heights_m_);
    }
    // x, y: in samples of the terrain. Straight between the normals of the four places around it.
    [[nodiscard]] Vec3 normal(double x, double y) const {
        const double u = x / step_ - first_x_, v = y / step_ - first_y_;
        const auto column = static_cast<std::int32_t>(std::floor(u)), row = static_cast<std::int32_t>(std::floor(v));
        const double fx = u - column, fy = v - row;
        return normalised(at(column, row) * ((1 - fx) * (1 - fy)) + at(column + 1, row) * (fx * (1 - fy)) +
                          at(column, row + 1) * ((1 - fx) * fy) + at(column + 1, row + 1) * (fx * fy));
    }

private:
    [[nodiscard]] float height(std::int32_t column, std::int32_t row) const {
        const auto last = static_cast<std::int32_t>(side_) - 1;
        return heights_m_[static_cast<std::size_t>(std::clamp(row, 0, last)) * side_ +
                          static_cast<std::size_t>(std::clamp(column, 0, last))];
    }
    // Up a metre east or south: by the places on both sides, or on the one that there is at the terrain's rim.
    [[nodiscard]] double rise(double less_m, double more_m, std::int32_t at, std::uint32_t count,
                              double spacing_m) const {
        const auto inside = [&](std::int64_t sample) {
            return std::clamp<std::int64_t>(sample, 0, std::int64_t{count} - 1);
        };
        const std::int64_t middle = std::int64_t{at} * step_;
        const std::int64_t apart = inside(middle + step_) - inside(middle - step_);
        return apart == 0 ? 0 : (more_m - less_m) / (static_cast<double>(apart) * spacing_m);
    }
    [[nodiscard]] Vec3 at(std::int32_t column, std::int32_t row) const {
        const PackHeader& h = terrain_.header();
        return normalised(
            Vec3{-rise(height(column - 1, row), height(column + 1, row), first_x_ + column, h.columns, h.spacing_m[0]),
                 1, -rise(height(column, row - 1), height(column, row + 1), first_y_ + row, h.rows, h.spacing_m[1])});
    }

    const Terrain& terrain_;
    std::int32_t step_, first_x_, first_y_;
    std::uint32_t side_;
    std::vector<float>& heights_m_;
};

GroundRect around(const GroundRect& a, const GroundRect& b) {
    return {{std::min(a.first.column, b.first.column), std::min(a.first.row, b.first.row)},
            {std::max(a.last.column, b.last.column), std::max(a.last.row, b.last.row)}};
}

} // namespace

void GroundNormals::follow(const Edits& edits, const Terrain& terrain, const MapArrays& normals) {
    if (!normals.present()) return;
    GroundRect rects[32];
    bool lost = false;
    while (const std::uint32_t count = take_ground_changes(edits, cursor_, rects, lost)) {
        tiles_.resize(terrain.tile_count());
        for (const GroundRect& rect : std::span(rects).first(count)) add(rect, terrain, normals);
    }
}

void GroundNormals::add(const GroundRect& rect, const Terrain& terrain, const MapArrays& normals) {
    constexpr std::int32_t near = 2 * static_cast<std::int32_t>(widest_texel);
    const PackHeader& h = terrain.header();
    const auto tile_of = [&](std::int32_t sample, std::uint32_t tiles) {
        return std::clamp(sample >> h.tile_log2, 0, static_cast<std::int32_t>(tiles) - 1);
    };
    for (std::int32_t y = tile_of(rect.first.row - near, h.tiles_y); y <= tile_of(rect.last.row + near, h.tiles_y); ++y)
        for (std::int32_t x = tile_of(rect.first.column - near, h.tiles_x);
             x <= tile_of(rect.last.column + near, h.tiles_x); ++x) {
            const std::uint32_t tile = terrain.tile_at({x, y});
            if (tile >= tiles_.size()) continue;
            TileEdits& t = tiles_[tile];
            if (t.rects.empty()) t.side_log2 = normals.tiles[tile].side_log2, t.layer = normals.tiles[tile].layer;
            const std::int32_t side = 1 << h.tile_log2; // of what is in reach of the tile
            const GroundRect within{
                {std::max(rect.first.column, x * side - near), std::max(rect.first.row, y * side - near)},
                {std::min(rect.last.column, (x + 1) * side + near), std::min(rect.last.row, (y + 1) * side + near)}};
            const bool known = std::ranges::any_of(t.rects, [&](const GroundRect& r) {
                return r.first.column <= within.first.column && r.first.row <= within.first.row &&
                       r.last.column >= within.last.column && r.last.row >= within.last.row;
            });
            if (!known && t.rects.size() == most_rects) {
                for (const GroundRect& r : t.rects) t.rects[0] = around(t.rects[0], r);
                t.rects.resize(1);
                t.rects[0] = around(t.rects[0], within);
            } else if (!known) {
                t.rects.push_back(within);
            }
            paint(tile, within, terrain, normals);
        }
}

void GroundNormals::written(std::uint32_t tile) {
    if (tile < tiles_.size()) tiles_[tile].side_log2 = 0;
}

void GroundNormals::repaint(const Terrain& terrain, const MapArrays& normals) {
    if (!normals.present()) return;
    for (std::uint32_t tile = 0; tile < tiles_.size(); ++tile) {
        TileEdits& t = tiles_[tile];
        const TileMap& shown = normals.tiles[tile];
        if (t.rects.empty() || (t.side_log2 == shown.side_log2 && t.layer == shown.layer)) continue;
        t.side_log2 = shown.side_log2, t.layer = shown.layer;
        for (const GroundRect& rect : t.rects) paint(tile, rect, terrain, normals);
    }
}

void GroundNormals::paint(std::uint32_t tile, const GroundRect& rect, const Terrain& terrain,
                          const MapArrays& normals) {
    const std::uint32_t side_log2 = normals.tiles[tile].side_log2;
    if (side_log2 == 0) return; // nothing is shown yet
    for (std::uint32_t mip = 0; mip < mip_count(side_log2); ++mip) paint_mip(tile, mip, rect, terrain, normals);
}

void GroundNormals::paint_mip(std::uint32_t tile, std::uint32_t mip, const GroundRect& rect, const Terrain& terrain,
                              const MapArrays& normals) {
    const PackHeader& h = terrain.header();
    const TileMap& shown = normals.tiles[tile];
    const std::uint32_t mip_log2 = shown.side_log2 - mip;
    const MipAxis axis(h.normal_log2, mip_log2, h.tile_log2);
    if (axis.spacing > widest_texel) return;
    const SampleIndex place = terrain.tile_place(tile), origin{place.column << h.tile_log2, place.row << h.tile_log2};
    // Texels whose normals look at a height that has changed, in whole blocks.
    struct Run {
        std::int32_t first, count;
    };
    const auto texels = [&](std::int32_t from, std::int32_t to) {
        const std::int32_t side = 1 << mip_log2;
        const double first = std::floor(axis.texel(from - 2 * axis.spacing - 1)),
                     last = std::ceil(axis.texel(to + 2 * axis.spacing + 1));
        if (last < 0 || first >= side) return Run{0, 0};
        const std::int32_t begin = std::max(static_cast<std::int32_t>(first), 0) / 4 * 4;
        const std::int32_t end = std::min(static_cast<std::int32_t>(last) / 4 * 4 + 4, side);
        return Run{begin, end - begin};
    };
    const Run x = texels(rect.first.column - origin.column, rect.last.column - origin.column),
              y = texels(rect.first.row - origin.row, rect.last.row - origin.row);
    if (x.count <= 0 || y.count <= 0) return;

    const int step_log2 =
        std::max(static_cast<int>(std::bit_width(static_cast<std::uint32_t>(axis.spacing + 0.5))) - 1, 0);
    const auto grid = [&](double sample) { return static_cast<std::int32_t>(std::floor(sample / (1 << step_log2))); };
    const std::int32_t grid_x = grid(origin.column + axis.sample(x.first)) - 1,
                       grid_y = grid(origin.row + axis.sample(y.first)) - 1;
    const std::int32_t wide = grid(origin.column + axis.sample(x.first + x.count - 1)) + 3 - grid_x,
                       high = grid(origin.row + axis.sample(y.first + y.count - 1)) + 3 - grid_y;
    const auto side = static_cast<std::uint32_t>(std::max(wide, high));
    if (side > max_patch_side) return;
    const NormalGrid heights(terrain, step_log2, grid_x, grid_y, side, heights_m_);
    blocks_.resize(static_cast<std::size_t>(x.count / 4 * (y.count / 4)) * normal_block_bytes);
    std::byte* block = blocks_.data();
    for (std::int32_t row = y.first; row < y.first + y.count; row += 4)
        for (std::int32_t column = x.first; column < x.first + x.count; column += 4, block += normal_block_bytes) {
            std::uint8_t east[16], south[16];
            for (std::int32_t i = 0; i < 16; ++i) {
                const Vec3 n =
                    heights.normal(origin.column + axis.sample(column + i % 4), origin.row + axis.sample(row + i / 4));
                east[i] = code_of(n.x), south[i] = code_of(n.z);
            }
            encode(east, block);
            encode(south, block + normal_block_bytes / 2);
        }
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    glCompressedTextureSubImage3D(normals.texture(shown.side_log2), static_cast<GLint>(mip), x.first, y.first,
                                  static_cast<GLint>(shown.layer), x.count, y.count, 1, GL_COMPRESSED_RG_RGTC2,
                                  static_cast<GLsizei>(blocks_.size()), blocks_.data());
}

} // namespace fjell::gl
