// What a terrain keeps in the host's memory for loading pages: the arrays that its const pointers show, and scratch.
#pragma once

#include <cstddef>
#include <cstdint>

#include "shared/page.h"
#include "shared/terrain_data.h"

struct ZSTD_DCtx_s;

namespace fjell {

struct TerrainMemory {
    PageEntry* page_table;
    VertexRecord* records;
    std::uint32_t* slot_page;
    std::uint32_t* slot_loads;
    std::uint32_t* corners;
    std::uint32_t* tile_numbers; // of a sparse terrain, and the next two
    std::uint32_t* corner_numbers;
    std::uint32_t* tile_places;
    std::uint32_t* free_slots; // a stack
    std::uint32_t free_count;
    ZSTD_DCtx_s* zstd;
    std::byte* raw; // room for the largest page decompressed
    std::uint32_t raw_bytes;
    PageArrays arrays;
    CornerSteps coarse;
    std::uint32_t changed_slots[change_log];
    LeafErrors leaf;
    // Hierarchical Z-order only: which vertex of the canonical order stands at each place, in page 0 and in any other.
    std::uint16_t page_vertex_at[max_page_vertices];
    std::uint16_t root_vertex_at[(page_squares + 1) * (page_squares + 1)];
};

} // namespace fjell
