// The glTF scene of a snapshot under construction.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "fjell/view.h"
#include "gltf/geometry.h"
#include "gltf/glb.h"

namespace fjell::gltf {

struct TileTextures {
    int colour = -1, normal = -1, occlusion = -1; // -1: none
};

class SceneBuilder {
public:
    explicit SceneBuilder(Glb& glb) : glb_(glb) {}

    // 8-bit sRGB, square. Returns the texture's index.
    int add_texture(const std::string& name, std::uint32_t side_px, std::span<const std::byte> rgb);
    // A node, a mesh and a material. Without textures the vertices carry no texture coordinates, without a normal
    // texture no tangents.
    void add_tile(const std::string& name, const TileGeometry& geometry, Vec3 corner_m, TileTextures textures);
    void add_camera(const View& view);

private:
    std::size_t add_material(const std::string& name, TileTextures textures);
    std::size_t add_mesh(const std::string& name, const TileGeometry& geometry, TileTextures textures);

    Glb& glb_;
};

} // namespace fjell::gltf
