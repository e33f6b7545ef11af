// A pack's geometry in the host's memory: what every method and query reads.
//
// Axes everywhere in Fjell: x east, y up, z south, metres, from sample (0, 0). Raster columns run along +x, rows along
// +z. Decoded pages lie in slots of page_capacity() records, 4 bytes a vertex; the page table says which slot holds a
// page. A page may be missing: methods then draw coarser terrain there, never a crack, because a vertex is drawn only
// when its parents are. The corners of tiles are always there.
// Ownership: the terrain lies in the memory that create_terrain was given; `Terrain` is a handle to it
// (fjell/handle.h). Thread: one that loads and unloads; between those, immutable and shareable. Queries (fjell/query.h)
// may run on any thread at any time. Heights are asked for there. Failure: of an empty or a refused handle, and for a
// pack that is not the terrain's, a Status; values are 0 then.
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
    [[nodiscard]] bool valid() const; // there is a terrain behind it

    [[nodiscard]] const PackHeader& header() const; // of its pack; valid as long as the terrain
    [[nodiscard]] std::uint32_t columns() const;    // samples
    [[nodiscard]] std::uint32_t rows() const;
    [[nodiscard]] float spacing_x_m() const;            // from column to column
    [[nodiscard]] float spacing_z_m() const;            // from row to row
    [[nodiscard]] float x_m(std::int32_t column) const; // where a sample is: column * spacing, rounded to float
    [[nodiscard]] float z_m(std::int32_t row) const;
    [[nodiscard]] float extent_x_m() const; // of the last column
    [[nodiscard]] float extent_z_m() const; // of the last row
    [[nodiscard]] bool has_voids() const;   // there are samples without a height

    [[nodiscard]] std::uint32_t tile_count() const; // that there are: all, but of a sparse pack set (tiles_of())
    // The number of the tile at a place, counted in tiles from sample (0, 0), and the place of a numbered one. no_tile
    // and {-1, -1}: there is none, so that nothing is drawn there and queries find no ground. O(1).
    [[nodiscard]] std::uint32_t tile_at(SampleIndex place) const;
    [[nodiscard]] SampleIndex tile_place(std::uint32_t tile) const;
    [[nodiscard]] std::uint32_t pages_per_tile() const;
    [[nodiscard]] std::uint32_t page_count() const; // of all tiles
    [[nodiscard]] std::uint32_t page_slots() const; // that there is memory for
    [[nodiscard]] std::uint32_t pages_loaded() const;
    [[nodiscard]] std::uint32_t pages_missing() const; // page_count() - pages_loaded()
    // The largest error on screen, in pixels, that missing pages which the views want may hide; 0: none. In views with
    // a threshold of their own (View::max_error_px) by that over CutSettings::max_error_px more. Set by what loads
    // pages for the views (update_stream), read by update_cut for its report.
    [[nodiscard]] double missing_px() const;
};

// Pages that the host gives memory for; 0: all of the pack.
struct TerrainBudget {
    std::uint32_t page_slots = 0;
};
// 0 for a header that check_ranges() refuses.
[[nodiscard]] std::size_t terrain_bytes(const PackHeader& header, const TerrainBudget& budget = {});

// Reads the corners and no page. memory: at least terrain_bytes(), aligned to 64.
Status create_terrain(const Pack& pack, const TerrainBudget& budget, std::span<std::byte> memory, Terrain& terrain);
// The same for a pack of open_index(). corners: the stored bytes of its chunk of corners.
Status create_terrain(const Pack& pack, std::span<const std::byte> corners, const TerrainBudget& budget,
                      std::span<std::byte> memory, Terrain& terrain);

// Ends the terrain; cuts, streams and recursive methods of it are refused from then on. Invalid_handle if there is
// none.
Status destroy_terrain(const Terrain& terrain);

// Decodes a page into a free slot. Fails with out_of_slots when there is none, with coarser_page_first when a page of a
// coarser step over it is missing (its errors follow from their heights), with corrupt when its bytes are. Loading a
// page that is there does nothing. Allocates nothing. O(vertices of a page).
Status load_page(const Pack& pack, const Terrain& terrain, std::uint32_t tile, std::uint32_t page);
// The same from a page's bytes, checked and decompressed already (decode_chunk). The frame's thread may do this: some 5
// to 10 us, no system call. Any bytes: what cannot be a page is corrupt.
Status insert_page(const Terrain& terrain, std::uint32_t tile, std::uint32_t page, std::span<const std::byte> raw);
// Frees its slot. Unloading a page that is not there does nothing.
Status unload_page(const Terrain& terrain, std::uint32_t tile, std::uint32_t page);

// create_terrain with room for all pages, and all of them loaded. O(samples).
Status load_terrain(const Pack& pack, std::span<std::byte> memory, Terrain& terrain);

} // namespace fjell
FJELL_API_END
