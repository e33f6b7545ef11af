// What tests of the bulk pass' rows share: all lengths of vectors, random bits, room for triangles.
#pragma once

#include <catch2/catch.hpp>

#include <hwy/targets.h>

#include <algorithm>
#include <vector>

#include "cut/bulk_rows.h"
#include "support/cut_scene.h"

namespace fjell::test {

// Once with each kind of vectors, the best last, which stays.
template <typename Check>
void with_all_vectors(const Check& check) {
    hwy::SetSupportedTargetsForTest(0);
    const std::int64_t here = hwy::SupportedTargets();
    for (std::int64_t left = here; left != 0; left &= left - 1) { // a lower bit is a better one
        hwy::SetSupportedTargetsForTest(left);
        hwy::GetChosenTarget().Update(left);
        CAPTURE(hwy::TargetName(left & -left));
        check();
    }
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(here);
}

inline std::uint32_t random_bits(Random& random) {
    std::uint32_t bits = 0;
    for (int n = 0; n < 32; ++n) bits |= static_cast<std::uint32_t>(pick(random, 0, 1)) << n;
    for (int thinner = pick(random, 0, 3); thinner > 0; --thinner)
        for (int n = 0; n < 32; ++n) bits &= ~(static_cast<std::uint32_t>(pick(random, 0, 1)) << n);
    return bits;
}

// Room for some triangles, and what is beyond it must stay.
struct Buffers {
    static constexpr std::uint32_t vertices = 512, slots = 160, untouched = 0xabcdef01;
    std::vector<std::uint32_t> indices = std::vector<std::uint32_t>(slots * 3, untouched);
    std::vector<std::uint32_t> triangle_of = std::vector<std::uint32_t>(vertices * 4, untouched);
    FanOut out{indices.data(), triangle_of.data(), 0, 0};
};

// Slots before `next` hold what they should, those from `end` on what they did.
inline void require_alike(const Buffers& fast, const Buffers& plain) {
    REQUIRE(fast.out.next == plain.out.next);
    const std::size_t written = std::size_t{plain.out.next} * 3, end = std::size_t{plain.out.end} * 3;
    REQUIRE(std::equal(plain.indices.begin(), plain.indices.begin() + static_cast<std::ptrdiff_t>(written),
                       fast.indices.begin()));
    REQUIRE(std::all_of(fast.indices.begin() + static_cast<std::ptrdiff_t>(end), fast.indices.end(),
                        [](std::uint32_t index) { return index == Buffers::untouched; }));
    REQUIRE(fast.triangle_of == plain.triangle_of);
}

} // namespace fjell::test
