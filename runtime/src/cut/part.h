// The groups of one step in one page: what the bulk pass works on.
#pragma once

#include "cut/find.h"

namespace fjell {

// The groups of one step in one page or, of coarse steps, in one tile.
struct Part {
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
[[nodiscard]] inline Part part_at(const CutState& s, int z, std::int32_t i0, std::int32_t j0) {
    const StepGroups& step = s.steps[z];
    return {&step, find_vertex(s, {z, VertexKind::centre, i0, j0}) / group_lanes - step.centres, 1 << step.page_log2};
}

// How many vertices are active in the page of a square; 0 where there is none.
[[nodiscard]] inline std::uint32_t active_at(const CutState& s, const Site& centre) {
    if (!exists(s, centre)) return 0;
    const std::uint32_t vertex = find_vertex(s, centre);
    return vertex == no_index ? 0 : s.page_slot[vertex / group_lanes / max_page_groups].active;
}

} // namespace fjell
