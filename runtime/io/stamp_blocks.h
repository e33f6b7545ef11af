// How many blocks of 32 x 32 samples stamps may change: what EditBudget::blocks, paint and locks need for them, or
// more. A stamp with which they would be more than most_stamp_blocks is left out, and refused when its turn comes: a
// file must not ask for all memory. O(blocks); memory: some 40 bytes a block. By the public headers alone, because a
// shared library hides what knows the samples of a stamp.
#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_set>

#include "fjell/io/journal.h"
#include "fjell/pack.h"

namespace fjell::io {

inline constexpr std::size_t most_stamp_blocks = std::size_t{1} << 18; // as many samples as a bake changes, 1.1 GB

class StampBlocks {
public:
    explicit StampBlocks(const PackHeader& pack);
    void add(const KeptStamp& stamp);
    [[nodiscard]] std::uint32_t heights() const { return static_cast<std::uint32_t>(heights_.size()); }
    [[nodiscard]] std::uint32_t paint() const { return static_cast<std::uint32_t>(paint_.size()); }
    [[nodiscard]] std::uint32_t locks() const { return static_cast<std::uint32_t>(locks_.size()); }

private:
    void add(double x0, double z0, double x1, double z1, const Stamp& stamp);
    std::uint32_t columns_, rows_;
    double spacing_m_[2];
    std::unordered_set<std::uint64_t> heights_, paint_, locks_;
};

} // namespace fjell::io
