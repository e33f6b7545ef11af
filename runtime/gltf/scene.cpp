#include "gltf/scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace fjell::gltf {

namespace {

// Unit quaternion (x, y, z, w) of the rotation whose columns are right, up and back: from the largest of its four
// components, so that nothing is lost where another one vanishes.
std::vector<double> quaternion(Vec3 right, Vec3 up, Vec3 back) {
    const double m[3][3] = {{right.x, up.x, back.x}, {right.y, up.y, back.y}, {right.z, up.z, back.z}};
    const double trace = m[0][0] + m[1][1] + m[2][2];
    std::vector<double> q(4);
    if (trace > 0) {
        q = {m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1], 1 + trace};
    } else {
        const int i = m[0][0] >= m[1][1] && m[0][0] >= m[2][2] ? 0 : m[1][1] >= m[2][2] ? 1 : 2;
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        const auto at = [&](int index) -> double& { return q[static_cast<std::size_t>(index)]; };
        at(i) = 1 + m[i][i] - m[j][j] - m[k][k];
        at(j) = m[j][i] + m[i][j];
        at(k) = m[k][i] + m[i][k];
        at(3) = m[k][j] - m[j][k];
    }
    const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (double& component : q) component /= norm;
    return q;
}

} // namespace

int SceneBuilder::add_texture(const std::string& name, std::uint32_t side_px, std::span<const std::byte> rgb,
                              SnapshotImage image) {
    const bool jpeg = image == SnapshotImage::jpeg;
    return static_cast<int>(
        glb_.add_texture(name, jpeg ? encode_jpeg(side_px, side_px, rgb) : encode_png(side_px, side_px, rgb),
                         jpeg ? "image/jpeg" : "image/png"));
}

void SceneBuilder::add_tile(const std::string& name, const TileGeometry& geometry, Vec3 corner_m, GlbTextures textures,
                            const TexelGrid& texels) {
    const std::vector<SnapshotVertex>& v = geometry.vertices;
    GlbMesh mesh{name, v.size(), geometry.indices};
    const auto three = [](const float(&from)[3]) {
        return std::array{static_cast<double>(from[0]), static_cast<double>(from[1]), static_cast<double>(from[2])};
    };
    mesh.place = [&v, three](std::size_t i) { return three(v[i].position_m); };
    mesh.normal = [&v, three](std::size_t i) { return three(v[i].normal); };
    if (textures.normal >= 0)
        mesh.tangent = [&v](std::size_t i) {
            const auto& t = v[i].tangent;
            return std::array{static_cast<double>(t[0]), static_cast<double>(t[1]), static_cast<double>(t[2]),
                              static_cast<double>(t[3])};
        };
    if (textures.colour >= 0 || textures.normal >= 0 || textures.occlusion >= 0)
        mesh.uv = [&v, texels](std::size_t i) {
            return std::array{texels.u(static_cast<double>(v[i].cells[0])),
                              texels.v(static_cast<double>(v[i].cells[1]))};
        };
    mesh.textures = textures;
    mesh.origin = {corner_m.x, corner_m.y, corner_m.z};
    mesh.lattice = lattice_;
    add_glb_mesh(glb_, std::move(mesh), meshopt_);
}

void SceneBuilder::add_camera(const View& view) {
    // glTF has no off-centre cameras: the one that shows all of this one's picture.
    const double ty = std::max(view.top, -view.bottom), tx = std::max(view.right, -view.left);
    const std::size_t camera = glb_.add(
        "cameras",
        {{"name", "camera"},
         {"type", "perspective"},
         {"perspective",
          {{"yfov", 2 * std::atan(ty)}, {"aspectRatio", tx / ty}, {"znear", view.near_m}, {"zfar", view.far_m}}}});
    // A glTF camera looks along its own -z.
    glb_.add_node({{"name", "camera"},
                   {"camera", camera},
                   {"translation", {view.eye_m.x, view.eye_m.y, view.eye_m.z}},
                   {"rotation", quaternion(cross(view.forward, view.up), view.up, view.forward * -1)}});
}

} // namespace fjell::gltf
