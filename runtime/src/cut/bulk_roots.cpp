// The roots of all tiles. A large terrain has hundreds, most of which nobody wants: those are decided side by side, and
// of a page 0 that has nothing else the pass writes no more than when to look again.
#include <algorithm>

#include "compiler.h"
#include "cut/bulk.h"
#include "cut/evaluate.h"
#include "cut/sight.h"

namespace fjell {

namespace {

constexpr std::uint32_t tiles_a_step = 64;

// The root's group is the first of page 0; no_index: that has no state.
std::uint32_t root_group(const Pages& pages, std::uint32_t tile) {
    return pages.page_groups[tile * pages.grid.pages_per_tile];
}

bool decide_root(CutState& s, std::uint32_t tile, std::uint32_t group) {
    const std::uint32_t vertex = group * group_lanes, slot = group / max_page_groups;
    // What keeps a vertex that is active lets it stay for longer than this slack says.
    const Evaluation v = evaluate_vertex(s.pages, s.views, vertex, site_of(s.pages, vertex), false);
    const auto ticks_a_metre = static_cast<float>(1 / tick_m(s.work.schedule, s.work.schedule.pages[slot]));
    const auto ticks = static_cast<std::uint16_t>(std::min(v.slack_m * ticks_a_metre, float{most_ticks}));
    s.bulk.tiles[tile].root = {static_cast<std::uint16_t>(soon + ticks),
                               static_cast<std::uint8_t>(grade_of(v.code) + 1)};
    ++s.frame.report.evaluations;
    return v.wanted;
}

} // namespace

bool step_roots(CutState& s) {
    BulkPass& b = s.bulk;
    const std::uint32_t first = b.at, end = std::min(first + tiles_a_step, s.mesh.tile_count);
    for (std::uint32_t tile = first; tile != end; ++tile)
        if (const std::uint32_t group = root_group(s.pages, tile); group != no_index) {
            FJELL_PREFETCH(records_of(s.pages, group / max_page_groups));
            FJELL_PREFETCH(s.pages.groups + group);
        }
    for (; b.at != end; ++b.at) {
        b.tiles[b.at].root = {unscheduled, 0};
        const std::uint32_t group = root_group(s.pages, b.at), slot = group / max_page_groups;
        if (group == no_index) continue;
        const PageState& page = s.pages.state[slot];
        if (b.beside) watch_visited_page(s.pages, s.work, s.visibility, slot);
        const bool evicting = page.status == PageStatus::evicting, wanted = !evicting && decide_root(s, b.at, group);
        if (evicting && b.beside) b.tiles[b.at].root = {spent, 1}; // it may be kept after all, so it waits
        if (wanted || !is_clear(page)) (void)visit_page(s.pages, s.work, s.bulk, s.visibility, slot);
        if (!wanted) continue;
        BulkPage& found = b.pages[slot];
        found.active[0] = 1;
        ++found.wanted;
        ++b.taken;
        b.listed[1][b.listed_count[1]++] = slot;
    }
    return end != s.mesh.tile_count;
}

bool step_install_roots(Pages& pages, Work& work, BulkPass& b, const Mesh& mesh) {
    const std::uint32_t first = b.at, end = std::min(first + tiles_a_step, mesh.tile_count);
    for (; b.at != end; ++b.at) {
        const std::uint32_t group = root_group(pages, b.at), slot = group / max_page_groups;
        if (group == no_index || found_in(b, slot) != nullptr) continue;
        pages.groups[group].queue = unqueued; // it may have waited
        const BulkRoot& root = b.tiles[b.at].root;
        if (root.grades != 0)
            restart_group(work.schedule, slot, 0, root.ticks, root.grades - 1u, b.travelled_m);
        else
            clear_page_schedule(work.schedule, slot);
    }
    return end != mesh.tile_count;
}

} // namespace fjell
