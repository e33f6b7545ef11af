// Activating and deactivating one vertex, and what follows for those around it.
#pragma once

#include "cut/state.h"

namespace fjell {

// The vertex at a site of the tree, or no_vertex when its page is not loaded. The site must exist. Pure, O(1).
[[nodiscard]] std::uint32_t find_vertex(const CutState& s, const Site& site);
[[nodiscard]] Site site_of(const CutState& s, std::uint32_t vertex);
// Does the tree have a vertex there?
[[nodiscard]] bool exists(const CutState& s, const Site& site);

[[nodiscard]] const BlockShape& shape_of(const CutState& s, std::uint32_t block);
[[nodiscard]] VertexRecord record_of(const CutState& s, std::uint32_t vertex);

enum class Outcome : std::uint8_t { done, no_vertices, no_triangles, gated };

// The vertex must be ready and not active. Evaluates the children that become ready.
Outcome activate(CutState& s, std::uint32_t vertex);
// The vertex must be active and without active children. Evaluates the parents that become childless. Fails, changing
// nothing, only when triangles that were hidden need a chunk and none is left.
Outcome deactivate(CutState& s, std::uint32_t vertex);

// Evaluates a block and returns it to the calendar, or does what its vertices call for as far as their rank and this
// frame's items allow, and puts it in the list of what is left. The block must be in no list.
void visit_block(CutState& s, std::uint32_t block, std::uint32_t least_rank, bool may_retire);

} // namespace fjell
