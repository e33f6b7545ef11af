#include "fjell/io/heights.h"

#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

#include "fjell/io/failure.h"
#include "fjell/io/load.h"
#include "fjell/pages.h"
#include "io/file.h"

namespace fjell::io {

namespace {

// Brings a page's bytes, decompressed.
using ReadPage = std::function<void(ChunkId id, std::vector<std::byte>& raw)>;

// Samples along an extent, the last one at the rim or beyond.
std::int32_t samples_along(std::uint32_t extent, std::uint32_t step_log2) {
    return static_cast<std::int32_t>((extent - 1 + (1u << step_log2) - 1) >> step_log2) + 1;
}

FullHeights make_grid(const PackHeader& h, std::uint64_t max_samples, const std::string& path) {
    FullHeights grid;
    for (grid.step_log2 = 0;; ++grid.step_log2) {
        grid.columns = samples_along(h.columns, grid.step_log2);
        grid.rows = samples_along(h.rows, grid.step_log2);
        const std::uint64_t samples = static_cast<std::uint64_t>(grid.columns) * static_cast<std::uint64_t>(grid.rows);
        if (samples <= max_samples) {
            grid.heights_m.resize(samples);
            return grid;
        }
        if (grid.step_log2 == h.tile_log2)
            throw Failure(1, path + ": the corners of its tiles alone are " + std::to_string(samples) +
                                 " samples and there is room for " + std::to_string(max_samples) +
                                 "; give room for more");
    }
}

// One tile at a time, its pages from coarse to fine, without those of finer steps than the grid has.
class TileReader {
public:
    TileReader(Terrain& terrain, const std::string& path, const ReadPage& read)
        : terrain_(terrain), path_(path), read_(read) {}

    void load(std::uint32_t tile, std::uint32_t step_log2) {
        for (std::uint32_t page = 0; page < terrain_.pages_per_tile(); ++page) {
            const int finest = page_step_log2(terrain_.header(), page);
            if (finest >= 0 && finest < static_cast<int>(step_log2)) continue;
            read_({ChunkKind::geometry, tile, page}, raw_);
            if (!insert_page(terrain_, tile, page, raw_).ok())
                throw Failure(1, path_ + ": page " + std::to_string(page) + " of tile " + std::to_string(tile) +
                                     " is damaged; fjell-bake verify says more");
        }
    }
    void unload(std::uint32_t tile) {
        for (std::uint32_t page = 0; page < terrain_.pages_per_tile(); ++page) (void)unload_page(terrain_, tile, page);
    }
    // The samples that are this tile's: those on its south and east border are its neighbours', if it has any.
    void copy(std::uint32_t tile, FullHeights& grid) const {
        const std::int32_t a_side = std::int32_t{1} << (terrain_.header().tile_log2 - grid.step_log2);
        const SampleIndex at = terrain_.tile_place(tile);
        const auto there = [&](std::int32_t dx, std::int32_t dy) {
            return terrain_.tile_at({at.column + dx, at.row + dy}) != no_tile;
        };
        const auto end = [&](std::int32_t place, bool next, std::int32_t all) {
            return std::min((place + 1) * a_side + (next ? 0 : 1), all);
        };
        const std::int32_t end_x = end(at.column, there(1, 0), grid.columns),
                           end_y = end(at.row, there(0, 1), grid.rows);
        for (std::int32_t y = at.row * a_side; y < end_y; ++y)
            for (std::int32_t x = at.column * a_side; x < end_x; ++x) {
                const TerrainVertex v = terrain_vertex(terrain_, {x << grid.step_log2, y << grid.step_log2});
                grid.heights_m[static_cast<std::size_t>(y) * static_cast<std::size_t>(grid.columns) +
                               static_cast<std::size_t>(x)] =
                    v.hole ? std::numeric_limits<float>::quiet_NaN() : v.height_m;
            }
    }

private:
    Terrain& terrain_;
    const std::string& path_;
    const ReadPage& read_;
    std::vector<std::byte> raw_;
};

std::optional<FullHeights> read(const Pack& pack, std::span<const std::byte> corners, const std::string& path,
                                std::uint64_t max_samples, const GoOn& go_on, const ReadPage& read_page) {
    FullHeights grid = make_grid(pack.header, max_samples, path);
    const TerrainBudget slots{pages_per_tile(pack.header)};
    const std::size_t bytes = terrain_bytes(pack.header, slots);
    const AlignedMemory memory = allocate(bytes);
    Terrain terrain;
    require(create_terrain(pack, corners, slots, {memory.get(), bytes}, terrain), path);
    TileReader reader(terrain, path, read_page);
    for (std::uint32_t tile = 0; tile < terrain.tile_count(); ++tile) {
        reader.load(tile, grid.step_log2);
        reader.copy(tile, grid);
        reader.unload(tile);
        if (go_on && !go_on((tile + 1.0) / terrain.tile_count())) return std::nullopt;
    }
    return grid;
}

} // namespace

std::optional<FullHeights> read_heights(const PackFile& file, std::uint64_t max_samples, const GoOn& go_on) {
    return read(file.pack(), file.corners(), file.path(), max_samples, go_on,
                [&](ChunkId id, std::vector<std::byte>& raw) { file.read_chunk(id, raw); });
}

std::optional<FullHeights> read_heights(const Pack& pack, const std::string& path, std::uint64_t max_samples,
                                        const GoOn& go_on) {
    const ChunkEntry corners = pack.entry(chunk_index(pack.header, {ChunkKind::corners, 0, 0}));
    return read(pack, pack.bytes.subspan(corners.offset, corners.stored_bytes), path, max_samples, go_on,
                [&](ChunkId id, std::vector<std::byte>& raw) {
                    raw.resize(pack.entry(chunk_index(pack.header, id)).raw_bytes);
                    if (!read_chunk(pack, id, raw).ok()) raw.clear();
                });
}

} // namespace fjell::io
