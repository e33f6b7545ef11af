#include "cut/queues.h"

#include "cut/state.h"

namespace fjell {

namespace {

Link& link(Queues& queues, std::uint32_t number) {
    return number < queues.group_count ? queues.nodes[number].link : queues.ends[number - queues.group_count];
}

// Whoever queues a group has taken it from the queue before: in two it would be visited twice, and then never.
[[maybe_unused]] bool is_in_no_queue(const GroupState& b) {
    return b.queue == unqueued || b.queue == being_visited;
}

void insert(Queues& queues, std::uint32_t queue, std::uint32_t group, Link between) {
    GroupState& b = queues.groups[group];
    FJELL_ASSERT(is_in_no_queue(b));
    queues.nodes[group].link = between;
    link(queues, between.prev).next = group;
    link(queues, between.next).prev = group;
    b.queue = static_cast<QueueId>(queue);
    ++queues.sizes[queue];
    count_queued(*queues.schedule, group / max_page_groups, 1);
}

} // namespace

void clear_queues(Queues& queues) {
    for (std::uint32_t i = 0; i < queue_count; ++i) {
        queues.ends[i] = {queues.group_count + i, queues.group_count + i};
        queues.sizes[i] = 0;
    }
}

void push_back(Queues& queues, std::uint32_t queue, std::uint32_t group) {
    insert(queues, queue, group, {queues.group_count + queue, queues.ends[queue].prev});
}

void push_front(Queues& queues, std::uint32_t queue, std::uint32_t group) {
    insert(queues, queue, group, {queues.ends[queue].next, queues.group_count + queue});
}

void unlink(Queues& queues, std::uint32_t group) {
    GroupState& b = queues.groups[group];
    if (b.queue == unqueued) return;
    FJELL_ASSERT(b.queue < queue_count && queues.sizes[b.queue] != 0);
    const Link between = queues.nodes[group].link;
    FJELL_ASSERT(link(queues, between.prev).next == group && link(queues, between.next).prev == group);
    --queues.sizes[b.queue];
    link(queues, between.prev).next = between.next;
    link(queues, between.next).prev = between.prev;
    b.queue = unqueued;
    count_queued(*queues.schedule, group / max_page_groups, -1);
}

std::uint32_t pop_front(Queues& queues, std::uint32_t queue) {
    const std::uint32_t group = queues.ends[queue].next;
    unlink(queues, group);
    return group;
}

} // namespace fjell
