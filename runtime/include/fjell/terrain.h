// A pack's geometry in the host's memory. All methods and queries read it.
//
// Axes everywhere in Fjell: x east, y up, z south, in metres from sample (0, 0). Columns of the raster run along +x,
// rows along +z. Decoded pages lie in slots of page_capacity() records, 4 bytes a vertex. A page table says which slot
// has a page. Where a page is missing, methods draw coarser terrain. No crack appears, because a vertex is drawn only
// when its parents are. The corners of tiles are always loaded.
// Ownership: the terrain lies in the memory that create_terrain() was given; `Terrain` is a handle to it
// (fjell/handle.h). Thread: one thread loads and unloads pages, and edits the ground (fjell/edit.h). While none does,
// the terrain is immutable and can be shared. Queries for heights and rays (fjell/query.h) may run on any thread at any
// time. Failure: with a handle that is empty or refused, or a pack that is not the terrain's, a call returns a Status
// or zero.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fjell/export.h"
#include "fjell/handle.h"
#include "fjell/pack.h"
#include "fjell/sample_index.h"

FJELL_API_BEGIN
namespace fjell {

inline constexpr std::uint32_t no_tile = 0xffff'ffff;

struct TerrainData; // opaque, lives in the host's memory

class Terrain : public Handle<TerrainData> {
public:
    [[nodiscard]] bool valid() const; // false: the handle is empty or refused

    [[nodiscard]] const PackHeader& header() const; // of its pack; valid as long as the terrain
    [[nodiscard]] std::uint32_t columns() const;    // samples
    [[nodiscard]] std::uint32_t rows() const;
    [[nodiscard]] float spacing_x_m() const; // from column to column
    [[nodiscard]] float spacing_z_m() const; // from row to row
    // Where a sample is: column * spacing, rounded to float.
    [[nodiscard]] float x_m(std::int32_t column) const;
    [[nodiscard]] float z_m(std::int32_t row) const;
    [[nodiscard]] float extent_x_m() const; // where the last column is
    [[nodiscard]] float extent_z_m() const; // where the last row is
    [[nodiscard]] bool has_voids() const;   // some samples have no height

    // Tiles that the terrain has. A sparse pack set has fewer than its header's tiles_x * tiles_y (tiles_of()).
    [[nodiscard]] std::uint32_t tile_count() const;
    // The number of the tile at a place, and the place of the tile with a number. Places count tiles from sample (0,
    // 0). no_tile and {-1, -1}: no such tile; nothing is drawn there, and queries find no ground. O(1).
    [[nodiscard]] std::uint32_t tile_at(SampleIndex place) const;
    [[nodiscard]] SampleIndex tile_place(std::uint32_t tile) const;
    [[nodiscard]] std::uint32_t pages_per_tile() const;
    [[nodiscard]] std::uint32_t page_count() const; // of all tiles
    [[nodiscard]] std::uint32_t page_slots() const; // for which there is memory
    [[nodiscard]] std::uint32_t pages_loaded() const;
    [[nodiscard]] std::uint32_t pages_missing() const; // page_count() - pages_loaded()
    // The largest error on screen in pixels that missing pages may hide, of those that the views want; 0: none is
    // missing. In a view with a threshold of its own multiply it by View::max_error_px / CutSettings::max_error_px.
    // update_stream() sets it, and update_cut() reads it for its report.
    [[nodiscard]] double missing_px() const;
};

// Pages that the host gives memory for; 0: all pages of the pack.
struct TerrainBudget {
    std::uint32_t page_slots = 0;
};
// Bytes that create_terrain() needs. 0 for a header that check_ranges() refuses.
[[nodiscard]] std::size_t terrain_bytes(const PackHeader& header, const TerrainBudget& budget = {});

// Makes a terrain. Reads the corners of the tiles and no page. memory: at least terrain_bytes(), aligned to 64.
Status create_terrain(const Pack& pack, const TerrainBudget& budget, std::span<std::byte> memory, Terrain& terrain);
// The same for a pack from open_index(). corners: the stored bytes of its chunk of corners.
Status create_terrain(const Pack& pack, std::span<const std::byte> corners, const TerrainBudget& budget,
                      std::span<std::byte> memory, Terrain& terrain);

// Ends the terrain. Cuts, streams and recursive methods of it are refused from then on. Returns invalid_handle for a
// handle that is empty or refused.
Status destroy_terrain(const Terrain& terrain);

// Decodes a page into a free slot. Does nothing for a page that is loaded. Fails with out_of_slots if no slot is free,
// with coarser_page_first if a page of a coarser step over it is missing (the page's errors follow from its heights),
// and with corrupt if its bytes are damaged. Allocates nothing. O(vertices of a page).
Status load_page(const Pack& pack, const Terrain& terrain, std::uint32_t tile, std::uint32_t page);
// The same from a page's bytes that are checked and decompressed already (decode_chunk). The frame's thread may do
// this: some 5 to 10 us, no system call. Bytes that cannot be a page are refused as corrupt.
Status insert_page(const Terrain& terrain, std::uint32_t tile, std::uint32_t page, std::span<const std::byte> raw);
// Frees the slot of a page. Does nothing for a page that is not loaded.
Status unload_page(const Terrain& terrain, std::uint32_t tile, std::uint32_t page);

// Makes a terrain with room for all pages, and loads all of them. O(samples).
Status load_terrain(const Pack& pack, std::span<std::byte> memory, Terrain& terrain);

} // namespace fjell
FJELL_API_END
