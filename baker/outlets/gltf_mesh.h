// A mesh as a node of a glTF file: float or on a lattice of 16 bits (KHR_mesh_quantization), plain or compressed
// (EXT_meshopt_compression).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gltf/glb.h"

namespace fjell::baker {

struct GltfPacking {
    bool quantised = false;
    bool meshopt = false;
};

// A place is offset + scale * a whole number of 16 bits, axis by axis.
struct GltfLattice {
    std::array<double, 3> offset{}, scale{1, 1, 1};
    static constexpr int most = 65535;
    [[nodiscard]] double nearest(double place, std::size_t axis) const;
};

struct GltfMesh {
    std::string name;
    std::size_t vertices = 0;
    std::span<const std::array<std::uint32_t, 3>> triangles;
    std::function<std::array<double, 3>(std::size_t vertex)> place{};
    std::function<std::array<double, 3>(std::size_t vertex)> normal{}; // unit; empty: there are none
    std::function<std::array<double, 2>(std::size_t vertex)> uv{};     // 0 to 1; with a texture alone
    std::vector<std::byte> texture_jpeg{};                             // empty: grey
    std::optional<GltfLattice> lattice{};                              // for places; all of them must fit
};

// The mesh must live until glb is written. What is compressed is in memory until then.
void add_gltf_mesh(fjell::gltf::Glb& glb, const GltfMesh& mesh, bool meshopt);

} // namespace fjell::baker
