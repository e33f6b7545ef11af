#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "cut/schedule.cpp"
#include <hwy/foreach_target.h> // includes this file once a target

#include <hwy/highway.h>

#include "cut/pages.h"
#include "cut/schedule.h"

HWY_BEFORE_NAMESPACE();
namespace fjell::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using U = hn::CappedTag<std::uint16_t, 16>;

void charge_ticks(std::uint16_t* ticks, std::uint16_t by) {
    const U d;
    const auto less = hn::Set(d, by), never = hn::Set(d, unscheduled), last = hn::Set(d, soon);
    for (std::size_t i = 0; i < page_ticks; i += hn::Lanes(d)) {
        const auto before = hn::LoadU(d, ticks + i), left = hn::SaturatedSub(before, less);
        const auto after = hn::IfThenElseZero(hn::Ne(hn::Max(left, last), last), left);
        hn::StoreU(hn::IfThenElse(hn::Eq(before, never), never, after), d, ticks + i);
    }
}

void spent_bits(const std::uint16_t* ticks, std::uint16_t last, std::uint64_t* bits) {
    const U d;
    const auto most = hn::Set(d, last);
    for (std::size_t i = 0; i < page_words; ++i) bits[i] = 0;
    for (std::size_t i = 0; i < page_ticks; i += hn::Lanes(d)) {
        std::uint8_t bytes[8] = {};
        hn::StoreMaskBits(d, hn::Eq(hn::Max(hn::LoadU(d, ticks + i), most), most), bytes);
        const std::uint64_t found = bytes[0] | std::uint64_t{bytes[1]} << 8;
        bits[i / 64] |= found << i % 64;
    }
}

std::uint16_t least_ticks(const std::uint16_t* ticks) {
    const U d;
    auto least = hn::Set(d, unscheduled);
    for (std::size_t i = 0; i < page_ticks; i += hn::Lanes(d)) least = hn::Min(least, hn::LoadU(d, ticks + i));
    alignas(64) std::uint16_t lanes[16];
    hn::StoreU(least, d, lanes);
    std::uint16_t out = unscheduled;
    for (std::size_t i = 0; i < hn::Lanes(d); ++i) out = lanes[i] < out ? lanes[i] : out;
    return out;
}

} // namespace fjell::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

