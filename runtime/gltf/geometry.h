// One tile of the mesh as glTF wants it: its own vertices, interleaved, and the smallest indices that reach them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "fjell/coord.h"
#include "fjell/mesh.h"
#include "fjell/terrain.h"

namespace fjell::gltf {

struct SnapshotVertex {
    float position_m[3]; // from the tile's corner with the smallest coordinates; y is the height itself
    float normal[3];
    float uv[2];
};
static_assert(sizeof(SnapshotVertex) == 32 && offsetof(SnapshotVertex, uv) == 24,
              "SnapshotVertex is stored: change the accessors in scene.cpp with it");

struct TileGeometry {
    std::vector<SnapshotVertex> vertices;
    std::vector<std::uint32_t> indices; // a triangle list, counter-clockwise from above, none degenerate
    float low_m[3], high_m[3];          // exact bounds of position_m
};

// Collects tiles one after the other; its table is one entry a sample of a tile.
class TileCollector {
public:
    // texture_px: texels a side of the tile's texture, whose first and last texel centres lie on its border.
    TileCollector(const Terrain& terrain, std::uint32_t texture_px);

    // Throws io::Failure when an index or a vertex lies outside what the mesh or the tile holds.
    [[nodiscard]] TileGeometry collect(const MeshView& mesh, const TileRange& range);

    // The corner of a tile in the scene: whole multiples of the tile's width as a float, see fjell/gltf/snapshot.h.
    [[nodiscard]] double tile_x_m(std::uint32_t tile) const;
    [[nodiscard]] double tile_z_m(std::uint32_t tile) const;

private:
    [[nodiscard]] std::uint32_t slot(TileGeometry& geometry, std::uint32_t tile, const MeshVertex& vertex);
    [[nodiscard]] Coord in_tile_of(std::uint32_t tile, const MeshVertex& vertex) const;
    [[nodiscard]] bool in_tile(std::uint32_t tile, const MeshVertex& vertex) const;
    [[nodiscard]] std::size_t place(std::uint32_t tile, const MeshVertex& vertex) const; // in slots
    [[nodiscard]] SnapshotVertex make_vertex(std::uint32_t tile, const MeshVertex& vertex) const;

    const Terrain& terrain;
    std::uint32_t side;
    double uv_first, uv_step;
    std::vector<std::uint32_t> slots; // of each sample of the current tile, or none
};

} // namespace fjell::gltf
