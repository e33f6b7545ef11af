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

[[nodiscard]] inline std::uint32_t hidden_tile(const CutState& s) {
    return s.mesh.tile_count;
}

[[nodiscard]] inline bool is_hidden(const CutState& s, const MeshTriangle& t) {
    if ((s.mesh.hole[t.right] | s.mesh.hole[t.a] | s.mesh.hole[t.b]) & hole_bit) return true;
    const MeshVertex &p = s.mesh.vertices[t.right], &a = s.mesh.vertices[t.a], &b = s.mesh.vertices[t.b];
    return std::int64_t{a.column - p.column} * (b.row - p.row) == std::int64_t{a.row - p.row} * (b.column - p.column);
}
[[nodiscard]] inline std::uint32_t list_for(const CutState& s, std::uint32_t tile, const MeshTriangle& t) {
    return s.mesh.some_hidden && is_hidden(s, t) ? hidden_tile(s) : tile;
}

inline void put_corners(CutState& s, std::uint32_t slot, const MeshTriangle& t) {
    std::uint32_t* const out = s.mesh.indices + std::size_t{slot} * 3;
    out[0] = t.right, out[1] = t.a, out[2] = t.b;
}
inline void put_triangle(CutState& s, std::uint32_t slot, const MeshTriangle& t, std::uint32_t key) {
    put_corners(s, slot, t);
    s.mesh.triangle_of[key] = slot;
}
// The key of the triangle in a slot: it is the one of its right angle's that leads there.
[[nodiscard]] inline std::uint32_t key_of(const CutState& s, std::uint32_t slot) {
    std::uint32_t key = s.mesh.indices[std::size_t{slot} * 3] * 4;
    while (s.mesh.triangle_of[key] != slot) ++key;
    return key;
}
inline void write_triangle(CutState& s, std::uint32_t slot, const MeshTriangle& t, std::uint32_t key) {
    put_triangle(s, slot, t, key);
    s.mesh.dirty_triangles.mark(slot);
}

// No triangle stays: the first segments are the next that are taken.
inline void free_all_segments(CutState& s) {
    for (std::uint32_t i = 0; i <= s.mesh.tile_count; ++i)
        static_cast<TileStack&>(s.mesh.tiles[i]) = {no_index, 0, 0, 0};
    s.mesh.free_segment_count = s.mesh.segment_count;
    for (std::uint32_t i = 0; i < s.mesh.segment_count; ++i) s.mesh.free_segments[i] = s.mesh.segment_count - 1 - i;
}

// Slots that a tile can still take without a new segment.
[[nodiscard]] inline std::uint32_t room_in(const CutState& s, std::uint32_t tile) {
    const TileList& list = s.mesh.tiles[tile];
    return list.last_segment == no_index ? 0 : (1u << s.mesh.segment_log2) - list.in_last;
}

[[nodiscard]] inline bool needs_segment(const CutState& s, const TileStack& list) {
    return list.last_segment == no_index || list.in_last == 1u << s.mesh.segment_log2;
}
inline void push_segment(CutState& s, TileStack& list, std::uint32_t tile, std::uint32_t segment) {
    s.mesh.segment_below[segment] = list.last_segment;
    s.mesh.segment_tile[segment] = tile;
    list.last_segment = segment;
    list.in_last = 0;
    ++list.segments;
}
inline void note_segments(CutState& s) {
    s.mesh.segment_peak = std::max(s.mesh.segment_peak, s.mesh.segment_count - s.mesh.free_segment_count);
}
// The next slot of a tile's list. There must be room: in its last segment or a free one.
inline std::uint32_t take_triangle(CutState& s, TileStack& list, std::uint32_t tile) {
    if (needs_segment(s, list)) {
        FJELL_ASSERT(s.mesh.free_segment_count != 0);
        push_segment(s, list, tile, s.mesh.free_segments[--s.mesh.free_segment_count]);
        note_segments(s);
    }
    ++list.total;
    return (list.last_segment << s.mesh.segment_log2) + list.in_last++;
}
inline void append_triangle(CutState& s, std::uint32_t tile, const MeshTriangle& t, std::uint32_t key) {
    FJELL_ASSERT(s.mesh.triangle_of[key] == no_index); // or the one of that key would stay in the mesh, over this one
    write_triangle(s, take_triangle(s, s.mesh.tiles[tile], tile), t, key);
}

inline void remove_triangle(CutState& s, std::uint32_t slot, std::uint32_t key) {
    TileList& list = s.mesh.tiles[s.mesh.segment_tile[slot >> s.mesh.segment_log2]];
    FJELL_ASSERT(list.in_last != 0 && s.mesh.triangle_of[key] == slot);
    const std::uint32_t last = (list.last_segment << s.mesh.segment_log2) + --list.in_last;
    --list.total;
    s.mesh.triangle_of[key] = no_index;
    if (last != slot) {
        const std::uint32_t* const from = s.mesh.indices + std::size_t{last} * 3;
        write_triangle(s, slot, {from[0], from[1], from[2]}, key_of(s, last));
    }
    if (list.in_last != 0) return;
    const std::uint32_t segment = list.last_segment;
    s.mesh.free_segments[s.mesh.free_segment_count++] = segment;
    list.last_segment = s.mesh.segment_below[segment];
    list.in_last = list.last_segment == no_index ? 0 : 1u << s.mesh.segment_log2;
    --list.segments;
}

// The triangle of this key becomes another one of the same tile, drawn or not.
inline void replace_triangle(CutState& s, std::uint32_t key, std::uint32_t tile, const MeshTriangle& t,
                             std::uint32_t new_key) {
    const std::uint32_t slot = s.mesh.triangle_of[key];
    if (s.mesh.segment_tile[slot >> s.mesh.segment_log2] == list_for(s, tile, t)) {
        s.mesh.triangle_of[key] = no_index;
        FJELL_ASSERT(s.mesh.triangle_of[new_key] == no_index);
        write_triangle(s, slot, t, new_key);
        return;
    }
    remove_triangle(s, slot, key);
    append_triangle(s, list_for(s, tile, t), t, new_key);
}

} // namespace fjell
