#include "cut/validate_parts.h"

namespace fjell {

namespace {

// What has been found in lists so far.
struct Found {
    Tally groups;
    std::uint32_t nodes = 0;
};

Violation check_bucket(const Lists& l, std::uint32_t number, Found& found) {
    const Bucket& bucket = l.buckets[number];
    if (bucket.in_top < 1 || bucket.in_top > node_groups) return {"a bucket's top node is empty"};
    if (number < soon_lists) {
        const std::uint32_t grade = number / (wheel_count * wheel_buckets),
                            wheel = number / wheel_buckets % wheel_count;
        if ((l.filled[grade][wheel] >> number % wheel_buckets & 1) == 0)
            return {"a bucket holds groups, and nobody will look at it"};
    }
    std::uint32_t nodes = 0, last = no_index;
    for (std::uint32_t node = bucket.top; node != no_index; node = l.nodes[node].next) {
        if (node >= list_node_count(l.group_count) || ++nodes > bucket.full + 1)
            return {"a bucket has more nodes than it counts"};
        const std::uint32_t count = nodes == 1 ? bucket.in_top : node_groups;
        for (std::uint32_t i = 0; i < count; ++i) {
            const std::uint32_t group = l.nodes[node].groups[i];
            if (group >= l.group_count) return {"a bucket holds a group that there is not"};
            const GroupState& b = l.groups[group];
            if (b.list != number || b.link.next != node || b.link.prev != i)
                return {"a group lies elsewhere than it says"};
            if (list_of(l, group) != number) return {"a group whose time has come is still in its bucket"};
            found.groups.add(group);
        }
        last = node;
    }
    found.nodes += nodes;
    return nodes == bucket.full + 1 && last == bucket.bottom ? Violation{}
                                                             : Violation{"a bucket counts its nodes wrongly"};
}

Violation check_due_node(const Lists& l, std::uint32_t grade, std::uint32_t node, std::uint32_t& count, Found& found) {
    const ListNode& n = l.nodes[node];
    if (n.count < 1 || n.count > node_groups) return {"a node of due groups is empty"};
    for (std::uint32_t i = 0; i < n.count; ++i) {
        if (n.groups[i] >= l.group_count || list_of(l, n.groups[i]) != due_lists + grade)
            return {"a group is due, and says otherwise"};
        found.groups.add(n.groups[i]);
    }
    count += n.count;
    ++found.nodes;
    return {};
}

Violation check_due(const Lists& l, std::uint32_t grade, Found& found) {
    const DueGroups& due = l.due[grade];
    std::uint32_t count = 0, last = no_index;
    for (std::uint32_t node = due.first; node != no_index; last = node, node = l.nodes[node].next) {
        if (node >= list_node_count(l.group_count) || count > l.group_count) return {"due groups go round in a circle"};
        if (const Violation wrong = check_due_node(l, grade, node, count, found)) return wrong;
    }
    if (due.first != no_index && last != due.last) return {"the last due groups are cut off"};
    if (due.filling != no_index)
        if (const Violation wrong = check_due_node(l, grade, due.filling, count, found)) return wrong;
    return count == size(l, due_lists + grade) ? Violation{} : Violation{"due groups are counted wrongly"};
}

Violation check_queue(const Lists& l, std::uint32_t queue, Found& found) {
    const std::uint32_t head = l.group_count + queue - work_lists;
    std::uint32_t count = 0, before = head;
    for (std::uint32_t group = l.queues[queue - work_lists].next; group != head; group = l.groups[group].link.next) {
        if (group >= l.group_count || ++count > size(l, queue)) return {"a queue goes elsewhere"};
        if (l.groups[group].list != queue) return {"a group is in a queue, and says otherwise"};
        if (l.groups[group].link.prev != before) return {"a queue's links disagree"};
        found.groups.add(group);
        before = group;
    }
    if (l.queues[queue - work_lists].prev != before) return {"a queue's links disagree"};
    return count == size(l, queue) ? Violation{} : Violation{"a queue counts its groups wrongly"};
}

} // namespace

Violation validate_lists(const Lists& l) {
    Found found;
    for (std::uint32_t number = 0; number < due_lists; ++number)
        if (l.buckets[number].top != no_index)
            if (const Violation wrong = check_bucket(l, number, found)) return wrong;
    for (std::uint32_t grade = 0; grade < grade_count; ++grade)
        if (const Violation wrong = check_due(l, grade, found)) return wrong;
    for (std::uint32_t queue = work_lists; queue < list_count; ++queue)
        if (const Violation wrong = check_queue(l, queue, found)) return wrong;
    Tally listed;
    for (std::uint32_t group = 0; group < l.group_count; ++group) {
        const ListId list = list_of(l, group);
        if (list == unlisted) continue;
        if (list >= list_count) return {"a group was taken from its list and not put back"};
        listed.add(group);
    }
    if (!(listed == found.groups)) return {"a group is in two lists, or lost from the one it says"};
    const std::uint32_t nodes = list_node_count(l.group_count);
    for (std::uint32_t node = l.free_node; node != no_index; node = l.nodes[node].next)
        if (node >= nodes || ++found.nodes > nodes) return {"a free node is used, or free twice"};
    return found.nodes == nodes ? Violation{} : Violation{"a node is lost"};
}

} // namespace fjell
