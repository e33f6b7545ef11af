#include "gltf/geometry.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fjell/io/failure.h"
#include "fjell/pages.h"
#include "fjell/texture.h"
#include "gltf/texels.h"

namespace fjell::gltf {

namespace {

constexpr std::uint32_t no_slot = 0xffff'ffff;

std::int32_t side_of(const Terrain& terrain) {
    return std::int32_t{1} << terrain.header().tile_log2;
}

// Along one axis: the central difference of the full-resolution heights, one-sided on the domain's rim and beside
// missing tiles; where pages are missing, over the smallest power of two for which there are heights.
double slope_at(const Terrain& terrain, SampleIndex sample, SampleIndex axis, double spacing_m) {
    const auto at = [&](std::int32_t by) {
        return SampleIndex{sample.column + by * axis.column, sample.row + by * axis.row};
    };
    const auto inside = [&](SampleIndex c) {
        return c.column >= 0 && c.row >= 0 && c.column < static_cast<std::int32_t>(terrain.columns()) &&
               c.row < static_cast<std::int32_t>(terrain.rows());
    };
    for (std::int32_t step = 1; step <= side_of(terrain); step *= 2)
        for (const auto& [from, to] : {std::pair{-step, step}, {0, step}, {-step, 0}}) {
            if (!inside(at(from)) || !inside(at(to))) continue;
            const TerrainVertex a = terrain_vertex(terrain, at(from)), b = terrain_vertex(terrain, at(to));
            if (!a.loaded || !b.loaded || !a.in_tile || !b.in_tile) continue;
            return (static_cast<double>(b.height_m) - static_cast<double>(a.height_m)) / ((to - from) * spacing_m);
        }
    return 0;
}

void normal_at(const Terrain& terrain, SampleIndex sample, float* normal) {
    const double slope_x = slope_at(terrain, sample, {1, 0}, terrain.header().spacing_m[0]);
    const double slope_z = slope_at(terrain, sample, {0, 1}, terrain.header().spacing_m[1]);
    const double scale = 1 / std::sqrt(slope_x * slope_x + slope_z * slope_z + 1);
    normal[0] = static_cast<float>(-slope_x * scale);
    normal[1] = static_cast<float>(scale);
    normal[2] = static_cast<float>(-slope_z * scale);
}

bool is_degenerate(const MeshVertex& a, const MeshVertex& b, const MeshVertex& c) {
    const std::int64_t bx = b.column - a.column, by = b.row - a.row, cx = c.column - a.column, cy = c.row - a.row;
    return bx * cy == by * cx;
}

} // namespace

void put_over(const MovedNormals& moved, std::uint32_t side_px, std::span<std::byte> blocks) {
    const std::size_t row_bytes = moved.columns / 4 * normal_block_bytes;
    for (std::uint32_t row = 0; row < moved.rows / 4; ++row)
        std::copy_n(moved.blocks.begin() + static_cast<std::ptrdiff_t>(row * row_bytes), row_bytes,
                    blocks.begin() + static_cast<std::ptrdiff_t>(((moved.y / 4 + row) * (side_px / 4) + moved.x / 4) *
                                                                 normal_block_bytes));
}

Vec3 tile_corner_m(const Pack& pack, std::uint32_t tile) {
    const PackHeader& header = pack.header;
    const std::uint32_t place = pack.tile_place(tile);
    const double side = 1u << header.tile_log2;
    return {(place % header.tiles_x) * static_cast<double>(static_cast<float>(side * header.spacing_m[0])), 0,
            (place / header.tiles_x) * static_cast<double>(static_cast<float>(side * header.spacing_m[1]))};
}

TileCollector::TileCollector(const Terrain& the_terrain)
    : terrain(the_terrain), side(static_cast<std::uint32_t>(side_of(the_terrain))),
      slots(std::size_t{side + 1} * (side + 1), no_slot) {}

SampleIndex TileCollector::in_tile_of(std::uint32_t tile, const MeshVertex& vertex) const {
    const SampleIndex place = terrain.tile_place(tile);
    return SampleIndex{vertex.column, vertex.row} -
           SampleIndex{place.column * side_of(terrain), place.row * side_of(terrain)};
}

bool TileCollector::in_tile(std::uint32_t tile, const MeshVertex& vertex) const {
    const SampleIndex c = in_tile_of(tile, vertex);
    return c.column >= 0 && c.row >= 0 && c.column <= side_of(terrain) && c.row <= side_of(terrain);
}

std::size_t TileCollector::place(std::uint32_t tile, const MeshVertex& vertex) const {
    const SampleIndex c = in_tile_of(tile, vertex);
    return static_cast<std::size_t>(c.row) * (side + 1) + static_cast<std::size_t>(c.column);
}

SnapshotVertex TileCollector::make_vertex(std::uint32_t tile, const MeshVertex& vertex) const {
    const SampleIndex in_tile = in_tile_of(tile, vertex);
    SnapshotVertex made{};
    made.position_m[0] = static_cast<float>(in_tile.column * terrain.header().spacing_m[0]);
    made.position_m[1] = vertex.height_m;
    made.position_m[2] = static_cast<float>(in_tile.row * terrain.header().spacing_m[1]);
    normal_at(terrain, {vertex.column, vertex.row}, made.normal);
    made.cells[0] = static_cast<float>(in_tile.column);
    made.cells[1] = static_cast<float>(in_tile.row);
    std::ranges::copy(tangent_of(made.normal), made.tangent);
    return made;
}

std::uint32_t TileCollector::slot(TileGeometry& geometry, const MeshVertex& vertex) {
    std::uint32_t& found = slots[place(geometry.tile, vertex)];
    if (found == no_slot) {
        found = static_cast<std::uint32_t>(geometry.vertices.size());
        geometry.vertices.push_back(make_vertex(geometry.tile, vertex));
        const float* at = geometry.vertices.back().position_m;
        for (int axis = 0; axis < 3; ++axis) {
            geometry.low_m[axis] = found == 0 ? at[axis] : std::min(geometry.low_m[axis], at[axis]);
            geometry.high_m[axis] = found == 0 ? at[axis] : std::max(geometry.high_m[axis], at[axis]);
        }
    }
    return found;
}

// A strip's triangles turn by turns the other way round; where it turns itself they are degenerate.
void TileCollector::add(TileGeometry& geometry, const MeshView& mesh, const TileRange& range,
                        std::span<const float> drawn_m) {
    const bool strip = mesh.topology == Topology::strip;
    if (range.tile >= terrain.tile_count() || (!strip && range.index_count % 3 != 0) ||
        range.first_index > mesh.indices.size() || range.index_count > mesh.indices.size() - range.first_index)
        throw io::Failure(
            2, "MeshView::tiles: a range lies outside the indices or the terrain; hand over a mesh of this terrain");
    const auto corner = [&](std::uint32_t index) {
        const std::uint32_t number = mesh.indices[index];
        if (number >= mesh.vertices.size() || !in_tile(range.tile, mesh.vertices[number]))
            throw io::Failure(
                2, "MeshView::indices: an index or a vertex is out of range; hand over a mesh of this terrain");
        MeshVertex vertex = mesh.vertices[number];
        if (!drawn_m.empty()) vertex.height_m = drawn_m[number];
        return vertex;
    };
    for (std::uint32_t i = 0; i + 3 <= range.index_count; i += strip ? 1 : 3) {
        const std::uint32_t first = range.first_index + i;
        MeshVertex a = corner(first), b = corner(first + 1), c = corner(first + 2);
        if (is_degenerate(a, b, c)) continue;
        if (strip && i % 2 != 0) std::swap(a, b);
        for (const MeshVertex* v : {&a, &b, &c}) geometry.indices.push_back(slot(geometry, *v));
    }
}

TileGeometry TileCollector::collect(const MeshView& mesh, std::span<const TileRange> ranges,
                                    std::span<const float> drawn_m) {
    TileGeometry geometry{};
    geometry.tile = ranges.front().tile;
    for (const TileRange& range : ranges) add(geometry, mesh, range, drawn_m);
    // Only the used entries are cleared: a tile of few triangles costs no pass over its samples.
    for (const TileRange& range : ranges)
        for (std::uint32_t i = range.first_index; i < range.first_index + range.index_count; ++i)
            if (const MeshVertex& v = mesh.vertices[mesh.indices[i]]; in_tile(range.tile, v))
                slots[place(range.tile, v)] = no_slot;
    return geometry;
}

} // namespace fjell::gltf
