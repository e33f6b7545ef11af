#include "gltf/scene.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

namespace fjell::gltf {

namespace {

using Json = Glb::Json;

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

int SceneBuilder::add_texture(const std::string& name, std::uint32_t side_px, std::span<const std::byte> rgb) {
    return static_cast<int>(glb_.add_texture(name, encode_png(side_px, side_px, rgb), "image/png"));
}

std::size_t SceneBuilder::add_material(const std::string& name, TileTextures textures) {
    Json surface{{"metallicFactor", 0.0}};
    if (textures.colour >= 0)
        surface["baseColorTexture"]["index"] = textures.colour;
    else
        surface["baseColorFactor"] = {0.5, 0.5, 0.5, 1.0};
    Json material{{"name", name}, {"pbrMetallicRoughness", std::move(surface)}};
    if (textures.normal >= 0) material["normalTexture"]["index"] = textures.normal;
    if (textures.occlusion >= 0) material["occlusionTexture"]["index"] = textures.occlusion;
    return glb_.add("materials", std::move(material));
}

std::size_t SceneBuilder::add_mesh(const std::string& name, const TileGeometry& geometry, TileTextures textures) {
    const bool textured = textures.colour >= 0 || textures.normal >= 0 || textures.occlusion >= 0;
    const bool tangents = textures.normal >= 0;
    const std::size_t count = geometry.vertices.size();
    const std::size_t stride = tangents   ? sizeof(SnapshotVertex)
                               : textured ? offsetof(SnapshotVertex, tangent)
                                          : offsetof(SnapshotVertex, uv);
    std::vector<std::byte> bytes(count * stride);
    for (std::size_t i = 0; i < count; ++i) std::memcpy(bytes.data() + i * stride, &geometry.vertices[i], stride);
    const std::size_t view = glb_.add_view(std::move(bytes), GlbTarget::vertices, stride);

    const auto accessor = [&](std::size_t offset, const char* type) {
        return Json{{"bufferView", view},
                    {"byteOffset", offset},
                    {"componentType", static_cast<int>(glb_float)},
                    {"count", count},
                    {"type", type}};
    };
    Json places = accessor(offsetof(SnapshotVertex, position_m), "VEC3"), attributes;
    places["min"] = geometry.low_m, places["max"] = geometry.high_m;
    attributes["POSITION"] = glb_.add("accessors", std::move(places));
    attributes["NORMAL"] = glb_.add("accessors", accessor(offsetof(SnapshotVertex, normal), "VEC3"));
    if (textured) attributes["TEXCOORD_0"] = glb_.add("accessors", accessor(offsetof(SnapshotVertex, uv), "VEC2"));
    if (tangents) attributes["TANGENT"] = glb_.add("accessors", accessor(offsetof(SnapshotVertex, tangent), "VEC4"));
    const std::size_t indices = glb_.add_indices(
        glb_.add_view(index_bytes(geometry.indices, count), GlbTarget::indices), geometry.indices.size(), count);
    return glb_.add("meshes", {{"name", name},
                               {"primitives",
                                {{{"attributes", std::move(attributes)},
                                  {"indices", indices},
                                  {"material", add_material(name, textures)},
                                  {"mode", 4}}}}});
}

void SceneBuilder::add_tile(const std::string& name, const TileGeometry& geometry, Vec3 corner_m,
                            TileTextures textures) {
    const std::size_t mesh = add_mesh(name, geometry, textures);
    glb_.add_node({{"name", name}, {"mesh", mesh}, {"translation", {corner_m.x, corner_m.y, corner_m.z}}});
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
