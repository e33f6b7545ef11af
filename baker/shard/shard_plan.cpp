#include "baker/shard/shard_plan.h"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

namespace fjell::baker {

namespace {

// `shards` of them in `rows_of_shards` rows: each row has as many as the others or one more, and is as high as its
// share.
std::vector<Window> cut_in_rows(std::int32_t across, std::int32_t down, int shards, int rows_of_shards) {
    std::vector<Window> parts;
    int done = 0;
    std::int32_t y = 0;
    for (int row = 0; row < rows_of_shards; ++row) {
        const int in_row = (shards - done) / (rows_of_shards - row);
        const int rows_after = rows_of_shards - row - 1;
        // At least one row of regions for each row of shards that is still to come.
        const auto share =
            static_cast<std::int32_t>((std::int64_t{down - y} * in_row + (shards - done) / 2) / (shards - done));
        const std::int32_t height = std::clamp(share, 1, std::max(down - y - rows_after, 1));
        for (int i = 0; i < in_row; ++i) {
            const auto x = static_cast<std::int32_t>(std::int64_t{across} * i / in_row),
                       end = static_cast<std::int32_t>(std::int64_t{across} * (i + 1) / in_row);
            parts.push_back(end > x ? Window{x, y, end - x, rows_after == 0 ? down - y : height} : Window{});
        }
        done += in_row;
        y += height;
    }
    return parts;
}

} // namespace

std::vector<Window> cut_into_shards(std::int32_t across, std::int32_t down, int shards) {
    std::vector<Window> best;
    double best_area = std::numeric_limits<double>::infinity();
    for (int rows = std::min(shards, down); rows >= 1; --rows) {
        std::vector<Window> parts = cut_in_rows(across, down, shards, rows);
        double largest = 0;
        for (const Window& part : parts) largest = std::max(largest, static_cast<double>(part.area()));
        if (largest >= 0.98 * best_area) continue;
        best_area = largest;
        best = std::move(parts);
    }
    return best;
}

std::string ShardStep::name() const {
    switch (kind) {
    case Kind::read: return "read";
    case Kind::means: return "means";
    case Kind::measure: return "measure";
    case Kind::errors: break;
    }
    return fmt::format("step{}", 1 << z);
}

std::vector<ShardStep> shard_steps(int rounds) {
    std::vector<ShardStep> steps{{ShardStep::Kind::read}, {ShardStep::Kind::means}, {ShardStep::Kind::measure}};
    for (int z = 0; z < rounds; ++z) steps.push_back({ShardStep::Kind::errors, z});
    return steps;
}

namespace {

// Of a grid of every 2^z-th place; more_x, more_y: with the last column and row, which a neighbour has too.
Window grid_of(const Regions& regions, const Window& part, const Tree& tree, int z, bool more_x, bool more_y) {
    const std::int32_t cells = regions.cells(), x = part.x * cells, y = part.y * cells;
    const std::int32_t end_x = std::min((part.x + part.columns) * cells, tree.grid_columns() - 1),
                       end_y = std::min((part.y + part.rows) * cells, tree.grid_rows() - 1);
    return {x >> z, y >> z, ((end_x - x) >> z) + more_x, ((end_y - y) >> z) + more_y};
}

} // namespace

Window PartWindows::places(int z) const {
    return grid_of(regions, part, tree, z, part.x + part.columns == regions.across(),
                   part.y + part.rows == regions.down());
}

Window PartWindows::centres(int z) const {
    return grid_of(regions, part, tree, z + 1, false, false);
}

Window PartWindows::south(int z) const {
    const Window all = grid_of(regions, part, tree, z, true, true);
    return {all.x, part.y, all.columns, part.rows};
}

Window PartWindows::east(int z) const {
    const Window all = grid_of(regions, part, tree, z, true, true);
    return {all.y, part.x, all.rows, part.columns};
}

Window PartWindows::level(const HorizonLevels& levels, int l) const {
    const Window own = samples();
    const Window& all = levels.extents(l);
    const std::int32_t x = own.x >> l, y = own.y >> l;
    return {x, y, (own.x + own.columns == tree.columns() ? all.columns : (own.x + own.columns) >> l) - x,
            (own.y + own.rows == tree.rows() ? all.rows : (own.y + own.rows) >> l) - y};
}

Window PartWindows::texels(const MapPlan& maps, MapKind kind, std::uint32_t mip) const {
    const Window tiles = regions.tiles_of(part);
    const auto tile = [&](std::int32_t x, std::int32_t y) {
        return maps.texels(kind, mip, static_cast<std::uint32_t>(y * tree.tiles_x + x));
    };
    const Window first = tile(tiles.x, tiles.y), last = tile(tiles.x + tiles.columns - 1, tiles.y + tiles.rows - 1);
    const auto n = static_cast<std::int32_t>(channels(kind));
    return {first.x * n, first.y, (last.x + last.columns - first.x) * n, last.y + last.rows - first.y};
}

namespace {

// The samples that a tile's maps of all kinds are made from: a rectangle around them.
Window seen_by_maps(const MapPlan& maps, const HorizonLevels& levels, std::uint32_t tile) {
    Window all = heights_for_maps(maps, tile);
    const auto add = [&](const Window& w) {
        if (all.area() == 0) all = w;
        const std::int32_t x = std::min(all.x, w.x), y = std::min(all.y, w.y);
        all = {x, y, std::max(all.x + all.columns, w.x + w.columns) - x, std::max(all.y + all.rows, w.y + w.rows) - y};
    };
    if (maps.horizon_log2 != 0)
        add(common(seen_of_level(0, maps.stride_log2(MapKind::horizon), points_for_map(maps, MapKind::horizon, tile)),
                   levels.extents(0)));
    if (maps.splat_log2 != 0) {
        SplatGround ground{maps.tree.columns(), maps.tree.rows(), {1, 1}, maps.stride_log2(MapKind::splat), nullptr,
                           maps.smooth};
        add(heights_for_splat(ground, points_for_map(maps, MapKind::splat, tile)));
    }
    return all;
}

} // namespace

int levels_of_shards(const HorizonLevels& levels, std::size_t whole_vertices) {
    constexpr int fewest = 5, most = 8; // regions begin at multiples of 2^8
    int level = std::min(fewest, levels.count() - 1);
    while (level < std::min(most, levels.count() - 1) && levels.extents(level).area() > whole_vertices) ++level;
    return level;
}

std::int32_t height_frame(const MapPlan& sizes, std::size_t whole_vertices) {
    std::int32_t most = step_frame;
    const Tree& tree = sizes.tree;
    // Shards leave frames before anyone knows which steps the heights are counted in.
    MapPlan maps = sizes;
    maps.smooth = {tree.columns(), tree.rows(), 1, most_smooth_levels};
    const HorizonLevels levels(tree.columns(), tree.rows(), maps.spacing_m);
    if (maps.horizon_log2 != 0) most = std::max(most, (1 << levels_of_shards(levels, whole_vertices)) - 1);
    for (std::uint32_t tile = 0;
         tile < static_cast<std::uint32_t>(tree.tiles_x) * static_cast<std::uint32_t>(tree.tiles_y); ++tile) {
        const Window seen = seen_by_maps(maps, levels, tile);
        if (seen.area() == 0) continue;
        const std::int32_t x = static_cast<std::int32_t>(tile) % tree.tiles_x * tree.side(),
                           y = static_cast<std::int32_t>(tile) / tree.tiles_x * tree.side();
        // Beyond the end of a tile's own samples, which its last column and row are no part of.
        most = std::max({most, x - seen.x, y - seen.y, seen.x + seen.columns - (x + tree.side()),
                         seen.y + seen.rows - (y + tree.side())});
    }
    return most;
}

} // namespace fjell::baker
