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

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "cut/frame.h"
#include "cut/mesh.h"
#include "cut/views.h"

namespace fjell {

struct CutState;

// --- what it keeps: the cut that is to be, in masks, while the one that is drawn stays as it is

// Rows of the planes of a page: a full one has 32 + 33 + 32 of 32 lanes, and its column; page 0 has a row a group.
inline constexpr std::uint32_t bulk_rows = 103;

// Of a page that has a state. Holds something while `build` is the pass'. Its vertices take slots one after the other,
// row by row.
struct alignas(64) BulkPage {
    std::uint32_t build;
    std::uint32_t number; // of its first vertex, in the order in which slots are taken
    std::uint32_t active[bulk_rows];
    std::uint16_t first[bulk_rows]; // of the row's vertices, counted from the page's first; where it has any
    std::uint16_t wanted;           // vertices
    std::uint16_t ticks[page_ticks];
    std::uint8_t grades;   // 1 + the highest grade of the groups that were evaluated; 0: none was
    bool has_groups;       // its state's are written, and
    std::uint32_t parents; // of its vertices are active, each counted once for each vertex that has it
};
static_assert(sizeof(BulkPage) == 1088);

// Rows of squares, or of a page's groups.
struct BulkRows {
    std::int32_t first, end;
};

// What is done at once: rows of a page, of one step where it is decided.
struct BulkUnit {
    std::uint32_t slot; // no_index: there was nothing
    int z;
    BulkRows rows;
    bool waits; // nobody sees the page, or it is being evicted: what is ready in it is due, not decided
    bool last;  // of its page
    // What was found:
    std::uint32_t wanted, groups, grades;
    // Triangles around its vertices, as they are placed: of its tile, and of those to the west and north.
    std::uint32_t own, west, north;
};
inline constexpr std::uint32_t most_units = 256; // at once

// Vertex slots in and around one page, where vertices are active. Rows and columns -1 of `centre` come first.
struct SlotGrid {
    static constexpr std::uint32_t n = page_squares;
    std::uint32_t corner[n + 1][n + 4];
    std::uint32_t centre[n + 1][n + 4];
    std::uint32_t side_x[n + 1][n];
    std::uint32_t side_y[n][n + 4];
};

// When a tile's root has to be looked at again: as BulkPage says of groups.
struct BulkRoot {
    std::uint16_t ticks;
    std::uint8_t grades;
};

// And what is known of them before: how many there will be, and which segments they take. free_segments below
// `reserved` down to as many as that takes; no_index: how many are hidden is not known, and it takes what comes.
struct BulkTile : TileStack {
    std::uint32_t planned;
    std::uint32_t reserved;
    BulkRoot root;
};

enum class BulkPhase : std::uint8_t {
    idle,
    roots,     // of all tiles: which are wanted
    centres,   // of step z, of the next pages: which are wanted
    sides,     // then which sides
    vertices,  // and what is wanted of these pages is written to its slots, while its records are at hand
    triangles, // tile by tile on the way down, when it is known which vertices are active
    built,     // the mesh stands beside the one that is drawn
    // It is drawn, and the state of pages follows:
    releasing,       // of those that the cut had
    installing,      // of those that it has
    installing_roots // and of those that nothing was found in
};

// A page on the way down.
struct BulkPlace {
    std::int32_t i0, j0;   // its first square, over the terrain
    std::uint32_t rows;    // whose triangles are there
    std::uint32_t quarter; // of it that comes next
};

// The way down of one tile, with the grids of its steps.
struct BulkDescent {
    SlotGrid* grids; // one a step
    std::uint32_t tile, depth;
    BulkPlace places[max_tile_log2];
};

// Records and masks of so many pages stay in the cache, and they are enough for a host's threads. The same whatever the
// number of these, or pages would be visited in another order.
inline constexpr std::uint32_t bulk_pages_together = 64;

struct BulkPass {
    BulkPage* pages;          // one a page state
    std::uint32_t* visited;   // states of pages that hold something
    std::uint32_t* listed[2]; // of those with active centres of the coarser step, and of the one in work
    std::uint32_t visited_count, listed_count[2];
    std::uint32_t workers;
    BulkDescent* descents;     // one a worker
    BulkTile* tiles;           // as many as Mesh::tiles
    std::uint32_t (*bases)[2]; // a tile's two triangles, where its root is not active; no_index where it is
    std::uint32_t build;
    bool beside;         // only slots that are free are used; otherwise all are, and what was drawn is gone
    bool again;          // the camera has jumped once more
    std::uint32_t taken; // vertices so far: the n-th has BulkSlots[n]
    std::uint32_t free_before, fresh_before; // of Mesh::free_vertices, when the pass began
    BulkPhase phase;
    bool no_pages;                   // there were not enough
    std::int32_t z;                  // step in work
    std::uint32_t at;                // next tile or page
    std::uint32_t part;              // of it
    std::uint32_t pages_together;    // at most, through centres, sides and vertices
    std::uint32_t end;               // of those pages
    std::uint32_t next_centres;      // those whose centres come after them
    std::uint32_t first_listed;      // of listed[1], the first of these pages
    std::uint32_t numbered;          // vertices that have their numbers
    double travelled_m[grade_count]; // by the odometers, since the pass began
    std::uint32_t units;             // that the last step has done
    bool begun_again;                // since a mesh was installed: the next jump does not drop what has been decided
    std::uint32_t parts;             // done, and not yet charged to a frame's work items
};

// What a pass does is charged in parts of a work item, such that an item takes as long as one that is spent vertex by
// vertex (docs/notes/live-cut.md). A unit that a frame's items do not cover is charged to those after it too.
inline constexpr std::uint32_t parts_an_item = 12, parts_a_group = 2, parts_a_placed_vertex = 1, triangles_a_part = 2,
                               states_a_part = 4;

// --- the pass

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

// Of that the first: the roots of the next tiles. False: all are decided.
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

// Charges the frame what the pass has done, as far as its items go.
void charge_work(BulkPass& bulk, Frame& frame, std::uint32_t parts);

// Units that may be done side by side: a few for each thread, where time counts, and no more than are left to a replay
// or, whatever they cost, to the items.
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

// What is done to rows of a page (bulk_decide.cpp).
// Decides the unit's rows: in the phase `centres` those of which its page's masks say what is ready, in `sides` those
// next to active centres. Writes nothing but its page and itself.
void decide_unit(const Pages& pages, const Schedule& schedule, BulkPass& bulk, const Views& views, BulkUnit& unit);

// Writes the vertices of the unit's rows, of all steps in the page, to their slots. Writes nothing but those, and where
// the rows begin.
void place_unit(const Pages& pages, BulkPass& bulk, Mesh& mesh, const Views& views, BulkUnit& unit);

// --- threads of the host's, where it gave us any

[[nodiscard]] inline std::uint32_t worker_count(const BulkPass& bulk, const Frame& frame) {
    return frame.settings.jobs.run == nullptr ? 1 : bulk.workers;
}

// work(n, worker) for n from 0 to count - 1, each once. Those of one worker run one after the other.
template <typename Work>
void run_jobs(const BulkPass& bulk, const Frame& frame, std::uint32_t count, const Work& work) {
    const std::uint32_t workers = std::min(worker_count(bulk, frame), count);
    if (workers < 2) {
        for (std::uint32_t n = 0; n < count; ++n) work(n, 0);
        return;
    }
    struct Shared {
        const Work& work;
        std::uint32_t count;
        std::atomic<std::uint32_t> next;
    } shared{work, count, 0};
    const auto job = [](void* data, std::uint32_t worker) {
        Shared& of = *static_cast<Shared*>(data);
        for (std::uint32_t n; (n = of.next.fetch_add(1, std::memory_order_relaxed)) < of.count;) of.work(n, worker);
    };
    frame.settings.jobs.run(frame.settings.jobs.user, workers, job, &shared);
}

} // namespace fjell
