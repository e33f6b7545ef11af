// A pack set: packs of parts of one terrain, opened as one pack.
//
// A terrain that is too large for one file, or that several machines have baked, is a set of packs. Each pack has a
// rectangle of the terrain's tiles. make_set_index() joins the directories of the packs, so that the rest of Fjell sees
// a single pack of a single file. That file exists on no disk. It consists of a header of 512 bytes, the files of the
// packs one after the other, and a tail (corners, directory, tiles). Whoever reads for the set looks up which file has
// an offset of it; io::PackFile does.
// Tiles that no pack has are missing. Nothing is drawn there, queries find no ground, and each missing tile costs 8
// bytes. Such a terrain is sparse: the numbers of its tiles (tiles_of()) skip the missing ones, and Terrain::tile_at()
// and tile_place() convert between places and numbers.
// The packs of a set must have the same tile size, order, spacing, map sizes and CRS, and the same scales of heights,
// errors and radii. All of this is compared, and so are the corners where tiles meet. Whether the packs were baked from
// one height field cannot be seen from their directories. `fjell-bake join` and `fjell-bake verify` read the borders of
// the tiles to check that.
// Ownership: the index lies in the host's memory. Afterwards only the files of the packs are needed. Thread: any.
// Complexity: O(chunks + places for tiles). zstd may allocate. Failure: a Status. at_fault is the number of the pack at
// fault, or the number of packs if no single pack is.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fjell/export.h"
#include "fjell/pack.h"
#include "fjell/status.h"

FJELL_API_BEGIN
namespace fjell {

// One pack of the set.
struct SetPart {
    const Pack* pack = nullptr;         // from open_index() or open_pack()
    std::span<const std::byte> corners; // its chunk of corners, as stored
    // Where its north-western tile is, in tiles from the north-western tile of the set.
    std::uint32_t tile_x = 0, tile_y = 0;
};
// The samples of the whole terrain: 2 to max_columns along each side.
struct SetShape {
    std::uint32_t columns = 0, rows = 0;
};

// The header and the tail of the file that a set stands for. All spans point into the memory that make_set_index() was
// given.
struct SetIndex {
    std::span<const std::byte> header;    // the first 512 bytes, for open_index()
    std::span<const std::byte> tail;      // from tail_offset to the end of the file
    std::span<const std::byte> corners;   // in the tail, as stored, for create_terrain()
    std::span<const std::byte> directory; // in the tail, up to its end, for open_index()
    std::uint64_t tail_offset = 0;
    std::uint64_t file_bytes = 0; // the length of the whole file
};

// Bytes that make_set_index() needs. 0 for parts that it refuses before it reads their corners.
[[nodiscard]] std::size_t set_index_bytes(const SetShape& shape, std::span<const SetPart> parts);
// Makes the index of a set. memory: at least set_index_bytes(). Fails with
// - wrong_pack if a part was baked by another recipe than the first (field: what differs), or if its corners differ
//   from those of an earlier part that it meets;
// - out_of_range if a part lies outside the set or over another part;
// - corrupt if the corners of a part are damaged;
// - memory_too_small.
Status make_set_index(const SetShape& shape, std::span<const SetPart> parts, std::span<std::byte> memory,
                      SetIndex& index, std::uint32_t& at_fault);
// The number of the part whose file has this offset of the whole file. in_part: the offset in that file. Returns the
// number of parts for an offset in the header, in the tail or beyond. O(parts).
[[nodiscard]] std::uint32_t set_part_at(std::span<const SetPart> parts, std::uint64_t offset, std::uint64_t& in_part);

} // namespace fjell
FJELL_API_END
