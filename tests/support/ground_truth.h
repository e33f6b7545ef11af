// The full-resolution ground, found without the hierarchy: which of a cell's two triangles is under a point.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "shared/terrain_data.h"
#include "support/terrain_fixture.h"

namespace fjell::test {

// The halves of cell (i, j). Vertices of the last step sit where both coordinates are odd, and every diagonal runs
// through one of them: from an odd place to an even one.
inline std::array<std::array<SampleIndex, 3>, 2> halves_of_cell(std::int32_t i, std::int32_t j) {
    const SampleIndex nw{i, j}, ne{i + 1, j}, sw{i, j + 1}, se{i + 1, j + 1};
    if (((i + j) & 1) == 0) return {{{nw, sw, se}, {nw, se, ne}}};
    return {{{nw, sw, ne}, {ne, sw, se}}};
}

struct TruePlane { // in metres over cells
    double height = 0, x = 0, y = 0;
    bool hole = false;
};
inline TruePlane plane_of(const Terrain& full, const std::array<SampleIndex, 3>& c) {
    TruePlane out;
    double h[3];
    for (std::size_t k = 0; k < 3; ++k) {
        const TerrainData::Vertex v = data_of(full).vertex(c[k]);
        h[k] = static_cast<double>(data_of(full).height_scale.base_m) +
               v.steps * static_cast<double>(data_of(full).height_scale.quantum_m);
        out.hole = out.hole || (full.has_voids() && v.hole);
    }
    const double bx = c[1].column - c[0].column, by = c[1].row - c[0].row, cx = c[2].column - c[0].column,
                 cy = c[2].row - c[0].row;
    const double area = bx * cy - by * cx;
    out.x = ((h[1] - h[0]) * cy - (h[2] - h[0]) * by) / area;
    out.y = ((h[2] - h[0]) * bx - (h[1] - h[0]) * cx) / area;
    out.height = h[0] - out.x * c[0].column - out.y * c[0].row;
    return out;
}
// At a place within the terrain, in cells.
inline TruePlane true_plane(const Terrain& full, double column, double row) {
    const std::int32_t i = std::clamp(static_cast<std::int32_t>(std::floor(column)), 0,
                                      data_of(full).tree.columns() - 2),
                       j = std::clamp(static_cast<std::int32_t>(std::floor(row)), 0, data_of(full).tree.rows() - 2);
    const auto halves = halves_of_cell(i, j);
    const double u = column - i, v = row - j;
    const bool first = ((i + j) & 1) == 0 ? v >= u : u + v <= 1;
    return plane_of(full, halves[first ? 0 : 1]);
}
inline double at(const TruePlane& plane, double column, double row) {
    return plane.height + plane.x * column + plane.y * row;
}

// The surface of a mesh of lists there, in metres; no triangle: NaN.
inline double drawn_m(const MeshView& mesh, double column, double row) {
    for (const TileRange& range : mesh.tiles)
        for (std::uint32_t i = range.first_index; i + 2 < range.first_index + range.index_count; i += 3) {
            const MeshVertex& a = mesh.vertices[mesh.indices[i]];
            const MeshVertex& b = mesh.vertices[mesh.indices[i + 1]];
            const MeshVertex& c = mesh.vertices[mesh.indices[i + 2]];
            const double bx = b.column - a.column, by = b.row - a.row, cx = c.column - a.column, cy = c.row - a.row;
            const double px = column - a.column, py = row - a.row, area = bx * cy - by * cx;
            if (area == 0) continue;
            const double u = (px * cy - py * cx) / area, v = (bx * py - by * px) / area;
            if (u < 0 || v < 0 || u + v > 1) continue;
            const auto h = [](const MeshVertex& m) { return static_cast<double>(m.height_m); };
            return h(a) + u * (h(b) - h(a)) + v * (h(c) - h(a));
        }
    return std::nan("");
}

// What doubles may lose: some hundred roundings of numbers as large as heights, and of places times the steepest slope.
inline double rounding_m(const Terrain& t, double largest_place_cells = 0) {
    const double range = t.header().height_steps * static_cast<double>(data_of(t).height_scale.quantum_m);
    const double cells =
        std::max({largest_place_cells, double(data_of(t).tree.columns()), double(data_of(t).tree.rows())});
    return 0x1p-45 * (std::abs(static_cast<double>(data_of(t).height_scale.base_m)) + range * (1 + cells));
}

// Loads a random subset, from coarse to fine as pages ask for, then takes some away again, coarse ones too.
inline void load_some_pages(Random& random, const Pack& pack, Terrain& terrain) {
    const double share = uniform(random, 0, 1.1), keep = uniform(random, 0.3, 1.1);
    for (std::uint32_t tile = 0; tile < terrain.tile_count(); ++tile)
        for (std::uint32_t page = 0; page < terrain.pages_per_tile(); ++page)
            if (uniform(random, 0, 1) <= share) (void)load_page(pack, terrain, tile, page);
    for (std::uint32_t tile = 0; tile < terrain.tile_count(); ++tile)
        for (std::uint32_t page = 0; page < terrain.pages_per_tile(); ++page)
            if (uniform(random, 0, 1) > keep) (void)unload_page(terrain, tile, page);
}

// Any size, tiling, order, estimate; holes in one of three when they may be.
inline io::LoadedPack random_ground(Random& random, bool holes, ErrorEstimate* estimate = nullptr) {
    const bool large = pick(random, 0, 7) == 0; // pages other than 0 need tiles of more than 32 cells
    const int log2 = large ? pick(random, 6, 8) : pick(random, 1, 7);
    baker::Dem dem = random_dem(random, pick(random, 2, large ? 400 : 120), pick(random, 2, large ? 300 : 90),
                                static_cast<Shape>(pick(random, 0, static_cast<int>(Shape::count) - 1)));
    if (holes && pick(random, 0, 2) == 0) add_random_holes(random, dem, log2);
    baker::BakeOptions options = small_bake(log2);
    options.order = static_cast<PageOrder>(pick(random, 0, 2));
    options.estimate = estimate && pick(random, 0, 4) == 0 ? ErrorEstimate::midpoint : ErrorEstimate::max;
    if (estimate) *estimate = options.estimate;
    return bake_and_load(std::move(dem), options);
}

} // namespace fjell::test
