// Pages and vertices one by one: for hosts that load pages themselves, without a stream, and for tools that inspect a
// terrain.
//
// A vertex is named by its sample in the terrain. A tile-local place counts samples from the tile's north-western
// corner, 0 to 2^tile_log2. Thread: the one that loads and unloads pages. Complexity: O(1); finding the place of a page
// is O(levels). Allocates nothing. Failure: a refused handle, and a place outside the terrain, give zeros and defaults.
#pragma once

#include <cstdint>

#include "fjell/export.h"
#include "fjell/pack.h"
#include "fjell/sample_index.h"
#include "fjell/terrain.h"

FJELL_API_BEGIN
namespace fjell {

// --- which page holds what ---

// Pages of each tile. Page 0 has the coarse steps, and all other pages need it.
[[nodiscard]] std::uint32_t pages_per_tile(const PackHeader& header);
// log2 of the step in samples that the page is a part of. -1 if it has several steps, as page 0 and all pages in linear
// order have.
[[nodiscard]] int page_step_log2(const PackHeader& header, std::uint32_t page);
// The page of a step that covers a tile-local place. Page 0 if the step has no pages of its own, and in linear order.
[[nodiscard]] std::uint32_t page_at(const PackHeader& header, std::uint32_t step_log2, std::uint32_t x,
                                    std::uint32_t y);
// The page that a tile-local vertex is read from.
[[nodiscard]] std::uint32_t page_of(const PackHeader& header, std::uint32_t x, std::uint32_t y);

// --- what is loaded ---

[[nodiscard]] bool page_loaded(const Terrain& terrain, std::uint32_t tile, std::uint32_t page);
// How many pages were loaded or unloaded so far. Compare it to find out whether something that you derived from pages
// is out of date.
[[nodiscard]] std::uint64_t page_changes(const Terrain& terrain);
// Sets what Terrain::missing_px() returns. For hosts that load pages without a stream.
Status set_missing_px(const Terrain& terrain, double missing_px);

// --- vertices ---

// A vertex with its numbers decoded. The corners of tiles are always loaded, and have neither error nor radius.
struct TerrainVertex {
    bool loaded = false; // false: its page is missing, and nothing else is known
    // The sample has no height; height_m continues the ground around it smoothly.
    bool hole = false;
    // False: no tile of the terrain has it. It is then a hole at the terrain's lowest height.
    bool in_tile = true;
    float height_m = 0, error_m = 0, radius_m = 0;
};
// Any sample, also beyond the terrain's rim up to the end of the last tiles. Slow and convenient.
[[nodiscard]] TerrainVertex terrain_vertex(const Terrain& terrain, SampleIndex sample);
// The bilinear height between the four samples around a place. It is smooth, and is not the surface that is drawn
// (fjell/query.h has that). A place outside counts as the nearest place of the rim. Needs the pages of those samples.
[[nodiscard]] double terrain_height_m(const Terrain& terrain, double x_m, double z_m);

} // namespace fjell
FJELL_API_END
