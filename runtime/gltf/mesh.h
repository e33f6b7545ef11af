// A mesh as a node of a glTF file: float or on a lattice of 16 bits (KHR_mesh_quantization), plain or compressed
// (EXT_meshopt_compression). Tiles of snapshots, meshes of height fields and 3D Tiles are all written here.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "fjell/export.h"
#include "gltf/glb.h"

FJELL_API_BEGIN
namespace fjell::gltf {

struct GlbPacking {
    bool quantised = false;
    bool meshopt = false;
};

// A place is offset + scale * a whole number of 16 bits, axis by axis.
struct GlbLattice {
    std::array<double, 3> offset{}, scale{1, 1, 1};
    static constexpr int most = 65535;
    // Where axes scale so differently, most directions lie close to one axis: 16 bits are half a degree off, and beyond
    // this directions are floats.
    static constexpr double most_different = 1024;
    [[nodiscard]] double nearest(double place, std::size_t axis) const;
};

// Indices of textures (Glb::add_texture()); -1: there is none.
struct GlbTextures {
    int colour = -1, normal = -1, occlusion = -1;
};

// Places are relative to origin, which is the node's, in double. What the functions and the span refer to must live
// until the file is written.
struct GlbMesh {
    std::string name; // of node, mesh and material
    std::size_t vertices = 0;
    std::span<const std::uint32_t> indices; // three for each triangle
    std::function<std::array<double, 3>(std::size_t vertex)> place{};
    std::function<std::array<double, 3>(std::size_t vertex)> normal{};  // unit; empty: there are none
    std::function<std::array<double, 4>(std::size_t vertex)> tangent{}; // unit, and the sign of the third axis
    std::function<std::array<double, 2>(std::size_t vertex)> uv{};      // 0 to 1; with a texture alone
    GlbTextures textures{};                                             // without colour: grey
    std::array<double, 3> origin{};
    std::optional<GlbLattice> lattice{}; // for places; all of them must fit
};

// What is compressed is in memory until glb is written.
void add_glb_mesh(Glb& glb, GlbMesh mesh, bool meshopt);

} // namespace fjell::gltf
FJELL_API_END
