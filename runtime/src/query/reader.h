// Vertices of a tile as queries read them: where they lie in pages, and what they say, from any thread.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

#include "pack/publish.h"
#include "shared/compiler.h"
#include "shared/terrain_data.h"

namespace fjell::query {

// A point over the ground, in cells: columns and rows.
struct Point {
    double x = 0, y = 0;
};

struct Sample {
    bool loaded = false, hole = false;
    std::int32_t error = 0; // code; of corners 0
    std::int32_t steps = 0;
};

// PageLayout::place() of a vertex that is not a tile's corner, with shifts instead of divisions.
[[nodiscard]] inline PagePlace place_of(const PageLayout& pages, std::uint32_t x, std::uint32_t y) {
    if (pages.order == PageOrder::linear) return pages.place_as<PageOrder::linear>(x, y);
    const auto z = static_cast<std::uint32_t>(std::countr_zero(x | y));
    const StepLayout step = pages.step_layout(static_cast<int>(z));
    const std::uint32_t i = x >> (z + 1), j = y >> (z + 1), last = (1u << step.pages_log2) - 1;
    const int page_log2 = std::countr_zero(step.page_side);
    const std::uint32_t px = std::min(i >> page_log2, last), py = std::min(j >> page_log2, last);
    const std::uint32_t in_x = i - (px << page_log2), in_y = j - (py << page_log2);
    const bool odd_x = (x >> z & 1) != 0, odd_y = (y >> z & 1) != 0;
    const VertexKind kind = odd_x && odd_y ? VertexKind::centre : odd_x ? VertexKind::side_x : VertexKind::side_y;
    if (pages.order == PageOrder::hierarchical_z)
        return {step.first_page + interleave(px, py),
                step.offset + page_index<PageOrder::hierarchical_z>(step.page_side, kind, in_x, in_y)};
    return {step.first_page + (py << step.pages_log2) + px,
            step.offset + page_index<PageOrder::planar>(step.page_side, kind, in_x, in_y)};
}

// Reads vertices of one tile, from any thread. Keeps the last page, which most often holds the next vertex too.
class Reader {
public:
    Reader(const TerrainData& terrain, std::int32_t tile_x, std::int32_t tile_y)
        : t_(terrain), origin_{tile_x * terrain.tree.side(), tile_y * terrain.tree.side()},
          first_page_(first_page(terrain, terrain.tile_at(tile_x, tile_y))) {}

    [[nodiscard]] SampleIndex origin() const { return origin_; }
    // v: a vertex of the tile, of the grid.
    [[nodiscard]] Sample read(SampleIndex v) {
        Sample sample;
        if (t_.tree.is_corner(v)) {
            const std::int32_t l = t_.tree.tile_log2;
            const std::uint32_t corner = t_.corner_at(v.column >> l, v.row >> l);
            sample.loaded = true;
            sample.hole = first_page_ == no_pages; // without a tile there is no ground, whatever its neighbours have
            if (sample.hole) return sample;
            const std::uint32_t stored = load_word_relaxed(t_.corners + corner);
            sample.hole = (stored & corner_void_bit) != 0;
            sample.steps = corner_steps(stored);
            return sample;
        }
        const PagePlace at = place_of(t_.pages, static_cast<std::uint32_t>(v.column - origin_.column),
                                      static_cast<std::uint32_t>(v.row - origin_.row));
        VertexRecord record;
        if (!read(at, record)) return sample;
        sample.loaded = true;
        sample.hole = is_void(record);
        sample.error = record.error;
        sample.steps = found_.base + record.height;
        return sample;
    }
    // The record at a place of the tile; then base() is what its height counts from. False: its page is not loaded.
    [[nodiscard]] bool read(PagePlace at, VertexRecord& record) {
        return (at.page == page_ && read_record(t_, found_, at.index, record)) || find(at, record);
    }
    [[nodiscard]] std::int32_t base() const { return found_.base; }
    // It will be read soon.
    void prefetch(PagePlace at) const {
        if (first_page_ == no_pages) return;
        if (const VertexRecord* const place = find_place(t_, first_page_ + at.page, at.index)) FJELL_PREFETCH(place);
    }

private:
    // A page that went while it was read may be back at once; one that keeps coming and going counts as missing.
    FJELL_NOINLINE bool find(PagePlace at, VertexRecord& record) {
        constexpr int attempts = 3;
        if (first_page_ == no_pages) return false;
        for (int attempt = 0; attempt < attempts; ++attempt) {
            page_ = at.page;
            if (find_page(t_, first_page_ + at.page, found_) && read_record(t_, found_, at.index, record)) return true;
        }
        page_ = no_index;
        return false;
    }

    // Of a tile that a sparse terrain does not have: no page of it is ever loaded.
    static constexpr std::size_t no_pages = static_cast<std::size_t>(-1);
    [[nodiscard]] static std::size_t first_page(const TerrainData& t, std::uint32_t tile) {
        return tile == no_index ? no_pages : std::size_t{tile} * t.pages_per_tile;
    }

    const TerrainData& t_;
    SampleIndex origin_;
    std::size_t first_page_;
    std::uint32_t page_ = no_index; // in the tile
    PublishedPage found_;
};

} // namespace fjell::query
