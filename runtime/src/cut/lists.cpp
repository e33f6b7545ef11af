#include "cut/lists.h"

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

// A queue's head has the number after the last block, and so on.
Link& link(Lists& lists, std::uint32_t node) {
    return node < lists.block_count ? lists.blocks[node].link : lists.queues[node - lists.block_count];
}

std::uint64_t due_tick(const BlockState& b) {
    return std::uint64_t{b.due_high} << 32 | b.due;
}

std::uint32_t take_chunk(Lists& lists, std::uint32_t next) {
    const std::uint32_t chunk = lists.free_chunk;
    lists.free_chunk = lists.chunks[chunk].next;
    lists.chunks[chunk].next = next;
    lists.chunks[chunk].count = 0;
    return chunk;
}
void give_chunk(Lists& lists, std::uint32_t chunk) {
    lists.chunks[chunk].next = lists.free_chunk;
    lists.free_chunk = chunk;
}

void push_bucket(Lists& lists, std::uint32_t number, std::uint32_t block) {
    Bucket& bucket = lists.buckets[number];
    if (bucket.top == nil) {
        bucket.top = bucket.bottom = take_chunk(lists, nil);
    } else if (bucket.in_top == chunk_blocks) {
        lists.chunks[bucket.top].count = chunk_blocks;
        bucket.top = take_chunk(lists, bucket.top);
        bucket.in_top = 0;
        ++bucket.full;
    }
    BlockState& b = lists.blocks[block];
    b.link = {bucket.top, bucket.in_top};
    b.list = static_cast<ListId>(number);
    lists.chunks[bucket.top].blocks[bucket.in_top++] = block;
}

// The bucket's newest block takes its place.
void leave_bucket(Lists& lists, std::uint32_t block) {
    const BlockState& b = lists.blocks[block];
    Bucket& bucket = lists.buckets[b.list];
    const std::uint32_t moved = lists.chunks[bucket.top].blocks[--bucket.in_top];
    if (moved != block) {
        lists.chunks[b.link.next].blocks[b.link.prev] = moved;
        lists.blocks[moved].link = b.link;
    }
    if (bucket.in_top != 0) return;
    const std::uint32_t below = lists.chunks[bucket.top].next;
    give_chunk(lists, bucket.top);
    bucket.top = below;
    if (below == nil) return;
    bucket.in_top = chunk_blocks;
    --bucket.full;
}

// Full chunks, from the first to the last of a chain.
void append_full(Lists& lists, std::uint32_t grade, std::uint32_t first, std::uint32_t last) {
    DueBlocks& due = lists.due[grade];
    lists.chunks[last].next = nil;
    if (due.first == nil)
        due.first = first;
    else
        lists.chunks[due.last].next = first;
    due.last = last;
}

void add_due(Lists& lists, std::uint32_t grade, std::uint32_t block) {
    DueBlocks& due = lists.due[grade];
    if (due.filling == nil) due.filling = take_chunk(lists, nil);
    BlockChunk& chunk = lists.chunks[due.filling];
    chunk.blocks[chunk.count++] = block;
    if (chunk.count < chunk_blocks) return;
    append_full(lists, grade, due.filling, due.filling);
    due.filling = nil;
}

// Everything in a bucket becomes due, in O(1): full chunks as they are, the rest one by one.
void drain(Lists& lists, std::uint32_t grade, std::uint32_t number) {
    const Bucket bucket = std::exchange(lists.buckets[number], {nil, nil, 0, 0});
    if (bucket.top == nil) return;
    const BlockChunk top = lists.chunks[bucket.top];
    lists.sizes[due_lists + grade - soon_lists] += bucket.full * chunk_blocks + bucket.in_top;
    for (std::uint32_t i = 0; i < bucket.in_top; ++i) add_due(lists, grade, top.blocks[i]);
    give_chunk(lists, bucket.top);
    if (bucket.full != 0) append_full(lists, grade, top.next, bucket.bottom);
}

} // namespace

void set_tick(Lists& lists, double about_m) {
    int exponent = 0;
    (void)std::frexp(about_m, &exponent);
    lists.tick_m = std::ldexp(1.0, exponent - 1);
    lists.ticks_per_m = std::ldexp(1.0, 1 - exponent);
}

