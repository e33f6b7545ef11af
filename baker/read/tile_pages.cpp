#include "baker/read/tile_pages.h"

#include <numeric>

#include <fmt/format.h>

#include "shared/order.h"

namespace fjell::baker {

PageCoords::PageCoords(const PageLayout& layout) : layout_(layout) {
    for (std::uint32_t i = 0; i < layout.page_vertices(0); ++i) of_root_.push_back(layout.coord({0, i}));
    if (layout.order == PageOrder::linear || layout.pages_per_tile() == 1) return;
    const int z = layout.page_step_log2(1);
    for (std::uint32_t i = 0; i < layout.page_vertices(1); ++i) {
        const SampleIndex c = layout.coord({1, i}); // the north-western page of its step
        of_step_.push_back({c.column >> z, c.row >> z});
    }
}

TilePages::TilePages(const io::PackFile& file) : TilePages(file, pages_of(file.pack().header).pages_per_tile()) {}

TilePages::TilePages(const io::PackFile& file, std::uint32_t most_pages) : file_(file) {
    const TerrainBudget budget{most_pages};
    const std::size_t bytes = terrain_bytes(file.pack().header, budget);
    memory_ = io::allocate(bytes);
    check(create_terrain(file.pack(), file.corners(), budget, {memory_.get(), bytes}, terrain_), 0);
}

void TilePages::check(const Status& status, std::uint32_t tile) const {
    if (!status.ok())
        throw Failure(1, fmt::format("{}: the heights of tile {}: {} ({}); bake the pack again", file_.path(), tile,
                                     message(status.code), status.field));
}

void TilePages::load(std::uint32_t tile) {
    if (whole_ && tile == held_) return;
    std::vector<std::uint32_t> all(terrain_.pages_per_tile());
    std::iota(all.begin(), all.end(), 0u);
    load_pages(tile, all);
    whole_ = true;
}

void TilePages::load_pages(std::uint32_t tile, std::span<const std::uint32_t> pages) {
    whole_ = false;
    for (std::uint32_t page = 0; page < terrain_.pages_per_tile(); ++page) (void)unload_page(terrain_, held_, page);
    held_ = tile;
    for (const std::uint32_t page : pages) {
        file_.read_chunk({ChunkKind::geometry, tile, page}, raw_);
        check(insert_page(terrain_, tile, page, raw_), tile);
    }
}

} // namespace fjell::baker
