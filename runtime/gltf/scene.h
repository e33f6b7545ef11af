// The glTF scene under construction: tinygltf's model, and the binary chunk as a list of pieces.
//
// tinygltf 2.7 writes the JSON; the container is written by snapshot.cpp, because tinygltf's own writer copies the
// whole binary chunk, does not look whether a write succeeded, and knows no null (extras.crs may be one).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <tiny_gltf.h>

#include "fjell/view.h"
#include "gltf/geometry.h"

namespace fjell::gltf {

struct TileTextures {
    int colour = -1, normal = -1, occlusion = -1; // -1: none
};

class SceneBuilder {
public:
    // max_binary_bytes: append beyond it throws io::Failure, before anything more is allocated.
    explicit SceneBuilder(std::uint64_t max_binary_bytes);

    // 8-bit sRGB, square. Returns the texture's index.
    int add_texture(const std::string& name, std::uint32_t side_px, std::span<const std::byte> rgb);
    // A node, a mesh and a material. Without textures the vertices carry no texture coordinates, without a normal
    // texture no tangents.
    void add_tile(const std::string& name, const TileGeometry& geometry, Vec3 corner_m, TileTextures textures);
    void add_camera(const View& view);

    [[nodiscard]] const tinygltf::Model& model() const { return model_; }
    // Concatenated, they are the binary chunk; the size of each is a multiple of 4.
    [[nodiscard]] const std::vector<std::vector<std::byte>>& pieces() const { return pieces_; }
    [[nodiscard]] std::uint64_t binary_bytes() const { return binary_bytes_; }

private:
    int add_view(std::vector<std::byte> bytes, int target, std::size_t stride);
    int add_vertex_accessor(int view, std::size_t offset, int type, std::size_t count);
    int add_indices(const TileGeometry& geometry);
    int add_material(const std::string& name, TileTextures textures);
    int add_mesh(const std::string& name, const TileGeometry& geometry, TileTextures textures);

    tinygltf::Model model_;
    std::vector<std::vector<std::byte>> pieces_;
    std::uint64_t binary_bytes_ = 0, max_binary_bytes_;
};

} // namespace fjell::gltf
