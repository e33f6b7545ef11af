// The bulk pass: the whole cut at once, from nothing, level by level.
//
// One by one an activation costs hundreds of nanoseconds, because everything it touches is somewhere else. Here a row
// of a page is a word: which vertices are ready follows from their parents' words by spreading bits, a group is
// evaluated once, and its vertices take slots in order. Triangles come last, page by page on the way down, when it is
// known which children are active; a page's corners are handed down as a grid of slots, so that no vertex is looked up.
#pragma once

#include "cut/find.h"

namespace fjell {

// The cut must be as reset() leaves it, with its decision set. Activates all that the decision wants. False when a
// capacity does not suffice, which the report then names; the cut must be reset.
[[nodiscard]] bool build_all(CutState& s);

// Its second half, for all tiles: the vertices are active, and triangle slots suffice.
void emit_triangles(CutState& s);

// The groups of one step in one page or, of coarse steps, in one tile.
struct PageStep {
    const StepGroups* step;
    std::uint32_t first;                                                     // group of the page
    std::int32_t n;                                                          // squares a side
    [[nodiscard]] std::uint32_t row(VertexKind kind, std::int32_t j) const { // j: 0..n for side_x
        const std::uint32_t plane = kind == VertexKind::centre   ? step->centres
                                    : kind == VertexKind::side_x ? step->sides_x
                                                                 : step->sides_y;
        return first + plane + (static_cast<std::uint32_t>(j) << step->words_log2);
    }
};
[[nodiscard]] inline PageStep page_step_at(const CutState& s, int z, std::int32_t i0, std::int32_t j0) {
    const StepGroups& step = s.steps[z];
    return {&step, find_vertex(s, {z, VertexKind::centre, i0, j0}) / group_lanes - step.centres, 1 << step.page_log2};
}

// How many vertices are active in the page of a square; 0 where there is none.
[[nodiscard]] inline std::uint32_t active_in_page_of(const CutState& s, const Site& centre) {
    if (!exists(s, centre)) return 0;
    const std::uint32_t vertex = find_vertex(s, centre);
    return vertex == no_index ? 0 : s.page_slot[vertex / group_lanes / max_page_groups].active;
}

} // namespace fjell
