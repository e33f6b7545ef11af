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

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "asserts.h"
#include "fjell/cut.h"
#include "shared/terrain_data.h"

namespace fjell {

// A stack of segments: a tile's triangles.
struct TileStack {
    std::uint32_t last_segment; // no_index: none
    std::uint32_t in_last;
    std::uint32_t total;
    std::uint32_t segments;
};

// A tile's triangles: all segments but the last are full.
struct TileList : TileStack {
    bool bounded; // by the root's sphere; not while page 0 is missing
    Vec3 centre_m;
    double radius_m;
};

struct DirtyBits {
    std::uint64_t* bits;
    std::uint32_t* words; // which hold any
    std::uint32_t word_count;
    std::uint32_t slots; // marked

    void mark(std::uint32_t slot) {
        std::uint64_t& word = bits[slot / 64];
        const std::uint64_t bit = std::uint64_t{1} << (slot % 64);
        if (word == 0) words[word_count++] = slot / 64;
        slots += (word & bit) == 0;
        word |= bit;
    }
    void mark_range(std::uint32_t first, std::uint32_t end) {
        for (; first < end && (first % 64 != 0 || end - first < 64); ++first) mark(first);
        for (; end - first >= 64; first += 64) {
            if (bits[first / 64] != 0) {
                for (std::uint32_t slot = first; slot < first + 64; ++slot) mark(slot);
                continue;
            }
            bits[first / 64] = ~std::uint64_t{0};
            words[word_count++] = first / 64;
            slots += 64;
        }
        for (; first < end; ++first) mark(first);
    }
    void clear() {
        for (std::uint32_t i = 0; i < word_count; ++i) bits[words[i]] = 0;
        word_count = slots = 0;
    }
    void move_to(DirtyBits& other) { // other.slots is not kept up to date
        for (std::uint32_t i = 0; i < word_count; ++i) {
            const std::uint32_t word = words[i];
            FJELL_ASSERT(bits[word] != 0); // or it was listed before, and would be listed there for good
            if (other.bits[word] == 0) other.words[other.word_count++] = word;
            other.bits[word] |= std::exchange(bits[word], 0);
        }
        word_count = slots = 0;
    }
};

// Of Mesh::hole.
inline constexpr std::uint8_t hole_bit = 1, morphs_out_bit = 2;

struct Mesh {
    // Vertex slots. The corners of all tiles have the first.
    std::uint32_t capacity, corner_count;
    MeshVertex* vertices;
    MorphVertex* morph;           // null: CutBudget::morph is false
    std::uint32_t* triangle_of;   // by key: its slot, or no_index
    std::uint8_t* hole;           // 1 a vertex slot: hole_bit, morphs_out_bit
    std::uint32_t* free_vertices; // a stack of given-back slots; those from fresh_vertex on were never taken
    std::uint32_t free_vertex_count, fresh_vertex, vertex_peak;
    std::uint32_t mapped; // entries of that stack that say what the bulk pass took, while the state follows
    // Triangle slots, in segments.
    std::uint32_t* indices; // 3 a triangle slot: right angle first
    TileList* tiles;        // tile_count, and one more: triangles that are not drawn
    std::uint32_t tile_count;
    std::uint32_t* segment_tile;
    std::uint32_t* segment_below; // the tile's segment before it
    std::uint32_t* free_segments;
    std::uint32_t free_segment_count, segment_count, segment_peak;
    std::uint32_t segment_log2;
    bool some_hidden; // the terrain has holes or ends inside tiles
    TileRange* ranges;
    std::uint32_t range_count;
    // What has changed.
    DirtyBits dirty_vertices, dirty_triangles;     // slots written by this update
    DirtyBits untaken_vertices, untaken_triangles; // and by those before, when the host had not taken them
    bool dirty_taken, untaken_taken;               // by cut_take_changes()
};

// --- vertex slots

[[nodiscard]] inline std::uint32_t free_vertices(const Mesh& mesh) {
    return mesh.free_vertex_count - mesh.mapped + mesh.capacity - mesh.fresh_vertex;
}
[[nodiscard]] inline std::uint32_t take_vertex(Mesh& mesh) {
    FJELL_ASSERT(free_vertices(mesh) != 0);
    const std::uint32_t slot =
        mesh.free_vertex_count != 0 ? mesh.free_vertices[--mesh.free_vertex_count] : mesh.fresh_vertex++;
    FJELL_ASSERT(slot >= mesh.corner_count && slot < mesh.fresh_vertex);
    for (std::uint32_t d = 0; d < 4; ++d)
        mesh.triangle_of[slot * 4 + d] = no_index; // whoever had the slot is forgotten
    return slot;
}
inline void give_vertex(Mesh& mesh, std::uint32_t slot) {
    FJELL_ASSERT(slot >= mesh.corner_count && slot < mesh.fresh_vertex);
    FJELL_ASSERT(mesh.free_vertex_count < mesh.fresh_vertex - mesh.corner_count); // or one was given back twice
    mesh.free_vertices[mesh.free_vertex_count++] = slot;
}

// --- triangles

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
