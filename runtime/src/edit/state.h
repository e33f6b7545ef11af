// What edits keep in the host's memory (fjell/edit.h).
#pragma once

#include <atomic>
#include <cstdint>

#include "edit/ground.h"
#include "fjell/edit.h"
#include "handle.h"
#include "shared/page.h"

namespace fjell {

namespace edit {

// A block of samples that differ from the pack, by its place in blocks: what a page that comes back is given again.
inline constexpr int block_log2 = 5;
inline constexpr std::int32_t block_side = 1 << block_log2;
inline constexpr std::uint16_t as_in_pack = 0xffff; // of Block::edited
struct Block {
    std::int32_t x, y; // in blocks
    std::int32_t pack_base, base;
    std::int32_t low_delta, high_delta; // of all edits so far, added up: what errors of pages to come may grow by
    std::uint16_t pack[block_side * block_side];   // steps above pack_base, where `edited` says that there are any
    std::uint16_t edited[block_side * block_side]; // steps above base, or as_in_pack
};

// Stamps are applied in pieces of so many places a side; with what lies around them they are read into a window.
inline constexpr std::int32_t piece_side = 64, window_margin = 28, window_side = piece_side + 2 * window_margin;
// Steps of which errors are measured at once.
inline constexpr int measured_at_once = 3;

struct Window {
    Rect rect;
    std::int32_t steps[window_side * window_side];
    std::uint8_t missing[window_side * window_side];
    std::uint8_t hole[window_side * window_side];
    [[nodiscard]] std::size_t index(SampleIndex v) const {
        return static_cast<std::size_t>(v.row - rect.y0) * window_side + static_cast<std::size_t>(v.column - rect.x0);
    }
};

struct Piece {
    Rect rect;                                     // places
    std::int32_t changed[piece_side * piece_side]; // new steps, by rows of piece_side
};

// Handed in, from any thread to the frame's: a bounded queue whose cells count their turns.
struct QueueCell {
    std::atomic<std::uint64_t> turn;
    Stamp stamp;
    StampId id;
};

// A stamp that was taken from the queue.
struct Waiting {
    Stamp stamp;
    StampId id;
    Rect places; // that it may change
    bool held;   // for pages
    // Looked at first, then applied: the next piece, and what was found.
    bool begun, checking;
    std::uint32_t piece;
    Rect changed;
    std::int32_t low, high, old_low, old_high, steepest;
    std::uint32_t blocks; // that it needs
};

// How far, in steps, a sphere may depend on a height: its children's, and those of the vertices that share their codes.
inline constexpr std::int32_t radius_reach = 24;
inline constexpr int no_radii = 99;

// Where errors are to be measured again: of vertices around these places, from fine to coarse.
struct Area {
    Rect places;
    int z;
    int plane;         // of sides_then_centres
    std::int32_t i, j; // the next square
    bool begun;
    bool unmeasured; // something could not be read, until pages come
    bool missed;     // the same, in this turn
    int radii_z;     // spheres of this step and coarser ones are to be worked out first; or no_radii
    bool radii_done; // they are
};

// What radii are worked out from: the baker's numbers (baker/heights/scales.h).
struct RadiusTerms {
    float quantum, height_pad, leaf_pad;
    float along_x[max_tile_log2], along_y[max_tile_log2], across[max_tile_log2]; // squares of ways along the ground
    float unit_m[2 * max_tile_log2];                                             // sides at 2 z, centres at 2 z + 1
    double ground_pad_m, height_pad_m, half_quantum_m;
};

} // namespace edit

struct EditsData {
    BlockHead head;
    Terrain handle;
    TerrainData* terrain;
    EditBudget budget;
    edit::RadiusTerms radius;
    // Any thread.
    edit::QueueCell* queue; // queue_size of them, a power of 2
    std::uint64_t queue_size;
    std::atomic<std::uint64_t> tail;
    std::uint64_t queue_head;            // the frame's thread only
    std::atomic<std::uint64_t>* results; // by id % (2 * queue_size): id << 16 | state << 8 | status code
    // The frame's thread.
    edit::Waiting* waiting;
    std::uint32_t waiting_count;
    edit::Block* blocks;
    std::uint32_t block_count;
    std::uint32_t* block_table; // by hash of their places: number, or no_index
    std::uint32_t block_table_size;
    edit::Area* areas; // the first is in work
    std::uint32_t area_count;
    bool radii_unknown;  // some could not be worked out for want of pages
    edit::Rect measured; // vertices of step 2^measured_z whose errors are others, and nobody knows
    int measured_z;
    std::uint64_t seen_page_changes;
    GroundChange changes[ground_change_log];
    edit::Window window;
    edit::Piece piece;
};

} // namespace fjell
