// When each group has to be evaluated again, page by page.
//
// A group whose smallest slack is d may rest until the worst eye has travelled d, plus what changes of threshold amount
// to for its errors. For each grade of errors an odometer adds that up. A page keeps its groups' slacks side by side in
// 16 bits each, in ticks of 1/32 of its step, from where its odometer stood once; and it knows when the first of them
// is spent. So a frame compares a number a page that has anything to watch, and a page whose time has come is visited
// as a whole: its spent groups are evaluated, while its states and records stream through the cache. Where the odometer
// has gone on for many ticks, the page is charged: all of its numbers become so much less.
//
// Never late: slacks are rounded down to ticks, from where the page was charged, so rounding does not add up from visit
// to visit. Early by a tick at most; and slacks of more than 49,149 ticks are looked at once in so many.
//
// An odometer cannot run out: from rewind_ticks on it begins again at 0, and its pages' times are shifted. Doubles
// below that are 2^-20 of a tick apart, less than what slack_rounding leaves out of any span.
//
// Rejected: a calendar of groups (wheels of buckets, linked nodes): as fast, worse in the worst frames, three times as
// much code (docs/notes/live-cut.md). One queue in order of due times: an order that nothing needs.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "asserts.h"
#include "cut/groups.h"
#include "shared/compiler.h"
#include "shared/tree.h"

