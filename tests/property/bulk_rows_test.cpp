// What the bulk pass does to rows of bits and of corners, against the plainest way to say the same, with vectors of
// every length that this machine has.
#include <catch2/catch.hpp>

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

#include "bulk_rows.h"
#include "cut/bulk_rows.h"

using namespace fjell;
using namespace fjell::test;

namespace {

constexpr std::uint32_t row_corners = page_squares + 2;
using Corners = std::array<std::uint32_t, row_corners>;
Corners random_corners(Random& random, std::uint32_t vertices) {
    Corners corners;
    for (std::uint32_t& slot : corners)
        slot = static_cast<std::uint32_t>(pick(random, 0, static_cast<int>(vertices) - 1));
    return corners;
}

// drawn(i, d): is the triangle of vertex i in direction d; other(i, d, n): its two other corners.
template <typename Drawn, typename Other>
std::uint32_t plainly(Buffers& to, const Corners& slots, std::uint32_t active, const Drawn& drawn, const Other& other) {
    for (std::uint32_t i = 0; i < page_squares; ++i) {
        if (!(active >> i & 1)) continue;
        if (to.out.next + 4 > to.out.end) return active >> i << i;
        for (std::uint32_t d = 0; d < 4; ++d) {
            to.triangle_of[slots[i] * 4 + d] = drawn(i, d) ? to.out.next : no_index;
            if (!drawn(i, d)) continue;
            std::uint32_t* const at = to.indices.data() + std::size_t{to.out.next++} * 3;
            at[0] = slots[i], at[1] = other(i, d, 0), at[2] = other(i, d, 1);
        }
    }
    return 0;
}

} // namespace

TEST_CASE("fans around a row's vertices are those made one by one, in whatever room there is") {
    Random random(301);
    with_all_vectors([&] {
        std::uint32_t cut_short = 0;
        for (int round = 0; round < 2'000; ++round) {
            const Corners slots = random_corners(random, Buffers::vertices), a = random_corners(random, 1 << 30),
                          b = random_corners(random, 1 << 30), c = random_corners(random, 1 << 30);
            const std::uint32_t active = random_bits(random);
            Buffers fast, plain;
            fast.out.next = plain.out.next = static_cast<std::uint32_t>(pick(random, 0, 20));
            fast.out.end = plain.out.end =
                static_cast<std::uint32_t>(pick(random, 0, static_cast<int>(Buffers::slots)));
            std::uint32_t left = 0, left_plainly = 0;
            if (round % 2 == 0) {
                const CentreRow row{slots.data(),
                                    a.data(),
                                    b.data(),
                                    random_bits(random) | std::uint64_t{random_bits(random)} << 32,
                                    random_bits(random),
                                    random_bits(random)};
                const auto drawn = [&](std::uint32_t i, std::uint32_t d) {
                    return d < 2 ? (row.sides_y >> (i + d) & 1) != 0 : ((d == 2 ? row.north : row.south) >> i & 1) != 0;
                };
                const auto other = [&](std::uint32_t i, std::uint32_t d, std::uint32_t n) {
                    const std::uint32_t nw = a[i], ne = a[i + 1], sw = b[i], se = b[i + 1];
                    const std::uint32_t corners[4][2] = {{nw, sw}, {se, ne}, {ne, nw}, {sw, se}};
                    return corners[d][n];
                };
                left = fan_centres(fast.out, row, active);
                left_plainly = plainly(plain, slots, active, drawn, other);
            } else {
                const SideRow row{slots.data(),
                                  a.data(),
                                  b.data(),
                                  c.data(),
                                  random_bits(random) | std::uint64_t{random_bits(random)} << 32,
                                  random_bits(random) | std::uint64_t{random_bits(random)} << 32};
                const auto drawn = [&](std::uint32_t i, std::uint32_t d) {
                    return ((d < 2 ? row.up : row.down) >> (2 * i + d % 2) & 1) != 0;
                };
                const auto other = [&](std::uint32_t i, std::uint32_t d, std::uint32_t n) {
                    const std::uint32_t west = a[i], east = a[i + 1], north = b[i], south = c[i];
                    const std::uint32_t corners[4][2] = {{north, west}, {east, north}, {west, south}, {south, east}};
                    return corners[d][n];
                };
                left = fan_sides(fast.out, row, active);
                left_plainly = plainly(plain, slots, active, drawn, other);
            }
            REQUIRE(left == left_plainly);
            require_alike(fast, plain);
            cut_short += left != 0;
        }
        REQUIRE(cut_short > 100);
    });
}

TEST_CASE("groups made from rows of bits hold the bits of their lanes") {
    Random random(302);
    with_all_vectors([&] {
        for (int round = 0; round < 2'000; ++round) {
            const auto rows = static_cast<std::uint32_t>(pick(random, 1, page_squares + 1)),
                       a_row = static_cast<std::uint32_t>(pick(random, 1, 2));
            std::uint32_t words[7][page_squares + 1];
            for (auto& array : words)
                for (std::uint32_t& word : array) word = random_bits(random);
            std::vector<GroupState> groups(2 * (page_squares + 2));
            std::memset(static_cast<void*>(groups.data()), 0x5a, groups.size() * sizeof(GroupState));
            write_groups(groups.data(), rows, a_row,
                         {words[0], {words[1], words[2]}, {words[3], words[4], words[5], words[6]}});
            bool alike = true;
            for (std::uint32_t n = 0; n < groups.size(); ++n) {
                const GroupState& group = groups[n];
                const std::uint16_t fields[7] = {group.active,   group.parent[0], group.parent[1], group.child[0],
                                                 group.child[1], group.child[2],  group.child[3]};
                const bool written = n < rows * a_row;
                for (std::uint32_t field = 0; field < 7; ++field) {
                    const std::uint32_t word = written ? words[field][n / a_row] >> (16 * (n % a_row)) : 0x5a5a;
                    alike = alike && fields[field] == static_cast<std::uint16_t>(word);
                }
                alike = alike && group.queue == (written ? unqueued : 0x5a5a);
            }
            REQUIRE(alike);
        }
    });
}

TEST_CASE("rows of bits are split and counted bit for bit") {
    Random random(303);
    with_all_vectors([&] {
        for (int round = 0; round < 2'000; ++round) {
            const auto count = static_cast<std::uint32_t>(pick(random, 0, 2 * page_squares + 1));
            std::uint64_t rows[2 * page_squares + 1];
            std::uint32_t words[2 * page_squares + 1], even[2 * page_squares + 2], odd[2 * page_squares + 2];
            for (std::uint64_t& row : rows) row = random_bits(random) | std::uint64_t{random_bits(random)} << 32;
            for (std::uint32_t& word : words) word = random_bits(random);
            even[count] = odd[count] = 0x5a5a5a5a;
            split_rows(rows, count, even, odd);
            std::uint32_t bits = 0;
            bool alike = true;
            for (std::uint32_t n = 0; n < count; ++n) {
                for (std::uint32_t bit = 0; bit < 32; ++bit)
                    alike = alike && (even[n] >> bit & 1) == (rows[n] >> 2 * bit & 1) &&
                            (odd[n] >> bit & 1) == (rows[n] >> (2 * bit + 1) & 1);
                for (std::uint32_t bit = 0; bit < 32; ++bit) bits += words[n] >> bit & 1;
            }
            REQUIRE(alike);
            REQUIRE(count_bits(words, count) == bits);
            REQUIRE((even[count] == 0x5a5a5a5a && odd[count] == 0x5a5a5a5a));
        }
    });
}
