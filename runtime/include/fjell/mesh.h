// What a method hands to a renderer or an exporter: vertices, indices and the ranges of each tile.
//
// Indices are either an indexed triangle list (three a triangle, counter-clockwise seen from above) or one triangle
// strip a tile (with degenerate triangles where the strip turns; same winding rule as OpenGL strips).
// Ownership: spans point into the method's memory and are valid until its next update.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fjell/export.h"

FJELL_API_BEGIN
namespace fjell {

// A record of the vertex buffer.
struct MeshVertex {
    std::int32_t column, row; // sample of the terrain
    float height_m;
};
static_assert(sizeof(MeshVertex) == 12, "MeshVertex is uploaded: change the renderer's vertex format with it");

// How indices make triangles.
enum class Topology : std::uint8_t { triangles, strip };

// A range of indices to draw.
struct TileRange {             // a tile may have several
    std::uint32_t tile;        // its number: row by row, of the tiles that there are (Terrain::tile_place)
    std::uint32_t first_index; // into MeshView::indices
    std::uint32_t index_count;
    std::uint32_t triangles; // degenerate ones not counted
};

// The mesh of the last update.
struct MeshView {
    Topology topology = Topology::triangles;
    std::span<const MeshVertex> vertices; // the whole vertex buffer, used slots or not
    std::span<const std::uint32_t> indices;
    std::span<const TileRange> tiles;
    // The slots that the recursive method has written since the previous update: upload [dirty_begin, dirty_end). Of a
    // live cut it is empty: cut_take_changes() has what it has written.
    std::uint32_t dirty_begin = 0, dirty_end = 0;
};

} // namespace fjell
FJELL_API_END
