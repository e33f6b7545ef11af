#include "baker/read/pack_source.h"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include "baker/read/gdal_file.h"
#include "baker/read/tile_pages.h"
#include "baker/read/windows.h"
#include "shared/terrain_data.h"

namespace fjell::baker {

namespace {

class PackReader final : public HeightReader {
public:
    PackReader(std::shared_ptr<const io::PackFile> file, bool holes)
        : file_(std::move(file)), pages_(*file_), terrain_(pages_.terrain()), coords_(data_of(terrain_).pages),
          holes_(holes) {}

    void read(const Window& window, float* to, ReadStatistics& statistics) override {
        statistics.per_unit = 1; // the height steps are the pack's own
        const std::int32_t side = data_of(terrain_).tree.side();
        const auto tile_of = [&](std::int32_t at, std::int32_t tiles) { return std::min(at / side, tiles - 1); };
        const std::int32_t tx0 = tile_of(window.x, data_of(terrain_).tree.tiles_x),
                           tx1 = tile_of(window.x + window.columns - 1, data_of(terrain_).tree.tiles_x),
                           ty0 = tile_of(window.y, data_of(terrain_).tree.tiles_y),
                           ty1 = tile_of(window.y + window.rows - 1, data_of(terrain_).tree.tiles_y);
        if (data_of(terrain_).is_sparse()) std::fill_n(to, window.area(), std::numeric_limits<float>::quiet_NaN());
        for (std::int32_t ty = ty0; ty <= ty1; ++ty)
            for (std::int32_t tx = tx0; tx <= tx1; ++tx) {
                const std::uint32_t tile = terrain_.tile_at({tx, ty});
                if (tile == no_tile) continue;
                pages_.load(tile);
                copy(tile, {tx * side, ty * side}, window, to);
            }
        count(window, to, statistics);
    }

private:
    // Border samples come from every tile that has them, and are the same.
    void copy(std::uint32_t tile, SampleIndex corner, const Window& window, float* to) const {
        for (std::uint32_t page = 0; page < terrain_.pages_per_tile(); ++page) {
            const PageEntry entry = data_of(terrain_).page_table[std::size_t{tile} * terrain_.pages_per_tile() + page];
            const VertexRecord* const from =
                data_of(terrain_).records + std::size_t{entry.slot} * data_of(terrain_).page_capacity;
            Window at = coords_.extents(page);
            at.x += corner.column, at.y += corner.row;
            const Window shared = common(at, window);
            if (shared.area() == 0) continue;
            const SampleIndex offset = corner - SampleIndex{window.x, window.y};
            const HeightScale scale = data_of(terrain_).height_scale;
            const auto put = [&](std::uint32_t i, SampleIndex c) {
                to[static_cast<std::ptrdiff_t>(c.row) * window.columns + c.column] =
                    holes_ && is_void(from[i]) ? std::numeric_limits<float>::quiet_NaN()
                                               : scale.height_m(entry.base + from[i].height);
            };
            if (shared == at)
                coords_.for_each(page, [&](std::uint32_t i, SampleIndex c) { put(i, offset + c); });
            else
                coords_.for_each(page, [&](std::uint32_t i, SampleIndex c) {
                    c = offset + c;
                    if (c.column >= 0 && c.row >= 0 && c.column < window.columns && c.row < window.rows) put(i, c);
                });
        }
    }

    static void count(const Window& window, const float* heights_m, ReadStatistics& statistics) {
        for (std::int32_t y = window.y; y < window.y + window.rows; ++y)
            for (std::int32_t x = window.x; x < window.x + window.columns; ++x, ++heights_m) {
                if (!(*heights_m == *heights_m)) {
                    statistics.voids.add(x, y);
                    continue;
                }
                statistics.least_m = std::min(statistics.least_m, *heights_m);
                statistics.most_m = std::max(statistics.most_m, *heights_m);
            }
    }

    std::shared_ptr<const io::PackFile> file_;
    TilePages pages_;
    const Terrain& terrain_;
    const PageCoords coords_;
    const bool holes_; // are NaN
};

} // namespace

PackSource::PackSource(const std::string& path) : file_(std::make_shared<io::PackFile>(path)) {
    const PackHeader& h = file_->pack().header;
    columns = static_cast<std::int32_t>(h.columns);
    rows = static_cast<std::int32_t>(h.rows);
    std::copy_n(h.spacing_m, 2, spacing_m);
    std::copy_n(h.crs_origin, 2, crs_origin);
    crs_wkt = file_->crs();
    std::copy_n(h.crs_step, 2, crs_step);
}

std::unique_ptr<HeightReader> PackSource::reader() const {
    return std::make_unique<PackReader>(file_, true);
}

std::unique_ptr<HeightReader> PackSource::ground_reader() const {
    return std::make_unique<PackReader>(file_, false);
}

std::vector<Window> PackSource::windows(std::size_t most) const {
    const std::int32_t side = tree_of(file_->pack().header).side();
    return cut_along({0, 0, columns, rows}, {side, side, 0, 0}, most);
}

SourceProperties PackSource::properties(const ReadStatistics& statistics) const {
    const PackHeader& h = file_->pack().header;
    if (!(statistics.least_m <= statistics.most_m)) throw Failure(1, fmt::format("{}: is all holes", file_->path()));
    return {static_cast<double>(h.quantum_m), static_cast<double>(h.base_m), statistics.voids.count > 0};
}

HeightScale PackSource::height_scale() const {
    return {file_->pack().header.base_m, file_->pack().header.quantum_m};
}

std::string PackSource::identity() const {
    return fmt::format("pack {:016x}", file_->pack().header.directory_hash);
}

} // namespace fjell::baker
