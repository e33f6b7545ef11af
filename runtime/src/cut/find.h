// From places in the tree to vertices of the cut, and back. Pure, O(1), and what most of a change consists of.
#pragma once

#include <algorithm>

#include "cut/state.h"

namespace fjell {

// Does the terrain have a square of the step there? Not beyond its rim, nor where a tile is missing: that is a rim too.
[[nodiscard]] inline bool has_square(const Grid& grid, int z, std::int32_t i, std::int32_t j) {
    const std::int32_t log2 = grid.steps[z].log2;
    if (i < 0 || j < 0 || i >= grid.tiles_x << log2 || j >= grid.tiles_y << log2) return false;
    return grid.terrain->has_tile(i >> log2, j >> log2);
}

// Does the tree have a vertex there?
[[nodiscard]] inline bool exists(const Grid& grid, const Site& v) {
    if (v.z < 0 || v.i < 0 || v.j < 0) return false;
    const std::int32_t nx = grid.tiles_x << grid.steps[v.z].log2, ny = grid.tiles_y << grid.steps[v.z].log2;
    if (v.i >= nx + (v.kind == VertexKind::side_y) || v.j >= ny + (v.kind == VertexKind::side_x)) return false;
    if (!grid.terrain->is_sparse()) return true;
    const bool other = (v.kind == VertexKind::side_x && has_square(grid, v.z, v.i, v.j - 1)) ||
                       (v.kind == VertexKind::side_y && has_square(grid, v.z, v.i - 1, v.j));
    return other || has_square(grid, v.z, v.i, v.j);
}

// Where a site of the tree lies: its page, and its vertex in that.
struct Place {
    std::uint32_t page, vertex;
};
// The site must exist.
[[nodiscard]] inline Place place_of(const Grid& grid, const Site& v) {
    const StepGroups& step = grid.steps[v.z];
    // A border belongs to the tile and the page to its south or east; the terrain's rim to those it ends.
    std::int32_t tile_x = v.i >> step.log2, tile_y = v.j >> step.log2;
    tile_x -= tile_x == grid.tiles_x;
    tile_y -= tile_y == grid.tiles_y;
    if (grid.terrain->is_sparse() && !grid.terrain->has_tile(tile_x, tile_y)) { // so does the rim of a missing tile
        tile_x -= v.kind == VertexKind::side_y;
        tile_y -= v.kind == VertexKind::side_x;
    }
    auto i = static_cast<std::uint32_t>(v.i - (tile_x << step.log2)),
         j = static_cast<std::uint32_t>(v.j - (tile_y << step.log2));
    std::uint32_t page = grid.terrain->tile_at(tile_x, tile_y) * grid.pages_per_tile;
    if (step.log2 >= page_squares_log2) {
        const std::uint32_t last = (1u << (step.log2 - page_squares_log2)) - 1;
        const std::uint32_t px = std::min(i >> page_squares_log2, last), py = std::min(j >> page_squares_log2, last);
        page += step.first_page + (grid.hz_places ? interleave(px, py) : py * (last + 1) + px);
        i -= px << page_squares_log2;
        j -= py << page_squares_log2;
    }
    const std::uint32_t n = 1u << step.page_log2;
    const std::uint32_t row = (j << step.words_log2) + (i >> lanes_log2);
    switch (v.kind) {
    case VertexKind::centre: return {page, (step.centres + row) * group_lanes + i % group_lanes};
    case VertexKind::side_x: return {page, (step.sides_x + row) * group_lanes + i % group_lanes};
    case VertexKind::side_y: break;
    }
    if (i == n) return {page, (step.column + (j >> lanes_log2)) * group_lanes + j % group_lanes};
    return {page, (step.sides_y + row) * group_lanes + i % group_lanes};
}

// The vertex at a site, or no_index when its page has no state: it is not loaded, or none of its vertices has an active
// parent.
[[nodiscard]] inline std::uint32_t find_vertex(const Pages& pages, const Site& v) {
    const Place at = place_of(pages.grid, v);
    const std::uint32_t first = pages.page_groups[at.page];
    return first == no_index ? no_index : first * group_lanes + at.vertex;
}

// The records of the page that a state is of.
[[nodiscard]] inline const VertexRecord* records_of(const Pages& pages, std::uint32_t slot) {
    return pages.grid.terrain->records +
           std::size_t{pages.state[slot].terrain_slot} * pages.grid.terrain->page_capacity;
}

[[nodiscard]] inline const GroupShape& shape_of(const Pages& pages, std::uint32_t group) {
    const std::uint32_t slot = group / max_page_groups;
    return pages.grid.shapes[pages.state[slot].shape].groups[group - slot * max_page_groups];
}

[[nodiscard]] inline Site site_of(const Pages& pages, std::uint32_t vertex) {
    const std::uint32_t group = vertex / group_lanes;
    const auto lane = static_cast<std::int32_t>(vertex % group_lanes);
    const PageState& info = pages.state[group / max_page_groups];
    const GroupShape& shape = shape_of(pages, group);
    const int z = info.z + shape.z;
    return {z, shape.kind, (info.tile_x << pages.grid.steps[z].log2) + info.i0 + shape.i0 + (shape.along_y ? 0 : lane),
            (info.tile_y << pages.grid.steps[z].log2) + info.j0 + shape.j0 + (shape.along_y ? lane : 0)};
}

[[nodiscard]] inline VertexRecord record_of(const Pages& pages, std::uint32_t vertex) {
    const std::uint32_t group = vertex / group_lanes, lane = vertex % group_lanes, slot = group / max_page_groups;
    const VertexRecord* const records = records_of(pages, slot);
    if (pages.grid.hz_places) {
        const std::size_t page_shape = pages.state[slot].shape;
        return records[pages.grid.hz_places[((page_shape - slot) * max_page_groups + group) * group_lanes + lane]];
    }
    const GroupShape& shape = shape_of(pages, group);
    return records[shape.first + shape.stride * lane];
}

} // namespace fjell
