// What the bulk pass keeps: the cut that is to be, in masks, while the one that is drawn stays as it is.
#pragma once

#include <cstddef>
#include <cstdint>

#include "cut/groups.h"
#include "cut/schedule.h"

namespace fjell {

// Rows of the planes of a page: a full one has 32 + 33 + 32 of 32 lanes, and its column; page 0 has a row a group.
inline constexpr std::uint32_t bulk_rows = 103;

// Of a page that has a state. Holds something while `build` is the pass'.
struct BulkPage {
    std::uint32_t build;
    std::uint32_t grades; // 1 + the highest grade of the groups that were evaluated; 0: none was
    std::uint32_t active[bulk_rows];
    std::uint32_t first[bulk_rows]; // of the row's active vertices: its number, in the order in which they take slots
    std::uint16_t ticks[page_ticks];
};
static_assert(sizeof(BulkPage) == 1280);

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

enum class BulkPhase : std::uint8_t {
    idle,
    centres,   // of step z, page by page: which are wanted
    sides,     // then which sides
    triangles, // tile by tile on the way down, when it is known which vertices are active
    built,     // the mesh stands beside the one that is drawn
    // It is drawn, and the state of pages follows:
    releasing, // of those that the cut had
    installing // of those that it has
};

// A page on the way down.
struct BulkPlace {
    std::int32_t i0, j0;   // its first square, over the terrain
    std::uint32_t rows;    // whose triangles are there
    std::uint32_t quarter; // of it that comes next
};

struct BulkPass {
    BulkPage* pages;          // one a page state
    std::uint32_t* visited;   // states of pages that hold something
    std::uint32_t* listed[2]; // of those with active centres of the coarser step, and of the one in work
    std::uint32_t visited_count, listed_count[2];
    SlotGrid* grids;           // one a step
    TileStack* tiles;          // as many as CutState::tiles
    std::uint32_t (*bases)[2]; // a tile's two triangles, where its root is not active; no_index where it is
    std::uint32_t build;
    bool beside;         // only slots that are free are used; otherwise all are, and what was drawn is gone
    bool again;          // the camera has jumped once more
    std::uint32_t taken; // vertices so far: the n-th has bulk_slot(n)
    std::uint32_t free_before, fresh_before; // of CutState::free_vertices, when the pass began
    std::uint32_t mapped;                    // entries of that stack that say so while the state follows
    BulkPhase phase;
    bool no_vertices, no_pages; // there were not enough
    std::int32_t z;             // step in work
    std::uint32_t at;           // next tile or page
    std::uint32_t part;         // of it
    std::uint32_t depth;
    double travelled_m[grade_count]; // by the odometers, since the pass began
    BulkPlace places[max_tile_log2];
};

} // namespace fjell
