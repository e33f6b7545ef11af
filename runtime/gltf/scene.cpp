#include "gltf/scene.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <exception>
#include <utility>

#include <stb_image_write.h>

#include "fjell/io/failure.h"

namespace fjell::gltf {

namespace {

int last(const auto& list) {
    return static_cast<int>(list.size()) - 1;
}

// stb hands over the whole file in one call; nothing may be thrown through its C frames.
struct PngSink {
    std::vector<std::byte> bytes;
    std::exception_ptr failure;
};

void receive(void* context, void* data, int size) {
    auto& sink = *static_cast<PngSink*>(context);
    try {
        const auto* begin = static_cast<const std::byte*>(data);
        sink.bytes.insert(sink.bytes.end(), begin, begin + size);
    } catch (...) {
        sink.failure = std::current_exception();
    }
}

std::vector<std::byte> encode_png(std::uint32_t side_px, std::span<const std::byte> rgb) {
    PngSink sink;
    const int side = static_cast<int>(side_px);
    const int written = stbi_write_png_to_func(receive, &sink, side, side, 3, rgb.data(), side * 3);
    if (sink.failure) std::rethrow_exception(sink.failure);
    if (!written)
        throw io::Failure(3, "not enough memory to encode a texture as PNG; ask for smaller textures (max_texture_px)");
    return std::move(sink.bytes);
}

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

SceneBuilder::SceneBuilder(std::uint64_t max_binary_bytes) : max_binary_bytes_(max_binary_bytes) {
    model_.asset.version = "2.0";
    model_.asset.generator = "Fjell";
    model_.defaultScene = 0;
    model_.scenes.resize(1);
}

int SceneBuilder::add_view(std::vector<std::byte> bytes, int target, std::size_t stride) {
    const std::size_t length = bytes.size(), padded = (length + 3) / 4 * 4;
    if (padded > max_binary_bytes_ - binary_bytes_)
        throw io::Failure(
            1, "the snapshot needs more bytes than a .glb may have (4 GiB, or max_file_bytes); ask for a larger "
               "error_px or smaller textures (max_texture_px)");
    bytes.resize(padded);
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = binary_bytes_;
    view.byteLength = length;
    view.byteStride = stride;
    view.target = target;
    model_.bufferViews.push_back(std::move(view));
    pieces_.push_back(std::move(bytes));
    binary_bytes_ += padded;
    return last(model_.bufferViews);
}

int SceneBuilder::add_texture(const std::string& name, std::uint32_t side_px, std::span<const std::byte> rgb) {
    if (model_.samplers.empty()) {
        tinygltf::Sampler sampler;
        sampler.magFilter = TINYGLTF_TEXTURE_FILTER_LINEAR;
        sampler.minFilter = TINYGLTF_TEXTURE_FILTER_LINEAR_MIPMAP_LINEAR;
        sampler.wrapS = sampler.wrapT = TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE;
        model_.samplers.push_back(std::move(sampler));
    }
    tinygltf::Image image;
    image.name = name;
    image.mimeType = "image/png";
    image.bufferView = add_view(encode_png(side_px, rgb), 0, 0);
    model_.images.push_back(std::move(image));
    tinygltf::Texture texture;
    texture.sampler = 0;
    texture.source = last(model_.images);
    model_.textures.push_back(std::move(texture));
    return last(model_.textures);
}

int SceneBuilder::add_vertex_accessor(int view, std::size_t offset, int type, std::size_t count) {
    tinygltf::Accessor accessor;
    accessor.bufferView = view;
    accessor.byteOffset = offset;
    accessor.componentType = TINYGLTF_COMPONENT_TYPE_FLOAT;
    accessor.type = type;
    accessor.count = count;
    model_.accessors.push_back(std::move(accessor));
    return last(model_.accessors);
}

int SceneBuilder::add_indices(const TileGeometry& geometry) {
    // The largest 16-bit index restarts primitives, so it may not name a vertex.
    const bool small = geometry.vertices.size() <= 0xffff;
    std::vector<std::byte> bytes(geometry.indices.size() * (small ? 2 : 4));
    if (small) {
        std::vector<std::uint16_t> narrow(geometry.indices.size());
        std::ranges::transform(geometry.indices, narrow.begin(),
                               [](std::uint32_t i) { return static_cast<std::uint16_t>(i); });
        std::memcpy(bytes.data(), narrow.data(), bytes.size());
    } else {
        std::memcpy(bytes.data(), geometry.indices.data(), bytes.size());
    }
    tinygltf::Accessor accessor;
    accessor.bufferView = add_view(std::move(bytes), TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER, 0);
    accessor.componentType = small ? TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT : TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
    accessor.type = TINYGLTF_TYPE_SCALAR;
    accessor.count = geometry.indices.size();
    model_.accessors.push_back(std::move(accessor));
    return last(model_.accessors);
}

int SceneBuilder::add_material(const std::string& name, TileTextures textures) {
    tinygltf::Material material;
    material.name = name;
    material.pbrMetallicRoughness.metallicFactor = 0;
    material.pbrMetallicRoughness.baseColorTexture.index = textures.colour;
    if (textures.colour < 0) material.pbrMetallicRoughness.baseColorFactor = {0.5, 0.5, 0.5, 1};
    material.normalTexture.index = textures.normal;
    material.occlusionTexture.index = textures.occlusion;
    model_.materials.push_back(std::move(material));
    return last(model_.materials);
}

int SceneBuilder::add_mesh(const std::string& name, const TileGeometry& geometry, TileTextures textures) {
    const bool textured = textures.colour >= 0 || textures.normal >= 0 || textures.occlusion >= 0;
    const bool tangents = textures.normal >= 0;
    const std::size_t count = geometry.vertices.size();
    const std::size_t stride = tangents   ? sizeof(SnapshotVertex)
                               : textured ? offsetof(SnapshotVertex, tangent)
                                          : offsetof(SnapshotVertex, uv);
    std::vector<std::byte> bytes(count * stride);
    for (std::size_t i = 0; i < count; ++i) std::memcpy(bytes.data() + i * stride, &geometry.vertices[i], stride);
    const int view = add_view(std::move(bytes), TINYGLTF_TARGET_ARRAY_BUFFER, stride);

    tinygltf::Primitive primitive;
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
    const auto add = [&](const char* attribute, std::size_t offset, int type) {
        primitive.attributes[attribute] = add_vertex_accessor(view, offset, type, count);
    };
    add("POSITION", offsetof(SnapshotVertex, position_m), TINYGLTF_TYPE_VEC3);
    model_.accessors.back().minValues.assign(geometry.low_m, geometry.low_m + 3);
    model_.accessors.back().maxValues.assign(geometry.high_m, geometry.high_m + 3);
    add("NORMAL", offsetof(SnapshotVertex, normal), TINYGLTF_TYPE_VEC3);
    if (textured) add("TEXCOORD_0", offsetof(SnapshotVertex, uv), TINYGLTF_TYPE_VEC2);
    if (tangents) add("TANGENT", offsetof(SnapshotVertex, tangent), TINYGLTF_TYPE_VEC4);
    primitive.indices = add_indices(geometry);
    primitive.material = add_material(name, textures);

    tinygltf::Mesh mesh;
    mesh.name = name;
    mesh.primitives.push_back(std::move(primitive));
    model_.meshes.push_back(std::move(mesh));
    return last(model_.meshes);
}

void SceneBuilder::add_tile(const std::string& name, const TileGeometry& geometry, Vec3 corner_m,
                            TileTextures textures) {
    tinygltf::Node node;
    node.name = name;
    node.mesh = add_mesh(name, geometry, textures);
    node.translation = {corner_m.x, corner_m.y, corner_m.z};
    model_.nodes.push_back(std::move(node));
    model_.scenes[0].nodes.push_back(last(model_.nodes));
}

void SceneBuilder::add_camera(const View& view) {
    tinygltf::Camera camera;
    camera.name = "camera";
    camera.type = "perspective";
    // glTF has no off-centre cameras: the one that shows all of this one's picture.
    const double ty = std::max(view.top, -view.bottom), tx = std::max(view.right, -view.left);
    camera.perspective.yfov = 2 * std::atan(ty);
    camera.perspective.aspectRatio = tx / ty;
    camera.perspective.znear = view.near_m;
    camera.perspective.zfar = view.far_m;
    model_.cameras.push_back(std::move(camera));
    tinygltf::Node node;
    node.name = "camera";
    node.camera = last(model_.cameras);
    node.translation = {view.eye_m.x, view.eye_m.y, view.eye_m.z};
    // A glTF camera looks along its own -z.
    node.rotation = quaternion(cross(view.forward, view.up), view.up, view.forward * -1);
    model_.nodes.push_back(std::move(node));
    model_.scenes[0].nodes.push_back(last(model_.nodes));
}

} // namespace fjell::gltf
