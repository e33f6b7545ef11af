// A pack's geometry, decoded into the host's memory: what every method and query reads.
//
// Axes everywhere in Fjell: x east, y up, z south, metres, from sample (0, 0). Raster columns run along +x, rows along
// +z. Records lie tile after tile (row-major tiles), each in planar order; a border vertex is stored in every tile that
// has it, with equal bits. 8 bytes a vertex. Ownership: Terrain points into the block. Thread: immutable after
// load_terrain, shareable.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fjell/pack.h"
#include "fjell/record.h"

namespace fjell {

struct Terrain {
    PackHeader header{};
    Tree tree;
    PlanarOrder order;
    Lattice lattice;
    float spacing_x_m = 1, spacing_z_m = 1;
    const VertexRecord* records = nullptr; // tile_count * vertices_per_tile
    std::uint32_t vertices_per_tile = 0;

    [[nodiscard]] std::uint32_t tile_count() const { return header.tiles_x * header.tiles_y; }
    [[nodiscard]] const VertexRecord* tile_records(std::uint32_t tile) const {
        return records + std::size_t{tile} * vertices_per_tile;
    }
    // Position of a sample, one fixed float expression: the baker measures radii with the very same one.
    [[nodiscard]] float x_m(std::int32_t column) const { return static_cast<float>(column) * spacing_x_m; }
    [[nodiscard]] float z_m(std::int32_t row) const { return static_cast<float>(row) * spacing_z_m; }
    // Of any vertex, also beyond the terrain's rim.
    [[nodiscard]] const VertexRecord& record(Coord vertex) const;
    [[nodiscard]] float height_m(Coord sample) const { return lattice.height_m(record(sample).height); }
    // Bilinear height of the full-resolution grid; positions outside are clamped to the rim.
    [[nodiscard]] double ground_m(double x, double z) const;
};

[[nodiscard]] std::size_t terrain_bytes(const PackHeader& header);

// Decodes every geometry chunk. block: at least terrain_bytes(), aligned to 64. O(samples).
Status load_terrain(const Pack& pack, std::span<std::byte> block, Terrain& terrain);

} // namespace fjell
