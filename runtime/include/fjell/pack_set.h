// A pack set: packs of rectangles of one terrain's tiles, opened as one pack.
//
// What a pack is too large for, or several machines have baked, lies in several files. make_set_index() puts their
// directories together, so that they are one pack, of one file that no disk has: everything else in Fjell knows of no
// set. That file is, one after the other: a header of 512 bytes, the packs' files from first to last, and a tail
// (corners, directory, tiles). Whoever reads for the set looks up in which file an offset lies; io::PackFile does.
// Tiles that no pack has are missing: nothing is drawn there, queries find no ground, and each costs 8 bytes. Such a
// terrain is sparse: its tiles' numbers (tiles_of()) leave the missing ones out, and Terrain::tile_at() and
// tile_place() lead from places to numbers and back.
// Packs of a set share all that their codes count on: tile size, order, spacing, the scales of heights, errors and
// radii, sizes of maps, CRS. All of it is compared, and corners where tiles meet. What they cannot tell is whether they
// were baked of one field: for that their borders must be read, as fjell-bake join and fjell-bake verify do.
// Ownership: the index lies in the host's memory; of the parts nothing is needed afterwards but their files. Thread:
// any. Complexity: O(chunks + places for tiles). zstd may allocate. Failure: a Status; at_fault is the part's number,
// or how many there are when it is no single one's.
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
    const Pack* pack = nullptr;           // of open_index() or open_pack()
    std::span<const std::byte> corners;   // its chunk of corners, as stored
    std::uint32_t tile_x = 0, tile_y = 0; // of its north-western tile, in tiles from the set's
};
// Samples of the whole, at least 2 and at most max_columns a side.
struct SetShape {
    std::uint32_t columns = 0, rows = 0;
};

// What stands before and behind the parts' files. Points into the memory that make_set_index() was given.
struct SetIndex {
    std::span<const std::byte> header;    // for open_index(): the first 512 bytes
    std::span<const std::byte> tail;      // from tail_offset to the end
    std::span<const std::byte> corners;   // in the tail, as stored: for create_terrain()
    std::span<const std::byte> directory; // in the tail, to its end: for open_index()
    std::uint64_t tail_offset = 0;
    std::uint64_t file_bytes = 0; // of all of it
};

// 0 for parts that make_set_index() refuses before it reads their corners.
[[nodiscard]] std::size_t set_index_bytes(const SetShape& shape, std::span<const SetPart> parts);
// Fails with wrong_pack for a part of another recipe than the first (field: what differs), or whose tiles have other
// corners than those of earlier parts that meet them, with out_of_range for one that does not lie in the set's tiles or
// lies over another one, with corrupt for its corners, with memory_too_small.
Status make_set_index(const SetShape& shape, std::span<const SetPart> parts, std::span<std::byte> memory,
                      SetIndex& index, std::uint32_t& at_fault);
// The number of the part whose file an offset of the whole lies in, and the offset in that; how many there are for the
// header, the tail and what lies beyond. O(parts).
[[nodiscard]] std::uint32_t set_part_at(std::span<const SetPart> parts, std::uint64_t offset, std::uint64_t& in_part);

} // namespace fjell
FJELL_API_END
