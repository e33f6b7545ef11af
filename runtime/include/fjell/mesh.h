// What a method hands to a renderer or an exporter: vertices, indices, and the ranges of indices of each tile.
//
// The indices are a triangle list or one triangle strip for each tile. A list has three indices a triangle,
// counter-clockwise seen from above. A strip has degenerate triangles where it turns, and the winding rule of OpenGL
// strips.
// Ownership: the spans point into the method's memory and are valid until its next update.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fjell/export.h"

FJELL_API_BEGIN
namespace fjell {

// A record of the vertex buffer.
struct MeshVertex {
    std::int32_t column, row; // the sample of the terrain that the vertex is
    float height_m;
};
static_assert(sizeof(MeshVertex) == 12, "MeshVertex is uploaded: change the renderer's vertex format with it");

// How indices make triangles.
enum class Topology : std::uint8_t { triangles, strip };

// A range of indices to draw. All its triangles are of one tile.
struct TileRange {
    // The tile's number, 0 to Terrain::tile_count() - 1. Terrain::tile_place() says where it is.
    std::uint32_t tile;
    std::uint32_t first_index; // into MeshView::indices
    std::uint32_t index_count;
    std::uint32_t triangles; // without degenerate ones
};

// The mesh of the last update.
struct MeshView {
    Topology topology = Topology::triangles;
    std::span<const MeshVertex> vertices; // the whole vertex buffer, with its unused slots
    std::span<const std::uint32_t> indices;
    std::span<const TileRange> tiles;
    // Vertex slots that the recursive method has written since the previous update: upload [dirty_begin, dirty_end).
    // Empty for a live cut, whose changes cut_take_changes() has.
    std::uint32_t dirty_begin = 0, dirty_end = 0;
};

} // namespace fjell
FJELL_API_END
