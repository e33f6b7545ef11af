#include "baker/bake/work_bytes.h"

#include <algorithm>
#include <cmath>

#include "baker/bake/region_stores.h"
#include "baker/maps/maps.h"
#include "fjell/pack.h"

namespace fjell::baker {

namespace {

constexpr double sum_of_mips = 4.0 / 3; // 1 + 1/4 + 1/16 + ...
constexpr double not_compressed = 1.01; // what zstd adds at most, and headers of pages

double texels_of(const Tree& tree, std::uint32_t log2_side) {
    return log2_side ? std::ldexp(static_cast<double>(tree.tiles_x) * tree.tiles_y, static_cast<int>(2 * log2_side))
                     : 0;
}

} // namespace

std::uint64_t work_bytes(const Tree& tree, Order order, const MapSizes& maps) {
    const double samples = static_cast<double>(tree.columns()) * tree.rows();
    const double places = static_cast<double>(tree.grid_columns()) * tree.grid_rows();
    const double tiles = static_cast<double>(tree.tiles_x) * tree.tiles_y;
    const double heights = samples * (sizeof(float) + sizeof(std::uint8_t)); // with holes marked
    const double colour = texels_of(tree, maps.colour_log2), normal = texels_of(tree, maps.normal_log2),
                 horizon = texels_of(tree, maps.horizon_log2), control = texels_of(tree, maps.control_log2);

    // Filling voids: heights as they were read, filled ones, and the pyramid of means.
    const double filling = heights + samples * sizeof(float) * sum_of_mips;
    // Maps: the last near mip and the one made from it. BC1 takes half a byte a texel, BC5 one.
    const double texel_bytes = sizeof(std::uint16_t) * (static_cast<double>(channels(MapKind::colour)) * colour +
                                                        static_cast<double>(channels(MapKind::normal)) * normal);
    const double texels = texel_bytes / std::pow(4.0, near_mips - 1) * 1.25;
    const double map_chunks = (0.5 * colour + normal) * sum_of_mips * not_compressed;
    // Horizons: levels of the heights, which lie in a rectangle that they fill to two thirds, and BC4 for each plane.
    const double levels = maps.horizon_log2 ? (samples / 4 * 1.6 + 4096) * sizeof(float) : 0;
    const double horizon_texels =
        horizon * sizeof(std::uint16_t) * horizon_planes / std::pow(4.0, near_mips - 1) * 1.25;
    const double horizon_chunks = 0.5 * horizon_planes * horizon * sum_of_mips * not_compressed;
    // Control maps: the same 16 channels on the way, 8 bytes a texel. They come last.
    const double control_texels = control * sizeof(std::uint16_t) * static_cast<double>(channels(MapKind::control)) /
                                  std::pow(4.0, near_mips - 1) * 1.25;
    const double control_chunks = control_texel_bytes * control * sum_of_mips * not_compressed;
    const double all_chunks = map_chunks + horizon_chunks + control_chunks;
    // Vertices: places and centres of the step above the finest one, its unsaturated errors, records of mixed pages.
    const bool linear = order == Order::linear;
    const int mixed_log2 = linear ? 0 : std::max(tree.tile_log2 - page_squares_log2, 0);
    const double steps = places / 4 * (sizeof(std::uint32_t) + sizeof(CentreRecord)) * 1.25 + places / 4;
    const double mixed = std::ldexp(places, -2 * mixed_log2) * (sizeof(std::uint32_t) + sizeof(std::uint16_t));
    // A vertex: height 2 bytes, error 1; a radius of its own in linear order, else one for 16.
    const double page_chunks = places * (linear ? 4 : 3 + 1.0 / 16) * not_compressed;
    const PageLayout pages{tree.tile_log2, order};
    const double entries = tiles *
                           (pages.pages_per_tile() + mip_count(maps.colour_log2) + mip_count(maps.normal_log2) +
                            mip_count(maps.horizon_log2) + mip_count(maps.control_log2)) *
                           sizeof(ChunkEntry);
    return static_cast<std::uint64_t>(
        std::max({filling, heights + texels + map_chunks + entries,
                  heights + texels + levels + horizon_texels + control_texels + all_chunks + entries,
                  heights + steps + mixed + all_chunks + page_chunks + entries}));
}

} // namespace fjell::baker
