// Vertices of pages that are asked back go as they came: down to the edge that they split, in morph_s.
#pragma once

#include "cut/morph.h"

namespace fjell {

[[nodiscard]] inline bool sinks(const CutState& s, std::uint32_t slot) {
    return (s.hole[slot] & sinks_bit) != 0;
}

// The vertex is active, has no active children and does not sink yet. To the shader a vertex that sinks is one that
// rises from where it stands to the edge, whatever the distance: only its numbers change.
inline void begin_sinking(CutState& s, std::uint32_t vertex) {
    const std::uint32_t slot = s.slots[vertex];
    MeshVertex& v = s.vertices[slot];
    MorphVertex& m = s.morph[slot];
    const float edge_m = m.flat_m;
    m.flat_m = morphed_height_m(*s.terrain, v, m, s.morph_now);
    v.height_m = edge_m;
    m.error_m = 1e30f; // has risen at any distance
    m.radius_m = 0;
    m.born_s = s.morph_now.now_s;
    s.hole[slot] |= sinks_bit;
    s.dirty_vertices.mark(slot);
    s.sinking[(s.first_sinking + s.sinking_count++) % s.budget.vertices] = vertex;
}

} // namespace fjell
