// The schedule and the queues of the live cut, against a model that keeps everything in plain containers.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <vector>

#include "cut/state.h"

using namespace fjell;

namespace {

struct Scheduled {
    explicit Scheduled(std::uint32_t slots)
        : ticks(std::size_t{slots} * page_ticks), pages(slots), awake(slots), bounds(slots), next_due(slots) {
        s.ticks = ticks.data();
        s.pages = pages.data();
        s.awake = awake.data();
        s.bounds = bounds.data();
        s.next_due = next_due.data();
        s.slot_count = slots;
        begin_schedule(s, 0.7); // 0.5
        for (std::uint32_t slot = 0; slot < slots; ++slot) {
            begin_page(s, slot, slot % 3);
            set_level(s, slot, slot % 5);
        }
    }
    std::vector<std::uint16_t> ticks;
    std::vector<PageSchedule> pages;
    std::vector<AwakePage> awake;
    std::vector<HiddenBound> bounds;
    std::vector<std::uint32_t> next_due;
    Schedule s{};
};

struct Appointment {
    double made_m, slack_m; // its grade's odometer when it was made; slack then
    double early_m;         // what rounding may have taken off it since
};

} // namespace

TEST_CASE("no group is looked at later than its slack allows, nor much too early, and none is lost") {
    const double start = GENERATE(0.0, rewind_ticks - 3000); // ticks
    std::mt19937 random(5);
    const auto pick = [&](std::uint32_t n) { return static_cast<std::uint32_t>(random() % n); };
    constexpr std::uint32_t slots = 9, groups_used = 40;
    Scheduled owner(slots);
    Schedule& s = owner.s;
    for (double& m : s.odometer_m) m = start * s.tick_m;
    double odometer[grade_count] = {}; // from there
    std::map<std::uint32_t, Appointment> booked;
    std::vector<std::uint32_t> grade_of_page(slots, 0);
    std::size_t came = 0, rewound = 0;
    const auto page_of = [](std::uint32_t group) { return group / max_page_groups; };
    const auto raise = [&](std::uint32_t slot, std::uint32_t grade) { // their times count on another odometer now
        const std::uint32_t old = grade_of_page[slot];
        grade_of_page[slot] = grade;
        for (auto& [group, a] : booked)
            if (page_of(group) == slot) a.made_m += odometer[grade] - odometer[old];
    };
    for (int step = 0; step < 40'000; ++step) {
        const std::uint32_t slot = pick(slots), group = slot * max_page_groups + pick(groups_used);
        const double one_m = tick_m(s, s.pages[slot]);
        switch (pick(5)) {
        case 0:
        case 1: { // the earlier time and the higher grade win
            const std::uint32_t grade = pick(grade_count);
            const auto slack = static_cast<float>(std::pow(10.0, pick(800) / 100.0 - 3));
            if (s.pages[slot].awake == no_index)
                grade_of_page[slot] = grade;
            else if (grade > grade_of_page[slot])
                raise(slot, grade);
            tighten(s, group, slack, grade);
            const double now = odometer[grade_of_page[slot]];
            const bool long_way = slack > (most_ticks - most_uncharged) * one_m;
            Appointment a{now, std::min<double>(slack, most_ticks * one_m),
                          (long_way ? most_uncharged + 2 : 1.01) * one_m};
            const auto found = booked.find(group);
            if (found != booked.end() && found->second.made_m + found->second.slack_m < now + a.slack_m)
                a = found->second;
            booked[group] = a;
            break;
        }
        case 2: {
            double metres[grade_count] = {};
            for (double& m : metres) m = pick(3) ? std::pow(10.0, pick(500) / 100.0 - 3) : 0;
            const double before = s.odometer_m[0];
            advance(s, metres);
            rewound += s.odometer_m[0] < before;
            for (std::uint32_t g = 0; g < grade_count; ++g) odometer[g] += metres[g];
            break;
        }
        case 3: // some due pages are visited, some of those to their end
            for (std::uint32_t n = pick(slots); n != 0; --n) {
                const std::uint32_t due = pop_due(s);
                if (due == no_index) break;
                std::uint64_t found[page_words];
                find_spent(s, due, found);
                std::vector<std::uint32_t> now;
                for (std::uint32_t i = 0; i < max_page_groups; ++i)
                    if ((found[i / 64] >> i % 64 & 1) != 0) now.push_back(due * max_page_groups + i);
                for (const std::uint32_t g : now) {
                    REQUIRE(booked.contains(g));
                    const Appointment a = booked[g];
                    const double travelled = odometer[grade_of_page[due]] - a.made_m;
                    REQUIRE(travelled >= a.slack_m - a.early_m - 1e-6 * a.slack_m);
                    ++came;
                    booked.erase(g);
                    forget(s, g);
                }
                if (pick(4) == 0)
                    put_back_due(s, due);
                else
                    close_page(s, due);
            }
            break;
        case 4: // waits in a queue from now on
            forget(s, group);
            booked.erase(group);
            break;
        }
        for (const auto& [g, a] : booked)
            if (odometer[grade_of_page[page_of(g)]] - a.made_m > a.slack_m)
                REQUIRE(is_due(s, page_of(g))); // never late
    }
    CHECK(came > 1000);
    CHECK((rewound != 0) == (start != 0));
    for (std::uint32_t slot = 0; slot < slots; ++slot) clear_page_schedule(s, slot);
    CHECK(s.awake_count + s.due_count + s.due_levels == 0);
    CHECK(std::count(owner.ticks.begin(), owner.ticks.end(), unscheduled) == std::ptrdiff_t{slots} * page_ticks);
}

