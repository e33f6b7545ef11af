// Lists of groups: a calendar of when each must be evaluated again, and queues of work.
//
// The calendar counts, for each grade of errors, how far the worst eye has travelled in metres - plus what changes of
// threshold amount to at that grade's largest error - in ticks of about 1/32 cell. A group whose smallest slack is d
// may rest until its grade's odometer has gone that far.
//
// Wheels. Eight wheels of 64 buckets a grade; a bucket of wheel k is 8^k ticks wide, and a slack goes to the first
// wheel that holds it, at least seven buckets ahead. So a group comes up at most a seventh of its slack too early,
// nothing is carried from wheel to wheel, and a frame that moves little reads eight numbers a grade. A bucket whose
// time has come joins the due groups of its grade without touching them: that a group is due follows from its tick.
//
// An odometer cannot wrap: once it has reached rewind_tick (2^32) it begins again at 0, and all groups of its grade are
// due, as they may be at any time. A due tick is at most last_tick (2^27) ahead of it, and 48 bits of it are kept.
// Doubles below 2^33 are at most 2^-20 of a tick apart, 2^-25 of a cell: less than slack_rounding of any span. So what
// a due tick is rounded by does not matter; small ways, which would be lost one by one, are rounded up.
//
// Buckets and due groups are arrays in nodes of a cache line, because what a visit costs is cache misses: with the
// numbers side by side, the states and records of the next node are fetched while this one is worked on. (Links
// through the groups made every visit wait for the one before: 150 to 190 ns a visit instead of 60.) A group knows its
// place in its bucket, so it can leave; there are as many nodes as all groups can ever need. Rejected: one queue in
// order of due times (a heap's cost for an order that nothing needs); cascading wheels, which move thousands of groups
// at once when a coarse bucket's turn comes.
//
// Queues of work are short and hold groups just evaluated; they are linked through the groups' states.
#pragma once

#include <cstddef>
#include <cstdint>

#include "asserts.h"
#include "tree/tree.h"