void clear_lists(Lists& lists, std::uint32_t chunk_count) {
    for (std::uint32_t i = 0; i < queue_count; ++i) lists.queues[i] = {lists.block_count + i, lists.block_count + i};
    for (std::uint32_t i = 0; i < due_lists; ++i) lists.buckets[i] = {nil, nil, 0, 0};
    for (std::uint32_t& n : lists.sizes) n = 0;
    for (DueBlocks& due : lists.due) due = {nil, nil, nil};
    for (auto& wheels : lists.filled)
        for (std::uint64_t& w : wheels) w = 0;
    for (std::uint32_t i = 0; i < chunk_count; ++i) lists.chunks[i].next = i + 1 < chunk_count ? i + 1 : nil;
    lists.free_chunk = 0;
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

void push_back(Lists& lists, std::uint32_t queue, std::uint32_t block) {
    BlockState& b = lists.blocks[block];
    const std::uint32_t head = lists.block_count + queue - work_lists;
    Link& ends = lists.queues[queue - work_lists];
    b.link = {head, ends.prev};
    link(lists, ends.prev).next = block;
    ends.prev = block;
    b.list = static_cast<ListId>(queue);
    ++lists.sizes[queue - soon_lists];
}

void push_front(Lists& lists, std::uint32_t queue, std::uint32_t block) {
    BlockState& b = lists.blocks[block];
    Link& ends = lists.queues[queue - work_lists];
    b.link = {ends.next, lists.block_count + queue - work_lists};
    link(lists, ends.next).prev = block;
    ends.next = block;
    b.list = static_cast<ListId>(queue);
    ++lists.sizes[queue - soon_lists];
}

void push_due(Lists& lists, std::uint32_t grade, std::uint32_t block) {
    BlockState& b = lists.blocks[block];
    b.grade = static_cast<std::uint8_t>(grade);
    b.list = static_cast<ListId>(due_lists + grade);
    ++lists.sizes[due_lists + grade - soon_lists];
    add_due(lists, grade, block);
}

void unlink(Lists& lists, std::uint32_t block) {
    BlockState& b = lists.blocks[block];
    if (b.list == no_list) return;
    if (b.list < due_lists) {
        leave_bucket(lists, block);
    } else {
        --lists.sizes[b.list - soon_lists];
        link(lists, b.link.prev).next = b.link.next;
        link(lists, b.link.next).prev = b.link.prev;
    }
    b.list = no_list;
}

std::uint32_t pop_front(Lists& lists, std::uint32_t queue) {
    const std::uint32_t block = lists.queues[queue - work_lists].next;
    unlink(lists, block);
    return block;
}

void forget_due(Lists& lists, std::uint32_t first, std::uint32_t count) {
    for (std::uint32_t grade = 0; grade < grade_count; ++grade) {
        DueBlocks old = lists.due[grade];
        lists.due[grade] = {nil, nil, nil};
        if (old.filling != nil) {
            lists.chunks[old.filling].next = nil;
            if (old.first == nil)
                old.first = old.filling;
            else
                lists.chunks[old.last].next = old.filling;
        }
        for (std::uint32_t chunk = old.first; chunk != nil;) {
            const BlockChunk c = lists.chunks[chunk];
            give_chunk(lists, chunk);
            for (std::uint32_t i = 0; i < c.count; ++i) {
                if (c.blocks[i] - first < count)
                    --lists.sizes[due_lists + grade - soon_lists];
                else
                    add_due(lists, grade, c.blocks[i]);
            }
            chunk = c.next;
        }
    }
}

void schedule(Lists& lists, std::uint32_t block, float slack_m, std::uint32_t grade) {
    BlockState& b = lists.blocks[block];
    b.grade = static_cast<std::uint8_t>(grade);
    const double ticks = std::min(static_cast<double>(slack_m) * lists.ticks_per_m, static_cast<double>(last_tick - 1));
    const auto due = static_cast<std::uint64_t>(lists.odometer_m[grade] * lists.ticks_per_m + ticks);
    const std::uint64_t now = lists.tick[grade];
    const bool soon = due <= now;
    const std::uint64_t stored = soon ? lists.moves[grade] : due;
    b.due = static_cast<std::uint32_t>(stored);
    b.due_high = static_cast<std::uint16_t>(stored >> 32);
    if (soon) return push_bucket(lists, soon_lists + grade, block);
    // 56 ticks and more go to the second wheel, 448 to the third ...
    const auto wheel = std::min((static_cast<std::uint32_t>(std::bit_width((due - now) / first_wheel_ticks)) + 2) / 3,
                                wheel_count - 1);
    const std::uint64_t bucket = due >> (3 * wheel);
    lists.filled[grade][wheel] |= std::uint64_t{1} << (bucket % wheel_buckets);
    push_bucket(lists, bucket_of(grade, wheel, bucket), block);
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
    lists.tick[grade] = static_cast<std::uint64_t>(lists.odometer_m[grade] * lists.ticks_per_m);
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
