// The blocks of one step in one page: what the bulk pass works on.
#pragma once

#include "cut/find.h"

namespace fjell {

// The blocks of one step in one page or, of coarse steps, in one tile.
struct Part {
    const StepBlocks* step;
    std::uint32_t first;                                                    // block of the page
    std::int32_t n;                                                         // squares a side
    [[nodiscard]] std::uint32_t row(PlaneKind kind, std::int32_t j) const { // j: 0..n for side_x
        const std::uint32_t plane = kind == PlaneKind::centre   ? step->centres
                                    : kind == PlaneKind::side_x ? step->sides_x
                                                                : step->sides_y;
        return first + plane + (static_cast<std::uint32_t>(j) << step->words_log2);
    }
};
[[nodiscard]] inline Part part_at(const CutState& s, int z, std::int32_t i0, std::int32_t j0) {
    const StepBlocks& step = s.steps[z];
    return {&step, find_vertex(s, {z, PlaneKind::centre, i0, j0}) / block_lanes - step.centres, 1 << step.page_log2};
}

// How many vertices are active in the page of a square; 0 where there is none.
[[nodiscard]] inline std::uint32_t active_at(const CutState& s, const Site& centre) {
    if (!exists(s, centre)) return 0;
    const std::uint32_t vertex = find_vertex(s, centre);
    return vertex == no_vertex ? 0 : s.slot_info[vertex / block_lanes / max_page_blocks].active;
}

} // namespace fjell
