// What textures of a mesh are made of beside its maps: the normal texture, which turns the mesh' interpolated normals
// into those of the full resolution, and the ground at each texel.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "fjell/export.h"
#include "fjell/view.h"
#include "gltf/geometry.h"

FJELL_API_BEGIN
namespace fjell::gltf {

// The texels of a texture over so many cells: the outer texel centres lie on the border.
struct TexelGrid {
    std::uint32_t columns = 1, rows = 1; // texels
    double cells_x = 1, cells_y = 1;

    // The texture coordinates of a place in cells.
    [[nodiscard]] double u(double cells) const { return (0.5 + cells * per_cell_x()) / columns; }
    [[nodiscard]] double v(double cells) const { return (0.5 + cells * per_cell_y()) / rows; }
    [[nodiscard]] double per_cell_x() const { return (columns - 1) / cells_x; }
    [[nodiscard]] double per_cell_y() const { return (rows - 1) / cells_y; }
};
struct TexelMesh {
    std::span<const SnapshotVertex> vertices;
    std::span<const std::uint32_t> indices; // three for each triangle
};
// A unit vector at a texel, which need not be a whole one.
using NormalAt = std::function<Vec3(double x, double y)>;

// Of the map of a tile, between its texels, as one of a texture with texture_px texels a side. map: BC5 decoded,
// map_px texels a side (fjell/texture.h), which must live on.
[[nodiscard]] NormalAt map_normals(std::span<const std::uint8_t> map, std::uint32_t map_px, std::uint32_t texture_px);

// East along the ground, less what of it lies along the normal, and 1: the third axis of the frame points north.
[[nodiscard]] std::array<float, 4> tangent_of(const float (&normal)[3]);

// Returns RGB texels, row by row: the normal there in the frame that glTF interpolates from the vertices' normals and
// tangents; what changes nothing where triangles are smaller than texels, or where there are none.
// O(texels * triangles that touch each).
[[nodiscard]] std::vector<std::uint8_t> normal_texture(const TexelMesh& mesh, const TexelGrid& grid,
                                                       const NormalAt& normal_at);

// Of the mesh at each texel, 0 where there is none; the slope is that of normal_at where it is given.
struct TexelGround {
    std::vector<float> height_m, slope_deg;
};
[[nodiscard]] TexelGround ground_of_texels(const TexelMesh& mesh, const TexelGrid& grid, const NormalAt& normal_at);

} // namespace fjell::gltf
FJELL_API_END
