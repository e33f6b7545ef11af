// The best few of many candidates.
#pragma once

#include <cstdint>

namespace fjell {

struct Candidate {
    std::uint32_t which; // a watch, or a tile
    std::uint32_t kind;  // of a map
    float score;
};

// Best first; of equals the first that came.
struct Best {
    static constexpr std::uint32_t most = 64;
    Candidate at[most];
    std::uint32_t count = 0;

    void offer(const Candidate& c) {
        if (count == most && !(c.score > at[most - 1].score)) return;
        std::uint32_t i = count < most ? count++ : most - 1;
        for (; i > 0 && at[i - 1].score < c.score; --i) at[i] = at[i - 1];
        at[i] = c;
    }
};

} // namespace fjell
