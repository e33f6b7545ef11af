// What the recursive method keeps in the host's memory, between frames.
#pragma once

#include <cstdint>

#include "fjell/recursive.h"
#include "recursive/locate.h"

namespace fjell {

// What is known of a vertex: the pass' number * 3 + a Decision, in 16 bits. Numbers come again after `pass_numbers`
// passes, by when every status of before has been cleared: a pass clears a part of them, all are through sooner.
enum Decision : std::uint32_t { not_in, in_partly, in_wholly }; // selected, and how its sphere lies in the frustum
inline constexpr std::uint32_t pass_numbers = 21844, clearing_passes = 16384;
static_assert(clearing_passes < pass_numbers && 3 * pass_numbers + 2 < 65536);

struct RecursiveState {
    BlockHead head;
    Terrain terrain_handle;
    const TerrainData* terrain; // its data
    RecursiveBudget budget;
    // One a record of every page slot, as they lie there; then four a tile, its corners.
    std::uint16_t* statuses;
    std::uint32_t* slots; // in the vertex buffer, with hole_flag, or no_index
    std::size_t state_count;
    StepPageEntry* step_pages; // page table by steps, step_pages_per_tile a tile (locate.h)
    std::uint32_t step_pages_per_tile;
    std::uint32_t* slot_pages;  // what each page slot held at the last update
    float *x_m2, *z_m2;         // squared distances from the eye to the columns and rows of the tile in work
    std::uint64_t seen_changes; // TerrainData::changes then
    std::uint64_t seen_ground;  // and ground_changes
    MeshVertex* vertices;       // budget.vertices
    std::uint32_t* owners;      // state of each slot's vertex, or no_index
    std::uint32_t* free_slots;
    std::uint32_t free_count;
    std::uint32_t* indices; // budget.indices
    std::uint32_t index_count;
    TileRange* tiles;
    std::uint32_t tile_count;
    Topology topology;
    std::uint32_t base;  // of the last pass' statuses: its number, 1 to pass_numbers, * 3
    std::size_t cleared; // statuses from here on are the next to be cleared
    std::uint64_t frame;
    std::uint32_t dirty_begin, dirty_end;
    double effective_px;     // 0 before the first frame
    std::uint32_t exhausted; // BudgetBits that keep effective_px above the requested one
    std::uint32_t last_selected, last_indices;
};

// Of the last pass.
[[nodiscard]] inline bool is_selected(const RecursiveState& s, std::size_t index) {
    return static_cast<std::uint16_t>(s.statuses[index] - s.base - in_partly) <= in_wholly - in_partly;
}

// The method behind a handle, or nullptr: also when its terrain is gone.
[[nodiscard]] inline RecursiveState* find_recursive(const RecursiveMethod& method) {
    RecursiveState* const s = find(method);
    return s != nullptr && find(s->terrain_handle) != nullptr ? s : nullptr;
}
inline constexpr Status no_recursive{StatusCode::invalid_handle, "method, or its terrain"};

// Follows which pages are loaded; what was known of a slot's vertices is dropped when it holds another page.
void sync_pages(RecursiveState& s);

} // namespace fjell