namespace fjell {

HWY_EXPORT(charge_ticks);
HWY_EXPORT(least_ticks);
HWY_EXPORT(spent_bits);

namespace {

void charge_vector(std::uint16_t* ticks, std::uint16_t by) {
    HWY_DYNAMIC_DISPATCH(charge_ticks)(ticks, by);
}
void spent_vector(const std::uint16_t* ticks, std::uint16_t last, std::uint64_t* bits) {
    HWY_DYNAMIC_DISPATCH(spent_bits)(ticks, last, bits);
}
std::uint16_t least_vector(const std::uint16_t* ticks) {
    return HWY_DYNAMIC_DISPATCH(least_ticks)(ticks);
}

void wake(Schedule& s, std::uint32_t slot, std::uint32_t grade) {
    PageSchedule& page = s.pages[slot];
    FJELL_ASSERT(page.awake == no_index && s.awake_count < s.slot_count);
    page.charged_m = page.seen_m = s.odometer_m[grade];
    page.awake = s.awake_count;
    s.awake[s.awake_count++] = {never_m, slot, static_cast<std::uint8_t>(grade), page.level, false, 0};
}
void sleep(Schedule& s, std::uint32_t slot) {
    PageSchedule& page = s.pages[slot];
    const AwakePage last = s.awake[--s.awake_count];
    s.awake[page.awake] = last;
    s.pages[last.slot].awake = page.awake;
    page.awake = no_index;
}

// What it has travelled since it was charged stays; from now on it is charged by the higher grade.
void raise_grade(Schedule& s, PageSchedule& page, AwakePage& awake, std::uint32_t grade) {
    const double by_m = s.odometer_m[grade] - s.odometer_m[awake.grade];
    page.charged_m += by_m;
    page.seen_m += by_m;
    if (awake.due_m < never_m) awake.due_m += by_m;
    awake.grade = static_cast<std::uint8_t>(grade);
}

void push_due(Schedule& s, AwakePage& page) {
    page.due = true;
    page.due_m = never_m;
    s.next_due[page.slot] = no_index;
    DuePages& due = s.due[page.level];
    if (s.due_levels >> page.level & 1)
        s.next_due[due.last] = page.slot;
    else
        due.first = page.slot;
    due.last = page.slot;
    s.due_levels |= 1u << page.level;
    ++s.due_count;
}

void take_from_due(Schedule& s, AwakePage& page) {
    DuePages& due = s.due[page.level];
    std::uint32_t before = no_index, at = due.first;
    while (at != page.slot) before = std::exchange(at, s.next_due[at]);
    (before == no_index ? due.first : s.next_due[before]) = s.next_due[page.slot];
    if (due.last == page.slot) due.last = before;
    if (due.first == no_index) s.due_levels &= ~(1u << page.level);
    --s.due_count;
    page.due = false;
}

// a + b, rounded up where more than charge_rounding of b would be lost.
double sum(double a, double b) {
    const double nearest = a + b;
    return nearest - a < b * (1 - charge_rounding) ? std::nextafter(nearest, 1e300) : nearest;
}

// The odometer begins again at 0, and all times of its grade with it.
void rewind(Schedule& s, std::uint32_t grade) {
    const double by_m = s.odometer_m[grade];
    for (std::uint32_t i = 0; i < s.awake_count; ++i) {
        AwakePage& awake = s.awake[i];
        if (awake.grade != grade) continue;
        s.pages[awake.slot].charged_m -= by_m;
        s.pages[awake.slot].seen_m -= by_m;
        if (awake.due_m < never_m) awake.due_m -= by_m;
    }
    for (std::uint32_t slot = 0; grade == 0 && slot < s.slot_count; ++slot) s.bounds[slot].from_m -= by_m;
    if (grade == 0)
        for (auto& age : s.late.reach_m)
            for (double& reach_m : age) reach_m -= by_m;
    s.odometer_m[grade] = 0;
}

} // namespace

void begin_schedule(Schedule& s, double about_m) {
    int exponent = 0;
    (void)std::frexp(about_m, &exponent);
    s.tick_m = std::ldexp(1.0, exponent - 1);
    s.ticks_a_metre = 1 / s.tick_m;
    s.vectors = {charge_vector, spent_vector, least_vector};
    for (std::uint32_t slot = 0; slot < s.slot_count; ++slot) s.pages[slot].awake = no_index;
    std::fill_n(s.ticks, std::size_t{s.slot_count} * page_ticks, unscheduled);
}

void clear_schedule(Schedule& s) {
    forget_late(s.late);
    while (s.awake_count != 0) clear_page_schedule(s, s.awake[s.awake_count - 1].slot);
}

void note_late(LateBounds& late, double odometer_m, std::int64_t now, std::int64_t lasts, std::uint8_t code,
               double apart_m) {
    const std::uint32_t next = (late.newest + 1) % late_ages;
    if (now - late.begun[late.newest] > lasts / late_ages && now - late.last[next] > lasts) {
        late.newest = next;
        late.begun[next] = now;
        std::fill_n(late.reach_m[next], late_grades, never_m);
    }
    late.last[late.newest] = now;
    double& reach_m = late.reach_m[late.newest][code >> late_grade_codes_log2];
    reach_m = std::min(reach_m, odometer_m + apart_m);
}

void forget_late(LateBounds& late) {
    for (std::uint32_t age = 0; age < late_ages; ++age) {
        late.begun[age] = late.last[age] = std::numeric_limits<std::int64_t>::min() / 2;
        std::fill_n(late.reach_m[age], late_grades, never_m);
    }
}

void begin_page(Schedule& s, std::uint32_t slot, std::uint32_t tick_log2) {
    FJELL_ASSERT(s.pages[slot].awake == no_index);
    s.pages[slot] = {0, 0, no_index, due_level_count - 1, static_cast<std::uint8_t>(tick_log2)};
    s.bounds[slot] = {0, 0, 3e38f}; // nobody knows yet
}

void set_level(Schedule& s, std::uint32_t slot, std::uint32_t level) {
    PageSchedule& page = s.pages[slot];
    page.level = static_cast<std::uint8_t>(level);
    if (page.awake == no_index) return;
    FJELL_ASSERT(!s.awake[page.awake].due); // or it would be looked for in another list than it is in
    s.awake[page.awake].level = page.level;
}

void clear_page_schedule(Schedule& s, std::uint32_t slot) {
    if (s.pages[slot].awake == no_index) return;
    if (is_due(s, slot)) take_from_due(s, s.awake[s.pages[slot].awake]);
    sleep(s, slot);
    std::fill_n(s.ticks + std::size_t{slot} * page_ticks, page_ticks, unscheduled);
}

namespace {

// Whole ticks that its odometer is ahead of what the page is charged.
std::uint16_t uncharged_ticks(const Schedule& s, const PageSchedule& page) {
    return whole_ticks(odometer_m(s, page) - page.charged_m, ticks_a_metre(s, page));
}

// The largest number that is spent.
std::uint16_t last_spent(const Schedule& s, const PageSchedule& page) {
    return odometer_m(s, page) > page.seen_m ? static_cast<std::uint16_t>(uncharged_ticks(s, page) + soon) : spent;
}

} // namespace

bool is_spent(const Schedule& s, std::uint32_t group) {
    const std::uint32_t slot = group / max_page_groups;
    const std::uint16_t ticks = ticks_of(s, group);
    return ticks != unscheduled && is_due(s, slot) && ticks <= last_spent(s, s.pages[slot]);
}

void tighten(Schedule& s, std::uint32_t group, float slack_m, std::uint32_t grade) {
    const std::uint32_t slot = group / max_page_groups;
    PageSchedule& page = s.pages[slot];
    if (page.awake == no_index) wake(s, slot, grade);
    AwakePage& awake = s.awake[page.awake];
    if (grade > awake.grade) raise_grade(s, page, awake, grade);
    if (awake.due_m == never_m && !awake.due) page.charged_m = page.seen_m = s.odometer_m[awake.grade]; // none so far
    const double now_m = s.odometer_m[awake.grade], one_m = tick_m(s, page);
    const std::uint16_t ticks =
        whole_ticks(static_cast<double>(slack_m) + (now_m - page.charged_m), ticks_a_metre(s, page));
    std::uint16_t& of_group = ticks_of(s, group);
    of_group = std::min(of_group, static_cast<std::uint16_t>(ticks + soon));
    if (awake.due) return;
    awake.due_m = std::min(awake.due_m, std::max(page.charged_m + static_cast<double>(ticks) * one_m, now_m));
}

void forget_due(Schedule& s) {
    for (std::uint32_t i = 0; i < s.awake_count; ++i) {
        s.awake[i].due = false;
        s.awake[i].due_m = never_m;
    }
    s.due_levels = s.due_count = 0;
}

namespace {

// A page that is awake and has nothing to watch but these ticks, as they were travelled_m ago. least: of them.
void start(Schedule& s, std::uint32_t slot, std::uint16_t least, double travelled_m) {
    PageSchedule& page = s.pages[slot];
    AwakePage& awake = s.awake[page.awake];
    page.charged_m = page.seen_m = s.odometer_m[awake.grade] - travelled_m;
    awake.due_m = page.charged_m + (least > soon ? static_cast<double>(least - soon) * tick_m(s, page) : 0.0);
    if (least == spent || s.odometer_m[awake.grade] > awake.due_m) push_due(s, awake);
}

} // namespace

void install_ticks(Schedule& s, std::uint32_t slot, const std::uint16_t* ticks, std::uint32_t grade,
                   const double (&travelled_m)[grade_count]) {
    wake(s, slot, grade);
    std::copy_n(ticks, page_ticks, s.ticks + std::size_t{slot} * page_ticks);
    start(s, slot, s.vectors.least(ticks), travelled_m[grade]);
}

void restart_group(Schedule& s, std::uint32_t slot, std::uint32_t group, std::uint16_t ticks, std::uint32_t grade,
                   const double (&travelled_m)[grade_count]) {
    if (s.pages[slot].awake == no_index) wake(s, slot, grade);
    if (is_due(s, slot)) take_from_due(s, s.awake[s.pages[slot].awake]);
    s.awake[s.pages[slot].awake] = {never_m, slot, static_cast<std::uint8_t>(grade), s.pages[slot].level, false, 0};
    s.ticks[std::size_t{slot} * page_ticks + group] = ticks;
    start(s, slot, ticks, travelled_m[grade]);
}

void make_due(Schedule& s, std::uint32_t group) {
    const std::uint32_t slot = group / max_page_groups;
    if (s.pages[slot].awake == no_index) wake(s, slot, 0);
    ticks_of(s, group) = spent;
    if (!is_due(s, slot)) push_due(s, s.awake[s.pages[slot].awake]);
}

void count_queued(Schedule& s, std::uint32_t slot, int more) {
    if (s.pages[slot].awake == no_index) wake(s, slot, 0);
    AwakePage& awake = s.awake[s.pages[slot].awake];
    FJELL_ASSERT(more > 0 || awake.queued != 0);
    awake.queued = static_cast<std::uint8_t>(awake.queued + more);
    // It watches nothing else: the rest of its schedule is as it was when it came.
    if (awake.queued == 0 && awake.due_m == never_m && !awake.due) sleep(s, slot);
}

void advance(Schedule& s, const double (&metres)[grade_count]) {
    const double most_m = s.tick_m * 0x1p17 * static_cast<double>(1u << max_tile_log2); // more than any slack
    bool moved = false;
    for (std::uint32_t grade = 0; grade < grade_count; ++grade) {
        if (!(metres[grade] > 0)) continue;
        if (s.odometer_m[grade] >= rewind_ticks * s.tick_m) rewind(s, grade);
        s.odometer_m[grade] = sum(s.odometer_m[grade], std::min(metres[grade], most_m));
        moved = true;
    }
    for (std::uint32_t i = 0; moved && i < s.awake_count; ++i)
        if (s.odometer_m[s.awake[i].grade] > s.awake[i].due_m) push_due(s, s.awake[i]);
}

std::uint32_t pop_due(Schedule& s) {
    if (s.due_levels == 0) return no_index;
    const auto level = static_cast<std::uint32_t>(std::bit_width(s.due_levels)) - 1;
    const std::uint32_t slot = s.due[level].first;
    s.due[level].first = s.next_due[slot];
    if (s.next_due[slot] == no_index) s.due_levels &= ~(1u << level);
    --s.due_count;
    return slot;
}

void put_back_due(Schedule& s, std::uint32_t slot) {
    FJELL_ASSERT(is_due(s, slot));
    const std::uint32_t level = s.pages[slot].level;
    DuePages& due = s.due[level];
    const bool alone = (s.due_levels >> level & 1) == 0;
    s.next_due[slot] = alone ? no_index : due.first;
    if (alone) due.last = slot;
    due.first = slot;
    s.due_levels |= 1u << level;
    ++s.due_count;
}

void find_spent(Schedule& s, std::uint32_t slot, std::uint64_t (&bits)[page_words]) {
    PageSchedule& page = s.pages[slot];
    std::uint16_t* const ticks = s.ticks + std::size_t{slot} * page_ticks;
    if (const std::uint16_t uncharged = uncharged_ticks(s, page); uncharged > most_uncharged) {
        const double gone_m = odometer_m(s, page) - page.charged_m;
        s.vectors.charge(ticks, uncharged);
        page.charged_m += std::floor(gone_m * ticks_a_metre(s, page)) * tick_m(s, page);
    }
    s.vectors.find_spent(ticks, last_spent(s, page), bits);
    page.seen_m = odometer_m(s, page);
}

void close_page(Schedule& s, std::uint32_t slot) {
    PageSchedule& page = s.pages[slot];
    AwakePage& awake = s.awake[page.awake];
    awake.due = false;
    const std::uint16_t least = s.vectors.least(s.ticks + std::size_t{slot} * page_ticks);
    if (least == unscheduled && awake.queued == 0) return sleep(s, slot);
    awake.due_m = least == unscheduled
                      ? never_m
                      : std::max(page.charged_m + (static_cast<double>(least) - soon) * tick_m(s, page),
                                 s.odometer_m[awake.grade]);
}

std::uint32_t count_spent(const Schedule& s, std::uint32_t most) {
    std::uint32_t count = 0;
    for (std::uint32_t i = 0; i < s.awake_count && count <= most; ++i) {
        if (!s.awake[i].due) continue;
        const PageSchedule& page = s.pages[s.awake[i].slot];
        const std::uint32_t last = last_spent(s, page);
        const std::uint16_t* const of_page = s.ticks + std::size_t{s.awake[i].slot} * page_ticks;
        for (std::uint32_t group = 0; group < page_ticks; ++group)
            count += of_page[group] <= last && of_page[group] != unscheduled;
    }
    return count;
}

namespace {

void charge_scalar(std::uint16_t* ticks, std::uint16_t by) {
    for (std::uint32_t i = 0; i < page_ticks; ++i)
        if (ticks[i] != unscheduled)
            ticks[i] = static_cast<std::uint16_t>(ticks[i] > by + soon ? ticks[i] - by : spent);
}

void spent_scalar(const std::uint16_t* ticks, std::uint16_t last, std::uint64_t* bits) {
    std::fill_n(bits, page_words, 0);
    for (std::uint32_t i = 0; i < page_ticks; ++i) bits[i / 64] |= std::uint64_t{ticks[i] <= last} << i % 64;
}

std::uint16_t least_scalar(const std::uint16_t* ticks) {
    return *std::min_element(ticks, ticks + page_ticks);
}

} // namespace

const TickVectors scalar_ticks{charge_scalar, spent_scalar, least_scalar};

// --- queues

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
    queues.work_ranks = queues.open_slots = 0;
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
#endif
