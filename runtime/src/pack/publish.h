// Pages change hands here: the frame's thread writes and unloads them, any thread reads their vertices meanwhile. No
// locks, and nobody waits.
//
// What is shared are plain arrays in the host's memory: the page table (8 bytes a page: slot and base), how often a
// page was loaded into each slot, and the records. The writer and the readers of other threads touch them by atomic
// operations only, of whole entries and whole records, so nothing is torn. The frame's own thread reads as it likes.
//
// The writer, one thread:
//   unload  U: entry = none (release)
//   insert  B: loads[slot] += 1 (release), a release fence
//           R: the records (relaxed)
//           P: entry = {slot, base} (release)
//   A slot is free, so its page's U is past, before the next B of that slot.
// A reader of one record:
//   1. entry (acquire)   2. loads[slot] (acquire) = g   3. entry again (acquire), must be the same
//   4. the record        5. an acquire fence            6. loads[slot], must still be g
//
// What it gets is the record that load g of the slot wrote, and load g was of the page that was requested. Proof:
// - The entry of 3 was published by load g. Say it was by load i of the slot, of this page. 3 acquires P of i, hence B
//   of i is visible to 6, and i <= g by 6. If i < g, then U of load i comes before B of g, which 2 has acquired: 3
//   would have found that U or something later than it. So i = g. It does not matter that 1 may have seen the same
//   bits from an older load of the same page (out, another page in its slot, in again): the bits are equal, base
//   included, and it is 3 that counts. With 3 after the record the proof fails: 1 sees the older load, 2 the counter of
//   the newest while its records are still being written, 4 reads the other page's record, and 3 the new publication.
// - The record is not older than load g: 3 has acquired P of g, which comes after R of g.
// - The record is not newer: had 4 read what load k > g wrote, then by the fences B of k would be visible to 6.
// After 1 to 3 the page may be read on with 4 to 6 alone, as long as 6 holds: the records are those of load g even when
// the page has been unloaded since. What a page holds changes only by edits, which tell queries so (query/steady.h);
// so vertices of one query may be of any times.
// Counters wrap after 2^32 loads of one slot; a reader would have to sleep through exactly so many.
#pragma once

#include <cstdint>
#include <cstring>
#include <span>

#include "shared/compiler.h"
#include "shared/terrain_data.h"

namespace fjell {

static_assert(sizeof(VertexRecord) == sizeof(std::uint32_t), "a record is read and written at once");
static_assert(sizeof(PageEntry) == 8 && alignof(PageEntry) == 8, "an entry is read and written at once");

// --- the frame's thread

inline void publish_entry(PageEntry& entry, PageEntry value) {
    store_release(entry, value);
}
// Before records are written to a slot.
inline void begin_slot(std::uint32_t& loads) {
    store_release(loads, loads + 1);
    fence_release();
}
inline void write_record(VertexRecord* to, std::uint32_t packed) {
    store_word_relaxed(to, packed);
}
// Several records at a time, from an aligned place on; single ones took three times as long.
inline constexpr std::uint32_t records_at_once = 4;
[[nodiscard]] inline bool takes_several(const VertexRecord* to) {
    return reinterpret_cast<std::uintptr_t>(to) % (records_at_once * sizeof(VertexRecord)) == 0;
}
// Two of them: atomic in the language too.
inline void write_pair(VertexRecord* to, std::uint64_t packed) {
    store_pair_relaxed(to, packed);
}

// Four of them in a register, where FJELL_WRITES_FOURS: one store of 16 aligned bytes, of which the machine tears no
// eight; volatile, so that no compiler makes anything else of it, and fences order it as they do atomic ones.
template <class Register>
inline void write_four(VertexRecord* to, Register packed) {
    static_assert(sizeof packed == records_at_once * sizeof(VertexRecord));
    *reinterpret_cast<volatile Register*>(to) = packed; // registers may alias
}

// --- any thread

// A page as a reader has found it: steps 1 to 3.
struct PublishedPage {
    std::uint32_t slot = no_index;
    std::int32_t base = 0;
    std::uint32_t loads = 0;
    const VertexRecord* records = nullptr; // its slot's
};
// False: it is not loaded, or was on its way out or in.
[[nodiscard]] inline bool find_page(const TerrainData& terrain, std::size_t page, PublishedPage& found) {
    const PageEntry first = load_acquire(terrain.page_table[page]);
    if (first.slot == no_index) return false;
    found.loads = load_acquire(terrain.slot_loads[first.slot]);
    const PageEntry again = load_acquire(terrain.page_table[page]);
    found.slot = first.slot;
    found.base = first.base;
    found.records = terrain.records + std::size_t{first.slot} * terrain.page_capacity;
    return again.slot == first.slot && again.base == first.base;
}
// Where a record would be read; null: its page is not loaded. For fetching it into the cache, and nothing else.
[[nodiscard]] inline const VertexRecord* find_place(const TerrainData& terrain, std::size_t page, std::uint32_t index) {
    const std::uint32_t slot = load_relaxed(terrain.page_table[page]).slot;
    if (slot == no_index) return nullptr;
    return terrain.records + std::size_t{slot} * terrain.page_capacity + index;
}
// Steps 4 to 6. False: another page has come into the slot.
[[nodiscard]] inline bool read_record(const TerrainData& terrain, const PublishedPage& page, std::uint32_t index,
                                      VertexRecord& record) {
    const VertexRecord* const from = page.records + index;
    const std::uint32_t word = load_word_relaxed(from);
    fence_acquire();
    std::memcpy(&record, &word, sizeof record);
    return load_relaxed(terrain.slot_loads[page.slot]) == page.loads;
}
// The same of some that lie side by side: 5 and 6 once for all.
[[nodiscard]] inline bool read_records(const TerrainData& terrain, const PublishedPage& page, std::uint32_t first,
                                       std::span<VertexRecord> records) {
    const VertexRecord* from = page.records + first;
    for (VertexRecord& record : records) {
        const std::uint32_t word = load_word_relaxed(from++);
        std::memcpy(&record, &word, sizeof record);
    }
    fence_acquire();
    return load_relaxed(terrain.slot_loads[page.slot]) == page.loads;
}

} // namespace fjell
