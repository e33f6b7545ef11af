// Pages and vertices one by one: for hosts that load pages themselves, without a stream, and for tools that look at
// what is there.
//
// Positions of vertices are samples of the terrain; where it says tile-local, samples from the tile's north-western
// corner, 0 to 2^tile_log2. Thread: the one that loads and unloads pages. Complexity: O(1); a page's place O(levels).
// Allocates nothing. Failure: of a refused handle and of what is outside the terrain, zeros and defaults.
#pragma once

#include <cstdint>

#include "fjell/export.h"
#include "fjell/pack.h"
#include "fjell/sample_index.h"
#include "fjell/terrain.h"

FJELL_API_BEGIN
namespace fjell {

// --- which page holds what ---

// Pages of every tile. Page 0 holds the coarse steps and is needed by all others.
[[nodiscard]] std::uint32_t pages_per_tile(const PackHeader& header);
// log2 of the step, in samples, that the page is a part of; -1: of several, as page 0 is, and all pages in linear
// order.
[[nodiscard]] int page_step_log2(const PackHeader& header, std::uint32_t page);
// The page of that step over a tile-local place; page 0 where the step has none of its own, and in linear order.
[[nodiscard]] std::uint32_t page_at(const PackHeader& header, std::uint32_t step_log2, std::uint32_t x,
                                    std::uint32_t y);
// The page that a tile-local vertex is read from.
[[nodiscard]] std::uint32_t page_of(const PackHeader& header, std::uint32_t x, std::uint32_t y);

// --- what is loaded ---

[[nodiscard]] bool page_loaded(const Terrain& terrain, std::uint32_t tile, std::uint32_t page);
// Pages loaded or unloaded so far: whoever keeps something of them compares.
[[nodiscard]] std::uint64_t page_changes(const Terrain& terrain);
// What Terrain::missing_px() says from now on: for hosts that decide without a stream which pages to load.
Status set_missing_px(const Terrain& terrain, double missing_px);

// --- vertices ---

// A vertex with its numbers decoded. The corners of tiles are always loaded, and have neither error nor radius.
struct TerrainVertex {
    bool loaded = false; // false: its page is missing, and nothing else is known
    bool hole = false;   // the height is a smooth continuation of the ground around it
    // False: it is of no tile that there is. Then it is a hole on the terrain's lowest height.
    bool in_tile = true;
    float height_m = 0, error_m = 0, radius_m = 0;
};
// Any sample, also beyond the terrain's rim to the end of the last tiles. Slow and convenient.
[[nodiscard]] TerrainVertex terrain_vertex(const Terrain& terrain, SampleIndex sample);
// Between the four samples around a place, bilinear: smooth, and not the surface that is drawn (fjell/query.h). Places
// outside count as the nearest of the rim. Needs the pages of those samples.
[[nodiscard]] double terrain_height_m(const Terrain& terrain, double x_m, double z_m);

} // namespace fjell
FJELL_API_END
