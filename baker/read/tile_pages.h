// A pack's geometry, one tile at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "baker/read/source.h"
#include "baker/store/window.h"
#include "fjell/io/load.h"
#include "fjell/io/pack_file.h"
#include "shared/order.h"

namespace fjell::baker {

// Where the vertices of a tile's pages lie, by tables: PageLayout::coord() divides and branches for each of them.
class PageCoords {
public:
    explicit PageCoords(const PageLayout& layout);
    // The tile-local samples that a page's vertices lie between, borders included.
    [[nodiscard]] Window extents(std::uint32_t page) const {
        const int z = layout_.page_step_log2(page);
        const auto side = static_cast<std::int32_t>(layout_.side());
        if (z < 0) return {0, 0, side + 1, side + 1};
        const SampleIndex at = layout_.page_position(page);
        const int shift = z + page_squares_log2 + 1;
        return {at.column << shift, at.row << shift, (1 << shift) + 1, (1 << shift) + 1};
    }
    // visit(number in the page, tile-local coordinates)
    template <typename Visit>
    void for_each(std::uint32_t page, const Visit& visit) const {
        const std::uint32_t count = layout_.page_vertices(page);
        const int z = layout_.page_step_log2(page);
        if (z < 0 && page != 0) { // linear order
            for (std::uint32_t i = 0; i < count; ++i) visit(i, layout_.coord({page, i}));
            return;
        }
        const SampleIndex at = page == 0 ? SampleIndex{} : layout_.page_position(page);
        const std::int32_t x = at.column << (page_squares_log2 + 1), y = at.row << (page_squares_log2 + 1);
        const SampleIndex* const table = page == 0 ? of_root_.data() : of_step_.data();
        const int shift = page == 0 ? 0 : z;
        for (std::uint32_t i = 0; i < count; ++i)
            visit(i, SampleIndex{(x + table[i].column) << shift, (y + table[i].row) << shift});
    }

private:
    PageLayout layout_;
    std::vector<SampleIndex> of_root_, of_step_; // the latter from a page's first square on, in its own steps
};

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
