#include "gltf/texels.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "fjell/texture.h"

namespace fjell::gltf {

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
void for_texels(const TexelMesh& mesh, const TexelGrid& grid, const Begin& begin, const Put& put) {
    struct Place {
        double x, y; // in texels, counted from texel centres
    };
    const auto first_of = [](double p, std::uint32_t texels) {
        return std::clamp<std::int64_t>(std::llround(std::ceil(p - 0.01)), 0, std::int64_t{texels} - 1);
    };
    const auto last_of = [](double p, std::uint32_t texels) {
        return std::clamp<std::int64_t>(std::llround(std::floor(p + 0.01)), 0, std::int64_t{texels} - 1);
    };
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
        const SnapshotVertex* v[3];
        Place at[3];
        for (std::size_t k = 0; k < 3; ++k) {
            v[k] = &mesh.vertices[mesh.indices[i + k]];
            at[k] = {static_cast<double>(v[k]->cells[0]) * grid.per_cell_x(),
                     static_cast<double>(v[k]->cells[1]) * grid.per_cell_y()};
        }
        const auto& [a, b, c] = at;
        const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        if (!begin(v, std::abs(area) / 2)) continue;
        const std::int64_t left = first_of(std::min({a.x, b.x, c.x}), grid.columns),
                           right = last_of(std::max({a.x, b.x, c.x}), grid.columns),
                           top = first_of(std::min({a.y, b.y, c.y}), grid.rows),
                           bottom = last_of(std::max({a.y, b.y, c.y}), grid.rows);
        for (std::int64_t y = top; y <= bottom; ++y)
            for (std::int64_t x = left; x <= right; ++x) {
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

std::array<float, 4> tangent_of(const float (&normal)[3]) {
    // The normal points up, so something is left.
    const Vec3 n{normal[0], normal[1], normal[2]}, east = normalised(Vec3{1, 0, 0} - n * n.x);
    return {static_cast<float>(east.x), static_cast<float>(east.y), static_cast<float>(east.z), 1};
}

NormalAt map_normals(std::span<const std::uint8_t> map, std::uint32_t map_px, std::uint32_t texture_px) {
    const double step = texture_px > 1 ? static_cast<double>(map_px - 1) / (texture_px - 1) : 0;
    return [map, map_px, step](double x, double y) { return baked_normal(map, map_px, x * step, y * step); };
}

std::vector<std::uint8_t> normal_texture(const TexelMesh& mesh, const TexelGrid& grid, const NormalAt& normal_at) {
    std::vector<std::uint8_t> rgb(std::size_t{grid.columns} * grid.rows * 3, 128);
    for (std::size_t i = 2; i < rgb.size(); i += 3) rgb[i] = 255;
    Corner a, b, c;
    const auto begin = [&](const SnapshotVertex* const(&v)[3], double area) {
        if (area < 1) return false; // where texels are coarser than triangles the vertices' own normals say more
        a = corner_of(*v[0]);
        b = corner_of(*v[1]);
        c = corner_of(*v[2]);
        return true;
    };
    for_texels(mesh, grid, begin,
               [&](const SnapshotVertex* const(&)[3], const Weights& w, std::size_t x, std::size_t y) {
                   const auto between = [&](Vec3 Corner::*axis) {
                       return normalised(a.*axis * w.a + b.*axis * w.b + c.*axis * w.c);
                   };
                   put(normal_at(static_cast<double>(x), static_cast<double>(y)), between(&Corner::tangent),
                       between(&Corner::bitangent), between(&Corner::normal), &rgb[3 * (y * grid.columns + x)]);
               });
    return rgb;
}

TexelGround ground_of_texels(const TexelMesh& mesh, const TexelGrid& grid, const NormalAt& normal_at) {
    const std::size_t all = std::size_t{grid.columns} * grid.rows;
    TexelGround ground{std::vector<float>(all), std::vector<float>(all)};
    const auto begin = [](const SnapshotVertex* const(&)[3], double area) { return area > 0; };
    for_texels(
        mesh, grid, begin, [&](const SnapshotVertex* const(&v)[3], const Weights& w, std::size_t x, std::size_t y) {
            const auto between = [&](float p, float q, float r) {
                return static_cast<double>(p) * w.a + static_cast<double>(q) * w.b + static_cast<double>(r) * w.c;
            };
            const double up = normal_at ? normal_at(static_cast<double>(x), static_cast<double>(y)).y
                                        : between(v[0]->normal[1], v[1]->normal[1], v[2]->normal[1]);
            const std::size_t at = y * grid.columns + x;
            ground.height_m[at] =
                static_cast<float>(between(v[0]->position_m[1], v[1]->position_m[1], v[2]->position_m[1]));
            ground.slope_deg[at] = static_cast<float>(std::acos(std::clamp(up, 0.0, 1.0)) * 180 / std::numbers::pi);
        });
    return ground;
}

} // namespace fjell::gltf
