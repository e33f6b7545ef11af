#include "cut/validate_parts.h"

namespace fjell {

namespace {

Violation check_queue(const Queues& q, std::uint32_t queue, Tally& queued) {
    const std::uint32_t head = q.group_count + queue;
    std::uint32_t count = 0, before = head;
    for (std::uint32_t group = q.ends[queue].next; group != head; group = q.nodes[group].link.next) {
        if (group >= q.group_count || ++count > q.sizes[queue]) return {"a queue goes elsewhere"};
        if (q.groups[group].queue != queue) return {"a group is in a queue, and says otherwise"};
        if (q.nodes[group].link.prev != before) return {"a queue's links disagree"};
        queued.add(group);
        before = group;
    }
    if (q.ends[queue].prev != before) return {"a queue's links disagree"};
    return count == q.sizes[queue] ? Violation{} : Violation{"a queue counts its groups wrongly"};
}

Violation check_page(const Schedule& s, const Queues& q, std::uint32_t slot) {
    const PageSchedule& page = s.pages[slot];
    const std::uint16_t* const ticks = s.ticks + std::size_t{slot} * page_ticks;
    std::uint32_t queued = 0;
    for (std::uint32_t n = 0; n < max_page_groups; ++n)
        queued += q.groups[slot * max_page_groups + n].queue != unqueued;
    for (std::uint32_t n = 0; n < page_ticks; ++n) {
        if (ticks[n] == unscheduled) continue;
        if (n >= max_page_groups) return {"a group is scheduled that there is not"};
        if (q.groups[slot * max_page_groups + n].queue != unqueued) return {"a group is scheduled, and in a queue"};
    }
    const std::uint16_t least = scalar_ticks.least(ticks);
    if (page.awake == no_index)
        return least == unscheduled && queued == 0 ? Violation{} : Violation{"a page sleeps with groups to watch"};
    if (page.awake >= s.awake_count || s.awake[page.awake].slot != slot) return {"a page is awake elsewhere"};
    const AwakePage& awake = s.awake[page.awake];
    if (awake.level != page.level) return {"a page is watched at another level than its own"};
    if (awake.queued != queued) return {"a page counts wrongly what of it is in queues"};
    if (awake.due) return {};
    const double one_m = tick_m(s, page);
    const double latest_m = least <= soon ? s.odometer_m[awake.grade] : page.charged_m + (least - soon) * one_m;
    if (least != unscheduled && awake.due_m > latest_m + one_m / 1024) return {"a page comes up later than its groups"};
    if (s.odometer_m[awake.grade] > awake.due_m + one_m * 1.001) return {"a page's time has come, and it is not due"};
    return {};
}

Violation check_due(const Schedule& s, Tally& listed) {
    std::uint32_t count = 0;
    for (std::uint32_t level = 0; level < due_level_count; ++level) {
        if ((s.due_levels >> level & 1) == 0) continue;
        std::uint32_t last = no_index;
        for (std::uint32_t slot = s.due[level].first; slot != no_index; slot = s.next_due[slot]) {
            if (slot >= s.slot_count || ++count > s.due_count) return {"due pages go round in a circle"};
            if (!is_due(s, slot) || s.pages[slot].level != level) return {"a page is due, and says otherwise"};
            listed.add(slot);
            last = slot;
        }
        if (last == no_index || s.due[level].last != last) return {"the last due page is cut off"};
    }
    return count == s.due_count ? Violation{} : Violation{"due pages are counted wrongly"};
}

} // namespace

Violation validate_queues(const Queues& q) {
    Tally queued, say_so;
    for (std::uint32_t queue = 0; queue < queue_count; ++queue)
        if (const Violation wrong = check_queue(q, queue, queued)) return wrong;
    for (std::uint32_t group = 0; group < q.group_count; ++group) {
        if (q.groups[group].queue == unqueued) continue;
        if (q.groups[group].queue >= queue_count) return {"a group was taken from its queue and not put back"};
        say_so.add(group);
    }
    return queued == say_so ? Violation{} : Violation{"a group is in two queues, or lost from the one it says"};
}

Violation validate_schedule(const Schedule& s, const Queues& q) {
    Tally listed, say_so;
    std::uint32_t awake = 0;
    for (std::uint32_t slot = 0; slot < s.slot_count; ++slot) {
        if (const Violation wrong = check_page(s, q, slot)) return wrong;
        awake += s.pages[slot].awake != no_index;
        if (is_due(s, slot)) say_so.add(slot);
    }
    if (awake != s.awake_count) return {"awake pages do not add up"};
    if (const Violation wrong = check_due(s, listed)) return wrong;
    return listed == say_so ? Violation{} : Violation{"a page is due twice, or lost from the due pages"};
}

} // namespace fjell
