// Queues of work: groups just evaluated whose lanes call for changes. Linked through a node of each group, so they
// cannot run out of room.
#pragma once

#include <cstddef>
#include <cstdint>

namespace fjell {

struct GroupState;
struct Schedule;

struct Link { // the queue's next and previous group; its head has the number after the last group, and so on
    std::uint32_t next, prev;
};

// Of a group, apart from its state, because few groups wait.
struct QueueNode {
    Link link;
    std::uint32_t calls; // lanes that call for work, activations in the lower half; a hint what to prefetch
};

inline constexpr std::uint32_t rank_count = 32; // of work: 16 by screen error, and 16 more for what a frustum shows

using QueueId = std::uint16_t;
inline constexpr QueueId unqueued = 0;                                  // so that a group of zeros is in none
inline constexpr QueueId work_queues = 1;                               // one a rank: vertices to activate
inline constexpr QueueId deactivation_queue = work_queues + rank_count; // vertices to deactivate
inline constexpr QueueId blocked_queues = deactivation_queue + 1;       // for want of a capacity; two that take turns
inline constexpr QueueId gated_queues = blocked_queues + 2; // behind a vertex that is morphing; two that take turns
inline constexpr QueueId queue_count = gated_queues + 2;
inline constexpr QueueId being_visited = 0xfffe; // taken from its queue, about to be evaluated

struct Queues {
    GroupState* groups;
    QueueNode* nodes; // one a group
    std::uint32_t group_count;
    Link ends[queue_count]; // first and last group
    std::uint32_t sizes[queue_count];
    Schedule* schedule;       // which counts what waits in a page
    std::uint32_t work_ranks; // which work_queues may hold groups, as bits
    std::uint32_t turn;       // which of blocked_queues takes what is put back
    std::uint32_t gated_turn; // and of gated_queues
    // Passes over the gated groups that are due, because a vertex has reached its height or is no longer evicted. A
    // pass may take several frames; groups that were filed before the event may lie in either list.
    std::uint8_t gate_passes;
};

void clear_queues(Queues& queues); // the groups' own states aside

// The group must be in no queue.
void push_back(Queues& queues, std::uint32_t queue, std::uint32_t group);
void push_front(Queues& queues, std::uint32_t queue, std::uint32_t group);
// Takes a group from whatever queue it is in.
void unlink(Queues& queues, std::uint32_t group);
// The queue must not be empty.
[[nodiscard]] std::uint32_t pop_front(Queues& queues, std::uint32_t queue);

} // namespace fjell
