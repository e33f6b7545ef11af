// Materials: colour, normal, horizon and splat maps of tiles, with mips, block-compressed (thesis 6.1: an image, or a
// ramp over height).
//
// Mip m of a map with N = 2^log2 texels a side has n = N >> m; the smallest has 4. Texel centres of the first and last
// column and row of *every* mip lie on the tile's border. So mip m of all tiles together is one grid of
// tiles_x * (n - 1) + 1 by tiles_y * (n - 1) + 1 texels, in which neighbours share their border; every texel is
// computed from that grid's coordinates alone - never from the tile - and is equal in both bit for bit before it is
// compressed. The first `near_mips` of a tile are made while its heights are at hand; each further one from the grid of
// the mip before it, which the caller keeps.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <vector>

#include "baker/maps/colour.h"
#include "baker/maps/smooth.h"
#include "baker/maps/tent.h"
#include "baker/read/source.h"
#include "fjell/texture.h"
#include "shared/tree.h"

namespace fjell::baker {

inline constexpr std::uint32_t near_mips = 3;

enum class MapKind : std::uint8_t { colour, normal, horizon, splat };
inline constexpr std::size_t map_kind_count = 4;
inline constexpr MapKind all_map_kinds[map_kind_count] = {MapKind::colour, MapKind::normal, MapKind::horizon,
                                                          MapKind::splat};

class ImageSource; // colour_files / image.h: an ortho-image of any size and CRS, read by windows
class ImageReader; // one a thread

// Fixed for a whole bake; shared by all threads.
struct MapPlan {
    Tree tree;
    double spacing_m[2] = {1, 1};
    // Texels a side of mip 0, at least 2; 0: none.
    std::uint32_t colour_log2 = 0, normal_log2 = 0, horizon_log2 = 0, splat_log2 = 0;
    std::optional<Ramp> ramp;                 // in metres; also where the image has no pixels
    const ImageSource* image = nullptr;       // or none
    const edit::PaintSource* paint = nullptr; // over colours and materials, or none
    const std::set<std::uint32_t>* stored =
        nullptr;         // tiles whose near mips are kept; of others texels alone; null: all
    SmoothGround smooth; // what normals and steepness are taken from; levels 0: the heights themselves

    [[nodiscard]] std::uint32_t log2_side(MapKind kind) const;
    // Horizons and shares of materials are computed at every (1 << this)-th sample: as far apart as texels of mip 0, or
    // nearer.
    [[nodiscard]] int stride_log2(MapKind kind) const;
    // Columns and rows of the grid of a mip of all tiles.
    [[nodiscard]] Window grid(MapKind kind, std::uint32_t mip) const;
    // The texels of the grid that are a tile's.
    [[nodiscard]] Window texels(MapKind kind, std::uint32_t mip, std::uint32_t tile) const;
};

// The samples that near_maps reads for a tile: its own and some around it, within the terrain.
[[nodiscard]] Window heights_for_maps(const MapPlan& plan, std::uint32_t tile);

// Texels between two mips: 16 bits a channel, row by row; colour 3 channels (linear light), normal 2, horizon and
// splat 16.
using Texels = Buffer<std::uint16_t>; // not cleared
[[nodiscard]] constexpr std::size_t channels(MapKind kind) {
    return kind == MapKind::colour ? 3 : kind == MapKind::normal ? 2 : 16;
}

static_assert(horizon_planes == 16 && max_splat_names == 16);

struct MipTexels {
    Buffer<std::byte> blocks; // BC1, BC5, BC4 or splat texels, as the pack stores it before zstd
    Texels texels;            // plan.texels(kind, mip, tile).area() * channels(kind)
};

// Mips 0 .. min(near_mips, mip_count) - 1 of a tile; texels are kept for the last one only (empty before).
// heights: of heights_for_maps(). reader: null without an image.
struct NearMaps {
    std::vector<MipTexels> colour, normal;
};
[[nodiscard]] NearMaps near_maps(const MapPlan& plan, std::uint32_t tile, const HeightWindow& heights,
                                 ImageReader* reader);

// The same mips of a horizon or splat map: first which points they are made from (horizon.h, splat.h), in a grid of
// every (1 << stride_log2())-th sample, then the work.
[[nodiscard]] Window points_for_map(const MapPlan& plan, MapKind kind, std::uint32_t tile);
[[nodiscard]] std::vector<MipTexels> near_mips_from(const MapPlan& plan, MapKind kind, std::uint32_t tile,
                                                    const TexelPlanes& points);

// Mip m >= near_mips of a tile, from the grid of mip m - 1: first which texels of that, then the work.
[[nodiscard]] Window finer_texels(const MapPlan& plan, MapKind kind, std::uint32_t mip, std::uint32_t tile);
// The same for a window of that mip's grid.
[[nodiscard]] Window finer_texels(const MapPlan& plan, MapKind kind, std::uint32_t mip, const Window& texels);
[[nodiscard]] MipTexels far_mip(const MapPlan& plan, MapKind kind, std::uint32_t mip, std::uint32_t tile,
                                const Texels& finer);

} // namespace fjell::baker
