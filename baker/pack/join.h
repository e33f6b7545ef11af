// Packs that were baked apart made one pack set: they stay as they are and get an index, if they may be one.
#pragma once

#include <cstdint>
#include <string>

#include "baker/pack/write_set.h"
#include "io/set_file.h"

namespace fjell::baker {

// Do the packs of a set agree where they meet? Packs baked apart have the same vertices along a shared border, each
// with a height, an error and a radius of its own; the runtime takes them for one vertex (docs/pack-format.md: all
// pages that hold it have equal bits), so that a difference is a crack, or an error that nobody is told of.
//
// Of the packs' pages only those along the borders are read, O(samples on borders); of each pack its directory, once
// and again for every neighbour in the west and north. Maps are not looked at (verify_maps.h).

struct BorderReport {
    std::uint64_t borders = 0;    // pairs of packs that share a side
    std::uint64_t vertices = 0;   // compared on them
    std::uint64_t differing = 0;  // borders that do
    std::uint64_t bytes_read = 0; // of pages, as stored
    std::string first;            // of the first that does: packs, place, largest difference, remedy, how many more do
    [[nodiscard]] bool ok() const { return differing == 0; }
};

// folder: of the set's files. Packs that no set could have side by side (other scales or tiles) are not compared:
// opening the set says what differs. Throws Failure: 1 for a pack or a page that is missing or damaged, 3 for a disk
// that fails.
[[nodiscard]] BorderReport compare_borders(const io::SetFile& set, const std::string& folder);

struct JoinSummary {
    SetSummary set;
    BorderReport borders;
};

// Writes set.json for all packs (*.fjell) of the folder. Where each lies follows from its origin, so that packs side by
// side must be cut at whole tiles and share a column or a row of samples. Whatever else the folder's set.json said is
// gone; it is replaced whole, or not at all. Throws Failure: 1 for packs that overlap, lie off the first one's tiles,
// differ where they meet, or cannot be of one set (io::SetParts); 3 for the disk.
[[nodiscard]] JoinSummary join_packs(const std::string& folder);

} // namespace fjell::baker
