// A pack's geometry, one tile at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "baker/read/source.h"
#include "fjell/io/load.h"
#include "fjell/io/pack_file.h"

namespace fjell::baker {

// A terrain of which one tile's pages are there, or some of them. One thread at a time. Memory: as many pages, 8 bytes
// for every page of the pack, and what of the file is being decoded.
class TilePages {
public:
    explicit TilePages(const io::PackFile& file); // must outlive it; throws Failure
    TilePages(const io::PackFile& file, std::uint32_t most_pages);
    // Pages of other tiles go. Throws Failure 1 for one that is damaged.
    void load(std::uint32_t tile);
    // Only these of the tile, coarse ones first; all others go.
    void load_pages(std::uint32_t tile, std::span<const std::uint32_t> pages);
    [[nodiscard]] const Terrain& terrain() const { return terrain_; }

private:
    void check(const Status& status, std::uint32_t tile) const;

    const io::PackFile& file_;
    io::AlignedMemory memory_;
    std::vector<std::byte> raw_;
    Terrain terrain_;
    std::uint32_t held_ = 0;
    bool whole_ = false;
};

} // namespace fjell::baker
