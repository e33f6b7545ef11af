#include "gltf/geometry.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "fjell/io/failure.h"
#include "fjell/pages.h"
#include "fjell/texture.h"

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

void set_texture_size(TileGeometry& geometry, std::uint32_t side, std::uint32_t texture_px) {
    const double texels = std::max(texture_px, 1u), first = 0.5 / texels, step = (texels - 1) / texels / side;
    for (SnapshotVertex& v : geometry.vertices)
        for (float& coordinate : v.uv) coordinate = static_cast<float>(first + step * static_cast<double>(coordinate));
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
    made.uv[0] = static_cast<float>(in_tile.column);
    made.uv[1] = static_cast<float>(in_tile.row);
    // East, less what of it lies along the normal; the normal points up, so something is left.
    const Vec3 n{made.normal[0], made.normal[1], made.normal[2]}, east = normalised(Vec3{1, 0, 0} - n * n.x);
    made.tangent[0] = static_cast<float>(east.x);
    made.tangent[1] = static_cast<float>(east.y);
    made.tangent[2] = static_cast<float>(east.z);
    made.tangent[3] = 1;
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

namespace {

// The frame of a triangle's corner.
struct Corner {
    Vec3 normal, tangent, bitangent;
};

Corner corner_of(const SnapshotVertex& v) {
    const Vec3 normal{v.normal[0], v.normal[1], v.normal[2]}, tangent{v.tangent[0], v.tangent[1], v.tangent[2]};
    return {normal, tangent, cross(normal, tangent) * static_cast<double>(v.tangent[3])};
}

// A place in a triangle: how much of each corner.
struct Weights {
    double a, b, c;
};

// Every texel whose centre lies in a triangle, or no further beyond its edges than rounding might be, so that none is
// left out between two. begin(corners, area in texels): of a triangle, whether it is wanted. put(corners, weights, x,
// y).
template <typename Begin, typename Put>
void for_texels(const TileGeometry& geometry, std::uint32_t texture_px, const Begin& begin, const Put& put) {
    struct Place {
        double x, y; // in texels, counted from texel centres
    };
    const auto last = static_cast<std::int64_t>(texture_px) - 1;
    const auto first_of = [&](double p) {
        return std::clamp<std::int64_t>(std::llround(std::ceil(p - 0.01)), 0, last);
    };
    const auto last_of = [&](double p) {
        return std::clamp<std::int64_t>(std::llround(std::floor(p + 0.01)), 0, last);
    };
    for (std::size_t i = 0; i < geometry.indices.size(); i += 3) {
        const SnapshotVertex* v[3];
        Place at[3];
        for (std::size_t k = 0; k < 3; ++k) {
            v[k] = &geometry.vertices[geometry.indices[i + k]];
            at[k] = {static_cast<double>(v[k]->uv[0]) * texture_px - 0.5,
                     static_cast<double>(v[k]->uv[1]) * texture_px - 0.5};
        }
        const auto& [a, b, c] = at;
        const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        if (!begin(v, std::abs(area) / 2)) continue;
        for (std::int64_t y = first_of(std::min({a.y, b.y, c.y})); y <= last_of(std::max({a.y, b.y, c.y})); ++y)
            for (std::int64_t x = first_of(std::min({a.x, b.x, c.x})); x <= last_of(std::max({a.x, b.x, c.x})); ++x) {
                const auto px = static_cast<double>(x), py = static_cast<double>(y);
                const double wb = ((px - a.x) * (c.y - a.y) - (py - a.y) * (c.x - a.x)) / area,
                             wc = ((b.x - a.x) * (py - a.y) - (b.y - a.y) * (px - a.x)) / area, wa = 1 - wb - wc;
                if (std::min({wa, wb, wc}) >= -0.01)
                    put(v, Weights{wa, wb, wc}, static_cast<std::size_t>(x), static_cast<std::size_t>(y));
            }
    }
}

// The map between its texels. x, y: 0 to baked_px - 1.
Vec3 baked_normal(std::span<const std::uint8_t> baked, std::uint32_t baked_px, double x, double y) {
    const auto most = static_cast<double>(baked_px - 1);
    const double cx = std::clamp(x, 0.0, most), cy = std::clamp(y, 0.0, most);
    const auto x0 = static_cast<std::size_t>(cx), y0 = static_cast<std::size_t>(cy);
    const std::size_t x1 = std::min<std::size_t>(x0 + 1, baked_px - 1),
                      y1 = std::min<std::size_t>(y0 + 1, baked_px - 1);
    const double u = cx - static_cast<double>(x0), v = cy - static_cast<double>(y0);
    const auto component = [&](std::size_t which) {
        const auto at = [&](std::size_t column, std::size_t row) {
            return static_cast<double>(normal_component(baked[2 * (row * baked_px + column) + which]));
        };
        return (at(x0, y0) * (1 - u) + at(x1, y0) * u) * (1 - v) + (at(x0, y1) * (1 - u) + at(x1, y1) * u) * v;
    };
    const double east = component(0), south = component(1);
    return {east, std::sqrt(std::max(1 - east * east - south * south, 0.0)), south};
}

std::uint8_t code(double component) {
    return static_cast<std::uint8_t>(std::lround((std::clamp(component, -1.0, 1.0) + 1) * 127.5));
}

// The baked normal as a sum of the three axes, by Cramer's rule: interpolated, they are not quite at right angles.
void put(const Vec3& baked, const Vec3& t, const Vec3& b, const Vec3& n, std::uint8_t* rgb) {
    const double det = dot(t, cross(b, n));
    if (!(std::abs(det) > 1e-6)) return;
    Vec3 local{dot(baked, cross(b, n)) / det, dot(baked, cross(n, t)) / det, dot(baked, cross(t, b)) / det};
    local.z = std::max(local.z, 0.01); // a texture holds none that points into the ground
    local = normalised(local);
    rgb[0] = code(local.x);
    rgb[1] = code(local.y);
    rgb[2] = code(local.z);
}

} // namespace

std::vector<std::uint8_t> normal_texture(const TileGeometry& geometry, std::uint32_t texture_px,
                                         std::span<const std::uint8_t> baked, std::uint32_t baked_px) {
    std::vector<std::uint8_t> rgb(std::size_t{texture_px} * texture_px * 3, 128);
    for (std::size_t i = 2; i < rgb.size(); i += 3) rgb[i] = 255;
    const double step = texture_px > 1 ? static_cast<double>(baked_px - 1) / (texture_px - 1) : 0;
    Corner a, b, c;
    const auto begin = [&](const SnapshotVertex* const(&v)[3], double area) {
        if (area < 1) return false; // where texels are coarser than triangles the vertices' own normals say more
        a = corner_of(*v[0]);
        b = corner_of(*v[1]);
        c = corner_of(*v[2]);
        return true;
    };
    for_texels(geometry, texture_px, begin,
               [&](const SnapshotVertex* const(&)[3], const Weights& w, std::size_t x, std::size_t y) {
                   const auto between = [&](Vec3 Corner::*axis) {
                       return normalised(a.*axis * w.a + b.*axis * w.b + c.*axis * w.c);
                   };
                   const Vec3 normal =
                       baked_normal(baked, baked_px, static_cast<double>(x) * step, static_cast<double>(y) * step);
                   put(normal, between(&Corner::tangent), between(&Corner::bitangent), between(&Corner::normal),
                       &rgb[3 * (y * texture_px + x)]);
               });
    return rgb;
}

TexelGround ground_of_texels(const TileGeometry& geometry, std::uint32_t texture_px,
                             std::span<const std::uint8_t> baked, std::uint32_t baked_px) {
    const std::size_t all = std::size_t{texture_px} * texture_px;
    TexelGround ground{std::vector<float>(all), std::vector<float>(all)};
    const double step = baked_px > 1 ? static_cast<double>(baked_px - 1) / (texture_px - 1) : 0;
    const auto begin = [](const SnapshotVertex* const(&)[3], double area) { return area > 0; };
    for_texels(
        geometry, texture_px, begin,
        [&](const SnapshotVertex* const(&v)[3], const Weights& w, std::size_t x, std::size_t y) {
            const auto between = [&](float p, float q, float r) {
                return static_cast<double>(p) * w.a + static_cast<double>(q) * w.b + static_cast<double>(r) * w.c;
            };
            const double up =
                baked_px > 1
                    ? baked_normal(baked, baked_px, static_cast<double>(x) * step, static_cast<double>(y) * step).y
                    : between(v[0]->normal[1], v[1]->normal[1], v[2]->normal[1]);
            const std::size_t at = y * texture_px + x;
            ground.height_m[at] =
                static_cast<float>(between(v[0]->position_m[1], v[1]->position_m[1], v[2]->position_m[1]));
            ground.slope_deg[at] = static_cast<float>(std::acos(std::clamp(up, 0.0, 1.0)) * 180 / std::numbers::pi);
        });
    return ground;
}

} // namespace fjell::gltf
