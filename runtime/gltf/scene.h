// The glTF scene of a snapshot under construction.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "fjell/gltf/snapshot.h"
#include "fjell/view.h"
#include "gltf/geometry.h"
#include "gltf/glb.h"
#include "gltf/mesh.h"
#include "gltf/texels.h"

namespace fjell::gltf {

class SceneBuilder {
public:
    // lattice: that of all tiles, whose own places are whole numbers of it; none: places are floats.
    SceneBuilder(Glb& glb, std::optional<GlbLattice> lattice, bool meshopt)
        : glb_(glb), lattice_(std::move(lattice)), meshopt_(meshopt) {}

    // 8-bit sRGB, square. Returns the texture's index.
    int add_texture(const std::string& name, std::uint32_t side_px, std::span<const std::byte> rgb,
                    SnapshotImage image);
    // A node, a mesh and a material. Without textures the vertices carry no texture coordinates, without a normal
    // texture no tangents. geometry lives until the file is written. texels: of its textures.
    void add_tile(const std::string& name, const TileGeometry& geometry, Vec3 corner_m, GlbTextures textures,
                  const TexelGrid& texels);
    void add_camera(const View& view);

private:
    Glb& glb_;
    std::optional<GlbLattice> lattice_;
    bool meshopt_;
};

} // namespace fjell::gltf
