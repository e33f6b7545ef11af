#include "baker/outlets/pack_map.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <string_view>

#include <fmt/format.h>

#include "baker/outlets/texel_places.h"
#include "fjell/io/failure.h"
#include "fjell/texture.h"

namespace fjell::baker {

namespace {

std::uint32_t log2_of(const PackHeader& h, PackMap::Kind kind) {
    return kind == PackMap::Kind::colour ? h.colour_log2 : kind == PackMap::Kind::sky ? h.horizon_log2 : h.splat_log2;
}

// What splat maps call "water", as renderers do; -1: nothing.
int number_of_water(const io::PackFile& file) {
    if (file.pack().header.layer_bytes == 0) return -1;
    std::vector<std::byte> text;
    file.read_chunk({ChunkKind::layers, 0, 0}, text);
    const auto names = io::layer_names({reinterpret_cast<const char*>(text.data()), text.size()});
    const auto found = std::ranges::find(names, "water");
    return found == names.end() ? -1 : static_cast<int>(found - names.begin());
}

const char* remedy_for(PackMap::Kind kind) {
    switch (kind) {
    case PackMap::Kind::colour: return "has no colours; bake it with --ramp or --texture, or leave out --colours";
    case PackMap::Kind::sky: return "has no horizon maps; bake it with --horizons, or leave out --occlusion";
    case PackMap::Kind::water: break;
    }
    return "has no water in splat maps; bake it with --layers";
}

} // namespace

PackMap::PackMap(const std::string& path, Kind kind)
    : kind_(kind), file_(path), log2_(log2_of(file_.pack().header, kind)) {
    const Pack& pack = file_.pack();
    if (kind == Kind::water) water_ = number_of_water(file_);
    if (mip_count(log2_) == 0 || (kind == Kind::water && water_ < 0))
        throw io::Failure(1, fmt::format("{}: {}", path, remedy_for(kind)));
    for (std::uint32_t tile = 0; tile < pack.tile_count(); ++tile) tiles_[pack.tile_place(tile)] = tile;
}

bool PackMap::has(const std::string& path, Kind kind) {
    const io::PackFile file(path);
    return mip_count(log2_of(file.pack().header, kind)) != 0 && (kind != Kind::water || number_of_water(file) >= 0);
}

void PackMap::decode(std::uint32_t side, Map& to) const {
    const std::size_t texels = std::size_t{side} * side;
    to.resize(texels * channels());
    if (kind_ == Kind::colour) {
        (void)decode_colour(blocks_, side, to);
    } else if (kind_ == Kind::sky) {
        Map planes(texels * horizon_planes);
        (void)decode_horizon(blocks_, side, planes);
        for (std::size_t i = 0; i < texels; ++i) to[i] = planes[i * horizon_planes + horizon_directions];
    } else {
        for (std::size_t i = 0; i < texels; ++i) {
            unsigned share = 0; // weights and numbers by turns
            for (std::size_t k = i * splat_texel_bytes; k < (i + 1) * splat_texel_bytes; k += 2)
                if (static_cast<int>(blocks_[k + 1]) == water_) share += static_cast<unsigned>(blocks_[k]);
            to[i] = static_cast<std::uint8_t>(std::min(share, 255u));
        }
    }
}

const PackMap::Map& PackMap::map_of(std::uint32_t tile, std::uint32_t mip) {
    const auto [found, fresh] = maps_.try_emplace({tile, mip});
    if (!fresh) return found->second;
    constexpr std::size_t most_bytes = std::size_t{64} << 20;
    if (bytes_ > most_bytes) {
        maps_.clear();
        bytes_ = 0;
        return map_of(tile, mip);
    }
    constexpr ChunkKind kinds[] = {ChunkKind::colour, ChunkKind::horizon, ChunkKind::splat};
    file_.read_chunk({kinds[static_cast<std::size_t>(kind_)], tile, mip}, blocks_);
    decode(1u << (log2_ - mip), found->second);
    bytes_ += found->second.size();
    return found->second;
}

PackMap::Texel PackMap::at(double column, double row, double texel_m) {
    constexpr Texel grey{188, 188, 188}; // half of the light, as tiles without a picture are
    const Texel beyond = kind_ == Kind::colour ? grey : kind_ == Kind::sky ? Texel{255, 255, 255} : Texel{};
    const PackHeader& h = file_.pack().header;
    if (!(column >= 0 && row >= 0 && column <= h.columns - 1.0 && row <= h.rows - 1.0)) return beyond;
    const double cells = std::ldexp(1.0, static_cast<int>(h.tile_log2));
    const auto tile_x = std::min(static_cast<std::uint32_t>(column / cells), h.tiles_x - 1),
               tile_y = std::min(static_cast<std::uint32_t>(row / cells), h.tiles_y - 1);
    const auto tile = tiles_.find(tile_y * h.tiles_x + tile_x);
    if (tile == tiles_.end()) return beyond;
    // Outer texel centres lie on the tile's border.
    const auto last_of = [&](std::uint32_t mip) { return static_cast<double>((1u << (log2_ - mip)) - 1); };
    const double tile_m = cells * std::max(h.spacing_m[0], h.spacing_m[1]);
    std::uint32_t mip = 0;
    while (mip + 1 < mip_count(log2_) && tile_m / last_of(mip + 1) <= texel_m) ++mip;
    const Map& map = map_of(tile->second, mip);
    const auto side = static_cast<std::size_t>(last_of(mip)) + 1;
    const double x = (column / cells - tile_x) * last_of(mip), y = (row / cells - tile_y) * last_of(mip);
    const auto i = std::min(static_cast<std::size_t>(x), side - 2), j = std::min(static_cast<std::size_t>(y), side - 2);
    const double s = x - static_cast<double>(i), t = y - static_cast<double>(j);
    Texel texel{};
    for (std::size_t c = 0; c < channels(); ++c) {
        const auto code = [&](std::size_t dx, std::size_t dy) {
            return static_cast<double>(map[((j + dy) * side + i + dx) * channels() + c]);
        };
        texel[c] = static_cast<std::uint8_t>(std::lround((1 - t) * ((1 - s) * code(0, 0) + s * code(1, 0)) +
                                                         t * ((1 - s) * code(0, 1) + s * code(1, 1))));
    }
    if (channels() == 1) texel.fill(texel[0]);
    return texel;
}

std::vector<std::uint8_t> PackMap::picture(std::uint32_t columns, std::uint32_t rows, double texel_m,
                                           const Place& place) {
    std::vector<std::uint8_t> rgb;
    rgb.reserve(std::size_t{columns} * rows * 3);
    constexpr double accuracy = 1.0 / 64; // of a texel: what no eye sees
    const TexelPlaces places({0, 0, static_cast<std::int32_t>(columns), static_cast<std::int32_t>(rows)}, accuracy,
                             [&](double x, double y) { return place((x + 0.5) / columns, (y + 0.5) / rows); });
    constexpr double beyond = -1; // of the ground
    for (std::int32_t y = 0; y < static_cast<std::int32_t>(rows); ++y)
        for (std::int32_t x = 0; x < static_cast<std::int32_t>(columns); ++x) {
            const auto at_sample = places.at(x, y).value_or(std::array{beyond, beyond});
            const auto texel = at(at_sample[0], at_sample[1], texel_m);
            rgb.insert(rgb.end(), texel.begin(), texel.end());
        }
    return rgb;
}

} // namespace fjell::baker
