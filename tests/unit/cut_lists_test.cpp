// The calendar and the queues of the live cut, against a model that keeps everything in plain vectors.
#include <catch2/catch.hpp>

#include <map>
#include <random>
#include <set>
#include <vector>

#include "cut/state.h"

using namespace fjell;

namespace {

struct Owner {
    explicit Owner(std::uint32_t count)
        : groups(count), queues(queue_count), nodes(list_node_count(count)), buckets(due_lists) {
        lists.groups = groups.data();
        lists.group_count = count;
        lists.queues = queues.data();
        lists.nodes = nodes.data();
        lists.buckets = buckets.data();
        set_tick(lists, 0.7); // 0.5
        for (GroupState& b : groups) b.list = unlisted;
        clear_lists(lists, list_node_count(count));
    }
    std::vector<GroupState> groups;
    std::vector<Link> queues;
    std::vector<ListNode> nodes;
    std::vector<Bucket> buckets;
    Lists lists{};

    [[nodiscard]] std::uint32_t free_chunks() const {
        std::uint32_t n = 0;
        for (std::uint32_t at = lists.free_node; at != no_index; at = nodes[at].next) ++n;
        return n;
    }
};

} // namespace

TEST_CASE("no group is looked at later than its slack allows, nor much too early, and none is lost") {
    const std::uint64_t start = GENERATE(std::uint64_t{0}, rewind_tick - 3000); // ticks
    std::mt19937 random(5);
    const auto pick = [&](std::uint32_t n) { return static_cast<std::uint32_t>(random() % n); };
    constexpr std::uint32_t count = 300;
    Owner owner(count);
    Lists& lists = owner.lists;
    for (std::uint32_t grade = 0; grade < grade_count; ++grade) {
        lists.tick[grade] = start;
        lists.odometer_m[grade] = static_cast<double>(start) * lists.tick_m;
    }
    double odometer[grade_count] = {}; // from there
    struct Appointment {
        std::uint32_t grade;
        double made_m, slack_m; // odometer when it was made; slack then
        int moved = 0;          // each time costs up to two ticks of rounding, on the early side
    };
    std::map<std::uint32_t, Appointment> booked;
    std::set<std::uint32_t> due, queued;
    std::size_t came = 0, rewound = 0;
    for (int step = 0; step < 60'000; ++step) {
        const std::uint32_t group = pick(count), grade = pick(grade_count);
        const auto slack = static_cast<float>(std::pow(10.0, pick(800) / 100.0 - 3));
        switch (pick(6)) {
        case 0:
        case 1:
            if (lists.groups[group].list != unlisted) break;
            schedule(lists, group, slack, grade);
            booked[group] = {grade, odometer[grade], slack, 0};
            break;
        case 2: { // the earlier time and the higher grade win
            if (due.contains(group) || queued.contains(group)) break;
            tighten(lists, group, slack, grade);
            const auto found = booked.find(group);
            if (found == booked.end()) {
                booked[group] = {grade, odometer[grade], slack, 0};
                break;
            }
            Appointment& a = found->second;
            const double left = a.made_m + a.slack_m - odometer[a.grade];
            const std::uint32_t highest = std::max(grade, a.grade);
            a = {highest, odometer[highest], std::min(left, static_cast<double>(slack)), a.moved + 1};
            break;
        }
        case 3: {
            const double metres = pick(3) ? std::pow(10.0, pick(500) / 100.0 - 3) : 0;
            const std::uint64_t before = lists.tick[grade];
            advance(lists, grade, metres);
            odometer[grade] += metres;
            const bool rewinds = lists.tick[grade] < before; // then all of the grade are due
            rewound += rewinds;
            for (auto it = booked.begin(); it != booked.end();) {
                const Appointment a = it->second;
                const bool is_due = list_of(lists, it->first) == due_lists + a.grade;
                const bool rewinding = rewinds && a.grade == grade;
                const double travelled = odometer[a.grade] - a.made_m;
                REQUIRE((is_due || (!rewinding && travelled < a.slack_m))); // never late
                if (!is_due) {
                    ++it;
                    continue;
                }
                // At most a seventh too early, and some ticks.
                if (!rewinding) REQUIRE(travelled >= a.slack_m * 6 / 7 - (2.01 + 2 * a.moved) * lists.tick_m);
                due.insert(it->first);
                ++came;
                it = booked.erase(it);
            }
            break;
        }
        case 4:
            for (std::uint32_t g = 0; g < grade_count; ++g)
                while (size(lists, due_lists + g) != 0 && pick(4) != 0) {
                    const std::uint32_t popped = pop_due(lists, g, [](std::uint32_t) {});
                    REQUIRE(due.erase(popped) == 1);
                    lists.groups[popped].list = unlisted;
                    if (pick(2) == 0) {
                        pick(2) ? push_back(lists, work_lists + pick(rank_count), popped)
                                : push_front(lists, deactivation_list, popped);
                        queued.insert(popped);
                    }
                }
            break;
        case 5:
            if (due.contains(group)) break;
            unlink(lists, group);
            booked.erase(group);
            queued.erase(group);
            break;
        }
        std::size_t in_due = 0, in_queues = 0;
        for (std::uint32_t l = due_lists; l < list_count; ++l) (l < work_lists ? in_due : in_queues) += size(lists, l);
        REQUIRE(in_due == due.size());
        REQUIRE(in_queues == queued.size());
    }
    CHECK(came > 1000);
    CHECK(rewound == (start == 0 ? 0 : grade_count));
    // Everything taken out again, every node is free.
    for (std::uint32_t g = 0; g < grade_count; ++g)
        while (size(lists, due_lists + g) != 0) lists.groups[pop_due(lists, g, [](std::uint32_t) {})].list = unlisted;
    for (std::uint32_t group = 0; group < count; ++group) unlink(lists, group);
    CHECK(owner.free_chunks() == list_node_count(count));
}

