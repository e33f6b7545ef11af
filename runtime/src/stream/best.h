// The best few of many candidates.
#pragma once

#include <cstdint>

namespace fjell {

struct Candidate {
    std::uint32_t which; // a watch, or a tile
    std::uint32_t kind;  // of a map
    double score;
};

// Best first; of equals the first that came.
struct Best {
    static constexpr std::uint32_t most = 64;
    Candidate at[most];
    std::uint32_t count = 0;

    [[nodiscard]] bool takes(double score) const { return count < most || score > at[most - 1].score; }
    void offer(const Candidate& c) {
        if (!takes(c.score)) return;
        std::uint32_t i = count < most ? count++ : most - 1;
        for (; i > 0 && at[i - 1].score < c.score; --i) at[i] = at[i - 1];
        at[i] = c;
    }
};

} // namespace fjell
