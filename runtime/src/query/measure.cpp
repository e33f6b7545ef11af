#include "fjell/measure.h"

#include <algorithm>
#include <cmath>

#include "shared/terrain_data.h"

namespace fjell {

namespace {

struct Accumulator {
    const TerrainData& terrain;
    const View& view;
    const Frustum* frustum;
    double rounding_m; // what float heights may differ by from the height scale, at the sample and at the surface
    MeasuredError result;

    void sample(SampleIndex at, double surface_m) {
        const TerrainData::Vertex vertex = terrain.vertex(at);
        if (vertex.hole) return;
        const double height = vertex.height_m;
        const Vec3 eye_to_sample =
            Vec3{at.column * terrain.header.spacing_m[0], height, at.row * terrain.header.spacing_m[1]} - view.eye_m;
        if (frustum)
            for (int i = 0; i < 6; ++i)
                if (dot(frustum->normal[i], eye_to_sample) < frustum->offset[i]) return;
        ++result.samples;
        const double error_m = std::max(std::abs(height - surface_m) - rounding_m, 0.0);
        const double error_px = error_m * focal_length_px(view) / std::max(length(eye_to_sample), 1e-9);
        if (error_m > result.max_m) result.max_m = error_m, result.sample_m = at;
        if (error_px > result.max_px) result.max_px = error_px, result.sample_px = at;
    }
};

struct Point {
    std::int64_t x, y;
    double height_m;
};

std::int64_t cross2(const Point& a, const Point& b, std::int64_t x, std::int64_t y) {
    return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
}

// Every grid point in the closed triangle, by its three edge functions.
void triangle(Accumulator& accumulate, const Point& a, const Point& b, const Point& c) {
    const std::int64_t area = cross2(a, b, c.x, c.y);
    if (area == 0) return;
    const std::int64_t sign = area > 0 ? 1 : -1;
    const auto [x0, x1] = std::minmax({a.x, b.x, c.x});
    const auto [y0, y1] = std::minmax({a.y, b.y, c.y});
    for (std::int64_t y = y0; y <= y1; ++y)
        for (std::int64_t x = x0; x <= x1; ++x) {
            const std::int64_t wa = cross2(b, c, x, y) * sign, wb = cross2(c, a, x, y) * sign,
                               wc = cross2(a, b, x, y) * sign;
            if (wa < 0 || wb < 0 || wc < 0) continue;
            const double surface = (static_cast<double>(wa) * a.height_m + static_cast<double>(wb) * b.height_m +
                                    static_cast<double>(wc) * c.height_m) /
                                   static_cast<double>(area * sign);
            accumulate.sample({static_cast<std::int32_t>(x), static_cast<std::int32_t>(y)}, surface);
        }
}

// Every index and every vertex that is drawn exists.
bool is_of(const MeshView& mesh, const TerrainData& terrain) {
    for (const TileRange& range : mesh.tiles) {
        if (std::uint64_t{range.first_index} + range.index_count > mesh.indices.size()) return false;
        for (const std::uint32_t index : mesh.indices.subspan(range.first_index, range.index_count)) {
            if (index >= mesh.vertices.size()) return false;
            const MeshVertex& v = mesh.vertices[index];
            if (v.column < 0 || v.row < 0 || v.column >= terrain.tree.columns() || v.row >= terrain.tree.rows())
                return false;
        }
    }
    return true;
}

} // namespace

MeasuredError measure_error(const Terrain& handle, const MeshView& mesh, const View& view, const Frustum* frustum) {
    const TerrainData* const data = find(handle);
    if (data == nullptr) return {};
    const TerrainData& terrain = *data;
    // base + steps * quantum: one rounding of the product, one of the sum; twice.
    const double low = terrain.range.low_m, high = terrain.range.high_m;
    const double rounding_m = 0x1p-23 * (std::max(std::abs(low), std::abs(high)) + high - low);
    Accumulator accumulate{terrain, view, frustum, rounding_m, {}};
    if (!is_of(mesh, terrain)) return {};
    for (const TileRange& range : mesh.tiles) {
        const auto point = [&](std::uint32_t index) -> Point {
            const MeshVertex& v = mesh.vertices[mesh.indices[index]];
            return {v.column, v.row, v.height_m};
        };
        // A strip's triangles overlap in their indices; its degenerate ones have no area and are skipped.
        const std::uint32_t step = mesh.topology == Topology::strip ? 1 : 3;
        for (std::uint32_t i = 0; i + 3 <= range.index_count; i += step) {
            const std::uint32_t first = range.first_index + i;
            triangle(accumulate, point(first), point(first + 1), point(first + 2));
        }
    }
    return accumulate.result;
}

} // namespace fjell
