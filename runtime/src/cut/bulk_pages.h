// What the bulk pass keeps: the cut that is to be, in masks, while the one that is drawn stays as it is.
#pragma once

#include <cstddef>
#include <cstdint>

#include "cut/groups.h"
#include "cut/schedule.h"

namespace fjell {

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

// A stack of segments: a tile's triangles.
struct TileStack {
    std::uint32_t last_segment; // no_index: none
    std::uint32_t in_last;
    std::uint32_t total;
    std::uint32_t segments;
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
};

} // namespace fjell
