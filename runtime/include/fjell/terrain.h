// A pack's geometry in the host's memory: what every method and query reads.
//
// Axes everywhere in Fjell: x east, y up, z south, metres, from sample (0, 0). Raster columns run along +x, rows along
// +z. Decoded pages lie in slots of page_capacity() records, 4 bytes a vertex; the page table says which slot holds a
// page. A page may be missing: methods then draw coarser terrain there, never a crack, because a vertex is drawn only
// when its parents are. The corners of tiles are always there.
// Ownership: Terrain points into the memory that create_terrain was given. Thread: one that loads and unloads; between
// those, immutable and shareable. Queries (fjell/query.h) may run on any thread at any time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fjell/export.h"
#include "fjell/order.h"
#include "fjell/pack.h"
#include "fjell/record.h"

FJELL_API_BEGIN
namespace fjell {

inline constexpr std::uint32_t change_log = 256; // changes that Terrain::changed_slots remembers

struct alignas(8) PageEntry { // read at once by queries of other threads
    std::uint32_t slot;       // no_index: not loaded
    std::int32_t base;        // height scale steps its heights are counted from
};

struct TerrainMemory; // what loading needs, in the host's memory

struct Terrain {
    PackHeader header{};
    Tree tree;
    PageLayout pages;
    HeightScale height_scale;
    float spacing_x_m = 1, spacing_z_m = 1;
    ErrorScale errors;
    RadiusScale radii;
    std::uint32_t pages_per_tile = 0, page_capacity = 0;
    std::uint32_t slot_count = 0;
    const PageEntry* page_table = nullptr;     // tile_count * pages_per_tile
    const VertexRecord* records = nullptr;     // slot_count * page_capacity
    const std::uint32_t* slot_page = nullptr;  // what each slot holds (tile * pages_per_tile + page), or no_index
    const std::uint32_t* slot_loads = nullptr; // how often a page was loaded into each slot
    const std::uint32_t* corners = nullptr;    // (tiles_x + 1) * (tiles_y + 1), as stored (corner_void_bit)
    std::uint32_t pages_missing = 0;
    std::uint64_t changes = 0; // pages loaded or unloaded so far; the n-th one in slot changed_slots[n % change_log]
    const std::uint32_t* changed_slots = nullptr;
    // The largest error on screen, in pixels, that missing pages which the views want may hide; 0: none. Set by what
    // loads pages for the views (update_stream), read by update_cut for its report.
    double missing_px = 0;
    TerrainMemory* memory = nullptr;

    [[nodiscard]] std::uint32_t tile_count() const { return header.tiles_x * header.tiles_y; }
    [[nodiscard]] std::uint32_t page_count() const { return tile_count() * pages_per_tile; }
    [[nodiscard]] bool has_voids() const { return header.voids != 0; }

    // Position of a sample, one fixed float expression: the baker measures radii with the very same one.
    [[nodiscard]] float x_m(std::int32_t column) const { return static_cast<float>(column) * spacing_x_m; }
    [[nodiscard]] float z_m(std::int32_t row) const { return static_cast<float>(row) * spacing_z_m; }

    // One vertex with its numbers decoded; slow and convenient. Any vertex of the grid, also beyond the
    // terrain's rim. Tile corners have neither error nor radius. `loaded` false: its page is missing, and nothing else
    // is set.
    struct Vertex {
        bool loaded = false, hole = false;
        std::int32_t steps = 0; // on the height scale
        std::uint8_t error_code = 0;
        float height_m = 0, error_m = 0, radius_m = 0;
    };
    [[nodiscard]] Vertex vertex(Coord v) const;
    [[nodiscard]] float height_m(Coord sample) const { return vertex(sample).height_m; }
    // A sample without a height. Its vertex stands on a smooth continuation of the ground around the hole.
    [[nodiscard]] bool is_hole(Coord sample) const { return has_voids() && vertex(sample).hole; }
    // Bilinear height of the full-resolution grid; positions outside are clamped to the rim. Needs their pages.
    [[nodiscard]] double ground_m(double x, double z) const;
};

// Pages that the host gives memory for; 0: all of the pack.
struct TerrainBudget {
    std::uint32_t page_slots = 0;
};
[[nodiscard]] std::size_t terrain_bytes(const PackHeader& header, const TerrainBudget& budget = {});

// Reads the corners and no page. memory: at least terrain_bytes(), aligned to 64.
Status create_terrain(const Pack& pack, const TerrainBudget& budget, std::span<std::byte> memory, Terrain& terrain);
// The same for a pack of open_index(). corners: the stored bytes of its chunk of corners.
Status create_terrain(const Pack& pack, std::span<const std::byte> corners, const TerrainBudget& budget,
                      std::span<std::byte> memory, Terrain& terrain);

// Decodes a page into a free slot. Fails with out_of_slots when there is none, with coarser_page_first when a page of a
// coarser step over it is missing (its errors follow from their heights), with corrupt when its bytes are. Loading a
// page that is there does nothing. Allocates nothing. O(vertices of a page).
Status load_page(const Pack& pack, Terrain& terrain, std::uint32_t tile, std::uint32_t page);
// The same from a page's bytes, checked and decompressed already (decode_chunk). The frame's thread may do this: some 5
// to 10 us, no system call. Any bytes: what cannot be a page is corrupt.
Status insert_page(Terrain& terrain, std::uint32_t tile, std::uint32_t page, std::span<const std::byte> raw);
void unload_page(Terrain& terrain, std::uint32_t tile, std::uint32_t page);

// create_terrain with room for all pages, and all of them loaded. O(samples).
Status load_terrain(const Pack& pack, std::span<std::byte> memory, Terrain& terrain);

} // namespace fjell
FJELL_API_END