namespace fjell {

struct GroupState; // pages.h

inline constexpr std::uint32_t grade_count = 8, grade_codes_log2 = 5; // grades of 32 error codes
inline constexpr std::uint32_t due_level_count = 32;                  // of due pages: how bad what they may hide is
inline constexpr double rewind_ticks = 0x1p32, never_m = 1e300;
inline constexpr double charge_rounding = 0x1p-20; // share of a way that an odometer may lose

[[nodiscard]] inline std::uint32_t grade_of(std::uint32_t code) {
    return code >> grade_codes_log2;
}

inline constexpr std::uint32_t page_words = (max_page_groups + 63) / 64;      // a bit a group
inline constexpr std::uint32_t page_ticks = (max_page_groups + 31) / 32 * 32; // numbers a page: whole cache lines
// A group's number: spent, so that it must be evaluated now; soon, with the next movement; otherwise soon and the ticks
// that it has left; or unscheduled.
inline constexpr std::uint16_t spent = 0, soon = 1, most_ticks = 0xfffd, unscheduled = 0xffff;
// Ticks that a page's odometer may be ahead of what the page is charged.
inline constexpr std::uint16_t most_uncharged = 0x4000;

struct PageSchedule {       // of a page that has a state
    double charged_m;       // the odometer of its grade from which its groups' numbers count
    double seen_m;          // and where that stood when its last visit began, or it woke
    std::uint32_t awake;    // its place among the pages that watch anything, or no_index
    std::uint8_t level;     // of due_level_count: the highest comes first
    std::uint8_t tick_log2; // of its ticks, over those of the finest step
};

// What a frame reads of every page that watches anything; dense, because it reads all of them.
struct AwakePage {
    double due_m; // odometer of its grade beyond which it is due; while it is, never
    std::uint32_t slot;
    std::uint8_t grade; // highest of its groups'
    std::uint8_t level;
    bool due;            // its time has come, and its visit has not ended
    std::uint8_t queued; // of its groups wait in queues
};
static_assert(max_page_groups <= 255);

// What a page's vertices could hide (error_bound.h), as it was when the first odometer stood at from_m: no more than
// error_m, no nearer to an eye than apart_m.
struct HiddenBound {
    double from_m;
    float apart_m, error_m;
};

// How near vertices that morph by time may come to an eye, by their errors and by when they began: the first odometer
// may not pass reach_m before. Ages are filled one after the other; one whose vertices have all arrived is used anew.
inline constexpr std::uint32_t late_ages = 8, late_grades = 32, late_grade_codes_log2 = 3; // of 8 error codes
struct LateBounds {
    std::int64_t begun[late_ages], last[late_ages]; // ticks of the morphing's clock
    double reach_m[late_ages][late_grades];
    std::uint32_t newest;
};

struct DuePages {
    std::uint32_t first, last;
};

// What is done to all of a page's numbers at once.
struct TickVectors {
    void (*charge)(std::uint16_t* ticks, std::uint16_t by);
    // Numbers of `last` or less, which is less than unscheduled: page_words of bits.
    void (*find_spent)(const std::uint16_t* ticks, std::uint16_t last, std::uint64_t* bits);
    std::uint16_t (*least)(const std::uint16_t* ticks);
};
extern const TickVectors scalar_ticks; // the same results, without vector instructions

struct Schedule {
    std::uint16_t* ticks; // page_ticks a state of a page
    PageSchedule* pages;
    AwakePage* awake;    // as many as states
    HiddenBound* bounds; // one a state
    LateBounds late;
    std::uint32_t* next_due; // of a due page's slot: the next one of its level
    std::uint32_t slot_count, awake_count, due_count;
    std::uint32_t due_levels; // that hold any, as bits
    DuePages due[due_level_count];
    double odometer_m[grade_count];
    double tick_m, ticks_a_metre; // of the finest step: powers of 2, so that products with them are exact
    TickVectors vectors;
};

// Ticks of about_m, rounded down to a power of 2. Nothing is scheduled.
void begin_schedule(Schedule& s, double about_m);
// Nothing is scheduled any more.
void clear_schedule(Schedule& s);

// A vertex begins to morph by time at `now`, its sphere apart_m from the nearest eye. lasts: ticks until it has
// arrived.
void note_late(LateBounds& late, double odometer_m, std::int64_t now, std::int64_t lasts, std::uint8_t code,
               double apart_m);
void forget_late(LateBounds& late);
// A page comes to a slot, with nothing scheduled.
void begin_page(Schedule& s, std::uint32_t slot, std::uint32_t tick_log2);
// Of a page that is not due: where it comes when it is.
void set_level(Schedule& s, std::uint32_t slot, std::uint32_t level);
// Nothing in the page is scheduled any more. O(due pages of its level).
void clear_page_schedule(Schedule& s, std::uint32_t slot);

[[nodiscard]] inline std::uint16_t& ticks_of(const Schedule& s, std::uint32_t group) {
    const std::uint32_t slot = group / max_page_groups;
    return s.ticks[slot * page_ticks + (group - slot * max_page_groups)];
}
[[nodiscard]] inline bool is_due(const Schedule& s, std::uint32_t slot) {
    const std::uint32_t awake = s.pages[slot].awake;
    return awake != no_index && s.awake[awake].due;
}
// The odometer that counts for an awake page.
[[nodiscard]] inline double odometer_m(const Schedule& s, const PageSchedule& page) {
    return s.odometer_m[s.awake[page.awake].grade];
}
[[nodiscard]] inline double tick_m(const Schedule& s, const PageSchedule& page) {
    return s.tick_m * static_cast<double>(1u << page.tick_log2);
}
[[nodiscard]] inline double ticks_a_metre(const Schedule& s, const PageSchedule& page) {
    return s.ticks_a_metre * bits_as<double>((std::uint64_t{1023} - page.tick_log2) << 52); // 2^-tick_log2
}
// A way of so many metres, and what is left of it in whole ticks.
[[nodiscard]] inline std::uint16_t whole_ticks(double metres, double ticks_a_metre) {
    return static_cast<std::uint16_t>(std::clamp(metres * ticks_a_metre, 0.0, static_cast<double>(most_ticks)));
}

// A due page in work: what scheduling its groups anew takes.
struct DuePage {
    std::uint16_t* ticks;
    double charged_before_m; // how far its odometer has gone since it was charged
    double ticks_a_metre;    // a power of 2, so that products with it are exact
    std::uint32_t grade;
};
[[nodiscard]] inline DuePage due_page(const Schedule& s, std::uint32_t slot) {
    const PageSchedule& page = s.pages[slot];
    return {s.ticks + std::size_t{slot} * page_ticks, odometer_m(s, page) - page.charged_m, ticks_a_metre(s, page),
            s.awake[page.awake].grade};
}

// Must the group be evaluated, or would it have to be if its page were charged now?
[[nodiscard]] bool is_spent(const Schedule& s, std::uint32_t group);

// The group must be evaluated before the odometer has gone slack_m further; of several times the earliest counts.
void tighten(Schedule& s, std::uint32_t group, float slack_m, std::uint32_t grade);
// The same of a due page's n-th group, of no higher grade than the page's.
inline void tighten(const DuePage& page, std::uint32_t n, float slack_m) {
    const std::uint16_t ticks = whole_ticks(static_cast<double>(slack_m) + page.charged_before_m, page.ticks_a_metre);
    page.ticks[n] = std::min(page.ticks[n], static_cast<std::uint16_t>(ticks + soon));
}
// The group must be evaluated in this frame.
void make_due(Schedule& s, std::uint32_t group);
// No page is due, or comes to be: each one's schedule is about to be cleared. O(awake pages).
void forget_due(Schedule& s);
// A page that is not awake wakes with these ticks (page_ticks of them) of its grade, as they were travelled_m ago.
void install_ticks(Schedule& s, std::uint32_t slot, const std::uint16_t* ticks, std::uint32_t grade,
                   const double (&travelled_m)[grade_count]);
// The same of one group, in a page in which no other can be scheduled; it may be awake.
void restart_group(Schedule& s, std::uint32_t slot, std::uint32_t group, std::uint16_t ticks, std::uint32_t grade,
                   const double (&travelled_m)[grade_count]);
// It need not, because it waits in a queue.
inline void forget(Schedule& s, std::uint32_t group) {
    ticks_of(s, group) = unscheduled;
}

// So many more of its groups wait in queues: an awake page is one that is watched, or waits.
void count_queued(Schedule& s, std::uint32_t slot, int more);
// Each grade's odometer goes on by at least (1 - charge_rounding) of its way. Pages whose time has come become due.
// O(awake pages) when anything moves.
void advance(Schedule& s, const double (&metres)[grade_count]);

// The next due page, or no_index: the highest level first, in the order in which their time came. It stays due until it
// is closed or put back.
[[nodiscard]] std::uint32_t pop_due(Schedule& s);
// Its visit has not ended.
void put_back_due(Schedule& s, std::uint32_t slot);
// The visit of a due page begins. A bit for each group that has travelled as far as its slack: these are to be
// evaluated. Where the odometer stands as at the visit before, only those that are marked as spent: what has been
// looked at since waits for the next movement, however small its slack is, or a visit might never end.
void find_spent(Schedule& s, std::uint32_t slot, std::uint64_t (&bits)[page_words]);
// Of all due pages; as far as `most` goes, or a little further. O(due pages).
[[nodiscard]] std::uint32_t count_spent(const Schedule& s, std::uint32_t most);
// All of them were: when is the page due again?
void close_page(Schedule& s, std::uint32_t slot);

// --- queues: groups just evaluated whose lanes call for changes. Linked through a node of each group, so they cannot
// run out of room.

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
inline constexpr QueueId gated_queues = blocked_queues + 2; // behind a page that is evicted; two that take turns
inline constexpr std::uint32_t rising_slots = 16;           // of time
inline constexpr QueueId rising_queues = gated_queues + 2;  // behind a vertex that morphs: by when that has arrived
inline constexpr QueueId queue_count = rising_queues + rising_slots;
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
    // Passes over the gated groups that are due, because a vertex is no longer evicted. A pass may take several frames;
    // groups that were filed before the event may lie in either list.
    std::uint8_t gate_passes;
    // A vertex arrives when its time has come, and not before: until then nobody looks at what waits for it. A slot is
    // an eighth of the time that vertices take; it opens when all of it is over, and slot n uses queue n %
    // rising_slots. They are counted from when nothing has morphed or waited, and not from when the clock began: the
    // same flight an hour later does the same.
    std::int64_t slot_ticks, slots_from_ticks, opened;
    std::uint32_t open_slots; // as bits: they may hold groups that are to be tried again
};

void clear_queues(Queues& queues); // the groups' own states aside

// The group must be in no queue.
void push_back(Queues& queues, std::uint32_t queue, std::uint32_t group);
void push_front(Queues& queues, std::uint32_t queue, std::uint32_t group);
// Takes a group from whatever queue it is in.
void unlink(Queues& queues, std::uint32_t group);
// The queue must not be empty.
[[nodiscard]] std::uint32_t pop_front(Queues& queues, std::uint32_t queue);

// What is to be done, and when.
struct Work {
    Schedule schedule;
    Queues queues;
};

} // namespace fjell
