// A pack set written from all chunks of a terrain, without a pack of them: packs of rectangles of its tiles, each with
// the whole's scales, chunks as they are, and an index.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "baker/pack/chunk_spool.h"
#include "baker/store/window.h"
#include "fjell/pack.h"
#include "io/set_file.h"
#include "shared/tree.h"

namespace fjell::baker {

// How many packs across and down, of as many tiles each as whole ones allow. So which tile lies in which pack, and with
// it each pack's bytes, follow from these alone.
struct SetGrid {
    std::uint32_t packs_x = 2, packs_y = 2;
    friend bool operator==(const SetGrid&, const SetGrid&) = default;
};
// Tiles of pack (px, py) of the grid.
[[nodiscard]] Window tiles_of_pack(const SetGrid& grid, const Tree& tree, std::uint32_t px, std::uint32_t py);
struct SetSummary {
    std::uint32_t packs = 0, left_out = 0; // left out: without any ground
    std::uint64_t file_bytes = 0;
};

struct SetInput {
    const PackHeader& header; // of the whole
    const ChunkSource& chunks;
    const std::string& notes;
    // Holes in a window of samples; asked only where the whole has some.
    std::function<std::uint64_t(const Window& samples)> voids;
};

// Throws Failure 2 when there are fewer tiles than packs. name: of what is taken apart, for the message.
void check_grid(const SetGrid& grid, std::uint32_t tiles_x, std::uint32_t tiles_y, const std::string& name);
// The folder of a set, made where it is not there yet. Throws Failure 1.
void make_set_folder(const std::string& folder);
// set.json, or a list like it, replaced whole. Throws Failure 3 for the disk.
void write_set_index(const io::SetFile& set, const std::string& path);
// What a bake or a split into this folder calls its output: its work folder (store.h) then lies inside, on the same
// file system.
[[nodiscard]] std::string set_work_name(const std::string& folder);

// Packs grow in `work`, a folder of the caller's inside `folder`. When all of them are complete the old index goes,
// they are renamed into their places, and the new index is written: so whatever is interrupted, an index speaks of
// complete packs, and an old set stays until then. Then packs of the old set that the new one does not name are
// removed; their names are in set.old until they are, for the next one that writes here. Files that no index has named
// stay. Rectangles without any ground are left out. progress(done, total): tiles. Throws Failure: 1 for chunks that are
// damaged, 3 for the disk.
[[nodiscard]] SetSummary write_set(const SetInput& whole, const SetGrid& grid, const std::string& folder,
                                   const std::string& work,
                                   const std::function<void(std::uint64_t, std::uint64_t)>& progress);

// A pack taken apart into a pack set: its chunks as they are, in packs of rectangles of its tiles.

// Writes the folder's packs, and set.json last (write_set.h). The set then is the pack, chunk for chunk; rectangles
// without any ground are left out of it. progress(done, total): tiles. Throws Failure as PackFile and AtomicFile do, 2
// for more packs than tiles, 1 for a set that is given.
[[nodiscard]] SetSummary split_pack(const std::string& pack, const std::string& folder, const SetGrid& grid,
                                    const std::function<void(std::uint64_t, std::uint64_t)>& progress = {});

} // namespace fjell::baker
