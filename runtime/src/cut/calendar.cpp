#include "cut/calendar.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "cut/state.h"

namespace fjell {

namespace {

constexpr std::uint64_t last_tick = std::uint64_t{first_wheel_ticks} << (3 * (wheel_count - 1)); // of any slack

std::uint32_t bucket_of(std::uint32_t grade, std::uint32_t wheel, std::uint64_t bucket) {
    return (grade * wheel_count + wheel) * wheel_buckets + static_cast<std::uint32_t>(bucket % wheel_buckets);
}

// A queue's head has the number after the last group, and so on.
Link& link(Lists& lists, std::uint32_t node) {
    return node < lists.group_count ? lists.groups[node].link : lists.queues[node - lists.group_count];
}

std::uint64_t due_tick(const GroupState& b) {
    return std::uint64_t{b.due_high} << 32 | b.due;
}

// Whoever puts a group in a list has taken it from the one before: in two it would be visited twice, and then never.
[[maybe_unused]] bool is_in_no_list(const GroupState& b) {
    return b.list == unlisted || b.list == being_visited;
}

std::uint32_t take_node(Lists& lists, std::uint32_t next) {
    FJELL_ASSERT(lists.free_node != no_index); // there are as many as all groups can need
    const std::uint32_t node = lists.free_node;
    lists.free_node = lists.nodes[node].next;
    lists.nodes[node].next = next;
    lists.nodes[node].count = 0;
    return node;
}
void give_node(Lists& lists, std::uint32_t node) {
    lists.nodes[node].next = lists.free_node;
    lists.free_node = node;
}

void push_bucket(Lists& lists, std::uint32_t number, std::uint32_t group) {
    FJELL_ASSERT(is_in_no_list(lists.groups[group]));
    Bucket& bucket = lists.buckets[number];
    if (bucket.top == no_index) {
        bucket.top = bucket.bottom = take_node(lists, no_index);
    } else if (bucket.in_top == node_groups) {
        lists.nodes[bucket.top].count = node_groups;
        bucket.top = take_node(lists, bucket.top);
        bucket.in_top = 0;
        ++bucket.full;
    }
    GroupState& b = lists.groups[group];
    b.link = {bucket.top, bucket.in_top};
    b.list = static_cast<ListId>(number);
    lists.nodes[bucket.top].groups[bucket.in_top++] = group;
}

// The bucket's newest group takes its place.
void leave_bucket(Lists& lists, std::uint32_t group) {
    const GroupState& b = lists.groups[group];
    Bucket& bucket = lists.buckets[b.list];
    FJELL_ASSERT(bucket.top != no_index && lists.nodes[b.link.next].groups[b.link.prev] == group);
    const std::uint32_t moved = lists.nodes[bucket.top].groups[--bucket.in_top];
    if (moved != group) {
        lists.nodes[b.link.next].groups[b.link.prev] = moved;
        lists.groups[moved].link = b.link;
    }
    if (bucket.in_top != 0) return;
    const std::uint32_t below = lists.nodes[bucket.top].next;
    give_node(lists, bucket.top);
    bucket.top = below;
    if (below == no_index) return;
    bucket.in_top = node_groups;
    --bucket.full;
}

// Full nodes, from the first to the last of a chain.
void append_full(Lists& lists, std::uint32_t grade, std::uint32_t first, std::uint32_t last) {
    DueGroups& due = lists.due[grade];
    lists.nodes[last].next = no_index;
    if (due.first == no_index)
        due.first = first;
    else
        lists.nodes[due.last].next = first;
    due.last = last;
}

void add_due(Lists& lists, std::uint32_t grade, std::uint32_t group) {
    DueGroups& due = lists.due[grade];
    if (due.filling == no_index) due.filling = take_node(lists, no_index);
    ListNode& node = lists.nodes[due.filling];
    node.groups[node.count++] = group;
    if (node.count < node_groups) return;
    append_full(lists, grade, due.filling, due.filling);
    due.filling = no_index;
}

// Everything in a bucket becomes due, in O(1): full nodes as they are, the rest one by one.
void drain(Lists& lists, std::uint32_t grade, std::uint32_t number) {
    const Bucket bucket = std::exchange(lists.buckets[number], {no_index, no_index, 0, 0});
    if (bucket.top == no_index) return;
    const ListNode top = lists.nodes[bucket.top];
    lists.sizes[due_lists + grade - soon_lists] += bucket.full * node_groups + bucket.in_top;
    for (std::uint32_t i = 0; i < bucket.in_top; ++i) add_due(lists, grade, top.groups[i]);
    give_node(lists, bucket.top);
    if (bucket.full != 0) append_full(lists, grade, top.next, bucket.bottom);
}

} // namespace

void set_tick(Lists& lists, double about_m) {
    int exponent = 0;
    (void)std::frexp(about_m, &exponent);
    lists.tick_m = std::ldexp(1.0, exponent - 1);
    lists.ticks_per_m = std::ldexp(1.0, 1 - exponent);
}

void clear_lists(Lists& lists, std::uint32_t node_count) {
    for (std::uint32_t i = 0; i < queue_count; ++i) lists.queues[i] = {lists.group_count + i, lists.group_count + i};
    for (std::uint32_t i = 0; i < due_lists; ++i) lists.buckets[i] = {no_index, no_index, 0, 0};
    for (std::uint32_t& n : lists.sizes) n = 0;
    for (DueGroups& due : lists.due) due = {no_index, no_index, no_index};
    for (auto& wheels : lists.filled)
        for (std::uint64_t& w : wheels) w = 0;
    for (std::uint32_t i = 0; i < node_count; ++i) lists.nodes[i].next = i + 1 < node_count ? i + 1 : no_index;
    lists.free_node = 0;
}

ListId list_of(const Lists& lists, std::uint32_t group) {
    const GroupState& b = lists.groups[group];
    if (b.list >= due_lists) return b.list;
    bool moved = false;
    if (b.list >= soon_lists) {
        moved = due_tick(b) != lists.moves[b.grade];
    } else {
        const std::uint32_t shift = 3 * (b.list / wheel_buckets % wheel_count);
        moved = due_tick(b) >> shift <= lists.tick[b.grade] >> shift;
    }
    return moved ? static_cast<ListId>(due_lists + b.grade) : b.list;
}

void push_back(Lists& lists, std::uint32_t queue, std::uint32_t group) {
    GroupState& b = lists.groups[group];
    FJELL_ASSERT(is_in_no_list(b));
    const std::uint32_t head = lists.group_count + queue - work_lists;
    Link& ends = lists.queues[queue - work_lists];
    b.link = {head, ends.prev};
    link(lists, ends.prev).next = group;
    ends.prev = group;
    b.list = static_cast<ListId>(queue);
    ++lists.sizes[queue - soon_lists];
}

void push_front(Lists& lists, std::uint32_t queue, std::uint32_t group) {
    GroupState& b = lists.groups[group];
    FJELL_ASSERT(is_in_no_list(b));
    Link& ends = lists.queues[queue - work_lists];
    b.link = {ends.next, lists.group_count + queue - work_lists};
    link(lists, ends.next).prev = group;
    ends.next = group;
    b.list = static_cast<ListId>(queue);
    ++lists.sizes[queue - soon_lists];
}

void push_due(Lists& lists, std::uint32_t grade, std::uint32_t group) {
    GroupState& b = lists.groups[group];
    FJELL_ASSERT(is_in_no_list(b));
    b.grade = static_cast<std::uint8_t>(grade);
    b.list = static_cast<ListId>(due_lists + grade);
    ++lists.sizes[due_lists + grade - soon_lists];
    add_due(lists, grade, group);
}

void unlink(Lists& lists, std::uint32_t group) {
    GroupState& b = lists.groups[group];
    if (b.list == unlisted) return;
    FJELL_ASSERT(list_of(lists, group) < due_lists || list_of(lists, group) >= work_lists); // due groups have no links
    if (b.list < due_lists) {
        leave_bucket(lists, group);
    } else {
        FJELL_ASSERT(b.list < list_count && size(lists, b.list) != 0);
        FJELL_ASSERT(link(lists, b.link.prev).next == group && link(lists, b.link.next).prev == group);
        --lists.sizes[b.list - soon_lists];
        link(lists, b.link.prev).next = b.link.next;
        link(lists, b.link.next).prev = b.link.prev;
    }
    b.list = unlisted;
}

std::uint32_t pop_front(Lists& lists, std::uint32_t queue) {
    const std::uint32_t group = lists.queues[queue - work_lists].next;
    unlink(lists, group);
    return group;
}

void forget_due(Lists& lists, std::uint32_t first, std::uint32_t count) {
    for (std::uint32_t grade = 0; grade < grade_count; ++grade) {
        DueGroups old = lists.due[grade];
        lists.due[grade] = {no_index, no_index, no_index};
        if (old.filling != no_index) {
            lists.nodes[old.filling].next = no_index;
            if (old.first == no_index)
                old.first = old.filling;
            else
                lists.nodes[old.last].next = old.filling;
        }
        for (std::uint32_t node = old.first; node != no_index;) {
            const ListNode c = lists.nodes[node];
            give_node(lists, node);
            for (std::uint32_t i = 0; i < c.count; ++i) {
                if (c.groups[i] - first < count)
                    --lists.sizes[due_lists + grade - soon_lists];
                else
                    add_due(lists, grade, c.groups[i]);
            }
            node = c.next;
        }
    }
}

void schedule(Lists& lists, std::uint32_t group, float slack_m, std::uint32_t grade) {
    GroupState& b = lists.groups[group];
    b.grade = static_cast<std::uint8_t>(grade);
    const double ticks = std::min(static_cast<double>(slack_m) * lists.ticks_per_m, static_cast<double>(last_tick - 1));
    const auto due = static_cast<std::uint64_t>(lists.odometer_m[grade] * lists.ticks_per_m + ticks);
    const std::uint64_t now = lists.tick[grade];
    const bool soon = due <= now;
    const std::uint64_t stored = soon ? lists.moves[grade] : due;
    FJELL_ASSERT(stored >> 48 == 0); // what a group keeps of it; a tick that wraps would be due in years
    b.due = static_cast<std::uint32_t>(stored);
    b.due_high = static_cast<std::uint16_t>(stored >> 32);
    if (soon) return push_bucket(lists, soon_lists + grade, group);
    // 56 ticks and more go to the second wheel, 448 to the third ...
    const auto wheel = std::min((static_cast<std::uint32_t>(std::bit_width((due - now) / first_wheel_ticks)) + 2) / 3,
                                wheel_count - 1);
    const std::uint64_t bucket = due >> (3 * wheel);
    lists.filled[grade][wheel] |= std::uint64_t{1} << (bucket % wheel_buckets);
    push_bucket(lists, bucket_of(grade, wheel, bucket), group);
}

void tighten(Lists& lists, std::uint32_t group, float slack_m, std::uint32_t grade) {
    const GroupState& b = lists.groups[group];
    if (b.list == unlisted) return schedule(lists, group, slack_m, grade);
    const ListId list = list_of(lists, group);
    if (list >= due_lists) return;
    // Ticks are whole: what is left lies between two bounds, and each is used where it errs on the safe side.
    const std::uint64_t ticks = list >= soon_lists ? 0 : due_tick(b) - lists.tick[b.grade];
    if (static_cast<double>(ticks) * lists.tick_m <= static_cast<double>(slack_m) && grade <= b.grade) return;
    const double left_m = ticks == 0 ? 0 : static_cast<double>(ticks - 1) * lists.tick_m;
    const std::uint32_t highest = std::max<std::uint32_t>(grade, b.grade);
    unlink(lists, group);
    schedule(lists, group, static_cast<float>(std::min(left_m, static_cast<double>(slack_m))), highest);
}

namespace {

// The odometer begins again at 0. Due groups have to know their list now: no tick tells any more.
void rewind(Lists& lists, std::uint32_t grade) {
    drain(lists, grade, soon_lists + grade);
    for (std::uint32_t wheel = 0; wheel < wheel_count; ++wheel) {
        for (std::uint64_t bucket = 0; bucket < wheel_buckets; ++bucket)
            drain(lists, grade, bucket_of(grade, wheel, bucket));
        lists.filled[grade][wheel] = 0;
    }
    const auto mark = [&](std::uint32_t node) {
        for (std::uint32_t i = 0; i < lists.nodes[node].count; ++i)
            lists.groups[lists.nodes[node].groups[i]].list = static_cast<ListId>(due_lists + grade);
    };
    const DueGroups& due = lists.due[grade];
    for (std::uint32_t node = due.first; node != no_index; node = lists.nodes[node].next) mark(node);
    if (due.filling != no_index) mark(due.filling);
    lists.odometer_m[grade] = 0;
    lists.tick[grade] = lists.moves[grade] = 0;
}

// a + b, rounded up where more than charge_rounding of b would be lost.
double sum(double a, double b) {
    const double nearest = a + b;
    return nearest - a < b * (1 - charge_rounding) ? std::nextafter(nearest, 1e300) : nearest;
}

} // namespace

void advance(Lists& lists, std::uint32_t grade, double metres) {
    if (!(metres > 0)) return;
    const std::uint64_t before = lists.tick[grade];
    if (before >= rewind_tick) return rewind(lists, grade);
    const double most_m = static_cast<double>(last_tick) * lists.tick_m; // more than any slack
    lists.odometer_m[grade] = sum(lists.odometer_m[grade], std::min(metres, most_m));
    lists.tick[grade] = static_cast<std::uint64_t>(lists.odometer_m[grade] * lists.ticks_per_m);
    FJELL_ASSERT(lists.tick[grade] >= before); // or what is due already would wait for another round
    ++lists.moves[grade];
    drain(lists, grade, soon_lists + grade);
    for (std::uint32_t wheel = 0; wheel < wheel_count; ++wheel) {
        if (lists.filled[grade][wheel] == 0) continue;
        const std::uint64_t first = (before >> (3 * wheel)) + 1, last = lists.tick[grade] >> (3 * wheel);
        const std::uint64_t n = std::min<std::uint64_t>(last + 1 - first, wheel_buckets);
        for (std::uint64_t bucket = first; bucket < first + n; ++bucket) {
            const std::uint64_t bit = std::uint64_t{1} << (bucket % wheel_buckets);
            if ((lists.filled[grade][wheel] & bit) == 0) continue;
            lists.filled[grade][wheel] &= ~bit;
            drain(lists, grade, bucket_of(grade, wheel, bucket));
        }
    }
}

} // namespace fjell
