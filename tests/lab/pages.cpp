#include "lab/pages.h"

#include <algorithm>
#include <bit>

#include "fjell/pack.h"

namespace fjell::lab {

namespace {

constexpr std::uint64_t page_samples = 3136, samples_in_4_kb = 4096 / 16, page_cells = 64, root_cells = 32;

// The bits of both numbers in turn, x first.
std::uint64_t interleave(std::uint32_t x, std::uint32_t y) {
    std::uint64_t both = 0;
    for (unsigned bit = 0; bit < 16; ++bit)
        both |= static_cast<std::uint64_t>(x >> bit & 1) << (2 * bit) | static_cast<std::uint64_t>(y >> bit & 1)
                                                                            << (2 * bit + 1);
    return both;
}

std::uint32_t step_of(std::uint32_t side, std::uint32_t x, std::uint32_t y) {
    return 1u << std::countr_zero(x | y | side);
}

std::uint64_t page_in_tile(PageOrder order, std::uint32_t side, std::uint32_t x, std::uint32_t y) {
    if (order == PageOrder::linear) return place_in_tile(order, side, x, y) / page_samples;
    const std::uint64_t step = step_of(side, x, y);
    if (side / step <= root_cells) return 0;
    return step << 32 | (y / step / page_cells) << 16 | x / step / page_cells;
}

} // namespace

std::uint64_t place_in_tile(PageOrder order, std::uint32_t side, std::uint32_t x, std::uint32_t y) {
    if (order == PageOrder::linear) return std::uint64_t{y} * (side + 1) + x;
    if (x >= side || y >= side) return std::uint64_t{side + y} * (side + 1) + x; // behind the others: the terrain's rim
    const std::uint32_t step = step_of(side, x, y);
    if (x == 0 && y == 0) return 0;
    const std::uint32_t i = x / step, j = y / step;
    const std::uint64_t n = side / step / 2, before = n * n; // coarser samples: as many as squares of this step
    if (order == PageOrder::hierarchical_z) {
        const std::uint64_t z = interleave(i, j);
        return before + z - z / 4 - 1; // every fourth is a coarser one
    }
    const std::uint64_t plane = (i & 1) != 0 ? (j & 1) != 0 ? 0 : 1 : 2;
    return before + plane * n * n + (j / 2) * n + i / 2;
}

bool PageCache::misses(std::uint64_t page) {
    const auto at = held_.find(page);
    if (at != held_.end()) {
        used_.splice(used_.begin(), used_, at->second);
        return false;
    }
    if (held_.size() >= slots_) {
        held_.erase(used_.back());
        used_.pop_back();
    }
    used_.push_front(page);
    held_[page] = used_.begin();
    return true;
}

PageCount::PageCount(double cache_mb)
    : cache(std::max<std::size_t>(1, static_cast<std::size_t>(cache_mb * 1e6 / (16 * page_samples)))),
      memory_cache(std::max<std::size_t>(1, static_cast<std::size_t>(cache_mb * 1e6 / 4096))) {}

void PageCount::add(const MeshView& mesh, std::int32_t columns, const Case& c) {
    const auto side = static_cast<std::uint32_t>(c.tile_cells);
    const std::uint32_t tiles_x = (static_cast<std::uint32_t>(columns) + side - 2) / side;
    std::unordered_set<std::uint64_t> pages_now, memory_now;
    std::vector<bool> seen(mesh.vertices.size());
    for (const TileRange& range : mesh.tiles)
        for (const std::uint32_t index : mesh.indices.subspan(range.first_index, range.index_count)) {
            if (seen[index]) continue;
            seen[index] = true;
            const auto column = static_cast<std::uint32_t>(mesh.vertices[index].column),
                       row = static_cast<std::uint32_t>(mesh.vertices[index].row);
            const std::uint64_t tile = std::uint64_t{row / side} * (tiles_x + 1) + column / side;
            const std::uint32_t x = column % side, y = row % side;
            const std::uint64_t page = tile << 44 | page_in_tile(c.order, side, x, y),
                                memory = tile << 44 | place_in_tile(c.order, side, x, y) / samples_in_4_kb;
            misses += cache.misses(page);
            memory_misses += memory_cache.misses(memory);
            pages_now.insert(page);
            memory_now.insert(memory);
        }
    ++frames;
    pages += static_cast<double>(pages_now.size());
    memory_pages += static_cast<double>(memory_now.size());
    read.merge(pages_now);
    memory_read.merge(memory_now);
}

} // namespace fjell::lab
