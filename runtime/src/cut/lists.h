// Lists of blocks: a calendar of when each must be looked at again, and queues of work.
//
// The calendar counts, for each grade of errors, how far the worst eye has travelled in metres - plus what changes of
// threshold amount to at that grade's largest error - in ticks of about 1/32 cell. A block whose smallest slack is d
// may rest until its grade's odometer has gone that far.
//
// Wheels. Eight wheels of 64 buckets a grade; a bucket of wheel k is 8^k ticks wide, and a slack goes to the first
// wheel that holds it, at least seven buckets ahead. So a block comes up at most a seventh of its slack too early,
// nothing is carried from wheel to wheel, and a frame that moves little looks at eight numbers a grade. A bucket whose
// time has come joins the due blocks of its grade without a look at them: that a block is due follows from its tick.
//
// Buckets and due blocks are arrays in chunks of a cache line, because what a visit costs is cache misses: with the
// numbers side by side, the states and records of the next chunk are fetched while this one is worked on. (Links
// through the blocks made every visit wait for the one before: 150 to 190 ns a visit instead of 60.) A block knows its
// place in its bucket, so it can leave; there are as many chunks as all blocks can ever need. Rejected: one queue in
// order of due times (a heap's cost for an order that nothing needs); cascading wheels, which move thousands of blocks
// at once when a coarse bucket's turn comes.
//
// Queues of work are short and of blocks just looked at; they are linked through the blocks' states.
#pragma once

#include <cstddef>
#include <cstdint>

namespace fjell {

inline constexpr std::uint32_t nil = 0xffffffff;

struct BlockState;

struct Link { // in a queue: neighbours; in the calendar: the chunk and the place in it
    std::uint32_t next, prev;
};

inline constexpr std::uint32_t chunk_blocks = 14;
struct BlockChunk {
    std::uint32_t next, count;
    std::uint32_t blocks[chunk_blocks];
};
static_assert(sizeof(BlockChunk) == 64, "a cache line");

inline constexpr std::uint32_t grade_count = 16, grade_codes_log2 = 4; // error codes 0..255 in grades of 16
inline constexpr std::uint32_t wheel_count = 8, wheel_buckets = 64, first_wheel_ticks = 56;
inline constexpr std::uint32_t rank_count = 32; // of work: 16 by screen error, and 16 more for what a frustum shows

// Numbers of lists.
using ListId = std::uint16_t;
inline constexpr ListId calendar_lists = grade_count * wheel_count * wheel_buckets;
inline constexpr ListId soon_lists = calendar_lists;           // one a grade: due with the next movement
inline constexpr ListId due_lists = soon_lists + grade_count;  // one a grade: to be evaluated
inline constexpr ListId work_lists = due_lists + grade_count;  // queues, one a rank: vertices to activate
inline constexpr ListId retire_list = work_lists + rank_count; // vertices to deactivate
inline constexpr ListId blocked_lists = retire_list + 1;       // for want of a capacity; two that take turns
inline constexpr ListId gated_lists = blocked_lists + 2;       // behind a vertex that is rising; two that take turns
inline constexpr ListId list_count = gated_lists + 2;
inline constexpr ListId queue_count = list_count - work_lists;
inline constexpr ListId held = 0xfffe; // taken from its list, about to be evaluated
inline constexpr ListId no_list = 0xffff;

struct Bucket {
    std::uint32_t top, bottom; // chunks; all below the top are full
    std::uint32_t full;        // how many those are
    std::uint32_t in_top;      // blocks; kept here, so that one more is a store to its line and no load
};

// Of a grade: full chunks, first come first, and one that fills up.
struct DueBlocks {
    std::uint32_t first, last, filling;
};

struct Lists {
    BlockState* blocks;
    std::uint32_t block_count;
    Link* queues; // queue_count: a queue's first and last block are its head's next and prev
    BlockChunk* chunks;
    std::uint32_t free_chunk;                     // a stack through BlockChunk::next
    Bucket* buckets;                              // due_lists
    std::uint32_t sizes[list_count - soon_lists]; // of the lists after the calendar
    DueBlocks due[grade_count];
    std::uint64_t filled[grade_count][wheel_count]; // buckets that may hold blocks
    double odometer_m[grade_count];
    std::uint64_t tick[grade_count];
    std::uint64_t moves[grade_count]; // times that it was advanced
    double tick_m, ticks_per_m;       // powers of 2: products with them are exact
};

[[nodiscard]] constexpr std::uint32_t block_chunks(std::uint32_t block_count) {
    return block_count / chunk_blocks + due_lists + grade_count + 1;
}

void set_tick(Lists& lists, double about_m); // rounded down to a power of 2
void clear_lists(Lists& lists, std::uint32_t chunk_count);

[[nodiscard]] ListId list_of(const Lists& lists, std::uint32_t block);            // or no_list
[[nodiscard]] inline std::uint32_t size(const Lists& lists, std::uint32_t list) { // not of the calendar's
    return lists.sizes[list - soon_lists];
}

// The block must be in no list.
void push_back(Lists& lists, std::uint32_t queue, std::uint32_t block);
void push_front(Lists& lists, std::uint32_t queue, std::uint32_t block);
void push_due(Lists& lists, std::uint32_t grade, std::uint32_t block);
// Takes a block from whatever list it is in, but not from due blocks.
void unlink(Lists& lists, std::uint32_t block);
// The list must not be empty.
[[nodiscard]] std::uint32_t pop_front(Lists& lists, std::uint32_t queue);
// With each block, one that comes a chunk later is passed to fetch().
template <typename Fetch>
[[nodiscard]] std::uint32_t pop_due(Lists& lists, std::uint32_t grade, const Fetch& fetch) {
    DueBlocks& due = lists.due[grade];
    const std::uint32_t at = due.first != nil ? due.first : due.filling;
    BlockChunk& chunk = lists.chunks[at];
    const std::uint32_t block = chunk.blocks[--chunk.count];
    if (const std::uint32_t next = chunk.next != nil ? chunk.next : due.filling; next != nil && next != at) {
        const BlockChunk& after = lists.chunks[next];
        if (chunk.count < after.count) fetch(after.blocks[chunk.count]);
        if (after.next != nil && chunk.count == chunk_blocks / 2) __builtin_prefetch(&lists.chunks[after.next]);
    }
    --lists.sizes[due_lists + grade - soon_lists];
    if (chunk.count != 0) return block;
    if (due.first != nil)
        due.first = chunk.next;
    else
        due.filling = nil;
    chunk.next = lists.free_chunk;
    lists.free_chunk = at;
    return block;
}
// Forgets due blocks numbered first to first + count - 1. O(due blocks).
void forget_due(Lists& lists, std::uint32_t first, std::uint32_t count);

// The block, in no list, must be looked at when the odometer of its grade has gone slack_m further.
void schedule(Lists& lists, std::uint32_t block, float slack_m, std::uint32_t grade);
// The same for one more vertex of a block that may be scheduled already: the earlier time and the higher grade win.
// Blocks in other lists stay there: they will be looked at anyway.
void tighten(Lists& lists, std::uint32_t block, float slack_m, std::uint32_t grade);

// Moves an odometer on; blocks whose time has come become due.
void advance(Lists& lists, std::uint32_t grade, double metres);

} // namespace fjell
