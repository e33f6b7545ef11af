// The table through which the frame's thread and the client speak. No locks: each entry has one owner at a time, and
// its state says who; what an owner wrote before it gave the entry away, the next one sees.
#pragma once

#include <algorithm>

#include "stream/state.h"

namespace fjell {

[[nodiscard]] inline Phase phase_of(const Request& r) {
    return static_cast<Phase>(r.state.load(std::memory_order_acquire) & 7);
}
// Who has an entry may take it from one phase to these. Another step means that it has two owners.
[[nodiscard]] constexpr bool may_follow(Phase from, Phase to) {
    switch (to) {
    case Phase::ready:
    case Phase::unreadable:
    case Phase::damaged:
    case Phase::unwanted: return from == Phase::in_flight;
    case Phase::shown: return from == Phase::ready;
    case Phase::vacant: return from != Phase::queued && from != Phase::in_flight; // those end by claim()
    case Phase::queued: return from == Phase::vacant;
    case Phase::in_flight: break; // by claim()
    }
    return false;
}
// By the owner.
inline void set_phase(Request& r, Phase phase) {
    const std::uint32_t state = r.state.load(std::memory_order_relaxed);
    FJELL_ASSERT(may_follow(static_cast<Phase>(state & 7), phase));
    r.state.store((state & ~7u) | static_cast<std::uint32_t>(phase), std::memory_order_release);
}
// Between offered and what follows: false when the other thread was first.
[[nodiscard]] inline bool claim(Request& r, Phase phase) {
    FJELL_ASSERT(phase == Phase::vacant || phase == Phase::in_flight);
    std::uint32_t state = r.state.load(std::memory_order_acquire);
    if ((state & 7) != static_cast<std::uint32_t>(Phase::queued)) return false;
    return r.state.compare_exchange_strong(state, (state & ~7u) | static_cast<std::uint32_t>(phase),
                                           std::memory_order_acq_rel);
}

// Fills a vacant entry for `chunks` chunks from `id` on and offers it. False: they do not lie one after the other, or
// are larger than the entry's room.
[[nodiscard]] bool queue_request(StreamState& s, Request& r, const ChunkId& id, std::uint32_t chunks, float score);

// What has come among entries [begin, end) and was wanted most, or nullptr. Taken over in this order: in the table's
// own, its first entries, filled anew with every frame, would keep the others waiting for as long as anything comes.
[[nodiscard]] Request* best_ready(StreamState& s, std::uint32_t begin, std::uint32_t end);

// A vacant entry for a page or a map, or nullptr.
[[nodiscard]] Request* vacant_request(StreamState& s, bool map);

// --- the best few of many candidates

struct Candidate {
    std::uint32_t which; // a watch, a slot, or a tile
    std::uint32_t kind;  // of a map
    double score;
};

// A heap, the worst of the best on top, until sort() puts them in order.
struct Best {
    static constexpr std::uint32_t most = 64;
    Candidate at[most];
    std::uint32_t count = 0;

    // Of equals the first one, by number, is better: the order must not depend on the library.
    static bool better(const Candidate& a, const Candidate& b) {
        return a.score != b.score ? a.score > b.score : a.which != b.which ? a.which < b.which : a.kind < b.kind;
    }
    [[nodiscard]] bool takes(double score) const { return count < most || score > at[0].score; }
    void offer(const Candidate& c) {
        if (count == most) {
            if (!better(c, at[0])) return;
            std::pop_heap(at, at + count--, better);
        }
        at[count++] = c;
        std::push_heap(at, at + count, better);
    }
    // Best first. Nothing may be offered afterwards.
    void sort() { std::sort(at, at + count, better); }
};

} // namespace fjell
