// One tile of the mesh as glTF wants it: its own vertices, and indices that reach them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "fjell/mesh.h"
#include "fjell/sample_index.h"
#include "fjell/terrain.h"
#include "fjell/view.h"

namespace fjell::gltf {

struct SnapshotVertex {
    float position_m[3]; // from the tile's corner with the smallest coordinates; y is the height itself
    float normal[3];
    float cells[2];   // from that corner
    float tangent[4]; // tangent_of() the normal
};
// Blocks of a tile's normal map that moving ground has changed (fjell/ground_maps.h), of one mip.
struct MovedNormals {
    std::uint32_t mip = 0;
    std::uint32_t x = 0, y = 0, columns = 0, rows = 0; // texels, whole blocks
    std::vector<std::byte> blocks;
};
// Writes them over the mip's blocks as the pack has them. side_px: of the mip.
void put_over(const MovedNormals& moved, std::uint32_t side_px, std::span<std::byte> blocks);

struct TileGeometry {
    std::uint32_t tile = 0;
    std::vector<MovedNormals> moved;
    std::vector<SnapshotVertex> vertices;
    std::vector<std::uint32_t> indices; // a triangle list, counter-clockwise from above, none degenerate
    float low_m[3], high_m[3];          // exact bounds of position_m
};

// The corner of a tile in the scene: whole multiples of the tile's width as a float, see fjell/gltf/snapshot.h.
[[nodiscard]] Vec3 tile_corner_m(const Pack& pack, std::uint32_t tile);

// Collects tiles one after the other; its table is one entry a sample of a tile.
class TileCollector {
public:
    explicit TileCollector(const Terrain& terrain);

    // All ranges of one tile. drawn_m: the heights of the mesh' vertices, one for one; empty: those that they have.
    // Throws io::Failure when an index or a vertex lies outside what the mesh or the tile holds.
    [[nodiscard]] TileGeometry collect(const MeshView& mesh, std::span<const TileRange> ranges,
                                       std::span<const float> drawn_m);

private:
    void add(TileGeometry& geometry, const MeshView& mesh, const TileRange& range, std::span<const float> drawn_m);
    [[nodiscard]] std::uint32_t slot(TileGeometry& geometry, const MeshVertex& vertex);
    [[nodiscard]] SampleIndex in_tile_of(std::uint32_t tile, const MeshVertex& vertex) const;
    [[nodiscard]] bool in_tile(std::uint32_t tile, const MeshVertex& vertex) const;
    [[nodiscard]] std::size_t place(std::uint32_t tile, const MeshVertex& vertex) const; // in slots
    [[nodiscard]] SnapshotVertex make_vertex(std::uint32_t tile, const MeshVertex& vertex) const;

    const Terrain& terrain;
    std::uint32_t side;
    std::vector<std::uint32_t> slots; // of each sample of the current tile, or none
};

} // namespace fjell::gltf