TEST_CASE("steps that are less than an odometer's rounding add up") {
    Scheduled owner(1);
    Schedule& s = owner.s;
    s.odometer_m[3] = (rewind_ticks - 1000) * s.tick_m;
    tighten(s, 0, 0.5f, 3); // a tick
    double step_m[grade_count] = {};
    step_m[3] = 1e-7; // less than half of what doubles there are apart
    REQUIRE(s.odometer_m[3] + step_m[3] == s.odometer_m[3]);
    double way_m = 0;
    for (; !is_due(s, 0) && way_m < 1; way_m += step_m[3]) advance(s, step_m);
    CHECK(way_m <= 0.5);
}

TEST_CASE("pages of a higher level are due first, in the order in which their time came") {
    Scheduled owner(10);
    for (const std::uint32_t slot : {3u, 9u, 4u, 0u, 8u}) make_due(owner.s, slot * max_page_groups);
    REQUIRE(owner.s.due_count == 5);
    const std::uint32_t first = pop_due(owner.s);
    CHECK(first == 9); // levels: 3 and 8 have 3, 9 and 4 have 4
    put_back_due(owner.s, first);
    for (const std::uint32_t slot : {9u, 4u, 3u, 8u, 0u}) CHECK(pop_due(owner.s) == slot);
    CHECK(pop_due(owner.s) == no_index);
}

TEST_CASE("a page's ticks are charged alike with and without vector instructions") {
    std::mt19937 random(6);
    Scheduled owner(1);
    for (int round = 0; round < 1000; ++round) {
        std::uint16_t vector[page_ticks], scalar[page_ticks];
        for (std::uint32_t i = 0; i < page_ticks; ++i) {
            const auto any = static_cast<std::uint16_t>(random());
            vector[i] = scalar[i] = random() % 4 == 0 ? unscheduled : random() % 4 == 0 ? any % 100 : any;
        }
        const auto by = static_cast<std::uint16_t>(random() % (round % 2 ? 100 : 65536));
        owner.s.vectors.charge(vector, by);
        scalar_ticks.charge(scalar, by);
        REQUIRE(std::equal(vector, vector + page_ticks, scalar));
        REQUIRE(owner.s.vectors.least(vector) == scalar_ticks.least(scalar));
        std::uint64_t found[page_words], expected[page_words];
        const auto last = static_cast<std::uint16_t>(random() % (round % 3 != 0 ? 200 : unscheduled));
        owner.s.vectors.find_spent(vector, last, found);
        scalar_ticks.find_spent(scalar, last, expected);
        REQUIRE(std::equal(found, found + page_words, expected));
    }
}

TEST_CASE("queues are first in, first out, and take back at the front") {
    std::vector<GroupState> groups(8);
    for (GroupState& group : groups) group.queue = unqueued;
    Scheduled owner(1);
    Queues queues{};
    queues.schedule = &owner.s;
    std::vector<QueueNode> nodes(groups.size());
    queues.groups = groups.data();
    queues.nodes = nodes.data();
    queues.group_count = 8;
    clear_queues(queues);
    for (const std::uint32_t group : {3u, 1u, 5u}) push_back(queues, work_queues + 4, group);
    push_front(queues, work_queues + 4, 7);
    unlink(queues, 1);
    CHECK(queues.sizes[work_queues + 4] == 3);
    CHECK((owner.s.awake_count == 1 && owner.s.awake[0].queued == 3)); // their page waits
    CHECK(pop_front(queues, work_queues + 4) == 7);
    CHECK(pop_front(queues, work_queues + 4) == 3);
    CHECK(pop_front(queues, work_queues + 4) == 5);
    CHECK(queues.sizes[work_queues + 4] == 0);
    CHECK(owner.s.awake_count == 0);
}
