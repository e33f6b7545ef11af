// What the recursive method keeps in the host's memory, between frames.
#pragma once

#include <cstdint>

#include "fjell/recursive.h"
#include "recursive/locate.h"

namespace fjell {

struct VertexState {
    std::uint32_t status; // frame * 3 + {0: not selected, 1: selected, sphere partly inside, 2: completely inside}
    std::uint32_t slot;   // in the vertex buffer, with hole_flag, or no_index
};

struct RecursiveState {
    BlockHead head;
    Terrain terrain_handle;
    const TerrainData* terrain; // its data
    RecursiveBudget budget;
    VertexState* states; // one a record of every page slot, as they lie there; then four a tile, its corners
    std::size_t state_count;
    StepPageEntry* step_pages; // page table by steps, step_pages_per_tile a tile (locate.h)
    std::uint32_t step_pages_per_tile;
    std::uint32_t* slot_pages;  // what each page slot held at the last update
    std::uint64_t seen_changes; // TerrainData::changes then
    MeshVertex* vertices;       // budget.vertices
    std::uint32_t* owners;      // state of each slot's vertex, or no_index
    std::uint32_t* free_slots;
    std::uint32_t free_count;
    std::uint32_t* indices; // budget.indices
    std::uint32_t index_count;
    TileRange* tiles;
    std::uint32_t tile_count;
    Topology topology;
    std::uint32_t pass; // status base is pass * 3
    std::uint64_t frame;
    std::uint32_t dirty_begin, dirty_end;
    double effective_px;     // 0 before the first frame
    std::uint32_t exhausted; // BudgetBits that keep effective_px above the requested one
    std::uint32_t last_selected, last_indices;
};

// The method behind a handle, or nullptr: also when its terrain is gone.
[[nodiscard]] inline RecursiveState* find_recursive(const RecursiveMethod& method) {
    RecursiveState* const s = find(method);
    return s != nullptr && find(s->terrain_handle) != nullptr ? s : nullptr;
}
inline constexpr Status no_recursive{Code::invalid_handle, "method, or its terrain"};

// Follows which pages are loaded; what was known of a slot's vertices is dropped when it holds another page.
void sync_pages(RecursiveState& s);

} // namespace fjell
