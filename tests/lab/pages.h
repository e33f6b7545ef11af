// Which pages the selected vertices of a mesh lie in: what a stream would have to have read.
//
// Counted twice. pages: as our packs cut a tile, in pages of one step (docs/notes/glossary.md), or in linear order of
// rows. memory_pages: 4 KB of one array over a whole tile, 16 bytes a sample, as the thesis lays it out (4.2, 5.3.3);
// there planar and hierarchical Z-order lie level by level, the coarsest first. Vertices that are visited and not
// selected are not counted. Misses are those of a cache that drops what was used longest ago, as large for both: its
// pages are looked for in the order of the mesh's triangles, and it is empty at first. Borders belong to the tile in
// the south-east.
#pragma once

#include <cstdint>
#include <list>
#include <unordered_map>
#include <unordered_set>

#include "fjell/mesh.h"
#include "lab/recipe.h"

namespace fjell::lab {

// Of what was used last.
class PageCache {
public:
    explicit PageCache(std::size_t slots) : slots_(slots) {}
    bool misses(std::uint64_t page); // and holds it from now on

private:
    std::size_t slots_;
    std::list<std::uint64_t> used_; // the last one first
    std::unordered_map<std::uint64_t, std::list<std::uint64_t>::iterator> held_;
};

struct PageCount {
    explicit PageCount(double cache_mb);
    PageCache cache, memory_cache;
    std::size_t misses = 0, memory_misses = 0;
    std::size_t frames = 0;
    double pages = 0, memory_pages = 0;                  // different ones in a frame, summed over frames
    std::unordered_set<std::uint64_t> read, memory_read; // of the flight so far
    void add(const MeshView& mesh, std::int32_t columns, const Case& c);
};

// Where a sample stands in such an array. x, y: 0 to side; side: a power of two.
[[nodiscard]] std::uint64_t place_in_tile(PageOrder order, std::uint32_t side, std::uint32_t x, std::uint32_t y);

} // namespace fjell::lab
