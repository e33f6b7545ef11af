// The bulk pass: the whole cut at once, from nothing, level by level.
//
// One by one an activation costs hundreds of nanoseconds, because everything it touches is somewhere else. Here a row
// of a page is a word: which vertices are ready follows from their parents' words by spreading bits, a group is
// evaluated once, and its vertices take slots in order. Triangles come next, page by page on the way down, when it is
// known which children are active; a page's corners are handed down as a grid of slots, so that no vertex is looked up.
// Both use only slots that are free. What they find becomes the cut's state at the end, page by page.
//
// Some pages at a time are decided and their vertices written, so that records and masks are read while they are in the
// cache. All of it is done in units of a quarter of a page at most, so that it may stop after any of them.
#pragma once

#include "cut/find.h"

namespace fjell {

// Begins, with the decision as it is set. beside: only in slots that are free, so that what is drawn stays as it is;
// otherwise in all of them.
void begin_bulk(const Pages& pages, BulkPass& bulk, const Mesh& mesh, bool beside);

// What was under way is forgotten, and the pass idle. Not when it has been installed.
void drop_bulk(Pages& pages, BulkPass& bulk, Mesh& mesh);

enum class BulkStatus : std::uint8_t { unfinished, built, no_vertices, no_triangles, no_pages };
// The next unit of deciding, placing and building, or the next ones, where the host has threads for them;
// BulkPass::units says how many. no_vertices, no_triangles, no_pages: that capacity does not suffice; idle again, and
// nothing has changed.
[[nodiscard]] BulkStatus step_bulk(CutState& s);

// Of that the first: the roots of the next tiles. False: all are decided (bulk_roots.cpp).
[[nodiscard]] bool step_roots(CutState& s);

// What has been found in a page, from now on: nothing so far, but for when a root has to be looked at again.
BulkPage& visit_page(Pages& pages, Work& work, BulkPass& bulk, const Visibility& visibility, std::uint32_t slot);

// Of it the triangles, once all vertices are placed (bulk_mesh.cpp). has_segments: there are enough for those that were
// decided, whatever their order. step: the triangles of one more quarter of a page; false when there is none. build:
// all of them, several tiles side by side.
[[nodiscard]] bool has_segments(const BulkPass& bulk, const Mesh& mesh);
void begin_triangles(const Grid& grid, BulkPass& bulk, Mesh& mesh);
[[nodiscard]] bool step_triangles(Pages& pages, BulkPass& bulk, Mesh& mesh, bool morphs);
void build_tiles(Pages& pages, BulkPass& bulk, Mesh& mesh, bool morphs, const Frame& frame);

// What was built is the cut's mesh from now on. Its state follows, and must be whole before anything is changed.
// O(tiles and segments).
void install_mesh(CutState& s);
// The next unit of that. False: all is done.
[[nodiscard]] bool step_install(CutState& s);

// Of that the last: the roots of tiles of which nothing else was found. False: all are done.
[[nodiscard]] bool step_install_roots(Pages& pages, Work& work, BulkPass& bulk, const Mesh& mesh);

// What it has begun to build comes to its end; what it has only decided is forgotten.
void finish_bulk(CutState& s);
// From nothing, with all slots. What does not fit leaves states and triangles as they are, but not what vertices' slots
// hold: it has to be built again, or reset.
[[nodiscard]] BulkStatus build_bulk(CutState& s);
// After a jump of the camera: builds what is seen, as long as the frame may. True: it has not come to its end, and what
// is drawn is as it was. What is not seen is due when it has.
[[nodiscard]] bool run_bulk(CutState& s);

// Units that may be done side by side: a few for each thread, where time counts, and no more than are left to a replay.
[[nodiscard]] std::uint32_t unit_limit(const BulkPass& bulk, const Frame& frame);

// The squares of one step in one page or, of coarse steps, in one tile; and of what the pass has found there.
struct BulkSquares {
    const StepGroups* step;
    std::uint32_t slot;
    int z;
    std::int32_t i0, j0, n; // first square, over the terrain; squares a side

