// Activating and deactivating one vertex, and what follows for those around it.
#pragma once

#include "cut/around.h"

namespace fjell {

// gated: a page that is evicted is in the way; rising: a vertex that morphs, until Morphing::arrives_ticks.
enum class Outcome : std::uint8_t { done, no_vertices, no_triangles, no_pages, gated, rising };

// The vertex must be ready and not active. Evaluates the children that become ready. around: it, as find_around() found
// it since pages last lost their states.
Outcome activate(CutState& s, std::uint32_t vertex, const Around& around);
// The vertex must be active and without active children. Evaluates the parents that become childless. Fails, changing
// nothing, only when triangles that were hidden need a segment and none is left.
Outcome deactivate(Pages& pages, Work& work, Mesh& mesh, const Views& views, std::uint32_t vertex,
                   const Around& around);
inline Outcome deactivate(Pages& pages, Work& work, Mesh& mesh, const Views& views, std::uint32_t vertex) {
    return deactivate(pages, work, mesh, views, vertex, find_around(pages, vertex));
}

} // namespace fjell
