#include "baker/read/tile_pages.h"

#include <fmt/format.h>

#include "tree/order.h"

namespace fjell::baker {

TilePages::TilePages(const io::PackFile& file) : file_(file) {
    const TerrainBudget one_tile{pages_of(file.pack().header).pages_per_tile()};
    const std::size_t bytes = terrain_bytes(file.pack().header, one_tile);
    memory_ = io::allocate(bytes);
    check(create_terrain(file.pack(), file.corners(), one_tile, {memory_.get(), bytes}, terrain_), 0);
}

void TilePages::check(const Status& status, std::uint32_t tile) const {
    if (!status.ok())
        throw Failure(1, fmt::format("{}: the heights of tile {}: {} ({}); bake the pack again", file_.path(), tile,
                                     message(status.code), status.field));
}

void TilePages::load(std::uint32_t tile) {
    if (whole_ && tile == held_) return;
    whole_ = false;
    for (std::uint32_t page = 0; page < terrain_.pages_per_tile(); ++page) (void)unload_page(terrain_, held_, page);
    held_ = tile;
    for (std::uint32_t page = 0; page < terrain_.pages_per_tile(); ++page) {
        file_.read_chunk({ChunkKind::geometry, tile, page}, raw_);
        check(insert_page(terrain_, tile, page, raw_), tile);
    }
    whole_ = true;
}

} // namespace fjell::baker