TEST_CASE("steps that are less than an odometer's rounding add up") {
    Owner owner(1);
    Lists& lists = owner.lists;
    lists.tick[3] = rewind_tick - 1000;
    lists.odometer_m[3] = static_cast<double>(lists.tick[3]) * lists.tick_m;
    schedule(lists, 0, 0.5f, 3);    // a tick
    constexpr double step_m = 1e-7; // less than half of what doubles there are apart
    REQUIRE(lists.odometer_m[3] + step_m == lists.odometer_m[3]);
    double way_m = 0;
    for (; list_of(lists, 0) != due_lists + 3 && way_m < 1; way_m += step_m) advance(lists, 3, step_m);
    CHECK(way_m <= 0.5);
}

TEST_CASE("queues are first in, first out, and take back at the front") {
    Owner owner(8);
    Lists& lists = owner.lists;
    for (const std::uint32_t group : {3u, 1u, 5u}) push_back(lists, work_lists + 4, group);
    push_front(lists, work_lists + 4, 7);
    unlink(lists, 1);
    CHECK(size(lists, work_lists + 4) == 3);
    CHECK(pop_front(lists, work_lists + 4) == 7);
    CHECK(pop_front(lists, work_lists + 4) == 3);
    CHECK(pop_front(lists, work_lists + 4) == 5);
    CHECK(size(lists, work_lists + 4) == 0);
}

TEST_CASE("due groups of a page that leaves are forgotten, others stay due") {
    Owner owner(200);
    Lists& lists = owner.lists;
    for (std::uint32_t group = 0; group < 200; ++group) push_due(lists, group % 3, group);
    forget_due(lists, 50, 100);
    std::set<std::uint32_t> left;
    for (std::uint32_t g = 0; g < 3; ++g)
        while (size(lists, due_lists + g) != 0) left.insert(pop_due(lists, g, [](std::uint32_t) {}));
    CHECK(left.size() == 100);
    for (const std::uint32_t group : left) CHECK((group < 50 || group >= 150));
    CHECK(owner.free_chunks() == list_node_count(200));
}
