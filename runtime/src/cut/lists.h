// Lists of blocks: a calendar of when each must be looked at again, and queues of work.
//
// Every block is in one list at most, linked through its own state, so no list can run out of room and a block moves in
// O(1). The calendar counts, for each grade of errors, how far the worst eye has travelled in metres - plus what changes
// of threshold amount to at that grade's largest error - in ticks of 1/32 cell. A block whose smallest slack is d may
// rest until its grade's odometer has gone that far.
//
// Wheels. Eight wheels of 64 buckets a grade; a bucket of wheel k is 8^k ticks wide, and a slack goes to the first wheel
// that holds it, at least seven buckets ahead. So a block comes up at most a seventh of its slack too early, nothing is
// carried from wheel to wheel, and a frame that moves little looks at eight numbers a grade. A bucket whose time has come
// is spliced onto the list of due blocks whole, without touching its blocks: that a block is due follows from its tick.
// Rejected: one queue in order of due times (a heap's cost and cold lines for an order that nothing needs); cascading
// wheels, which move thousands of blocks at once when a coarse bucket's turn comes.
#pragma once

#include <cstddef>
#include <cstdint>

namespace fjell {

struct BlockState;

struct Link {
    std::uint32_t next, prev;
};

inline constexpr std::uint32_t grade_count = 16, grade_codes_log2 = 4; // error codes 0..255 in grades of 16
inline constexpr std::uint32_t wheel_count = 8, wheel_buckets = 64, first_wheel_ticks = 56;
inline constexpr std::uint32_t rank_count = 32; // of work: 16 by screen error, and 16 more for what a frustum shows

// Numbers of lists.
using ListId = std::uint16_t;
inline constexpr ListId calendar_lists = grade_count * wheel_count * wheel_buckets;
inline constexpr ListId soon_lists = calendar_lists;         // one a grade: due with the next movement
inline constexpr ListId due_lists = soon_lists + grade_count; // one a grade: to be evaluated
inline constexpr ListId work_lists = due_lists + grade_count; // one a rank: vertices to activate
inline constexpr ListId retire_list = work_lists + rank_count; // vertices to deactivate
inline constexpr ListId blocked_lists = retire_list + 1;       // for want of a capacity; two that take turns
inline constexpr ListId gated_lists = blocked_lists + 2;       // behind a vertex that is rising; two that take turns
inline constexpr ListId list_count = gated_lists + 2;
inline constexpr ListId no_list = 0xffff;

struct Lists {
    BlockState* blocks;
    std::uint32_t block_count;
    Link* heads;          // list_count: a list's first and last block are its head's next and prev
    std::uint32_t* sizes; // list_count
    std::uint64_t filled[grade_count][wheel_count]; // buckets that may hold blocks
    double odometer_m[grade_count];
    std::uint64_t tick[grade_count];
    std::uint64_t moves[grade_count]; // times that it was advanced
    double tick_m;
};

void clear_lists(Lists& lists);

void push_back(Lists& lists, ListId list, std::uint32_t block);
void unlink(Lists& lists, std::uint32_t block); // from whatever list it is in
[[nodiscard]] ListId list_of(const Lists& lists, std::uint32_t block); // or no_list

[[nodiscard]] inline std::uint32_t size(const Lists& lists, ListId list) {
    return lists.sizes[list];
}
[[nodiscard]] inline std::uint32_t front(const Lists& lists, ListId list) {
    return lists.heads[list].next;
}

// The block, in no list, must be looked at when the odometer of its grade has gone slack_m further.
void schedule(Lists& lists, std::uint32_t block, float slack_m, std::uint32_t grade);
// The same for one more vertex of a block that may be scheduled already: the earlier time and the higher grade win.
// Blocks in other lists stay there: they will be looked at anyway.
void tighten(Lists& lists, std::uint32_t block, float slack_m, std::uint32_t grade);

// Moves an odometer on; blocks whose time has come become due.
void advance(Lists& lists, std::uint32_t grade, double metres);

} // namespace fjell
