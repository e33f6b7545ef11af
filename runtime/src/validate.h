// Walks over a whole state: whatever can be checked from the state alone, for tests. What an assert sees at one place,
// these see from outside: that lists, masks, tables and counters still agree. O(what the state holds), no allocation.
//
// The library itself walks at the end of what changes a state when the CMake option FJELL_VALIDATE is on, and aborts
// with what it finds; otherwise it holds no walk, and the tests compile them. Thread: the frame's.
//
// Not walked over: numbers that a pack brings. A pack may lie about errors and radii, which costs its picture and never
// the cut's validity (`fjell-bake verify` compares them with the heights).
#pragma once

#include <cstdint>
#include <cstdio>

#include "asserts.h"
#include "fjell/sample_index.h"
#include "shared/compiler.h"

namespace fjell {

struct CutState;
struct StreamState;
struct TerrainData;

struct Violation {
    const char* what = nullptr; // nullptr: none
    SampleIndex at{-1, -1};     // sample, if it is a vertex'
    [[nodiscard]] explicit operator bool() const { return what != nullptr; }
};

// Pages, their slots and the free ones. Also between updates.
[[nodiscard]] Violation validate_terrain(const TerrainData& terrain);

// Invariant 1 (an active vertex' parents are active), masks, slots, triangles, lists, rings, written slots and the
// report; and that every vertex that could change is in a group that some list holds, and, in the calendar, agrees with
// the decision and is due before it could cease to. After an update or a rebuild, until the host moves pages.
[[nodiscard]] Violation validate_cut(const CutState& cut);

// Pages that are watched, requested, loaded and evicted, and layers of maps. After an update, while the client works;
// not when the host has moved pages of the stream's terrain.
[[nodiscard]] Violation validate_stream(const StreamState& stream);

// Each number of a set exactly once, without memory for the set: what was put in must have the sum of what should be.
// Sums of mixed numbers: that two sets have the same one by chance is as likely as a guessed 64-bit number.
struct Tally {
    std::uint64_t sum = 0;
    void add(std::uint64_t number) {
        number += 0x9e3779b97f4a7c15u; // splitmix64
        number = (number ^ number >> 30) * 0xbf58476d1ce4e5b9u;
        number = (number ^ number >> 27) * 0x94d049bb133111ebu;
        sum += number ^ number >> 31;
    }
    void add_range(std::uint64_t first, std::uint64_t end) {
        for (; first < end; ++first) add(first);
    }
    [[nodiscard]] bool operator==(const Tally&) const = default;
};

#ifdef FJELL_VALIDATE
// The first ones, every power of two and every 256th: all of them would take longer than the tests.
[[nodiscard]] constexpr bool is_walked_after(std::uint64_t event) {
    return (event & (event - 1)) == 0 || event % 256 == 0;
}
FJELL_COLD inline void abort_if(const Violation& found, const char* file, int line) {
    if (!found) return;
    char what[200]; // and where
    (void)std::snprintf(what, sizeof what, "%s (%d, %d)", found.what, found.at.column, found.at.row);
    fail_assert(file, line, what);
}
// Aborts with what a walk finds after an event; events are numbered from 1 on.
#define FJELL_WALK(event, walk)                                                                                        \
    (is_walked_after(event) ? ::fjell::abort_if((walk), __FILE__, __LINE__) : static_cast<void>(0))
#else
#define FJELL_WALK(event, walk) static_cast<void>(sizeof(walk))
#endif

} // namespace fjell
