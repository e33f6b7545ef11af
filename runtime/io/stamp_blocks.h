// How many blocks of 32 x 32 samples stamps may change: what EditBudget::blocks and EditBudget::paint need for them, or
// more. O(blocks); memory: some 40 bytes a block.
#pragma once

#include <cstdint>
#include <unordered_set>

#include "fjell/io/journal.h"
#include "fjell/pack.h"

namespace fjell::io {

class StampBlocks {
public:
    explicit StampBlocks(const PackHeader& pack);
    void add(const KeptStamp& stamp);
    [[nodiscard]] std::uint32_t heights() const { return static_cast<std::uint32_t>(heights_.size()); }
    [[nodiscard]] std::uint32_t paint() const { return static_cast<std::uint32_t>(paint_.size()); }

private:
    void add(double x0, double z0, double x1, double z1, const Stamp& stamp);
    std::uint32_t columns_, rows_;
    double spacing_m_[2];
    std::unordered_set<std::uint64_t> heights_, paint_;
};

} // namespace fjell::io
