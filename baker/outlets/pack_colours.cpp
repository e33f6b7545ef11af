#include "baker/outlets/pack_colours.h"

#include <algorithm>
#include <cmath>
#include <span>

#include <fmt/format.h>

#include "fjell/io/failure.h"
#include "fjell/texture.h"
#include "gltf/glb.h"

namespace fjell::baker {

PackColours::PackColours(const std::string& path) : file_(path) {
    const Pack& pack = file_.pack();
    if (mip_count(pack.header.colour_log2) == 0)
        throw io::Failure(
            1, fmt::format("{}: has no colours; bake it with --ramp or --texture, or leave out --colours", path));
    for (std::uint32_t tile = 0; tile < pack.tile_count(); ++tile) tiles_[pack.tile_place(tile)] = tile;
}

const PackColours::Map& PackColours::map_of(std::uint32_t tile, std::uint32_t mip) {
    const auto [found, fresh] = maps_.try_emplace({tile, mip});
    if (!fresh) return found->second;
    constexpr std::size_t most_bytes = std::size_t{64} << 20;
    if (bytes_ > most_bytes) {
        maps_.clear();
        bytes_ = 0;
        return map_of(tile, mip);
    }
    const std::uint32_t side = 1u << (file_.pack().header.colour_log2 - mip);
    file_.read_chunk({ChunkKind::colour, tile, mip}, blocks_);
    found->second.resize(std::size_t{side} * side * 3);
    (void)decode_colour(blocks_, side, found->second);
    bytes_ += found->second.size();
    return found->second;
}

std::array<std::uint8_t, 3> PackColours::at(double column, double row, double texel_m) {
    constexpr std::array<std::uint8_t, 3> grey{188, 188, 188}; // half of the light, as tiles without a picture are
    const PackHeader& h = file_.pack().header;
    if (!(column >= 0 && row >= 0 && column <= h.columns - 1.0 && row <= h.rows - 1.0)) return grey;
    const double cells = std::ldexp(1.0, static_cast<int>(h.tile_log2));
    const auto tile_x = std::min(static_cast<std::uint32_t>(column / cells), h.tiles_x - 1),
               tile_y = std::min(static_cast<std::uint32_t>(row / cells), h.tiles_y - 1);
    const auto tile = tiles_.find(tile_y * h.tiles_x + tile_x);
    if (tile == tiles_.end()) return grey;
    // Outer texel centres lie on the tile's border.
    const auto last_of = [&](std::uint32_t mip) { return static_cast<double>((1u << (h.colour_log2 - mip)) - 1); };
    const double tile_m = cells * std::max(h.spacing_m[0], h.spacing_m[1]);
    std::uint32_t mip = 0;
    while (mip + 1 < mip_count(h.colour_log2) && tile_m / last_of(mip + 1) <= texel_m) ++mip;
    const Map& map = map_of(tile->second, mip);
    const auto side = static_cast<std::size_t>(last_of(mip)) + 1;
    const double x = (column / cells - tile_x) * last_of(mip), y = (row / cells - tile_y) * last_of(mip);
    const auto i = std::min(static_cast<std::size_t>(x), side - 2), j = std::min(static_cast<std::size_t>(y), side - 2);
    const double s = x - static_cast<double>(i), t = y - static_cast<double>(j);
    std::array<std::uint8_t, 3> rgb{};
    for (std::size_t c = 0; c < 3; ++c) {
        const auto code = [&](std::size_t dx, std::size_t dy) {
            return static_cast<double>(map[((j + dy) * side + i + dx) * 3 + c]);
        };
        rgb[c] = static_cast<std::uint8_t>(std::lround((1 - t) * ((1 - s) * code(0, 0) + s * code(1, 0)) +
                                                       t * ((1 - s) * code(0, 1) + s * code(1, 1))));
    }
    return rgb;
}

std::vector<std::byte> PackColours::picture(std::uint32_t columns, std::uint32_t rows, double texel_m,
                                            const Place& place) {
    std::vector<std::uint8_t> rgb;
    rgb.reserve(std::size_t{columns} * rows * 3);
    constexpr double beyond = -1; // of the ground
    for (std::uint32_t y = 0; y < rows; ++y)
        for (std::uint32_t x = 0; x < columns; ++x) {
            const auto at_sample = place((x + 0.5) / columns, (y + 0.5) / rows).value_or(std::array{beyond, beyond});
            const auto texel = at(at_sample[0], at_sample[1], texel_m);
            rgb.insert(rgb.end(), texel.begin(), texel.end());
        }
    return gltf::encode_jpeg(columns, rows, std::as_bytes(std::span(rgb)));
}

} // namespace fjell::baker
