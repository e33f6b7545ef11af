#include "gltf/normals.h"

#include <algorithm>
#include <cmath>

#include "fjell/texture.h"

namespace fjell::gltf {

namespace {

// Corners of a triangle in texels, counted from texel centres, and their frames.
struct Corner {
    double x, y;
    Vec3 normal, tangent, bitangent;
};

Corner corner_of(const SnapshotVertex& v, std::uint32_t texture_px) {
    const Vec3 normal{v.normal[0], v.normal[1], v.normal[2]}, tangent{v.tangent[0], v.tangent[1], v.tangent[2]};
    return {static_cast<double>(v.uv[0]) * texture_px - 0.5, static_cast<double>(v.uv[1]) * texture_px - 0.5, normal,
            tangent, cross(normal, tangent) * static_cast<double>(v.tangent[3])};
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
    const auto last = static_cast<std::int64_t>(texture_px) - 1;
    for (std::size_t i = 0; i < geometry.indices.size(); i += 3) {
        const Corner a = corner_of(geometry.vertices[geometry.indices[i]], texture_px),
                     b = corner_of(geometry.vertices[geometry.indices[i + 1]], texture_px),
                     c = corner_of(geometry.vertices[geometry.indices[i + 2]], texture_px);
        const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        // Where texels are coarser than triangles the vertices' own normals say more.
        if (std::abs(area) / 2 < 1) continue;
        // A little beyond its edges, so that rounding leaves no texel between two triangles.
        const auto first_of = [&](double p) {
            return std::clamp<std::int64_t>(std::llround(std::ceil(p - 0.01)), 0, last);
        };
        const auto last_of = [&](double p) {
            return std::clamp<std::int64_t>(std::llround(std::floor(p + 0.01)), 0, last);
        };
        for (std::int64_t y = first_of(std::min({a.y, b.y, c.y})); y <= last_of(std::max({a.y, b.y, c.y})); ++y)
            for (std::int64_t x = first_of(std::min({a.x, b.x, c.x})); x <= last_of(std::max({a.x, b.x, c.x})); ++x) {
                const auto px = static_cast<double>(x), py = static_cast<double>(y);
                const double wb = ((px - a.x) * (c.y - a.y) - (py - a.y) * (c.x - a.x)) / area,
                             wc = ((b.x - a.x) * (py - a.y) - (b.y - a.y) * (px - a.x)) / area, wa = 1 - wb - wc;
                if (!(std::min({wa, wb, wc}) >= -0.01)) continue;
                const auto between = [&](Vec3 Corner::*axis) {
                    return normalised(a.*axis * wa + b.*axis * wb + c.*axis * wc);
                };
                put(baked_normal(baked, baked_px, px * step, py * step), between(&Corner::tangent),
                    between(&Corner::bitangent), between(&Corner::normal),
                    &rgb[3 * (static_cast<std::size_t>(y) * texture_px + static_cast<std::size_t>(x))]);
            }
    }
    return rgb;
}

} // namespace fjell::gltf