namespace fjell {

struct GroupState;

struct Link { // in a queue: neighbours; in the calendar: the node and the place in it
    std::uint32_t next, prev;
};

inline constexpr std::uint32_t node_groups = 14;
struct ListNode {
    std::uint32_t next, count;
    std::uint32_t groups[node_groups];
};
static_assert(sizeof(ListNode) == 64, "a cache line");

inline constexpr std::uint32_t grade_count = 16, grade_codes_log2 = 4; // error codes 0..255 in grades of 16
inline constexpr std::uint32_t wheel_count = 8, wheel_buckets = 64, first_wheel_ticks = 56;
inline constexpr std::uint64_t rewind_tick = std::uint64_t{1} << 32;
inline constexpr double charge_rounding = 0x1p-20; // share of a way that an odometer may lose
inline constexpr std::uint32_t rank_count = 32;    // of work: 16 by screen error, and 16 more for what a frustum shows

[[nodiscard]] inline std::uint32_t grade_of(std::uint32_t code) {
    return code >> grade_codes_log2;
}

// Numbers of lists.
using ListId = std::uint16_t;
inline constexpr ListId calendar_lists = grade_count * wheel_count * wheel_buckets;
inline constexpr ListId soon_lists = calendar_lists;                 // one a grade: due with the next movement
inline constexpr ListId due_lists = soon_lists + grade_count;        // one a grade: to be evaluated
inline constexpr ListId work_lists = due_lists + grade_count;        // queues, one a rank: vertices to activate
inline constexpr ListId deactivation_list = work_lists + rank_count; // vertices to deactivate
inline constexpr ListId blocked_lists = deactivation_list + 1;       // for want of a capacity; two that take turns
inline constexpr ListId gated_lists = blocked_lists + 2; // behind a vertex that is morphing; two that take turns
inline constexpr ListId list_count = gated_lists + 2;
inline constexpr ListId queue_count = list_count - work_lists;
inline constexpr ListId being_visited = 0xfffe; // taken from its list, about to be evaluated
inline constexpr ListId unlisted = 0xffff;

struct Bucket {
    std::uint32_t top, bottom; // nodes; all below the top are full
    std::uint32_t full;        // how many those are
    std::uint32_t in_top;      // groups; kept here, so that one more is a store to its line and no load
};

// Of a grade: full nodes, first come first, and one that fills up.
struct DueGroups {
    std::uint32_t first, last, filling;
};

struct Lists {
    GroupState* groups;
    std::uint32_t group_count;
    Link* queues; // queue_count: a queue's first and last group are its head's next and prev
    ListNode* nodes;
    std::uint32_t free_node;                      // a stack through ListNode::next
    Bucket* buckets;                              // due_lists
    std::uint32_t sizes[list_count - soon_lists]; // of the lists after the calendar
    DueGroups due[grade_count];
    std::uint64_t filled[grade_count][wheel_count]; // buckets that may hold groups
    double odometer_m[grade_count];
    std::uint64_t tick[grade_count];
    std::uint64_t moves[grade_count]; // times that it was advanced
    double tick_m, ticks_per_m;       // powers of 2: products with them are exact
};

[[nodiscard]] constexpr std::uint32_t list_node_count(std::uint32_t group_count) {
    return group_count / node_groups + due_lists + grade_count + 1;
}

void set_tick(Lists& lists, double about_m); // rounded down to a power of 2
void clear_lists(Lists& lists, std::uint32_t node_count);

[[nodiscard]] ListId list_of(const Lists& lists, std::uint32_t group);            // or unlisted
[[nodiscard]] inline std::uint32_t size(const Lists& lists, std::uint32_t list) { // not of the calendar's
    return lists.sizes[list - soon_lists];
}

// The group must be in no list.
void push_back(Lists& lists, std::uint32_t queue, std::uint32_t group);
void push_front(Lists& lists, std::uint32_t queue, std::uint32_t group);
void push_due(Lists& lists, std::uint32_t grade, std::uint32_t group);
// Takes a group from whatever list it is in, but not from due groups.
void unlink(Lists& lists, std::uint32_t group);
// The list must not be empty.
[[nodiscard]] std::uint32_t pop_front(Lists& lists, std::uint32_t queue);
// With each group, one a node later is passed to prefetch().
template <typename Prefetch>
[[nodiscard]] std::uint32_t pop_due(Lists& lists, std::uint32_t grade, const Prefetch& prefetch) {
    FJELL_ASSERT(size(lists, due_lists + grade) != 0);
    DueGroups& due = lists.due[grade];
    const std::uint32_t at = due.first != no_index ? due.first : due.filling;
    ListNode& node = lists.nodes[at];
    const std::uint32_t group = node.groups[--node.count];
    if (const std::uint32_t next = node.next != no_index ? node.next : due.filling; next != no_index && next != at) {
        const ListNode& after = lists.nodes[next];
        if (node.count < after.count) prefetch(after.groups[node.count]);
        if (after.next != no_index && node.count == node_groups / 2) __builtin_prefetch(&lists.nodes[after.next]);
    }
    --lists.sizes[due_lists + grade - soon_lists];
    if (node.count != 0) return group;
    if (due.first != no_index)
        due.first = node.next;
    else
        due.filling = no_index;
    node.next = lists.free_node;
    lists.free_node = at;
    return group;
}
// Forgets due groups numbered first to first + count - 1. O(due groups).
void forget_due(Lists& lists, std::uint32_t first, std::uint32_t count);

// The group, in no list, must be evaluated when the odometer of its grade has gone slack_m further.
void schedule(Lists& lists, std::uint32_t group, float slack_m, std::uint32_t grade);
// The same for one more vertex of a group that may be scheduled already: the earlier time and the higher grade win.
// Groups in other lists stay there: they will be visited anyway.
void tighten(Lists& lists, std::uint32_t group, float slack_m, std::uint32_t grade);

// Moves an odometer on by at least (1 - charge_rounding) of the way; groups whose time has come become due. O(groups)
// once in rewind_tick.
void advance(Lists& lists, std::uint32_t grade, double metres);

} // namespace fjell
