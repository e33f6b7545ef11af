// Pages of the terrain that the cut has a state of, and the masks of their groups; from places in the tree to vertices
// of the cut, and back.
#pragma once

#include <algorithm>
#include <cstdint>

#include "cut/groups.h"
#include "cut/schedule.h"
#include "shared/terrain_data.h"

namespace fjell {

struct CutState;
struct Frame;
struct Mesh;
struct Morphing;
struct Views;
struct Visibility;

// One group: a bit a lane in every mask. 16 bytes, so that a visit costs a quarter of a cache line beside the records.
// When it is due, the schedule says.
struct GroupState {
    std::uint16_t active;
    std::uint16_t parent[2]; // that parent is active, or does not exist because it would lie outside the terrain
    std::uint16_t child[4];  // that child is active; where it is not, an active vertex draws a triangle towards it
    QueueId queue;           // that the group waits in, or unqueued

    [[nodiscard]] std::uint16_t ready() const { return static_cast<std::uint16_t>(parent[0] & parent[1]); }
    [[nodiscard]] std::uint16_t parental() const {
        return static_cast<std::uint16_t>(child[0] | child[1] | child[2] | child[3]);
    }
};
static_assert(sizeof(GroupState) == 16, "four groups a cache line");

// What a page's vertices stand within, and the largest of their errors and spheres: what it could hide.
struct PageExtent {
    float low_m, high_m, error_m, radius_m;
};

// What a page slot of the terrain holds, as far as the cut knows.
struct LoadedPage {
    std::uint32_t page;  // tile * pages_per_tile + page, or no_index
    std::uint32_t loads; // TerrainData::slot_loads when the cut entered it
    bool evicting;
    PageExtent extent;
};

enum class PageStatus : std::uint8_t { empty, live, evicting };

// The state of a page: of every tile's page 0, and of those where a vertex has an active parent. No other can have
// anything to do, so the pool follows what is active, not what is loaded. A page's state is named by its place in the
// pool, and keeps it until it is idle and another page needs it.
struct alignas(64) PageState {  // a cache line
    std::uint32_t page;         // tile * pages_per_tile + page, or no_index
    std::uint32_t terrain_slot; // where its records are
    std::uint32_t tile;
    std::int32_t i0, j0; // the page's first square in its tile; page 0: 0
    std::int32_t tile_x, tile_y;
    std::int32_t x0, y0;   // its first square's corner, in samples of the terrain
    std::int32_t base;     // height scale steps
    std::uint32_t parents; // active ones, counted once for each vertex that has them; 0: the page is idle
    std::uint16_t active;  // vertices
    std::uint8_t z;        // log2 of the step; page 0: 0, its groups say
    std::uint8_t shape;    // 0: page 0; 1: any other
    PageStatus status;
    bool idle;              // listed among idle_pages: stays when the page leaves
    std::uint8_t offscreen; // parts that no view sees, nor soon will (visibility.h)
    bool used;              // something was active since its groups were last written: any of them may be queued
};
static_assert(sizeof(PageState) == 64);

// The geometry of groups, the same for as long as the cut lives.
struct Grid {
    Terrain handle;
    const TerrainData* terrain; // its data
    std::uint32_t pages_per_tile;
    std::int32_t tiles_x, tiles_y;
    StepGroups steps[max_tile_log2];
    PageShape shapes[2];      // [0] of page 0, [1] of all others
    std::uint16_t* hz_places; // hierarchical Z-order: place of each group's lanes, for both shapes; else nullptr
    float level_unit_m[2 * max_tile_log2]; // of radii: centres at 2 z, sides at 2 z + 1
};

// The pool of page states, and the masks of their groups.
struct Pages {
    Grid grid;
    GroupState* groups;
    std::uint32_t* vertex_slot; // vertex slot of each active vertex
    std::uint32_t* page_groups; // first group of each page, or no_index: no state
    LoadedPage* loaded;         // one a page slot of the terrain
    std::uint64_t seen_changes;
    std::uint64_t seen_ground, seen_bases; // of TerrainData::ground_changes
    PageState* state;
    std::uint32_t count, group_count; // the pool's size
    std::uint32_t* free;              // a stack of given-back states; those from fresh on were never taken
    std::uint32_t free_count, fresh;
    std::uint32_t* idle; // a ring: those that became idle first; some of them are no longer
    std::uint32_t first_idle, idle_count;
    std::uint32_t tiles_waiting; // for their pages 0, which shall have one
    bool some_wait;              // a page was loaded, and had none to be had
    std::uint32_t busy;          // that are not idle
    std::uint32_t* evicting;     // states of pages that are being evicted
    std::uint32_t evicting_count;
};

// --- places

// Does the terrain have a square of the step there? Not beyond its rim, nor where a tile is missing: that is a rim too.
[[nodiscard]] inline bool has_square(const Grid& grid, int z, std::int32_t i, std::int32_t j) {
    const std::int32_t log2 = grid.steps[z].log2;
    if (i < 0 || j < 0 || i >= grid.tiles_x << log2 || j >= grid.tiles_y << log2) return false;
    return grid.terrain->has_tile(i >> log2, j >> log2);
}

// Does the tree have a vertex there?
[[nodiscard]] inline bool exists(const Grid& grid, const Site& v) {
    if (v.z < 0 || v.i < 0 || v.j < 0) return false;
    const std::int32_t nx = grid.tiles_x << grid.steps[v.z].log2, ny = grid.tiles_y << grid.steps[v.z].log2;
    if (v.i >= nx + (v.kind == VertexKind::side_y) || v.j >= ny + (v.kind == VertexKind::side_x)) return false;
    if (!grid.terrain->is_sparse()) return true;
    const bool other = (v.kind == VertexKind::side_x && has_square(grid, v.z, v.i, v.j - 1)) ||
                       (v.kind == VertexKind::side_y && has_square(grid, v.z, v.i - 1, v.j));
    return other || has_square(grid, v.z, v.i, v.j);
}

// Where a site of the tree lies: its page, and its vertex in that.
struct VertexPlace {
    std::uint32_t page, vertex;
};
// The site must exist.
[[nodiscard]] inline VertexPlace place_of(const Grid& grid, const Site& v) {
    const StepGroups& step = grid.steps[v.z];
    // A border belongs to the tile and the page to its south or east; the terrain's rim to those it ends.
    std::int32_t tile_x = v.i >> step.log2, tile_y = v.j >> step.log2;
    tile_x -= tile_x == grid.tiles_x;
    tile_y -= tile_y == grid.tiles_y;
    if (grid.terrain->is_sparse() && !grid.terrain->has_tile(tile_x, tile_y)) { // so does the rim of a missing tile
        tile_x -= v.kind == VertexKind::side_y;
        tile_y -= v.kind == VertexKind::side_x;
    }
    auto i = static_cast<std::uint32_t>(v.i - (tile_x << step.log2)),
         j = static_cast<std::uint32_t>(v.j - (tile_y << step.log2));
    std::uint32_t page = grid.terrain->tile_at(tile_x, tile_y) * grid.pages_per_tile;
    if (step.log2 >= page_squares_log2) {
        const std::uint32_t last = (1u << (step.log2 - page_squares_log2)) - 1;
        const std::uint32_t px = std::min(i >> page_squares_log2, last), py = std::min(j >> page_squares_log2, last);
        page += step.first_page + (grid.hz_places ? interleave(px, py) : py * (last + 1) + px);
        i -= px << page_squares_log2;
        j -= py << page_squares_log2;
    }
    const std::uint32_t n = 1u << step.page_log2;
    const std::uint32_t row = (j << step.words_log2) + (i >> lanes_log2);
    switch (v.kind) {
    case VertexKind::centre: return {page, (step.centres + row) * group_lanes + i % group_lanes};
    case VertexKind::side_x: return {page, (step.sides_x + row) * group_lanes + i % group_lanes};
    case VertexKind::side_y: break;
    }
    if (i == n) return {page, (step.column + (j >> lanes_log2)) * group_lanes + j % group_lanes};
    return {page, (step.sides_y + row) * group_lanes + i % group_lanes};
}

// The vertex at a site, or no_index when its page has no state: it is not loaded, or none of its vertices has an active
// parent.
[[nodiscard]] inline std::uint32_t find_vertex(const Pages& pages, const Site& v) {
    const VertexPlace at = place_of(pages.grid, v);
    const std::uint32_t first = pages.page_groups[at.page];
    return first == no_index ? no_index : first * group_lanes + at.vertex;
}

[[nodiscard]] inline bool is_active(const Pages& pages, std::uint32_t vertex) {
    return (pages.groups[vertex / group_lanes].active & bit_of(vertex)) != 0;
}

// The records of the page that a state is of.
[[nodiscard]] inline const VertexRecord* records_of(const Pages& pages, std::uint32_t slot) {
    return pages.grid.terrain->records +
           std::size_t{pages.state[slot].terrain_slot} * pages.grid.terrain->page_capacity;
}

[[nodiscard]] inline const GroupShape& shape_of(const Pages& pages, std::uint32_t group) {
    const std::uint32_t slot = group / max_page_groups;
    return pages.grid.shapes[pages.state[slot].shape].groups[group - slot * max_page_groups];
}

[[nodiscard]] inline Site site_of(const Pages& pages, std::uint32_t vertex) {
    const std::uint32_t group = vertex / group_lanes;
    const auto lane = static_cast<std::int32_t>(vertex % group_lanes);
    const PageState& info = pages.state[group / max_page_groups];
    const GroupShape& shape = shape_of(pages, group);
    const int z = info.z + shape.z;
    return {z, shape.kind, (info.tile_x << pages.grid.steps[z].log2) + info.i0 + shape.i0 + (shape.along_y ? 0 : lane),
            (info.tile_y << pages.grid.steps[z].log2) + info.j0 + shape.j0 + (shape.along_y ? lane : 0)};
}

[[nodiscard]] inline VertexRecord record_of(const Pages& pages, std::uint32_t vertex) {
    const std::uint32_t group = vertex / group_lanes, lane = vertex % group_lanes, slot = group / max_page_groups;
    const VertexRecord* const records = records_of(pages, slot);
    if (pages.grid.hz_places) {
        const std::size_t page_shape = pages.state[slot].shape;
        return records[pages.grid.hz_places[((page_shape - slot) * max_page_groups + group) * group_lanes + lane]];
    }
    const GroupShape& shape = shape_of(pages, group);
    return records[shape.first + shape.stride * lane];
}

// --- states

[[nodiscard]] inline bool is_offscreen(const Pages& pages, std::uint32_t group) {
    const PageState& page = pages.state[group / max_page_groups];
    if (page.offscreen == 0) return false;
    const std::uint8_t parts = pages.grid.shapes[page.shape].groups[group % max_page_groups].parts;
    return (page.offscreen & parts) == parts;
}
inline void count_parents(Pages& pages, std::uint32_t slot, std::uint32_t more) {
    PageState& page = pages.state[slot];
    pages.busy += page.parents == 0 && more != 0;
    page.parents += more;
}

// Enters every page that was loaded and lets go of those that were unloaded. O(changes since the last call), or
// O(slots) when those were more than the terrain's log remembers.
void sync_pages(CutState& s);
// Has the host unloaded a page that the cut holds? The same complexity.
[[nodiscard]] bool has_lost_pages(const Pages& pages);
// The next sync_pages() visits all slots.
void rescan_pages(Pages& pages);

// Gives a page its state, if it is loaded and has none. False: there is none to be had.
[[nodiscard]] bool attach_page(Pages& pages, Work& work, Mesh& mesh, Visibility& visibility, std::uint32_t page);
// The page may have become idle: another one may have its state, from the next frame on.
void note_idle(Pages& pages, std::uint32_t slot);
// The sphere of the tile's root holds all of the tile. loaded: its page 0 is.
void bound_tile(const Grid& grid, Mesh& mesh, const PageState& info, bool loaded);
// Takes the state of the page that has been idle longest. False: none is. Not while the bulk pass is under way, or
// groups have been taken from their queues.
bool reclaim_page(Pages& pages, Work& work, Mesh& mesh);
// A few, as far as they will be needed soon.
void keep_pages_at_hand(Pages& pages, Work& work, Mesh& mesh);
// States that pages can have without taking others'.
[[nodiscard]] std::uint32_t free_pages(const Pages& pages);
// Can there be more pages with states than there are states?
[[nodiscard]] inline bool may_lack_pages(const Pages& pages) {
    return pages.count < pages.grid.terrain->slot_count;
}

// Parents that do not exist count as active, in a page's groups. Writes nothing else.
void mark_absent_parents(Pages& pages, std::uint32_t slot);
// As if nothing were active, for one page: what is counted of it, and its groups, which are zero but for such parents.
void clear_page(Pages& pages, std::uint32_t slot);
void forget_active(Pages& pages, std::uint32_t slot);
void zero_groups(Pages& pages, std::uint32_t slot);

// Deactivates what is still active in pages that are being evicted, as far as the items go.
void evict_pages(CutState& s);

// The page stays after all: what it could activate is evaluated again.
void cancel_eviction(Pages& pages, Work& work, std::uint32_t slot);

// Finds which parents of some lanes of a group are active.
struct ParentMasks {
    std::uint16_t parent[2];
};
[[nodiscard]] ParentMasks parents_of(const Pages& pages, std::uint32_t group, std::uint32_t lanes);
// Those that do not exist, at the terrain's rim and above a tile's root, count as active. first: of the group's lanes.
[[nodiscard]] ParentMasks absent_parents(const Grid& grid, const Site& first, const GroupShape& shape);

} // namespace fjell