    [[nodiscard]] std::uint32_t row(VertexKind kind, std::int32_t j) const { // j: 0..n for side_x
        const std::uint32_t plane = kind == VertexKind::centre   ? step->centres
                                    : kind == VertexKind::side_x ? step->sides_x
                                                                 : step->sides_y;
        return (plane >> step->words_log2) + static_cast<std::uint32_t>(j);
    }
    [[nodiscard]] std::uint32_t column() const { return step->column >> step->words_log2; }
    [[nodiscard]] std::uint32_t all() const { return n == 32 ? ~0u : (1u << n) - 1; }
};

// Those that a square lies in. Its slot is no_index when its page has no state, or there is no such tile.
[[nodiscard]] inline BulkSquares squares_at(const Pages& pages, int z, std::int32_t i, std::int32_t j) {
    const StepGroups& step = pages.grid.steps[z];
    const bool there = !pages.grid.terrain->is_sparse() || has_square(pages.grid, z, i, j);
    const std::uint32_t vertex = there ? find_vertex(pages, {z, VertexKind::centre, i, j}) : no_index;
    const std::int32_t n = 1 << step.page_log2;
    return {&step, vertex == no_index ? no_index : vertex / group_lanes / max_page_groups, z, i & -n, j & -n, n};
}

// The squares of a step in a page that has a state.
[[nodiscard]] inline BulkSquares listed_squares(const Pages& pages, std::uint32_t slot, int z) {
    const PageState& page = pages.state[slot];
    const StepGroups& step = pages.grid.steps[z];
    return {&step,
            slot,
            z,
            (page.tile_x << step.log2) + page.i0,
            (page.tile_y << step.log2) + page.j0,
            1 << step.page_log2};
}

// Whether the terrain ends there: a page owns the sides of a rim, as no neighbour does.
[[nodiscard]] inline bool ends_north(const Grid& grid, const BulkSquares& at) {
    return !has_square(grid, at.z, at.i0, at.j0 - 1);
}
[[nodiscard]] inline bool ends_west(const Grid& grid, const BulkSquares& at) {
    return !has_square(grid, at.z, at.i0 - 1, at.j0);
}
[[nodiscard]] inline bool ends_south(const Grid& grid, const BulkSquares& at) {
    return !has_square(grid, at.z, at.i0, at.j0 + at.n);
}
[[nodiscard]] inline bool ends_east(const Grid& grid, const BulkSquares& at) {
    return !has_square(grid, at.z, at.i0 + at.n, at.j0);
}

// What the pass has found in a page; nullptr: nothing.
[[nodiscard]] inline const BulkPage* found_in(const BulkPass& bulk, std::uint32_t slot) {
    return slot != no_index && bulk.pages[slot].build == bulk.build ? &bulk.pages[slot] : nullptr;
}
[[nodiscard]] inline const BulkPage* found_at(const Pages& pages, const BulkPass& bulk, int z, std::int32_t i,
                                              std::int32_t j) {
    if (i < 0 || j < 0 || i >= pages.grid.tiles_x << pages.grid.steps[z].log2 ||
        j >= pages.grid.tiles_y << pages.grid.steps[z].log2)
        return nullptr;
    return found_in(bulk, squares_at(pages, z, i, j).slot);
}

// Nothing but its root can be ready, or scheduled, or wait.
[[nodiscard]] inline bool is_clear(const PageState& page) {
    return page.shape == 0 && page.parents == 0 && !page.used;
}

[[nodiscard]] inline std::uint32_t row_bits(const BulkPage* page, std::uint32_t row) {
    return page == nullptr ? 0 : page->active[row];
}

// Which parents of a page's centres are active, a word a row. False: none at all.
[[nodiscard]] bool centre_parents(const Pages& pages, const BulkPass& bulk, const BulkSquares& at,
                                  std::uint32_t (&parents)[2][page_squares]);

// Bit i to bits 2i and 2i + 1.
[[nodiscard]] inline std::uint32_t doubled(std::uint32_t v) {
    const std::uint32_t even = spread_bits(v);
    return even | even << 1;
}

// The slots of the vertices that the pass has taken, by their numbers.
class BulkSlots {
public:
    BulkSlots(const Mesh& mesh, const BulkPass& bulk)
        : stack_(mesh.free_vertices), free_(bulk.free_before), fresh_(bulk.fresh_before - bulk.free_before) {}
    [[nodiscard]] std::uint32_t operator[](std::uint32_t n) const {
        return n < free_ ? stack_[free_ - 1 - n] : fresh_ + n;
    }
    [[nodiscard]] bool are_consecutive(std::uint32_t first) const { return first >= free_; }

private:
    const std::uint32_t* stack_;
    std::uint32_t free_, fresh_;
};
// How many there are.
[[nodiscard]] inline std::uint32_t bulk_capacity(const BulkPass& bulk, const Mesh& mesh) {
    return bulk.free_before + mesh.capacity - bulk.fresh_before;
}

} // namespace fjell
