#include "cut/lists.h"

#include <algorithm>
#include <bit>

#include "cut/state.h"

namespace fjell {

namespace {

constexpr std::uint64_t last_tick = std::uint64_t{first_wheel_ticks} << (3 * (wheel_count - 1)); // of any slack

ListId bucket_list(std::uint32_t grade, std::uint32_t wheel, std::uint64_t bucket) {
    return static_cast<ListId>((grade * wheel_count + wheel) * wheel_buckets + bucket % wheel_buckets);
}

Link& link(Lists& lists, std::uint32_t node) {
    return node < lists.block_count ? lists.blocks[node].link : lists.heads[node - lists.block_count];
}

std::uint64_t due_tick(const BlockState& b) {
    return std::uint64_t{b.due_high} << 32 | b.due;
}

// All of a list to the end of a list of due blocks.
void splice(Lists& lists, ListId from, ListId to) {
    if (lists.sizes[from] == 0) return;
    const Link moved = lists.heads[from];
    Link& ends = lists.heads[to];
    link(lists, ends.prev).next = moved.next;
    lists.blocks[moved.next].link.prev = ends.prev;
    lists.blocks[moved.prev].link.next = lists.block_count + to;
    ends.prev = moved.prev;
    lists.heads[from] = {lists.block_count + from, lists.block_count + from};
    lists.sizes[to] += lists.sizes[from];
    lists.sizes[from] = 0;
}

void drain(Lists& lists, std::uint32_t grade, std::uint32_t wheel, std::uint64_t bucket) {
    const std::uint64_t bit = std::uint64_t{1} << (bucket % wheel_buckets);
    if ((lists.filled[grade][wheel] & bit) == 0) return;
    lists.filled[grade][wheel] &= ~bit;
    splice(lists, bucket_list(grade, wheel, bucket), static_cast<ListId>(due_lists + grade));
}

} // namespace

void clear_lists(Lists& lists) {
    for (std::uint32_t i = 0; i < list_count; ++i) {
        lists.heads[i] = {lists.block_count + i, lists.block_count + i};
        lists.sizes[i] = 0;
    }
    for (auto& wheels : lists.filled)
        for (std::uint64_t& w : wheels) w = 0;
}

ListId list_of(const Lists& lists, std::uint32_t block) {
    const BlockState& b = lists.blocks[block];
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

void push_back(Lists& lists, ListId list, std::uint32_t block) {
    BlockState& b = lists.blocks[block];
    Link& ends = lists.heads[list];
    b.link = {lists.block_count + list, ends.prev};
    link(lists, ends.prev).next = block;
    ends.prev = block;
    b.list = list;
    ++lists.sizes[list];
}

void unlink(Lists& lists, std::uint32_t block) {
    BlockState& b = lists.blocks[block];
    if (b.list == no_list) return;
    --lists.sizes[list_of(lists, block)];
    link(lists, b.link.prev).next = b.link.next;
    link(lists, b.link.next).prev = b.link.prev;
    b.list = no_list;
}

void schedule(Lists& lists, std::uint32_t block, float slack_m, std::uint32_t grade) {
    BlockState& b = lists.blocks[block];
    b.grade = static_cast<std::uint8_t>(grade);
    const double ticks = std::min(static_cast<double>(slack_m) / lists.tick_m, static_cast<double>(last_tick - 1));
    const auto due = static_cast<std::uint64_t>(lists.odometer_m[grade] / lists.tick_m + ticks);
    const std::uint64_t now = lists.tick[grade];
    const bool soon = due <= now;
    const std::uint64_t stored = soon ? lists.moves[grade] : due;
    b.due = static_cast<std::uint32_t>(stored);
    b.due_high = static_cast<std::uint16_t>(stored >> 32);
    if (soon) return push_back(lists, static_cast<ListId>(soon_lists + grade), block);
    // 56 ticks and more go to the second wheel, 448 to the third ...
    const auto wheel = std::min(
        (static_cast<std::uint32_t>(std::bit_width((due - now) / first_wheel_ticks)) + 2) / 3, wheel_count - 1);
    const std::uint64_t bucket = due >> (3 * wheel);
    lists.filled[grade][wheel] |= std::uint64_t{1} << (bucket % wheel_buckets);
    push_back(lists, bucket_list(grade, wheel, bucket), block);
}

void tighten(Lists& lists, std::uint32_t block, float slack_m, std::uint32_t grade) {
    const BlockState& b = lists.blocks[block];
    if (b.list == no_list) return schedule(lists, block, slack_m, grade);
    const ListId list = list_of(lists, block);
    if (list >= due_lists) return;
    // Ticks are whole: what is left lies between two bounds, and each is used where it errs on the safe side.
    const std::uint64_t ticks = list >= soon_lists ? 0 : due_tick(b) - lists.tick[b.grade];
    if (static_cast<double>(ticks) * lists.tick_m <= static_cast<double>(slack_m) && grade <= b.grade) return;
    const double left_m = ticks == 0 ? 0 : static_cast<double>(ticks - 1) * lists.tick_m;
    const std::uint32_t highest = std::max<std::uint32_t>(grade, b.grade);
    unlink(lists, block);
    schedule(lists, block, static_cast<float>(std::min(left_m, static_cast<double>(slack_m))), highest);
}

void advance(Lists& lists, std::uint32_t grade, double metres) {
    if (!(metres > 0)) return;
    const std::uint64_t before = lists.tick[grade];
    lists.odometer_m[grade] += std::min(metres, static_cast<double>(last_tick) * lists.tick_m);
    lists.tick[grade] = static_cast<std::uint64_t>(lists.odometer_m[grade] / lists.tick_m);
    ++lists.moves[grade];
    splice(lists, static_cast<ListId>(soon_lists + grade), static_cast<ListId>(due_lists + grade));
    for (std::uint32_t wheel = 0; wheel < wheel_count; ++wheel) {
        if (lists.filled[grade][wheel] == 0) continue;
        const std::uint64_t first = (before >> (3 * wheel)) + 1, last = lists.tick[grade] >> (3 * wheel);
        const std::uint64_t n = last + 1 - first;
        for (std::uint64_t i = 0; i < (n < wheel_buckets ? n : wheel_buckets); ++i)
            drain(lists, grade, wheel, first + i);
    }
}

} // namespace fjell
