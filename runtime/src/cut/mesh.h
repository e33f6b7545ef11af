// The mesh of the live cut, edited in place: the thesis' vertex buffer and status array, made incremental.
//
// A triangle's key is the vertex at its right angle and a direction: the child of that vertex on its hypotenuse
//. Activating a vertex replaces the triangle towards it, of each of its parents, by two of its own;
// deactivating it does the reverse. Neither needs more than the parents' vertex slots, because a triangle's indices
// hold its other corners.
//
// Triangles of a tile fill segments of slots without gaps: a removed one is overwritten by the tile's last. So every
// segment is one draw range, nothing degenerate is drawn, and one change touches at most six triangle slots. Triangles
// that are not drawn - with a corner in a hole, or shrunk to nothing beyond the terrain's rim - are kept the same way,
// as those of one more tile.
#pragma once

#include "cut/state.h"

namespace fjell {

struct MeshTriangle {
    std::uint32_t right, a, b; // vertex slots, counter-clockwise from above; a-b is the hypotenuse
};

[[nodiscard]] inline std::uint32_t hidden_tile(const Mesh& mesh) {
    return mesh.tile_count;
}

[[nodiscard]] inline bool is_hidden(const Mesh& mesh, const MeshTriangle& t) {
    if ((mesh.hole[t.right] | mesh.hole[t.a] | mesh.hole[t.b]) & hole_bit) return true;
    const MeshVertex &p = mesh.vertices[t.right], &a = mesh.vertices[t.a], &b = mesh.vertices[t.b];
    return std::int64_t{a.column - p.column} * (b.row - p.row) == std::int64_t{a.row - p.row} * (b.column - p.column);
}
[[nodiscard]] inline std::uint32_t list_for(const Mesh& mesh, std::uint32_t tile, const MeshTriangle& t) {
    return mesh.some_hidden && is_hidden(mesh, t) ? hidden_tile(mesh) : tile;
}

inline void put_corners(Mesh& mesh, std::uint32_t slot, const MeshTriangle& t) {
    std::uint32_t* const out = mesh.indices + std::size_t{slot} * 3;
    out[0] = t.right, out[1] = t.a, out[2] = t.b;
}
inline void put_triangle(Mesh& mesh, std::uint32_t slot, const MeshTriangle& t, std::uint32_t key) {
    put_corners(mesh, slot, t);
    mesh.triangle_of[key] = slot;
}
// The key of the triangle in a slot: it is the one of its right angle's that leads there.
[[nodiscard]] inline std::uint32_t key_of(const Mesh& mesh, std::uint32_t slot) {
    std::uint32_t key = mesh.indices[std::size_t{slot} * 3] * 4;
    while (mesh.triangle_of[key] != slot) ++key;
    return key;
}
inline void write_triangle(Mesh& mesh, std::uint32_t slot, const MeshTriangle& t, std::uint32_t key) {
    put_triangle(mesh, slot, t, key);
    mesh.dirty_triangles.mark(slot);
}

// No triangle stays: the first segments are the next that are taken.
inline void free_all_segments(Mesh& mesh) {
    for (std::uint32_t i = 0; i <= mesh.tile_count; ++i) static_cast<TileStack&>(mesh.tiles[i]) = {no_index, 0, 0, 0};
    mesh.free_segment_count = mesh.segment_count;
    for (std::uint32_t i = 0; i < mesh.segment_count; ++i) mesh.free_segments[i] = mesh.segment_count - 1 - i;
}

// Slots that a tile can still take without a new segment.
[[nodiscard]] inline std::uint32_t room_in(const Mesh& mesh, std::uint32_t tile) {
    const TileList& list = mesh.tiles[tile];
    return list.last_segment == no_index ? 0 : (1u << mesh.segment_log2) - list.in_last;
}

[[nodiscard]] inline bool needs_segment(const Mesh& mesh, const TileStack& list) {
    return list.last_segment == no_index || list.in_last == 1u << mesh.segment_log2;
}
inline void push_segment(Mesh& mesh, TileStack& list, std::uint32_t tile, std::uint32_t segment) {
    mesh.segment_below[segment] = list.last_segment;
    mesh.segment_tile[segment] = tile;
    list.last_segment = segment;
    list.in_last = 0;
    ++list.segments;
}
inline void note_segments(Mesh& mesh) {
    mesh.segment_peak = std::max(mesh.segment_peak, mesh.segment_count - mesh.free_segment_count);
}
// The next slot of a tile's list. There must be room: in its last segment or a free one.
inline std::uint32_t take_triangle(Mesh& mesh, TileStack& list, std::uint32_t tile) {
    if (needs_segment(mesh, list)) {
        FJELL_ASSERT(mesh.free_segment_count != 0);
        push_segment(mesh, list, tile, mesh.free_segments[--mesh.free_segment_count]);
        note_segments(mesh);
    }
    ++list.total;
    return (list.last_segment << mesh.segment_log2) + list.in_last++;
}
inline void append_triangle(Mesh& mesh, std::uint32_t tile, const MeshTriangle& t, std::uint32_t key) {
    FJELL_ASSERT(mesh.triangle_of[key] == no_index); // or the one of that key would stay in the mesh, over this one
    write_triangle(mesh, take_triangle(mesh, mesh.tiles[tile], tile), t, key);
}

inline void remove_triangle(Mesh& mesh, std::uint32_t slot, std::uint32_t key) {
    TileList& list = mesh.tiles[mesh.segment_tile[slot >> mesh.segment_log2]];
    FJELL_ASSERT(list.in_last != 0 && mesh.triangle_of[key] == slot);
    const std::uint32_t last = (list.last_segment << mesh.segment_log2) + --list.in_last;
    --list.total;
    mesh.triangle_of[key] = no_index;
    if (last != slot) {
        const std::uint32_t* const from = mesh.indices + std::size_t{last} * 3;
        write_triangle(mesh, slot, {from[0], from[1], from[2]}, key_of(mesh, last));
    }
    if (list.in_last != 0) return;
    const std::uint32_t segment = list.last_segment;
    mesh.free_segments[mesh.free_segment_count++] = segment;
    list.last_segment = mesh.segment_below[segment];
    list.in_last = list.last_segment == no_index ? 0 : 1u << mesh.segment_log2;
    --list.segments;
}

// The triangle of this key becomes another one of the same tile, drawn or not.
inline void replace_triangle(Mesh& mesh, std::uint32_t key, std::uint32_t tile, const MeshTriangle& t,
                             std::uint32_t new_key) {
    const std::uint32_t slot = mesh.triangle_of[key];
    if (mesh.segment_tile[slot >> mesh.segment_log2] == list_for(mesh, tile, t)) {
        mesh.triangle_of[key] = no_index;
        FJELL_ASSERT(mesh.triangle_of[new_key] == no_index);
        write_triangle(mesh, slot, t, new_key);
        return;
    }
    remove_triangle(mesh, slot, key);
    append_triangle(mesh, list_for(mesh, tile, t), t, new_key);
}

} // namespace fjell
