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
        : blocks(count), queues(queue_count), chunks(block_chunks(count)), buckets(due_lists) {
        lists.blocks = blocks.data();
        lists.block_count = count;
        lists.queues = queues.data();
        lists.chunks = chunks.data();
        lists.buckets = buckets.data();
        set_tick(lists, 0.7); // 0.5
        for (BlockState& b : blocks) b.list = no_list;
        clear_lists(lists, block_chunks(count));
    }
    std::vector<BlockState> blocks;
    std::vector<Link> queues;
    std::vector<BlockChunk> chunks;
    std::vector<Bucket> buckets;
    Lists lists{};

    [[nodiscard]] std::uint32_t free_chunks() const {
        std::uint32_t n = 0;
        for (std::uint32_t at = lists.free_chunk; at != nil; at = chunks[at].next) ++n;
        return n;
    }
};

} // namespace

TEST_CASE("no block is looked at later than its slack allows, nor much too early, and none is lost") {
    std::mt19937 random(5);
    const auto pick = [&](std::uint32_t n) { return static_cast<std::uint32_t>(random() % n); };
    constexpr std::uint32_t count = 300;
    Owner owner(count);
    Lists& lists = owner.lists;
    double odometer[grade_count] = {};
    struct Appointment {
        std::uint32_t grade;
        double made_m, slack_m; // odometer when it was made; slack then
        int moved = 0;          // each time costs up to two ticks of rounding, on the early side
    };
    std::map<std::uint32_t, Appointment> booked;
    std::set<std::uint32_t> due, queued;
    std::size_t came = 0;
    for (int step = 0; step < 60'000; ++step) {
        const std::uint32_t block = pick(count), grade = pick(grade_count);
        const auto slack = static_cast<float>(std::pow(10.0, pick(800) / 100.0 - 3));
        switch (pick(6)) {
        case 0:
        case 1:
            if (lists.blocks[block].list != no_list) break;
            schedule(lists, block, slack, grade);
            booked[block] = {grade, odometer[grade], slack, 0};
            break;
        case 2: { // the earlier time and the higher grade win
            if (due.contains(block) || queued.contains(block)) break;
            tighten(lists, block, slack, grade);
            const auto found = booked.find(block);
            if (found == booked.end()) {
                booked[block] = {grade, odometer[grade], slack, 0};
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
            advance(lists, grade, metres);
            odometer[grade] += metres;
            for (auto it = booked.begin(); it != booked.end();) {
                const Appointment a = it->second;
                const bool is_due = list_of(lists, it->first) == due_lists + a.grade;
                const double travelled = odometer[a.grade] - a.made_m;
                REQUIRE((is_due || travelled < a.slack_m)); // never late
                if (!is_due) {
                    ++it;
                    continue;
                }
                // At most a seventh too early, and some ticks.
                REQUIRE(travelled >= a.slack_m * 6 / 7 - (2.01 + 2 * a.moved) * lists.tick_m);
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
                    lists.blocks[popped].list = no_list;
                    if (pick(2) == 0) {
                        pick(2) ? push_back(lists, work_lists + pick(rank_count), popped)
                                : push_front(lists, retire_list, popped);
                        queued.insert(popped);
                    }
                }
            break;
        case 5:
            if (due.contains(block)) break;
            unlink(lists, block);
            booked.erase(block);
            queued.erase(block);
            break;
        }
        std::size_t in_due = 0, in_queues = 0;
        for (std::uint32_t l = due_lists; l < list_count; ++l) (l < work_lists ? in_due : in_queues) += size(lists, l);
        REQUIRE(in_due == due.size());
        REQUIRE(in_queues == queued.size());
    }
    CHECK(came > 1000);
    // Everything taken out again, every chunk is free.
    for (std::uint32_t g = 0; g < grade_count; ++g)
        while (size(lists, due_lists + g) != 0) lists.blocks[pop_due(lists, g, [](std::uint32_t) {})].list = no_list;
    for (std::uint32_t block = 0; block < count; ++block) unlink(lists, block);
    CHECK(owner.free_chunks() == block_chunks(count));
}

TEST_CASE("queues are first in, first out, and take back at the front") {
    Owner owner(8);
    Lists& lists = owner.lists;
    for (const std::uint32_t block : {3u, 1u, 5u}) push_back(lists, work_lists + 4, block);
    push_front(lists, work_lists + 4, 7);
    unlink(lists, 1);
    CHECK(size(lists, work_lists + 4) == 3);
    CHECK(pop_front(lists, work_lists + 4) == 7);
    CHECK(pop_front(lists, work_lists + 4) == 3);
    CHECK(pop_front(lists, work_lists + 4) == 5);
    CHECK(size(lists, work_lists + 4) == 0);
}

TEST_CASE("due blocks of a page that leaves are forgotten, others stay due") {
    Owner owner(200);
    Lists& lists = owner.lists;
    for (std::uint32_t block = 0; block < 200; ++block) push_due(lists, block % 3, block);
    forget_due(lists, 50, 100);
    std::set<std::uint32_t> left;
    for (std::uint32_t g = 0; g < 3; ++g)
        while (size(lists, due_lists + g) != 0) left.insert(pop_due(lists, g, [](std::uint32_t) {}));
    CHECK(left.size() == 100);
    for (const std::uint32_t block : left) CHECK((block < 50 || block >= 150));
    CHECK(owner.free_chunks() == block_chunks(200));
}
