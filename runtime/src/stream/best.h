// The best few of many candidates.
#pragma once

#include <algorithm>
#include <cstdint>

namespace fjell {

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
