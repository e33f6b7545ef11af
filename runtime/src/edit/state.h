// What edits keep in the host's memory (fjell/edit.h).
#pragma once

#include <atomic>
#include <cstdint>

#include "edit/block_table.h"
#include "edit/ground.h"
#include "edit/window.h"
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
    std::int32_t x, y;      // in blocks
    std::int32_t differing; // samples that do, 1 at least
    std::int32_t pack_base, base;
    std::int32_t least_off, most_off;              // of edited heights over the pack's, ever, 0 among them
    std::uint16_t pack[block_side * block_side];   // steps above pack_base, where `edited` says that there are any
    std::uint16_t edited[block_side * block_side]; // steps above base, or as_in_pack
};
// Which of a block's samples are holes, by rows; only where stamps may make some (EditBudget::holes). Of those that
// `edited` has, both; what differs in this alone has its height there.
struct BlockHoles {
    std::uint32_t pack[block_side], edited[block_side];
    std::int32_t differing; // samples
};

// The samples of a block, by its place in blocks.
[[nodiscard]] constexpr Rect block_samples(std::int32_t x, std::int32_t y) {
    return {x * block_side, y * block_side, x * block_side + block_side - 1, y * block_side + block_side - 1};
}

// A block some of whose samples are locked, by its place in blocks.
inline constexpr std::uint8_t no_lock = 255; // any error is allowed
struct LockBlock {
    std::int32_t x, y;
    std::uint8_t least;                            // of `allowed`
    std::uint8_t allowed[block_side * block_side]; // codes
};

// What a stamp makes of a piece.
struct Piece {
    Rect rect;                                         // places
    std::int32_t steps[largest_piece * largest_piece]; // by rows of largest_piece
    bool holes[largest_piece * largest_piece];
    [[nodiscard]] std::size_t index(SampleIndex v) const {
        return static_cast<std::size_t>(v.row - rect.y0) * largest_piece + static_cast<std::size_t>(v.column - rect.x0);
    }
    [[nodiscard]] std::int32_t& at(SampleIndex v) { return steps[index(v)]; }
    [[nodiscard]] bool& hole_at(SampleIndex v) { return holes[index(v)]; }
};

// What a stamp changes, of a piece or of all that have been looked at.
struct Change {
    Rect places;                                       // where something changes
    StepRange heights, before;                         // of the new heights there, and of the old ones
    StepRange off{0, 0};                               // of new over old heights, 0 among them
    std::int32_t steepest = 0;                         // difference between neighbours
    std::int32_t bend = 0;                             // that neighbours move apart by, at most
    std::uint32_t samples = 0, pieces = 0, blocks = 0; // blocks that it needs
    bool no_number = false;                            // a height is none
    bool holes = false;                                // samples become holes, or ground
    StepRange filled;                                  // heights of those that become ground
    void add(const Change& c) {
        places = places.with(c.places);
        heights.add(c.heights), before.add(c.before), off.add(c.off);
        steepest = std::max(steepest, c.steepest), bend = std::max(bend, c.bend);
        samples += c.samples, pieces += c.pieces, blocks += c.blocks;
        no_number = no_number || c.no_number;
        holes = holes || c.holes;
        filled.add(c.filled);
    }
};

// Handed in, from any thread to the frame's: a bounded queue whose cells count their turns.
struct QueueCell {
    std::atomic<std::uint64_t> turn;
    Stamp stamp;
    StampId id;
};

// A stamp that was taken from the queue. All its pieces are looked at, then all are applied; a single one at once.
struct Waiting {
    Stamp stamp;
    StampId id = 0;
    Rect places;             // that it may change
    bool held = false;       // for pages
    bool lacks_pages = true; // as it was at page_changes
    bool awaits = false;     // its pages: it has lacked some, and streams load them until it is done
    bool wants_rest = false; // pages around it too, and that all is measured there
    bool fits = false;       // it has been looked at, and is not refused
    bool at_once = false;    // its pieces are one item
    bool moves = false;      // it has begun to, and waits no more
    std::uint32_t piece = 0; // the next one
    Change change{};         // of what has been looked at
    std::uint64_t page_changes = ~std::uint64_t{0}; // TerrainData::changes when its pages were looked for
};

// A stamp whose ground is on its way: where it was, where it goes, and how much of the way it has come.
struct Moving {
    Waiting stamp;
    double begun_s, share;
    Rect rect;            // places
    StepRange heights;    // of both
    std::uint32_t blocks; // that it may still need
    std::int32_t from[largest_piece * largest_piece], to[largest_piece * largest_piece];
};

// How far, in steps, a sphere may depend on a height: its children's, and those of the vertices that share their codes.
inline constexpr std::int32_t radius_reach = 24;
inline constexpr int no_radii = 99;

// Where errors are to be measured again: of vertices around these places, from fine to coarse.
struct Area {
    Rect places;
    bool begun = false;
    bool unmeasured = false; // something could not be read: it waits for pages
    int first_z = 0;         // of its vertices
    int radii_z = no_radii;  // spheres of this step and larger ones are to be worked out first
    // Of this turn.
    int z = 0, plane = 0; // of sides_then_centres
    bool plane_begun = false;
    std::int32_t i = 0, j = 0; // the next square
    bool missed = false;       // something could not be read
    int missed_radii_z = no_radii;
    std::uint64_t page_changes = 0; // TerrainData::changes when it began
    Missing missing{};              // what it has lacked: a stream loads it where a stamp waits for the area
};

// What radii are worked out from: the baker's numbers (baker/heights/scales.h).
struct RadiusTerms {
    float quantum, height_pad, leaf_pad;
    float along_x[max_tile_log2], along_y[max_tile_log2], across[max_tile_log2]; // squares of ways along the ground
    float unit_m[2 * max_tile_log2];                                             // sides at 2 z, centres at 2 z + 1
    double ground_pad_m, height_pad_m, half_quantum_m;
    float side_edge_m, centre_edge_m; // hypotenuses of step 1 are as long at least
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
    std::uint64_t queue_head; // the frame's thread only
    std::atomic<std::uint64_t>*
        results; // by id % (2 * queue_size): id << 16 | state << 12 | refusal << 8 | status code
    // The frame's thread.
    edit::Waiting* waiting;
    std::uint32_t waiting_count, awaiting_count; // awaiting: those of the waiting that await pages
    std::uint64_t awaits_changes;                // how often stamps began or ceased to
    edit::Moving* moving;
    std::uint32_t moving_count;
    edit::Block* blocks;
    edit::BlockHoles* block_holes; // by their numbers; null: EditBudget::holes is false
    std::uint32_t block_count;
    edit::BlockTable block_table;
    edit::LockBlock* locks;
    std::uint32_t lock_count;
    edit::BlockTable lock_table;
    edit::Area* areas; // the first that is not `unmeasured` is in work
    std::uint32_t area_count;
    edit::Rect measured; // vertices of step 2^measured_z whose errors are others, and nobody knows
    int measured_z;
    double steepest_m; // ground with such steps between neighbours has codes wherever the pack's heights end
    bool room_for_holes, room_for_locks;
    GroundChange changes[ground_change_log];
    PaintData* paint; // null: the pack has no maps for it
    edit::Window window;
    edit::Piece piece;
};

} // namespace fjell
